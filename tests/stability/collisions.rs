//! Collisions that are fast against the timestep: of two particles, of a particle and a wall.

use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

use octant::dynamics::Fix;
use octant::system::{GROUP_ALL, SimulationBox, State, Vec3};

use crate::common::{arc, free_or_periodic};
use crate::rows::{Case, rounding};
use crate::{ALL, advanced, each, energy, fetched, momentum, smooth, started};

const SECTION: &str = "stiff";

/// Two particles that fly at each other; 1e6 epsilon bring them to 0.355 sigma.
fn head_on() -> (State, SimulationBox) {
    let mut state = State::default();
    // Across a corner of the box.
    let direction = Vec3::new(1.0, 2.0, -2.0) / 3.0;
    let space = free_or_periodic([0.0; 3], [30.0; 3], [true; 3]);
    for (id, side) in [(1, -1.0), (2, 1.0)] {
        let (mut x, mut image) = (0.7 * side * direction, [0; 3]);
        space.wrap(&mut x, &mut image);
        state.push(id, 1, x);
        state.v[id as usize - 1] = -1000.0 * side * direction;
    }
    (state, space)
}

#[test]
fn head_on_at_high_speed() {
    let case = Case::new(SECTION, "head-on at a relative speed of 2000");
    let (state, space) = head_on();
    // U'' at the closest point, 4 r^-12 = 1e6, of a mass of 1/2.
    let omega = (2.0 * 624.0 * (1e6f64 / 4.0).powf(14.0 / 12.0)).sqrt();
    for timestep in [1e-6, 1e-5] {
        let program = smooth(timestep);
        // What velocity Verlet keeps differs from the energy by dt^2 (v U'' v / 12 - F^2 / (24 mu)), which is little before and
        // after, however much it is at the closest point. A collision of duration 1 / omega changes what is kept by less than any
        // power of dt. Over the energy:
        let force = |r: f64| program.pair.evaluate(0, 0, r).unwrap().force_over_r * r;
        let ends = ((force(1.4 - 1e-4) - force(1.4 + 1e-4)) / 2e-4).abs() / 12.0 / 1e6;
        each(|variant| {
            let mut backend = started(variant, &program, &state, &space);
            let start = energy(&backend.sums().unwrap());
            let steps = (1.6e-3 / timestep) as u64;
            let now = advanced(variant, &mut *backend, steps);
            let turned = now.v[0].dot(&state.v[0]) < 0.0 && now.v[1].dot(&state.v[1]) < 0.0;
            case.holds(variant, "both fly back", turned);
            let change = (energy(&backend.sums().unwrap()) / start - 1.0).abs();
            let (position, force) = rounding(variant.precision);
            let root = (steps as f64).sqrt();
            // Velocities are rounded at every step, forces matter at the few of the collision alone.
            let rounds = 4.0 * root * position + 6.0 * force;
            let bound = 4.0 * ends * (2000.0 * timestep).powi(2) + (-TAU / (omega * timestep)).exp() + rounds;
            let measured = format!("dt {timestep:e}: relative change of the energy");
            let reason = "shadow Hamiltonian, 4 dt^2 v^2 U'' / 12 where they start, e^(-2 pi / (omega dt)), rounding";
            case.check(variant, &measured, change, bound, reason);
            let walk = 4.0 * root * (position + force);
            let left = momentum(&program, &now).norm() / 1000.0;
            case.check(variant, "momentum over that of a particle", left, walk, "rounding as a random walk");
        });
    }
    // Far beyond the limit of stability: energy is not kept, but there are numbers or there is a stop.
    let program = smooth(1e-3);
    each(|variant| {
        let mut backend = variant.backend(1);
        backend.load(arc(program.clone()), &state, &space, 0).unwrap();
        let end = backend.set_up(ALL).and_then(|()| backend.advance(1000, ALL, &AtomicBool::new(false)));
        let fine = match end {
            Err(why) => why.fault().is_some(),
            Ok(_) => energy(&backend.sums().unwrap()).is_finite() && fetched(&*backend).x[0].norm().is_finite(),
        };
        case.holds(variant, "dt 1e-3: finite or a stop", fine);
    });
}

fn walls(space: &SimulationBox) -> Fix {
    let parameters = (0..3).flat_map(|axis| [space.lo[axis], space.hi[axis]]).collect();
    Fix { id: "w".into(), style: "wall/reflect", group: GROUP_ALL, choice: 0b11_1111, parameters, ..Fix::default() }
}

#[test]
fn steps_as_long_as_a_box_between_walls() {
    let case = Case::new(SECTION, "dt against walls: steps of 0.01 to 0.97 of the box");
    let space = free_or_periodic([-3.0; 3], [10.0; 3], [false; 3]);
    for part in [0.01, 0.1, 0.37, 0.51, 0.97] {
        let mut program = smooth(1.0);
        program.fixes.push(walls(&space));
        let mut state = State::default();
        // No whole number of steps from a wall.
        state.push(1, 1, Vec3::new(1.0, 2.0, 3.0) + Vec3::repeat(1.0 / 7.0));
        state.v[0] = 10.0 * part * Vec3::new(1.0, -0.9, 0.8);
        each(|variant| {
            let mut backend = started(variant, &program, &state, &space);
            let mut out = 0;
            for _ in 0..100 {
                let now = advanced(variant, &mut *backend, 7);
                out += usize::from(space.outside(&now.x[0]).is_some());
            }
            case.check(variant, "times beyond a wall", out as f64, 0.0, "a wall puts back what is beyond it");
            let v = fetched(&*backend).v[0];
            let off = (v.abs() - state.v[0].abs()).amax() / state.v[0].amax();
            let bound = if rounding(variant.precision).0 > 1e-10 { f64::from(f32::EPSILON) } else { 0.0 };
            case.check(
                variant,
                "relative change of a speed",
                off,
                bound,
                "a sign alone is changed; f32 rounds the start",
            );
        });
    }
}

#[test]
fn a_particle_exactly_on_an_upper_side_is_lost_as_in_lammps() {
    let case = Case::new(SECTION, "dt against walls: a step that ends exactly on an upper wall");
    // A wall puts back what is beyond it, and a box ends before its upper side.
    let space = free_or_periodic([-3.0; 3], [10.0; 3], [false; 3]);
    let mut program = smooth(1.0);
    program.fixes.push(walls(&space));
    let mut state = State::default();
    state.push(1, 1, Vec3::new(1.0, 2.0, 3.0));
    state.v[0].x = 3.0;
    each(|variant| {
        let mut backend = started(variant, &program, &state, &space);
        let end = backend.advance(10, ALL, &AtomicBool::new(false));
        // Where f32 keeps positions, walls stand a hair inside.
        let fine = match end {
            Err(why) => why.fault().is_some_and(|fault| fault.step == 2 && fault.id == 1 && fault.position.x == 7.0),
            Ok(_) => space.outside(&fetched(&*backend).x[0]).is_none(),
        };
        case.holds(variant, "inside, or a clear stop", fine);
    });
}

#[test]
fn a_ball_that_bounces_gains_nothing() {
    let case = Case::new(SECTION, "dt against walls: a bouncing ball gains nothing");
    // 1000 steps of 0.002 up and down from a speed of 1; from another, bounces fall anywhere in a step.
    for (v0, whole_steps) in [(1.0, true), (0.5 + 0.1 * std::f64::consts::PI, false)] {
        bounces(case, v0, whole_steps);
    }
}

fn bounces(case: Case, v0: f64, whole_steps: bool) {
    let (g, timestep, steps) = (1.0f64, 2e-3f64, 60_000u64);
    let space = free_or_periodic([0.0; 3], [10.0; 3], [false; 3]);
    let mut program = smooth(timestep);
    let parameters = vec![0.0, 0.0, -g];
    let pull = Fix { id: "g".into(), style: "gravity", group: GROUP_ALL, parameters, ..Fix::default() };
    program.fixes.extend([walls(&space), pull]);
    let mut state = State::default();
    state.push(1, 1, Vec3::new(5.0, 5.0, 0.5 * v0 * v0 / g));
    let n = timestep * steps as f64 * g / (2.0 * v0);
    each(|variant| {
        let mut backend = started(variant, &program, &state, &space);
        let now = advanced(variant, &mut *backend, steps);
        let v = (now.v[0].norm_squared() + 2.0 * g * now.x[0].z).sqrt();
        // Turned with the velocity between two kicks, a particle that was beyond the wall for tau comes away with g (2 tau - dt)
        // more: even between -g dt and g dt. A gain at every bounce would be n g dt, three times the bound.
        // From rest at the top the motion is its own reverse: what a bounce gives, the next takes; bounces after a whole number of
        // steps give nothing. Rounding of f32 soon has them anywhere in a step.
        let position = rounding(variant.precision).0;
        let walk = 4.0 * (steps as f64).sqrt() * position;
        let (bound, reason) = match whole_steps {
            _ if position > 1e-10 => {
                let reason = "changes of -g dt to g dt a bounce as a random walk, 5 standard deviations";
                (5.0 * g * timestep * (n / 3.0).sqrt(), reason)
            }
            true => (walk, "as many steps up as down: rounding as a random walk"),
            false => (g * timestep + walk, "the next bounce takes what one gives, g dt at most; rounding"),
        };
        let whole = if whole_steps { "whole numbers of" } else { "no whole number of" };
        let measured = format!("change of the speed at the wall after {n:.0} bounces of {whole} steps");
        case.check(variant, &measured, (v - v0).abs(), bound, reason);
    });
}
