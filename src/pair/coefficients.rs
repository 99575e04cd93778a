//! Coefficients as the script gives them, and the mixing rules that fill the gaps.

use super::{Mix, PairTable, StyleInfo, StyleVisitor, TypePair, styles, with_style};
use crate::script::parse_number;

/// Rule for coefficients of unlike types (LAMMPS doc page `pair_modify`, keyword mix).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mixing {
    #[default]
    Geometric,
    Arithmetic,
    SixthPower,
}

impl Mixing {
    /// Names in the `pair_modify` command, in the order of [`Mixing::ALL`].
    pub const NAMES: [&'static str; 3] = ["geometric", "arithmetic", "sixthpower"];
    /// All rules.
    pub const ALL: [Mixing; 3] = [Mixing::Geometric, Mixing::Arithmetic, Mixing::SixthPower];

    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    fn distance(self, a: f64, b: f64) -> f64 {
        match self {
            Mixing::Geometric => (a * b).sqrt(),
            Mixing::Arithmetic => 0.5 * (a + b),
            Mixing::SixthPower => (0.5 * (a.powf(6.0) + b.powf(6.0))).powf(1.0 / 6.0),
        }
    }

    /// `a` and `b` are energies, `s` and `t` the lengths that belong to them (sigma).
    fn energy(self, a: f64, b: f64, s: f64, t: f64) -> f64 {
        match self {
            Mixing::Geometric | Mixing::Arithmetic => (a * b).sqrt(),
            Mixing::SixthPower => 2.0 * (a * b).sqrt() * s.powf(3.0) * t.powf(3.0) / (s.powf(6.0) + t.powf(6.0)),
        }
    }
}

/// What the script said of one pair of types.
#[derive(Clone, Debug, PartialEq)]
struct Given {
    coefficients: Vec<f64>,
    cutoff: f64,
    /// The cutoff stood in `pair_coeff` itself, not in `pair_style`.
    own_cutoff: bool,
}

/// The pair part of a scene while the script is read.
#[derive(Clone, Debug, PartialEq)]
pub struct PairCoefficients {
    style: StyleInfo,
    /// Values of the style's settings.
    settings: Vec<f64>,
    /// Cutoff of `pair_style`, length units.
    pub global_cutoff: f64,
    pub mixing: Mixing,
    /// `pair_modify shift yes`.
    pub shift: bool,
    /// `pair_modify tail yes`.
    pub tail: bool,
    types: usize,
    /// Upper triangle by `i * types + j`, i <= j from 0.
    given: Vec<Option<Given>>,
}

impl PairCoefficients {
    /// Style of that name for `types` atom types (0 while there is no box); the error lists what there is. Settings, if the
    /// style has some, come with [`PairCoefficients::reset`].
    pub fn new(name: &str, global_cutoff: f64, types: usize) -> Result<Self, String> {
        let all = styles();
        let Some(style) = all.iter().find(|s| s.name == name) else {
            let names: Vec<_> = all.iter().map(|s| s.name).collect();
            return Err(format!("pair style '{name}' is not part of octant; available: {}", names.join(", ")));
        };
        let given = vec![None; types * types];
        let settings = vec![0.0; style.settings.len()];
        Ok(Self {
            style: *style,
            settings,
            global_cutoff,
            mixing: Mixing::default(),
            shift: false,
            tail: false,
            types,
            given,
        })
    }

    /// The style's name and coefficients.
    pub fn style(&self) -> &StyleInfo {
        &self.style
    }

    /// Tells how many atom types there are, once the box is known.
    pub fn set_types(&mut self, types: usize) {
        if types != self.types {
            self.types = types;
            self.given = vec![None; types * types];
        }
    }

    /// Settings and cutoff of a `pair_style` command, maybe a repeated one of the same name: cutoffs given in `pair_coeff` fall
    /// back to the new global one, as in LAMMPS, if the style has one.
    pub fn reset(&mut self, settings: Vec<f64>, cutoff: f64) {
        self.settings = settings;
        self.global_cutoff = cutoff;
        if !self.style.global_cutoff {
            return;
        }
        for given in self.given.iter_mut().flatten() {
            given.cutoff = cutoff;
            given.own_cutoff = false;
        }
    }

    /// Sets the pairs `rows` x `columns` (type ranges from 1, inclusive); `words` are the values after the types.
    /// The error names the index of the bad word in `words`.
    pub fn set(
        &mut self,
        rows: (usize, usize),
        columns: (usize, usize),
        words: &[&str],
    ) -> Result<(), (usize, String)> {
        let wanted = self.style.coefficients.len();
        let least = wanted + usize::from(!self.style.global_cutoff);
        if words.len() < least || words.len() > wanted + 1 {
            let names: Vec<_> = self.style.coefficients.iter().map(|c| c.name).collect();
            let at = if words.len() < least { words.len().saturating_sub(1) } else { wanted + 1 };
            let (count, cutoff) = match self.style.global_cutoff {
                true => (format!("{wanted} to {}", wanted + 1), "[cutoff]"),
                false => (least.to_string(), "cutoff"),
            };
            let (names, got) = (names.join(" "), words.len());
            return Err((at, format!("expected {count} values after the types ({names} {cutoff}), got {got}")));
        }
        let mut values = Vec::with_capacity(words.len());
        for (k, text) in words.iter().enumerate() {
            let name = self.style.coefficients.get(k).map_or("cutoff", |c| c.name);
            let least = if k == wanted { Some(0.0) } else { self.style.coefficients[k].least };
            match parse_number(text).filter(|x| x.is_finite()) {
                None => return Err((k, format!("expected {name}, a finite number, got '{text}'"))),
                Some(x) if least.is_some_and(|l| x < l) => {
                    return Err((k, format!("expected {name} of at least {}, got '{text}'", least.unwrap_or(0.0))));
                }
                Some(x) => values.push(x),
            }
        }
        let own_cutoff = values.len() > wanted;
        let cutoff = if own_cutoff { values[wanted] } else { self.global_cutoff };
        values.truncate(wanted);
        if let Some(why) = self.refuses(&values) {
            return Err((wanted - 1, why.to_string()));
        }
        // LAMMPS takes `2 1` for `1 2`.
        let single = rows.0 == rows.1 && columns.0 == columns.1;
        let (rows, columns) = if single && rows.0 > columns.0 { (columns, rows) } else { (rows, columns) };
        let mut any = false;
        for i in rows.0..=rows.1 {
            for j in columns.0.max(i)..=columns.1 {
                self.given[(i - 1) * self.types + j - 1] =
                    Some(Given { coefficients: values.clone(), cutoff, own_cutoff });
                any = true;
            }
        }
        if any { Ok(()) } else { Err((0, "expected types I <= J: no pair is set".to_string())) }
    }

    /// Fills unlike pairs by mixing. The error says which pair has no coefficients.
    /// Also counts mixed and mixable pairs, which the log reports.
    pub fn complete(&self) -> Result<(PairTable, usize, usize), String> {
        if self.shift && self.tail {
            return Err("pair_modify: shift and tail cannot both be yes".into());
        }
        let n = self.types;
        let mut pairs = vec![TypePair::default(); n * n];
        let mut mixed = 0;
        for i in 0..n {
            for j in i..n {
                let pair = match &self.given[i * n + j] {
                    Some(given) => self.pair(given.coefficients.clone(), given.cutoff),
                    None => {
                        mixed += 1;
                        self.mix(i, j)?
                    }
                };
                pairs[j * n + i] = pair.clone();
                pairs[i * n + j] = pair;
            }
        }
        let (style, shift, tail, settings) = (self.style.name, self.shift, self.tail, self.settings.clone());
        let table = PairTable { style, shift, tail, types: n, settings, pairs };
        table.check_tail()?;
        Ok((table, mixed, n * (n - 1) / 2))
    }

    fn mix(&self, i: usize, j: usize) -> Result<TypePair, String> {
        let missing = || format!("pair_coeff for types {} {} is missing", i + 1, j + 1);
        let like = |k: usize| self.given[k * self.types + k].as_ref();
        let (Some(a), Some(b)) = (like(i), like(j)) else { return Err(missing()) };
        if i == j || self.style.coefficients.iter().any(|c| c.mix == Mix::Never) {
            return Err(missing());
        }
        let length = self.style.coefficients.iter().position(|c| c.mix == Mix::Distance);
        // Where there is no sigma, a cutoff that is a coefficient stands for it.
        let (s, t) = match length {
            Some(k) => (a.coefficients[k], b.coefficients[k]),
            None if !self.style.global_cutoff => (a.cutoff, b.cutoff),
            None => (1.0, 1.0),
        };
        let mut values = Vec::with_capacity(a.coefficients.len());
        for (c, (x, y)) in self.style.coefficients.iter().zip(a.coefficients.iter().zip(&b.coefficients)) {
            values.push(match c.mix {
                Mix::Distance => self.mixing.distance(*x, *y),
                Mix::Energy | Mix::Never => self.mixing.energy(*x, *y, s, t),
            });
        }
        if values.iter().any(|x| !x.is_finite()) || self.refuses(&values).is_some() {
            return Err(format!(
                "mixing the coefficients of types {} and {} gives no number; set pair_coeff {} {}",
                i + 1,
                j + 1,
                i + 1,
                j + 1
            ));
        }
        Ok(self.pair(values, self.mixing.distance(a.cutoff, b.cutoff)))
    }

    /// [`super::PairStyle::refuses`] of the style.
    fn refuses(&self, coefficients: &[f64]) -> Option<&'static str> {
        with_style(self.style.name, Refuses(coefficients)).flatten()
    }

    fn pair(&self, coefficients: Vec<f64>, cutoff: f64) -> TypePair {
        let energy_at_cutoff = if cutoff > 0.0 {
            with_style(self.style.name, EnergyAt { coefficients: &coefficients, settings: &self.settings, cutoff })
                .unwrap_or(0.0)
        } else {
            0.0
        };
        TypePair { coefficients, cutoff, energy_at_cutoff }
    }

    /// Lines of a data file's `Pair Coeffs` section: type and coefficients, as far as given. As in LAMMPS, cutoffs stand there
    /// only where `pair_style` has none.
    pub fn like_type_lines(&self) -> Vec<String> {
        let cutoff = |g: &Given| (!self.style.global_cutoff).then_some(g.cutoff);
        let values = |g: &Given| g.coefficients.iter().copied().chain(cutoff(g)).collect::<Vec<_>>();
        let like = |k: usize| self.given[k * self.types + k].as_ref().map(|g| line(&[k], &values(g)));
        (0..self.types).filter_map(like).collect()
    }
}

impl PairTable {
    /// Lines of a data file's `PairIJ Coeffs` section: types, coefficients and cutoff of every pair.
    pub fn pair_lines(&self) -> Vec<String> {
        let pairs = (0..self.types).flat_map(|i| (i..self.types).map(move |j| (i, j)));
        let text = |(i, j): (usize, usize)| {
            let pair = &self.pairs[i * self.types + j];
            let values: Vec<f64> = pair.coefficients.iter().copied().chain([pair.cutoff]).collect();
            line(&[i, j], &values)
        };
        pairs.map(text).collect()
    }
}

/// Types (from 0) and values, with the digits that read back to the same bits.
fn line(types: &[usize], values: &[f64]) -> String {
    let types = types.iter().map(|k| (k + 1).to_string());
    types.chain(values.iter().map(f64::to_string)).collect::<Vec<_>>().join(" ")
}

struct EnergyAt<'a> {
    coefficients: &'a [f64],
    settings: &'a [f64],
    cutoff: f64,
}

impl StyleVisitor for EnergyAt<'_> {
    type Output = f64;
    fn visit<S: super::PairStyle>(self) -> f64 {
        S::eval::<f64>(self.cutoff * self.cutoff, &S::params(self.coefficients, self.settings, self.cutoff)).energy
    }
}

struct Refuses<'a>(&'a [f64]);

impl StyleVisitor for Refuses<'_> {
    type Output = Option<&'static str>;
    fn visit<S: super::PairStyle>(self) -> Self::Output {
        S::refuses(self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cutoff_that_is_a_coefficient_is_mixed_as_lammps_mixes_it() {
        let mut given = PairCoefficients::new("harmonic/cut", 0.0, 2).unwrap();
        given.set((1, 1), (1, 1), &["2.0", "1.0"]).unwrap();
        given.set((2, 2), (2, 2), &["8.0", "3.0"]).unwrap();
        // Energy and force at a distance of 0.5 that LAMMPS 22Jul2025 has.
        let expected = [
            (Mixing::Geometric, 6.0717967697244895, 9.85640646055102),
            (Mixing::Arithmetic, 9.0, 12.0),
            (Mixing::SixthPower, 1.3975681270792994, 1.2861213088),
        ];
        for (mixing, energy, force) in expected {
            given.mixing = mixing;
            let value = given.complete().unwrap().0.evaluate(0, 1, 0.5).unwrap();
            assert!((value.energy - energy).abs() < 1e-13, "{mixing:?}: {}", value.energy);
            assert!((0.5 * value.force_over_r - force).abs() < 1e-8, "{mixing:?}: {}", value.force_over_r);
        }
        assert_eq!(given.like_type_lines(), ["1 2 1", "2 8 3"]);
        // A repeated pair_style leaves such cutoffs alone.
        given.reset(Vec::new(), 0.0);
        assert_eq!(given.like_type_lines(), ["1 2 1", "2 8 3"]);
        let missing = given.set((1, 1), (2, 2), &["4.0"]).unwrap_err();
        assert_eq!(missing, (0, "expected 2 values after the types (K cutoff), got 1".into()));
    }
}
