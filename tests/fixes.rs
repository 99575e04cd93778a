//! What fixes do to particles, on every backend in every precision: against closed forms and against steps made by hand.

mod common;

use common::{Noise, Variant, advanced, all_pairs, fetched, free_or_periodic, melt, program, started, variants};
use octant::dynamics::Fix;
use octant::engine::Precision;
use octant::neighbor::Search;
use octant::pair::PairCoefficients;
use octant::system::{GROUP_ALL, SimulationBox, State, Vec3};

fn fix(style: &'static str, group: u32, choice: u32, parameters: Vec<f64>) -> Fix {
    Fix { id: style.into(), style, group, choice, parameters, ..Fix::default() }
}

fn gravity(group: u32, acceleration: [f64; 3]) -> Fix {
    fix("gravity", group, 0, acceleration.to_vec())
}

/// Walls at all six faces of a box.
fn walls(space: &SimulationBox) -> Fix {
    let both = |axis: usize| [space.lo[axis], space.hi[axis]];
    fix("wall/reflect", GROUP_ALL, 63, [both(0), both(1), both(2)].concat())
}

/// Particles that never meet, of two types (masses 1 and 2), some of them in a group of their own (bit 2), in a box without
/// periodic sides. No number of them is a multiple of any register's lanes.
fn loners(speed: f64) -> (State, SimulationBox) {
    let space = free_or_periodic([-20.0, 0.0, 5.0], [40.0, 50.0, 60.0], [false; 3]);
    let mut state = State::default();
    let mut noise = Noise(3);
    for k in 0..27u32 {
        let corner = Vec3::new((k % 3) as f64, (k / 3 % 3) as f64, (k / 9) as f64);
        state.push(k + 1, 1 + k % 2, space.lo + Vec3::repeat(3.0) + 15.0 * corner);
        state.v[k as usize] = speed * noise.vector();
        state.mask[k as usize] |= if k % 3 == 0 { 2 } else { 0 };
    }
    (state, space)
}

/// What single precision makes of numbers of this size, and double of much smaller ones.
fn rounding(variant: &Variant) -> f64 {
    if variant.precision == Precision::Double { 1e-11 } else { 1e-4 }
}

#[test]
fn gravity_pulls_all_masses_of_its_group_alike() {
    let (state, space) = loners(0.5);
    let g = Vec3::new(0.25, -0.5, -1.0);
    for variant in variants() {
        for (group, of_group) in [(GROUP_ALL, [true, true]), (2, [true, false])] {
            let mut program = program(&[1.0, 1.0], 0.3, Search::Trimmed);
            // Before the integrator: forces are its business all the same.
            program.fixes.insert(0, gravity(group, g.into()));
            let mut backend = started(&variant, 2, &program, &state, &space);
            let falls = |k: usize| of_group[usize::from(state.mask[k] & 2 == 0)];
            let at_start = fetched(&*backend);
            let t = 200.0 * program.timestep;
            let after = advanced(&variant, &mut *backend, 200);
            for k in 0..state.len() {
                let g = if falls(k) { g } else { Vec3::zeros() };
                let mass = program.masses[state.kind[k] as usize - 1];
                for now in [&at_start, &after] {
                    assert!((now.f[k] - mass * g).norm() < 1e-6, "{}: atom {} {}", variant.name, k + 1, now.f[k]);
                }
                let (x, v) = (state.x[k] + t * state.v[k] + 0.5 * t * t * g, state.v[k] + t * g);
                let allowed = rounding(&variant);
                assert!((after.x[k] - x).norm() < allowed, "{}: atom {} {} {x}", variant.name, k + 1, after.x[k]);
                assert!((after.v[k] - v).norm() < allowed, "{}: atom {} {} {v}", variant.name, k + 1, after.v[k]);
            }
        }
    }
}

#[test]
fn gravity_is_in_the_force_and_in_no_energy_or_virial() {
    let (state, space) = melt(4);
    for variant in variants() {
        let plain = program(&[2.5], 0.3, Search::Trimmed);
        let mut heavy = plain.clone();
        heavy.fixes.push(gravity(GROUP_ALL, [0.0, 3.0, -5.0]));
        let (mut a, mut b) =
            (started(&variant, 2, &plain, &state, &space), started(&variant, 2, &heavy, &state, &space));
        let (sums, with) = (a.sums().unwrap(), b.sums().unwrap());
        assert_eq!((sums.potential, sums.virial), (with.potential, with.virial), "{}", variant.name);
        let (a, b) = (fetched(&*a), fetched(&*b));
        let scale = a.f.iter().map(|f| f.amax()).fold(0.0, f64::max);
        for (f, with) in a.f.iter().zip(&b.f) {
            let allowed = if variant.precision == Precision::Double { 1e-14 } else { 1e-6 } * scale;
            assert!((with - f - Vec3::new(0.0, 3.0, -5.0)).amax() <= allowed, "{}: {f} {with}", variant.name);
        }
    }
}

/// One flight with reflections, as LAMMPS has it: a step, then each face in turn.
fn flown(mut x: Vec3, mut v: Vec3, dt: f64, steps: usize, space: &SimulationBox) -> (Vec3, Vec3) {
    for _ in 0..steps {
        x += dt * v;
        for axis in 0..3 {
            if x[axis] < space.lo[axis] {
                (x[axis], v[axis]) = (space.lo[axis] + (space.lo[axis] - x[axis]), -v[axis]);
            }
            if x[axis] > space.hi[axis] {
                (x[axis], v[axis]) = (space.hi[axis] - (x[axis] - space.hi[axis]), -v[axis]);
            }
        }
    }
    (x, v)
}

#[test]
fn walls_send_back_what_goes_beyond_them() {
    let (state, space) = loners(40.0);
    for variant in variants() {
        for walls_first in [false, true] {
            let mut program = program(&[0.01, 0.01], 0.3, Search::Trimmed);
            program.fixes.insert(usize::from(!walls_first), walls(&space));
            let mut backend = started(&variant, 2, &program, &state, &space);
            let after = advanced(&variant, &mut *backend, 700);
            for k in 0..state.len() {
                let (x, v) = flown(state.x[k], state.v[k], program.timestep, 700, &space);
                // Each step rounds a displacement, each wall where it stands.
                let allowed = if variant.precision == Precision::Single { 2e-3 } else { 1e-10 };
                assert!((after.x[k] - x).norm() < allowed, "{}: atom {} {} {x}", variant.name, k + 1, after.x[k]);
                assert!((after.v[k] - v).norm() < allowed, "{}: atom {} {} {v}", variant.name, k + 1, after.v[k]);
            }
            assert!(
                after.v.iter().zip(&state.v).any(|(now, then)| (now.x + then.x).abs() < 1e-5),
                "none has met a wall"
            );
        }
    }
}

#[test]
fn walls_of_a_group_let_the_others_pass() {
    let (state, space) = loners(0.0);
    for variant in variants() {
        let mut program = program(&[0.01, 0.01], 0.3, Search::Trimmed);
        program.lost = octant::system::LostAtoms::Ignore;
        // A wall at 0 along x that only the group sees, and only from above.
        program.fixes.push(fix("wall/reflect", 2, 1, vec![0.0; 6]));
        let mut moving = state.clone();
        for (k, v) in moving.v.iter_mut().enumerate() {
            moving.x[k].x = moving.x[k].x.abs() + 1.0;
            *v = Vec3::new(-20.0, 0.0, 0.0);
        }
        let mut backend = started(&variant, 2, &program, &moving, &space);
        let after = advanced(&variant, &mut *backend, 100);
        for k in 0..state.len() {
            let bounces = moving.mask[k] & 2 != 0 && moving.x[k].x < 10.0;
            let x = moving.x[k].x - 10.0;
            let x = if bounces { x.abs() } else { x };
            assert!((after.x[k].x - x).abs() < rounding(&variant), "{}: {} {x}", variant.name, after.x[k].x);
            assert_eq!(after.v[k].x, if bounces { 20.0 } else { -20.0 }, "{}", variant.name);
        }
    }
}

#[test]
fn no_rounding_leaves_a_particle_beyond_a_wall() {
    // A box whose sides are no round numbers in either precision, crossed many times, with a list built every step: a particle
    // that stands on or beyond a side is lost, and the run stops.
    let space = free_or_periodic([0.1, -0.7, 1e3 + 0.3], [1.3, 0.9, 1.1], [false; 3]);
    let mut forceless = PairCoefficients::new("harmonic/cut", 0.0, 1).unwrap();
    forceless.set((1, 1), (1, 1), &["0.0", "1.0"]).unwrap();
    let forceless = forceless.complete().unwrap().0;
    let mut noise = Noise(11);
    let mut state = State::default();
    for k in 0..120u32 {
        let place = 0.5 * (Vec3::repeat(1.0) + noise.vector());
        state.push(k + 1, 1, space.lo + 0.999 * place.component_mul(&space.lengths()));
        state.v[k as usize] = 30.0 * noise.vector();
        if k % 2 == 0 {
            // These crawl along a side by a few units in the last place of single precision a step.
            let (axis, side) = ((k / 4 % 3) as usize, [space.lo, space.hi][(k / 2 % 2) as usize]);
            state.x[k as usize][axis] = side[axis] + 5e-7 * (0.5 * space.lengths() + space.lo - side)[axis].signum();
            state.v[k as usize] = 3e-5 * noise.vector();
        }
    }
    for variant in variants() {
        let mut program = program(&[1e-3], 0.0, Search::Trimmed);
        program.pair = forceless.clone();
        program.fixes.push(walls(&space));
        let mut backend = started(&variant, 2, &program, &state, &space);
        let after = advanced(&variant, &mut *backend, 600);
        assert_eq!((after.len(), backend.lost()), (120, 0), "{}", variant.name);
        assert!(after.x.iter().all(|x| space.outside(x).is_none()), "{}", variant.name);
        assert!(backend.statistics().builds == 600, "{}", variant.name);
    }
}

#[test]
fn second_order_euler_kicks_with_the_old_force() {
    let (state, space) = melt(4);
    for variant in variants() {
        let mut program = program(&[2.5], 0.3, Search::Trimmed);
        program.masses = vec![2.0];
        program.fixes[0].style = "nve/euler2";
        program.timestep = 0.002;
        let dt = program.timestep;
        let mut backend = started(&variant, 2, &program, &state, &space);
        let mut by_hand = fetched(&*backend);
        let origin = by_hand.x.clone();
        let mut unwrapped = by_hand.x.clone();
        for _ in 0..40 {
            by_hand.x.clone_from(&unwrapped);
            let (f, ..) = all_pairs(&program.pair, &by_hand, &space);
            for k in 0..by_hand.len() {
                let a = f[k] / program.masses[0];
                unwrapped[k] += dt * by_hand.v[k] + 0.5 * dt * dt * a;
                by_hand.v[k] += dt * a;
            }
        }
        let after = advanced(&variant, &mut *backend, 40);
        let allowed = if variant.precision == Precision::Double { 1e-9 } else { 2e-4 };
        for k in 0..after.len() {
            let x = space.unwrap(&after.x[k], &after.image[k]);
            let origin_image = space.unwrap(&origin[k], &state.image[k]);
            let moved = (unwrapped[k] - origin[k]) - (x - origin_image);
            let lengths = space.lengths();
            let moved = moved.zip_map(&lengths, |d, l| d - l * (d / l).round());
            assert!(moved.norm() < allowed, "{}: atom {} off by {}", variant.name, k + 1, moved.norm());
            assert!((after.v[k] - by_hand.v[k]).norm() < 100.0 * allowed, "{}", variant.name);
        }
    }
}

/// Particles anywhere in a periodic box, many of them close to others; every third in a group of its own (bit 2).
fn crowd(seed: u64) -> (State, SimulationBox) {
    let space = free_or_periodic([0.0; 3], [6.0; 3], [true; 3]);
    let mut state = State::default();
    let mut noise = Noise(seed);
    for k in 0..151u32 {
        state.push(k + 1, 1, Vec3::repeat(3.0) + 2.999 * noise.vector());
        state.v[k as usize] = noise.vector();
        state.mask[k as usize] |= if k % 3 == 0 { 2 } else { 0 };
    }
    (state, space)
}

#[test]
fn limited_steps_take_overlaps_apart_and_are_never_longer() {
    let (state, space) = crowd(5);
    let (dt, most) = (0.005, 0.02);
    for variant in variants() {
        let mut program = program(&[2.5], 0.3, Search::Trimmed);
        program.timestep = dt;
        program.fixes = vec![fix("nve/limit", GROUP_ALL, 0, vec![most])];
        let mut backend = started(&variant, 2, &program, &state, &space);
        let before = backend.sums().unwrap().potential;
        let mut then = fetched(&*backend);
        for step in 0..300 {
            let now = advanced(&variant, &mut *backend, 1);
            for k in 0..now.len() {
                let moved = (space.unwrap(&now.x[k], &now.image[k]) - space.unwrap(&then.x[k], &then.image[k])).norm();
                // What a coordinate of 6 and a cut of a root and a quotient round, in double or single precision.
                let rounded = if variant.precision == Precision::Single { 4e-6 } else { 1e-13 };
                assert!(moved <= most + rounded, "{}: step {step}, atom {}: {moved}", variant.name, k + 1);
                assert!(now.v[k].norm() <= most / dt * (1.0 + 1e-6), "{}: {}", variant.name, now.v[k].norm());
            }
            then = now;
        }
        let after = backend.sums().unwrap().potential;
        assert!(before > 1e8 && after < 1e3, "{}: {before} {after}", variant.name);
    }
}

#[test]
fn limited_steps_are_those_of_their_formula_and_of_their_group() {
    let (state, space) = melt(4);
    let dt = 0.005;
    for variant in variants() {
        let mut program = program(&[2.5], 0.3, Search::Trimmed);
        program.timestep = dt;
        program.masses = vec![2.0];
        // Half of the crystal's particles are faster than 1.4.
        let limit: f64 = 1.4;
        program.fixes = vec![fix("nve/limit", 2, 0, vec![limit * dt])];
        let mut moving = state.clone();
        moving.mask.iter_mut().step_by(2).for_each(|mask| *mask |= 2);
        let mut backend = started(&variant, 2, &program, &moving, &space);
        let mut by_hand = fetched(&*backend);
        let start = by_hand.clone();
        let cut = |v: Vec3| if v.norm() > limit { limit * v.normalize() } else { v };
        let kicked = |state: &mut State, f: &[Vec3]| {
            for k in (0..state.len()).filter(|k| moving.mask[*k] & 2 != 0) {
                state.v[k] = cut(state.v[k] + 0.5 * dt / 2.0 * f[k]);
            }
        };
        for _ in 0..20 {
            let (f, ..) = all_pairs(&program.pair, &by_hand, &space);
            kicked(&mut by_hand, &f);
            for k in (0..by_hand.len()).filter(|k| moving.mask[*k] & 2 != 0) {
                let v = by_hand.v[k];
                by_hand.x[k] += dt * v;
            }
            let (f, ..) = all_pairs(&program.pair, &by_hand, &space);
            kicked(&mut by_hand, &f);
        }
        let after = advanced(&variant, &mut *backend, 20);
        let fast = start.v.iter().filter(|v| v.norm() > limit).count();
        assert!(fast > 60 && fast < 200, "{fast}");
        let allowed = if variant.precision == Precision::Double { 1e-9 } else { 2e-4 };
        for k in 0..after.len() {
            let off = (after.x[k] - by_hand.x[k]).zip_map(&space.lengths(), |d, l| d - l * (d / l).round());
            assert!(off.norm() < allowed, "{}: atom {} off by {}", variant.name, k + 1, off.norm());
            assert!((after.v[k] - by_hand.v[k]).norm() < 100.0 * allowed, "{}", variant.name);
        }
    }
}
