//! The three precisions as types: what positions, velocities and pairs are kept and computed in.

use crate::real::lanes::{DoubleSlot, Element, FixedSlot, Lanes, PairLanes, PositionLanes, Simd, Tile};

/// Coordinates of slots beyond this, in a double, are no particle's: the slot that fills rows up.
const NOWHERE: f64 = 1.0e150;

/// A particle as pair arithmetic reads it, in a tile.
pub trait Slot: Copy + Default + Send + Sync + 'static {
    /// In fixed point; differences are in quanta, not in length units.
    const FIXED: bool;
    /// Out of every cutoff for the particles of a block whose first slot is `first`.
    fn nowhere(first: &Self) -> Self;
    /// Type, from 0.
    fn kind(&self) -> usize;
    /// Position in the slots' units.
    fn position(&self) -> [f64; 3];
    /// Moved by a periodic shift in the slots' units; the type is kept.
    fn shifted(&self, shift: &Self) -> Self;
    /// A periodic shift in the slots' units.
    fn shift(shift: &Shift) -> &Self;
    /// Slots of particles `from..` at x + origin (length units), as many as `to` has.
    fn pack<I: Simd, E: Element>(x: [&[E]; 3], origin: &[f64; 3], kinds: &[u32], quanta: f64, to: &mut [Self]);
}

/// A periodic shift for both kinds of slots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    pub fixed: FixedSlot,
    pub double: DoubleSlot,
}

impl Shift {
    /// `image` box lengths; `quanta` a length unit.
    pub fn new(image: [i32; 3], lengths: &[f64; 3], quanta: f64) -> Self {
        let mut shift = Self::default();
        for axis in 0..3 {
            let length = f64::from(image[axis]) * lengths[axis];
            shift.double.x[axis] = length;
            // Modulo 2^32; lengths so great that this saturates are left to double precision.
            shift.fixed[axis] = (length * quanta).round() as i64 as i32;
        }
        shift
    }
}

impl Slot for FixedSlot {
    const FIXED: bool = true;
    #[inline(always)]
    fn nowhere(first: &Self) -> Self {
        let opposite = |x: i32| x.wrapping_add(i32::MIN);
        [opposite(first[0]), opposite(first[1]), opposite(first[2]), 0]
    }
    #[inline(always)]
    fn kind(&self) -> usize {
        self[3] as usize
    }
    fn position(&self) -> [f64; 3] {
        [self[0].into(), self[1].into(), self[2].into()]
    }
    #[inline(always)]
    fn shifted(&self, shift: &Self) -> Self {
        std::array::from_fn(|k| self[k].wrapping_add(shift[k]))
    }
    #[inline(always)]
    fn shift(shift: &Shift) -> &Self {
        &shift.fixed
    }
    #[inline(always)]
    fn pack<I: Simd, E: Element>(x: [&[E]; 3], origin: &[f64; 3], kinds: &[u32], quanta: f64, to: &mut [Self]) {
        let (count, lanes) = (to.len(), I::F64::COUNT);
        let mut k = 0;
        while k + lanes <= count {
            let axes = [
                quanta_of::<E, I::F64>(&x[0][k..], origin[0], quanta),
                quanta_of::<E, I::F64>(&x[1][k..], origin[1], quanta),
                quanta_of::<E, I::F64>(&x[2][k..], origin[2], quanta),
            ];
            I::F64::fixed_slots(axes, &kinds[k..], &mut to[k..]);
            k += lanes;
        }
        if k < count {
            // The last few by way of a full set of lanes.
            let rest = count - k;
            let mut last = [[E::default(); 16]; 3];
            for (last, x) in last.iter_mut().zip(x) {
                last[..rest].copy_from_slice(&x[k..count]);
            }
            let mut own_kinds = [0; 16];
            own_kinds[..rest].copy_from_slice(&kinds[k..count]);
            let mut slots = [[0; 4]; 16];
            let axes = [
                quanta_of::<E, I::F64>(&last[0], origin[0], quanta),
                quanta_of::<E, I::F64>(&last[1], origin[1], quanta),
                quanta_of::<E, I::F64>(&last[2], origin[2], quanta),
            ];
            I::F64::fixed_slots(axes, &own_kinds, &mut slots);
            to[k..].copy_from_slice(&slots[..rest]);
        }
    }
}

/// Coordinates in quanta.
#[inline(always)]
fn quanta_of<E: Element, L: Lanes>(x: &[E], origin: f64, quanta: f64) -> L {
    (E::lanes::<L>(x) + L::constant(origin)) * L::constant(quanta)
}

impl Slot for DoubleSlot {
    const FIXED: bool = false;
    #[inline(always)]
    fn nowhere(_: &Self) -> Self {
        DoubleSlot { x: [NOWHERE; 3], kind: 0 }
    }
    #[inline(always)]
    fn kind(&self) -> usize {
        self.kind as usize
    }
    fn position(&self) -> [f64; 3] {
        self.x
    }
    #[inline(always)]
    fn shifted(&self, shift: &Self) -> Self {
        Self { x: std::array::from_fn(|a| self.x[a] + shift.x[a]), kind: self.kind }
    }
    #[inline(always)]
    fn shift(shift: &Shift) -> &Self {
        &shift.double
    }
    #[inline(always)]
    fn pack<I: Simd, E: Element>(x: [&[E]; 3], origin: &[f64; 3], kinds: &[u32], _: f64, to: &mut [Self]) {
        let others = x[0].iter().zip(x[1]).zip(x[2].iter().zip(kinds));
        for (slot, ((x, y), (z, kind))) in to.iter_mut().zip(others) {
            let x = [x.double() + origin[0], y.double() + origin[1], z.double() + origin[2]];
            *slot = DoubleSlot { x, kind: (*kind).into() };
        }
    }
}

/// A precision at compile time.
pub trait Mode: Copy + Default + Send + Sync + 'static {
    /// Positions are relative to the origin of the particle's cell at the last build.
    const RELATIVE: bool;
    /// Positions and velocities.
    type Store: Element;
    /// Forces and pair arithmetic.
    type Force: Element;
    type Slot: Slot;
    type StoreLanes<I: Simd>: Lanes<Element = Self::Store>;
    type PairLanes<I: Simd>: PairLanes<Element = Self::Force, Slot = Self::Slot>;
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Double;
#[derive(Clone, Copy, Debug, Default)]
pub struct Mixed;
#[derive(Clone, Copy, Debug, Default)]
pub struct Single;

impl Mode for Double {
    const RELATIVE: bool = false;
    type Store = f64;
    type Force = f64;
    type Slot = DoubleSlot;
    type StoreLanes<I: Simd> = I::F64;
    type PairLanes<I: Simd> = I::F64;
}

impl Mode for Mixed {
    const RELATIVE: bool = false;
    type Store = f64;
    type Force = f32;
    type Slot = FixedSlot;
    type StoreLanes<I: Simd> = I::F64;
    type PairLanes<I: Simd> = I::F32;
}

impl Mode for Single {
    const RELATIVE: bool = true;
    type Store = f32;
    type Force = f32;
    type Slot = FixedSlot;
    type StoreLanes<I: Simd> = I::F32;
    type PairLanes<I: Simd> = I::F32;
}

/// A tile on the heap; its pages are only taken as they are used.
pub fn new_tile<S: Slot>() -> Box<Tile<S>> {
    match vec![S::default(); crate::real::lanes::SLOTS].try_into() {
        Ok(tile) => tile,
        Err(_) => unreachable!("the vector has as many slots as a tile"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_go_around_in_fixed_point_and_keep_the_type() {
        assert_eq!([1, 2, i32::MAX, 4].shifted(&[10, -20, 1, 0]), [11, -18, i32::MIN, 4]);
        let (slot, shift) = (DoubleSlot { x: [1.0, 2.0, 3.0], kind: 9 }, DoubleSlot { x: [0.5, 0.25, -1.0], kind: 0 });
        assert_eq!(slot.shifted(&shift), DoubleSlot { x: [1.5, 2.25, 2.0], kind: 9 });
    }
}
