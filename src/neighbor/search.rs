//! The neighbor searches, one interface: which runs of sorted particles can hold the neighbors of an octant.
//!
//! All searches are one scheme with different axes: [`Search::Octant`] and [`Search::Trimmed`] look into the 2x2x2 cells on
//! the particle's side, [`Search::Midplane`] into those of them that are in reach, [`Search::Standard`] into all cells within R,
//! [`Search::Brute`] is a single cell with its images.

use std::fmt;
use std::ops::{Add, Mul};

use super::axis::{Axis, AxisRequest, Reach, Visit};
use super::cells::{Cells, OCTANTS};
use super::plan::{CellOrder, Search, SearchPlan};
use crate::system::{SimulationBox, Vec3};

/// Bits of a cell's number along an axis: three such numbers and the octant make a 64-bit key.
pub const CELL_BITS: u32 = 20;
const MOST_CELLS: i64 = 1 << CELL_BITS;

/// A contiguous run of sorted particles that may hold neighbors, and the periodic image it is seen in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    pub start: u32,
    pub end: u32,
    /// The particles stand at x + image * box lengths.
    pub image: [i32; 3],
}

/// Where a particle is sorted to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Cell hash times 8 plus octant.
    pub octant: u64,
    /// Part of the octant: place along a Z-order curve of 4 x 4 x 4 of them, or bits of the axes along which the particle needs
    /// no second cell ([`Search::Midplane`]).
    pub part: u8,
}

/// The grid: three axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    pub axes: [Axis; 3],
    /// Particles of an octant are sorted by its parts too, so that those near in memory are near in space; and the list build
    /// passes over groups of particles that are out of reach.
    pub compact: bool,
    /// Particles of an octant differ in the cells they look into; they are sorted by that.
    pub midplane: bool,
    /// In which cells follow each other.
    pub order: CellOrder,
}

impl Grid {
    /// Cuts the space that holds the particles. `low` and `high` bound them along free axes; periodic axes span the box.
    pub fn new(plan: SearchPlan, simulation_box: &SimulationBox, low: &Vec3, high: &Vec3, radius: f64) -> Self {
        let axes = std::array::from_fn(|axis| {
            let periodic = simulation_box.periodic(axis);
            let (lo, hi) =
                if periodic { (simulation_box.lo[axis], simulation_box.hi[axis]) } else { (low[axis], high[axis]) };
            let looks = plan.looks()[axis];
            Axis::new(&AxisRequest { lo, hi, periodic, radius, plan, looks, most_cells: MOST_CELLS })
        });
        Self { axes, compact: plan.is_compact(), midplane: plan.search() == Search::Midplane, order: plan.order() }
    }

    /// Cells along each axis of the box of cells that hashes number one after the other: the grid, or for a Z-order curve the
    /// cube of a power of two that holds it.
    pub fn numbered(&self) -> [u64; 3] {
        let cells = self.axes.map(|axis| axis.cells as u64);
        match self.order {
            CellOrder::Usual | CellOrder::Rows => cells,
            CellOrder::Curve => [cells.into_iter().max().unwrap_or(1).next_power_of_two(); 3],
        }
    }

    /// All hashes are smaller; it may be far more than there are particles.
    pub fn hashes(&self) -> u64 {
        self.numbered().into_iter().product()
    }

    /// The sort key of a particle: cell hash, octant, part of the octant.
    #[inline]
    pub fn key(&self, at: &Vec3) -> Key {
        let places: [(f64, f64); 3] = std::array::from_fn(|a| self.axes[a].locate(at[a]));
        let [x, y, z] = places.map(|(_, eighth)| SPREAD[eighth as usize & 7]);
        let bits = x | y << 1 | z << 2;
        let part = match (self.compact, self.midplane) {
            (true, _) => (bits & ((1 << PART_BITS) - 1)) as u8,
            (_, true) => (0..3).map(|a| u8::from(self.axes[a].is_middle(at[a])) << a).sum(),
            _ => 0,
        };
        let cell = places.map(|(cell, _)| cell as i64);
        let octant = bits >> PART_BITS & self.octants();
        Key { octant: self.hash(cell) * OCTANTS as u64 + u64::from(octant), part }
    }

    /// Bits of the axes whose cells are divided into halves: where both halves look into the same cells, they stay together.
    pub fn octants(&self) -> u32 {
        let divides = |axis: usize| self.compact || matches!(self.axes[axis].reach, Reach::Octant { .. });
        (0..3).map(|axis| u32::from(divides(axis)) << axis).sum()
    }

    /// Equation 1 of Morillo et al., `z ny nx + y nx + x`, or the place on a Z-order curve.
    #[inline]
    pub fn hash(&self, cell: [i64; 3]) -> u64 {
        let cell = cell.map(|c| c as u64);
        match self.order {
            CellOrder::Usual | CellOrder::Rows => row_major(cell, self.axes.map(|axis| axis.cells as u64)),
            CellOrder::Curve => apart(cell[0]) | apart(cell[1]) << 1 | apart(cell[2]) << 2,
        }
    }

    /// Cell coordinates of a hash.
    pub fn unhash(&self, hash: u64) -> [i64; 3] {
        if self.order == CellOrder::Curve {
            return [0, 1, 2].map(|axis| together(hash >> axis) as i64);
        }
        let [nx, ny] = [self.axes[0].cells as u64, self.axes[1].cells as u64];
        [(hash % nx) as i64, (hash / nx % ny) as i64, (hash / nx / ny) as i64]
    }

    /// Adds the runs that can hold neighbors of the particles in `octant` of `cell`, in order of z, y, x; an octant each where the
    /// grid is compact, elsewhere what lies end to end in one. `middle` has the bits of the axes along which their own cell is enough.
    pub fn runs(&self, cells: &Cells, cell: [i64; 3], octant: u8, middle: u8, runs: &mut Vec<Run>) {
        let half = |axis: usize| octant >> axis & 1;
        let own = |axis: usize| middle >> axis & 1 != 0;
        self.axes[2].visits(cell[2], half(2), own(2), |z| {
            self.axes[1].visits(cell[1], half(1), own(1), |y| {
                self.axes[0].visits(cell[0], half(0), own(0), |x| {
                    if let Some(k) = cells.find(self.hash([x.cell, y.cell, z.cell])) {
                        octant_runs(cells, k, [x, y, z], !self.compact, runs);
                    }
                });
            });
        });
    }
}

/// Number of a cell in a grid of so many cells along each axis, X fastest.
#[inline(always)]
pub fn row_major<T: Copy + Add<Output = T> + Mul<Output = T>>(cell: [T; 3], cells: [T; 3]) -> T {
    (cell[2] * cells[1] + cell[1]) * cells[0] + cell[0]
}

/// Steps in which bits are moved three places apart: how far, and which bits there are then.
pub const APART: [(u32, u64); 5] = [
    (32, 0x001f_0000_0000_ffff),
    (16, 0x001f_0000_ff00_00ff),
    (8, 0x100f_00f0_0f00_f00f),
    (4, 0x10c3_0c30_c30c_30c3),
    (2, 0x1249_2492_4924_9249),
];

/// A number of up to [`CELL_BITS`] bits with these three places apart.
#[inline(always)]
fn apart(x: u64) -> u64 {
    APART.iter().fold(x, |x, (by, mask)| (x | x << by) & mask)
}

/// The number that [`apart`] has been given; other bits than its are left out.
fn together(x: u64) -> u64 {
    let masks = APART.iter().rev().skip(1).map(|(_, mask)| *mask).chain([(1 << 21) - 1]);
    APART.iter().rev().zip(masks).fold(x & APART[4].1, |x, ((by, _), mask)| (x | x >> by) & mask)
}

/// Bits of an eighth of a cell, three places apart: interleaved with those of the other axes, X lowest, they are the part of an
/// octant along a Z-order curve of 4 x 4 x 4 and, from bit [`PART_BITS`] on, the octant.
pub const SPREAD: [u32; 8] = {
    let mut spread = [0; 8];
    let mut eighth = 0;
    while eighth < 8 {
        let e = eighth as u32;
        spread[eighth] = e & 1 | (e & 2) << 2 | (e & 4) << 4;
        eighth += 1;
    }
    spread
};

/// See [`SPREAD`].
pub const PART_BITS: u32 = 6;

/// "12 x 12 x 12 cells of edge 5.6".
impl fmt::Display for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.axes.map(|a| a.cells);
        let edges = self.axes.map(|a| a.edge);
        write!(f, "{x} x {y} x {z} cells of edges {:.4}, {:.4}, {:.4}", edges[0], edges[1], edges[2])
    }
}

/// Adds the wanted octants of occupied cell `k`, to the last run where they follow it and are to be joined.
fn octant_runs(cells: &Cells, k: usize, [x, y, z]: [Visit; 3], join: bool, runs: &mut Vec<Run>) {
    let image = [x.image, y.image, z.image];
    for octant in 0..OCTANTS {
        let wanted = x.halves >> (octant & 1) & y.halves >> (octant >> 1 & 1) & z.halves >> (octant >> 2) & 1;
        let (start, end) = cells.octant(k, octant);
        if wanted == 0 || start == end {
            continue;
        }
        match runs.last_mut() {
            Some(last) if join && last.end == start && last.image == image => last.end = end,
            _ => runs.push(Run { start, end, image }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::Side;

    #[test]
    fn hashes_are_different_numbers_below_the_bound_and_lead_back() {
        let space = SimulationBox::new(Vec3::zeros(), Vec3::new(10.5, 7.0, 3.5), [[Side::Periodic; 2]; 3]);
        for (order, bound) in [(CellOrder::Rows, 10 * 7 * 3), (CellOrder::Curve, 16 * 16 * 16)] {
            let plan = Search::Standard.plan().with_order(order);
            let grid = Grid::new(plan, &space, &space.lo, &space.hi, 0.999);
            assert_eq!((grid.axes.map(|axis| axis.cells), grid.hashes()), ([10, 7, 3], bound));
            let mut seen = vec![false; bound as usize];
            for cell in (0..210).map(|k| [k % 10, k / 10 % 7, k / 70]) {
                let hash = grid.hash(cell);
                assert!(!std::mem::replace(&mut seen[hash as usize], true), "{cell:?}");
                assert_eq!(grid.unhash(hash), cell);
            }
        }
    }

    #[test]
    fn a_z_order_curve_goes_through_each_cube_of_a_power_of_two() {
        for x in [0, 1, 2, 0b1011, (1 << CELL_BITS) - 1] {
            let bits = (0..CELL_BITS).map(|bit| (x >> bit & 1) << (3 * bit)).sum::<u64>();
            assert_eq!((apart(x), together(bits), together(bits | bits << 1)), (bits, x, x));
        }
    }
}
