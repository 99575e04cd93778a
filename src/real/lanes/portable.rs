//! Lanes as arrays: what the compiler makes of them for the architecture's baseline (SSE2, NEON).

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{DoubleSlot, Element, FixedSlot, Lanes, PairLanes, PositionLanes, SearchLanes, Simd, Tile, WHOLE, Work};
use crate::real::Real;

/// Four lanes of an array.
const COUNT: usize = 4;

/// The baseline.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl Simd for Portable {
    type F32 = Array<f32>;
    type F64 = Array<f64>;
    #[inline(always)]
    fn vectorize<W: Work>(self, work: W) -> W::Output {
        work.run()
    }
}

/// Numbers side by side.
#[derive(Clone, Copy, Debug)]
pub struct Array<T>([T; COUNT]);

impl<T: Copy> Array<T> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
}

macro_rules! operator {
    ($($trait:ident $name:ident)*) => {$(
        impl<T: Element> $trait for Array<T> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.zip(other, T::$name)
            }
        }
    )*};
}
operator!(Add add Sub sub Mul mul Div div);

impl<T: Element> Neg for Array<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(T::neg))
    }
}

macro_rules! real_lanes {
    ($t:ident, $bits:ident, $mantissa:expr, $bias:expr) => {
        impl Real for Array<$t> {
            type Mask = [bool; COUNT];
            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self([value as $t; COUNT])
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0.map($t::sqrt))
            }
            #[inline(always)]
            fn exp(self) -> Self {
                super::exp::exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                super::exp::ln(self)
            }
            #[inline(always)]
            fn less(self, other: Self) -> Self::Mask {
                std::array::from_fn(|k| self.0[k] < other.0[k])
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                Self(std::array::from_fn(|k| if mask[k] { yes.0[k] } else { no.0[k] }))
            }
        }

        impl Lanes for Array<$t> {
            type Element = $t;
            const COUNT: usize = COUNT;
            const SATURATES: bool = false;
            #[inline(always)]
            fn from_fn(value: impl FnMut(usize) -> $t) -> Self {
                Self(std::array::from_fn(value))
            }
            #[inline(always)]
            fn splat(value: $t) -> Self {
                Self([value; COUNT])
            }
            #[inline(always)]
            fn load(from: &[$t]) -> Self {
                Self(std::array::from_fn(|k| from[k]))
            }
            #[inline(always)]
            fn load_single(from: &[f32]) -> Self {
                Self(std::array::from_fn(|k| from[k] as $t))
            }
            #[inline(always)]
            fn load_double(from: &[f64]) -> Self {
                Self(std::array::from_fn(|k| from[k] as $t))
            }
            #[inline(always)]
            fn store(self, to: &mut [$t]) {
                to[..COUNT].copy_from_slice(&self.0);
            }
            #[inline(always)]
            fn round(self) -> Self {
                // Numbers beyond what this trick can round have no digits after the point, but exp never asks for them.
                let whole = 1.5 / $t::EPSILON;
                Self(self.0.map(|x| (x + whole) - whole))
            }
            #[inline(always)]
            fn times_power_of_two(self, n: Self) -> Self {
                // One factor of two goes to the other number, so that results near the largest come out.
                let power = |n: $t| $t::from_bits(((n as i32).wrapping_add($bias - 1) as $bits) << $mantissa);
                Self(std::array::from_fn(|k| (self.0[k] + self.0[k]) * power(n.0[k])))
            }
            #[inline(always)]
            fn split(self) -> (Self, Self) {
                let exponent = |x: $t| (x.to_bits() >> $mantissa) as i32 - $bias;
                let significand = |x: $t| $t::from_bits(x.to_bits() & ((1 << $mantissa) - 1) | $bias << $mantissa);
                (Self(self.0.map(|x| exponent(x) as $t)), Self(self.0.map(significand)))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.zip(other, |a, b| if a > b { a } else { b })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                self.zip(other, |a, b| if a < b { a } else { b })
            }
            #[inline(always)]
            fn sum(self) -> $t {
                (self.0[0] + self.0[2]) + (self.0[1] + self.0[3])
            }
            #[inline(always)]
            fn largest(self) -> $t {
                self.0.into_iter().fold($t::NEG_INFINITY, $t::max)
            }
            #[inline(always)]
            fn bits(mask: Self::Mask) -> u32 {
                (0..COUNT).map(|k| u32::from(mask[k]) << k).sum()
            }
            #[inline(always)]
            fn mask(bits: u32) -> Self::Mask {
                std::array::from_fn(|k| bits >> k & 1 == 1)
            }
        }
    };
}
real_lanes!(f32, u32, 23, 127);
real_lanes!(f64, u64, 52, 1023);

impl PairLanes for Array<f32> {
    type Slot = FixedSlot;
    type Own = FixedSlot;
    type Kinds = [i32; COUNT];
    #[inline(always)]
    fn own(slot: &FixedSlot) -> FixedSlot {
        *slot
    }
    #[inline(always)]
    fn differences(own: FixedSlot, tile: &Tile<FixedSlot>, index: &[u16]) -> ([Self; 3], Self::Kinds) {
        let slots: [&FixedSlot; COUNT] = std::array::from_fn(|k| &tile[index[k] as usize]);
        let axis = |a: usize| Self(std::array::from_fn(|k| own[a].wrapping_sub(slots[k][a]) as f32));
        ([axis(0), axis(1), axis(2)], slots.map(|s| s[3]))
    }
    #[inline(always)]
    fn coefficient(column: &[f32], kinds: Self::Kinds) -> Self {
        Self(kinds.map(|kind| column[kind as usize]))
    }
}

impl PairLanes for Array<f64> {
    type Slot = DoubleSlot;
    type Own = DoubleSlot;
    type Kinds = [u64; COUNT];
    #[inline(always)]
    fn own(slot: &DoubleSlot) -> DoubleSlot {
        *slot
    }
    #[inline(always)]
    fn differences(own: DoubleSlot, tile: &Tile<DoubleSlot>, index: &[u16]) -> ([Self; 3], Self::Kinds) {
        let slots: [&DoubleSlot; COUNT] = std::array::from_fn(|k| &tile[index[k] as usize]);
        let axis = |a: usize| Self(std::array::from_fn(|k| own.x[a] - slots[k].x[a]));
        ([axis(0), axis(1), axis(2)], slots.map(|s| s.kind))
    }
    #[inline(always)]
    fn coefficient(column: &[f64], kinds: Self::Kinds) -> Self {
        Self(kinds.map(|kind| column[kind as usize]))
    }
}

impl SearchLanes for Array<f32> {
    #[inline(always)]
    fn fixed_differences(own: i32, from: &[i32]) -> Self {
        Self(std::array::from_fn(|k| own.wrapping_sub(from[k]) as f32))
    }
    #[inline(always)]
    fn compress(first: u16, bits: u32, to: &mut [u16]) {
        let mut n = 0;
        for k in 0..COUNT {
            to[n] = first + k as u16;
            n += (bits >> k & 1) as usize;
        }
    }
}

impl PositionLanes for Array<f64> {
    #[inline(always)]
    fn fixed_slots(quanta: [Self; 3], kinds: &[u32], to: &mut [FixedSlot]) {
        let whole = |x: f64| (x + WHOLE).to_bits() as i32;
        for k in 0..COUNT {
            to[k] = [whole(quanta[0].0[k]), whole(quanta[1].0[k]), whole(quanta[2].0[k]), kinds[k] as i32];
        }
    }
}
