//! What a long run keeps: energy, momentum, and in double precision the way back. 108 particles of a liquid, dt 0.005.

use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use octant::engine::{Needs, Precision};
use octant::real::Isa;
use octant::system::{SimulationBox, State, Vec3};

use crate::common::{Engine, Tolerance, Variant, melt};
use crate::rows::{Case, is_full, rounding};
use crate::{advanced, each, energy, fetched, momentum, smooth, started};

const SECTION: &str = "conservation";
const TIMESTEP: f64 = 0.005;

/// 108 particles after 20 time units, melted at a temperature about 1.5, their momentum zero.
fn liquid() -> &'static (State, SimulationBox) {
    static LIQUID: OnceLock<(State, SimulationBox)> = OnceLock::new();
    LIQUID.get_or_init(|| {
        let (mut state, space) = melt(3);
        let mean = state.v.iter().sum::<Vec3>() / state.len() as f64;
        state.v.iter_mut().for_each(|v| *v = 2.0 * (*v - mean));
        let precision = Precision::Double;
        let exact = Variant {
            name: "melting".into(),
            precision,
            engine: Engine::Cpu(Isa::detect()),
            tolerance: Tolerance::of(precision),
        };
        let mut backend = started(&exact, &smooth(TIMESTEP), &state, &space);
        let mut state = advanced(&exact, &mut *backend, 4000);
        state.image.fill([0; 3]);
        (state, space)
    })
}

/// Slope of a line through means of equal blocks of a series, against the number of blocks, and its standard error from what is
/// left over.
fn slope(series: &[f64]) -> (f64, f64) {
    const BLOCKS: usize = 20;
    let means: Vec<f64> = series
        .chunks_exact(series.len() / BLOCKS)
        .take(BLOCKS)
        .map(|b| b.iter().sum::<f64>() / b.len() as f64)
        .collect();
    let (n, mean) = (means.len() as f64, means.iter().sum::<f64>() / means.len() as f64);
    let at = |k: usize| k as f64 - (n - 1.0) / 2.0;
    let square: f64 = (0..means.len()).map(|k| at(k).powi(2)).sum();
    let slope = (0..means.len()).map(|k| at(k) * (means[k] - mean)).sum::<f64>() / square;
    let left: f64 = (0..means.len()).map(|k| (means[k] - mean - slope * at(k)).powi(2)).sum();
    (slope / BLOCKS as f64, (left / (n - 2.0) / square).sqrt() / BLOCKS as f64)
}

#[test]
fn energy_and_momentum_of_a_liquid() {
    let steps: u64 = if is_full() { 1_000_000 } else { 20_000 };
    let (state, space) = liquid();
    let program = smooth(TIMESTEP);
    let n = state.len() as f64;
    let form = if is_full() { "1e6 steps" } else { "2e4 steps" };
    each(|variant| {
        let mut backend = started(variant, &program, state, space);
        let before = momentum(&program, &fetched(&*backend));
        let needs = Needs { energy: true, ..Needs::default() };
        let every = 20;
        let mut series = Vec::new();
        for _ in 0..steps / every {
            backend.advance(every, needs, &AtomicBool::new(false)).unwrap_or_else(|why| panic!("{why}"));
            series.push(energy(&backend.sums().unwrap()) / n);
        }
        let time = TIMESTEP * steps as f64;
        let (drift, error) = slope(&series);
        let (drift, error) = (drift / time, error / time);
        let case =
            Case::new(SECTION, "drift of the energy per atom and time unit, 108 atoms of a force-shifted liquid");
        let allowed = match variant.precision {
            Precision::Double => 1e-8,
            Precision::Mixed => 1e-7,
            Precision::Single => 1e-6,
        };
        let measured = format!("drift over {form} (standard error {error:.1e})");
        let reason = "1e-8, 1e-7, 1e-6 in double, mixed, single, and 3 standard errors of the fit";
        case.check(variant, &measured, drift.abs(), allowed + 3.0 * error, reason);

        let case = Case::new(SECTION, "momentum of 108 atoms");
        let after = momentum(&program, &fetched(&*backend));
        let (store, force) = rounding(variant.precision);
        // Pair forces are antisymmetric to the bit; their sums, of parts that add up to 200 or so, and velocities of 1 are
        // rounded, each of them by itself.
        let one = 0.3 * ((force * 200.0 * TIMESTEP).powi(2) + store.powi(2)).sqrt();
        let bound = 5.0 * one * (3.0 * n * 2.0 * steps as f64).sqrt();
        let measured = format!("growth over {form}");
        let reason = "rounding of forces' sums and of velocities as a random walk, 5 standard deviations";
        case.check(variant, &measured, (after - before).norm(), bound, reason);
        assert!(backend.statistics().builds > 100, "{}", variant.name);
    });
}

#[test]
fn a_run_turned_round_comes_back() {
    let case = Case::new(SECTION, "time reversal in double precision, lists changing in between");
    let (state, space) = liquid();
    let program = smooth(TIMESTEP);
    let steps = 400;
    each(|variant| {
        if variant.precision != Precision::Double {
            return;
        }
        let mut backend = started(variant, &program, state, space);
        let mut there = advanced(variant, &mut *backend, steps);
        let builds = backend.statistics().builds;
        there.v.iter_mut().for_each(|v| *v = -*v);
        let mut backend = started(variant, &program, &there, space);
        let back = advanced(variant, &mut *backend, steps);
        case.holds(variant, "lists were built anew", builds.min(backend.statistics().builds) > 5);
        let place = |s: &State, k: usize| space.unwrap(&s.x[k], &s.image[k]);
        let far = (0..state.len()).map(|k| (place(&back, k) - place(state, k)).norm()).fold(0.0, f64::max);
        let moved = (0..state.len()).map(|k| (place(&there, k) - place(state, k)).norm()).fold(0.0, f64::max);
        assert!(moved > 0.5);
        // An error of a step's rounding, 1e-15, grows as e^(3.6 t) over the time there and back.
        let time = 2.0 * TIMESTEP * steps as f64;
        let bound = 1e-15 * (3.6 * time).exp();
        case.check(variant, "largest distance from the start", far, bound, "rounding grown by chaos, e^(3.6 t)");
    });
}
