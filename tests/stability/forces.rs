//! How exact the forces of each precision are, against f64 sums over all pairs of a liquid; wherever the liquid lies.

use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use octant::engine::{Needs, Precision};
use octant::neighbor::Search;
use octant::real::Isa;
use octant::system::{SimulationBox, State, Vec3};

use crate::common::{Engine, Tolerance, Variant, all_pairs, arc, melt, program, variants};
use crate::rows::Case;
use crate::{FORCE_ERROR, force_error};

/// A crystal of 4 n^3 particles after 400 steps.
fn liquid(n: usize) -> (State, SimulationBox) {
    let (mut state, space) = melt(n);
    let exact = Variant {
        name: "melting".into(),
        precision: Precision::Double,
        engine: Engine::Cpu(Isa::detect()),
        tolerance: Tolerance::of(Precision::Double),
    };
    let mut backend = exact.backend(0);
    backend.load(arc(program(&[2.5], 0.3, Search::Trimmed)), &state, &space, 0).unwrap();
    backend.set_up(Needs::default()).unwrap();
    backend.advance(400, Needs::default(), &AtomicBool::new(false)).unwrap();
    backend.fetch(&mut state).unwrap();
    (state, space)
}

fn small() -> &'static (State, SimulationBox) {
    static LIQUID: OnceLock<(State, SimulationBox)> = OnceLock::new();
    LIQUID.get_or_init(|| liquid(10))
}

/// RMS and largest error of a backend's forces over the RMS force.
fn errors(variant: &Variant, state: &State, space: &SimulationBox) -> (f64, f64) {
    let program = program(&[2.5], 0.3, Search::Trimmed);
    let mut backend = variant.backend(0);
    backend.load(arc(program.clone()), state, space, 0).unwrap();
    backend.set_up(Needs::default()).unwrap();
    let mut now = State::default();
    backend.fetch(&mut now).unwrap();
    // Of the positions as given: what single precision rounds of them counts as its error.
    let mut given = state.clone();
    given.x.iter_mut().zip(&mut given.image).for_each(|(x, image)| space.wrap(x, image));
    let (f, ..) = all_pairs(&program.pair, &given, space);
    let sum: f64 = f.iter().map(Vec3::norm_squared).sum();
    let off: Vec<f64> = f.iter().zip(&now.f).map(|(a, b)| (a - b).norm_squared()).collect();
    let worst = off.iter().copied().fold(0.0, f64::max);
    ((off.iter().sum::<f64>() / sum).sqrt(), (worst * f.len() as f64 / sum).sqrt())
}

const LIQUID: Case = Case::new("force error", "a melted liquid against sums over all pairs in f64");
const FAR: Case = Case::new("force error", "the liquid 1e6 sigma from the origin, and in a box of 1e6 sigma");

/// Checks RMS and largest error; returns the RMS.
fn check(case: &Case, what: &str, variant: &Variant, state: &State, space: &SimulationBox) -> f64 {
    let (rms, worst) = errors(variant, state, space);
    let measured = |of: &str| format!("{what}: force error over the RMS force, {of}");
    case.check(variant, &measured("RMS"), rms, variant.tolerance.force_rms, FORCE_ERROR);
    // The worst of 32 000 has two of the nearest pairs more often than that of a hundred.
    let most = (2.0 * force_error(variant)).min(variant.tolerance.force);
    case.check(variant, &measured("worst atom"), worst, most, FORCE_ERROR);
    rms
}

#[test]
fn forces_in_a_liquid_of_4_000() {
    let (state, space) = small();
    for variant in variants() {
        check(&LIQUID, "4 000 atoms", &variant, state, space);
    }
}

#[test]
fn forces_in_a_liquid_of_32_000() {
    let (state, space) = liquid(20);
    for variant in
        variants().into_iter().filter(|v| v.engine == Engine::Cpu(Isa::detect()) || !matches!(v.engine, Engine::Cpu(_)))
    {
        check(&LIQUID, "32 000 atoms", &variant, &state, &space);
        let mut backend = variant.backend(1);
        backend.load(arc(program(&[2.5], 0.3, Search::Trimmed)), &state, &space, 0).unwrap();
        backend.set_up(Needs::default()).unwrap();
        let each = backend.bytes() / state.len();
        assert!(each < 1200, "{}: {each} bytes an atom", variant.name);
    }
}

#[test]
fn forces_a_million_sigma_from_the_origin_and_in_a_box_of_a_million() {
    let (state, space) = small();
    // Coordinates far out lie on a coarser grid: both liquids on it, so that they are one.
    let offset = 1_048_576.0;
    let on_grid = |x: f64| (x + offset) - offset;
    let mut near = state.clone();
    near.x.iter_mut().for_each(|x| *x = x.map(on_grid));
    let near_space = SimulationBox::new(space.lo, space.hi.map(on_grid), space.sides);
    let mut far = near.clone();
    far.x.iter_mut().for_each(|x| *x = x.add_scalar(offset));
    let far_space = SimulationBox::new(near_space.lo.add_scalar(offset), near_space.hi.add_scalar(offset), space.sides);
    // The same drop of liquid in a box of a million sigma: its surface has other forces, the errors are alike.
    let wide = SimulationBox::new(space.lo, Vec3::repeat(offset), space.sides);
    for variant in variants() {
        let here = check(&FAR, "at the origin", &variant, &near, &near_space);
        let there = check(&FAR, "a million sigma away", &variant, &far, &far_space);
        let lonely = check(&FAR, "in a box of a million sigma", &variant, &near, &wide);
        // 5e-15 are the roundings of a sum in f64, below which no ratio tells anything.
        for (what, error) in [("a million sigma away", there), ("in a box of a million sigma", lonely)] {
            let measured = format!("{what}: error over that at the origin");
            let reason = "coordinates are relative to cells: the same but for other roundings";
            FAR.check(&variant, &measured, error / (here + 5e-15), 2.0, reason);
        }
    }
}
