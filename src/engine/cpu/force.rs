//! Pair forces over the full list: kernels compiled for a style, a truncation, a precision and an instruction set, and the
//! division of work among threads. `rows` has the inner loop.

use super::block::Block;
use super::list::List;
use super::mode::{Mode, Slot};
use super::rows::Rows;
use super::scratch::Tiles;
use crate::pair::truncation::{Cut, Shifted, Truncation};
use crate::pair::{PairStyle, PairTable, StyleVisitor, with_style};
use crate::real::Isa;
use crate::real::lanes::{Element, Lanes, Simd, SimdVisitor, with_simd};
use crate::system::parallel;

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
    /// Both blocks' sums.
    pub fn join(a: Self, b: Self) -> Self {
        let virial = std::array::from_fn(|k| a.virial[k] + b.virial[k]);
        Self { energy: a.energy + b.energy, virial, broken: a.broken | b.broken }
    }
}

/// What pair forces are worked out from.
pub struct PairTask<'a, M: Mode> {
    pub list: &'a List,
    pub slots: &'a [M::Slot],
    /// Quanta in a length unit (slots in fixed point).
    pub quanta: f64,
    pub lengths: [f64; 3],
    pub tiles: &'a Tiles<M::Slot>,
    /// Energy and virial are wanted.
    pub sums: bool,
}

/// Forces of one pair style, compiled for what the scene has.
pub trait PairKernel<M: Mode>: Send + Sync {
    /// Writes the force on every particle; returns sums over all pairs.
    fn forces(&self, task: &PairTask<'_, M>, f: [&mut [M::Force]; 3]) -> PairSums;
    /// Pairs worked out side by side.
    fn lanes(&self) -> usize;
}

/// The kernel for a scene's coefficients.
pub fn pair_kernel<M: Mode>(table: &PairTable, isa: Isa) -> Option<Box<dyn PairKernel<M>>> {
    struct Compile<'a, M>(&'a PairTable, Isa, std::marker::PhantomData<M>);
    impl<M: Mode> StyleVisitor for Compile<'_, M> {
        type Output = Box<dyn PairKernel<M>>;
        fn visit<S: PairStyle>(self) -> Self::Output {
            if self.0.shift {
                with_simd(self.1, On::<M, S, Shifted>(self.0, std::marker::PhantomData))
            } else {
                with_simd(self.1, On::<M, S, Cut>(self.0, std::marker::PhantomData))
            }
        }
    }
    struct On<'a, M, S, T>(&'a PairTable, std::marker::PhantomData<(M, S, T)>);
    impl<M: Mode, S: PairStyle, T: Truncation> SimdVisitor for On<'_, M, S, T> {
        type Output = Box<dyn PairKernel<M>>;
        fn visit<I: Simd>(self, simd: I) -> Self::Output {
            Box::new(Kernel::<M, S, T, I>::new(self.0, simd))
        }
    }
    with_style(table.style, Compile::<M>(table, isa, std::marker::PhantomData))
}

pub(super) struct Kernel<M: Mode, S: PairStyle, T: Truncation, I> {
    pub(super) simd: I,
    pub(super) types: usize,
    /// Units of the table in the scene's: energy and length.
    pub(super) energy: f64,
    pub(super) length: f64,
    /// Constants of the first pair of types, for their shape.
    pub(super) style: S::Params<f64>,
    pub(super) truncation: T::Params<f64>,
    /// Numbers of a pair of types: squared cutoff, the style's, the truncation's.
    numbers: usize,
    /// Length of a column: types, filled up to the lanes of a register.
    pub(super) stride: usize,
    /// For each type of the first particle and each number a column by type of the second.
    columns: Vec<M::Force>,
    /// Squared cutoffs in the scene's units, for ties.
    pub(super) squared_cutoffs: Vec<f64>,
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> Kernel<M, S, T, I> {
    fn new(table: &PairTable, simd: I) -> Self {
        // Double precision needs no scaling, and without it squared cutoffs are LAMMPS's to the last bit.
        let (energy, length) = if M::Slot::FIXED { table.scales() } else { (1.0, 1.0) };
        let scaled = table.scaled(energy, length);
        let cutoffs = scaled.squared_cutoffs();
        let types = table.types;
        let style = |k: usize| S::params(&scaled.pairs[k].coefficients, &scaled.settings, scaled.pairs[k].cutoff);
        let truncation = |k: usize| T::params(scaled.pairs[k].energy_at_cutoff);
        let numbers_of = |k: usize| {
            let mut numbers = vec![M::Force::of(cutoffs[k])];
            let mut add = |x: f64| {
                numbers.push(M::Force::of(x));
                x
            };
            S::map(&style(k), &mut add);
            T::map(&truncation(k), &mut add);
            numbers
        };
        let numbers = numbers_of(0).len();
        let stride = types.max(M::PairLanes::<I>::COUNT);
        let mut columns = vec![M::Force::default(); types * numbers * stride];
        for i in 0..types {
            for j in 0..types {
                for (n, number) in numbers_of(i * types + j).into_iter().enumerate() {
                    columns[(i * numbers + n) * stride + j] = number;
                }
            }
        }
        Self {
            simd,
            types,
            energy,
            length,
            style: style(0),
            truncation: truncation(0),
            numbers,
            stride,
            columns,
            squared_cutoffs: table.squared_cutoffs(),
        }
    }

    /// Columns of a type with the others, one after the other.
    #[inline(always)]
    pub(super) fn columns(&self, kind: usize) -> &[M::Force] {
        let length = self.numbers * self.stride;
        &self.columns[kind * length..][..length]
    }
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> PairKernel<M> for Kernel<M, S, T, I> {
    fn forces(&self, task: &PairTask<'_, M>, f: [&mut [M::Force]; 3]) -> PairSums {
        sum_blocks(task.list.blocks(), f, &|block, f| {
            task.tiles.with(|tile| self.simd.vectorize(Rows { kernel: self, task, block, tile, f }))
        })
    }

    fn lanes(&self) -> usize {
        M::PairLanes::<I>::COUNT
    }
}

/// Halves of halves, down to single blocks; sums are joined two by two, whatever the number of threads.
fn sum_blocks<F: Send>(
    blocks: &[Block],
    f: [&mut [F]; 3],
    work: &(impl Fn(&Block, [&mut [F]; 3]) -> PairSums + Sync),
) -> PairSums {
    match blocks {
        [] => PairSums::default(),
        [block] => work(block, f),
        _ => {
            let (low, high) = blocks.split_at(blocks.len() / 2);
            let (f_low, f_high) = parallel::Pieces::split(f, high[0].first - low[0].first);
            let (a, b) = rayon::join(|| sum_blocks(low, f_low, work), || sum_blocks(high, f_high, work));
            PairSums::join(a, b)
        }
    }
}
