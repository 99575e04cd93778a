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
}

impl SimulationBox {
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
    if far.abs() > 4.0 && far.abs() < i32::MAX as f64 / 2.0 {
        *x -= far * edge;
        *image += far as i32;
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
