//! LAMMPS's "Park" random stream, bit for bit.

const MULTIPLIER: i64 = 16807;
const MODULUS: i64 = 2147483647;

/// The minimal standard generator of Park and Miller, doi:10.1145/63039.63042.
#[derive(Clone, Debug, PartialEq)]
pub struct RanPark {
    state: i64,
    /// The second value of the last Gaussian pair.
    kept: Option<f64>,
}

impl RanPark {
    /// Starts a stream. Seeds are 1 to 2147483646; 0 and multiples of the modulus would stick at zero and count as 1.
    pub fn new(seed: u32) -> Self {
        Self { state: (i64::from(seed) % MODULUS).max(1), kept: None }
    }

    /// Uniform in (0, 1): the state times the rounded reciprocal of the modulus.
    pub fn uniform(&mut self) -> f64 {
        self.state = self.state * MULTIPLIER % MODULUS;
        self.state as f64 * (1.0 / MODULUS as f64)
    }

    /// Standard normal, by the polar method (Knuth, The Art of Computer Programming 2, 3.4.1 C); one value of each pair is kept.
    pub fn gaussian(&mut self) -> f64 {
        if let Some(kept) = self.kept.take() {
            return kept;
        }
        loop {
            let v1 = 2.0 * self.uniform() - 1.0;
            let v2 = 2.0 * self.uniform() - 1.0;
            let square = v1 * v1 + v2 * v2;
            if square > 0.0 && square < 1.0 {
                let factor = (-2.0 * square.ln() / square).sqrt();
                self.kept = Some(v1 * factor);
                return v2 * factor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values printed by LAMMPS's `random` and `normal` functions from one stream with seed 12345.
    #[test]
    #[allow(clippy::excessive_precision)]
    fn stream_is_that_of_lammps() {
        let mut random = RanPark::new(12345);
        assert_eq!(random.uniform(), 0.86995309591293302);
        assert_eq!(random.uniform(), 0.0104259252548218);
        assert_eq!(random.uniform(), 0.29356783628463701);
        assert_eq!(random.gaussian(), 0.99841110703537606);
        assert_eq!(random.gaussian(), -1.3659043601027601);
    }
}
