//! The orthogonal simulation box: sides, kind of boundary, wrapping.

use super::state::Vec3;

/// What happens at one side of the box (`boundary` command).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// `p`: the opposite side is its continuation.
    Periodic,
    /// `f`: free; the side stays where it is and atoms beyond it are lost.
    Fixed,
    /// `s`: free; the side follows the outermost atom.
    Shrink,
}

/// An orthogonal box. Lengths in the scene's units.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationBox {
    pub lo: Vec3,
    pub hi: Vec3,
    /// `sides[axis] = [low side, high side]`; both or neither are periodic.
    pub sides: [[Side; 2]; 3],
    /// Distance kept between a shrink-wrapped side and the outermost atom: [`SHRINK_MARGIN`] of the edge as first given.
    pub margin: Vec3,
}

/// Part of an edge that a shrink-wrapped side stays away from the atoms.
const SHRINK_MARGIN: f64 = 1.0e-4;

impl SimulationBox {
    /// A box as a script or data file gives it, `lo < hi`: shrink-wrapped sides are moved out by the margin, so that atoms on
    /// them lie inside (LAMMPS doc page `boundary`).
    pub fn new(lo: Vec3, hi: Vec3, sides: [[Side; 2]; 3]) -> Self {
        let margin = SHRINK_MARGIN * (hi - lo);
        let mut simulation_box = Self { lo, hi, sides, margin };
        for axis in 0..3 {
            if sides[axis][0] == Side::Shrink {
                simulation_box.lo[axis] -= margin[axis];
            }
            if sides[axis][1] == Side::Shrink {
                simulation_box.hi[axis] += margin[axis];
            }
        }
        simulation_box
    }

    /// Whether some side follows the atoms.
    pub fn shrinks(&self) -> bool {
        self.sides.as_flattened().contains(&Side::Shrink)
    }

    /// Moves the shrink-wrapped sides to the outermost atoms plus the margin; without atoms nothing moves.
    pub fn shrink_wrap(&mut self, positions: &[Vec3]) {
        let Some(&first) = positions.first() else { return };
        if !self.shrinks() {
            return;
        }
        let (lo, hi) = positions.iter().fold((first, first), |(lo, hi), x| (lo.inf(x), hi.sup(x)));
        for axis in 0..3 {
            if self.sides[axis][0] == Side::Shrink {
                self.lo[axis] = lo[axis] - self.margin[axis];
            }
            if self.sides[axis][1] == Side::Shrink {
                self.hi[axis] = hi[axis] + self.margin[axis];
            }
        }
    }

    /// Is the position outside a free axis? (Particles there are lost at the next list build.)
    pub fn beyond_fixed_side(&self, x: &Vec3) -> bool {
        (0..3).any(|axis| !self.periodic(axis) && !(x[axis] >= self.lo[axis] && x[axis] < self.hi[axis]))
    }

    pub fn periodic(&self, axis: usize) -> bool {
        self.sides[axis][0] == Side::Periodic
    }

    /// Edge lengths.
    pub fn lengths(&self) -> Vec3 {
        self.hi - self.lo
    }

    pub fn volume(&self) -> f64 {
        let l = self.lengths();
        l.x * l.y * l.z
    }

    /// Brings a position into the box along periodic axes, counting images, with LAMMPS's arithmetic:
    /// one addition or subtraction of the edge per image, the result never below `lo` nor at or above `hi`.
    pub fn wrap(&self, x: &mut Vec3, image: &mut [i32; 3]) {
        for axis in 0..3 {
            if self.periodic(axis) {
                wrap_axis(&mut x[axis], &mut image[axis], self.lo[axis], self.hi[axis]);
            }
        }
    }

    /// Position with its periodic images undone.
    pub fn unwrap(&self, x: &Vec3, image: &[i32; 3]) -> Vec3 {
        let l = self.lengths();
        Vec3::new(x.x + image[0] as f64 * l.x, x.y + image[1] as f64 * l.y, x.z + image[2] as f64 * l.z)
    }
}

fn wrap_axis(x: &mut f64, image: &mut i32, lo: f64, hi: f64) {
    let edge = hi - lo;
    // Far out (LAMMPS would lose such an atom): jump near the box first; one image more or less is settled below.
    let far = ((*x - lo) / edge).floor();
    if far.abs() > 1.0e5 {
        *x = if far.abs() < 1e9 { *x - far * edge } else { lo + (*x - lo).rem_euclid(edge) };
        *image = image.saturating_add(far as i32);
    }
    while *x < lo {
        *x = (*x + edge).max(lo);
        *image -= 1;
    }
    while *x >= hi {
        *x = (*x - edge).max(lo);
        *image += 1;
    }
    // x a hair below lo wraps to hi exactly in floating point, and back to lo: both steps counted, as LAMMPS does.
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shrink_wrapped_sides_follow_the_atoms() {
        use Side::{Fixed, Periodic, Shrink};
        let sides = [[Fixed, Shrink], [Shrink, Fixed], [Periodic, Periodic]];
        let mut simulation_box = SimulationBox::new(Vec3::new(0.0, 1.0, 1.0), Vec3::new(3.0, 3.0, 3.0), sides);
        // Bounds that LAMMPS 22Jul2025 reports for `boundary fs sf p`.
        assert_eq!(simulation_box.lo, Vec3::new(0.0, 0.9998, 1.0));
        assert_eq!(simulation_box.hi, Vec3::new(3.0003, 3.0, 3.0));
        simulation_box.shrink_wrap(&[]);
        assert_eq!(simulation_box.hi.x, 3.0003);
        simulation_box.shrink_wrap(&[Vec3::new(1.0, 2.0, 2.0), Vec3::new(2.0, 1.5, 9.0)]);
        assert_eq!(simulation_box.lo, Vec3::new(0.0, 1.4998, 1.0));
        assert_eq!(simulation_box.hi, Vec3::new(2.0003, 3.0, 3.0));
    }
}
