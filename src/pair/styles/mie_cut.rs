//! `pair_style mie/cut`: U(r) = C epsilon ((sigma/r)^gammaR - (sigma/r)^gammaA) for r < cutoff, with
//! C = gammaR / (gammaR - gammaA) (gammaR / gammaA)^(gammaA / (gammaR - gammaA)), so that the well is epsilon deep (LAMMPS doc page
//! `pair_mie`; G. Mie 1903, doi:10.1002/andp.19033160802; C. Avendano et al. 2011, doi:10.1021/jp204908d).

use crate::pair::{Coefficient, Dimension, Mix, PairStyle, PairValue};
use crate::real::{Convert, Real};

/// Repulsion and attraction with any two exponents.
pub struct Style;

/// Squared sigma, halved exponents (powers are taken of squares), and prefactors of both powers in force and energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R> {
    pub sigma_squared: R,
    pub repulsive: R,
    pub attractive: R,
    pub force_repulsive: R,
    pub force_attractive: R,
    /// C epsilon.
    pub energy: R,
}

/// C: what makes the well as deep as epsilon.
fn prefactor(repulsive: f64, attractive: f64) -> f64 {
    let difference = repulsive - attractive;
    repulsive / difference * (repulsive / attractive).powf(attractive / difference)
}

impl PairStyle for Style {
    const NAME: &'static str = "mie/cut";
    const FORMULA: &'static str =
        "C epsilon ((sigma/r)^gammaR - (sigma/r)^gammaA), C such that the well is epsilon deep";
    const SETTINGS: &'static [Coefficient] = &[];
    const COEFFICIENTS: &'static [Coefficient] = &[
        Coefficient { name: "epsilon", dimension: Dimension::ENERGY, mix: Mix::Energy, least: None },
        Coefficient { name: "sigma", dimension: Dimension::LENGTH, mix: Mix::Distance, least: None },
        Coefficient { name: "gammaR", dimension: Dimension::NUMBER, mix: Mix::Distance, least: None },
        Coefficient { name: "gammaA", dimension: Dimension::NUMBER, mix: Mix::Distance, least: None },
    ];
    type Params<R: Real> = Params<R>;

    fn params(c: &[f64], _: &[f64], _: f64) -> Params<f64> {
        let [epsilon, sigma, repulsive, attractive] = [c[0], c[1], c[2], c[3]];
        let energy = prefactor(repulsive, attractive) * epsilon;
        Params {
            sigma_squared: sigma * sigma,
            repulsive: 0.5 * repulsive,
            attractive: 0.5 * attractive,
            force_repulsive: energy * repulsive,
            force_attractive: energy * attractive,
            energy,
        }
    }

    #[inline(always)]
    fn map<A: Real, B: Real>(p: &Params<A>, mut convert: impl Convert<A, B>) -> Params<B> {
        Params {
            sigma_squared: convert.convert(p.sigma_squared),
            repulsive: convert.convert(p.repulsive),
            attractive: convert.convert(p.attractive),
            force_repulsive: convert.convert(p.force_repulsive),
            force_attractive: convert.convert(p.force_attractive),
            energy: convert.convert(p.energy),
        }
    }

    #[inline(always)]
    fn eval<R: Real>(r2: R, p: &Params<R>) -> PairValue<R> {
        let s = r2.recip();
        // A power is one exponential more, whatever the exponent; the logarithm serves both.
        let logarithm = (p.sigma_squared * s).ln();
        let repulsive = (p.repulsive * logarithm).exp();
        let attractive = (p.attractive * logarithm).exp();
        PairValue {
            force_over_r: (p.force_repulsive * repulsive - p.force_attractive * attractive) * s,
            energy: p.energy * (repulsive - attractive),
        }
    }

    fn refuses(c: &[f64]) -> Option<&'static str> {
        let finite = prefactor(c[2], c[3]).is_finite();
        (!finite).then_some("expected gammaR and gammaA that differ and have one sign")
    }

    fn tail(p: &Params<f64>, cutoff: f64) -> Option<f64> {
        let beyond = |half: f64| match 2.0 * half {
            exponent if exponent > 3.0 => {
                (p.sigma_squared / (cutoff * cutoff)).powf(half) * cutoff.powi(3) / (exponent - 3.0)
            }
            _ => f64::INFINITY,
        };
        Some(p.energy * (beyond(p.repulsive) - beyond(p.attractive)))
    }
}
