//! Thermostats on every backend in every precision: by hand, by their means and their distributions, along a ramp.

mod common;

use std::sync::atomic::AtomicBool;

use common::{Noise, Variant, arc, free_or_periodic, melt, program, variants};
use octant::dynamics::Fix;
use octant::dynamics::noise::noise;
use octant::engine::{Backend, Needs, Precision, Program};
use octant::neighbor::Search;
use octant::system::{GROUP_ALL, SimulationBox, State, Vec3};

const ALL: Needs = Needs { energy: true, virial: true, pressure: true, positions: true, forces: true };

const SEED: u32 = 904_297;

/// `fix langevin` in reduced units; `choice` as the script's parser has it.
fn langevin(group: u32, (start, stop): (f64, f64), damp: f64) -> Fix {
    let parameters = vec![start, stop, 1.0 / damp, (24.0 / damp).sqrt(), f64::from(SEED)];
    Fix { id: "bath".into(), style: "langevin", group, choice: u32::from(start != stop), parameters, ..Fix::default() }
}

fn started(
    variant: &Variant,
    threads: usize,
    program: &Program,
    state: &State,
    space: &SimulationBox,
) -> Box<dyn Backend> {
    let mut backend = variant.backend(threads);
    backend.load(arc(program.clone()), state, space, 0).unwrap();
    if let Err(fault) = backend.set_up(ALL) {
        panic!("{}: {fault}", variant.name);
    }
    backend
}

fn advanced(variant: &Variant, backend: &mut dyn Backend, steps: u64) -> State {
    if let Err(fault) = backend.advance(steps, ALL, &AtomicBool::new(false)) {
        panic!("{}: {fault}", variant.name);
    }
    let mut state = State::default();
    backend.fetch(&mut state).unwrap();
    state
}

/// Particles too small to meet, of two types (masses 1 and 2), every third in a group of its own (bit 2).
fn points(n: usize) -> (State, SimulationBox) {
    let space = free_or_periodic([0.0; 3], [30.0; 3], [true; 3]);
    let mut state = State::default();
    let mut noise = Noise(17);
    for k in 0..n as u32 {
        state.push(k + 1, 1 + k % 2, Vec3::repeat(15.0) + 14.9 * noise.vector());
        state.v[k as usize] = noise.vector();
        state.mask[k as usize] |= if k % 3 == 0 { 2 } else { 0 };
    }
    (state, space)
}

/// A program for [`points`] under `fix nve` and a thermostat.
fn of_points(bath: Fix, dt: f64) -> Program {
    let mut program = program(&[1e-4, 1e-4], 0.5, Search::Trimmed);
    program.fixes.push(bath);
    program.timestep = dt;
    program
}

/// Temperature of a group without the three degrees of freedom of its momentum, which a bath of random forces gives back.
fn temperature(program: &Program, state: &State) -> f64 {
    let sum: f64 =
        state.v.iter().zip(&state.kind).map(|(v, kind)| program.masses[*kind as usize - 1] * v.norm_squared()).sum();
    sum / (3 * state.len()) as f64
}

#[test]
fn langevin_forces_are_those_of_the_formula() {
    let (state, space) = points(203);
    let (damp, dt) = (0.4, 0.01);
    for variant in variants() {
        for (group, (start, stop)) in [(GROUP_ALL, (1.7, 1.7)), (2, (1.0, 3.0))] {
            let mut program = of_points(langevin(group, (start, stop), damp), dt);
            program.range = (0, 40);
            let mut backend = started(&variant, 2, &program, &state, &space);
            // The push on each particle at a step, of the velocity that it has then.
            let push = |v: &[Vec3], k: usize, step: i64| {
                if state.mask[k] & group == 0 {
                    return Vec3::zeros();
                }
                let mass = program.masses[state.kind[k] as usize - 1];
                let target = start + (stop - start) * step as f64 / 40.0;
                let u = Vec3::from(noise(SEED, state.id[k], step));
                -mass / damp * v[k] + (24.0 * target * mass / (damp * dt)).sqrt() * u
            };
            let mut v = state.v.clone();
            let mut f: Vec<Vec3> = (0..v.len()).map(|k| push(&v, k, 0)).collect();
            for step in 1..=30 {
                for k in 0..v.len() {
                    v[k] += 0.5 * dt / program.masses[state.kind[k] as usize - 1] * f[k];
                }
                for k in 0..v.len() {
                    f[k] = push(&v, k, step);
                }
                for k in 0..v.len() {
                    v[k] += 0.5 * dt / program.masses[state.kind[k] as usize - 1] * f[k];
                }
            }
            let after = advanced(&variant, &mut *backend, 30);
            // Sums of 30 numbers near 10, rounded as the arithmetic of forces does.
            let allowed = if variant.precision == Precision::Double { 1e-12 } else { 1e-4 };
            let place = |id: u32| after.id.iter().position(|other| *other == id).unwrap();
            for k in 0..v.len() {
                let at = place(state.id[k]);
                assert!((after.f[at] - f[k]).amax() < allowed, "{}: {} {}", variant.name, after.f[at], f[k]);
                assert!((after.v[at] - v[k]).amax() < allowed, "{}: {} {}", variant.name, after.v[at], v[k]);
            }
        }
    }
}

#[test]
fn langevin_brings_free_particles_to_their_temperature_and_to_maxwells_velocities() {
    let (state, space) = points(300);
    let (damp, dt, target) = (0.5, 0.01, 1.3);
    for variant in variants() {
        let program = of_points(langevin(GROUP_ALL, (target, target), damp), dt);
        let mut backend = started(&variant, 2, &program, &state, &space);
        advanced(&variant, &mut *backend, 500);
        let (mut temperatures, mut reduced) = (Vec::new(), Vec::new());
        // Five damping times apart: what is left of a velocity after them is 0.6 percent.
        for _ in 0..20 {
            let now = advanced(&variant, &mut *backend, 250);
            temperatures.push(temperature(&program, &now));
            let scale = |kind: u32| (program.masses[kind as usize - 1] / target).sqrt();
            reduced.extend(
                now.v
                    .iter()
                    .zip(&now.kind)
                    .flat_map(|(v, kind)| (scale(*kind) * v).iter().copied().collect::<Vec<_>>()),
            );
        }
        // For free particles the scheme has no error in the step: half-step velocities are too hot by 1 / (1 - dt / 2 damp), and
        // a velocity is the mean of two of them. Squares of n Gaussian numbers vary by 2 / n.
        let n = reduced.len() as f64;
        let mean = temperatures.iter().sum::<f64>() / temperatures.len() as f64;
        assert!((mean / target - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{}: {mean}", variant.name);
        // Parts within one, two and three standard deviations, where even random forces make the fourth moment less than a
        // Gaussian's by 1.2 dt / damp, which is one in a thousand here.
        for (width, part) in [(1.0, 0.682_689_5), (2.0, 0.954_499_7), (3.0, 0.997_300_2)] {
            let found = reduced.iter().filter(|v: &&f64| v.abs() < width).count() as f64 / n;
            let error = (part * (1.0 - part) / n).sqrt();
            assert!((found - part).abs() < 4.0 * error + 1e-3, "{}: {found} within {width}", variant.name);
        }
        let drift = reduced.iter().sum::<f64>() / n;
        assert!(drift.abs() < 4.0 / n.sqrt(), "{}: {drift}", variant.name);
    }
}

#[test]
fn langevin_holds_a_liquid_at_its_temperature() {
    let (state, space) = melt(4);
    let target = 1.1;
    for variant in variants() {
        let mut program = program(&[2.5], 0.3, Search::Trimmed);
        program.timestep = 0.004;
        program.fixes.push(langevin(GROUP_ALL, (target, target), 0.2));
        let mut backend = started(&variant, 2, &program, &state, &space);
        advanced(&variant, &mut *backend, 500);
        let samples: Vec<f64> =
            (0..30).map(|_| temperature(&program, &advanced(&variant, &mut *backend, 50))).collect();
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        // As independent as a damping time apart; the error of the step, (omega dt)^2 / 8 with omega of about 20, is less.
        let error = target * (2.0 / (3.0 * state.len() as f64 * samples.len() as f64)).sqrt();
        assert!((mean - target).abs() < 4.0 * error + 1e-3 * target, "{}: {mean} +- {error}", variant.name);
    }
}

#[test]
fn langevin_follows_a_ramp() {
    let (state, space) = points(1500);
    let (damp, dt, steps) = (0.2, 0.01, 800);
    let (start, stop) = (0.5, 3.0);
    for variant in variants() {
        let mut program = of_points(langevin(GROUP_ALL, (start, stop), damp), dt);
        program.range = (0, steps as i64);
        let mut backend = started(&variant, 2, &program, &state, &space);
        for part in 1..=4u32 {
            let now = temperature(&program, &advanced(&variant, &mut *backend, steps / 4));
            // Temperature follows its target by half a damping time.
            let rate = (stop - start) / (steps as f64 * dt);
            let expected = start + (stop - start) * f64::from(part) / 4.0 - 0.5 * damp * rate;
            let error = expected * (2.0 / (3.0 * state.len() as f64)).sqrt();
            assert!((now - expected).abs() < 4.0 * error + 0.01 * expected, "{}: {now} {expected}", variant.name);
        }
    }
}

#[test]
fn random_forces_know_neither_threads_nor_the_order_of_atoms() {
    let (state, space) = points(500);
    let mut turned = State::default();
    for k in (0..state.len()).rev() {
        turned.push(state.id[k], state.kind[k], state.x[k]);
        turned.v[state.len() - 1 - k] = state.v[k];
    }
    for variant in variants() {
        let program = of_points(langevin(GROUP_ALL, (2.0, 2.0), 0.3), 0.01);
        let run = |threads: usize, state: &State| {
            let mut backend = started(&variant, threads, &program, state, &space);
            let mut after = advanced(&variant, &mut *backend, 60);
            let order = after.order_by_id();
            after.v = order.iter().map(|k| after.v[*k]).collect();
            after.v
        };
        let one = run(1, &state);
        assert!(one == run(3, &state) && one == run(2, &turned), "{}", variant.name);
    }
}
