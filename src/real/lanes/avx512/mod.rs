//! AVX-512: 16 single or 8 double precision lanes.
//!
//! Safety of every block here: the intrinsics need AVX-512 F, VL, DQ and BW (and AVX2, FMA and the bit instructions, which come with them). Lanes
//! are only made by work that [`Avx512::vectorize`] runs, and an [`Avx512`] only exists where detection found all of them.
//! Loads and stores go through slices whose length is checked, or through references.

mod slots;

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Lanes, Simd, Work};
use crate::real::Real;

/// Proof that the processor has what this file uses.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

impl Avx512 {
    pub fn detect() -> Option<Self> {
        let found = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("popcnt")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        found.then_some(Self(()))
    }
}

#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,popcnt,bmi1,bmi2")]
fn with_features<W: Work>(work: W) -> W::Output {
    work.run()
}

impl Simd for Avx512 {
    type F32 = F32;
    type F64 = F64;
    #[inline(always)]
    fn vectorize<W: Work>(self, work: W) -> W::Output {
        // SAFETY: `self` proves that detection found the features.
        unsafe { with_features(work) }
    }
}

#[derive(Clone, Copy)]
pub struct F32(__m512);
#[derive(Clone, Copy)]
pub struct F64(__m512d);

macro_rules! lanes {
    ($name:ident, $t:ident, $count:literal, $mask:ident, $set1:ident, $load:ident, $store:ident, $add:ident, $sub:ident,
     $mul:ident, $div:ident, $sqrt:ident, $fmadd:ident, $cmp:ident, $blend:ident, $round:ident, $scale:ident, $max:ident, $min:ident,
     $rsqrt:ident, $fnmadd:ident, $steps:literal, $sum:ident, $largest:ident) => {
        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, b: Self) -> Self {
                unsafe { Self($add(self.0, b.0)) }
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, b: Self) -> Self {
                unsafe { Self($sub(self.0, b.0)) }
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, b: Self) -> Self {
                unsafe { Self($mul(self.0, b.0)) }
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, b: Self) -> Self {
                unsafe { Self($div(self.0, b.0)) }
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::constant(-0.0) - self
            }
        }

        impl Real for $name {
            type Mask = $mask;
            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self::splat(value as $t)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                unsafe { Self($sqrt(self.0)) }
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
            fn less(self, other: Self) -> $mask {
                unsafe { $cmp::<_CMP_LT_OQ>(self.0, other.0) }
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                unsafe { Self($blend(mask, no.0, yes.0)) }
            }
            #[inline(always)]
            fn recip(self) -> Self {
                estimate::$t(self)
            }
            /// An estimate of 14 bits, doubled by each Newton step.
            #[inline(always)]
            fn rsqrt(self) -> Self {
                let (half, three_halves) = (Self::constant(0.5), Self::constant(1.5));
                unsafe {
                    let mut y = $rsqrt(self.0);
                    let h = $mul(self.0, half.0);
                    for _ in 0..$steps {
                        y = $mul(y, $fnmadd($mul(h, y), y, three_halves.0));
                    }
                    Self(y)
                }
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                unsafe { Self($fmadd(self.0, a.0, b.0)) }
            }
        }

        impl Lanes for $name {
            type Element = $t;
            const COUNT: usize = $count;
            const SATURATES: bool = true;
            #[inline(always)]
            fn from_fn(value: impl FnMut(usize) -> $t) -> Self {
                let values: [$t; $count] = std::array::from_fn(value);
                Self::load(&values)
            }
            #[inline(always)]
            fn splat(value: $t) -> Self {
                unsafe { Self($set1(value)) }
            }
            #[inline(always)]
            fn load(from: &[$t]) -> Self {
                let from = &from[..$count];
                unsafe { Self($load(from.as_ptr())) }
            }
            #[inline(always)]
            fn load_single(from: &[f32]) -> Self {
                load_single::$t(&from[..$count])
            }
            #[inline(always)]
            fn load_double(from: &[f64]) -> Self {
                load_double::$t(&from[..$count])
            }
            #[inline(always)]
            fn store(self, to: &mut [$t]) {
                let to = &mut to[..$count];
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn round(self) -> Self {
                unsafe { Self($round::<0>(self.0)) }
            }
            #[inline(always)]
            fn times_power_of_two(self, n: Self) -> Self {
                unsafe { Self($scale(self.0, n.0)) }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                unsafe { Self($max(self.0, other.0)) }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                unsafe { Self($min(self.0, other.0)) }
            }
            #[inline(always)]
            fn sum(self) -> $t {
                unsafe { $sum(self.0) }
            }
            #[inline(always)]
            fn sums(three: [Self; 3]) -> [$t; 3] {
                sums::$t(three)
            }
            #[inline(always)]
            fn largest(self) -> $t {
                unsafe { $largest(self.0) }
            }
            #[inline(always)]
            fn lookup(column: &[$t], index: &[u32]) -> Self {
                lookup::$t(column, index)
            }
            #[inline(always)]
            fn bits(mask: $mask) -> u32 {
                mask.into()
            }
            #[inline(always)]
            fn mask(bits: u32) -> $mask {
                bits as $mask
            }
        }
    };
}

lanes!(
    F32,
    f32,
    16,
    __mmask16,
    _mm512_set1_ps,
    _mm512_loadu_ps,
    _mm512_storeu_ps,
    _mm512_add_ps,
    _mm512_sub_ps,
    _mm512_mul_ps,
    _mm512_div_ps,
    _mm512_sqrt_ps,
    _mm512_fmadd_ps,
    _mm512_cmp_ps_mask,
    _mm512_mask_blend_ps,
    _mm512_roundscale_ps,
    _mm512_scalef_ps,
    _mm512_max_ps,
    _mm512_min_ps,
    _mm512_rsqrt14_ps,
    _mm512_fnmadd_ps,
    1,
    _mm512_reduce_add_ps,
    _mm512_reduce_max_ps
);
lanes!(
    F64,
    f64,
    8,
    __mmask8,
    _mm512_set1_pd,
    _mm512_loadu_pd,
    _mm512_storeu_pd,
    _mm512_add_pd,
    _mm512_sub_pd,
    _mm512_mul_pd,
    _mm512_div_pd,
    _mm512_sqrt_pd,
    _mm512_fmadd_pd,
    _mm512_cmp_pd_mask,
    _mm512_mask_blend_pd,
    _mm512_roundscale_pd,
    _mm512_scalef_pd,
    _mm512_max_pd,
    _mm512_min_pd,
    _mm512_rsqrt14_pd,
    _mm512_fnmadd_pd,
    2,
    _mm512_reduce_add_pd,
    _mm512_reduce_max_pd
);

/// Reciprocals, named by the type of the lanes.
mod estimate {
    use super::*;
    /// An estimate of 14 bits and a Newton step.
    #[inline(always)]
    pub fn f32(x: F32) -> F32 {
        unsafe {
            let y = _mm512_rcp14_ps(x.0);
            F32(_mm512_mul_ps(y, _mm512_fnmadd_ps(x.0, y, _mm512_set1_ps(2.0))))
        }
    }
    /// Division: two Newton steps take longer.
    #[inline(always)]
    pub fn f64(x: F64) -> F64 {
        F64::constant(1.0) / x
    }
}

/// Look-ups, named by the type of the lanes: within a register where the column fits into one.
mod lookup {
    use super::*;
    #[inline(always)]
    pub fn f32(column: &[f32], index: &[u32]) -> F32 {
        let index = &index[..16];
        if column.len() == 16 {
            return unsafe {
                let index = _mm512_loadu_si512(index.as_ptr().cast());
                F32(_mm512_permutexvar_ps(index, F32::load(column).0))
            };
        }
        F32::from_fn(|k| column[index[k] as usize])
    }
    #[inline(always)]
    pub fn f64(column: &[f64], index: &[u32]) -> F64 {
        let index = &index[..8];
        if column.len() == 8 {
            return unsafe {
                let index = _mm512_cvtepu32_epi64(_mm256_loadu_si256(index.as_ptr().cast()));
                F64(_mm512_permutexvar_pd(index, F64::load(column).0))
            };
        }
        F64::from_fn(|k| column[index[k] as usize])
    }
}

/// Sums of three, named by the type of the lanes.
mod sums {
    use super::*;
    #[inline(always)]
    fn fold_single(x: F32) -> __m256 {
        unsafe { _mm256_add_ps(_mm512_castps512_ps256(x.0), _mm512_extractf32x8_ps::<1>(x.0)) }
    }
    #[inline(always)]
    fn fold_double(x: F64) -> __m256d {
        unsafe { _mm256_add_pd(_mm512_castpd512_pd256(x.0), _mm512_extractf64x4_pd::<1>(x.0)) }
    }
    #[inline(always)]
    pub fn f32([x, y, z]: [F32; 3]) -> [f32; 3] {
        super::super::avx2::sums_single([fold_single(x), fold_single(y), fold_single(z)])
    }
    #[inline(always)]
    pub fn f64([x, y, z]: [F64; 3]) -> [f64; 3] {
        super::super::avx2::sums_double([fold_double(x), fold_double(y), fold_double(z)])
    }
}

/// Converting loads, named by the type of the lanes; slices are long enough.
mod load_single {
    use super::*;
    #[inline(always)]
    pub fn f32(from: &[f32]) -> F32 {
        F32::load(from)
    }
    #[inline(always)]
    pub fn f64(from: &[f32]) -> F64 {
        let from = &from[..8];
        unsafe { F64(_mm512_cvtps_pd(_mm256_loadu_ps(from.as_ptr()))) }
    }
}
mod load_double {
    use super::*;
    #[inline(always)]
    pub fn f32(from: &[f64]) -> F32 {
        let (low, high) = (F64::load(from), F64::load(&from[8..]));
        unsafe {
            let low = _mm512_castps256_ps512(_mm512_cvtpd_ps(low.0));
            F32(_mm512_insertf32x8::<1>(low, _mm512_cvtpd_ps(high.0)))
        }
    }
    #[inline(always)]
    pub fn f64(from: &[f64]) -> F64 {
        F64::load(from)
    }
}
