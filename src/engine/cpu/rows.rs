//! The inner loop of the pair forces: rows of one block, as many neighbors at a time as a register has lanes.

use super::block::{Block, Part};
use super::force::{Kernel, PairSums, PairTask};
use super::mode::{Mode, Shift, Slot};
use crate::neighbor::ties::{Ties, is_tied};
use crate::pair::PairStyle;
use crate::pair::power_of_two;
use crate::pair::truncation::Truncation;
use crate::real::lanes::{Element, Lanes, PairLanes, Simd, Tile, Work};
use crate::real::{Convert, Real};
use crate::system::Vec3;

/// Forces on the particles of one block; `f` is the block's part of the force arrays.
pub struct Rows<'a, M: Mode, S: PairStyle, T: Truncation, I> {
    pub kernel: &'a Kernel<M, S, T, I>,
    pub task: &'a PairTask<'a, M>,
    pub block: &'a Block,
    pub tile: &'a mut Tile<M::Slot>,
    pub f: [&'a mut [M::Force]; 3],
}

/// One type; no more than a register has lanes, so that numbers are picked within registers; more.
const ONE: u8 = 0;
const FEW: u8 = 1;
const MANY: u8 = 2;

/// Pair lanes of a mode.
type Of<M, I> = <M as Mode>::PairLanes<I>;

/// Constants of pairs in lanes.
struct Constants<L: Real, S: PairStyle, T: Truncation> {
    squared_cutoff: L,
    style: S::Params<L>,
    truncation: T::Params<L>,
}

impl<L: Real, S: PairStyle, T: Truncation> Constants<L, S, T> {
    /// Made number after number, in the order of a kernel's columns.
    #[inline(always)]
    fn new<M: Mode, I>(kernel: &Kernel<M, S, T, I>, mut number: impl Convert<f64, L>) -> Self {
        let squared_cutoff = number.convert(0.0);
        let mut rest = Rest(number);
        let style = S::map(&kernel.style, &mut rest);
        let truncation = T::map(&kernel.truncation, &mut rest);
        Self { squared_cutoff, style, truncation }
    }
}

/// Goes on where another conversion stopped.
struct Rest<C>(C);

impl<A, B, C: Convert<A, B>> Convert<A, B> for &mut Rest<C> {
    #[inline(always)]
    fn convert(&mut self, value: A) -> B {
        self.0.convert(value)
    }
}

/// Numbers of a type with the others, one column after the other, for the types in the lanes.
struct OfKinds<'a, L: PairLanes> {
    columns: &'a [L::Element],
    stride: usize,
    kinds: L::Kinds,
}

impl<L: PairLanes> Convert<f64, L> for OfKinds<'_, L> {
    #[inline(always)]
    fn convert(&mut self, _: f64) -> L {
        let (column, rest) = self.columns.split_at(self.stride);
        self.columns = rest;
        L::coefficient(column, self.kinds)
    }
}

/// Numbers of the one pair of types there is.
struct OfOneType<'a, E> {
    columns: &'a [E],
    stride: usize,
}

impl<L: PairLanes> Convert<f64, L> for OfOneType<'_, L::Element> {
    #[inline(always)]
    fn convert(&mut self, _: f64) -> L {
        let (column, rest) = self.columns.split_at(self.stride);
        self.columns = rest;
        L::splat(column[0])
    }
}

/// What a row adds up to, lane by lane.
struct Totals<L> {
    force: [L; 3],
    energy: L,
    virial: [L; 6],
    /// The least square of (squared distance - squared cutoff).
    nearest: L,
}

/// What all rows of a part have in common.
struct Common<L: Real, S: PairStyle, T: Truncation> {
    /// Squares of the table's length units in the square of a slot's unit.
    scale: L,
    /// What forces are multiplied by for the virial: a slot's unit in the table's, to a power of two. In squares of a slot's unit
    /// a virial is no f32 where the force still is one.
    work: L,
    /// For one type.
    constants: Constants<L, S, T>,
    zero: L,
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> Work for Rows<'_, M, S, T, I> {
    type Output = PairSums;

    #[inline(always)]
    fn run(mut self) -> PairSums {
        let mut sums = PairSums::default();
        for (k, part) in self.block.parts().iter().enumerate() {
            self.load(part);
            let few = self.kernel.stride == Of::<M, I>::COUNT;
            match (self.kernel.types, few, self.task.sums) {
                (1, _, false) => self.part::<ONE, false>(part, k > 0, &mut sums),
                (1, _, true) => self.part::<ONE, true>(part, k > 0, &mut sums),
                (_, true, false) => self.part::<FEW, false>(part, k > 0, &mut sums),
                (_, true, true) => self.part::<FEW, true>(part, k > 0, &mut sums),
                (_, false, false) => self.part::<MANY, false>(part, k > 0, &mut sums),
                (_, false, true) => self.part::<MANY, true>(part, k > 0, &mut sums),
            }
        }
        sums
    }
}

impl<M: Mode, S: PairStyle, T: Truncation, I: Simd> Rows<'_, M, S, T, I> {
    /// Copies a tile, shifts applied.
    #[inline(always)]
    fn load(&mut self, part: &Part) {
        for tile_run in &part.runs {
            let run = &tile_run.run;
            let from = &self.task.slots[run.start as usize..run.end as usize];
            let to = &mut self.tile[tile_run.slot as usize..][..from.len()];
            if run.image == [0; 3] {
                to.copy_from_slice(from);
            } else {
                let shift = Shift::new(run.image, &self.task.lengths, self.task.quanta);
                for (to, from) in to.iter_mut().zip(from) {
                    *to = from.shifted(M::Slot::shift(&shift));
                }
            }
        }
        self.tile[part.slots as usize] = M::Slot::nowhere(&self.task.slots[self.block.first]);
    }

    /// Adds what the rows of a part give; `further` parts add to the forces of the first.
    #[inline(always)]
    fn part<const TYPES: u8, const SUMS: bool>(&mut self, part: &Part, further: bool, sums: &mut PairSums) {
        let kernel = self.kernel;
        // Of the mode that the list was built for, which may have more than this kernel.
        let lanes = self.task.list.lanes;
        // Length units of a slot's unit.
        let unit = if M::Slot::FIXED { 1.0 / self.task.quanta } else { 1.0 };
        let force_unit = unit * kernel.energy / kernel.length.powi(2);
        let zero = Of::<M, I>::constant(0.0);
        let work = if M::Slot::FIXED { power_of_two(unit / kernel.length) } else { 1.0 };
        let of_one_type = OfOneType { columns: kernel.columns(0), stride: kernel.stride };
        let common = Common {
            scale: Of::<M, I>::constant((unit / kernel.length).powi(2)),
            work: Of::<M, I>::constant(work),
            constants: Constants::new(kernel, of_one_type),
            zero,
        };
        // Across a periodic side, rounding must decide for both rows of a pair alike; in fixed point it does.
        let ties = !M::Slot::FIXED && part.images;
        let band = self.task.list.ties.band * kernel.squared_cutoffs.iter().copied().fold(0.0, f64::max);
        let mut poison = M::Force::default();
        let mut begin = 0;
        for (k, length) in part.lengths.iter().enumerate() {
            let end = begin + (*length as usize).next_multiple_of(lanes);
            let row = &part.entries[begin..end];
            begin = end;
            let mut totals = self.row::<TYPES, SUMS, false>(part, k, row, &common);
            if !M::Slot::FIXED && ties && -(-totals.nearest).largest().double() <= band * band {
                totals = self.row::<TYPES, SUMS, true>(part, k, row, &common);
            }
            let force = Of::<M, I>::sums(totals.force);
            for (to, force) in self.f.iter_mut().zip(force) {
                let before = if further { to[k].double() } else { 0.0 };
                let total = M::Force::of(before + force.double() * force_unit);
                to[k] = total;
                // Infinite and undefined numbers make this undefined for good.
                poison = poison + total * M::Force::default();
            }
            if SUMS {
                sums.energy += 0.5 * kernel.energy * totals.energy.sum().double();
                for (total, product) in sums.virial.iter_mut().zip(totals.virial) {
                    *total += 0.5 * force_unit * (unit / work) * product.sum().double();
                }
            }
        }
        sums.broken |= poison.double() != 0.0;
    }

    /// Adds up one row. `EXACT` asks about every pair near the cutoff and across a side.
    #[inline(always)]
    fn row<const TYPES: u8, const SUMS: bool, const EXACT: bool>(
        &self,
        part: &Part,
        k: usize,
        row: &[u16],
        common: &Common<Of<M, I>, S, T>,
    ) -> Totals<Of<M, I>> {
        let Common { scale, work, zero, .. } = *common;
        let kernel = self.kernel;
        let slot = &self.task.slots[self.block.first + k];
        let own = Of::<M, I>::own(slot);
        let kind = if TYPES == ONE { 0 } else { M::Slot::kind(slot) };
        let columns = kernel.columns(kind);
        let mut totals = Totals { force: [zero; 3], energy: zero, virial: [zero; 6], nearest: Real::constant(1e300) };
        for index in row.chunks_exact(Of::<M, I>::COUNT) {
            let (d, kinds) = Of::<M, I>::differences(own, self.tile, index);
            let r2 = if M::Slot::FIXED {
                d[2].mul_add(d[2], d[1].mul_add(d[1], d[0] * d[0])) * scale
            } else {
                // In LAMMPS's order of operations: rounding decides at the cutoff.
                d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
            };
            let of_kinds;
            let constants = if TYPES == ONE {
                &common.constants
            } else {
                let stride = if TYPES == FEW { Of::<M, I>::COUNT } else { kernel.stride };
                of_kinds = Constants::new(kernel, OfKinds::<Of<M, I>> { columns, stride, kinds });
                &of_kinds
            };
            let mut inside = r2.less(constants.squared_cutoff);
            if EXACT {
                let at = TieAt { part, task: self.task, i: self.block.first + k, index };
                inside = Of::<M, I>::mask(at.decide(Of::<M, I>::bits(inside), kernel, &self.task.list.ties));
            } else if !M::Slot::FIXED {
                let off = r2 - constants.squared_cutoff;
                totals.nearest = totals.nearest.min(off * off);
            }
            let value = T::apply(S::eval(r2, &constants.style), &constants.truncation);
            let pull = Of::<M, I>::select(inside, value.force_over_r, zero);
            for (total, d) in totals.force.iter_mut().zip(d) {
                *total = d.mul_add(pull, *total);
            }
            if SUMS {
                totals.energy = totals.energy + Of::<M, I>::select(inside, value.energy, zero);
                let products = [d[0] * d[0], d[1] * d[1], d[2] * d[2], d[0] * d[1], d[0] * d[2], d[1] * d[2]];
                let work = if M::Slot::FIXED { pull * work } else { pull };
                for (total, product) in totals.virial.iter_mut().zip(products) {
                    *total = product.mul_add(work, *total);
                }
            }
        }
        totals
    }
}

/// Pairs of one register.
struct TieAt<'a, M: Mode> {
    part: &'a Part,
    task: &'a PairTask<'a, M>,
    i: usize,
    index: &'a [u16],
}

impl<M: Mode> TieAt<'_, M> {
    /// Which lanes are inside the cutoff, as LAMMPS decides it.
    #[cold]
    fn decide<S: PairStyle, T: Truncation, I>(&self, inside: u32, kernel: &Kernel<M, S, T, I>, ties: &Ties) -> u32 {
        let mut inside = inside;
        for (lane, slot) in self.index.iter().enumerate() {
            if u32::from(*slot) >= self.part.slots {
                continue;
            }
            let (j, image) = self.part.particle(*slot);
            let (a, b) = (&self.task.slots[self.i], &self.task.slots[j]);
            let limit = kernel.squared_cutoffs[M::Slot::kind(a) * kernel.types + M::Slot::kind(b)];
            let place = |slot: &M::Slot| Vec3::from(M::Slot::position(slot));
            let (a, b) = (place(a), place(b));
            let shift = Vec3::from_fn(|axis, _| f64::from(image[axis]) * self.task.lengths[axis]);
            let squared = (a - (b + shift)).norm_squared();
            if image != [0; 3] && is_tied(squared, limit, ties.band) != 0.0 {
                let within = ties.squared_distance(&a, &b, image) < limit;
                inside = inside & !(1 << lane) | u32::from(within) << lane;
            }
        }
        inside
    }
}
