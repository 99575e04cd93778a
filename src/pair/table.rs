//! The finished coefficients of a scene: one entry for each ordered pair of types.

use std::f64::consts::PI;

use super::{Coefficient, PairStyle, StyleInfo, StyleVisitor, styles, with_style};
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
    /// Energy and pressure that are shown hold what lies beyond the cutoff.
    pub tail: bool,
    pub types: usize,
    /// `types * types` entries, row-major, types from 0.
    pub pairs: Vec<TypePair>,
    /// Values of the style's settings.
    pub settings: Vec<f64>,
}

/// What pairs beyond the cutoff would add where atoms lie evenly, once divided by the volume (LAMMPS doc page `pair_modify`,
/// keyword tail; D. Frenkel and B. Smit, Understanding Molecular Simulation, section 3.2.2). Forces have none of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tail {
    /// To the potential energy, energy times volume.
    pub energy: f64,
    /// To each of the virial's xx, yy, zz, energy times volume.
    pub virial: f64,
}

/// A number for each pair of types, row-major.
pub type PerTypePair = Vec<f64>;

impl PairTable {
    /// Powers of two near the table's own energy and length, in the scene's units. In units of these, numbers fit into f32
    /// whatever the unit system: SI has lengths of 1e-10 whose twelfth power is no f32.
    pub fn scales(&self) -> (f64, f64) {
        let length = power_of_two(self.largest_cutoff() / 2.5);
        let style = style_info(self.style);
        let energies = self.pairs.iter().flat_map(|pair| style.coefficients.iter().zip(&pair.coefficients));
        let energies = energies.filter(|(c, _)| c.dimension.energy == 1);
        let sizes = energies.map(|(c, value)| value.abs() / length.powi(c.dimension.length));
        (power_of_two(sizes.fold(0.0, f64::max)), length)
    }

    /// The same table in units of these scales. With powers of two nothing is rounded.
    pub fn scaled(&self, energy: f64, length: f64) -> PairTable {
        let style = style_info(self.style);
        let scale = |names: &[Coefficient], values: &[f64]| -> Vec<f64> {
            names.iter().zip(values).map(|(c, value)| value / c.dimension.size(energy, length)).collect()
        };
        let pair = |pair: &TypePair| TypePair {
            coefficients: scale(style.coefficients, &pair.coefficients),
            cutoff: pair.cutoff / length,
            energy_at_cutoff: pair.energy_at_cutoff / energy,
        };
        let pairs = self.pairs.iter().map(pair).collect();
        PairTable { pairs, settings: scale(style.settings, &self.settings), ..self.clone() }
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

    /// Whether the style has tail corrections at all.
    pub fn has_tail(&self) -> bool {
        self.pairs.first().is_some_and(|pair| self.beyond(pair).is_some())
    }

    /// A pair that is switched off has no cutoff that a tail could begin at, and a potential may fall off too slowly for one.
    pub(super) fn check_tail(&self) -> Result<(), String> {
        if !self.tail || !self.has_tail() {
            return Ok(());
        }
        for (k, pair) in self.pairs.iter().enumerate() {
            let (i, j) = (k / self.types + 1, k % self.types + 1);
            if pair.cutoff <= 0.0 {
                return Err(format!("pair_modify tail: expected a cutoff above 0 for types {i} {j}, got 0"));
            }
            if self.beyond(pair).is_some_and(|integral| !integral.is_finite()) {
                return Err(format!(
                    "pair_modify tail: expected a potential that falls off faster than r^-3 for types {i} {j}"
                ));
            }
        }
        Ok(())
    }

    /// Tail corrections where there are so many atoms of each type (from 0); none unless they are asked for.
    pub fn tail(&self, atoms: &[usize]) -> Tail {
        let mut tail = Tail::default();
        if !self.tail {
            return tail;
        }
        let pairs = (0..self.types).flat_map(|i| (0..self.types).map(move |j| (i, j)));
        for ((i, j), pair) in pairs.zip(&self.pairs) {
            let Some(integral) = self.beyond(pair) else { continue };
            // By parts: the integral of -U'(r) r^3 is r^3 U at the cutoff and three times that of U r^2.
            let virial = pair.cutoff.powi(3) * pair.energy_at_cutoff + 3.0 * integral;
            let count = atoms[i] as f64 * atoms[j] as f64;
            tail.energy += 2.0 * PI * count * integral;
            tail.virial += 2.0 * PI / 3.0 * count * virial;
        }
        tail
    }

    /// [`PairStyle::tail`] of a pair of types.
    fn beyond(&self, pair: &TypePair) -> Option<f64> {
        struct Beyond<'a>(&'a TypePair, &'a [f64]);
        impl StyleVisitor for Beyond<'_> {
            type Output = Option<f64>;
            fn visit<S: PairStyle>(self) -> Self::Output {
                let Beyond(pair, settings) = self;
                S::tail(&S::params(&pair.coefficients, settings, pair.cutoff), pair.cutoff)
            }
        }
        with_style(self.style, Beyond(pair, &self.settings)).flatten()
    }

    /// U(r) and -U'(r)/r of a pair of types (from 0), 0 from the cutoff on.
    pub fn evaluate(&self, i: usize, j: usize, r: f64) -> Option<super::PairValue<f64>> {
        struct At<'a>(&'a TypePair, &'a [f64], bool, f64);
        impl StyleVisitor for At<'_> {
            type Output = super::PairValue<f64>;
            fn visit<S: PairStyle>(self) -> Self::Output {
                let At(pair, settings, shift, r) = self;
                if r * r >= pair.cutoff * pair.cutoff {
                    return super::PairValue { force_over_r: 0.0, energy: 0.0 };
                }
                let value = S::eval::<f64>(r * r, &S::params(&pair.coefficients, settings, pair.cutoff));
                if shift {
                    Shifted::apply(value, &Shifted::params(pair.energy_at_cutoff))
                } else {
                    Cut::apply(value, &())
                }
            }
        }
        with_style(self.style, At(self.pairs.get(i * self.types + j)?, &self.settings, self.shift, r))
    }
}

/// What is known of a registered style.
fn style_info(name: &str) -> StyleInfo {
    styles().into_iter().find(|style| style.name == name).expect("a table names a registered style")
}

/// The power of two nearest to a positive number, 1 for others.
pub(crate) fn power_of_two(x: f64) -> f64 {
    if x > 0.0 && x.is_finite() { x.log2().round().clamp(-300.0, 300.0).exp2() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::{Mix, PairCoefficients};
    use super::*;

    #[test]
    fn scaling_changes_units_and_nothing_else() {
        for style in styles() {
            // The same potential in units of its own and in units like SI's.
            for (energy, length) in [(1.0, 1.0), (1.65e-21, 3.4e-10), (3e5, 700.0)] {
                let value = |c: &Coefficient, k: usize| (1.3 - 0.2 * k as f64) * c.dimension.size(energy, length);
                let mut given = PairCoefficients::new(style.name, 0.0, 1).unwrap();
                let settings = style.settings.iter().enumerate().map(|(k, c)| value(c, k)).collect();
                given.reset(settings, 2.5 * length);
                let words: Vec<String> =
                    style.coefficients.iter().enumerate().map(|(k, c)| value(c, k).to_string()).collect();
                let cutoff = (2.5 * length).to_string();
                let words: Vec<&str> = words.iter().chain([&cutoff]).map(String::as_str).collect();
                given.set((1, 1), (1, 1), &words).unwrap();
                given.shift = true;
                let table = given.complete().unwrap().0;
                let (e, l) = table.scales();
                let scaled = table.scaled(e, l);
                assert!((0.4..2.5).contains(&(l / length)) && (0.4..2.5).contains(&(e / energy)), "{}", style.name);
                for k in 1..50 {
                    let r = (0.7 + 0.035 * k as f64) * length;
                    let (plain, other) = (table.evaluate(0, 0, r).unwrap(), scaled.evaluate(0, 0, r / l).unwrap());
                    let force_unit = e / (l * l);
                    assert!((plain.energy - other.energy * e).abs() <= 1e-14 * plain.energy.abs().max(energy));
                    let error = plain.force_over_r - other.force_over_r * force_unit;
                    assert!(error.abs() <= 1e-14 * plain.force_over_r.abs().max(energy / (length * length)));
                }
            }
            assert!(style.settings.iter().all(|c| c.mix == Mix::Never), "{}: nothing mixes settings", style.name);
        }
    }

    #[test]
    fn reduced_units_need_no_scaling() {
        let mut given = PairCoefficients::new("lj/cut", 2.5, 1).unwrap();
        given.set((1, 1), (1, 1), &["1.0", "1.0"]).unwrap();
        assert_eq!(given.complete().unwrap().0.scales(), (1.0, 1.0));
    }
}
