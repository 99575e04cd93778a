//! One axis of the cell grid: which cells a particle of a given cell half must look into.

use super::plan::{Search, SearchPlan};
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
        /// None but the own cell for particles so near to its middle that nothing beyond is in reach.
        midplane: bool,
    },
    /// All cells up to this many away, below and above (Green 2010).
    Cells([i64; 2]),
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
    /// Part of the edge next to a side within which particles look beyond that side. From 1/2 on that is all of them.
    pub border: f64,
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
    pub plan: SearchPlan,
    /// Whether there is a look below and above the own cell, if the search looks to both sides ([`SearchPlan::looking`]).
    pub looks: [bool; 2],
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

/// 1 where a position (in cells, as is its cell's number) lies further than `border` from both sides of the cell, 0 elsewhere.
#[inline(always)]
pub fn middle<R: Real>(position: R, cell: R, border: R) -> R {
    let (zero, one) = (R::constant(0.0), R::constant(1.0));
    let within = position - cell;
    R::select(border.less(within), R::select(within.less(one - border), one, zero), zero)
}

impl Axis {
    /// Cuts an axis into cells. Cells of a periodic axis divide its length, so they may be larger than asked for; where it is too
    /// short for octant cells, one cell and its images take their place. Cells of a free axis have the edge that was asked for,
    /// and the last one reaches beyond what is there.
    pub fn new(request: &AxisRequest) -> Self {
        let AxisRequest { lo, hi, periodic, radius, plan, looks, .. } = *request;
        let length = hi - lo;
        // Binning errs by a few units in the last place of the coordinates; count that in cell edges of size R.
        let coordinate = lo.abs().max(hi.abs());
        let rounding = if radius > 0.0 { 16.0 * f64::EPSILON * coordinate / radius } else { 0.0 };
        let reach = radius * (1.0 + MARGIN + rounding);
        let asked = plan.edge() * reach;
        let wanted = match length / asked {
            // No length, no radius, one cell.
            count if !(asked > 0.0 && length.is_finite() && count >= 1.0) => 1.0,
            count if periodic => count.floor(),
            count => count.ceil(),
        };
        let cells = (wanted.min(request.most_cells as f64) as i64).max(1);
        let edge = match length {
            _ if !periodic && cells > 1 && asked * cells as f64 >= length => asked,
            length if length > 0.0 => length / cells as f64,
            _ => 1.0,
        };
        let fits = !periodic || edge >= SearchPlan::OCTANT_EDGE * reach;
        let far = ((reach / edge).ceil() as i64).max(1);
        let to_both = |far: i64| Reach::Cells(looks.map(|look| if look { far } else { 0 }));
        let reaches = match plan.search() {
            Search::Trimmed if fits => Reach::Octant { trimmed: true, midplane: false },
            Search::Octant if fits => Reach::Octant { trimmed: false, midplane: false },
            Search::Midplane if fits => Reach::Octant { trimmed: false, midplane: true },
            // Beyond the ends of a free axis there is nothing to look into.
            _ if !periodic => to_both(far.min(cells)),
            _ => to_both(far),
        };
        let border = if reaches == (Reach::Octant { trimmed: false, midplane: true }) { reach / edge } else { 1.0 };
        Self { lo, edge, inverse_edge: 1.0 / edge, cells, periodic, reach: reaches, border }
    }

    /// Whether a particle at this coordinate finds its neighbors along the axis in its own cell.
    pub fn is_middle(&self, x: f64) -> bool {
        let cell = self.locate(x).0;
        middle(in_cells(x, self.lo, self.inverse_edge), cell, self.border) != 0.0
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
            Reach::Cells([below, above]) => below.max(above),
        };
        (cells + 1) as f64 * self.edge
    }

    /// Calls `look` for every cell that can hold neighbors of a particle in `half` of `cell`; `middle`: [`Axis::is_middle`] holds
    /// for it.
    pub fn visits(&self, cell: i64, half: u8, middle: bool, mut look: impl FnMut(Visit)) {
        match self.reach {
            Reach::Octant { midplane: true, .. } if middle => look(Visit { cell, image: 0, halves: BOTH_HALVES }),
            Reach::Octant { trimmed, .. } => {
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
            Reach::Cells([below, above]) => {
                for neighbor in cell - below..=cell + above {
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

#[cfg(test)]
mod tests {
    use super::*;

    const R: f64 = 1.0;

    fn axis(search: Search, edge: f64, length: f64, periodic: bool) -> Axis {
        let plan = search.with_edge(edge).unwrap();
        Axis::new(&AxisRequest {
            lo: 0.3,
            hi: 0.3 + length,
            periodic,
            radius: R,
            plan,
            looks: [true; 2],
            most_cells: 1 << 20,
        })
    }

    /// What a particle at x looks into: intervals of coordinates, periodic images undone.
    fn looked_into(axis: &Axis, x: f64) -> Vec<[f64; 2]> {
        let (cell, eighth) = axis.locate(x);
        let mut found = Vec::new();
        axis.visits(cell as i64, u8::from(eighth >= 4.0), axis.is_middle(x), |visit| {
            let low = axis.lo + (visit.cell as f64 + f64::from(visit.image) * axis.cells as f64) * axis.edge;
            let half = |k: u8| [low + f64::from(k) * axis.edge / 2.0, low + f64::from(k + 1) * axis.edge / 2.0];
            found.extend((0..2).filter(|k| visit.halves >> k & 1 != 0).map(half));
        });
        found
    }

    #[test]
    fn cells_looked_into_reach_as_far_as_r() {
        for search in [Search::Trimmed, Search::Octant, Search::Midplane, Search::Standard] {
            for edge in [2.0, 2.52, 3.1, 4.0] {
                for periodic in [false, true] {
                    let axis = axis(search, edge, 41.0, periodic);
                    for k in 0..4000 {
                        let x = axis.lo + 41.0 * (f64::from(k) + 0.5) / 4000.0;
                        let found = looked_into(&axis, x);
                        for target in [x - R, x + R] {
                            let there = periodic || (axis.lo..axis.lo + 41.0).contains(&target);
                            let seen = found.iter().any(|[low, high]| (*low..*high).contains(&target));
                            assert!(seen || !there, "{search:?} {edge}: {target} from {x}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn near_the_mid_plane_the_own_cell_is_enough() {
        for edge in [2.0, 2.52, 4.0] {
            let axis = axis(Search::Midplane, edge, 40.0 * edge + 0.1, false);
            let mut alone = 0;
            for k in 0..1000 {
                let within = axis.edge * (f64::from(k) + 0.5) / 1000.0;
                let x = axis.lo + 7.0 * axis.edge + within;
                let halves = looked_into(&axis, x).len();
                // From the mid-plane, with the room that rounding is given.
                let near = (within - axis.edge / 2.0).abs() < axis.edge / 2.0 - R * (1.0 + 2.0 * MARGIN);
                let far = (within - axis.edge / 2.0).abs() > axis.edge / 2.0 - R;
                assert!((!near || halves == 2) && (!far || halves == 4), "{edge}: {within}");
                alone += usize::from(halves == 2);
            }
            // (e - 2R) / e of all places.
            assert_eq!(alone, (1000.0 * (edge - 2.0) / edge) as usize / 2 * 2, "{edge}");
        }
    }

    #[test]
    fn cells_have_the_edge_that_was_asked_for() {
        for edge in [0.5, 1.0, 2.0, 2.52, 4.0] {
            // On a free axis to the margin, on a periodic one as nearly as its length allows.
            let free = axis(Search::Standard, edge, 23.436, false);
            assert!((free.edge / edge - 1.0).abs() < 2.0 * MARGIN, "{edge}");
            assert_eq!(free.cells, (23.436 / free.edge).ceil() as i64);
            let periodic = axis(Search::Standard, edge, 23.436, true);
            assert_eq!(periodic.cells, (23.436 / free.edge).floor() as i64);
            for axis in [free, periodic] {
                assert_eq!(axis.reach, Reach::Cells([(1.0 / edge).ceil() as i64; 2]), "{edge}");
            }
        }
    }

    #[test]
    fn an_axis_without_length_or_shorter_than_r_has_one_cell() {
        for search in Search::ALL {
            for length in [0.0, 1e-300, 0.5 * R] {
                let request = |periodic| AxisRequest {
                    lo: 0.3,
                    hi: 0.3 + length,
                    periodic,
                    radius: R,
                    plan: search.plan(),
                    looks: [true; 2],
                    most_cells: 1 << 20,
                };
                let free = Axis::new(&request(false));
                assert!(free.cells == 1 && free.edge > 0.0, "{search:?} {length}");
                assert_eq!(free.locate(0.3).0, 0.0);
            }
            let periodic = axis(Search::Standard, 1.0, 0.5 * R, true);
            assert_eq!((periodic.cells, periodic.reach), (1, Reach::Cells([3, 3])));
        }
    }
}
