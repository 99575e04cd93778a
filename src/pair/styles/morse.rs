//! `pair_style morse`: U(r) = D0 (exp(-2 alpha (r - r0)) - 2 exp(-alpha (r - r0))) for r < cutoff (LAMMPS doc page
//! `pair_morse`; P. M. Morse 1929, doi:10.1103/PhysRev.34.57).

use crate::pair::{Coefficient, Dimension, Mix, PairStyle, PairValue};
use crate::real::{Convert, Real};

/// Morse potential: a well of depth D0 at r0.
pub struct Style;

/// Depth, inverse width, place of the well, and the prefactor of the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R> {
    pub depth: R,
    pub alpha: R,
    pub r0: R,
    /// 2 D0 alpha.
    pub slope: R,
}

impl PairStyle for Style {
    const NAME: &'static str = "morse";
    const FORMULA: &'static str = "D0 (exp(-2 alpha (r - r0)) - 2 exp(-alpha (r - r0)))";
    const SETTINGS: &'static [Coefficient] = &[];
    const COEFFICIENTS: &'static [Coefficient] = &[
        Coefficient { name: "D0", dimension: Dimension::ENERGY, mix: Mix::Never, least: None },
        Coefficient { name: "alpha", dimension: Dimension::INVERSE_LENGTH, mix: Mix::Never, least: None },
        Coefficient { name: "r0", dimension: Dimension::LENGTH, mix: Mix::Never, least: None },
    ];
    type Params<R: Real> = Params<R>;

    fn params(c: &[f64], _: &[f64], _: f64) -> Params<f64> {
        let (depth, alpha, r0) = (c[0], c[1], c[2]);
        Params { depth, alpha, r0, slope: 2.0 * depth * alpha }
    }

    #[inline(always)]
    fn map<A: Real, B: Real>(p: &Params<A>, mut convert: impl Convert<A, B>) -> Params<B> {
        Params {
            depth: convert.convert(p.depth),
            alpha: convert.convert(p.alpha),
            r0: convert.convert(p.r0),
            slope: convert.convert(p.slope),
        }
    }

    #[inline(always)]
    fn eval<R: Real>(r2: R, p: &Params<R>) -> PairValue<R> {
        let inverse = r2.rsqrt();
        let r = r2 * inverse;
        // r is short of the root of r2 by (r2 - r^2) / 2 r: a steep potential multiplies that rounding by alpha, and r0 - r has digits left
        // for it.
        let inward = (R::constant(-0.5) * inverse).mul_add((-r).mul_add(r, r2), p.r0 - r);
        let e = (p.alpha * inward).exp();
        let e2 = e * e;
        PairValue { force_over_r: p.slope * (e2 - e) * inverse, energy: p.depth * (e2 - (e + e)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steep_well_does_not_multiply_the_rounding_of_the_distance() {
        let given = Style::params(&[1.0, 20.0, 1.125], &[], 0.0);
        let single: Params<f32> = Style::map(&given, |x: f64| x as f32);
        let off = |k: i32| {
            let r2 = (0.9 + 1.1 * f64::from(k) / 4000.0) as f32;
            let (exact, found) = (Style::eval(f64::from(r2), &given), Style::eval(r2, &single));
            let r = f64::from(r2).sqrt();
            let e = (given.alpha * (given.r0 - r)).exp();
            // Over what a relative error of the exponential counts for in the force.
            (f64::from(found.force_over_r) - exact.force_over_r).abs() / (given.slope * (2.0 * e * e + e) / r)
        };
        let worst = (0..4000).map(off).fold(0.0, f64::max);
        assert!(worst < 1.2e-6, "{worst:e}; with the rounding of r, 6e-8 of it, it is 2e-6 and more");
    }
}
