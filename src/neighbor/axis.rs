//! One axis of the cell grid: which cells a particle of a given cell half must look into.

use crate::real::{Real, Whole};

/// Relative widening of the search radius, against rounding in the binning of positions.
const MARGIN: f64 = 1e-6;

/// Halves of a cell along an axis: bit 0 the lower half, bit 1 the upper.
pub const BOTH_HALVES: u8 = 0b11;

/// How neighbors are looked for along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Cells of edge at least 2R: the own cell and the one on the particle's side (Morillo et al. 2015,
    /// doi:10.2312/vriphys.20151339; the printed alpha and beta are exchanged there).
    Octant {
        /// Of the other cell only the half that borders on the own one.
        trimmed: bool,
    },
    /// All cells up to this many away on both sides (Green 2010).
    Cells(i64),
}

/// The grid along one axis. Cell k covers `[lo + k edge, lo + (k + 1) edge)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    pub lo: f64,
    pub edge: f64,
    pub inverse_edge: f64,
    pub cells: i64,
    pub periodic: bool,
    pub reach: Reach,
}

/// A cell to look into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    pub cell: i64,
    /// The cell's periodic image: positions are shifted by this many box lengths.
    pub image: i32,
    /// Halves that can hold neighbors.
    pub halves: u8,
}

/// Extent of an axis, and how it is to be cut.
#[derive(Clone, Copy, Debug)]
pub struct AxisRequest {
    pub lo: f64,
    pub hi: f64,
    pub periodic: bool,
    /// Neighbor cutoff R.
    pub radius: f64,
    /// Smallest cell edge wanted.
    pub edge: f64,
    /// `None`: all cells within R.
    pub octant: Option<bool>,
    /// Most cells the axis may have (free axes: cells grow beyond that).
    pub most_cells: i64,
}

/// A coordinate in cells of an axis from `lo`.
#[inline(always)]
pub fn in_cells<R: Real>(x: R, lo: R, inverse_edge: R) -> R {
    (x - lo) * inverse_edge
}

/// Cell and eighth of it of a coordinate, as whole numbers, on an axis from `lo` whose last cell is number `last`.
#[inline(always)]
pub fn locate<R: Whole>(x: R, lo: R, inverse_edge: R, last: R) -> (R, R) {
    let zero = R::constant(0.0);
    let position = in_cells(x, lo, inverse_edge);
    let cell = position.trunc().lesser(last).greater(zero);
    let eighth = (R::constant(8.0) * (position - cell)).trunc();
    (cell, eighth.lesser(R::constant(7.0)).greater(zero))
}

impl Axis {
    /// Cuts an axis into cells. Where a periodic axis is too short for octant cells, one cell and its images take their place.
    pub fn new(request: &AxisRequest) -> Self {
        let AxisRequest { lo, hi, periodic, radius, octant, .. } = *request;
        let length = hi - lo;
        // Binning errs by a few units in the last place of the coordinates; count that in cell edges of size R.
        let coordinate = lo.abs().max(hi.abs());
        let rounding = if radius > 0.0 { 16.0 * f64::EPSILON * coordinate / radius } else { 0.0 };
        let reach = radius * (1.0 + MARGIN + rounding);
        let edge = match octant {
            Some(_) => request.edge.max(2.0 * reach),
            None => request.edge,
        };
        let wanted = if edge > 0.0 && length.is_finite() { (length / edge).floor() } else { 1.0 };
        let cells = (wanted.min(request.most_cells as f64) as i64).max(1);
        let edge = if length > 0.0 { length / cells as f64 } else { 1.0 };
        let fits = !periodic || edge >= 2.0 * reach;
        let reach = match octant {
            Some(trimmed) if fits => Reach::Octant { trimmed },
            // Beyond the ends of a free axis there is nothing to look into.
            _ if !periodic => Reach::Cells(((reach / edge).ceil() as i64).clamp(1, cells)),
            _ => Reach::Cells(((reach / edge).ceil() as i64).max(1)),
        };
        Self { lo, edge, inverse_edge: 1.0 / edge, cells, periodic, reach }
    }

    /// Cell and eighth of it (0 to 7; from 4 on the upper half) of a coordinate inside the axis's extent, as whole numbers.
    #[inline]
    pub fn locate(&self, x: f64) -> (f64, f64) {
        locate(x, self.lo, self.inverse_edge, (self.cells - 1) as f64)
    }

    /// Middle of a cell.
    pub fn middle(&self, cell: i64) -> f64 {
        self.lo + (cell as f64 + 0.5) * self.edge
    }

    /// How far the cells that a particle looks into may reach from the lower side of its own.
    pub fn reach_length(&self) -> f64 {
        let cells = match self.reach {
            Reach::Octant { .. } => 1,
            Reach::Cells(m) => m,
        };
        (cells + 1) as f64 * self.edge
    }

    /// Calls `look` for every cell that can hold neighbors of a particle in `half` of `cell`.
    pub fn visits(&self, cell: i64, half: u8, mut look: impl FnMut(Visit)) {
        match self.reach {
            Reach::Octant { trimmed } => {
                let other = if half == 0 { cell - 1 } else { cell + 1 };
                let border = if half == 0 { 0b10 } else { 0b01 };
                let own = Visit { cell, image: 0, halves: BOTH_HALVES };
                let other = self.image_of(other).map(|(cell, image)| Visit {
                    cell,
                    image,
                    halves: if trimmed { border } else { BOTH_HALVES },
                });
                // Ascending cells, so that lists come out in the order of memory.
                match (half, other) {
                    (0, Some(other)) => {
                        look(other);
                        look(own);
                    }
                    (_, Some(other)) => {
                        look(own);
                        look(other);
                    }
                    (_, None) => look(own),
                }
            }
            Reach::Cells(m) => {
                for neighbor in cell - m..=cell + m {
                    if let Some((cell, image)) = self.image_of(neighbor) {
                        look(Visit { cell, image, halves: BOTH_HALVES });
                    }
                }
            }
        }
    }

    /// The stored cell and periodic image for a cell number that may lie outside the grid.
    fn image_of(&self, cell: i64) -> Option<(i64, i32)> {
        if self.periodic {
            Some((cell.rem_euclid(self.cells), cell.div_euclid(self.cells) as i32))
        } else {
            (0..self.cells).contains(&cell).then_some((cell, 0))
        }
    }
}
