//! The orthogonal simulation box: sides, kind of boundary, wrapping.

use super::state::{Vec3, bounds};
use crate::real::Whole;

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

/// What becomes of atoms that leave through a fixed side (`thermo_modify lost`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LostAtoms {
    /// The run stops.
    #[default]
    Error,
    /// They are removed, with a warning.
    Warn,
    /// They are removed.
    Ignore,
}

/// An orthogonal box. Lengths in the scene's units.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationBox {
    pub lo: Vec3,
    pub hi: Vec3,
    /// `sides[axis] = [low side, high side]`; both or neither are periodic.
    pub sides: [[Side; 2]; 3],
    /// Distance kept between a shrink-wrapped side and the outermost atom: 1e-4 of the edge as first given.
    pub margin: Vec3,
}

/// See [`SimulationBox::margin`].
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
        if !self.shrinks() {
            return;
        }
        let Some((lo, hi)) = bounds(positions) else { return };
        for axis in 0..3 {
            if self.sides[axis][0] == Side::Shrink {
                self.lo[axis] = lo[axis] - self.margin[axis];
            }
            if self.sides[axis][1] == Side::Shrink {
                self.hi[axis] = hi[axis] + self.margin[axis];
            }
        }
    }

    /// The first axis along which a position is outside. (Particles that are after wrapping are lost at a list build.)
    pub fn outside(&self, x: &Vec3) -> Option<usize> {
        (0..3).find(|axis| !(self.lo[*axis]..self.hi[*axis]).contains(&x[*axis]))
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

    /// The same by at most one image along each axis, as LAMMPS does at list builds; what is further out stays outside.
    pub fn wrap_once(&self, x: &mut Vec3, image: &mut [i32; 3]) {
        // Most coordinates are inside already.
        let is_outside = |axis: usize, x: &Vec3| !(self.lo[axis] <= x[axis] && x[axis] < self.hi[axis]);
        for axis in 0..3 {
            if !is_outside(axis, x) || !self.periodic(axis) {
                continue;
            }
            let (wrapped, images) = wrap_once(x[axis], self.lo[axis], self.hi[axis]);
            x[axis] = wrapped;
            image[axis] = image[axis].saturating_add(images as i32);
        }
    }

    /// Position with its periodic images undone.
    pub fn unwrap(&self, x: &Vec3, image: &[i32; 3]) -> Vec3 {
        let l = self.lengths();
        Vec3::new(x.x + image[0] as f64 * l.x, x.y + image[1] as f64 * l.y, x.z + image[2] as f64 * l.z)
    }
}

/// A coordinate brought back by at most one edge, and the number of images this counts.
#[inline(always)]
pub fn wrap_once<R: Whole>(x: R, lo: R, hi: R) -> (R, R) {
    let (zero, one) = (R::constant(0.0), R::constant(1.0));
    let edge = hi - lo;
    let raised = R::select(x.less(lo), x + edge, x);
    let below = R::select(x.less(lo), -one, zero);
    let inside = raised.less(hi);
    let lowered = R::select(inside, raised, (raised - edge).greater(lo));
    (lowered, below + R::select(inside, zero, one))
}

/// Farther out than this many edges, a position is brought back in one go, which costs its last bits.
const FAR: f64 = 1.0e5;

fn wrap_axis(x: &mut f64, image: &mut i32, lo: f64, hi: f64) {
    let edge = hi - lo;
    let edges_away = ((*x - lo) / edge).floor();
    if edges_away.abs() > FAR {
        *x = lo + (*x - lo).rem_euclid(edge);
        *image = image.saturating_add(edges_away as i32);
    }
    if *x < lo {
        while *x < lo {
            *x += edge;
            *image = image.saturating_sub(1);
        }
        *x = x.max(lo);
    }
    // x a hair below lo is exactly hi now, and comes back to lo: both steps counted, as LAMMPS does.
    while *x >= hi {
        *x = (*x - edge).max(lo);
        *image = image.saturating_add(1);
    }
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

    #[test]
    fn positions_wrap_from_any_number_of_edges_away() {
        let periodic = [[Side::Periodic; 2]; 3];
        let simulation_box = SimulationBox::new(Vec3::zeros(), Vec3::repeat(10.0), periodic);
        let wrapped = |x: f64| {
            let (mut x, mut image) = (Vec3::new(x, 1.0, 1.0), [5, 0, 0]);
            simulation_box.wrap(&mut x, &mut image);
            (x.x, image[0])
        };
        // Values LAMMPS 22Jul2025 reads from a data file.
        assert_eq!(wrapped(12345.678), (5.677999999999884, 1239));
        assert_eq!(wrapped(-13.3).1, 3);
        assert!((wrapped(-13.3).0 - 6.7).abs() < 1e-14);
        assert_eq!(wrapped(-1e-17), (0.0, 5));
        assert_eq!(wrapped(10.0), (0.0, 6));
        // Far out nothing hangs or overflows.
        assert!((0.0..10.0).contains(&wrapped(1e300).0));
        assert!((0.0..10.0).contains(&wrapped(-1e300).0));
    }
}
