//! Radix sort of particles by the octants they are in, the last digit first (the sort that Morillo et al. 2015 take from a library,
//! after Satish, Harris and Garland 2009, doi:10.1109/IPDPS.2009.5161005).

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use rayon::prelude::*;

use super::Key;

/// Bits of a digit.
const BITS: u32 = 8;
const DIGITS: usize = 1 << BITS;

/// Particles that are counted as one piece at least, and most pieces.
const PIECE: usize = 16_384;
const MOST_PIECES: usize = 16;

/// Numbers of octants and places, before and after a digit is sorted by; kept from build to build.
#[derive(Debug, Default)]
pub struct Digits {
    sides: [Side; 2],
    /// For each piece the next place of each digit.
    next: Vec<u32>,
    /// The side that is sorted.
    sorted: usize,
}

#[derive(Debug, Default)]
struct Side {
    octants: Vec<AtomicU64>,
    places: Vec<AtomicU32>,
}

impl Digits {
    /// Sorts all keys by octant, whose numbers are below `bound`. Those of the same octant stay in their order.
    pub fn sort(&mut self, keys: &[Key], bound: u64) {
        for side in &mut self.sides {
            side.octants.resize_with(keys.len(), AtomicU64::default);
            side.places.resize_with(keys.len(), AtomicU32::default);
        }
        self.sorted = 0;
        let Side { octants, places } = &self.sides[0];
        keys.par_iter().zip(octants).zip(places).with_min_len(4096).enumerate().for_each(
            |(k, ((key, octant), place))| {
                octant.store(key.octant, Ordering::Relaxed);
                place.store(k as u32, Ordering::Relaxed);
            },
        );
        let bits = u64::BITS - bound.saturating_sub(1).leading_zeros();
        for digit in 0..bits.div_ceil(BITS) {
            self.sort_by(digit * BITS);
        }
    }

    /// Sorts by the digit that begins at a bit.
    fn sort_by(&mut self, bit: u32) {
        let Self { sides, next, sorted } = self;
        let [from, to] = [&sides[*sorted], &sides[1 - *sorted]];
        let count = from.octants.len();
        let pieces = (count / PIECE).clamp(1, MOST_PIECES);
        let size = count.div_ceil(pieces).max(1);
        let digit = |octant: u64| (octant >> bit) as usize & (DIGITS - 1);
        next.clear();
        next.resize(pieces * DIGITS, 0);
        next.par_chunks_mut(DIGITS).zip(from.octants.par_chunks(size)).for_each(|(next, octants)| {
            octants.iter().for_each(|octant| next[digit(octant.load(Ordering::Relaxed))] += 1);
        });
        let mut place = 0;
        for digit in 0..DIGITS {
            for piece in 0..pieces {
                place += std::mem::replace(&mut next[piece * DIGITS + digit], place);
            }
        }
        let from = from.octants.par_chunks(size).zip(from.places.par_chunks(size));
        next.par_chunks_mut(DIGITS).zip(from).for_each(|(next, (octants, places))| {
            for (octant, k) in octants.iter().zip(places) {
                let octant = octant.load(Ordering::Relaxed);
                let at = &mut next[digit(octant)];
                to.octants[*at as usize].store(octant, Ordering::Relaxed);
                to.places[*at as usize].store(k.load(Ordering::Relaxed), Ordering::Relaxed);
                *at += 1;
            }
        });
        *sorted = 1 - *sorted;
    }

    /// Octant and place before sorting of what is now in place `k`.
    #[inline]
    pub fn get(&self, k: usize) -> (u64, u32) {
        let Side { octants, places } = &self.sides[self.sorted];
        (octants[k].load(Ordering::Relaxed), places[k].load(Ordering::Relaxed))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.sides.iter().map(|side| side.octants.capacity() * 8 + side.places.capacity() * 4).sum::<usize>()
            + self.next.capacity() * 4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_sorted_and_equal_ones_keep_their_order() {
        let mut digits = Digits::default();
        // One piece and several; one digit and several, not all of them in use; more and then fewer.
        for (count, bound) in [(100_000, 1 << 20), (1000, 7), (50_000, 1 << 40), (3, 256), (0, 1)] {
            let octant = |k: u64| (k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20) % bound / 3 * 3;
            let keys: Vec<Key> = (0..count).map(|k| Key { octant: octant(k), part: 0 }).collect();
            digits.sort(&keys, bound);
            let found: Vec<(u64, u32)> = (0..keys.len()).map(|k| digits.get(k)).collect();
            let mut expected: Vec<(u64, u32)> = keys.iter().zip(0..).map(|(key, k)| (key.octant, k)).collect();
            expected.sort_unstable();
            assert_eq!(found, expected);
        }
    }
}
