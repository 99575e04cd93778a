//! The particle system of Morillo et al. 2015 (doi:10.2312/vriphys.20151339) as `inputs/paper/` has it: Table 1 at step 0, and
//! both readings of the force with both integrators.

#[path = "common/cli.rs"]
mod cli;
mod common;

use std::fs;
use std::sync::atomic::AtomicBool;

use common::{arc, variants};
use octant::dynamics::Phase;
use octant::engine::cpu::{CpuBackend, CpuOptions};
use octant::engine::{Backend, Needs, Precision, Stop};
use octant::paper::{Published, TABLE_1, expected_neighbors};
use octant::session::{FirstRun, Settings, first_run};

fn script(size: usize) -> String {
    let path = cli::root().join(format!("inputs/paper/{size}.in"));
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn start(size: usize, variables: &[(&str, &str)]) -> FirstRun {
    let variables = variables.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    first_run("paper.in", &script(size), &Settings { variables, ..Settings::default() }).unwrap()
}

#[test]
fn boxes_are_chosen_so_that_table_1_is_expected() {
    for Published { particles, neighbors, edge } in TABLE_1 {
        let count = expected_neighbors(particles, edge);
        assert!((count - f64::from(neighbors)).abs() < 2e-3 * f64::from(neighbors), "{particles}: {count}");
    }
}

#[test]
fn table_1_holds_at_step_0() {
    for Published { particles: size, neighbors, edge } in TABLE_1 {
        let FirstRun { program, state, simulation_box, step } = start(size, &[]);
        assert_eq!(state.len(), size);
        let radius = program.pair.largest_cutoff() + program.policy.skin;
        assert_eq!((radius, simulation_box.lengths().x), (1.0, edge));
        let program = arc(program);
        let counted = |mut backend: Box<dyn Backend>, name: &str| {
            backend.load(program.clone(), &state, &simulation_box, step).unwrap();
            backend.set_up(Needs::default()).unwrap_or_else(|_| panic!("{name}: {size}"));
            backend.neighbor_counts().unwrap()
        };
        // These are LAMMPS's, as the comparison with it shows.
        let options = CpuOptions { threads: 2, precision: Precision::Double, isa: None };
        let known = counted(Box::new(CpuBackend::new(options).unwrap()), "cpu");
        for variant in variants() {
            // The particle itself is not counted.
            let counts = counted(variant.backend(2), &variant.name);
            // Single precision rounds positions.
            assert!(counts == known || variant.precision == Precision::Single, "{}: {size}", variant.name);
            let mean = counts.iter().map(|n| f64::from(*n)).sum::<f64>() / size as f64;
            // The number of pairs scatters as that of rare events does: by its square root, about.
            let count = expected_neighbors(size, edge);
            let scatter = (2.0 * count / size as f64).sqrt();
            assert!((mean - count).abs() < 4.0 * scatter, "{}: {size}: {mean}, expected {count}", variant.name);
            assert_eq!(mean.round() as u32, neighbors, "{}: {size}: {mean}", variant.name);
        }
    }
}

#[test]
fn scripts_differ_in_size_and_edge_alone() {
    let [first, ..] = TABLE_1;
    for other in TABLE_1 {
        let of = |Published { particles: size, neighbors, edge }| {
            [
                format!("section 6): {size} particles"),
                format!("Table 1: {neighbors})"),
                format!("variable n          index {size}\n"),
                format!("variable edge       index {edge}\n"),
            ]
        };
        let mut text = script(first.particles);
        for (from, to) in of(first).iter().zip(of(other)) {
            assert_eq!(text.matches(from).count(), 1, "{from}");
            text = text.replace(from, &to);
        }
        assert_eq!(text, script(other.particles), "{}", other.particles);
    }
}

#[test]
fn both_forces_run_with_both_integrators() {
    for variant in variants() {
        for (force, style) in [("inverse", "inverse"), ("spring", "harmonic/cut")] {
            for integrator in ["nve/euler2", "nve"] {
                let variables = [("force", force), ("integrator", integrator)];
                let FirstRun { program, state, simulation_box, step } = start(2000, &variables);
                assert_eq!((program.pair.style, program.masses[0], program.timestep), (style, 3e-4, 2e-4));
                // k, at a distance of half the cutoff: F = k / r, and F = k (R - r).
                let pull = program.pair.evaluate(0, 0, 0.5).unwrap().force_over_r * 0.5;
                assert_eq!(pull, if force == "inverse" { 7200.0 } else { 1800.0 });
                let moving: Vec<_> = program.fixes.iter().filter(|fix| fix.acts(Phase::Initial)).collect();
                assert!(moving.len() == 1 && moving[0].style == integrator);
                let mut backend = variant.backend(2);
                backend.load(arc(program), &state, &simulation_box, step).unwrap();
                let ran = backend.set_up(Needs::default());
                let ran = ran.and_then(|()| backend.advance(20, Needs::default(), &AtomicBool::new(false)).map(|_| ()));
                if let Err(Stop::Fault(fault)) = ran {
                    panic!("{} {force} {integrator}: {fault}", variant.name);
                }
                // A spring is not stiff enough to throw a particle out at once.
                assert!(force == "inverse" || backend.lost() == 0, "{} {integrator}", variant.name);
                assert_eq!(backend.statistics().builds, 20);
            }
        }
    }
}

#[test]
fn a_force_or_integrator_that_is_none_is_refused() {
    let refused = |name: &str| {
        let settings = Settings { variables: vec![(name.into(), "sprung".into())], ..Settings::default() };
        match first_run("paper.in", &script(1000), &settings) {
            Ok(_) => panic!("there is no {name} of that name"),
            Err(error) => error.to_string(),
        }
    };
    assert!(refused("force").contains("pair style 'sprung' is not part of octant"), "{}", refused("force"));
    assert!(refused("integrator").contains("fix style 'sprung' is not part of octant"), "{}", refused("integrator"));
}
