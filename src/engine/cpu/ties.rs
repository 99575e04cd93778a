//! Pairs at exactly the cutoff across a periodic side: rounding decides, and it has to be LAMMPS's rounding.
//!
//! Within rounding, the distance of such a pair depends on which of the two is shifted. LAMMPS lists a pair once, in the row
//! of an owned atom; the other is a copy ("ghost") whose shifted position is rounded before the difference is taken. The
//! copy is the one in the upper bin (by z, then y, then x; edge about half the largest neighbor cutoff) or, in one bin, the
//! one with the upper coordinates. Deciding so in both rows also keeps forces equal and opposite.

use crate::neighbor::LAMMPS_BIN;
use crate::system::{SimulationBox, Vec3};

/// What it takes to repeat LAMMPS's rounding.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ties {
    lo: Vec3,
    hi: Vec3,
    lengths: Vec3,
    /// Bins along each axis.
    bins: Vec3,
    /// Relative width of the band around a squared cutoff in which rounding could decide.
    pub band: f64,
}

impl Ties {
    /// `cutoffs` are the neighbor cutoffs of all pairs of types.
    pub fn new(cutoffs: &[f64], simulation_box: &SimulationBox) -> Self {
        let smallest = cutoffs.iter().copied().filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
        let largest = cutoffs.iter().copied().fold(0.0, f64::max);
        let lengths = simulation_box.lengths();
        let coordinate = simulation_box.lo.amax().max(simulation_box.hi.amax()) + lengths.amax();
        let inverse = 1.0 / (LAMMPS_BIN * largest);
        Self {
            lo: simulation_box.lo,
            hi: simulation_box.hi,
            lengths,
            bins: lengths.map(|l| (l * inverse).floor().max(1.0)),
            band: 64.0 * f64::EPSILON * (1.0 + coordinate / smallest),
        }
    }

    /// The squared distance that LAMMPS finds for particle i and the image of j.
    #[cold]
    pub fn squared_distance(&self, i: &Vec3, j: &Vec3, image: [i32; 3]) -> f64 {
        let above = self.shifted(j, image);
        let d = if self.is_above(&above, i) { i - above } else { j - self.shifted(i, image.map(|n| -n)) };
        d.x * d.x + d.y * d.y + d.z * d.z
    }

    /// A copy's position: one addition of the edge per image.
    fn shifted(&self, x: &Vec3, image: [i32; 3]) -> Vec3 {
        let mut x = *x;
        for axis in 0..3 {
            for _ in 0..image[axis].unsigned_abs() {
                x[axis] += if image[axis] > 0 { self.lengths[axis] } else { -self.lengths[axis] };
            }
        }
        x
    }

    fn is_above(&self, a: &Vec3, b: &Vec3) -> bool {
        let place = |x: &Vec3| {
            let bin = |axis: usize| self.bin(x[axis], axis);
            ([bin(2), bin(1), bin(0)], [x.z, x.y, x.x])
        };
        place(a) > place(b)
    }

    fn bin(&self, x: f64, axis: usize) -> f64 {
        let (lo, hi, bins) = (self.lo[axis], self.hi[axis], self.bins[axis]);
        let inverse = 1.0 / ((hi - lo) / bins);
        if x >= hi {
            ((x - hi) * inverse).trunc() + bins
        } else if x >= lo {
            ((x - lo) * inverse).trunc().min(bins - 1.0)
        } else {
            ((x - lo) * inverse).trunc() - 1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::Side;

    #[test]
    fn both_directions_agree() {
        let periodic = [[Side::Periodic; 2]; 3];
        let simulation_box = SimulationBox::new(Vec3::repeat(0.1), Vec3::new(4.3, 5.2, 3.1), periodic);
        let ties = Ties::new(&[2.8], &simulation_box);
        let (a, b) = (Vec3::new(0.3, 0.7, 0.9), Vec3::new(4.1, 5.1, 0.9));
        for image in [[-1, 0, 0], [0, -1, 0], [-1, -1, 0], [-1, -1, 1], [0, 0, -1], [2, 0, -3]] {
            let back = image.map(|n| -n);
            assert_eq!(ties.squared_distance(&a, &b, image), ties.squared_distance(&b, &a, back), "{image:?}");
            assert_eq!(ties.squared_distance(&a, &a, image), ties.squared_distance(&a, &a, back), "{image:?}");
        }
    }

    #[test]
    fn bins_come_before_coordinates() {
        let periodic = [[Side::Periodic; 2]; 3];
        let simulation_box = SimulationBox::new(Vec3::zeros(), Vec3::repeat(6.0), periodic);
        let ties = Ties::new(&[3.0], &simulation_box);
        // One bin in z, the upper one in y: above, though z is lower.
        assert!(ties.is_above(&Vec3::new(1.0, 1.6, 0.2), &Vec3::new(1.0, 1.4, 0.3)));
        assert!(!ties.is_above(&Vec3::new(1.0, 1.4, 0.2), &Vec3::new(1.0, 1.3, 0.3)));
        assert!(ties.is_above(&Vec3::new(1.0, 1.4, 6.1), &Vec3::new(1.0, 4.3, 5.9)));
    }
}
