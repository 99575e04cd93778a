//! Which search builds the lists, and with cells of which edge.

use std::fmt;
use std::str::FromStr;

/// How neighbors are looked for. All searches give the same pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Search {
    /// Octant cells, only the octants that border on the particle's: 27 of 64, 27 R^3 of candidates with cells of edge 2R.
    #[default]
    Trimmed,
    /// Octant cells as in Morillo et al. 2015 (doi:10.2312/vriphys.20151339): 8 cells, 64 R^3 with cells of edge 2R.
    Octant,
    /// Octant cells larger than 2R: along an axis on which a particle lies so near to the middle of its cell that R does not
    /// reach out of it, the own cell alone. 8, 4, 2 cells or 1; what the paper's cases of particles on secant planes come to
    /// where they are to lose no neighbor.
    Midplane,
    /// All cells within R on both sides: 27 with cells of edge R (Green 2010).
    Standard,
    /// All pairs.
    Brute,
}

impl Search {
    /// Names on the command line, in the order of [`Search::ALL`].
    pub const NAMES: [&'static str; 5] = ["trimmed", "octant", "midplane", "standard", "brute"];
    /// All searches.
    pub const ALL: [Search; 5] = [Search::Trimmed, Search::Octant, Search::Midplane, Search::Standard, Search::Brute];

    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// With cells of an edge in neighbor cutoffs R. Says what is wrong where such cells could miss neighbors, or are too many.
    pub fn with_edge(self, edge: f64) -> Result<SearchPlan, String> {
        let least = match self {
            Search::Trimmed | Search::Octant | Search::Midplane => SearchPlan::OCTANT_EDGE,
            Search::Standard => LEAST_EDGE,
            Search::Brute => return Err("the search 'brute' has no cells".into()),
        };
        if edge >= least && edge.is_finite() {
            return Ok(SearchPlan { edge, ..self.plan() });
        }
        if edge == f64::INFINITY {
            return Err(format!(
                "cells of the search '{}' have a finite edge, got {edge}; the search 'brute' has one cell",
                self.name()
            ));
        }
        let why = match self {
            Search::Standard => "",
            _ => ": particles do not look into all cells around theirs, and smaller ones could hide a neighbor",
        };
        Err(format!(
            "cells of the search '{}' have an edge of at least {least} neighbor cutoffs, got {edge}{why}",
            self.name()
        ))
    }

    /// With cells of the usual edge.
    pub fn plan(self) -> SearchPlan {
        let edge = match self {
            Search::Trimmed | Search::Octant => SearchPlan::OCTANT_EDGE,
            Search::Midplane => MIDPLANE_EDGE,
            Search::Standard => 1.0,
            Search::Brute => f64::INFINITY,
        };
        SearchPlan { search: self, edge, order: CellOrder::default(), sort: Sort::default(), looks: [[true; 2]; 3] }
    }
}

/// In which order cells, and with them particles, lie in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellOrder {
    /// The engine's own: on the CPU row after row, on a GPU brick after brick of 2 x 2 x 2 cells.
    #[default]
    Usual,
    /// Row after row, X fastest, then Y, then Z: equation 1 of the paper.
    Rows,
    /// Along a Z-order curve (Morton order): the z-indexing that the paper turns down.
    Curve,
}

impl CellOrder {
    pub fn name(self) -> &'static str {
        ["usual", "rows", "zorder"][self as usize]
    }
}

/// How particles are brought into the order of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sort {
    /// Counted by cell and dealt out; by comparing where the grid is mostly empty.
    #[default]
    Counting,
    /// By the digits of their keys, the last first: radix sort, which the paper takes.
    Radix,
}

impl Sort {
    pub fn name(self) -> &'static str {
        if self == Sort::Counting { "counting" } else { "radix" }
    }
}

/// Smallest edge of the standard search's cells, in neighbor cutoffs: 21 cells along each axis are looked into.
const LEAST_EDGE: f64 = 0.1;

/// Usual edge for [`Search::Midplane`]: the second of the paper's three; cells of edge 2R have no particles to spare a cell for.
const MIDPLANE_EDGE: f64 = 2.52;

/// A search, the edge of its cells, their order in memory, and how particles are brought into it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchPlan {
    search: Search,
    edge: f64,
    order: CellOrder,
    sort: Sort,
    looks: [[bool; 2]; 3],
}

impl SearchPlan {
    /// Smallest edge of cells of which a particle looks into at most two along an axis, in neighbor cutoffs R.
    pub const OCTANT_EDGE: f64 = 2.0;

    pub fn search(&self) -> Search {
        self.search
    }

    /// Edge of the cells, in neighbor cutoffs R; infinite where there is one cell.
    pub fn edge(&self) -> f64 {
        self.edge
    }

    pub fn order(&self) -> CellOrder {
        self.order
    }

    pub fn sort(&self) -> Sort {
        self.sort
    }

    /// Sides of the own cell, lower and upper along each axis, beyond which [`Search::Standard`] looks for neighbors.
    pub fn looks(&self) -> [[bool; 2]; 3] {
        self.looks
    }

    /// Looks beyond these sides alone. What comes out is no neighbor list, but tells what looking costs; it has no written form.
    pub fn looking(self, looks: [[bool; 2]; 3]) -> Self {
        Self { looks, ..self }
    }

    pub fn with_order(self, order: CellOrder) -> Self {
        Self { order, ..self }
    }

    pub fn with_sort(self, sort: Sort) -> Self {
        Self { sort, ..self }
    }

    /// Particles of an octant are sorted by its parts too.
    pub fn is_compact(&self) -> bool {
        self.search == Search::Trimmed
    }
}

impl Default for SearchPlan {
    fn default() -> Self {
        Search::default().plan()
    }
}

impl From<Search> for SearchPlan {
    fn from(search: Search) -> Self {
        search.plan()
    }
}

/// "octant", or with what is not usual "octant:2.52+zorder+radix".
impl fmt::Display for SearchPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.search.name())?;
        if self.edge != self.search.plan().edge {
            write!(f, ":{}", self.edge)?;
        }
        if self.order != CellOrder::default() {
            write!(f, "+{}", self.order.name())?;
        }
        if self.sort != Sort::default() {
            write!(f, "+{}", self.sort.name())?;
        }
        Ok(())
    }
}

/// The form that is displayed.
impl FromStr for SearchPlan {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (text, rest) = text.split_once('+').map_or((text, None), |(text, rest)| (text, Some(rest)));
        let (mut order, mut sort) = (CellOrder::default(), Sort::default());
        for word in rest.into_iter().flat_map(|rest| rest.split('+')) {
            match word {
                "rows" => order = CellOrder::Rows,
                "zorder" => order = CellOrder::Curve,
                "radix" => sort = Sort::Radix,
                _ => return Err(format!("expected 'rows', 'zorder' or 'radix' after '+', got '{word}'")),
            }
        }
        let (name, edge) = match text.split_once(':') {
            Some((name, edge)) => (name, Some(edge)),
            None => (text, None),
        };
        let Some(place) = Search::NAMES.iter().position(|known| *known == name) else {
            return Err(format!("expected a search, one of {}, got '{name}'", Search::NAMES.join(", ")));
        };
        let search = Search::ALL[place];
        let plan = match edge.map(str::parse::<f64>) {
            None => search.plan(),
            Some(Ok(edge)) => search.with_edge(edge)?,
            Some(Err(_)) => {
                return Err(format!("expected an edge in neighbor cutoffs, got '{}'", edge.unwrap_or_default()));
            }
        };
        Ok(plan.with_order(order).with_sort(sort))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_is_read() {
        for search in Search::ALL {
            assert_eq!(search.name().parse(), Ok(search.plan()));
            assert_eq!(search.plan().to_string(), search.name());
        }
        for text in [
            "standard:0.5",
            "standard:4",
            "octant:2.52",
            "trimmed:3",
            "midplane:2",
            "trimmed+zorder",
            "octant+rows",
            "octant:4+radix",
            "standard:2+zorder+radix",
        ] {
            let plan: SearchPlan = text.parse().unwrap();
            assert_eq!(plan.to_string(), text);
        }
        assert_eq!("octant:2.0".parse(), Ok(Search::Octant.plan()));
        assert_eq!("octant+radix+zorder".parse::<SearchPlan>().unwrap().to_string(), "octant+zorder+radix");
    }

    #[test]
    fn edges_that_could_hide_a_neighbor_are_refused() {
        let error = |text: &str| text.parse::<SearchPlan>().unwrap_err();
        for search in ["trimmed", "octant", "midplane"] {
            let said = error(&format!("{search}:1.999"));
            assert!(
                said.starts_with(&format!("cells of the search '{search}' have an edge of at least 2 neighbor")),
                "{said}"
            );
        }
        assert!(error("standard:0").contains("at least 0.1 neighbor cutoffs, got 0"));
        assert!(error("standard:NaN").contains("got NaN"));
        let said = "cells of the search 'octant' have a finite edge, got inf; the search 'brute' has one cell";
        assert_eq!(error("octant:inf"), said);
        assert_eq!(error("brute:2"), "the search 'brute' has no cells");
        assert_eq!(error("octant+quick"), "expected 'rows', 'zorder' or 'radix' after '+', got 'quick'");
        assert_eq!(error("octant:wide"), "expected an edge in neighbor cutoffs, got 'wide'");
        assert_eq!(error("quick"), "expected a search, one of trimmed, octant, midplane, standard, brute, got 'quick'");
    }
}
