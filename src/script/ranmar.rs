//! Marsaglia's random stream, which LAMMPS's formulas draw from (`random` and `normal` of equal-style variables), bit for bit.
//!
//! F. James, A review of pseudorandom number generators, doi:10.1016/0010-4655(90)90032-V ("RANMAR").

/// Largest seed.
pub const LARGEST_SEED: i64 = 900_000_000;

const LONG_LAG: usize = 97;
const SHORT_LAG: usize = 33;
/// The second sequence counts down in steps of `STEP` modulo `WRAP`, in units of 2^-24.
const UNIT: f64 = 1.0 / 16_777_216.0;
const START: f64 = 362_436.0 * UNIT;
const STEP: f64 = 7_654_321.0 * UNIT;
const WRAP: f64 = 16_777_213.0 * UNIT;

/// A lagged Fibonacci sequence and an arithmetic one, subtracted; all values are exact multiples of 2^-24.
#[derive(Clone, Debug)]
pub struct RanMar {
    lagged: Vec<f64>,
    long: usize,
    short: usize,
    arithmetic: f64,
    kept: Option<f64>,
}

impl RanMar {
    /// Starts a stream; `None` unless 1 <= seed <= [`LARGEST_SEED`].
    pub fn new(seed: i64) -> Option<Self> {
        if !(1..=LARGEST_SEED).contains(&seed) {
            return None;
        }
        let (high, low) = ((seed - 1) / 30_082, (seed - 1) % 30_082);
        let (mut i, mut j) = ((high / 177) % 177 + 2, high % 177 + 2);
        let (mut k, mut l) = ((low / 169) % 178 + 1, low % 169);
        let mut lagged = vec![0.0; LONG_LAG];
        for value in &mut lagged {
            let mut bit = 0.5;
            for _ in 0..24 {
                let m = ((i * j) % 179) * k % 179;
                (i, j, k) = (j, k, m);
                l = (53 * l + 1) % 169;
                if (l * m) % 64 >= 32 {
                    *value += bit;
                }
                bit *= 0.5;
            }
        }
        let mut stream = Self { lagged, long: LONG_LAG - 1, short: SHORT_LAG - 1, arithmetic: START, kept: None };
        stream.uniform(); // LAMMPS throws the first value away
        Some(stream)
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        let wrap = |x: f64| if x < 0.0 { x + 1.0 } else { x };
        let value = wrap(self.lagged[self.long] - self.lagged[self.short]);
        self.lagged[self.long] = value;
        self.long = self.long.checked_sub(1).unwrap_or(LONG_LAG - 1);
        self.short = self.short.checked_sub(1).unwrap_or(LONG_LAG - 1);
        self.arithmetic -= STEP;
        if self.arithmetic < 0.0 {
            self.arithmetic += WRAP;
        }
        wrap(value - self.arithmetic)
    }

    /// Standard normal, by the polar method; one value of each pair is kept.
    pub fn gaussian(&mut self) -> f64 {
        if let Some(kept) = self.kept.take() {
            return kept;
        }
        let (first, second) = crate::system::random::polar_pair(|| self.uniform());
        self.kept = Some(second);
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values printed (with 20 digits) by LAMMPS's `random` and `normal` functions from one stream with seed 12345.
    #[test]
    fn stream_is_that_of_lammps() {
        let mut random = RanMar::new(12345).unwrap();
        let uniform: Vec<f64> = (0..3).map(|_| random.uniform()).collect();
        assert_eq!(uniform, [14_595_391.0 * UNIT, 174_918.0 * UNIT, 4_925_251.0 * UNIT]);
        assert_eq!(random.gaussian(), 0.9984111070353759);
        assert_eq!(random.gaussian(), -1.365904360102757);
        assert!(RanMar::new(0).is_none() && RanMar::new(LARGEST_SEED + 1).is_none());
    }
}
