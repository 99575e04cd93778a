//! The full Verlet list: for each particle all neighbors within R, in runs of one periodic image.
//!
//! Membership is exact and LAMMPS's: distance at the build at most R, in f64, from the canonical positions.

use rayon::prelude::*;

use super::particles::{Particles, Site};
use super::ties::Ties;
use crate::neighbor::estimate::ListBytes;
use crate::neighbor::{Cells, Grid, OCTANTS, Run};
use crate::system::{SimulationBox, Vec3};

/// Particles a block holds at least (the last may hold fewer). Blocks are cut by cells, never by threads, so that
/// sums over blocks are the same for any number of threads.
const BLOCK: u32 = 128;

/// A stretch of one particle's row whose neighbors are all seen in one periodic image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// One past the stretch's last entry in [`Block::entries`].
    pub end: usize,
    /// Neighbors stand at x + shift.
    pub shift: [f64; 3],
}

/// For estimates of a list's size.
pub const LIST_BYTES: ListBytes = ListBytes { entry: size_of::<u32>(), stretch: size_of::<Segment>() };

/// The rows of a block of consecutive particles.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// First particle and one past the last.
    pub first: usize,
    pub end: usize,
    /// Occupied cells of the block.
    cells: (usize, usize),
    /// Neighbor places, row after row. Only `used` of them are valid: the rest is room for the next build.
    pub entries: Vec<u32>,
    used: usize,
    /// Stretches, row after row.
    pub segments: Vec<Segment>,
    /// One past each particle's last segment.
    pub rows: Vec<u32>,
}

impl Block {
    /// Entries in the rows.
    pub fn pairs(&self) -> usize {
        self.used
    }

    /// Calls `look` with (place of the particle, its stretches as (first entry, segment)).
    #[inline(always)]
    pub fn for_each_row(&self, mut look: impl FnMut(usize, &[Segment], usize)) {
        let (mut segment, mut entry) = (0, 0);
        for (k, row_end) in self.rows.iter().enumerate() {
            let stretches = &self.segments[segment..*row_end as usize];
            look(self.first + k, stretches, entry);
            segment = *row_end as usize;
            entry = stretches.last().map_or(entry, |s| s.end);
        }
    }
}

/// Squared neighbor cutoffs by pair of types, and what exactness needs to know of the box.
#[derive(Clone, Debug, Default)]
pub struct Membership {
    types: usize,
    squared: Vec<f64>,
    lengths: Vec3,
    pub ties: Ties,
}

impl Membership {
    /// `cutoffs` are the neighbor cutoffs R of each pair of types.
    pub fn new(types: usize, cutoffs: &[f64], simulation_box: &SimulationBox) -> Self {
        let squared = cutoffs.iter().map(|r| r * r).collect();
        Self { types, squared, lengths: simulation_box.lengths(), ties: Ties::new(cutoffs, simulation_box) }
    }

    #[inline(always)]
    fn limits(&self, kind: u32) -> &[f64] {
        &self.squared[kind as usize * self.types..][..self.types]
    }
}

/// All rows.
#[derive(Debug, Default)]
pub struct List {
    pub blocks: Vec<Block>,
    /// How ties at a cutoff were decided at the build.
    pub ties: Ties,
    count: usize,
}

impl List {
    /// Blocks in use.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks[..self.count]
    }

    /// Builds all rows from sorted particles.
    pub fn build(&mut self, particles: &Particles, grid: &Grid, cells: &Cells, membership: &Membership) {
        self.cut(cells);
        self.ties.clone_from(&membership.ties);
        let one_type = membership.types == 1;
        self.blocks[..self.count].par_iter_mut().for_each(|block| {
            if one_type {
                fill::<true>(block, &particles.site, grid, cells, membership);
            } else {
                fill::<false>(block, &particles.site, grid, cells, membership);
            }
        });
    }

    /// Cuts the occupied cells into blocks.
    fn cut(&mut self, cells: &Cells) {
        self.count = 0;
        let mut from = 0;
        while from < cells.len() {
            let first = cells.cell(from).0;
            let mut to = from + 1;
            while to < cells.len() && cells.cell(to - 1).1 - first < BLOCK {
                to += 1;
            }
            if self.count == self.blocks.len() {
                self.blocks.push(Block::default());
            }
            let block = &mut self.blocks[self.count];
            (block.first, block.end) = (first as usize, cells.cell(to - 1).1 as usize);
            block.cells = (from, to);
            self.count += 1;
            from = to;
        }
    }

    /// Entries of the full list.
    pub fn pairs(&self) -> u64 {
        self.blocks().iter().map(|b| b.pairs() as u64).sum()
    }

    /// Neighbors of each sorted particle.
    pub fn counts(&self) -> Vec<u32> {
        let mut counts = Vec::new();
        for block in self.blocks() {
            block.for_each_row(|_, stretches, start| {
                counts.push((stretches.last().map_or(start, |s| s.end) - start) as u32);
            });
        }
        counts
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of =
            |b: &Block| b.entries.capacity() * 4 + b.segments.capacity() * size_of::<Segment>() + b.rows.capacity() * 4;
        self.blocks.iter().map(of).sum()
    }
}

fn fill<const ONE_TYPE: bool>(block: &mut Block, site: &[Site], grid: &Grid, cells: &Cells, membership: &Membership) {
    let mut runs: Vec<Run> = Vec::new();
    let mut used = 0;
    block.segments.clear();
    block.rows.clear();
    for k in block.cells.0..block.cells.1 {
        let cell = grid.unhash(cells.hash(k));
        for octant in 0..OCTANTS {
            let (first, end) = cells.octant(k, octant);
            if first == end {
                continue;
            }
            grid.runs(cells, cell, octant as u8, &mut runs);
            let candidates: usize = runs.iter().map(|r| (r.end - r.start) as usize).sum();
            for i in first..end {
                if block.entries.len() < used + candidates {
                    block.entries.resize((used + candidates).max(2 * used), 0);
                }
                let row = &mut block.entries[used..];
                let segments = &mut block.segments;
                used += fill_row::<ONE_TYPE>(row, used, segments, site, i, &runs, membership);
                block.rows.push(segments.len() as u32);
            }
        }
    }
    block.used = used;
}

/// Fills one row, which has room for all candidates; returns its length.
#[inline(always)]
fn fill_row<const ONE_TYPE: bool>(
    row: &mut [u32],
    offset: usize,
    segments: &mut Vec<Segment>,
    site: &[Site],
    i: u32,
    runs: &[Run],
    membership: &Membership,
) -> usize {
    let own = &site[i as usize];
    let limits = membership.limits(own.kind);
    let mut length = 0;
    let mut last_image = None;
    for run in runs {
        let before = length;
        let candidates = run.start..run.end;
        let others = &site[run.start as usize..run.end as usize];
        if run.image == [0; 3] {
            for (j, other) in candidates.zip(others) {
                let limit = if ONE_TYPE { limits[0] } else { limits[other.kind as usize] };
                row[length] = j;
                length += usize::from(squared_distance(own, other, &[0.0; 3]) <= limit && j != i);
            }
        } else {
            let shift = shift(run.image, &membership.lengths);
            for (j, other) in candidates.zip(others) {
                let limit = if ONE_TYPE { limits[0] } else { limits[other.kind as usize] };
                let r2 = squared_distance(own, other, &shift);
                let mut inside = r2 <= limit;
                if (r2 - limit).abs() <= membership.ties.band * limit {
                    inside = limit > 0.0 && membership.ties.squared_distance(own, other, run.image) <= limit;
                }
                row[length] = j;
                length += usize::from(inside);
            }
        }
        if length == before {
            continue;
        }
        match segments.last_mut() {
            Some(last) if last_image == Some(run.image) => last.end = offset + length,
            _ => segments.push(Segment { end: offset + length, shift: shift(run.image, &membership.lengths) }),
        }
        last_image = Some(run.image);
    }
    length
}

/// The periodic image that a shift stands for.
pub fn image_of(shift: &[f64; 3], lengths: &Vec3) -> [i32; 3] {
    std::array::from_fn(|axis| (shift[axis] / lengths[axis]).round() as i32)
}

fn shift(image: [i32; 3], lengths: &Vec3) -> [f64; 3] {
    std::array::from_fn(|axis| image[axis] as f64 * lengths[axis])
}

/// |x_i - (x_j + shift)|^2 in LAMMPS's order of operations.
#[inline(always)]
fn squared_distance(i: &Site, j: &Site, shift: &[f64; 3]) -> f64 {
    let dx = i.x[0] - (j.x[0] + shift[0]);
    let dy = i.x[1] - (j.x[1] + shift[1]);
    let dz = i.x[2] - (j.x[2] + shift[2]);
    dx * dx + dy * dy + dz * dz
}
