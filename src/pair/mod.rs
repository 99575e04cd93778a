//! Pair potentials: the trait a style implements, the registry of all styles, coefficients and mixing, truncation.
//!
//! A style is one file in `styles/` with a type `Style: PairStyle`; `build.rs` registers it.

mod coefficients;
mod table;
pub mod truncation;

pub use coefficients::{Mixing, PairCoefficients};
pub(crate) use table::power_of_two;
pub use table::{PairTable, Tail, TypePair};

use crate::real::{Convert, Real};

include!(concat!(env!("OUT_DIR"), "/pair_styles.rs"));

/// What a pair does at one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairValue<R> {
    /// -U'(r) / r: times the vector from j to i it is the force on i.
    pub force_over_r: R,
    /// U(r).
    pub energy: R,
}

/// How a coefficient of unlike types follows from those of like types (LAMMPS doc page `pair_modify`, keyword mix).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mix {
    /// As an energy (the square root of the product, or the sixth-power rule).
    Energy,
    /// As a distance.
    Distance,
    /// Not at all: unlike pairs must be set by `pair_coeff`.
    Never,
}

/// Powers of energy and length in a coefficient's unit: an inverse length is `{ energy: 0, length: -1 }`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    pub energy: i32,
    pub length: i32,
}

impl Dimension {
    pub const NUMBER: Self = Self { energy: 0, length: 0 };
    pub const ENERGY: Self = Self { energy: 1, length: 0 };
    pub const LENGTH: Self = Self { energy: 0, length: 1 };
    pub const INVERSE_LENGTH: Self = Self { energy: 0, length: -1 };
    pub const ENERGY_LENGTH: Self = Self { energy: 1, length: 1 };
    pub const STIFFNESS: Self = Self { energy: 1, length: -2 };

    /// The unit's size where energies and lengths have units of these sizes.
    pub fn size(self, energy: f64, length: f64) -> f64 {
        energy.powi(self.energy) * length.powi(self.length)
    }
}

/// One number of `pair_coeff` after the two types, or of `pair_style` before the cutoff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficient {
    pub name: &'static str,
    pub dimension: Dimension,
    pub mix: Mix,
    /// Smallest value that makes sense, if there is one.
    pub least: Option<f64>,
}

/// A pair potential of the distance alone.
pub trait PairStyle: Send + Sync + 'static {
    /// Name in the `pair_style` command.
    const NAME: &'static str;
    /// U(r) in words for `octant info`.
    const FORMULA: &'static str;
    /// What `pair_style` takes before the cutoff; none for most. Nothing of it is mixed.
    const SETTINGS: &'static [Coefficient];
    /// What `pair_coeff` takes after the types; a cutoff (length) follows them.
    const COEFFICIENTS: &'static [Coefficient];
    /// `pair_style` takes a cutoff, and that of `pair_coeff` is optional; otherwise every `pair_coeff` must name one.
    const GLOBAL_CUTOFF: bool = true;
    /// Constants of one pair of types, worked out once.
    type Params<R: Real>: Copy + Send + Sync + 'static;

    /// Constants from the values of [`PairStyle::COEFFICIENTS`] and [`PairStyle::SETTINGS`], in their order, and the cutoff.
    fn params(coefficients: &[f64], settings: &[f64], cutoff: f64) -> Self::Params<f64>;
    /// The same constants in another arithmetic: `convert` is called once for each number, always in the same order.
    fn map<A: Real, B: Real>(params: &Self::Params<A>, convert: impl Convert<A, B>) -> Self::Params<B>;
    /// The untruncated formula at squared distance `r2`.
    fn eval<R: Real>(r2: R, params: &Self::Params<R>) -> PairValue<R>;
    /// What is wrong with values of [`PairStyle::COEFFICIENTS`] together, if something is.
    fn refuses(_coefficients: &[f64]) -> Option<&'static str> {
        None
    }
    /// Integral of U(r) r^2 from the cutoff to infinity, energy times volume, for `pair_modify tail`; `None` where LAMMPS
    /// corrects nothing.
    fn tail(_params: &Self::Params<f64>, _cutoff: f64) -> Option<f64> {
        None
    }
}

/// Something to be done for one style, whose type is chosen by its name.
pub trait StyleVisitor {
    type Output;
    fn visit<S: PairStyle>(self) -> Self::Output;
}

/// Calls the visitor with the style of that name; `None` where there is none.
pub fn with_style<V: StyleVisitor>(name: &str, visitor: V) -> Option<V::Output> {
    macro_rules! try_style {
        ($style:ty) => {
            if name == <$style as PairStyle>::NAME {
                return Some(visitor.visit::<$style>());
            }
        };
    }
    for_each!(try_style);
    None
}

/// What `octant info` and error messages say of a style.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StyleInfo {
    pub name: &'static str,
    pub formula: &'static str,
    pub settings: &'static [Coefficient],
    pub coefficients: &'static [Coefficient],
    /// See [`PairStyle::GLOBAL_CUTOFF`].
    pub global_cutoff: bool,
}

/// All registered styles.
pub fn styles() -> Vec<StyleInfo> {
    let mut all = Vec::new();
    macro_rules! describe {
        ($style:ty) => {
            all.push(StyleInfo {
                name: <$style as PairStyle>::NAME,
                formula: <$style as PairStyle>::FORMULA,
                settings: <$style as PairStyle>::SETTINGS,
                coefficients: <$style as PairStyle>::COEFFICIENTS,
                global_cutoff: <$style as PairStyle>::GLOBAL_CUTOFF,
            })
        };
    }
    for_each!(describe);
    all
}

impl StyleInfo {
    /// How the style is asked for in a script.
    pub fn usage(&self) -> String {
        let cutoff = if self.global_cutoff { ["cutoff", "[cutoff]"] } else { ["", "cutoff"] };
        let settings = self.settings.iter().map(|s| s.name).chain([cutoff[0]]);
        let coefficients = self.coefficients.iter().map(|c| c.name).chain([cutoff[1]]);
        let words =
            ["pair_style", self.name].into_iter().chain(settings).chain(["; pair_coeff I J"]).chain(coefficients);
        words.filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" ").replace(" ;", ";")
    }
}
