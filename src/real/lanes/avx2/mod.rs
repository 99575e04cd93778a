//! AVX2 with FMA: 8 single or 4 double precision lanes.
//!
//! Safety of every block here: the intrinsics need AVX2 and FMA (the bit instructions come with them). Lanes are only made by work that [`Avx2::vectorize`] runs,
//! and an [`Avx2`] only exists where detection found them. Loads and stores go through slices whose length is checked, or
//! through references.

mod slots;

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::vector::vector_lanes;
use super::{Lanes, Simd, Work};
use crate::real::Real;

/// Proof that the processor has what this file uses.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    pub fn detect() -> Option<Self> {
        let found = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("popcnt")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        found.then_some(Self(()))
    }
}

#[target_feature(enable = "avx2,fma,popcnt,bmi1,bmi2")]
fn with_features<W: Work>(work: W) -> W::Output {
    work.run()
}

impl Simd for Avx2 {
    type F32 = F32;
    type F64 = F64;
    #[inline(always)]
    fn vectorize<W: Work>(self, work: W) -> W::Output {
        // SAFETY: `self` proves that detection found the features.
        unsafe { with_features(work) }
    }
}

#[derive(Clone, Copy)]
pub struct F32(__m256);
#[derive(Clone, Copy)]
pub struct F64(__m256d);

vector_lanes!(
    F32: f32 x 8, mask __m256, saturates false, set _mm256_set1_ps, load _mm256_loadu_ps, store _mm256_storeu_ps, add _mm256_add_ps,
    sub _mm256_sub_ps, mul _mm256_mul_ps, div _mm256_div_ps, sqrt _mm256_sqrt_ps, fmadd _mm256_fmadd_ps, compare _mm256_cmp_ps, max _mm256_max_ps, min _mm256_min_ps
);
vector_lanes!(
    F64: f64 x 4, mask __m256d, saturates false, set _mm256_set1_pd, load _mm256_loadu_pd, store _mm256_storeu_pd, add _mm256_add_pd,
    sub _mm256_sub_pd, mul _mm256_mul_pd, div _mm256_div_pd, sqrt _mm256_sqrt_pd, fmadd _mm256_fmadd_pd, compare _mm256_cmp_pd, max _mm256_max_pd, min _mm256_min_pd
);

/// Choices, named by the type of the lanes.
mod select {
    use super::*;
    #[inline(always)]
    pub fn f32(mask: __m256, yes: F32, no: F32) -> F32 {
        unsafe { F32(_mm256_blendv_ps(no.0, yes.0, mask)) }
    }
    #[inline(always)]
    pub fn f64(mask: __m256d, yes: F64, no: F64) -> F64 {
        unsafe { F64(_mm256_blendv_pd(no.0, yes.0, mask)) }
    }
}

/// To the nearest, without exceptions.
const NEAREST: i32 = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;

/// Nearest whole numbers, named by the type of the lanes.
mod round {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> F32 {
        unsafe { F32(_mm256_round_ps::<NEAREST>(x.0)) }
    }
    #[inline(always)]
    pub fn f64(x: F64) -> F64 {
        unsafe { F64(_mm256_round_pd::<NEAREST>(x.0)) }
    }
}

/// A bit a lane, named by the type of the lanes.
mod bits {
    use super::*;
    #[inline(always)]
    pub fn f32(mask: __m256) -> u32 {
        unsafe { _mm256_movemask_ps(mask) as u32 }
    }
    #[inline(always)]
    pub fn f64(mask: __m256d) -> u32 {
        unsafe { _mm256_movemask_pd(mask) as u32 }
    }
}

/// Masks from bits, named by the type of the lanes. The sign decides in every use of a mask.
mod mask {
    use super::*;
    #[inline(always)]
    pub fn f32(bits: u32) -> __m256 {
        F32::from_fn(|k| if bits >> k & 1 == 1 { -1.0 } else { 0.0 }).0
    }
    #[inline(always)]
    pub fn f64(bits: u32) -> __m256d {
        F64::from_fn(|k| if bits >> k & 1 == 1 { -1.0 } else { 0.0 }).0
    }
}

/// Sums of all lanes, named by the type of the lanes.
mod sum {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> f32 {
        fold::f32(x, |a, b| a + b)
    }
    #[inline(always)]
    pub fn f64(x: F64) -> f64 {
        fold::f64(x, |a, b| a + b)
    }
}

/// The largest lane, named by the type of the lanes.
mod largest {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> f32 {
        fold::f32(x, f32::max)
    }
    #[inline(always)]
    pub fn f64(x: F64) -> f64 {
        fold::f64(x, f64::max)
    }
}

/// Sums of the lanes of three registers, side by side.
#[inline(always)]
pub fn sums_single([x, y, z]: [__m256; 3]) -> [f32; 3] {
    let mut to = [0.0; 4];
    unsafe {
        let pairs = _mm256_hadd_ps(_mm256_hadd_ps(x, y), _mm256_hadd_ps(z, z));
        let sum = _mm_add_ps(_mm256_castps256_ps128(pairs), _mm256_extractf128_ps::<1>(pairs));
        _mm_storeu_ps(to.as_mut_ptr(), sum);
    }
    [to[0], to[1], to[2]]
}

/// Sums of the lanes of three registers, side by side.
#[inline(always)]
pub fn sums_double([x, y, z]: [__m256d; 3]) -> [f64; 3] {
    unsafe {
        let (xy, zz) = (_mm256_hadd_pd(x, y), _mm256_hadd_pd(z, z));
        let xy = _mm_add_pd(_mm256_castpd256_pd128(xy), _mm256_extractf128_pd::<1>(xy));
        let zz = _mm_add_pd(_mm256_castpd256_pd128(zz), _mm256_extractf128_pd::<1>(zz));
        [_mm_cvtsd_f64(xy), _mm_cvtsd_f64(_mm_unpackhi_pd(xy, xy)), _mm_cvtsd_f64(zz)]
    }
}

/// Look-ups, named by the type of the lanes: within a register where the column fits into one.
mod lookup {
    use super::*;
    #[inline(always)]
    pub fn f32(column: &[f32], index: &[u32]) -> F32 {
        let index = &index[..8];
        if column.len() == 8 {
            return unsafe {
                let index = _mm256_loadu_si256(index.as_ptr().cast());
                F32(_mm256_permutevar8x32_ps(F32::load(column).0, index))
            };
        }
        F32::from_fn(|k| column[index[k] as usize])
    }
    #[inline(always)]
    pub fn f64(column: &[f64], index: &[u32]) -> F64 {
        F64::from_fn(|k| column[index[k] as usize])
    }
}

/// Sums of three, named by the type of the lanes.
mod sums {
    use super::*;
    #[inline(always)]
    pub fn f32([x, y, z]: [F32; 3]) -> [f32; 3] {
        sums_single([x.0, y.0, z.0])
    }
    #[inline(always)]
    pub fn f64([x, y, z]: [F64; 3]) -> [f64; 3] {
        sums_double([x.0, y.0, z.0])
    }
}

/// Reciprocals, named by the type of the lanes: for f32 an estimate of 12 bits and its correction to third order. A Newton step
/// would leave every result too small by up to a rounding, and a twelfth power by six.
mod recip {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> F32 {
        unsafe {
            let y = _mm256_rcp_ps(x.0);
            let e = _mm256_fnmadd_ps(x.0, y, _mm256_set1_ps(1.0));
            F32(_mm256_fmadd_ps(y, _mm256_fmadd_ps(e, e, e), y))
        }
    }
    #[inline(always)]
    pub fn f64(x: F64) -> F64 {
        F64::constant(1.0) / x
    }
}

/// Reciprocal square roots, named by the type of the lanes: for f32 an estimate of 12 bits and its correction to third order.
mod rsqrt {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> F32 {
        unsafe {
            let y = _mm256_rsqrt_ps(x.0);
            let e = _mm256_fnmadd_ps(_mm256_mul_ps(x.0, y), y, _mm256_set1_ps(1.0));
            let more = _mm256_mul_ps(e, _mm256_fmadd_ps(e, _mm256_set1_ps(0.375), _mm256_set1_ps(0.5)));
            F32(_mm256_fmadd_ps(y, more, y))
        }
    }
    #[inline(always)]
    pub fn f64(x: F64) -> F64 {
        F64::constant(1.0) / x.sqrt()
    }
}

/// Times 2^n, named by the type of the lanes. One factor of two goes to the other number, so that results near the largest come
/// out.
mod times_power_of_two {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32, n: F32) -> F32 {
        (x + x) * power_of_two::f32(n)
    }
    #[inline(always)]
    pub fn f64(x: F64, n: F64) -> F64 {
        (x + x) * power_of_two::f64(n)
    }
}

/// 2^(n - 1) by its exponent bits, named by the type of the lanes.
mod power_of_two {
    use super::*;
    #[inline(always)]
    pub fn f32(n: F32) -> F32 {
        unsafe {
            let biased = _mm256_add_epi32(_mm256_cvtps_epi32(n.0), _mm256_set1_epi32(126));
            F32(_mm256_castsi256_ps(_mm256_slli_epi32::<23>(biased)))
        }
    }
    #[inline(always)]
    pub fn f64(n: F64) -> F64 {
        unsafe {
            let biased = _mm_add_epi32(_mm256_cvtpd_epi32(n.0), _mm_set1_epi32(1022));
            F64(_mm256_castsi256_pd(_mm256_slli_epi64::<52>(_mm256_cvtepi32_epi64(biased))))
        }
    }
}

/// Exponents and significands by their bits, named by the type of the lanes.
mod split {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32) -> (F32, F32) {
        unsafe {
            let bits = _mm256_castps_si256(x.0);
            let exponent = F32(_mm256_cvtepi32_ps(_mm256_srli_epi32::<23>(bits))) - F32::constant(127.0);
            let digits = _mm256_and_si256(bits, _mm256_set1_epi32(0x007f_ffff));
            (exponent, F32(_mm256_or_ps(_mm256_castsi256_ps(digits), _mm256_set1_ps(1.0))))
        }
    }
    #[inline(always)]
    pub fn f64(x: F64) -> (F64, F64) {
        // A whole number in the low bits of 2^52 is added to it.
        const ABOVE: f64 = 4_503_599_627_370_496.0;
        unsafe {
            let bits = _mm256_castpd_si256(x.0);
            let biased = _mm256_castsi256_pd(_mm256_srli_epi64::<52>(bits));
            let exponent = F64(_mm256_or_pd(biased, _mm256_set1_pd(ABOVE))) - F64::constant(ABOVE + 1023.0);
            let digits = _mm256_and_si256(bits, _mm256_set1_epi64x(0x000f_ffff_ffff_ffff));
            (exponent, F64(_mm256_or_pd(_mm256_castsi256_pd(digits), _mm256_set1_pd(1.0))))
        }
    }
}

/// Folds the lanes, halves first, named by the type of the lanes.
mod fold {
    use super::*;
    #[inline(always)]
    pub fn f32(x: F32, f: impl Fn(f32, f32) -> f32) -> f32 {
        let mut v = [0.0; 8];
        x.store(&mut v);
        f(f(f(v[0], v[4]), f(v[2], v[6])), f(f(v[1], v[5]), f(v[3], v[7])))
    }
    #[inline(always)]
    pub fn f64(x: F64, f: impl Fn(f64, f64) -> f64) -> f64 {
        let mut v = [0.0; 4];
        x.store(&mut v);
        f(f(v[0], v[2]), f(v[1], v[3]))
    }
}

/// Converting loads, named by the type of the lanes.
mod load_single {
    use super::*;
    #[inline(always)]
    pub fn f32(from: &[f32]) -> F32 {
        F32::load(from)
    }
    #[inline(always)]
    pub fn f64(from: &[f32]) -> F64 {
        let from = &from[..4];
        unsafe { F64(_mm256_cvtps_pd(_mm_loadu_ps(from.as_ptr()))) }
    }
}
mod load_double {
    use super::*;
    #[inline(always)]
    pub fn f32(from: &[f64]) -> F32 {
        let (low, high) = (F64::load(from), F64::load(&from[4..]));
        unsafe { F32(_mm256_set_m128(_mm256_cvtpd_ps(high.0), _mm256_cvtpd_ps(low.0))) }
    }
    #[inline(always)]
    pub fn f64(from: &[f64]) -> F64 {
        F64::load(from)
    }
}
