//! `pair_style inverse`: U(r) = k ln(cutoff / r), so a force k / r, for r < cutoff. The force of Morillo et al. 2015
//! (doi:10.2312/vriphys.20151339, section 6) as its text has it: "inversely proportional to the distance". LAMMPS has no such
//! style; `pair_write` makes a table of it that LAMMPS reads.

use crate::pair::{Coefficient, Dimension, Mix, PairStyle, PairValue};
use crate::real::{Convert, Real};

/// Repulsion that falls off with the inverse distance, and ends at the cutoff with a step of k / cutoff.
pub struct Style;

/// Strength and where the energy is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R> {
    /// k, energy.
    pub strength: R,
    /// k / 2: the logarithm is taken of squares.
    pub half: R,
    /// Length squared.
    pub cutoff_squared: R,
}

impl PairStyle for Style {
    const NAME: &'static str = "inverse";
    const FORMULA: &'static str = "k ln(cutoff / r)";
    const SETTINGS: &'static [Coefficient] = &[];
    const COEFFICIENTS: &'static [Coefficient] =
        &[Coefficient { name: "k", dimension: Dimension::ENERGY, mix: Mix::Energy, least: None }];
    type Params<R: Real> = Params<R>;

    fn params(c: &[f64], _: &[f64], cutoff: f64) -> Params<f64> {
        Params { strength: c[0], half: 0.5 * c[0], cutoff_squared: cutoff * cutoff }
    }

    #[inline(always)]
    fn map<A: Real, B: Real>(p: &Params<A>, mut convert: impl Convert<A, B>) -> Params<B> {
        Params {
            strength: convert.convert(p.strength),
            half: convert.convert(p.half),
            cutoff_squared: convert.convert(p.cutoff_squared),
        }
    }

    #[inline(always)]
    fn eval<R: Real>(r2: R, p: &Params<R>) -> PairValue<R> {
        let inverse = r2.recip();
        PairValue { force_over_r: p.strength * inverse, energy: p.half * (p.cutoff_squared * inverse).ln() }
    }
}
