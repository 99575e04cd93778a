//! Lattices: where `create_atoms` puts atoms and what a "lattice unit" is.
//!
//! Every operation is done in LAMMPS's order, so that positions agree to the last bit.

use nalgebra::Matrix3;

use crate::script::Complaint;
use crate::script::command::lattice::{LatticeCommand, LatticeStyle};
use crate::system::{Units, Vec3};

/// A lattice placed in the box (LAMMPS doc page `lattice`).
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Fractional coordinates of the atoms of one unit cell.
    basis: Vec<[f64; 3]>,
    /// `primitive[row][column]`: component `row` of primitive vector `column`, before scaling.
    primitive: [[f64; 3]; 3],
    /// Length of the unit of the primitive vectors.
    scale: f64,
    /// Rows: unit vectors of the lattice directions along the box axes.
    rotation: [[f64; 3]; 3],
    /// Lattice units along the box axes, length units.
    spacing: Vec3,
    /// Shift in lattice units.
    origin: Vec3,
}

impl Default for Lattice {
    /// What holds before any `lattice` command: no points, lattice units equal to length units.
    fn default() -> Self {
        Self::pointless(1.0)
    }
}

impl Lattice {
    /// A lattice without points: it only scales lengths.
    fn pointless(scale: f64) -> Self {
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let spacing = Vec3::repeat(scale);
        Self { basis: Vec::new(), primitive: unit, scale, rotation: unit, spacing, origin: Vec3::zeros() }
    }

    /// Builds a lattice. Errors: directions that are not orthogonal and right-handed, primitive vectors in one plane,
    /// a custom lattice without basis.
    pub fn new(command: &LatticeCommand, units: &Units) -> Result<Self, Complaint> {
        if command.style == LatticeStyle::None {
            return Ok(Self::pointless(command.scale));
        }
        let (vectors, basis) = unit_cell(command);
        if basis.is_empty() {
            return Err(Complaint::new(1, "expected at least one basis atom of the custom lattice, got none"));
        }
        check_orientation(&command.orient)?;
        let volume = cell_volume(&vectors);
        if volume == 0.0 {
            return Err(Complaint::new(1, "the primitive vectors a1, a2, a3 lie in one plane"));
        }
        let scale = if units.name == "lj" {
            (basis.len() as f64 / volume / command.scale).powf(1.0 / 3.0)
        } else {
            command.scale
        };
        let mut primitive = [[0.0; 3]; 3];
        for (column, vector) in vectors.iter().enumerate() {
            for (row, component) in vector.iter().enumerate() {
                primitive[row][column] = *component;
            }
        }
        let rotation = command.orient.map(|direction| {
            let length = (direction.iter().map(|c| c * c).sum::<i64>() as f64).sqrt();
            direction.map(|c| c as f64 / length)
        });
        let mut lattice =
            Self { basis, primitive, scale, rotation, spacing: Vec3::zeros(), origin: Vec3::from(command.origin) };
        lattice.spacing = match command.spacing {
            Some(spacing) => Vec3::from(spacing) * scale,
            None => lattice.cell_extent(),
        };
        if !lattice.spacing.iter().all(|s| *s > 0.0 && s.is_finite()) || !scale.is_finite() {
            return Err(Complaint::new(1, "the lattice spacing is not a positive number"));
        }
        Ok(lattice)
    }

    /// Lattice units along x, y and z, length units.
    pub fn spacing(&self) -> Vec3 {
        self.spacing
    }

    /// Atoms in a unit cell; 0 for a lattice that only scales.
    pub fn basis_len(&self) -> usize {
        self.basis.len()
    }

    /// Where basis atom `basis` of unit cell (i, j, k) sits in the box.
    pub fn point(&self, i: i64, j: i64, k: i64, basis: usize) -> Vec3 {
        let [x, y, z] = self.basis[basis];
        self.to_box([i as f64 + x, j as f64 + y, k as f64 + z])
    }

    /// Lattice coordinates to box coordinates.
    fn to_box(&self, point: [f64; 3]) -> Vec3 {
        let scaled = product(&self.primitive, &point).map(|c| c * self.scale);
        let rotated = product(&self.rotation, &scaled);
        Vec3::new(
            rotated[0] + self.spacing.x * self.origin.x,
            rotated[1] + self.spacing.y * self.origin.y,
            rotated[2] + self.spacing.z * self.origin.z,
        )
    }

    /// Extent of the unit cell at the origin along the box axes.
    fn cell_extent(&self) -> Vec3 {
        let (mut lo, mut hi) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for corner in 0..8u32 {
            let bit = |axis: u32| f64::from(corner >> axis & 1);
            let scaled = product(&self.primitive, &[bit(0), bit(1), bit(2)]).map(|c| c * self.scale);
            let point = Vec3::from(product(&self.rotation, &scaled));
            (lo, hi) = (lo.inf(&point), hi.sup(&point));
        }
        hi - lo
    }

    /// Ranges of unit cells (first and last, per lattice direction) that cover an axis-parallel part of the box.
    pub fn cells_covering(&self, lo: &Vec3, hi: &Vec3) -> [[f64; 2]; 3] {
        let primitive = Matrix3::from_fn(|r, c| self.primitive[r][c]) * self.scale;
        let rotation = Matrix3::from_fn(|r, c| self.rotation[r][c]);
        let inverse = primitive.try_inverse().unwrap_or_else(Matrix3::identity) * rotation.transpose();
        let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for corner in 0..8u32 {
            let side = |axis: usize| if corner >> axis & 1 == 0 { lo[axis] } else { hi[axis] };
            let point = Vec3::new(side(0), side(1), side(2)) - self.spacing.component_mul(&self.origin);
            let cell = inverse * point;
            for (range, c) in ranges.iter_mut().zip(cell.iter()) {
                *range = [range[0].min(*c), range[1].max(*c)];
            }
        }
        // One cell below covers the basis, one more rounding; far too many cells is the caller's error.
        ranges.map(|[first, last]| [first.floor() - 1.0, last.floor() + 1.0])
    }
}

/// Product of a matrix and a vector, three-term sums from the left.
fn product(matrix: &[[f64; 3]; 3], v: &[f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Primitive vectors and basis of a style, before scaling.
fn unit_cell(command: &LatticeCommand) -> ([[f64; 3]; 3], Vec<[f64; 3]>) {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let basis = match command.style {
        LatticeStyle::None => vec![],
        LatticeStyle::Sc => vec![[0.0; 3]],
        LatticeStyle::Bcc => vec![[0.0; 3], [0.5; 3]],
        LatticeStyle::Fcc => vec![[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]],
        LatticeStyle::Hcp => {
            vectors[1][1] = 3f64.sqrt();
            vectors[2][2] = (8.0f64 / 3.0).sqrt();
            vec![[0.0; 3], [0.5, 0.5, 0.0], [0.5, 5.0 / 6.0, 0.5], [0.0, 1.0 / 3.0, 0.5]]
        }
        LatticeStyle::Diamond => vec![
            [0.0; 3],
            [0.0, 0.5, 0.5],
            [0.5, 0.0, 0.5],
            [0.5, 0.5, 0.0],
            [0.25; 3],
            [0.25, 0.75, 0.75],
            [0.75, 0.25, 0.75],
            [0.75, 0.75, 0.25],
        ],
        LatticeStyle::Custom => {
            for (vector, given) in vectors.iter_mut().zip(command.primitive) {
                *vector = given.unwrap_or(*vector);
            }
            command.basis.clone()
        }
    };
    (vectors, basis)
}

/// Volume spanned by the primitive vectors.
fn cell_volume([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]).abs()
}

fn check_orientation([x, y, z]: &[[i64; 3]; 3]) -> Result<(), Complaint> {
    let dot = |a: &[i64; 3], b: &[i64; 3]| a.iter().zip(b).map(|(p, q)| p * q).sum::<i64>();
    if dot(x, y) != 0 || dot(y, z) != 0 || dot(x, z) != 0 {
        return Err(Complaint::new(1, "the orient vectors of x, y and z are not orthogonal")
            .with_help("give all three directions, each by its own `orient` keyword"));
    }
    let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    if dot(&cross, z) <= 0 {
        return Err(Complaint::new(1, "the orient vectors of x, y and z are not right-handed"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::test_support::Scene;

    #[test]
    fn spacings_are_those_of_lammps() {
        // Values of LAMMPS 22Jul2025.
        let spacing = |line: &str| Scene::new(line).lattice.unwrap().spacing();
        let bcc = spacing("lattice bcc 0.9 orient x 1 1 1 orient y 1 -1 0 orient z 1 1 -2");
        assert_eq!(bcc, Vec3::new(2.260249886470599, 1.8454863043455247, 2.130984029199313));
        let hcp = spacing("lattice hcp 1.1");
        assert_eq!(hcp, Vec3::new(1.0873618812400903, 1.8833660245215118, 1.7756545165273476));
        let mut scene = Scene::new("");
        scene.units = Units::named("metal").unwrap();
        scene.run("lattice custom 3.5 a1 1.1 0.2 0.1 a2 0 1.3 0.2 a3 0.3 0.1 0.9 basis 0 0 0").unwrap();
        assert_eq!(scene.lattice.unwrap().spacing(), Vec3::new(4.9, 5.6000000000000005, 4.200000000000001));
    }

    #[test]
    fn wrong_lattices_are_told_apart() {
        let complaint = |line: &str| Scene::new("").complaint(line).1;
        assert!(complaint("lattice fcc 1 orient x 1 1 0").contains("not orthogonal"));
        assert!(complaint("lattice fcc 1 orient x 1 1 0 orient y 1 -1 0").contains("not right-handed"));
        assert!(complaint("lattice custom 1 a1 1 0 0 a2 1 0 0 basis 0 0 0").contains("in one plane"));
        assert!(complaint("lattice custom 1").contains("basis atom"));
        assert!(complaint("lattice fcc 1 basis 0 0 0").contains("custom only"));
        assert!(complaint("lattice hex 1").contains("two-dimensional"));
        assert_eq!(
            Scene::new("").complaint("lattice fcc 1 origin 0 1 0"),
            (5, "expected an origin coordinate from 0 to below 1, got '1'".into())
        );
    }
}
