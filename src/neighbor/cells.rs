//! Occupied cells: particles sorted by (cell, octant), and where each octant's run starts.

use rayon::prelude::*;

/// Octants of a cell: bit 0 the upper half along x, bit 1 along y, bit 2 along z.
pub const OCTANTS: usize = 8;

/// A dense table is kept where the grid has at most this many cells a particle (the paper asks to store occupied cells only;
/// beyond this, memory would follow the volume).
const DENSE_CELLS_PER_PARTICLE: u64 = 4;

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
    /// (key, id, index before sorting), sorted.
    entries: Vec<Entry>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    key: u64,
    id: u32,
    index: u32,
}

impl Cells {
    /// Sorts particles `0..keys.len()` by (key, id) and indexes the cells.
    pub fn build(&mut self, count: usize, cells: u64, key: impl Fn(usize) -> u64 + Sync, id: &[u32]) {
        self.entries.resize(count, Entry::default());
        self.entries.par_iter_mut().with_min_len(4096).enumerate().for_each(|(index, entry)| {
            *entry = Entry { key: key(index), id: id[index], index: index as u32 };
        });
        // Between builds few particles change octant, and the array is almost in order already.
        self.entries.par_sort_unstable();
        self.index(cells);
    }

    fn index(&mut self, cells: u64) {
        self.hashes.clear();
        self.starts.clear();
        let mut next = 0; // octant slots written so far, counted over all occupied cells
        for (slot, entry) in self.entries.iter().enumerate() {
            let hash = entry.key / OCTANTS as u64;
            if self.hashes.last() != Some(&hash) {
                while self.starts.len() < self.hashes.len() * OCTANTS {
                    self.starts.push(slot as u32);
                }
                next = self.starts.len();
                self.hashes.push(hash);
            }
            let octant = (entry.key % OCTANTS as u64) as usize;
            while self.starts.len() <= next + octant {
                self.starts.push(slot as u32);
            }
        }
        while self.starts.len() <= self.hashes.len() * OCTANTS {
            self.starts.push(self.entries.len() as u32);
        }
        self.table.clear();
        if cells <= DENSE_CELLS_PER_PARTICLE * self.entries.len() as u64 + 64 {
            self.table.resize(cells as usize, EMPTY);
            for (k, hash) in self.hashes.iter().enumerate() {
                self.table[*hash as usize] = k as u32;
            }
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

    /// Index before sorting of the particle now at each place.
    pub fn sources(&self) -> impl IndexedParallelIterator<Item = u32> + '_ {
        self.entries.par_iter().with_min_len(4096).map(|e| e.index)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.hashes.capacity() * 8
            + (self.starts.capacity() + self.table.capacity()) * 4
            + self.entries.capacity() * size_of::<Entry>()
    }
}
