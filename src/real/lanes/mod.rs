//! Numbers in the lanes of vector registers: the [`Real`] of the CPU engine.
//!
//! One binary is fast everywhere: each instruction set has a file of its own, [`Isa::detect`] finds the best one of the
//! processor, and work that is written over [`Simd`] is compiled for all of them. Lanes are only made inside
//! [`Simd::vectorize`], which switches the instruction set on for everything inlined into it; `unsafe` stays in these files.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod exp;
mod portable;
#[cfg(target_arch = "x86_64")]
mod vector;

use std::fmt;

use super::Real;

/// Slots that a 16-bit index can reach: tiles have this many, so no index needs a check.
pub const SLOTS: usize = 1 << 16;

/// A tile: particles that a block of particles interacts with, in the form that pair arithmetic reads.
pub type Tile<S> = [S; SLOTS];

/// A particle in 32-bit fixed point, modulo 2^32 quanta, and its type (from 0): differences of near particles are exact in
/// integers wherever the box lies, and half the size of doubles.
pub type FixedSlot = [i32; 4];

/// A particle in double precision. Aligned, so that none lies across two cache lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct DoubleSlot {
    /// Length units.
    pub x: [f64; 3],
    /// Type, from 0.
    pub kind: u64,
}

/// A number type in memory.
pub trait Element: Real<Mask = bool> + Default + PartialOrd + fmt::Debug {
    /// The nearest number of this type.
    fn of(value: f64) -> Self;
    /// The same value in double precision.
    fn double(self) -> f64;
    /// `L::COUNT` numbers from `from`, in the lanes' own type.
    fn lanes<L: Lanes>(from: &[Self]) -> L;
}

impl Element for f32 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn double(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn lanes<L: Lanes>(from: &[Self]) -> L {
        L::load_single(from)
    }
}

impl Element for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn double(self) -> f64 {
        self
    }
    #[inline(always)]
    fn lanes<L: Lanes>(from: &[Self]) -> L {
        L::load_double(from)
    }
}

/// As many numbers as a register holds. Slices that are loaded or stored have at least [`Lanes::COUNT`] entries; the first
/// ones are meant.
pub trait Lanes: Real {
    type Element: Element;
    const COUNT: usize;

    /// Lane k holds `value(k)`.
    fn from_fn(value: impl FnMut(usize) -> Self::Element) -> Self;
    fn splat(value: Self::Element) -> Self;
    fn load(from: &[Self::Element]) -> Self;
    /// Loads and converts.
    fn load_single(from: &[f32]) -> Self;
    /// Loads and converts.
    fn load_double(from: &[f64]) -> Self;
    fn store(self, to: &mut [Self::Element]);
    /// Nearest whole numbers.
    fn round(self) -> Self;
    /// [`Lanes::times_power_of_two`] gives 0 or infinity where the result is out of range.
    const SATURATES: bool;
    /// Times two to the power of a whole number; right where the result is a normal number and n below 1024 (f32: 128), or
    /// everywhere.
    fn times_power_of_two(self, n: Self) -> Self;
    /// Whole n and m from 1 to 2 with m 2^n this number, of positive normal numbers.
    fn split(self) -> (Self, Self);
    /// The larger of two numbers, where neither is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller of two numbers, where neither is NaN.
    fn min(self, other: Self) -> Self;
    /// Sum over the lanes, always in the same order.
    fn sum(self) -> Self::Element;
    /// Sums of three at once, each as [`Lanes::sum`] has it or in another fixed order.
    #[inline(always)]
    fn sums(three: [Self; 3]) -> [Self::Element; 3] {
        [three[0].sum(), three[1].sum(), three[2].sum()]
    }
    /// The largest lane, where none is NaN.
    fn largest(self) -> Self::Element;
    /// One bit a lane, lane 0 lowest.
    fn bits(mask: Self::Mask) -> u32;
    /// The mask with these bits.
    fn mask(bits: u32) -> Self::Mask;
    /// `column[index[k]]` in lane k. A column of at most [`Lanes::COUNT`] entries that are looked up is best filled up to that
    /// length: it fits into a register.
    #[inline(always)]
    fn lookup(column: &[Self::Element], index: &[u32]) -> Self {
        Self::from_fn(|k| column[index[k] as usize])
    }
}

/// Lanes of pairs: one particle against as many others.
pub trait PairLanes: Lanes {
    /// A particle in a tile.
    type Slot: Copy + Default + Send + Sync + 'static;
    /// One particle in all lanes.
    type Own: Copy;
    /// Types of the others.
    type Kinds: Copy;
    fn own(slot: &Self::Slot) -> Self::Own;
    /// Own position minus the positions in the slots that `index` names, in units of the slots, and the types there.
    fn differences(own: Self::Own, tile: &Tile<Self::Slot>, index: &[u16]) -> ([Self; 3], Self::Kinds);
    /// A coefficient by type. A column of at most [`Lanes::COUNT`] types is padded to that length.
    fn coefficient(column: &[Self::Element], kinds: Self::Kinds) -> Self;
}

/// Lanes of the list build: fixed-point coordinates, one array an axis.
pub trait SearchLanes: Lanes<Element = f32> {
    /// `own - from[k]` in lane k, modulo 2^32, as a float.
    fn fixed_differences(own: i32, from: &[i32]) -> Self;
    /// Writes `first + k` for every lane k whose bit is set to the beginning of `to`, ascending; `to` has room for
    /// [`Lanes::COUNT`] entries, the rest of which are overwritten.
    fn compress(first: u16, bits: u32, to: &mut [u16]);
}

/// Lanes that positions come from.
pub trait PositionLanes: Lanes<Element = f64> {
    /// Fixed-point slots of particles whose coordinates, in quanta, are below 2^51: nearest whole numbers modulo 2^32.
    fn fixed_slots(quanta: [Self; 3], kinds: &[u32], to: &mut [FixedSlot]);
}

/// What makes whole numbers of doubles below 2^51: after this is added, they stand in the low bits.
const WHOLE: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52

/// An instruction set: lanes for both number types.
pub trait Simd: Copy + Send + Sync + 'static {
    type F32: PairLanes<Slot = FixedSlot> + SearchLanes;
    type F64: PairLanes<Slot = DoubleSlot> + PositionLanes;
    /// Does the work with the instruction set switched on.
    fn vectorize<W: Work>(self, work: W) -> W::Output;
}

/// Work for [`Simd::vectorize`]; `run` is to be `#[inline(always)]`, or it is compiled without the instruction set.
pub trait Work {
    type Output;
    fn run(self) -> Self::Output;
}

/// An instruction set by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Isa {
    /// What every processor of the architecture has.
    Portable,
    /// x86-64 with AVX2 and FMA: 8 single or 4 double precision lanes.
    Avx2,
    /// x86-64 with AVX-512 (F, VL, DQ, BW): 16 or 8 lanes.
    Avx512,
}

impl Isa {
    pub const ALL: [Isa; 3] = [Isa::Portable, Isa::Avx2, Isa::Avx512];

    pub fn name(self) -> &'static str {
        ["portable", "avx2", "avx512"][self as usize]
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|isa| isa.name() == name)
    }

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return match self {
            Isa::Portable => true,
            Isa::Avx2 => avx2::Avx2::detect().is_some(),
            Isa::Avx512 => avx512::Avx512::detect().is_some(),
        };
        #[cfg(not(target_arch = "x86_64"))]
        return self == Isa::Portable;
    }

    /// The best that this processor has.
    pub fn detect() -> Self {
        Self::ALL.into_iter().rfind(|isa| isa.is_available()).unwrap_or(Isa::Portable)
    }
}

/// Something to be done for one instruction set, whose type is chosen at run time.
pub trait SimdVisitor {
    type Output;
    fn visit<I: Simd>(self, simd: I) -> Self::Output;
}

/// Calls the visitor with an instruction set; with the portable one where the processor lacks it.
pub fn with_simd<V: SimdVisitor>(isa: Isa, visitor: V) -> V::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if let (Isa::Avx512, Some(simd)) = (isa, avx512::Avx512::detect()) {
            return visitor.visit(simd);
        }
        if let (Isa::Avx2, Some(simd)) = (isa, avx2::Avx2::detect()) {
            return visitor.visit(simd);
        }
    }
    let _ = isa;
    visitor.visit(portable::Portable)
}

#[cfg(test)]
mod tests;
