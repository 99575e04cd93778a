//! The full Verlet list: for each particle all neighbors within R.
//!
//! Membership is exact and LAMMPS's: distance at the build at most R, in f64, from the positions of the build. Distances are
//! tested in lanes of f32 on fixed-point coordinates; pairs so near to R that rounding could decide are decided in f64.

use super::block::{Block, Part, SPAN, cut};
use super::membership::Membership;
use super::scratch::Pool;
use super::search::Fill;
use crate::engine::particles::Particles;
use crate::neighbor::axis::Axis;
use crate::neighbor::estimate::ListBytes;
use crate::neighbor::ties::Ties;
use crate::neighbor::{Cells, Grid};
use crate::real::Isa;
use crate::real::lanes::{FixedSlot, with_simd};
use crate::system::parallel;

/// For estimates of a list's size: an entry, and a row in one periodic image. Rows are filled up to whole registers.
pub const LIST_BYTES: ListBytes = ListBytes { entry: size_of::<u16>(), stretch: size_of::<u32>() };

/// All rows.
#[derive(Debug, Default)]
pub struct List {
    blocks: Vec<Block>,
    count: usize,
    /// How ties at a cutoff were decided at the build.
    pub ties: Ties,
    /// Rows are filled up to a multiple of this.
    pub lanes: usize,
    /// Distances tested at the last build.
    pub tests: u64,
}

/// What a build starts from.
#[derive(Clone, Copy)]
pub struct Sorted<'a> {
    pub particles: &'a Particles,
    pub fixed: &'a [FixedSlot],
    pub grid: &'a Grid,
    pub cells: &'a Cells,
}

impl List {
    /// Blocks in use.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks[..self.count]
    }

    /// Quanta in a length unit such that the tile of any block fits into 32 bits.
    pub fn quanta(grid: &Grid) -> f64 {
        let extent = |axis: &Axis| {
            let cells = axis.cells.min(SPAN) as f64;
            cells * axis.edge + axis.reach_length()
        };
        let most = grid.axes.iter().map(extent).fold(0.0, f64::max);
        // An eighth stays for rounding and for particles a little outside of their cells.
        0.875 * (1u64 << 31) as f64 / most
    }

    /// Builds all rows, each filled up to a multiple of `lanes`.
    pub fn build(&mut self, sorted: Sorted<'_>, membership: &Membership, isa: Isa, lanes: usize, pool: &Pool) {
        self.count = cut(&mut self.blocks, sorted.grid, sorted.cells);
        self.ties = membership.ties;
        self.lanes = lanes;
        let fill = |_: usize, blocks: &mut [Block]| {
            let mut tests = 0;
            for block in blocks {
                let mut scratch = pool.build();
                block.lay_out(sorted.grid, sorted.cells, &mut scratch.runs);
                tests += with_simd(isa, Fill { block, sorted, membership, lanes, scratch: &mut scratch });
            }
            tests
        };
        self.tests = parallel::each(&mut self.blocks[..self.count], 1, &fill, &|a, b| a + b);
    }

    /// Entries of the full list.
    pub fn pairs(&self) -> u64 {
        let parts = self.blocks().iter().flat_map(|b| b.parts());
        parts.flat_map(|p| &p.lengths).map(|length| u64::from(*length)).sum()
    }

    /// Calls `look` with each row: place of the particle, the part it stands in, slots of its neighbors.
    pub fn for_each_row(&self, mut look: impl FnMut(usize, &Part, &[u16])) {
        for block in self.blocks() {
            for part in block.parts() {
                part.for_each_row(self.lanes, |k, row| look(block.first + k, part, row));
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.blocks.iter().map(Block::bytes).sum()
    }
}
