//! The number type of formulas: a formula written once over [`Real`] serves every engine and the tests.
//!
//! `f64` is the reference, `f32` the arithmetic of the faster precisions, [`Dual`] carries a derivative so that each
//! force can be tested against its energy. Formulas are branch-free: choices go through [`Real::select`], so that types
//! that hold many values at once ([`lanes`]) or none ([`Expr`], which records them for the GPU) fit the same trait.

mod dual;
mod expr;
pub(crate) mod lanes;

pub use dual::Dual;
pub use expr::{Arithmetic, Expr, Recording};
pub use lanes::Isa;

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What a formula may do with a number.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// Outcome of a comparison: one truth value for each number held.
    type Mask: Copy;

    /// The same constant everywhere.
    fn constant(value: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Natural exponential.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Where `self < other`.
    fn less(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere; both are evaluated.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Reciprocal.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::constant(1.0) / self
    }
    /// Reciprocal of the square root.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        self.sqrt().recip()
    }
    /// `self * a + b`; fused where the number type has a fused form at no cost.
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
}

/// Numbers that can be cut to whole ones: what decides in which cell a particle is.
pub trait Whole: Real {
    /// The whole part, towards zero, of numbers below 2^63; others come out at least as large.
    fn trunc(self) -> Self;

    /// The smaller of two numbers.
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        Self::select(other.less(self), other, self)
    }
    /// The larger of two numbers.
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self::select(self.less(other), other, self)
    }
}

impl Whole for f64 {
    #[inline(always)]
    fn trunc(self) -> Self {
        // On the oldest processors `f64::trunc` is a call.
        self as i64 as f64
    }
}

/// Turns constants into another arithmetic, one number after the other. Closures do; in inner loops a type whose method is
/// sure to be inlined does.
pub trait Convert<A, B> {
    fn convert(&mut self, value: A) -> B;
}

impl<A, B, F: FnMut(A) -> B> Convert<A, B> for F {
    #[inline(always)]
    fn convert(&mut self, value: A) -> B {
        self(value)
    }
}

macro_rules! scalar_real {
    ($t:ident) => {
        impl Real for $t {
            type Mask = bool;
            #[inline(always)]
            fn constant(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $t::sqrt(self)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                $t::exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                $t::ln(self)
            }
            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
        }
    };
}

scalar_real!(f64);
scalar_real!(f32);
