//! AVX-512: particles in slots, searches among them, and their making. The safety of the blocks is that of the lanes'
//! own file.

use std::arch::x86_64::*;

use super::super::{DoubleSlot, FixedSlot, Lanes, PairLanes, PositionLanes, SearchLanes, Tile, WHOLE};
use super::{F32, F64};

/// Four slots in the quarters of a register.
#[inline(always)]
fn quarters(tile: &Tile<FixedSlot>, index: [u16; 4]) -> __m512i {
    let slot = index.map(|k| (&raw const tile[k as usize]).cast());
    unsafe {
        let a = _mm512_castsi128_si512(_mm_loadu_si128(slot[0]));
        let b = _mm512_inserti32x4::<1>(a, _mm_loadu_si128(slot[1]));
        let c = _mm512_inserti32x4::<2>(b, _mm_loadu_si128(slot[2]));
        _mm512_inserti32x4::<3>(c, _mm_loadu_si128(slot[3]))
    }
}

/// Two slots in the halves of a register.
#[inline(always)]
fn halves(tile: &Tile<DoubleSlot>, first: u16, second: u16) -> __m512d {
    unsafe {
        let low = _mm256_load_pd((&raw const tile[first as usize]).cast());
        let high = _mm256_load_pd((&raw const tile[second as usize]).cast());
        _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)
    }
}

impl PairLanes for F32 {
    type Slot = FixedSlot;
    type Own = [__m512i; 3];
    type Kinds = __m512i;
    #[inline(always)]
    fn own(slot: &FixedSlot) -> Self::Own {
        unsafe { [_mm512_set1_epi32(slot[0]), _mm512_set1_epi32(slot[1]), _mm512_set1_epi32(slot[2])] }
    }
    #[inline(always)]
    fn differences(own: Self::Own, tile: &Tile<FixedSlot>, index: &[u16]) -> ([Self; 3], Self::Kinds) {
        let index = &index[..16];
        // Lane k of the result is particle k: quarter q of the r-th register holds particle 4 q + r.
        let a = quarters(tile, [index[0], index[4], index[8], index[12]]);
        let b = quarters(tile, [index[1], index[5], index[9], index[13]]);
        let c = quarters(tile, [index[2], index[6], index[10], index[14]]);
        let d = quarters(tile, [index[3], index[7], index[11], index[15]]);
        unsafe {
            let (ab, cd) = (_mm512_unpacklo_epi32(a, b), _mm512_unpacklo_epi32(c, d));
            let (ab_high, cd_high) = (_mm512_unpackhi_epi32(a, b), _mm512_unpackhi_epi32(c, d));
            let x = _mm512_unpacklo_epi64(ab, cd);
            let y = _mm512_unpackhi_epi64(ab, cd);
            let z = _mm512_unpacklo_epi64(ab_high, cd_high);
            let kinds = _mm512_unpackhi_epi64(ab_high, cd_high);
            let dx = Self(_mm512_cvtepi32_ps(_mm512_sub_epi32(own[0], x)));
            let dy = Self(_mm512_cvtepi32_ps(_mm512_sub_epi32(own[1], y)));
            let dz = Self(_mm512_cvtepi32_ps(_mm512_sub_epi32(own[2], z)));
            ([dx, dy, dz], kinds)
        }
    }
    #[inline(always)]
    fn coefficient(column: &[f32], kinds: Self::Kinds) -> Self {
        if column.len() == Self::COUNT {
            return unsafe { Self(_mm512_permutexvar_ps(kinds, Self::load(column).0)) };
        }
        let mut index = [0u32; 16];
        unsafe { _mm512_storeu_si512(index.as_mut_ptr().cast(), kinds) };
        Self::lookup(column, &index)
    }
}

impl PairLanes for F64 {
    type Slot = DoubleSlot;
    type Own = [__m512d; 3];
    type Kinds = __m512i;
    #[inline(always)]
    fn own(slot: &DoubleSlot) -> Self::Own {
        unsafe { [_mm512_set1_pd(slot.x[0]), _mm512_set1_pd(slot.x[1]), _mm512_set1_pd(slot.x[2])] }
    }
    #[inline(always)]
    fn differences(own: Self::Own, tile: &Tile<DoubleSlot>, index: &[u16]) -> ([Self; 3], Self::Kinds) {
        let index = &index[..8];
        let (a, b) = (halves(tile, index[0], index[4]), halves(tile, index[1], index[5]));
        let (c, d) = (halves(tile, index[2], index[6]), halves(tile, index[3], index[7]));
        unsafe {
            let (xz_ab, yk_ab) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
            let (xz_cd, yk_cd) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
            let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
            let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
            let x = _mm512_permutex2var_pd(xz_ab, low, xz_cd);
            let y = _mm512_permutex2var_pd(yk_ab, low, yk_cd);
            let z = _mm512_permutex2var_pd(xz_ab, high, xz_cd);
            let kinds = _mm512_castpd_si512(_mm512_permutex2var_pd(yk_ab, high, yk_cd));
            let dx = Self(_mm512_sub_pd(own[0], x));
            let dy = Self(_mm512_sub_pd(own[1], y));
            let dz = Self(_mm512_sub_pd(own[2], z));
            ([dx, dy, dz], kinds)
        }
    }
    #[inline(always)]
    fn coefficient(column: &[f64], kinds: Self::Kinds) -> Self {
        if column.len() == Self::COUNT {
            return unsafe { Self(_mm512_permutexvar_pd(kinds, Self::load(column).0)) };
        }
        let mut index = [0u64; 8];
        unsafe { _mm512_storeu_si512(index.as_mut_ptr().cast(), kinds) };
        Self::from_fn(|k| column[index[k] as usize])
    }
}

impl SearchLanes for F32 {
    #[inline(always)]
    fn fixed_differences(own: i32, from: &[i32]) -> Self {
        let from = &from[..16];
        unsafe {
            let others = _mm512_loadu_si512(from.as_ptr().cast());
            Self(_mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_set1_epi32(own), others)))
        }
    }
    #[inline(always)]
    fn compress(first: u16, bits: u32, to: &mut [u16]) {
        let to = &mut to[..16];
        unsafe {
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let all = _mm512_add_epi32(lanes, _mm512_set1_epi32(first.into()));
            let chosen = _mm512_maskz_compress_epi32(bits as u16, all);
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm512_cvtepi32_epi16(chosen));
        }
    }
}

/// The low words of whole numbers.
#[inline(always)]
fn whole(x: F64) -> __m256i {
    unsafe { _mm512_cvtepi64_epi32(_mm512_castpd_si512(_mm512_add_pd(x.0, _mm512_set1_pd(WHOLE)))) }
}

impl PositionLanes for F64 {
    #[inline(always)]
    fn fixed_slots(quanta: [Self; 3], kinds: &[u32], to: &mut [FixedSlot]) {
        let (kinds, to) = (&kinds[..8], &mut to[..8]);
        unsafe {
            let (x, y, z) = (whole(quanta[0]), whole(quanta[1]), whole(quanta[2]));
            let kinds = _mm256_loadu_si256(kinds.as_ptr().cast());
            let (xy, zk) = (_mm256_unpacklo_epi32(x, y), _mm256_unpacklo_epi32(z, kinds));
            let (xy_high, zk_high) = (_mm256_unpackhi_epi32(x, y), _mm256_unpackhi_epi32(z, kinds));
            // Register r holds particles r and r + 4.
            let rows = [
                _mm256_unpacklo_epi64(xy, zk),
                _mm256_unpackhi_epi64(xy, zk),
                _mm256_unpacklo_epi64(xy_high, zk_high),
                _mm256_unpackhi_epi64(xy_high, zk_high),
            ];
            for (r, row) in rows.into_iter().enumerate() {
                _mm_storeu_si128((&raw mut to[r]).cast(), _mm256_castsi256_si128(row));
                _mm_storeu_si128((&raw mut to[r + 4]).cast(), _mm256_extracti128_si256::<1>(row));
            }
        }
    }
}
