//! Pair forces over the full list: each particle's force is summed by one thread in the order of its row.

use rayon::prelude::*;

use super::list::{Block, List};
use super::particles::Site;
use super::ties::Ties;
use crate::pair::truncation::{Cut, Shifted, Truncation};
use crate::pair::{PairStyle, PairTable, StyleVisitor, with_style};
use crate::system::Vec3;

/// Energy and virial of the pairs of one block, each pair counted half (its other half is in the partner's row).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairSums {
    pub energy: f64,
    /// xx, yy, zz, xy, xz, yz.
    pub virial: [f64; 6],
    /// A force is infinite or not a number.
    pub broken: bool,
}

impl PairSums {
    /// Adds another block's sums.
    pub fn add(&mut self, other: &Self) {
        self.energy += other.energy;
        for (a, b) in self.virial.iter_mut().zip(other.virial) {
            *a += b;
        }
        self.broken |= other.broken;
    }
}

/// Forces of one pair style, compiled for what the scene has.
pub trait PairKernel: Send + Sync {
    /// Writes the force on every particle. Sums are worked out only if `sums`; `partial` has one entry a block.
    fn forces(&self, list: &List, site: &[Site], f: &mut [Vec3], sums: bool, partial: &mut Vec<PairSums>);
}

/// The kernel for a scene's coefficients.
pub fn pair_kernel(table: &PairTable) -> Option<Box<dyn PairKernel>> {
    struct Compile<'a>(&'a PairTable);
    impl StyleVisitor for Compile<'_> {
        type Output = Box<dyn PairKernel>;
        fn visit<S: PairStyle>(self) -> Self::Output {
            if self.0.shift {
                Box::new(Kernel::<S, Shifted>::new(self.0))
            } else {
                Box::new(Kernel::<S, Cut>::new(self.0))
            }
        }
    }
    with_style(table.style, Compile(table))
}

/// Constants of one pair of types.
struct Constants<S: PairStyle, T: Truncation> {
    squared_cutoff: f64,
    style: S::Params<f64>,
    truncation: T::Params<f64>,
}

struct Kernel<S: PairStyle, T: Truncation> {
    types: usize,
    pairs: Vec<Constants<S, T>>,
}

impl<S: PairStyle, T: Truncation> Kernel<S, T> {
    fn new(table: &PairTable) -> Self {
        let constants = |(pair, squared_cutoff): (&crate::pair::TypePair, f64)| Constants {
            squared_cutoff,
            style: S::params(&pair.coefficients),
            truncation: T::params(pair.energy_at_cutoff),
        };
        let pairs = table.pairs.iter().zip(table.squared_cutoffs()).map(constants).collect();
        Self { types: table.types, pairs }
    }

    /// Forces on the particles of one block; `f` is the block's part of the force array.
    fn block<const ONE_TYPE: bool, const SUMS: bool>(
        &self,
        (block, ties): (&Block, &Ties),
        site: &[Site],
        f: &mut [Vec3],
    ) -> PairSums {
        let mut sums = PairSums::default();
        let entries = &block.entries[..block.pairs()];
        block.for_each_row(|i, stretches, start| {
            let own = &site[i];
            let row = &self.pairs[own.kind as usize * self.types..];
            let mut force = [0.0; 3];
            let mut begin = start;
            for stretch in stretches {
                let s = stretch.shift;
                // Across a periodic side, rounding must decide for both rows of a pair alike.
                let band = if s == [0.0; 3] { 0.0 } else { ties.band };
                let (below, above) = (1.0 - band, 1.0 + band);
                for j in &entries[begin..stretch.end] {
                    let other = &site[*j as usize];
                    let d = [
                        own.x[0] - (other.x[0] + s[0]),
                        own.x[1] - (other.x[1] + s[1]),
                        own.x[2] - (other.x[2] + s[2]),
                    ];
                    let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                    let pair = if ONE_TYPE { &row[0] } else { &row[other.kind as usize] };
                    if r2 < pair.squared_cutoff * above {
                        if r2 >= pair.squared_cutoff * below
                            && ties.shifted_squared_distance(own, other, &s) >= pair.squared_cutoff
                        {
                            continue;
                        }
                        let value = T::apply(S::eval::<f64>(r2, &pair.style), &pair.truncation);
                        let k = value.force_over_r;
                        for axis in 0..3 {
                            force[axis] += d[axis] * k;
                        }
                        if SUMS {
                            sums.energy += 0.5 * value.energy;
                            let h = 0.5 * k;
                            let w = [d[0] * d[0], d[1] * d[1], d[2] * d[2], d[0] * d[1], d[0] * d[2], d[1] * d[2]];
                            for (total, product) in sums.virial.iter_mut().zip(w) {
                                *total += h * product;
                            }
                        }
                    }
                }
                begin = stretch.end;
            }
            sums.broken |= !(force[0] + force[1] + force[2]).is_finite();
            f[i - block.first] = force.into();
        });
        sums
    }
}

impl<S: PairStyle, T: Truncation> PairKernel for Kernel<S, T> {
    fn forces(&self, list: &List, site: &[Site], f: &mut [Vec3], sums: bool, partial: &mut Vec<PairSums>) {
        let blocks = list.blocks();
        // Blocks follow each other without gaps, so the force array splits at their ends.
        let mut rest = f;
        let mut parts = Vec::with_capacity(blocks.len());
        for block in blocks {
            let (part, tail) = rest.split_at_mut(block.end - block.first);
            parts.push((block, part));
            rest = tail;
        }
        let one_type = self.types == 1;
        let work = |(block, f): (&Block, &mut [Vec3])| match (one_type, sums) {
            (true, false) => self.block::<true, false>((block, &list.ties), site, f),
            (true, true) => self.block::<true, true>((block, &list.ties), site, f),
            (false, false) => self.block::<false, false>((block, &list.ties), site, f),
            (false, true) => self.block::<false, true>((block, &list.ties), site, f),
        };
        parts.into_par_iter().map(work).collect_into_vec(partial);
    }
}
