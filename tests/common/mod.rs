//! What several test files share: programs and states made by hand.
#![allow(dead_code)]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use octant::dynamics::Fix;
use octant::engine::cpu::{CpuBackend, CpuOptions};
#[cfg(feature = "cuda")]
use octant::engine::cuda::{CudaBackend, CudaOptions, Tuning};
use octant::engine::{Backend, Needs, Precision, Program};
use octant::neighbor::{Policy, Search, SearchPlan};
use octant::pair::{Coefficient, Dimension, PairCoefficients, PairTable, StyleInfo};
use octant::real::Isa;
use octant::system::{GROUP_ALL, LostAtoms, Side, SimulationBox, State, Units, Vec3};

/// Relative tolerances of a backend's arithmetic.
#[derive(Clone, Debug)]
pub struct Tolerance {
    /// Error of the force on any particle, over the RMS force: rounding of sums whose terms nearly cancel.
    pub force: f64,
    /// The same, RMS over all particles.
    pub force_rms: f64,
    /// Relative error of energies and virials.
    pub energy: f64,
    /// Energy drift of a thousand short steps, per particle, energy units.
    pub drift: f64,
    /// Change of the total momentum of 500 particles in a thousand steps.
    pub momentum: f64,
    /// Distance of two trajectories that differ by rounding, after 200 steps of 0.005.
    pub trajectory: f64,
}

impl Tolerance {
    /// Single and mixed precision round pairs as f32 does (6e-8), single also positions (2e-7 of a cell).
    pub fn of(precision: Precision) -> Self {
        match precision {
            Precision::Double => {
                Self { force: 1e-12, force_rms: 1e-13, energy: 1e-11, drift: 2e-4, momentum: 1e-9, trajectory: 1e-7 }
            }
            Precision::Mixed => {
                Self { force: 3e-5, force_rms: 3e-6, energy: 1e-6, drift: 2e-4, momentum: 1e-3, trajectory: 1e-2 }
            }
            Precision::Single => {
                Self { force: 3e-5, force_rms: 3e-6, energy: 1e-6, drift: 2e-3, momentum: 1e-2, trajectory: 1e-1 }
            }
        }
    }
}

/// A backend in one precision, on one instruction set.
#[derive(Clone, Debug)]
pub struct Variant {
    pub name: String,
    pub precision: Precision,
    pub engine: Engine,
    pub tolerance: Tolerance,
}

/// Where a variant runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Engine {
    Cpu(Isa),
    /// On a GPU, with rows of the list as short as this at the start and an inner list, or as the scene suggests.
    #[cfg(feature = "cuda")]
    Cuda(Option<u32>),
}

impl Variant {
    /// `threads` are of no account on a GPU.
    pub fn backend(&self, threads: usize) -> Box<dyn Backend> {
        let precision = self.precision;
        match self.engine {
            Engine::Cpu(isa) => Box::new(CpuBackend::new(CpuOptions { threads, precision, isa: Some(isa) }).unwrap()),
            #[cfg(feature = "cuda")]
            Engine::Cuda(capacity) => {
                let tuning = Tuning { capacity, inner: capacity.map(|_| 0.4), ..Tuning::default() };
                Box::new(CudaBackend::new(CudaOptions { device: 0, precision, tuning }).unwrap())
            }
        }
    }
}

/// Every precision on every instruction set of this processor, and on the GPU if there is one.
/// OCTANT_TEST_BACKEND=cpu or cuda keeps to one of them; with cuda there must be a GPU.
pub fn variants() -> Vec<Variant> {
    let only = std::env::var("OCTANT_TEST_BACKEND").unwrap_or_default();
    let mut all = if only == "cuda" { Vec::new() } else { cpu_variants() };
    if only != "cpu" {
        all.extend(gpu_variants());
    }
    assert!(!all.is_empty(), "no backend to test");
    all
}

/// Every precision on the GPU, once with rows that have to grow; none where there is no GPU, which is said.
#[cfg(feature = "cuda")]
pub fn gpu_variants() -> Vec<Variant> {
    if let Err(reason) = octant::engine::cuda::devices() {
        println!("skipped: no CUDA device: {reason}");
        return Vec::new();
    }
    let variant = |precision: Precision, capacity: Option<u32>| {
        let start = if capacity.is_some() { ", rows of one entry at the start" } else { "" };
        let name = format!("cuda {}{start}", precision.name());
        Variant { name, precision, engine: Engine::Cuda(capacity), tolerance: Tolerance::of(precision) }
    };
    Precision::ALL.into_iter().flat_map(|p| [variant(p, None), variant(p, Some(1))]).collect()
}

#[cfg(not(feature = "cuda"))]
pub fn gpu_variants() -> Vec<Variant> {
    println!("skipped: no CUDA device: built without CUDA");
    Vec::new()
}

/// Every precision on every instruction set of this processor.
pub fn cpu_variants() -> Vec<Variant> {
    let mut all = Vec::new();
    for precision in Precision::ALL {
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            let name = format!("cpu {} {}", precision.name(), isa.name());
            all.push(Variant { name, precision, engine: Engine::Cpu(isa), tolerance: Tolerance::of(precision) });
        }
    }
    all
}

/// Everything there is to ask for.
pub const ALL: Needs = Needs { energy: true, virial: true, pressure: true, positions: true, forces: true };

/// A backend with a program and particles, set up at step 0.
pub fn started(
    variant: &Variant,
    threads: usize,
    program: &Program,
    state: &State,
    space: &SimulationBox,
) -> Box<dyn Backend> {
    let mut backend = variant.backend(threads);
    backend.load(arc(program.clone()), state, space, 0).unwrap();
    backend.set_up(ALL).unwrap_or_else(|why| panic!("{}: {why}", variant.name));
    backend
}

/// The state after some more steps.
pub fn advanced(variant: &Variant, backend: &mut dyn Backend, steps: u64) -> State {
    let end = backend.advance(steps, ALL, &AtomicBool::new(false));
    end.unwrap_or_else(|why| panic!("{}: {why}", variant.name));
    fetched(backend)
}

/// The state as it is.
pub fn fetched(backend: &dyn Backend) -> State {
    let mut state = State::default();
    backend.fetch(&mut state).unwrap();
    state
}

/// Variants of which the binary can be told, the default instruction set only, with the words that tell it.
pub fn told() -> Vec<(Variant, String)> {
    let mut found: Vec<(Variant, String)> = Vec::new();
    for variant in variants() {
        let backend = if variant.name.starts_with("cpu") { "cpu" } else { "cuda" };
        let words = format!("--backend {backend} --precision {}", variant.precision.name());
        if found.iter().all(|(_, known)| *known != words) {
            found.push((variant, words));
        }
    }
    found
}

/// Forces, energy and virial of all pairs within the cutoff, straight from the pair table, by minimum image.
pub fn all_pairs(pair: &PairTable, state: &State, space: &SimulationBox) -> (Vec<Vec3>, f64, f64) {
    let lengths = space.lengths();
    let most = pair.largest_cutoff();
    let mut f = vec![Vec3::zeros(); state.len()];
    let (mut energy, mut virial) = (0.0, 0.0);
    for i in 0..state.len() {
        for j in i + 1..state.len() {
            let mut d = state.x[i] - state.x[j];
            for a in 0..3 {
                if space.periodic(a) && d[a].abs() > 0.5 * lengths[a] {
                    d[a] -= lengths[a] * (d[a] / lengths[a]).round();
                }
            }
            if d.norm_squared() >= most * most {
                continue;
            }
            let (ti, tj) = (state.kind[i] as usize - 1, state.kind[j] as usize - 1);
            let value = pair.evaluate(ti, tj, d.norm()).unwrap();
            f[i] += d * value.force_over_r;
            f[j] -= d * value.force_over_r;
            energy += value.energy;
            virial += d.norm_squared() * value.force_over_r;
        }
    }
    (f, energy, virial)
}

/// Lennard-Jones particles under `fix nve`, `cutoffs[t]` for type t + 1 and arithmetic means between types.
pub fn program(cutoffs: &[f64], skin: f64, search: impl Into<SearchPlan>) -> Program {
    let types = cutoffs.len();
    let mut pair = PairCoefficients::new("lj/cut", cutoffs[0], types).unwrap();
    pair.mixing = octant::pair::Mixing::Arithmetic;
    for (k, cutoff) in cutoffs.iter().enumerate() {
        let words = [format!("{}", 1.0 + 0.1 * k as f64), format!("{}", 1.0 - 0.05 * k as f64), cutoff.to_string()];
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        pair.set((k + 1, k + 1), (k + 1, k + 1), &words).unwrap();
    }
    let units = *Units::named("lj").unwrap();
    Program {
        units,
        pair: pair.complete().unwrap().0,
        masses: (0..types).map(|k| 1.0 + k as f64).collect(),
        fixes: vec![Fix { id: "1".into(), style: "nve", group: GROUP_ALL, ..Fix::default() }],
        timestep: 0.005,
        policy: Policy::new(skin),
        range: (0, 1000),
        search: search.into(),
        lost: LostAtoms::Error,
        storage_sort: None,
    }
}

/// Two types of particles with any registered style: all pairs set, each with a cutoff of its own; lengths and energies in
/// units of these sizes, SI's magnitudes for instance.
pub fn program_of_style(style: &StyleInfo, shift: bool, energy: f64, length: f64) -> Program {
    let mut pair = PairCoefficients::new(style.name, 0.0, 2).unwrap();
    pair.reset(style.settings.iter().map(|c| 1.1 * c.dimension.size(energy, length)).collect(), 2.5 * length);
    pair.shift = shift;
    for (n, (i, j)) in [(1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
        let value = |(k, c): (usize, &Coefficient)| match c.dimension {
            // Exponents.
            Dimension::NUMBER => 20.0 - 4.0 * k as f64 + 0.1 * n as f64,
            other => (1.0 + 0.1 * n as f64 - 0.05 * k as f64) * other.size(energy, length),
        };
        let values = style.coefficients.iter().enumerate().map(value);
        let words: Vec<String> = values.chain([(2.5 - 0.3 * n as f64) * length]).map(|x: f64| x.to_string()).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        pair.set((i, i), (j, j), &words).unwrap();
    }
    let mut program = program(&[2.5, 2.0], 0.3 * length, Search::Trimmed);
    program.pair = pair.complete().unwrap().0;
    program
}

pub fn arc(program: Program) -> Arc<Program> {
    Arc::new(program)
}

/// A box from its edges; `periodic[axis]` or free.
pub fn free_or_periodic(lo: [f64; 3], edges: [f64; 3], periodic: [bool; 3]) -> SimulationBox {
    let side = |p: bool| if p { [Side::Periodic; 2] } else { [Side::Fixed; 2] };
    let lo = Vec3::from(lo);
    SimulationBox::new(lo, lo + Vec3::from(edges), periodic.map(side))
}

/// An fcc crystal of `n`^3 unit cells at reduced density 0.8442, with small seeded displacements and velocities.
pub fn melt(n: usize) -> (State, SimulationBox) {
    let a = (4.0f64 / 0.8442).cbrt();
    let mut state = State::default();
    let mut noise = Noise(12345);
    for k in 0..n * n * n {
        let cell = Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
        for b in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]] {
            let jitter = 0.05 * noise.vector();
            state.push(state.len() as u32 + 1, 1, a * (cell + Vec3::from(b)) + jitter);
            let last = state.len() - 1;
            state.v[last] = 1.5 * noise.vector();
        }
    }
    (state, free_or_periodic([0.0; 3], [a * n as f64; 3], [true; 3]))
}

/// A small generator of numbers in [-1, 1), so that tests need no package for it.
pub struct Noise(pub u64);

impl Noise {
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}
