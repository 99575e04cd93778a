//! What must not matter: where a scene lies, how it is turned, in which order its atoms come, in which image they are given.

use octant::system::{SimulationBox, State, Vec3};

use crate::common::{Noise, Variant, free_or_periodic, melt};
use crate::rows::Case;
use crate::{advanced, each, fetched, force_error, rms, smooth, started};

const SECTION: &str = "conservation";

type Scene = (State, SimulationBox);

/// A scene seen otherwise: particle `k` is the `order[k]`-th of the plain one, `turn` is what becomes of its vectors.
struct View {
    scene: Scene,
    order: Vec<usize>,
    turn: Box<dyn Fn(&Vec3) -> Vec3>,
}

fn liquid() -> Scene {
    let (mut state, space) = melt(4);
    let mut noise = Noise(77);
    for x in &mut state.x {
        *x += 0.1 * noise.vector();
        space.wrap(x, &mut [0; 3]);
    }
    (state, space)
}

/// As it stands, each particle's position and velocity changed by `place` and `turn`.
fn seen((state, space): &Scene, place: impl Fn(&Vec3) -> Vec3, turn: impl Fn(&Vec3) -> Vec3 + 'static) -> View {
    let mut state = state.clone();
    for k in 0..state.len() {
        state.x[k] = place(&state.x[k]);
        state.v[k] = turn(&state.v[k]);
        space.wrap(&mut state.x[k], &mut [0; 3]);
    }
    let order = (0..state.len()).collect();
    View { scene: (state, space.clone()), order, turn: Box::new(turn) }
}

fn compare(case: Case, variant: &Variant, plain: &Scene, view: &View) {
    let program = smooth(0.005);
    let run = |scene: &Scene| {
        let mut backend = started(variant, &program, &scene.0, &scene.1);
        (fetched(&*backend), advanced(variant, &mut *backend, 100))
    };
    let ((a, a_later), (b, b_later)) = (run(plain), run(&view.scene));
    let worst = |a: &[Vec3], b: &[Vec3]| {
        let off = |k: usize| (b[k] - (view.turn)(&a[view.order[k]])).norm();
        (0..b.len()).map(off).fold(0.0, f64::max)
    };
    let (error, bound) = (worst(&a.f, &b.f) / rms(&a.f), 2.0 * force_error(variant));
    case.check(variant, "difference of forces, worst atom over RMS force", error, bound, "both are rounded");
    // As if that difference pulled all the time, of masses of 1.
    let time = 100.0 * program.timestep;
    let error = worst(&a_later.v, &b_later.v);
    let bound = 2.0 * force_error(variant) * rms(&a.f) * time * (3.6 * time).exp();
    let reason = "the bound of the forces' difference, all the time, grown by chaos, e^(3.6 t)";
    case.check(variant, "difference of velocities after 100 steps", error, bound, reason);
}

#[test]
fn translation() {
    let case = Case::new(SECTION, "translation");
    let plain = liquid();
    let by = Vec3::new(1.2345, -3.21, 17.0);
    let view = seen(&plain, |x| x + by, |v| *v);
    each(|variant| compare(case, variant, &plain, &view));
}

#[test]
fn turns_by_90_degrees() {
    let case = Case::new(SECTION, "turns by 90 degrees");
    let plain = liquid();
    let edge = plain.1.lengths().x;
    let around_z = seen(&plain, move |x| Vec3::new(edge - x.y, x.x, x.z), |v| Vec3::new(-v.y, v.x, v.z));
    let around_x = seen(&plain, move |x| Vec3::new(x.x, edge - x.z, x.y), |v| Vec3::new(v.x, -v.z, v.y));
    let around_diagonal = seen(&plain, |x| Vec3::new(x.z, x.x, x.y), |v| Vec3::new(v.z, v.x, v.y));
    for view in [around_z, around_x, around_diagonal] {
        each(|variant| compare(case, variant, &plain, &view));
    }
}

#[test]
fn an_open_cluster_at_any_angle() {
    let case = Case::new(SECTION, "turns of an open cluster by any angle");
    let (mut state, _) = melt(3);
    let middle = state.x.iter().sum::<Vec3>() / state.len() as f64;
    state.x.iter_mut().for_each(|x| *x += Vec3::repeat(20.0) - middle);
    let plain = (state, free_or_periodic([0.0; 3], [40.0; 3], [false; 3]));
    for (axis, angle) in [([1.0, 2.0, 3.0], 0.7), ([-2.0, 0.5, 1.0], 2.9)] {
        let axis = nalgebra::Unit::new_normalize(Vec3::from(axis));
        let turn = nalgebra::Rotation3::from_axis_angle(&axis, angle);
        let place = move |x: &Vec3| turn * (x - Vec3::repeat(20.0)) + Vec3::repeat(20.0);
        let view = seen(&plain, place, move |v| turn * v);
        each(|variant| compare(case, variant, &plain, &view));
    }
}

#[test]
fn the_order_of_atoms() {
    let case = Case::new(SECTION, "permutation of atoms");
    let plain = liquid();
    let n = plain.0.len();
    // 97 has no factor in common with 256.
    let order: Vec<usize> = (0..n).map(|k| (97 * k + 5) % n).collect();
    let mut state = State::default();
    for (k, old) in order.iter().enumerate() {
        state.push(k as u32 + 1, 1, plain.0.x[*old]);
        state.v[k] = plain.0.v[*old];
    }
    let view = View { scene: (state, plain.1.clone()), order, turn: Box::new(|v| *v) };
    each(|variant| compare(case, variant, &plain, &view));
}

#[test]
fn images_and_wrapping() {
    let case = Case::new(SECTION, "images and wrapping");
    let plain = liquid();
    let lengths = plain.1.lengths();
    let mut view = seen(&plain, |x| *x, |v| *v);
    // Outside by one edge, and counted somewhere else.
    for (k, x) in view.scene.0.x.iter_mut().enumerate() {
        let image = [k % 3, k / 3 % 3, k / 9 % 3].map(|i| i as i32 - 1);
        *x += Vec3::from(image.map(f64::from)).component_mul(&lengths);
        view.scene.0.image[k] = [k as i32, -7, 3];
    }
    each(|variant| compare(case, variant, &plain, &view));
}
