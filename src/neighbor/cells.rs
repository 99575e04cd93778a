//! Occupied cells: particles sorted by (cell, octant, part of the octant, id), and where each octant's run starts.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::plan::Sort;
use super::radix::Digits;
use super::{Grid, Key};
use crate::system::Vec3;
use crate::system::parallel::{self, Pieces};

/// Octants of a cell: bit 0 the upper half along x, bit 1 along y, bit 2 along z.
pub const OCTANTS: usize = 8;

/// Where the grid has at most this many cells a particle, particles are counted into a dense table of cells (the paper asks to
/// store occupied cells only; beyond this, memory would follow the volume).
const DENSE_CELLS_PER_PARTICLE: u64 = 4;

/// Most cells of a dense table for so many particles.
pub fn most_dense_cells(particles: usize) -> u64 {
    DENSE_CELLS_PER_PARTICLE * particles as u64 + 64
}

/// Particles that are counted as one piece at least, and most pieces: each has a table of its own.
const PIECE: usize = 16_384;
const MOST_PIECES: usize = 16;

/// Octants that are sorted as one piece of work.
const OCTANTS_A_PIECE: usize = 256;

const EMPTY: u32 = u32::MAX;

/// Particles in cell order. All arrays are reused from build to build.
#[derive(Debug, Default)]
pub struct Cells {
    /// Cell hashes of occupied cells, ascending.
    hashes: Vec<u64>,
    /// First particle of each octant of each occupied cell; one more entry closes the last.
    starts: Vec<u32>,
    /// Index into `hashes` by cell hash, `EMPTY` where there is none; no entries where the grid is too large for a table.
    table: Vec<u32>,
    /// Sort key by index before sorting.
    keys: Vec<Key>,
    /// Index before sorting, by place.
    order: Vec<u32>,
    /// The same while particles are dealt out.
    dealt: Vec<AtomicU32>,
    /// For each piece of particles the next place in each octant of the grid.
    next: Vec<u32>,
    /// Used where the grid has no table.
    entries: Vec<Entry>,
    /// Used where the plan asks for a radix sort.
    digits: Digits,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    key: Key,
    id: u32,
    index: u32,
}

/// Some octants and their particles.
struct Octants<'a> {
    starts: &'a [u32],
    order: &'a mut [u32],
}

impl Pieces for Octants<'_> {
    fn split(self, at: usize) -> (Self, Self) {
        let (low, high) = self.starts.split_at(at);
        let (order, rest) = self.order.split_at_mut((high[0] - low[0]) as usize);
        (Self { starts: low, order }, Self { starts: high, order: rest })
    }
    fn count(&self) -> usize {
        self.starts.len()
    }
}

impl Cells {
    /// Sorts particles at `x` by (key, id) and indexes the cells.
    pub fn build(&mut self, grid: &Grid, sort: Sort, x: &[Vec3], id: &[u32]) {
        let count = x.len();
        self.keys.resize(count, Key::default());
        self.keys.par_iter_mut().with_min_len(4096).zip(x).for_each(|(to, x)| *to = grid.key(x));
        self.hashes.clear();
        self.starts.clear();
        self.table.clear();
        self.order.resize(count, 0);
        let hashes = grid.hashes();
        let dense = hashes <= most_dense_cells(count);
        match sort {
            Sort::Radix => self.sort_by_digits(hashes, dense, id),
            Sort::Counting if dense => self.sort_by_counting(hashes as usize, id),
            Sort::Counting => self.sort_by_comparing(id),
        }
    }

    /// Counts the particles of each octant of the grid, deals them out, and sorts the few of each octant.
    fn sort_by_counting(&mut self, cells: usize, id: &[u32]) {
        let (count, octants) = (self.keys.len(), cells * OCTANTS);
        let pieces = (count / PIECE).clamp(1, MOST_PIECES);
        let size = count.div_ceil(pieces).max(1);
        self.next.clear();
        self.next.resize(pieces * octants, 0);
        let keys = &self.keys;
        self.next.par_chunks_mut(octants.max(1)).zip(keys.par_chunks(size)).for_each(|(next, keys)| {
            keys.iter().for_each(|key| next[key.octant as usize] += 1);
        });
        self.table.resize(cells, EMPTY);
        let mut place = 0;
        for cell in 0..cells {
            let first = self.starts.len();
            let begin = place;
            for octant in cell * OCTANTS..(cell + 1) * OCTANTS {
                self.starts.push(place);
                for piece in 0..pieces {
                    place += std::mem::replace(&mut self.next[piece * octants + octant], place);
                }
            }
            if place == begin {
                self.starts.truncate(first);
            } else {
                self.table[cell] = self.hashes.len() as u32;
                self.hashes.push(cell as u64);
            }
        }
        self.starts.push(place);
        self.dealt.resize_with(count, AtomicU32::default);
        let dealt = &self.dealt;
        let deal = |(piece, (next, keys)): (usize, (&mut [u32], &[Key]))| {
            for (k, key) in keys.iter().enumerate() {
                let to = &mut next[key.octant as usize];
                dealt[*to as usize].store((piece * size + k) as u32, Ordering::Relaxed);
                *to += 1;
            }
        };
        self.next.par_chunks_mut(octants.max(1)).zip(keys.par_chunks(size)).enumerate().for_each(deal);
        self.sort_octants(id);
    }

    /// Sorts what was dealt to each octant: little is out of order, since particles come in the order of the last build.
    fn sort_octants(&mut self, id: &[u32]) {
        let (dealt, keys) = (&self.dealt, &self.keys);
        let rank = |k: u32| (keys[k as usize].part, id[k as usize]);
        let sort = |_: usize, Octants { starts, order }: Octants<'_>| {
            let first = starts[0];
            for (to, from) in order.iter_mut().zip(&dealt[first as usize..]) {
                *to = from.load(Ordering::Relaxed);
            }
            for (k, start) in starts.iter().enumerate() {
                let end = starts.get(k + 1).map_or(order.len(), |e| (e - first) as usize);
                let octant = &mut order[(start - first) as usize..end];
                if !octant.is_sorted_by_key(|k| rank(*k)) {
                    octant.sort_unstable_by_key(|k| rank(*k));
                }
            }
        };
        let octants = Octants { starts: &self.starts, order: &mut self.order };
        parallel::each(octants, OCTANTS_A_PIECE, &sort, &|(), ()| ());
    }

    /// Sorts without a table: for grids that are mostly empty.
    fn sort_by_comparing(&mut self, id: &[u32]) {
        self.entries.resize(self.keys.len(), Entry::default());
        let keys = &self.keys;
        self.entries.par_iter_mut().with_min_len(4096).enumerate().for_each(|(index, entry)| {
            *entry = Entry { key: keys[index], id: id[index], index: index as u32 };
        });
        self.entries.par_sort_unstable();
        let entries = std::mem::take(&mut self.entries);
        for (to, entry) in self.order.iter_mut().zip(&entries) {
            *to = entry.index;
        }
        self.index(entries.iter().map(|entry| entry.key.octant));
        self.entries = entries;
    }

    /// Sorts by the digits of the octants' numbers; the table is kept where the grid is small enough.
    fn sort_by_digits(&mut self, hashes: u64, dense: bool, id: &[u32]) {
        let (count, mut digits) = (self.keys.len(), std::mem::take(&mut self.digits));
        digits.sort(&self.keys, hashes.saturating_mul(OCTANTS as u64));
        self.dealt.resize_with(count, AtomicU32::default);
        self.dealt.par_iter_mut().with_min_len(4096).enumerate().for_each(|(k, to)| *to.get_mut() = digits.get(k).1);
        self.index((0..count).map(|k| digits.get(k).0));
        self.digits = digits;
        if dense {
            self.table.resize(hashes as usize, EMPTY);
            for (k, hash) in self.hashes.iter().enumerate() {
                self.table[*hash as usize] = k as u32;
            }
        }
        self.sort_octants(id);
    }

    /// Cells, and where their octants start, of particles in the order of their octants.
    fn index(&mut self, octants: impl ExactSizeIterator<Item = u64>) {
        let count = octants.len() as u32;
        for (slot, octant) in (0..).zip(octants) {
            let hash = octant / OCTANTS as u64;
            if self.hashes.last() != Some(&hash) {
                self.close_cell(slot);
                self.hashes.push(hash);
            }
            let octant = (octant % OCTANTS as u64) as usize;
            while self.starts.len() <= (self.hashes.len() - 1) * OCTANTS + octant {
                self.starts.push(slot);
            }
        }
        self.close_cell(count);
        self.starts.push(count);
    }

    /// The last cell's octants that have no particle start where it ends.
    fn close_cell(&mut self, slot: u32) {
        while self.starts.len() < self.hashes.len() * OCTANTS {
            self.starts.push(slot);
        }
    }

    /// Number of occupied cells.
    pub fn len(&self) -> usize {
        self.hashes.len()
    }

    pub fn is_empty(&self) -> bool {
        self.hashes.is_empty()
    }

    /// Hash of occupied cell `k`.
    pub fn hash(&self, k: usize) -> u64 {
        self.hashes[k]
    }

    /// Index of an occupied cell.
    #[inline]
    pub fn find(&self, hash: u64) -> Option<usize> {
        if self.table.is_empty() {
            return self.hashes.binary_search(&hash).ok();
        }
        match self.table[hash as usize] {
            EMPTY => None,
            k => Some(k as usize),
        }
    }

    /// Sorted particles of an octant, as a range.
    #[inline]
    pub fn octant(&self, k: usize, octant: usize) -> (u32, u32) {
        let at = k * OCTANTS + octant;
        (self.starts[at], self.starts[at + 1])
    }

    /// Sorted particles of a cell, as a range.
    pub fn cell(&self, k: usize) -> (u32, u32) {
        (self.starts[k * OCTANTS], self.starts[(k + 1) * OCTANTS])
    }

    /// Part of its octant that the particle now at a place is in.
    pub fn part(&self, place: u32) -> u8 {
        self.keys[self.order[place as usize] as usize].part
    }

    /// Index before sorting of the particle now at each place.
    pub fn sources(&self) -> &[u32] {
        &self.order
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.hashes.capacity() * 8
            + (self.starts.capacity() + self.table.capacity() + self.order.capacity()) * 4
            + (self.dealt.capacity() + self.next.capacity()) * 4
            + self.keys.capacity() * size_of::<Key>()
            + self.entries.capacity() * size_of::<Entry>()
            + self.digits.bytes()
    }
}
