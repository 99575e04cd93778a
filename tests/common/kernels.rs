//! What tests of CUDA kernels share.
#![allow(dead_code)]

use octant::engine::cuda::inspect::compiler;
use octant::system::{Side, SimulationBox, State, Vec3};

use crate::common::Noise;

/// Whether there is a compiler; without one these tests cannot tell anything, and say so.
pub fn is_there() -> bool {
    match compiler() {
        Ok(_) => true,
        Err(reason) => {
            eprintln!("skipped: {reason}");
            false
        }
    }
}

/// Particles at random places of a cube, of two types in turn.
pub fn gas(n: usize, edge: f64, side: Side) -> (State, SimulationBox) {
    let mut noise = Noise(7);
    let mut state = State::default();
    for k in 0..n {
        let x = 0.5 * edge * (Vec3::repeat(1.0) + noise.vector());
        state.push(k as u32 + 1, 1 + k as u32 % 2, x);
    }
    (state, SimulationBox::new(Vec3::zeros(), Vec3::repeat(edge), [[side; 2]; 3]))
}
