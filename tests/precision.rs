//! How exact the forces of each precision are, against f64 sums over all pairs of a liquid; wherever the liquid lies.

mod common;

use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use common::{Engine, Tolerance, Variant, all_pairs, arc, melt, program, variants};
use octant::engine::{Needs, Precision};
use octant::neighbor::Search;
use octant::real::Isa;
use octant::system::{SimulationBox, State, Vec3};

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

fn check(what: &str, variant: &Variant, state: &State, space: &SimulationBox) -> f64 {
    let (rms, worst) = errors(variant, state, space);
    println!("{what}, {}: force error RMS {rms:.2e}, worst atom {worst:.2e}", variant.name);
    assert!(rms <= variant.tolerance.force_rms, "{what}, {}: RMS {rms:e}", variant.name);
    assert!(worst <= variant.tolerance.force, "{what}, {}: worst {worst:e}", variant.name);
    rms
}

#[test]
fn forces_in_a_liquid_of_4_000() {
    let (state, space) = small();
    for variant in variants() {
        check("4 000", &variant, state, space);
    }
}

#[test]
fn forces_in_a_liquid_of_32_000() {
    let (state, space) = liquid(20);
    for variant in
        variants().into_iter().filter(|v| v.engine == Engine::Cpu(Isa::detect()) || !matches!(v.engine, Engine::Cpu(_)))
    {
        check("32 000", &variant, &state, &space);
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
        let here = check("at the origin", &variant, &near, &near_space);
        let there = check("a million sigma away", &variant, &far, &far_space);
        let lonely = check("in a box of a million sigma", &variant, &near, &wide);
        assert!(there < 2.0 * here + 1e-14 && lonely < 2.0 * here + 1e-14, "{}: {here} {there} {lonely}", variant.name);
    }
}
