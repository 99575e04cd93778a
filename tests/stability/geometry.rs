//! Boxes and places that are hard on cells: faces, edges and corners, edges of the box near multiples of R, slabs, needles,
//! crowds and emptiness. What must hold: every particle in the box, forces and energy by definition, before and after a run.

use octant::engine::{FaultKind, StiffPair};
use octant::system::{SimulationBox, State, Vec3};

use crate::common::{Noise, Variant, arc, free_or_periodic};
use crate::rows::Case;
use crate::{ALL, Exact, advanced, by_definition, each, energy_error, fetched, force_error, smooth, started};

const SECTION: &str = "extreme geometry";

/// Neighbor cutoff of `smooth`.
const R: f64 = 2.8;

/// A lattice about `spacing` wide in which every other particle stays exactly where it is, on faces, edges, corners and
/// mid-planes; the others are a little off, so that forces are none of a crystal's zeros.
fn lattice(space: &SimulationBox, spacing: f64) -> State {
    let lengths = space.lengths();
    let counts = lengths.map(|length| (length / spacing).floor().max(1.0));
    let mut noise = Noise(11);
    let mut state = State::default();
    let [nx, ny, nz] = [counts.x as usize, counts.y as usize, counts.z as usize];
    for k in 0..nx * ny * nz {
        let place = Vec3::new((k % nx) as f64, (k / nx % ny) as f64, (k / nx / ny) as f64);
        let off = if k % 2 == 1 { 0.08 * noise.vector() } else { Vec3::zeros() };
        let x = space.lo + place.component_div(&counts).component_mul(&lengths) + off;
        // On free axes nothing may be beyond a side.
        let inside = x.zip_zip_map(&space.lo, &space.hi, |x, lo, hi| x.clamp(lo, hi.next_down()));
        let x = Vec3::from_fn(|axis, _| if space.periodic(axis) { x[axis] } else { inside[axis] });
        state.push(k as u32 + 1, 1, x);
        state.v[k] = 0.5 * noise.vector();
    }
    state
}

/// U'' of the nearest pairs of a liquid, 1.03 sigma apart.
const STEEP: f64 = 400.0;

fn compare(
    case: Case,
    variant: &Variant,
    when: &str,
    now: &State,
    potential: f64,
    exact: &Exact,
    space: &SimulationBox,
) {
    // Seen across a side, a position is one near the other side, rounded as that is, by LAMMPS too; f32 arithmetic has it in
    // fixed point. U'' of the scene's stiffest pair, masses being 1, makes a force of it; four of them allow for several.
    let program = smooth(1.0);
    let steepest = StiffPair::of(&program, now, space).map_or(0.0, |pair| 0.5 * pair.omega_dt(&program).powi(2));
    let shifted = 4.0 * steepest * f64::EPSILON * space.lengths().amax() / exact.size.max(1.0);
    let reason =
        "rounding of pair arithmetic, of positions in single precision, and of an edge added to a position in double";
    let measured = format!("force error {when}, worst atom over RMS of pair forces");
    case.check(variant, &measured, exact.worst(&now.f), force_error(variant) + shifted, reason);
    let size = exact.energy.abs().max(now.len() as f64);
    let measured = format!("energy error {when}, relative");
    case.check(variant, &measured, (potential - exact.energy).abs() / size, energy_error(variant), reason);
}

/// A scene at rest and, on periodic axes, after `steps` steps.
fn check(case: Case, variant: &Variant, (state, space): &(State, SimulationBox), exact: &Exact, steps: u64) {
    let program = smooth(0.002);
    let mut backend = started(variant, &program, state, space);
    let now = fetched(&*backend);
    let is_in = |x: &Vec3| (0..3).all(|a| (space.lo[a]..space.hi[a]).contains(&x[a]));
    let outside = now.x.iter().filter(|x| !is_in(x)).count();
    case.check(variant, "particles outside the box after wrapping", outside as f64, 0.0, "lo <= x < hi");
    compare(case, variant, "at the start", &now, backend.sums().unwrap().potential, exact, space);
    if steps > 0 {
        let now = advanced(variant, &mut *backend, steps);
        let exact = by_definition(&program.pair, &now, space);
        compare(case, variant, "after a run", &now, backend.sums().unwrap().potential, &exact, space);
    }
}

/// All variants on scenes that make one row together.
fn check_all(case: Case, scenes: &[(State, SimulationBox)], steps: u64) {
    for scene in scenes {
        let exact = by_definition(&smooth(0.002).pair, &scene.0, &scene.1);
        each(|variant| check(case, variant, scene, &exact, steps));
    }
}

fn filled(lo: [f64; 3], edges: [f64; 3], periodic: [bool; 3], spacing: f64) -> (State, SimulationBox) {
    let space = free_or_periodic(lo, edges, periodic);
    (lattice(&space, spacing), space)
}

#[test]
fn particles_on_faces_edges_corners_and_mid_planes() {
    let case = Case::new(SECTION, "particles on faces, edges, corners and mid-planes of the box and its cells");
    // Two cells an axis, planes of particles at quarters of them.
    let edges = [11.3, 11.4, 11.5];
    check_all(case, &[filled([0.0; 3], edges, [true; 3], 1.4), filled([-3.0, 0.0, 7.0], edges, [true; 3], 1.4)], 200);
    let free = [[false; 3], [true, false, true]].map(|periodic| filled([0.0; 3], edges, periodic, 1.4));
    check_all(case, &free, 0);
}

#[test]
fn coordinates_that_are_hard_to_wrap() {
    let case = Case::new(SECTION, "x = L exactly, -0.0, denormals, x = -5e-17");
    let (plain, space) = filled([0.0; 3], [11.3, 11.4, 11.5], [true; 3], 1.4);
    let mut state = plain.clone();
    let mut count = 0;
    for x in &mut state.x {
        for axis in 0..3 {
            let edge = space.hi[axis];
            let hard = [edge, -0.0, 5e-324, -5e-324, -5e-17, edge.next_down(), edge.next_up(), 1e-310, -1e-310, -1e-16];
            if x[axis] == 0.0 {
                x[axis] = hard[count % hard.len()];
                count += 1;
            }
        }
    }
    assert!(count > 100);
    // They are all a face's particles, to rounding; the last digits that the wrap may round off are far below any tolerance.
    check_all(case, &[(state, space)], 200);
}

#[test]
fn edges_just_above_and_below_multiples_of_r() {
    let case = Case::new(SECTION, "L just above, at and just below k R, k = 1 to 7");
    let mut scenes = Vec::new();
    for k in 1..=7 {
        for off in [-1e-9, 0.0, 1e-9] {
            let mut edges = [6.1, 6.2, 6.3];
            edges[k % 3] = k as f64 * R * (1.0 + off);
            scenes.push(filled([0.0; 3], edges, [true; 3], 1.25));
        }
    }
    check_all(case, &scenes, 50);
}

#[test]
fn boxes_below_and_at_2r() {
    let case = Case::new(SECTION, "boxes below R, below 2R and at 2R exactly: images");
    let edges = [[1.4, 1.45, 1.5], [2.8, 2.8, 2.8], [1.4, 4.0, 9.0], [4.0, 4.1, 4.2], [5.6, 5.6, 5.6]];
    let mut scenes: Vec<_> = edges.map(|edges| filled([0.0; 3], edges, [true; 3], 1.3)).into();
    scenes.push(filled([0.0; 3], [1.4, 9.0, 4.0], [true, false, true], 1.3));
    check_all(case, &scenes, 200);
}

#[test]
fn one_two_and_three_cells_a_side() {
    let case = Case::new(SECTION, "1, 2 and 3 cells per side");
    let scenes: Vec<_> = [[5.61, 5.7, 5.8], [11.21, 11.3, 11.4], [16.9, 16.85, 5.7], [5.65, 11.25, 16.9]]
        .map(|edges| filled([0.0; 3], edges, [true; 3], 1.5))
        .into();
    check_all(case, &scenes, 50);
}

/// Drops of liquid around points of a box, across its sides where points are on them.
fn drops(space: &SimulationBox, points: &[[f64; 3]]) -> State {
    let mut state = State::default();
    let mut noise = Noise(23);
    for point in points {
        for k in 0..4 * 4 * 4 {
            let place = Vec3::new(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16)).add_scalar(-1.5);
            let x = Vec3::from(*point) + 1.15 * place + 0.06 * noise.vector();
            let id = state.len() as u32 + 1;
            let mut image = [0; 3];
            let mut x = x;
            space.wrap(&mut x, &mut image);
            state.push(id, 1, x);
            state.v[id as usize - 1] = 0.3 * noise.vector();
        }
    }
    state
}

#[test]
fn slabs_and_needles() {
    let case = Case::new(SECTION, "slabs and needles, 1000:1");
    let (short, long) = (5.0, 5000.0);
    let mut scenes = Vec::new();
    for (edges, points) in [
        ([long, short, short], [[0.0, 2.5, 2.5], [1234.5, 0.0, 0.0], [long - 3.0, 1.0, 2.0]]),
        ([short, short, long], [[2.5, 2.5, 0.0], [0.0, 0.0, 1234.5], [1.0, 2.0, long - 3.0]]),
        ([long, short, long], [[0.0, 2.5, 0.0], [1234.5, 0.0, 1.0], [long - 3.0, 1.0, 4000.0]]),
        ([short, long, long], [[2.5, 0.0, 0.0], [0.0, 4321.5, 1.0], [1.0, long - 3.0, 4000.0]]),
    ] {
        let space = free_or_periodic([-1.0; 3], edges, [true; 3]);
        scenes.push((drops(&space, &points), space));
    }
    check_all(case, &scenes, 100);
}

#[test]
fn two_particles_in_a_thousand_cells() {
    let case = Case::new(SECTION, "2 particles per 1000 cells");
    // 46 cells a side; dimers on their corners and elsewhere, across the periodic sides too.
    let edge = 46.0 * 5.61;
    let space = free_or_periodic([0.0; 3], [edge; 3], [true; 3]);
    let mut state = State::default();
    let mut noise = Noise(5);
    for k in 0..100 {
        let corner = (0.5 * edge * (Vec3::repeat(1.0) + noise.vector())).map(|x| (x / 5.61).round() * 5.61);
        let place = corner + if k % 2 == 0 { Vec3::zeros() } else { 2.0 * noise.vector() };
        let apart = (1.1 + 0.1 * noise.number()) * noise.vector().normalize();
        for side in [-0.5, 0.5] {
            let mut x = place + side * apart;
            space.wrap(&mut x, &mut [0; 3]);
            state.push(state.len() as u32 + 1, 1, x);
        }
    }
    check_all(case, &[(state, space)], 200);
}

#[test]
fn an_atom_fifty_boxes_out() {
    let case = Case::new(SECTION, "an atom 50 boxes out");
    let (plain, space) = filled([0.0; 3], [11.3, 11.4, 11.5], [true; 3], 1.4);
    let exact = by_definition(&smooth(0.002).pair, &plain, &space);
    let mut out = plain.clone();
    let far = Vec3::new(50.0, -50.0, 50.0).component_mul(&space.lengths());
    out.x[101] += far;
    // As files are read: brought back, images counted.
    let mut wrapped = out.clone();
    wrapped.x.iter_mut().zip(&mut wrapped.image).for_each(|(x, image)| space.wrap(x, image));
    each(|variant| {
        case.holds(variant, "50 images are counted", wrapped.image[101] == [50, -50, 50]);
        let backend = started(variant, &smooth(0.002), &wrapped, &space);
        let now = fetched(&*backend);
        let worst = exact.worst(&now.f);
        // Each of 100 edges that are added or taken off rounds as 575 sigma do.
        let bound = force_error(variant) + 100.0 * STEEP * 575.0 * f64::EPSILON / exact.size;
        let measured = "force error, worst atom over RMS of pair forces";
        case.check(variant, measured, worst, bound, "rounding of arithmetic, and of 50 edges taken off");
        // An engine brings back by one image, as LAMMPS does at a set-up: farther out a particle is lost, and named.
        let mut backend = variant.backend(1);
        backend.load(arc(smooth(0.002)), &out, &space, 0).unwrap();
        let fault = backend.set_up(ALL).unwrap_err().fault().unwrap();
        case.holds(variant, "a clear stop that names it", (fault.kind, fault.id) == (FaultKind::Lost, 102));
    });
}

#[test]
fn a_crowd_in_the_corner_of_an_empty_box() {
    let case = Case::new(SECTION, "1e5 particles in one corner of an empty box");
    let count = 46;
    let tight = free_or_periodic([0.0; 3], [1.2 * count as f64 + 5.0; 3], [false; 3]);
    let mut state = State::default();
    let mut noise = Noise(3);
    for k in 0..count * count * count {
        let place = Vec3::new((k % count) as f64, (k / count % count) as f64, (k / count / count) as f64);
        state.push(k as u32 + 1, 1, (1.2 * place + 0.1 * noise.vector()).map(f64::abs));
    }
    // A sample by definition.
    let program = smooth(0.002);
    let near = |x: &Vec3| x.iter().all(|c| *c < 9.0);
    let mut sample = State::default();
    (0..state.len()).filter(|k| near(&state.x[*k])).for_each(|k| sample.push(state.id[k], 1, state.x[k]));
    let exact = by_definition(&program.pair, &sample, &tight);
    let inner = |x: &Vec3| x.iter().all(|c| *c < 6.0);
    each(|variant| {
        let bytes = [&tight, &free_or_periodic([0.0; 3], [1e5; 3], [false; 3])].map(|space| {
            let backend = started(variant, &program, &state, space);
            let now = fetched(&*backend);
            let errors = (0..sample.len()).filter(|k| inner(&sample.x[*k])).map(|k| {
                let id = sample.id[k] as usize;
                (now.f[id - 1] - exact.f[k]).norm()
            });
            let worst = errors.fold(0.0, f64::max) / exact.size;
            let measured = "force error, worst atom over RMS of pair forces";
            case.check(variant, measured, worst, force_error(variant), "rounding of pair arithmetic");
            backend.bytes() as f64
        });
        let reason = "memory follows particles; twice allows for other cells";
        case.check(variant, "memory over that in a tight box", bytes[1] / bytes[0], 2.0, reason);
    });
}
