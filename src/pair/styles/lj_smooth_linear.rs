//! `pair_style lj/smooth/linear`: U(r) = V(r) - V(cutoff) - (r - cutoff) V'(cutoff) for r < cutoff, V being the Lennard-Jones
//! potential of `lj/cut` (LAMMPS doc page `pair_lj_smooth_linear`; S. Toxvaerd and J. C. Dyre 2011, doi:10.1063/1.3558787). Energy
//! and force both end at the cutoff without a step: what plain truncation does to energies and trajectories is not there.

use super::lj_cut;
use crate::pair::{Coefficient, Dimension, Mix, PairStyle, PairValue};
use crate::real::{Convert, Real};

/// Lennard-Jones 12-6, its force shifted to zero at the cutoff.
pub struct Style;

/// Prefactors of r^-12 and r^-6 in force and energy, and what is taken off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R> {
    pub force12: R,
    pub force6: R,
    pub energy12: R,
    pub energy6: R,
    /// -V'(cutoff), energy / length.
    pub slope: R,
    /// -V(cutoff) - cutoff * slope, energy.
    pub offset: R,
}

impl PairStyle for Style {
    const NAME: &'static str = "lj/smooth/linear";
    const FORMULA: &'static str =
        "V(r) - V(cutoff) - (r - cutoff) V'(cutoff), V = 4 epsilon ((sigma/r)^12 - (sigma/r)^6)";
    const SETTINGS: &'static [Coefficient] = &[];
    const COEFFICIENTS: &'static [Coefficient] = &[
        Coefficient { name: "epsilon", dimension: Dimension::ENERGY, mix: Mix::Energy, least: None },
        Coefficient { name: "sigma", dimension: Dimension::LENGTH, mix: Mix::Distance, least: None },
    ];
    type Params<R: Real> = Params<R>;

    fn params(c: &[f64], _: &[f64], cutoff: f64) -> Params<f64> {
        let (epsilon, sigma) = (c[0], c[1]);
        let lj = lj_cut::Style::params(c, &[], cutoff);
        // A pair that is switched off has no cutoff to be shifted at.
        let ratio6 = if cutoff > 0.0 { (sigma / cutoff).powf(6.0) } else { 0.0 };
        let energy = 4.0 * epsilon * ratio6 * (ratio6 - 1.0);
        let slope = if cutoff > 0.0 { 24.0 * epsilon * ratio6 * (2.0 * ratio6 - 1.0) / cutoff } else { 0.0 };
        Params {
            force12: lj.force12,
            force6: lj.force6,
            energy12: lj.energy12,
            energy6: lj.energy6,
            slope,
            offset: -energy - cutoff * slope,
        }
    }

    #[inline(always)]
    fn map<A: Real, B: Real>(p: &Params<A>, mut convert: impl Convert<A, B>) -> Params<B> {
        Params {
            force12: convert.convert(p.force12),
            force6: convert.convert(p.force6),
            energy12: convert.convert(p.energy12),
            energy6: convert.convert(p.energy6),
            slope: convert.convert(p.slope),
            offset: convert.convert(p.offset),
        }
    }

    #[inline(always)]
    fn eval<R: Real>(r2: R, p: &Params<R>) -> PairValue<R> {
        let inverse = r2.rsqrt();
        let r = r2 * inverse;
        let s = inverse * inverse;
        let s3 = s * s * s;
        PairValue {
            force_over_r: (s3 * p.force12.mul_add(s3, -p.force6) * inverse - p.slope) * inverse,
            energy: s3 * p.energy12.mul_add(s3, -p.energy6) + p.slope.mul_add(r, p.offset),
        }
    }
}
