//! Pair arithmetic in double precision, where fixed point cannot hold the scene.

use super::engine::Engine;
use super::force::{PairKernel, PairTask, pair_kernel};
use super::mode::{Double, Mode};
use super::scratch::Tiles;
use super::sums::displacement;
use crate::real::lanes::{DoubleSlot, Element};

/// Pair arithmetic in double precision for a faster mode, where fixed point cannot hold the scene.
pub(super) struct Fallback {
    pub(super) kernel: Box<dyn PairKernel<Double>>,
    pub(super) tiles: Tiles<DoubleSlot>,
    pub(super) slots: Vec<DoubleSlot>,
    pub(super) f: [Vec<f64>; 3],
}

impl<M: Mode> Engine<M> {
    /// Whether differences of fixed-point coordinates could be wrong: the grid is too coarse for them, or particles have moved
    /// far since the build, which a script without rebuilds allows.
    pub(super) fn is_out_of_range(&mut self) -> bool {
        let radius = self.neighbor_cutoffs.iter().copied().fold(0.0, f64::max);
        if !self.too_coarse && self.travel > radius {
            self.travel = displacement(&self.moving, self.isa).sqrt();
        }
        self.too_coarse || self.travel > radius
    }

    pub(super) fn forces_in_double(&mut self, sums: bool, lengths: [f64; 3]) {
        let Self { moving, list, kernel, fallback, isa, program, .. } = self;
        let threads = rayon::current_num_threads();
        let fallback = fallback.get_or_insert_with(|| {
            let kernel = pair_kernel(&program.pair, *isa).expect("the scene names a registered pair style");
            let (slots, f) = (Vec::new(), [Vec::new(), Vec::new(), Vec::new()]);
            Box::new(Fallback { kernel, tiles: Tiles::new(threads), slots, f })
        });
        let n = moving.len();
        moving.pack(*isa, 1.0, &mut fallback.slots);
        fallback.f.iter_mut().for_each(|axis| axis.resize(n, 0.0));
        let Fallback { kernel: double, tiles, slots, f } = &mut **fallback;
        // Rows are filled up for the faster kernel's lanes, of which there are at least as many.
        debug_assert!(kernel.lanes().is_multiple_of(double.lanes()));
        let task = PairTask { list, slots, quanta: 1.0, lengths, tiles, sums };
        self.pair_sums = double.forces(&task, f.each_mut().map(|axis| &mut axis[..]));
        for (to, from) in moving.f.iter_mut().zip(&fallback.f) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = M::Force::of(*from);
            }
        }
    }
}
