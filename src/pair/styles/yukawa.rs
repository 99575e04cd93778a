//! `pair_style yukawa`: U(r) = A exp(-kappa r) / r for r < cutoff (LAMMPS doc page `pair_yukawa`; H. Yukawa 1935,
//! doi:10.11429/ppmsj1919.17.0_48).

use crate::pair::{Coefficient, Dimension, Mix, PairStyle, PairValue};
use crate::real::{Convert, Real};

/// Screened Coulomb potential.
pub struct Style;

/// Strength (energy times length) and inverse screening length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R> {
    pub strength: R,
    pub kappa: R,
}

impl PairStyle for Style {
    const NAME: &'static str = "yukawa";
    const FORMULA: &'static str = "A exp(-kappa r) / r";
    const SETTINGS: &'static [Coefficient] =
        &[Coefficient { name: "kappa", dimension: Dimension::INVERSE_LENGTH, mix: Mix::Never, least: None }];
    const COEFFICIENTS: &'static [Coefficient] =
        &[Coefficient { name: "A", dimension: Dimension::ENERGY_LENGTH, mix: Mix::Energy, least: None }];
    type Params<R: Real> = Params<R>;

    fn params(c: &[f64], settings: &[f64], _: f64) -> Params<f64> {
        Params { strength: c[0], kappa: settings[0] }
    }

    #[inline(always)]
    fn map<A: Real, B: Real>(p: &Params<A>, mut convert: impl Convert<A, B>) -> Params<B> {
        Params { strength: convert.convert(p.strength), kappa: convert.convert(p.kappa) }
    }

    #[inline(always)]
    fn eval<R: Real>(r2: R, p: &Params<R>) -> PairValue<R> {
        let inverse = r2.rsqrt();
        let r = r2 * inverse;
        let screened = p.strength * (-(p.kappa * r)).exp();
        let energy = screened * inverse;
        PairValue { force_over_r: screened * (p.kappa + inverse) * (inverse * inverse), energy }
    }
}
