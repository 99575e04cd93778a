//! AVX2: particles in slots, searches among them, and their making. The safety of the blocks is that of the lanes'
//! own file.

use std::arch::x86_64::*;

use super::super::{DoubleSlot, FixedSlot, Lanes, PairLanes, PositionLanes, SearchLanes, Tile, WHOLE};
use super::{F32, F64};

/// Two slots in the halves of a register.
#[inline(always)]
fn halves(tile: &Tile<FixedSlot>, first: u16, second: u16) -> __m256i {
    unsafe {
        let low = _mm_loadu_si128((&raw const tile[first as usize]).cast());
        let high = _mm_loadu_si128((&raw const tile[second as usize]).cast());
        _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(low), high)
    }
}

impl PairLanes for F32 {
    type Slot = FixedSlot;
    type Own = [__m256i; 3];
    type Kinds = __m256i;
    #[inline(always)]
    fn own(slot: &FixedSlot) -> Self::Own {
        unsafe { [_mm256_set1_epi32(slot[0]), _mm256_set1_epi32(slot[1]), _mm256_set1_epi32(slot[2])] }
    }
    #[inline(always)]
    fn differences(own: Self::Own, tile: &Tile<FixedSlot>, index: &[u16]) -> ([Self; 3], Self::Kinds) {
        let index = &index[..8];
        let (a, b) = (halves(tile, index[0], index[4]), halves(tile, index[1], index[5]));
        let (c, d) = (halves(tile, index[2], index[6]), halves(tile, index[3], index[7]));
        unsafe {
            let (ab, cd) = (_mm256_unpacklo_epi32(a, b), _mm256_unpacklo_epi32(c, d));
            let (ab_high, cd_high) = (_mm256_unpackhi_epi32(a, b), _mm256_unpackhi_epi32(c, d));
            let x = _mm256_unpacklo_epi64(ab, cd);
            let y = _mm256_unpackhi_epi64(ab, cd);
            let z = _mm256_unpacklo_epi64(ab_high, cd_high);
            let kinds = _mm256_unpackhi_epi64(ab_high, cd_high);
            let dx = Self(_mm256_cvtepi32_ps(_mm256_sub_epi32(own[0], x)));
            let dy = Self(_mm256_cvtepi32_ps(_mm256_sub_epi32(own[1], y)));
            let dz = Self(_mm256_cvtepi32_ps(_mm256_sub_epi32(own[2], z)));
            ([dx, dy, dz], kinds)
        }
    }
    #[inline(always)]
    fn coefficient(column: &[f32], kinds: Self::Kinds) -> Self {
        if column.len() == Self::COUNT {
            return unsafe { Self(_mm256_permutevar8x32_ps(Self::load(column).0, kinds)) };
        }
        let mut index = [0u32; 8];
        unsafe { _mm256_storeu_si256(index.as_mut_ptr().cast(), kinds) };
        Self::lookup(column, &index)
    }
}

impl PairLanes for F64 {
    type Slot = DoubleSlot;
    type Own = [__m256d; 3];
    type Kinds = [u64; 4];
    #[inline(always)]
    fn own(slot: &DoubleSlot) -> Self::Own {
        unsafe { [_mm256_set1_pd(slot.x[0]), _mm256_set1_pd(slot.x[1]), _mm256_set1_pd(slot.x[2])] }
    }
    #[inline(always)]
    fn differences(own: Self::Own, tile: &Tile<DoubleSlot>, index: &[u16]) -> ([Self; 3], Self::Kinds) {
        let index = &index[..4];
        let slot: [&DoubleSlot; 4] = std::array::from_fn(|k| &tile[index[k] as usize]);
        let row = slot.map(|s| (&raw const *s).cast());
        unsafe {
            let (a, b) = (_mm256_load_pd(row[0]), _mm256_load_pd(row[1]));
            let (c, d) = (_mm256_load_pd(row[2]), _mm256_load_pd(row[3]));
            let (xz_ab, y_ab) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (xz_cd, y_cd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            let x = _mm256_permute2f128_pd::<0x20>(xz_ab, xz_cd);
            let y = _mm256_permute2f128_pd::<0x20>(y_ab, y_cd);
            let z = _mm256_permute2f128_pd::<0x31>(xz_ab, xz_cd);
            let dx = Self(_mm256_sub_pd(own[0], x));
            let dy = Self(_mm256_sub_pd(own[1], y));
            let dz = Self(_mm256_sub_pd(own[2], z));
            ([dx, dy, dz], slot.map(|s| s.kind))
        }
    }
    #[inline(always)]
    fn coefficient(column: &[f64], kinds: Self::Kinds) -> Self {
        Self::from_fn(|k| column[kinds[k] as usize])
    }
}

/// For each set of 8 lanes, the bytes of the 16-bit numbers of the chosen ones.
static CHOSEN: [[u8; 16]; 256] = {
    let mut table = [[0x80; 16]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut lane, mut place) = (0, 0);
        while lane < 8 {
            if bits >> lane & 1 == 1 {
                table[bits][2 * place] = 2 * lane;
                table[bits][2 * place + 1] = 2 * lane + 1;
                place += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    table
};

impl SearchLanes for F32 {
    #[inline(always)]
    fn fixed_differences(own: i32, from: &[i32]) -> Self {
        let from = &from[..8];
        unsafe {
            let others = _mm256_loadu_si256(from.as_ptr().cast());
            Self(_mm256_cvtepi32_ps(_mm256_sub_epi32(_mm256_set1_epi32(own), others)))
        }
    }
    #[inline(always)]
    fn compress(first: u16, bits: u32, to: &mut [u16]) {
        let to = &mut to[..8];
        unsafe {
            let all = _mm_add_epi16(_mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7), _mm_set1_epi16(first as i16));
            let chosen = _mm_loadu_si128(CHOSEN[bits as u8 as usize].as_ptr().cast());
            _mm_storeu_si128(to.as_mut_ptr().cast(), _mm_shuffle_epi8(all, chosen));
        }
    }
}

/// The low words of whole numbers.
#[inline(always)]
fn whole(x: F64) -> __m128i {
    unsafe {
        let sum = _mm256_castpd_si256(_mm256_add_pd(x.0, _mm256_set1_pd(WHOLE)));
        let low = _mm256_permutevar8x32_epi32(sum, _mm256_setr_epi32(0, 2, 4, 6, 1, 3, 5, 7));
        _mm256_castsi256_si128(low)
    }
}

impl PositionLanes for F64 {
    #[inline(always)]
    fn fixed_slots(quanta: [Self; 3], kinds: &[u32], to: &mut [FixedSlot]) {
        let (kinds, to) = (&kinds[..4], &mut to[..4]);
        unsafe {
            let (x, y, z) = (whole(quanta[0]), whole(quanta[1]), whole(quanta[2]));
            let kinds = _mm_loadu_si128(kinds.as_ptr().cast());
            let (xy, zk) = (_mm_unpacklo_epi32(x, y), _mm_unpacklo_epi32(z, kinds));
            let (xy_high, zk_high) = (_mm_unpackhi_epi32(x, y), _mm_unpackhi_epi32(z, kinds));
            let rows = [
                _mm_unpacklo_epi64(xy, zk),
                _mm_unpackhi_epi64(xy, zk),
                _mm_unpacklo_epi64(xy_high, zk_high),
                _mm_unpackhi_epi64(xy_high, zk_high),
            ];
            for (r, row) in rows.into_iter().enumerate() {
                _mm_storeu_si128((&raw mut to[r]).cast(), row);
            }
        }
    }
}
