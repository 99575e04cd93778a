//! Pairs at exactly the cutoff across a periodic side: rounding decides, and it has to be LAMMPS's rounding.
//!
//! Within rounding, the distance of such a pair depends on which of the two is shifted. LAMMPS lists a pair once, in the row
//! of an owned atom; the other is a copy ("ghost") whose shifted position is rounded before the difference is taken. The
//! copy is the one in the upper bin (by z, then y, then x; edge about half the largest neighbor cutoff) or, in one bin, the
//! one with the upper coordinates. Deciding so in both rows also keeps forces equal and opposite.

use super::LAMMPS_BIN;
use crate::real::{Real, Whole};
use crate::system::{SimulationBox, Vec3};

/// What it takes to repeat LAMMPS's rounding.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ties {
    pub sides: TieBox<f64>,
    /// Relative width of the band around a squared cutoff in which rounding could decide.
    pub band: f64,
}

/// The box as ties see it.
#[derive(Clone, Copy, Debug, Default)]
pub struct TieBox<R> {
    pub lo: [R; 3],
    pub hi: [R; 3],
    pub lengths: [R; 3],
    /// LAMMPS's bins along each axis, and bins in a unit of length.
    pub bins: [R; 3],
    pub inverse_bin: [R; 3],
}

impl Ties {
    /// `cutoffs` are the neighbor cutoffs of all pairs of types.
    pub fn new(cutoffs: &[f64], simulation_box: &SimulationBox) -> Self {
        let smallest = cutoffs.iter().copied().filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
        let largest = cutoffs.iter().copied().fold(0.0, f64::max);
        let lengths = simulation_box.lengths();
        let coordinate = simulation_box.lo.amax().max(simulation_box.hi.amax()) + lengths.amax();
        let inverse = 1.0 / (LAMMPS_BIN * largest);
        let (lo, hi) = (simulation_box.lo, simulation_box.hi);
        let bins = lengths.map(|l| (l * inverse).floor().max(1.0));
        let inverse_bin = std::array::from_fn(|a| 1.0 / ((hi[a] - lo[a]) / bins[a]));
        let sides = TieBox { lo: lo.into(), hi: hi.into(), lengths: lengths.into(), bins: bins.into(), inverse_bin };
        Self { sides, band: 64.0 * f64::EPSILON * (1.0 + coordinate / smallest) }
    }

    /// The squared distance that LAMMPS finds for particle i and the image of j.
    #[cold]
    pub fn squared_distance(&self, i: &Vec3, j: &Vec3, image: [i32; 3]) -> f64 {
        let most = image.map(i32::unsigned_abs);
        tied_squared_distance(&self.sides, (*i).into(), (*j).into(), image.map(f64::from), most)
    }

    /// Whether particle i and the image of j are at most the square root of `limit` apart, as LAMMPS finds it.
    #[cold]
    pub fn hold(&self, i: &Vec3, j: &Vec3, image: [i32; 3], limit: f64) -> bool {
        let most = image.map(i32::unsigned_abs);
        hold(&self.sides, (*i).into(), (*j).into(), image.map(f64::from), (limit, self.band), most) != 0.0
    }
}

/// Squared distance of i and j where j stands at j + image * lengths, in the order of operations that lists are decided with.
#[inline(always)]
pub fn squared_distance<R: Whole>(i: [R; 3], j: [R; 3], image: [R; 3], lengths: [R; 3]) -> R {
    squared(std::array::from_fn(|a| i[a] - (j[a] + image[a] * lengths[a])))
}

/// 1 where rounding could decide on which side of `limit` a squared distance across a periodic side is, else 0.
#[inline(always)]
pub fn is_tied<R: Real>(squared: R, limit: R, band: R) -> R {
    let (off, width) = (squared - limit, band * limit);
    let (zero, one) = (R::constant(0.0), R::constant(1.0));
    R::select(width.less(off), zero, R::select(width.less(-off), zero, one))
}

/// 1 where i and the image of j are neighbors: at most the square root of `limit` apart, with LAMMPS's rounding where it could
/// decide; else 0. `band` is the relative width of the band in which it could.
pub fn hold<R: Whole>(
    sides: &TieBox<R>,
    i: [R; 3],
    j: [R; 3],
    image: [R; 3],
    (limit, band): (R, R),
    most: [u32; 3],
) -> R {
    let (zero, one) = (R::constant(0.0), R::constant(1.0));
    let squared = squared_distance(i, j, image, sides.lengths);
    let within = |squared: R| R::select(limit.less(squared), zero, one);
    if most == [0; 3] {
        return within(squared);
    }
    // A pair that is switched off has no ties: it is listed where particles coincide.
    let tied = R::select(zero.less(limit), within(tied_squared_distance(sides, i, j, image, most)), zero);
    let away = image[0] * image[0] + image[1] * image[1] + image[2] * image[2];
    let across = R::select(zero.less(away), is_tied(squared, limit, band), zero);
    R::select(zero.less(across), tied, within(squared))
}

/// [`squared_distance`] with LAMMPS's rounding; no image lies further out than `most` edges.
pub fn tied_squared_distance<R: Whole>(sides: &TieBox<R>, i: [R; 3], j: [R; 3], image: [R; 3], most: [u32; 3]) -> R {
    let above = shifted(sides, j, image, most);
    let below = shifted(sides, i, image.map(|n| -n), most);
    let is_above = R::constant(0.0).less(order(sides, above, i));
    squared(std::array::from_fn(|a| R::select(is_above, i[a] - above[a], j[a] - below[a])))
}

fn squared<R: Whole>(d: [R; 3]) -> R {
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

/// A copy's position: one addition of the edge per image.
fn shifted<R: Whole>(sides: &TieBox<R>, x: [R; 3], image: [R; 3], most: [u32; 3]) -> [R; 3] {
    let mut x = x;
    for a in 0..3 {
        let positive = R::constant(0.0).less(image[a]);
        let edge = R::select(positive, sides.lengths[a], -sides.lengths[a]);
        let images = R::select(positive, image[a], -image[a]);
        for k in 0..most[a] {
            x[a] = R::select(R::constant(k.into()).less(images), x[a] + edge, x[a]);
        }
    }
    x
}

/// Above zero where `a` comes after `b`: by bin (z, y, x), then by coordinate (z, y, x).
fn order<R: Whole>(sides: &TieBox<R>, a: [R; 3], b: [R; 3]) -> R {
    let mut outcome = R::constant(0.0);
    let compare = |a: R, b: R, otherwise: R| {
        R::select(b.less(a), R::constant(1.0), R::select(a.less(b), R::constant(-1.0), otherwise))
    };
    for axis in 0..3 {
        outcome = compare(a[axis], b[axis], outcome);
    }
    for axis in 0..3 {
        outcome = compare(bin(sides, a[axis], axis), bin(sides, b[axis], axis), outcome);
    }
    outcome
}

fn bin<R: Whole>(sides: &TieBox<R>, x: R, axis: usize) -> R {
    let (lo, hi, bins, inverse) = (sides.lo[axis], sides.hi[axis], sides.bins[axis], sides.inverse_bin[axis]);
    let one = R::constant(1.0);
    let beyond = ((x - hi) * inverse).trunc() + bins;
    let from_low = ((x - lo) * inverse).trunc();
    R::select(x.less(hi), R::select(x.less(lo), from_low - one, from_low.lesser(bins - one)), beyond)
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
        let is_above = |a: [f64; 3], b: [f64; 3]| order(&ties.sides, a, b) > 0.0;
        // One bin in z, the upper one in y: above, though z is lower.
        assert!(is_above([1.0, 1.6, 0.2], [1.0, 1.4, 0.3]));
        assert!(!is_above([1.0, 1.4, 0.2], [1.0, 1.3, 0.3]));
        assert!(is_above([1.0, 1.4, 6.1], [1.0, 4.3, 5.9]));
    }
}
