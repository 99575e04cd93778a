//! `pair_style harmonic/cut`: U(r) = K (cutoff - r)^2 for r < cutoff, the usual factor 1/2 being part of K (LAMMPS doc page
//! `pair_harmonic_cut`).

use crate::pair::{Coefficient, Dimension, Mix, PairStyle, PairValue};
use crate::real::{Convert, Real};

/// A spring that only pushes: relaxed at the cutoff and beyond.
pub struct Style;

/// Spring constant and relaxed length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R> {
    /// K, energy / length^2.
    pub stiffness: R,
    /// 2 K.
    pub slope: R,
    /// Length.
    pub cutoff: R,
}

impl PairStyle for Style {
    const NAME: &'static str = "harmonic/cut";
    const FORMULA: &'static str = "K (cutoff - r)^2";
    const SETTINGS: &'static [Coefficient] = &[];
    const COEFFICIENTS: &'static [Coefficient] =
        &[Coefficient { name: "K", dimension: Dimension::STIFFNESS, mix: Mix::Energy, least: None }];
    const GLOBAL_CUTOFF: bool = false;
    type Params<R: Real> = Params<R>;

    fn params(c: &[f64], _: &[f64], cutoff: f64) -> Params<f64> {
        Params { stiffness: c[0], slope: 2.0 * c[0], cutoff }
    }

    #[inline(always)]
    fn map<A: Real, B: Real>(p: &Params<A>, mut convert: impl Convert<A, B>) -> Params<B> {
        Params {
            stiffness: convert.convert(p.stiffness),
            slope: convert.convert(p.slope),
            cutoff: convert.convert(p.cutoff),
        }
    }

    #[inline(always)]
    fn eval<R: Real>(r2: R, p: &Params<R>) -> PairValue<R> {
        let inverse = r2.rsqrt();
        let overlap = p.cutoff - r2 * inverse;
        PairValue { force_over_r: p.slope * overlap * inverse, energy: p.stiffness * overlap * overlap }
    }
}
