//! Outputs that want sums alone, gone over several at a time, are those of a run that stops at each of them.

#[path = "common/cli.rs"]
mod cli;
mod common;

use std::sync::atomic::AtomicBool;

use cli::Folder;
use common::{Engine, Variant, arc, free_or_periodic, melt, program, variants};
use octant::engine::{Backend, Needs, Precision, Program, Record, Stop};
use octant::neighbor::Search;
use octant::system::{SimulationBox, State, Vec3};

const SUMS: Needs = Needs { energy: true, virial: true, pressure: true, positions: false, forces: false };

/// The same, of the virial the trace alone.
const TRACE: Needs = Needs { virial: false, ..SUMS };

/// Rows at the least, and how many are said to be ahead: some engines record only where it is worth their while.
const MANY: usize = 300;
const AHEAD: u64 = 3000;

/// Rows that are compared: before trajectories that differ by rounding part.
const COMPARED: usize = 60;

type Scene = (State, SimulationBox);

fn set_up(variant: &Variant, program: &Program, (state, space): &Scene, needs: Needs) -> Box<dyn Backend> {
    let mut backend = variant.backend(1);
    backend.load(arc(program.clone()), state, space, 0).unwrap();
    backend.set_up(needs).unwrap();
    backend
}

/// A row at the step an engine has reached.
fn here(backend: &mut dyn Backend) -> Record {
    Record { step: backend.step(), sums: backend.sums().unwrap() }
}

/// Rows `stride` steps apart, until there are as many as that or something goes wrong.
fn rows(backend: &mut dyn Backend, stride: u64, many: usize, needs: Needs) -> (Vec<Record>, Option<Stop>) {
    let (stop, mut rows) = (AtomicBool::new(false), Vec::new());
    backend.expect_outputs((stride, AHEAD), needs).unwrap();
    while rows.len() < many {
        if let Err(why) = backend.advance_recording((stride, AHEAD), needs, &stop, &mut rows) {
            return (rows, Some(why));
        }
        rows.push(here(backend));
    }
    (rows, None)
}

fn rows_one_by_one(backend: &mut dyn Backend, stride: u64, many: usize, needs: Needs) -> Vec<Record> {
    let stop = AtomicBool::new(false);
    let one = |_| {
        backend.advance(stride, needs, &stop).unwrap();
        here(backend)
    };
    (0..many).map(one).collect()
}

/// How far sums may lie apart, in the energy of the first row: rounding of forces, as it has grown by the last row compared.
fn tolerance(precision: Precision) -> f64 {
    match precision {
        Precision::Double => 1e-9,
        Precision::Mixed => 1e-4,
        Precision::Single => 1e-3,
    }
}

fn assert_same(variant: &Variant, rows: &[Record], expected: &[Record], needs: Needs) {
    let scale = expected[0].sums.potential.abs();
    for (row, expected) in rows.iter().zip(expected) {
        assert_eq!(row.step, expected.step, "{}", variant.name);
        let numbers = |r: &Record| {
            let virial = &r.sums.virial;
            let trace = [virial.iter().take(3).sum()];
            let virial = if needs.virial { &virial[..] } else { &trace };
            [&[r.sums.potential], virial, &r.sums.kinetic].concat()
        };
        for (k, (a, b)) in numbers(row).into_iter().zip(numbers(expected)).enumerate() {
            let difference = (a - b).abs() / scale;
            let (name, step) = (&variant.name, row.step);
            assert!(difference <= tolerance(variant.precision), "{name}: number {k} of step {step} is {a}, not {b}");
            assert!(!matches!(variant.engine, Engine::Cpu(_)) || a == b, "{name}: number {k} of step {step}");
        }
    }
}

fn assert_every(variant: &Variant, rows: &[Record], first: i64, stride: i64) {
    let steps: Vec<i64> = rows.iter().map(|row| row.step).collect();
    let expected: Vec<i64> = (1..=rows.len() as i64).map(|k| first + k * stride).collect();
    assert_eq!(steps, expected, "{}: rows are missing or there twice", variant.name);
}

#[test]
fn rows_are_those_of_a_run_that_stops_at_each() {
    for variant in variants() {
        // One type of particles and two of them; coordinates that go around with the box, and images.
        let scenes =
            [(&[2.5][..], 5, 1, SUMS), (&[2.5, 2.0], 3, 1, SUMS), (&[2.5], 5, 3, TRACE), (&[2.5, 2.0], 3, 1, TRACE)];
        for (cutoffs, n, stride, needs) in scenes {
            let program = program(cutoffs, 0.3, Search::Trimmed);
            let mut scene = melt(n);
            for (k, kind) in scene.0.kind.iter_mut().enumerate() {
                *kind = 1 + (k % cutoffs.len()) as u32;
            }
            let mut backend = set_up(&variant, &program, &scene, needs);
            let (found, failed) = rows(&mut *backend, stride, MANY, needs);
            assert!(failed.is_none(), "{}: {failed:?}", variant.name);
            assert_every(&variant, &found, 0, stride as i64);
            let builds = backend.statistics().builds;
            assert!(builds > 5, "{}: lists were built {builds} times", variant.name);
            // Kinetic sums that were made on the way are those of the velocities that are there.
            let (mut state, last) = (scene.0.clone(), found[found.len() - 1]);
            backend.fetch(&mut state).unwrap();
            let mass = |k: usize| program.masses[state.kind[k] as usize - 1];
            let along_x: f64 = (0..state.len()).map(|k| mass(k) * state.v[k].x * state.v[k].x).sum();
            approx::assert_relative_eq!(last.sums.kinetic[0], along_x, max_relative = 1e-9);

            let mut other = set_up(&variant, &program, &scene, needs);
            let expected = rows_one_by_one(&mut *other, stride, COMPARED / stride as usize, needs);
            assert_same(&variant, &found, &expected, needs);
        }
    }
}

/// A crystal of low density that falls in upon its middle: rows of the list grow all the time.
fn collapse() -> Scene {
    let (n, a) = (8, 1.5);
    let mut state = State::default();
    let middle = Vec3::from_element(0.5 * n as f64 * a);
    for k in 0..n * n * n {
        let cell = Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
        state.push(k as u32 + 1, 1, a * (cell + Vec3::from_element(0.5)));
        state.v[k] = -0.9 * (state.x[k] - middle);
    }
    (state, free_or_periodic([-80.0; 3], [160.0 + n as f64 * a; 3], [false; 3]))
}

#[test]
fn rows_stay_whole_where_arrays_have_to_grow() {
    let mut program = program(&[2.5], 0.3, Search::Trimmed);
    program.timestep = 0.004;
    let scene = collapse();
    for variant in variants() {
        let mut backend = set_up(&variant, &program, &scene, SUMS);
        let before = backend.statistics().redone;
        let (found, failed) = rows(&mut *backend, 1, MANY, SUMS);
        assert!(failed.is_none(), "{}: {failed:?}", variant.name);
        assert_every(&variant, &found, 0, 1);
        let redone = backend.statistics().redone - before;
        #[cfg(feature = "cuda")]
        assert!(redone > 0 || !matches!(variant.engine, Engine::Cuda(Some(_))), "{}: nothing grew", variant.name);
        let mut other = set_up(&variant, &program, &scene, SUMS);
        assert_same(&variant, &found, &rows_one_by_one(&mut *other, 1, COMPARED, SUMS), SUMS);
        println!("{}: arrays grew {redone} times", variant.name);
    }
}

#[test]
fn rows_before_a_fault_are_there() {
    let program = program(&[2.5], 0.3, Search::Trimmed);
    let mut state = State::default();
    for (k, x) in [[5.0, 5.0, 5.0], [9.0, 5.5, 5.0], [3.0, 4.0, 9.5]].into_iter().enumerate() {
        state.push(k as u32 + 1, 1, Vec3::from(x));
        state.v[k] = Vec3::new(1.0, 0.5, 0.25);
    }
    let scene = (state, free_or_periodic([0.0; 3], [10.0; 3], [false, true, true]));
    for variant in variants() {
        let mut backend = set_up(&variant, &program, &scene, TRACE);
        let (found, failed) = rows(&mut *backend, 1, 1000, TRACE);
        let fault = failed.and_then(Stop::fault).expect("a particle is lost");
        assert!(fault.step > 100, "{}: {fault}", variant.name);
        assert_every(&variant, &found, 0, 1);
        assert_eq!(found.len() as i64, fault.step - 1, "{}: {fault}", variant.name);
    }
}

/// Numbers of the rows of a thermo table whose header begins with "Step".
fn table(log: &str) -> Vec<Vec<String>> {
    let rows = log.lines().skip_while(|line| !line.trim_start().starts_with("Step")).skip(1);
    let rows = rows.take_while(|line| !line.starts_with("Loop time"));
    rows.map(|line| line.split_whitespace().map(String::from).collect()).collect()
}

#[test]
fn a_table_is_the_same_whatever_else_it_shows() {
    let folder = Folder::new("records");
    const STEPS: usize = 1001;
    // A variable may ask for particles, a dump does: each row or some of them are stopped at.
    let plain = ("thermo_style custom step temp pe press ke", "");
    let stopping = ("variable s equal step\nthermo_style custom step temp pe press ke v_s", "");
    let dumped = (plain.0, "dump d all custom 7 out.dump id x\n");
    let run = |precision: Precision, (style, dump): (&str, &str)| {
        let more = format!("{style}\nthermo_modify format float %.12g\nthermo 1\n{dump}run {}", STEPS - 1);
        folder.write("a.in", &cli::melt(&more));
        let said = folder.says(&format!("run a.in --precision {}", precision.name()));
        (table(&said), said.contains(" cpu, "))
    };
    for precision in Precision::ALL {
        let (rows, exact) = run(precision, plain);
        assert_eq!(rows.len(), STEPS, "{precision:?}");
        for other in [stopping, dumped] {
            let (others, _) = run(precision, other);
            assert_eq!(others.len(), STEPS, "{precision:?}");
            for (step, (row, other)) in rows.iter().zip(&others).enumerate() {
                assert_eq!((&row[0], &other[0]), (&step.to_string(), &step.to_string()), "{precision:?}");
                if exact {
                    assert_eq!(row[..5], other[..5], "{precision:?}, step {step}");
                }
                for (a, b) in row[1..5].iter().zip(&other[1..5]).take_while(|_| step < COMPARED) {
                    let [a, b] = [a, b].map(|text| text.parse::<f64>().unwrap());
                    // Energies of an atom and pressures are of the order of ten.
                    assert!((a - b).abs() < 10.0 * tolerance(precision), "{precision:?}, step {step}: {a} and {b}");
                }
            }
        }
    }
}
