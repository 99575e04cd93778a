//! `pair_style lj/cut`: U(r) = 4 epsilon ((sigma/r)^12 - (sigma/r)^6) for r < cutoff (LAMMPS doc page `pair_lj_cut`).

use crate::pair::{Coefficient, Dimension, Mix, PairStyle, PairValue};
use crate::real::{Convert, Real};

/// Lennard-Jones 12-6.
pub struct Style;

/// Prefactors of r^-12 and r^-6 in force and energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R> {
    pub force12: R,
    pub force6: R,
    pub energy12: R,
    pub energy6: R,
}

impl PairStyle for Style {
    const NAME: &'static str = "lj/cut";
    const FORMULA: &'static str = "4 epsilon ((sigma/r)^12 - (sigma/r)^6)";
    const SETTINGS: &'static [Coefficient] = &[];
    const COEFFICIENTS: &'static [Coefficient] = &[
        Coefficient { name: "epsilon", dimension: Dimension::ENERGY, mix: Mix::Energy, least: None },
        Coefficient { name: "sigma", dimension: Dimension::LENGTH, mix: Mix::Distance, least: None },
    ];
    type Params<R: Real> = Params<R>;

    fn params(c: &[f64], _: &[f64], _: f64) -> Params<f64> {
        let (epsilon, sigma) = (c[0], c[1]);
        let (sigma6, sigma12) = (sigma.powf(6.0), sigma.powf(12.0));
        Params {
            force12: 48.0 * epsilon * sigma12,
            force6: 24.0 * epsilon * sigma6,
            energy12: 4.0 * epsilon * sigma12,
            energy6: 4.0 * epsilon * sigma6,
        }
    }

    #[inline(always)]
    fn map<A: Real, B: Real>(p: &Params<A>, mut convert: impl Convert<A, B>) -> Params<B> {
        Params {
            force12: convert.convert(p.force12),
            force6: convert.convert(p.force6),
            energy12: convert.convert(p.energy12),
            energy6: convert.convert(p.energy6),
        }
    }

    #[inline(always)]
    fn eval<R: Real>(r2: R, p: &Params<R>) -> PairValue<R> {
        let s = r2.recip();
        let s3 = s * s * s;
        PairValue {
            force_over_r: s3 * p.force12.mul_add(s3, -p.force6) * s,
            energy: s3 * p.energy12.mul_add(s3, -p.energy6),
        }
    }

    fn tail(p: &Params<f64>, cutoff: f64) -> Option<f64> {
        Some(p.energy12 / (9.0 * cutoff.powi(9)) - p.energy6 / (3.0 * cutoff.powi(3)))
    }
}
