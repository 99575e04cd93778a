//! What several test files share: programs and states made by hand.
#![allow(dead_code)]

use std::sync::Arc;

use octant::dynamics::Fix;
use octant::engine::Program;
use octant::neighbor::{Policy, Search};
use octant::pair::PairCoefficients;
use octant::system::{GROUP_ALL, LostAtoms, Side, SimulationBox, State, Units, Vec3};

/// Lennard-Jones particles under `fix nve`, `cutoffs[t]` for type t + 1 and arithmetic means between types.
pub fn program(cutoffs: &[f64], skin: f64, search: Search) -> Program {
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
        fixes: vec![Fix { id: "1".into(), style: "nve", group: GROUP_ALL, parameters: vec![] }],
        timestep: 0.005,
        policy: Policy::new(skin),
        search,
        lost: LostAtoms::Error,
        storage_sort: None,
    }
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
