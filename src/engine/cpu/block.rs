//! Blocks of the list: consecutive particles, and the tiles of particles they interact with.
//!
//! A tile is a copy of the octants that the particles of a block look into, periodic shifts applied, so a row of the list is
//! 16-bit places in it. A row holds exactly the particle's neighbors; it is filled up to whole registers with a slot that is
//! out of every cutoff.

use crate::neighbor::{Cells, Grid, OCTANTS, Run};
use crate::real::lanes::SLOTS;

/// Particles of a block at least (the last may have fewer). Blocks are cut by cells, never by threads, so that sums over
/// blocks are the same for any number of threads.
const BLOCK: u32 = 256;

/// Particles of a block at most, but for those of its last octant: a crowded cell is cut between octants.
const CROWDED: u32 = 4 * BLOCK;

/// Cells of a block span at most this many along each axis: fixed-point coordinates must reach all of its tile.
pub const SPAN: i64 = 4;

/// Slots of a tile that particles may take: one stays for the slot that fills rows up, and room for a full set of lanes.
const ROOM: u32 = SLOTS as u32 - 32;

/// Particles of a cell's octant that look into the same cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unit {
    /// Occupied cell, and octant of it.
    pub cell: usize,
    pub octant: u8,
    /// Bits of the axes along which their own cell is enough.
    pub middle: u8,
    pub first: u32,
    pub end: u32,
}

/// Consecutive particles that a tile holds in one periodic image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileRun {
    pub run: Run,
    /// Slot of its first particle.
    pub slot: u32,
}

/// A tile and the rows that refer to it.
#[derive(Clone, Debug, Default)]
pub struct Part {
    pub runs: Vec<TileRun>,
    /// Slots taken by `runs`; the next one fills rows up.
    pub slots: u32,
    /// Neighbors of each particle of the block.
    pub lengths: Vec<u32>,
    /// Slots of the neighbors, row after row, each row filled up to whole registers.
    pub entries: Vec<u16>,
    /// Entries in use; the rest is room for the next build.
    pub used: usize,
    /// Some run is seen in another image.
    pub images: bool,
}

/// The particle in a slot of the tile that `runs` lay out, and its image.
pub fn particle_of(runs: &[TileRun], slot: u16) -> (usize, [i32; 3]) {
    let k = runs.partition_point(|r| r.slot <= u32::from(slot)) - 1;
    let TileRun { run, slot: first } = runs[k];
    ((run.start + u32::from(slot) - first) as usize, run.image)
}

impl Part {
    fn clear(&mut self) {
        self.runs.clear();
        self.lengths.clear();
        (self.slots, self.used, self.images) = (0, 0, false);
    }

    fn add(&mut self, run: Run) {
        self.images |= run.image != [0; 3];
        let slot = self.slots;
        self.slots += run.end - run.start;
        match self.runs.last_mut() {
            Some(last) if last.run.end == run.start && last.run.image == run.image => last.run.end = run.end,
            _ => self.runs.push(TileRun { run, slot }),
        }
    }

    /// The particle in a slot, and its image.
    pub fn particle(&self, slot: u16) -> (usize, [i32; 3]) {
        particle_of(&self.runs, slot)
    }

    /// The slots of particles `start..end` in an image, a stretch at a time.
    pub fn slots_of(&self, wanted: &Run, mut look: impl FnMut(u32, u32)) {
        let key = |r: &Run| (r.image != [0; 3], r.image, r.end);
        let mut k = self.runs.partition_point(|r| key(&r.run) <= (wanted.image != [0; 3], wanted.image, wanted.start));
        while let Some(TileRun { run, slot }) = self.runs.get(k).filter(|r| r.run.image == wanted.image) {
            let (start, end) = (wanted.start.max(run.start), wanted.end.min(run.end));
            if start >= end {
                return;
            }
            look(slot + start - run.start, slot + end - run.start);
            k += 1;
        }
    }

    /// Calls `look` with the entries of each row, as many as the particle has neighbors.
    pub fn for_each_row(&self, lanes: usize, mut look: impl FnMut(usize, &[u16])) {
        let mut begin = 0;
        for (k, length) in self.lengths.iter().enumerate() {
            let length = *length as usize;
            look(k, &self.entries[begin..begin + length]);
            begin += length.next_multiple_of(lanes);
        }
    }
}

/// The rows of consecutive particles.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// First particle and one past the last.
    pub first: usize,
    pub end: usize,
    pub units: Vec<Unit>,
    parts: Vec<Part>,
    count: usize,
}

impl Block {
    /// Tiles in use: one, but where particles crowd.
    pub fn parts(&self) -> &[Part] {
        &self.parts[..self.count]
    }

    /// Starts anew at a particle.
    fn start(&mut self, first: u32) {
        (self.first, self.end, self.count) = (first as usize, first as usize, 0);
        self.units.clear();
    }

    /// Lays out the tiles. `runs` is scratch.
    pub fn lay_out(&mut self, grid: &Grid, cells: &Cells, runs: &mut Vec<Run>) {
        runs.clear();
        for unit in &self.units {
            grid.runs(cells, grid.unhash(cells.hash(unit.cell)), unit.octant, unit.middle, runs);
        }
        // Own image first: the block's own particles then are one stretch of slots.
        runs.sort_unstable_by_key(|r| (r.image != [0; 3], r.image, r.start));
        runs.dedup();
        self.count = 0;
        self.next_part();
        for run in runs.iter() {
            let mut rest = *run;
            while rest.start < rest.end {
                let mut room = ROOM - self.parts[self.count - 1].slots;
                if room == 0 {
                    self.next_part();
                    room = ROOM;
                }
                let end = rest.end.min(rest.start + room);
                self.parts[self.count - 1].add(Run { end, ..rest });
                rest.start = end;
            }
        }
    }

    fn next_part(&mut self) {
        if self.count == self.parts.len() {
            self.parts.push(Part::default());
        }
        self.parts[self.count].clear();
        self.count += 1;
    }

    /// Parts to be filled, and the units whose rows they hold.
    pub fn parts_mut(&mut self) -> (&mut [Part], &[Unit]) {
        (&mut self.parts[..self.count], &self.units)
    }

    pub fn bytes(&self) -> usize {
        let part =
            |p: &Part| p.entries.capacity() * 2 + p.lengths.capacity() * 4 + p.runs.capacity() * size_of::<TileRun>();
        self.parts.iter().map(part).sum::<usize>() + self.units.capacity() * size_of::<Unit>() + size_of::<Self>()
    }
}

/// Cuts the occupied cells into blocks; returns how many there are. Blocks of the last build are used again.
pub fn cut(blocks: &mut Vec<Block>, grid: &Grid, cells: &Cells) -> usize {
    let mut count = 0;
    let mut origin = [0; 3];
    let mut open = false;
    for cell in 0..cells.len() {
        let at = grid.unhash(cells.hash(cell));
        let near = (0..3).all(|axis| (at[axis] - origin[axis]).abs() < SPAN);
        let full = open && {
            let block: &Block = &blocks[count - 1];
            block.end - block.first >= BLOCK as usize
        };
        open &= near && !full;
        for octant in 0..OCTANTS {
            let (first, end) = cells.octant(cell, octant);
            if first == end {
                continue;
            }
            if !open {
                if count == blocks.len() {
                    blocks.push(Block::default());
                }
                blocks[count].start(first);
                count += 1;
                origin = at;
            }
            let block = &mut blocks[count - 1];
            let unit = |first, end| {
                let middle = if grid.midplane { cells.part(first) } else { 0 };
                Unit { cell, octant: octant as u8, middle, first, end }
            };
            let mut from = first;
            for k in (first + 1..end).filter(|k| grid.midplane && cells.part(*k) != cells.part(k - 1)) {
                block.units.push(unit(from, k));
                from = k;
            }
            block.units.push(unit(from, end));
            block.end = end as usize;
            open = block.end - block.first < CROWDED as usize;
        }
    }
    count
}
