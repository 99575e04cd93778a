//! Pair forces over the full list: each particle's force is summed by one thread in the order of its row, as many neighbors at
//! a time as a register has lanes.

use super::block::{Block, Part};
use super::list::List;
use super::mode::{Mode, Shift, Slot};
use super::scratch::Tiles;
use super::ties::Ties;
use crate::pair::truncation::{Cut, Shifted, Truncation};
use crate::pair::{PairStyle, PairTable, StyleVisitor, with_style};
use crate::real::lanes::{Element, Lanes, PairLanes, Simd, SimdVisitor, Tile, Work, with_simd};
use crate::real::{Isa, Real};
use crate::system::Vec3;
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

struct Kernel<M: Mode, S: PairStyle, T: Truncation, I> {
    simd: I,
    types: usize,
    /// Units of the table in the scene's: energy and length.
    energy: f64,
    length: f64,
    /// Constants of the first pair of types, for their shape.
    style: S::Params<f64>,
    truncation: T::Params<f64>,
    /// Numbers of a pair of types: squared cutoff, the style's, the truncation's.
    numbers: usize,
    /// Length of a column: types, filled up to the lanes of a register.
    stride: usize,
    /// For each type of the first particle and each number a column by type of the second.
    columns: Vec<M::Force>,
    /// Squared cutoffs in the scene's units, for ties.
    squared_cutoffs: Vec<f64>,
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> Kernel<M, S, T, I> {
    fn new(table: &PairTable, simd: I) -> Self {
        // Double precision needs no scaling, and without it squared cutoffs are LAMMPS's to the last bit.
        let (energy, length) = if M::Slot::FIXED { table.scales() } else { (1.0, 1.0) };
        let scaled = table.scaled(energy, length);
        let cutoffs = scaled.squared_cutoffs();
        let types = table.types;
        let style = |k: usize| S::params(&scaled.pairs[k].coefficients, &scaled.settings);
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

    /// Number `n` of a type with the others.
    #[inline(always)]
    fn column(&self, kind: usize, n: usize) -> &[M::Force] {
        &self.columns[(kind * self.numbers + n) * self.stride..][..self.stride]
    }
}

/// Constants of pairs in lanes.
struct Constants<L: Real, S: PairStyle, T: Truncation> {
    squared_cutoff: L,
    style: S::Params<L>,
    truncation: T::Params<L>,
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> PairKernel<M> for Kernel<M, S, T, I> {
    fn forces(&self, task: &PairTask<'_, M>, f: [&mut [M::Force]; 3]) -> PairSums {
        sum_blocks(task.list.blocks(), f, &|block, f| {
            task.tiles.with(|tile| self.simd.vectorize(OnBlock { kernel: self, task, block, tile, f }))
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

/// Forces on the particles of one block; `f` is the block's part of the force arrays.
struct OnBlock<'a, M: Mode, S: PairStyle, T: Truncation, I> {
    kernel: &'a Kernel<M, S, T, I>,
    task: &'a PairTask<'a, M>,
    block: &'a Block,
    tile: &'a mut Tile<M::Slot>,
    f: [&'a mut [M::Force]; 3],
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> Work for OnBlock<'_, M, S, T, I> {
    type Output = PairSums;

    #[inline(always)]
    fn run(mut self) -> PairSums {
        let mut sums = PairSums::default();
        for (k, part) in self.block.parts().iter().enumerate() {
            self.load(part);
            match (self.kernel.types == 1, self.task.sums) {
                (true, false) => self.rows::<true, false>(part, k > 0, &mut sums),
                (true, true) => self.rows::<true, true>(part, k > 0, &mut sums),
                (false, false) => self.rows::<false, false>(part, k > 0, &mut sums),
                (false, true) => self.rows::<false, true>(part, k > 0, &mut sums),
            }
        }
        sums
    }
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> OnBlock<'_, M, S, T, I> {
    /// Copies a tile, shifts applied.
    #[inline(always)]
    fn load(&mut self, part: &Part) {
        type Of<M, I> = <M as Mode>::PairLanes<I>;
        for tile_run in &part.runs {
            let run = &tile_run.run;
            let from = &self.task.slots[run.start as usize..run.end as usize];
            let to = &mut self.tile[tile_run.slot as usize..][..from.len()];
            if run.image == [0; 3] {
                to.copy_from_slice(from);
            } else {
                let shift = Shift::new(run.image, &self.task.lengths, self.task.quanta);
                for (to, from) in to.iter_mut().zip(from) {
                    *to = Of::<M, I>::shifted(from, M::Slot::shift(&shift));
                }
            }
        }
        self.tile[part.slots as usize] = M::Slot::nowhere(&self.task.slots[self.block.first]);
    }

    /// Adds what the rows of a part give; `further` parts add to the forces of the first.
    #[inline(always)]
    fn rows<const ONE_TYPE: bool, const SUMS: bool>(&mut self, part: &Part, further: bool, sums: &mut PairSums) {
        type Of<M, I> = <M as Mode>::PairLanes<I>;
        let Self { kernel, task, block, tile, f } = self;
        let tile = &**tile;
        let lanes = Of::<M, I>::COUNT;
        // Length units of a slot's unit, and of that in the table's.
        let unit = if M::Slot::FIXED { 1.0 / task.quanta } else { 1.0 };
        let scale = Of::<M, I>::constant((unit / kernel.length).powi(2));
        let force_unit = unit * kernel.energy / kernel.length.powi(2);
        let fixed = Constants::<Of<M, I>, S, T> {
            squared_cutoff: Of::<M, I>::splat(kernel.column(0, 0)[0]),
            style: kernel.style_of(0, |column| Of::<M, I>::splat(column[0])),
            truncation: kernel.truncation_of(0, |column| Of::<M, I>::splat(column[0])),
        };
        // Across a periodic side, rounding must decide for both rows of a pair alike.
        let ties = (!M::Slot::FIXED && part.images).then_some(&task.list.ties);
        let zero = Of::<M, I>::constant(0.0);
        let mut begin = 0;
        let mut poison = M::Force::default();
        for (k, length) in part.lengths.iter().enumerate() {
            let end = begin + (*length as usize).next_multiple_of(lanes);
            let row = &part.entries[begin..end];
            begin = end;
            let slot = &task.slots[block.first + k];
            let own = Of::<M, I>::own(slot);
            let kind = if ONE_TYPE { 0 } else { M::Slot::kind(slot) };
            let mut force = [zero; 3];
            let mut energy = zero;
            let mut virial = [zero; 6];
            for index in row.chunks_exact(lanes) {
                let (d, kinds) = Of::<M, I>::differences(own, tile, index);
                let r2 = if M::Slot::FIXED {
                    d[2].mul_add(d[2], d[1].mul_add(d[1], d[0] * d[0])) * scale
                } else {
                    // In LAMMPS's order of operations: rounding decides at the cutoff.
                    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
                };
                let constants = if ONE_TYPE {
                    Constants::<Of<M, I>, S, T> { ..fixed }
                } else {
                    let lookup = |column: &[M::Force]| Of::<M, I>::coefficient(column, kinds);
                    Constants {
                        squared_cutoff: lookup(kernel.column(kind, 0)),
                        style: kernel.style_of(kind, lookup),
                        truncation: kernel.truncation_of(kind, lookup),
                    }
                };
                let mut inside = r2.less(constants.squared_cutoff);
                if let Some(ties) = ties {
                    let near = (r2 - constants.squared_cutoff) * (r2 - constants.squared_cutoff);
                    let band = constants.squared_cutoff * Real::constant(ties.band);
                    let near = Of::<M, I>::bits(near.less(band * band));
                    if near != 0 {
                        let at = TieAt { part, task, i: block.first + k, index, near };
                        inside = Of::<M, I>::mask(at.decide(Of::<M, I>::bits(inside), kernel, ties));
                    }
                }
                let value = T::apply(S::eval(r2, &constants.style), &constants.truncation);
                let pull = Of::<M, I>::select(inside, value.force_over_r, zero);
                for a in 0..3 {
                    force[a] = d[a].mul_add(pull, force[a]);
                }
                if SUMS {
                    energy = energy + Of::<M, I>::select(inside, value.energy, zero);
                    let products = [d[0] * d[0], d[1] * d[1], d[2] * d[2], d[0] * d[1], d[0] * d[2], d[1] * d[2]];
                    for (total, product) in virial.iter_mut().zip(products) {
                        *total = product.mul_add(pull, *total);
                    }
                }
            }
            let force = Of::<M, I>::sums(force);
            for a in 0..3 {
                let before = if further { f[a][k].double() } else { 0.0 };
                let total = M::Force::of(before + force[a].double() * force_unit);
                f[a][k] = total;
                // Infinite and undefined numbers make this undefined for good.
                poison = poison + total * M::Force::default();
            }
            if SUMS {
                sums.energy += 0.5 * kernel.energy * energy.sum().double();
                for (total, product) in sums.virial.iter_mut().zip(virial) {
                    *total += 0.5 * force_unit * unit * product.sum().double();
                }
            }
        }
        sums.broken |= poison.double() != 0.0;
    }
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> Kernel<M, S, T, I> {
    /// The style's constants of a type with the others, each number made from its column.
    #[inline(always)]
    fn style_of<L: Real>(&self, kind: usize, number: impl Fn(&[M::Force]) -> L) -> S::Params<L> {
        let mut n = 0;
        S::map(&self.style, |_: f64| {
            n += 1;
            number(self.column(kind, n))
        })
    }

    /// The same for the truncation, whose numbers are the last.
    #[inline(always)]
    fn truncation_of<L: Real>(&self, kind: usize, number: impl Fn(&[M::Force]) -> L) -> T::Params<L> {
        let mut n = self.numbers;
        T::map(&self.truncation, |x: f64| {
            n -= 1;
            x
        });
        T::map(&self.truncation, |_: f64| {
            n += 1;
            number(self.column(kind, n - 1))
        })
    }
}

/// Pairs of one register, some of them at the cutoff within rounding.
struct TieAt<'a, M: Mode> {
    part: &'a Part,
    task: &'a PairTask<'a, M>,
    i: usize,
    index: &'a [u16],
    near: u32,
}

impl<M: Mode> TieAt<'_, M> {
    /// Which lanes are inside the cutoff, as LAMMPS decides it.
    #[cold]
    fn decide<S: PairStyle, T: Truncation, I>(&self, inside: u32, kernel: &Kernel<M, S, T, I>, ties: &Ties) -> u32 {
        let mut inside = inside;
        for (lane, slot) in self.index.iter().enumerate().filter(|(lane, _)| self.near >> lane & 1 == 1) {
            if u32::from(*slot) >= self.part.slots {
                continue;
            }
            let (j, image) = self.part.particle(*slot);
            if image == [0; 3] {
                continue;
            }
            let (a, b) = (&self.task.slots[self.i], &self.task.slots[j]);
            let limit = kernel.squared_cutoffs[M::Slot::kind(a) * kernel.types + M::Slot::kind(b)];
            let place = |slot: &M::Slot| Vec3::from(M::Slot::position(slot));
            let within = ties.squared_distance(&place(a), &place(b), image) < limit;
            inside = inside & !(1 << lane) | u32::from(within) << lane;
        }
        inside
    }
}
