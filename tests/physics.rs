//! What must hold whatever the backend, the search, the number of threads: forces are derivatives of energies, momentum
//! and energy are conserved, results are the same bits.

mod common;

use std::sync::atomic::AtomicBool;

use approx::assert_relative_eq;
use common::{Noise, Variant, all_pairs, arc, free_or_periodic, melt, program, program_of_style, variants};
use octant::engine::{Backend, FaultKind, Needs, Precision, Program, Sums};
use octant::neighbor::Search;
use octant::pair::{PairStyle, StyleVisitor, styles, with_style};
use octant::real::{Dual, Real};
use octant::system::{LostAtoms, Side, SimulationBox, State, Vec3};

const ALL: Needs = Needs { energy: true, virial: true, pressure: true, positions: true, forces: true };

fn started(
    variant: &Variant,
    threads: usize,
    program: Program,
    state: &State,
    space: &SimulationBox,
) -> Box<dyn Backend> {
    let mut backend = variant.backend(threads);
    backend.load(arc(program), state, space, 0).unwrap();
    if let Err(fault) = backend.set_up(ALL) {
        panic!("{}: {fault}", variant.name);
    }
    backend
}

fn advanced(backend: &mut dyn Backend, steps: u64) -> (State, Sums) {
    if let Err(fault) = backend.advance(steps, ALL, &AtomicBool::new(false)) {
        panic!("{fault}");
    }
    let mut state = State::default();
    backend.fetch(&mut state).unwrap();
    (state, backend.sums().unwrap())
}

/// A liquid of two types with cutoffs of their own.
fn mixture() -> (State, SimulationBox, Vec<f64>) {
    let (mut state, space) = melt(5);
    for (k, kind) in state.kind.iter_mut().enumerate() {
        *kind = 1 + u32::from(k % 3 == 0);
    }
    (state, space, vec![2.5, 1.9])
}

#[test]
fn every_style_has_the_force_of_its_energy() {
    struct Check;
    impl StyleVisitor for Check {
        type Output = ();
        fn visit<S: PairStyle>(self) {
            let coefficients: Vec<f64> = (0..S::COEFFICIENTS.len()).map(|k| 1.3 - 0.2 * k as f64).collect();
            let params = S::params(&coefficients, &vec![1.1; S::SETTINGS.len()], 4.0);
            for k in 1..60 {
                let r = 0.7 + 0.05 * k as f64;
                let x = Dual::variable(r);
                let dual = S::eval::<Dual>(x * x, &S::map(&params, Dual::constant));
                let plain = S::eval::<f64>(r * r, &params);
                assert_eq!(plain.energy, dual.energy.value, "{}", S::NAME);
                let scale = plain.force_over_r.abs().max(0.1);
                assert_relative_eq!(plain.force_over_r, -dual.energy.derivative / r, epsilon = 4e-14 * scale);
                let single = S::eval::<f32>((r * r) as f32, &S::map(&params, f32::constant));
                assert_relative_eq!(single.energy as f64, plain.energy, epsilon = 2e-6 * scale * r * r);
                let less = f64::less(plain.energy, 0.0);
                assert_eq!(f64::select(less, -1.0, 1.0), if plain.energy < 0.0 { -1.0 } else { 1.0 });
            }
        }
    }
    for style in styles() {
        with_style(style.name, Check).unwrap();
    }
}

#[test]
fn forces_energy_and_virial_are_those_of_all_pairs() {
    let (state, space, cutoffs) = mixture();
    for variant in variants() {
        let (name, tolerance) = (&variant.name, &variant.tolerance);
        for search in Search::ALL {
            let program = program(&cutoffs, 0.3, search);
            let mut backend = started(&variant, 2, program.clone(), &state, &space);
            let mut now = State::default();
            backend.fetch(&mut now).unwrap();
            let (f, energy, virial) = all_pairs(&program.pair, &now, &space);
            let rms = (f.iter().map(Vec3::norm_squared).sum::<f64>() / f.len() as f64).sqrt();
            for (k, expected) in f.iter().enumerate() {
                let error = (now.f[k] - expected).norm() / rms;
                assert!(error < tolerance.force, "{name} {}: atom {} off by {error}", search.name(), now.id[k]);
            }
            let sums = backend.sums().unwrap();
            assert_relative_eq!(sums.potential, energy, max_relative = tolerance.energy);
            let trace: f64 = sums.virial[..3].iter().sum();
            assert_relative_eq!(trace, virial, max_relative = tolerance.energy);
        }
    }
}

/// Checks forces, energy and virial of all variants against all pairs.
fn compare_with_all_pairs(what: &str, program: &Program, state: &State, space: &SimulationBox) {
    for variant in variants() {
        let (name, tolerance) = (&variant.name, &variant.tolerance);
        let backend = &mut *started(&variant, 2, program.clone(), state, space);
        let mut now = State::default();
        backend.fetch(&mut now).unwrap();
        let (f, energy, virial) = all_pairs(&program.pair, &now, space);
        let rms = (f.iter().map(Vec3::norm_squared).sum::<f64>() / f.len() as f64).sqrt();
        for (k, expected) in f.iter().enumerate() {
            let error = (now.f[k] - expected).norm() / rms;
            assert!(error < tolerance.force, "{what}, {name}: atom {} off by {error}", now.id[k]);
        }
        let sums = backend.sums().unwrap();
        assert_relative_eq!(sums.potential, energy, max_relative = tolerance.energy);
        assert_relative_eq!(sums.virial[..3].iter().sum::<f64>(), virial, max_relative = 10.0 * tolerance.energy);
    }
}

#[test]
fn every_style_computes_what_all_pairs_give() {
    let (state, space, _) = mixture();
    for style in styles() {
        for shift in [false, true] {
            let program = program_of_style(&style, shift, 1.0, 1.0);
            compare_with_all_pairs(&format!("{} shift {shift}", style.name), &program, &state, &space);
        }
    }
}

#[test]
fn units_of_any_size_give_the_same_forces() {
    let (state, space, _) = mixture();
    // Argon in SI; something huge.
    for (energy, length) in [(1.65e-21, 3.4e-10), (1e12, 1e5)] {
        let mut scaled = state.clone();
        scaled.x.iter_mut().for_each(|x| *x *= length);
        scaled.v.iter_mut().for_each(|v| *v = Vec3::zeros());
        let space = SimulationBox::new(space.lo * length, space.hi * length, space.sides);
        for style in styles() {
            let program = program_of_style(&style, true, energy, length);
            compare_with_all_pairs(&format!("{} at {length}", style.name), &program, &scaled, &space);
        }
    }
}

#[test]
fn a_list_that_is_never_built_anew_holds_however_far_particles_fly() {
    // Two pairs fly apart; their partners stay in reach. Fixed-point coordinates go around many times meanwhile.
    let space = free_or_periodic([0.0; 3], [400.0; 3], [false; 3]);
    let mut state = State::default();
    for (id, x, v) in [(1, 10.0, 0.0), (2, 11.2, 0.0), (3, 13.0, 90.0), (4, 14.15, 90.0)] {
        state.push(id, 1, Vec3::new(x, 20.0, 20.0));
        state.v[id as usize - 1] = Vec3::new(v, v / 2.0, v / 3.0);
    }
    for variant in variants() {
        let mut program = program(&[2.5], 0.3, Search::Trimmed);
        program.policy.once = true;
        let mut backend = started(&variant, 1, program.clone(), &state, &space);
        for _ in 0..40 {
            let (now, _) = advanced(&mut *backend, 20);
            let (f, ..) = all_pairs(&program.pair, &now, &space);
            for (k, f) in f.iter().enumerate() {
                // Far from its cell, single precision rounds a position to 1e-5.
                let allowed = if variant.precision == Precision::Single { 0.05 } else { variant.tolerance.force };
                assert!((now.f[k] - f).norm() <= allowed * f.norm().max(1.0), "{}: {} {f}", variant.name, now.f[k]);
            }
        }
    }
}

#[test]
fn cells_too_large_for_fixed_point_are_computed_in_double() {
    // One cell of a million sigma, as brute force has it.
    let (state, space) = melt(4);
    let wide = SimulationBox::new(space.lo.add_scalar(-1.0), Vec3::repeat(1e6), space.sides);
    for variant in variants() {
        let program = program(&[2.5], 0.3, Search::Brute);
        let backend = started(&variant, 2, program.clone(), &state, &wide);
        let mut now = State::default();
        backend.fetch(&mut now).unwrap();
        let (f, ..) = all_pairs(&program.pair, &now, &wide);
        let rms = (f.iter().map(Vec3::norm_squared).sum::<f64>() / f.len() as f64).sqrt();
        for (expected, got) in f.iter().zip(&now.f) {
            assert!((got - expected).norm() <= 1e-6 * rms.max(expected.norm()), "{}", variant.name);
        }
    }
}

#[test]
fn more_types_than_lanes_are_looked_up_rightly() {
    let (mut state, space) = melt(5);
    let types = 19;
    for (k, kind) in state.kind.iter_mut().enumerate() {
        *kind = 1 + (k * 7 % types) as u32;
    }
    let cutoffs: Vec<f64> = (0..types).map(|k| 2.5 - 0.05 * k as f64).collect();
    let mut program = program(&cutoffs, 0.3, Search::Trimmed);
    program.masses = (0..types).map(|k| 1.0 + 0.1 * k as f64).collect();
    compare_with_all_pairs("19 types", &program, &state, &space);
}

#[test]
fn energy_and_momentum_are_conserved() {
    let (state, space, cutoffs) = mixture();
    for variant in variants() {
        let (name, tolerance) = (&variant.name, &variant.tolerance);
        let mut program = program(&cutoffs, 0.3, Search::Trimmed);
        // A shifted potential and a short step leave little but the integrator's error.
        program.pair.shift = true;
        program.timestep = 0.001;
        let masses = program.masses.clone();
        let momentum = |state: &State| -> Vec3 {
            state.v.iter().zip(&state.kind).map(|(v, kind)| v * masses[*kind as usize - 1]).sum()
        };
        let total = |sums: &Sums| sums.potential + 0.5 * sums.kinetic[..3].iter().sum::<f64>();
        let mut backend = started(&variant, 2, program, &state, &space);
        let (early, sums) = advanced(&mut *backend, 100);
        let before = total(&sums);
        let (late, sums) = advanced(&mut *backend, 1000);
        assert_relative_eq!(momentum(&late), momentum(&early), epsilon = tolerance.momentum);
        let drift = (total(&sums) - before) / state.len() as f64;
        assert!(drift.abs() < tolerance.drift, "{name}: energy drifts by {drift} per particle");
        assert!(backend.statistics().builds > 5);
    }
}

#[test]
fn threads_do_not_change_a_bit_and_searches_none_but_the_order_of_sums() {
    let (state, space, cutoffs) = mixture();
    for variant in variants() {
        let name = &variant.name;
        let run = |threads: usize, search: Search| {
            let mut backend = started(&variant, threads, program(&cutoffs, 0.3, search), &state, &space);
            let result = advanced(&mut *backend, 200);
            (result, backend.statistics())
        };
        let reference = run(1, Search::Trimmed);
        for threads in [2, 3, 5] {
            assert!(run(threads, Search::Trimmed) == reference, "{name}: {threads} threads give other bits");
        }
        let midplane = run(1, Search::Midplane);
        assert!(run(3, Search::Midplane) == midplane, "{name}: 3 threads give other bits");
        for search in Search::ALL.into_iter().filter(|search| *search != Search::Trimmed) {
            let ((other, _), _) = run(1, search);
            for (a, b) in other.x.iter().zip(&reference.0.0.x) {
                assert_relative_eq!(a, b, epsilon = variant.tolerance.trajectory);
            }
        }
    }
}

#[test]
fn a_default_policy_misses_no_pair() {
    let (state, space, cutoffs) = mixture();
    for variant in variants() {
        let (name, tolerance) = (&variant.name, &variant.tolerance);
        let program = program(&cutoffs, 0.3, Search::Trimmed);
        let mut backend = started(&variant, 1, program.clone(), &state, &space);
        for _ in 0..20 {
            let (now, sums) = advanced(&mut *backend, 7);
            let (_, energy, _) = all_pairs(&program.pair, &now, &space);
            assert_relative_eq!(sums.potential, energy, max_relative = tolerance.energy);
        }
        let statistics = backend.statistics();
        assert!(statistics.builds > 0 && statistics.dangerous == Some(0), "{name}: {statistics:?}");
    }
}

#[test]
fn the_same_scene_far_from_the_origin_has_the_same_forces() {
    let (mut state, space, cutoffs) = mixture();
    // Far out, coordinates lie on a coarser grid: round them to it first, so that both scenes are one.
    let offset = 2f64.powi(20) + 64.0;
    for x in &mut state.x {
        *x = x.map(|c| (c + offset) - offset);
    }
    let edge = (space.hi.x + offset) - offset;
    let lo = [0.0; 3];
    for variant in variants() {
        let name = &variant.name;
        let forces = |shift: f64| {
            let space = free_or_periodic(lo.map(|c| c + shift), [edge; 3], [true; 3]);
            let mut moved = state.clone();
            moved.x.iter_mut().for_each(|x| *x = x.add_scalar(shift));
            let backend = started(&variant, 1, program(&cutoffs, 0.3, Search::Trimmed), &moved, &space);
            let mut now = State::default();
            backend.fetch(&mut now).unwrap();
            now.f
        };
        let (near, far) = (forces(0.0), forces(offset));
        let rms = (near.iter().map(Vec3::norm_squared).sum::<f64>() / near.len() as f64).sqrt();
        for (near, far) in near.iter().zip(&far) {
            let error = (near - far).norm() / rms;
            assert!(error < 2.0 * variant.tolerance.force, "{name}: {error}");
        }
    }
}

#[test]
fn a_broken_force_names_atom_place_and_neighbor() {
    let space = free_or_periodic([0.0; 3], [10.0; 3], [true; 3]);
    let mut state = State::default();
    state.push(7, 1, Vec3::new(1.0, 2.0, 3.0));
    state.push(4, 1, Vec3::new(5.0, 5.0, 5.0));
    state.push(9, 1, Vec3::new(5.0, 5.0, 5.0));
    for variant in variants() {
        let name = &variant.name;
        let mut backend = variant.backend(1);
        backend.load(arc(program(&[2.5], 0.3, Search::Trimmed)), &state, &space, 17).unwrap();
        let fault = backend.set_up(ALL).unwrap_err().fault().unwrap();
        assert_eq!((fault.kind, fault.step, fault.id, fault.count), (FaultKind::Force, 17, 4, 2), "{name}");
        assert_eq!(fault.nearest, Some((9, 0.0)));
        assert_eq!(
            fault.to_string(),
            "step 17: non-finite force on atom 4 at (5, 5, 5); nearest is atom 9 at distance 0; 2 atoms are at fault"
        );
    }
}

#[test]
fn atoms_that_leave_are_lost_where_lammps_loses_them() {
    let space = free_or_periodic([0.0; 3], [10.0; 3], [false, true, true]);
    let mut state = State::default();
    for k in 0..5u32 {
        state.push(k + 1, 1, Vec3::new(2.0 * k as f64 + 1.0, 5.0, 5.0));
    }
    state.v[4].x = 50.0;
    for variant in variants() {
        let name = &variant.name;
        let mut quiet = program(&[2.5], 0.3, Search::Trimmed);
        quiet.lost = LostAtoms::Ignore;
        let mut backend = started(&variant, 1, quiet.clone(), &state, &space);
        let (after, _) = advanced(&mut *backend, 100);
        assert_eq!((after.id, backend.lost()), (vec![1, 2, 3, 4], 1), "{name}");
        quiet.lost = LostAtoms::Error;
        let mut backend = started(&variant, 1, quiet, &state, &space);
        let fault = backend.advance(100, ALL, &AtomicBool::new(false)).unwrap_err().fault().unwrap();
        assert_eq!((fault.kind, fault.id), (FaultKind::Lost, 5));
        let good = fault.last_good.unwrap();
        assert!(good.step < fault.step && good.state.x[4].x < 10.0);
        assert_eq!(good.state.id, vec![1, 2, 3, 4, 5]);
    }
}

#[test]
fn shrink_wrapped_sides_follow_particles_at_builds() {
    let (state, periodic) = melt(4);
    let sides = [[Side::Shrink; 2], [Side::Periodic; 2], [Side::Fixed, Side::Shrink]];
    let mut space = SimulationBox::new(periodic.lo, periodic.hi, sides);
    space.shrink_wrap(&state.x);
    for variant in variants() {
        let mut program = program(&[2.5], 0.3, Search::Trimmed);
        (program.policy.every, program.policy.check, program.lost) = (10, false, LostAtoms::Ignore);
        let mut backend = started(&variant, 2, program, &state, &space);
        let mut before = space.clone();
        for _ in 0..5 {
            let (now, _) = advanced(&mut *backend, 10);
            let found = backend.simulation_box().clone();
            let mut expected = found.clone();
            expected.shrink_wrap(&now.x);
            // This step's build has just looked at these positions.
            let rounding = if variant.precision == Precision::Single { 1e-6 } else { 0.0 };
            assert_relative_eq!(found.lo, expected.lo, epsilon = rounding, max_relative = 0.0);
            assert_relative_eq!(found.hi, expected.hi, epsilon = rounding, max_relative = 0.0);
            assert_ne!(found.hi, before.hi, "{}: particles move", variant.name);
            before = found;
        }
    }
}

#[test]
fn a_gas_of_no_or_one_particle_runs() {
    let space = free_or_periodic([0.0; 3], [3.0, 40.0, 7.0], [true, false, true]);
    for variant in variants() {
        for count in 0..2u32 {
            let mut state = State::default();
            let mut noise = Noise(3);
            for k in 0..count {
                state.push(k + 1, 1, Vec3::new(1.5, 20.0, 3.0) + noise.vector());
            }
            let mut backend = started(&variant, 2, program(&[2.5], 0.3, Search::Trimmed), &state, &space);
            let (after, sums) = advanced(&mut *backend, 50);
            assert_eq!(after.len(), count as usize);
            assert!(sums.potential.is_finite());
        }
    }
}
