//! Boxes of fcc cells for wanted numbers of atoms.

use std::fmt;

/// Atoms of a cell of the fcc lattice.
const ATOMS_A_CELL: usize = 4;

/// Edges that differ from the cube's by up to this many cells are tried: nearly cubic boxes stay comparable.
const AROUND: usize = 1;

/// Fewest atoms of a box, and most: their ids are 32-bit numbers.
pub const FEWEST: usize = 500;
pub const MOST: usize = 1 << 30;

/// A crystal of so many cells along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells(pub [usize; 3]);

impl Cells {
    /// The box, cubic or nearly so, that comes nearest to a number of atoms; the more cubic of two that are as near.
    pub fn nearest(atoms: usize) -> Self {
        let wanted = (atoms as f64 / ATOMS_A_CELL as f64).max(1.0);
        let edge = wanted.cbrt().round() as usize;
        let range = || edge.saturating_sub(AROUND).max(1)..=edge + AROUND;
        let boxes = range().flat_map(|x| range().flat_map(move |y| range().map(move |z| [x, y, z])));
        let ordered = boxes.filter(|[x, y, z]| x <= y && y <= z).map(Self);
        let off = |cells: &Self| cells.atoms().abs_diff(atoms);
        let spread = |Self([x, _, z]): &Self| z - x;
        ordered.min_by_key(|cells| (off(cells), spread(cells))).expect("the cube is among them")
    }

    pub fn atoms(&self) -> usize {
        ATOMS_A_CELL * self.0.iter().product::<usize>()
    }

    /// Cells along the shortest edge.
    pub fn shortest(&self) -> usize {
        self.0[0].min(self.0[1]).min(self.0[2])
    }
}

impl fmt::Display for Cells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x}x{y}x{z}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubes_where_they_fit_and_boxes_that_come_nearer() {
        let of = |atoms| Cells::nearest(atoms).0;
        assert_eq!(of(4_000), [10; 3]);
        assert_eq!(of(131_072), [32; 3]);
        assert_eq!(of(256_000), [40; 3]);
        assert_eq!(of(1_000_188), [63; 3]);
        assert_eq!(of(64_012_032), [252; 3]);
        assert_eq!(of(1_000_000), [62, 63, 64]);
        assert_eq!(of(500), [5; 3]);
        for atoms in [501, 999, 7_777, 123_456, 8_192_000, 16_000_000] {
            let cells = Cells::nearest(atoms);
            assert!(cells.atoms().abs_diff(atoms) * 20 <= atoms, "{atoms}: {cells}");
            assert!(cells.0[2] - cells.0[0] <= 2 * AROUND && cells.shortest() == cells.0[0]);
        }
    }
}
