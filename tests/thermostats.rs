//! Thermostats on every backend in every precision: by hand, by their means and their distributions, along a ramp.

mod common;

use common::{ALL, Engine, Noise, advanced, arc, free_or_periodic, melt, program, started, variants};
use octant::dynamics::Fix;
use octant::dynamics::noise::noise;
use octant::engine::{Backend, Precision, Program};
use octant::neighbor::Search;
use octant::system::{GROUP_ALL, SimulationBox, State, Vec3};

const SEED: u32 = 904_297;

/// `fix langevin` in reduced units; `choice` as the script's parser has it.
fn langevin(group: u32, (start, stop): (f64, f64), damp: f64) -> Fix {
    let parameters = vec![start, stop, 1.0 / damp, (24.0 / damp).sqrt(), f64::from(SEED)];
    Fix { id: "bath".into(), style: "langevin", group, choice: u32::from(start != stop), parameters, ..Fix::default() }
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
                f = (0..v.len()).map(|k| push(&v, k, step)).collect();
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

/// `fix nvt` in reduced units with a chain of `links`, as the script's parser has it.
fn nvt(group: u32, (start, stop): (f64, f64), damp: f64, links: u32) -> Fix {
    let parameters = vec![start, stop, 1.0 / damp, 0.0, 1.0, 1.0];
    Fix { id: "nvt".into(), style: "nvt", group, choice: links | 1 << 8, parameters, ..Fix::default() }
}

/// Twice the kinetic energy.
fn doubled_kinetic(backend: &mut dyn Backend) -> f64 {
    let kinetic = backend.sums().unwrap().kinetic;
    kinetic[0] + kinetic[1] + kinetic[2]
}

/// Twice the kinetic energy of free particles under a chain of two links after some time, from the equations of motion
/// (Martyna, Klein and Tuckerman 1992), by small steps of the fourth-order Runge-Kutta method.
fn chain_of_two(kinetic: f64, freedom: f64, target: f64, damp: f64, time: f64) -> f64 {
    let (heavy, light) = (freedom * target * damp * damp, target * damp * damp);
    let slope = |y: [f64; 3]| {
        let [k, first, second] = y;
        [-2.0 * first * k, (k - freedom * target) / heavy - first * second, (heavy * first * first - target) / light]
    };
    let steps = 20_000;
    let h = time / f64::from(steps);
    let mut y = [kinetic, 0.0, 0.0];
    for _ in 0..steps {
        let on = |d: [f64; 3], h: f64| std::array::from_fn(|i| y[i] + h * d[i]);
        let a = slope(y);
        let b = slope(on(a, 0.5 * h));
        let c = slope(on(b, 0.5 * h));
        let d = slope(on(c, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    y[0]
}

#[test]
fn a_chain_follows_its_equations_of_motion() {
    let (state, space) = points(201);
    let (target, damp, time) = (0.8, 0.5, 2.0);
    for variant in variants() {
        let error = |dt: f64| {
            let mut program = of_points(nvt(GROUP_ALL, (target, target), damp, 2), dt);
            program.fixes.remove(0);
            let mut backend = started(&variant, 2, &program, &state, &space);
            let before = doubled_kinetic(&mut *backend);
            advanced(&variant, &mut *backend, (time / dt).round() as u64);
            let freedom = 3.0 * state.len() as f64 - 3.0;
            doubled_kinetic(&mut *backend) / chain_of_two(before, freedom, target, damp, time) - 1.0
        };
        let (coarse, fine) = (error(0.02), error(0.01));
        // Of second order, as the chain's propagator is; single precision rounds 400 scalings of velocities.
        assert!(coarse.abs() < 5e-3 && coarse.abs() > 1e-5, "{}: {coarse}", variant.name);
        let rounded = if variant.precision == Precision::Single { 400.0 * 6e-8 } else { 0.0 };
        assert!((coarse / 4.0 - fine).abs() < 0.1 * coarse.abs() + rounded, "{}: {coarse} {fine}", variant.name);
    }
}

#[test]
fn a_chain_keeps_its_energy_with_the_liquid_and_its_temperature() {
    let (state, space) = melt(4);
    let target = 1.2;
    for variant in variants() {
        let mut program = program(&[2.5], 0.3, Search::Trimmed);
        program.pair.shift = true;
        program.timestep = 0.004;
        program.fixes = vec![nvt(GROUP_ALL, (target, target), 0.2, 3)];
        let mut backend = started(&variant, 2, &program, &state, &space);
        advanced(&variant, &mut *backend, 500);
        let conserved = |backend: &mut dyn Backend| {
            let sums = backend.sums().unwrap();
            let kinetic = sums.kinetic[0] + sums.kinetic[1] + sums.kinetic[2];
            (sums.potential + 0.5 * kinetic + sums.bath, sums.bath, kinetic)
        };
        let (before, bath, _) = conserved(&mut *backend);
        let (mut temperatures, mut exchanged) = (Vec::new(), 0.0f64);
        for _ in 0..40 {
            advanced(&variant, &mut *backend, 50);
            let (now, taken, kinetic) = conserved(&mut *backend);
            let off = (now - before).abs() / state.len() as f64;
            // Forces jump at the cutoff, and energies of the scheme wander by (omega dt)^2 / 8 of kT: a good deal less than this.
            assert!(off < 3e-3, "{}: {off}", variant.name);
            exchanged = exchanged.max((taken - bath).abs() / state.len() as f64);
            temperatures.push(kinetic / (3.0 * state.len() as f64 - 3.0));
        }
        assert!(exchanged > 1e-2, "{}: the bath has taken and given {exchanged}", variant.name);
        let mean = temperatures.iter().sum::<f64>() / temperatures.len() as f64;
        // Samples are a damping time apart.
        let error = target * (2.0 / (3.0 * state.len() as f64 * temperatures.len() as f64)).sqrt();
        assert!((mean - target).abs() < 4.0 * error, "{}: {mean} +- {error}", variant.name);
    }
}

#[test]
fn thermostats_of_two_groups_know_nothing_of_each_other() {
    let (state, space) = points(300);
    for variant in variants() {
        let mut program = of_points(nvt(2, (3.0, 3.0), 0.1, 1), 0.005);
        // The others fly on.
        program.fixes[0].group = 4;
        let mut mixed = state.clone();
        mixed.mask.iter_mut().filter(|mask| **mask & 2 == 0).for_each(|mask| *mask |= 4);
        let run = |program: &Program, threads: usize| {
            let mut backend = started(&variant, threads, program, &mixed, &space);
            let mut after = advanced(&variant, &mut *backend, 100);
            let order = after.order_by_id();
            after.v = order.iter().map(|k| after.v[*k]).collect();
            after.v
        };
        let alone = run(&program, 1);
        assert!(alone == run(&program, 3), "{}: threads show", variant.name);
        for (k, v) in alone.iter().enumerate() {
            let scaled = mixed.mask[k] & 2 != 0;
            // Single precision rounds the velocity that it is given.
            let moved = (v - mixed.v[k]).amax() > 1e-3 * v.amax();
            assert_eq!(moved, scaled, "{}: atom {}", variant.name, k + 1);
            // All of a group by the same factor.
            let factor = v.x / mixed.v[k].x;
            assert!((v - factor * mixed.v[k]).amax() < 1e-4 * v.amax(), "{}", variant.name);
        }
        program.fixes[0] = nvt(4, (0.2, 0.2), 0.3, 5);
        let both = run(&program, 2);
        // On a GPU these are other kernels, in which other products may be fused.
        let rounding = match (variant.engine, variant.precision) {
            (Engine::Cpu(_), _) => 0.0,
            (_, Precision::Single) => 1e-5,
            _ => 1e-12,
        };
        let same = |k: usize| (both[k] - alone[k]).amax() <= rounding * alone[k].amax();
        let same = (0..both.len()).filter(|k| mixed.mask[*k] & 2 != 0).all(same);
        assert!(same && both != alone, "{}", variant.name);
    }
}

#[test]
fn a_single_particle_has_no_temperature_to_be_brought_to() {
    let (mut state, space) = points(2);
    state.mask[0] |= 4;
    for variant in variants() {
        let program = of_points(nvt(4, (1.0, 1.0), 0.1, 3), 0.005);
        let mut backend =
            started(&variant, 2, &Program { fixes: program.fixes[1..].to_vec(), ..program }, &state, &space);
        let after = advanced(&variant, &mut *backend, 50);
        assert!((after.v[0] - state.v[0]).amax() < 1e-6 && (after.v[1] - state.v[1]).amax() < 1e-6, "{}", variant.name);
    }
}

#[test]
fn a_run_in_parts_is_one_run() {
    let (state, space) = melt(4);
    for variant in variants() {
        let mut program = program(&[2.5], 0.3, Search::Trimmed);
        program.fixes = vec![nvt(GROUP_ALL, (1.0, 1.5), 0.2, 3)];
        program.range = (0, 60);
        let whole = advanced(&variant, &mut *started(&variant, 2, &program, &state, &space), 60);
        let mut backend = started(&variant, 2, &program, &state, &space);
        for steps in [1, 9, 30] {
            advanced(&variant, &mut *backend, steps);
        }
        assert!(advanced(&variant, &mut *backend, 20).v == whole.v, "{}: outputs show", variant.name);
        // Into the next run goes what the chain has kept, and particles as they are stored.
        let mut backend = started(&variant, 2, &program, &state, &space);
        let halfway = advanced(&variant, &mut *backend, 30);
        let mut next = program.clone();
        next.fixes[0].memory = backend.memories().remove(0);
        assert_eq!(next.fixes[0].memory.len(), 11);
        let mut backend = variant.backend(2);
        backend.load(arc(next), &halfway, &space, 30).unwrap();
        backend.set_up(ALL).unwrap();
        let rest = advanced(&variant, &mut *backend, 30);
        // Forces of another list are added up in another order; a chaotic liquid makes that grow tenfold in 0.15 tau.
        let allowed = variant.tolerance.trajectory;
        for (v, other) in rest.v.iter().zip(&whole.v) {
            assert!((v - other).amax() < allowed, "{}: {v} {other}", variant.name);
        }
    }
}
