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

/// A block that has this many particles takes no more, and a unit has no more: crowded cells and octants are cut.
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
        // Where joined runs overlap, a particle takes one slot.
        let mut laid = Run { start: 0, end: 0, image: [0; 3] };
        for run in runs.iter() {
            let start = if run.image == laid.image { run.start.max(laid.end) } else { run.start };
            let mut rest = Run { start, ..*run };
            if start >= run.end {
                continue;
            }
            laid = *run;
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
            let mut from = first;
            while from < end {
                // As far as particles look into the same cells, and as a block has room.
                let mut to = end.min(from + CROWDED);
                if grid.midplane {
                    to = (from + 1..to).find(|k| cells.part(*k) != cells.part(from)).unwrap_or(to);
                }
                if !open {
                    if count == blocks.len() {
                        blocks.push(Block::default());
                    }
                    blocks[count].start(from);
                    count += 1;
                    origin = at;
                }
                let middle = if grid.midplane { cells.part(from) } else { 0 };
                let block = &mut blocks[count - 1];
                block.units.push(Unit { cell, octant: octant as u8, middle, first: from, end: to });
                block.end = to as usize;
                open = block.end - block.first < CROWDED as usize;
                from = to;
            }
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbor::Search;
    use crate::system::{RanPark, Side, SimulationBox, Vec3};

    /// Cells of points in a cube of edge 12, half of them crowded into a corner of it.
    fn sorted(search: Search, edge: f64) -> (Grid, Cells) {
        let space = SimulationBox::new(Vec3::zeros(), Vec3::repeat(12.0), [[Side::Periodic; 2]; 3]);
        let plan = search.with_edge(edge).unwrap_or(search.plan());
        let grid = Grid::new(plan, &space, &space.lo, &space.hi, 1.0);
        let mut random = RanPark::new(9);
        let mut x = Vec::new();
        for k in 0..6000 {
            let size = if k % 2 == 0 { 12.0 } else { 0.9 };
            x.push(Vec3::from_fn(|_, _| size * random.uniform()));
        }
        let ids: Vec<u32> = (0..x.len() as u32).collect();
        let mut cells = Cells::default();
        cells.build(&grid, plan.sort(), &x, &ids);
        (grid, cells)
    }

    #[test]
    fn every_particle_is_in_one_unit_and_no_block_is_large() {
        for (search, edge) in
            [(Search::Trimmed, 2.0), (Search::Midplane, 4.0), (Search::Standard, 0.5), (Search::Brute, 1.0)]
        {
            let (grid, cells) = sorted(search, edge);
            let mut blocks = Vec::new();
            let count = cut(&mut blocks, &grid, &cells);
            let mut place = 0;
            for block in &blocks[..count] {
                assert_eq!(block.first, place as usize);
                for unit in &block.units {
                    assert!(unit.first == place && unit.first < unit.end && unit.end - unit.first <= CROWDED);
                    let (first, end) = cells.octant(unit.cell, unit.octant.into());
                    assert!(first <= unit.first && unit.end <= end);
                    let part = |k: u32| if search == Search::Midplane { cells.part(k) } else { 0 };
                    assert!((unit.first..unit.end).all(|k| part(k) == unit.middle));
                    place = unit.end;
                }
                assert!(block.end == place as usize && block.end - block.first < 2 * CROWDED as usize);
            }
            assert_eq!(place, 6000, "{search:?}");
            // Enough blocks for several threads, all in one cell too.
            assert!(count > 3, "{search:?}");
        }
    }

    #[test]
    fn a_tile_has_each_particle_once_that_a_unit_looks_at() {
        for (search, edge) in
            [(Search::Trimmed, 2.0), (Search::Octant, 4.0), (Search::Midplane, 2.52), (Search::Standard, 1.0)]
        {
            let (grid, cells) = sorted(search, edge);
            let (mut blocks, mut runs) = (Vec::new(), Vec::new());
            let count = cut(&mut blocks, &grid, &cells);
            for block in &mut blocks[..count] {
                block.lay_out(&grid, &cells, &mut runs);
                assert_eq!(block.parts().len(), 1);
                let part = &block.parts()[0];
                let mut held: Vec<(usize, [i32; 3])> = (0..part.slots).map(|slot| part.particle(slot as u16)).collect();
                held.sort_unstable();
                assert!(held.windows(2).all(|pair| pair[0] != pair[1]), "{search:?}");
                for unit in &block.units {
                    runs.clear();
                    grid.runs(&cells, grid.unhash(cells.hash(unit.cell)), unit.octant, unit.middle, &mut runs);
                    for run in &runs {
                        let mut slots = 0;
                        part.slots_of(run, |start, end| slots += end - start);
                        assert_eq!(slots, run.end - run.start, "{search:?}");
                    }
                }
            }
        }
    }
}
