//! What happens to a potential at its cutoff; written once for all styles.

use super::PairValue;
use crate::real::{Convert, Real};

/// A rule that turns U(r) into the potential that acts below the cutoff.
pub trait Truncation: Send + Sync + 'static {
    /// Constants of one pair of types.
    type Params<R: Real>: Copy + Send + Sync + 'static;
    /// Constants from the energy at the cutoff.
    fn params(energy_at_cutoff: f64) -> Self::Params<f64>;
    /// The same constants in another arithmetic: `convert` is called once for each number, always in the same order.
    fn map<A: Real, B: Real>(params: &Self::Params<A>, convert: impl Convert<A, B>) -> Self::Params<B>;
    /// Applies the rule inside the cutoff.
    fn apply<R: Real>(value: PairValue<R>, params: &Self::Params<R>) -> PairValue<R>;
}

/// U(r) as it is: energy jumps at the cutoff.
pub struct Cut;

impl Truncation for Cut {
    type Params<R: Real> = ();
    fn params(_: f64) {}
    #[inline(always)]
    fn map<A: Real, B: Real>(_: &(), _: impl Convert<A, B>) {}
    #[inline(always)]
    fn apply<R: Real>(value: PairValue<R>, _: &()) -> PairValue<R> {
        value
    }
}

/// U(r) - U(cutoff): the force is unchanged (`pair_modify shift yes`).
pub struct Shifted;

impl Truncation for Shifted {
    type Params<R: Real> = R;
    fn params(energy_at_cutoff: f64) -> f64 {
        energy_at_cutoff
    }
    #[inline(always)]
    fn map<A: Real, B: Real>(offset: &A, mut convert: impl Convert<A, B>) -> B {
        convert.convert(*offset)
    }
    #[inline(always)]
    fn apply<R: Real>(value: PairValue<R>, offset: &R) -> PairValue<R> {
        PairValue { force_over_r: value.force_over_r, energy: value.energy - *offset }
    }
}
