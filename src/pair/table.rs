//! The finished coefficients of a scene: one entry for each ordered pair of types.

use super::{PairStyle, StyleVisitor, with_style};
use crate::pair::truncation::{Cut, Shifted, Truncation};

/// Coefficients of one pair of types.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TypePair {
    /// In the style's order.
    pub coefficients: Vec<f64>,
    /// Length units; 0 switches the pair off.
    pub cutoff: f64,
    /// U(cutoff), energy units.
    pub energy_at_cutoff: f64,
}

/// Complete, symmetric pair coefficients of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct PairTable {
    /// Registered name.
    pub style: &'static str,
    /// Energies are shifted to 0 at the cutoff.
    pub shift: bool,
    pub types: usize,
    /// `types * types` entries, row-major, types from 0.
    pub pairs: Vec<TypePair>,
    pub settings: Vec<f64>,
}

/// A number for each pair of types, row-major.
pub type PerTypePair = Vec<f64>;

impl PairTable {
    pub fn scales(&self) -> (f64, f64) {
        (1.0, 1.0)
    }
    pub fn scaled(&self, _energy: f64, _length: f64) -> PairTable {
        self.clone()
    }
    /// Largest cutoff, length units.
    pub fn largest_cutoff(&self) -> f64 {
        self.pairs.iter().map(|p| p.cutoff).fold(0.0, f64::max)
    }

    /// Squared force cutoffs.
    pub fn squared_cutoffs(&self) -> PerTypePair {
        self.pairs.iter().map(|p| p.cutoff * p.cutoff).collect()
    }

    /// Neighbor cutoffs R = cutoff + skin; a pair that is switched off has none (LAMMPS adds no skin to a zero cutoff).
    pub fn neighbor_cutoffs(&self, skin: f64) -> PerTypePair {
        self.squared_cutoffs().iter().map(|c2| if *c2 > 0.0 { c2.sqrt() + skin } else { 0.0 }).collect()
    }

    /// U(r) and -U'(r)/r of a pair of types (from 0), 0 from the cutoff on.
    pub fn evaluate(&self, i: usize, j: usize, r: f64) -> Option<super::PairValue<f64>> {
        struct At<'a>(&'a TypePair, bool, f64);
        impl StyleVisitor for At<'_> {
            type Output = super::PairValue<f64>;
            fn visit<S: PairStyle>(self) -> Self::Output {
                let At(pair, shift, r) = self;
                if r * r >= pair.cutoff * pair.cutoff {
                    return super::PairValue { force_over_r: 0.0, energy: 0.0 };
                }
                let value = S::eval::<f64>(r * r, &S::params(&pair.coefficients, &[]));
                if shift {
                    Shifted::apply(value, &Shifted::params(pair.energy_at_cutoff))
                } else {
                    Cut::apply(value, &())
                }
            }
        }
        with_style(self.style, At(self.pairs.get(i * self.types + j)?, self.shift, r))
    }
}
