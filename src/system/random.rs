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
        let (first, second) = polar_pair(|| self.uniform());
        self.kept = Some(second);
        first
    }
}

/// Two independent standard normals from uniform numbers, in the order in which LAMMPS hands them out.
pub fn polar_pair(mut uniform: impl FnMut() -> f64) -> (f64, f64) {
    loop {
        let v1 = 2.0 * uniform() - 1.0;
        let v2 = 2.0 * uniform() - 1.0;
        let square = v1 * v1 + v2 * v2;
        if square > 0.0 && square < 1.0 {
            let factor = (-2.0 * square.ln() / square).sqrt();
            return (v2 * factor, v1 * factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published check of the minimal standard generator: seed 1, ten thousandth state.
    #[test]
    fn ten_thousandth_state_is_the_published_one() {
        let mut random = RanPark::new(1);
        let last = (0..10_000).map(|_| random.uniform()).last();
        assert_eq!(last, Some(1_043_618_065.0 * (1.0 / 2_147_483_647.0)));
    }

    #[test]
    fn gaussians_come_in_pairs() {
        let mut random = RanPark::new(2839);
        let (first, second) = (random.gaussian(), random.gaussian());
        assert_ne!(first, second);
        assert_eq!(random.kept, None);
    }
}
