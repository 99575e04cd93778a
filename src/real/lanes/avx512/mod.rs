//! AVX-512: 16 single or 8 double precision lanes.
//!
//! Safety of every block here: the intrinsics need AVX-512 F, VL, DQ and BW (and AVX2, FMA and the bit instructions, which
//! come with them). Lanes are only made by work that [`Avx512::vectorize`] runs, and an [`Avx512`] only exists where detection
//! found all of them. Loads and stores go through slices whose length is checked, or through references.

mod slots;

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::vector::vector_lanes;
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

vector_lanes!(
    F32: f32 x 16, mask __mmask16, saturates true, set _mm512_set1_ps, load _mm512_loadu_ps, store _mm512_storeu_ps, add _mm512_add_ps,
    sub _mm512_sub_ps, mul _mm512_mul_ps, div _mm512_div_ps, sqrt _mm512_sqrt_ps, fmadd _mm512_fmadd_ps, compare _mm512_cmp_ps_mask, max _mm512_max_ps, min _mm512_min_ps
);
vector_lanes!(
    F64: f64 x 8, mask __mmask8, saturates true, set _mm512_set1_pd, load _mm512_loadu_pd, store _mm512_storeu_pd, add _mm512_add_pd,
    sub _mm512_sub_pd, mul _mm512_mul_pd, div _mm512_div_pd, sqrt _mm512_sqrt_pd, fmadd _mm512_fmadd_pd, compare _mm512_cmp_pd_mask, max _mm512_max_pd, min _mm512_min_pd
);

/// Choices, named by the type of the lanes.
mod select {
    use super::*;
    #[inline(always)]
    pub fn f32(mask: __mmask16, yes: F32, no: F32) -> F32 {
        unsafe { F32(_mm512_mask_blend_ps(mask, no.0, yes.0)) }
    }
    #[inline(always)]
    pub fn f64(mask: __mmask8, yes: F64, no: F64) -> F64 {
        unsafe { F64(_mm512_mask_blend_pd(mask, no.0, yes.0)) }
    }
}

/// Nearest whole numbers, named by the type of the lanes.
mod round {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> F32 {
        unsafe { F32(_mm512_roundscale_ps::<0>(x.0)) }
    }
    #[inline(always)]
    pub fn f64(x: F64) -> F64 {
        unsafe { F64(_mm512_roundscale_pd::<0>(x.0)) }
    }
}

/// Times 2^n, named by the type of the lanes.
mod times_power_of_two {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32, n: F32) -> F32 {
        unsafe { F32(_mm512_scalef_ps(x.0, n.0)) }
    }
    #[inline(always)]
    pub fn f64(x: F64, n: F64) -> F64 {
        unsafe { F64(_mm512_scalef_pd(x.0, n.0)) }
    }
}

/// Exponents and significands, named by the type of the lanes.
mod split {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> (F32, F32) {
        unsafe { (F32(_mm512_getexp_ps(x.0)), F32(_mm512_getmant_ps::<_MM_MANT_NORM_1_2, _MM_MANT_SIGN_SRC>(x.0))) }
    }
    #[inline(always)]
    pub fn f64(x: F64) -> (F64, F64) {
        unsafe { (F64(_mm512_getexp_pd(x.0)), F64(_mm512_getmant_pd::<_MM_MANT_NORM_1_2, _MM_MANT_SIGN_SRC>(x.0))) }
    }
}

/// Sums of all lanes, named by the type of the lanes.
mod sum {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> f32 {
        unsafe { _mm512_reduce_add_ps(x.0) }
    }
    #[inline(always)]
    pub fn f64(x: F64) -> f64 {
        unsafe { _mm512_reduce_add_pd(x.0) }
    }
}

/// The largest lane, named by the type of the lanes.
mod largest {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> f32 {
        unsafe { _mm512_reduce_max_ps(x.0) }
    }
    #[inline(always)]
    pub fn f64(x: F64) -> f64 {
        unsafe { _mm512_reduce_max_pd(x.0) }
    }
}

/// A bit a lane, named by the type of the lanes.
mod bits {
    use super::*;
    #[inline(always)]
    pub fn f32(mask: __mmask16) -> u32 {
        mask.into()
    }
    #[inline(always)]
    pub fn f64(mask: __mmask8) -> u32 {
        mask.into()
    }
}

/// Masks from bits, named by the type of the lanes.
mod mask {
    use super::*;
    #[inline(always)]
    pub fn f32(bits: u32) -> __mmask16 {
        bits as __mmask16
    }
    #[inline(always)]
    pub fn f64(bits: u32) -> __mmask8 {
        bits as __mmask8
    }
}

/// Reciprocal square roots, named by the type of the lanes: an estimate of 14 bits, doubled by each Newton step.
mod rsqrt {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> F32 {
        let y = unsafe { F32(_mm512_rsqrt14_ps(x.0)) };
        improved(x, y)
    }
    #[inline(always)]
    pub fn f64(x: F64) -> F64 {
        let y = unsafe { F64(_mm512_rsqrt14_pd(x.0)) };
        improved(x, improved(x, y))
    }
    /// A Newton step: y (3/2 - x y^2 / 2).
    #[inline(always)]
    fn improved<L: Lanes>(x: L, y: L) -> L {
        let half = x * L::constant(-0.5);
        y * (half * y).mul_add(y, L::constant(1.5))
    }
}

/// Reciprocals, named by the type of the lanes.
mod recip {
    use super::*;
    /// An estimate of 14 bits and a Newton step.
    #[inline(always)]
    pub fn f32(x: F32) -> F32 {
        unsafe {
            let y = _mm512_rcp14_ps(x.0);
            F32(_mm512_mul_ps(y, _mm512_fnmadd_ps(x.0, y, _mm512_set1_ps(2.0))))
        }
    }
    /// Division, which is exact; an estimate and two Newton steps take as long.
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
