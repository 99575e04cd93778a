//! The random stream that scripts can rely on.
//!
//! Park and Miller's minimal standard generator (DOI 10.1145/63039.63042) in Schrage's form, with the polar method for
//! Gaussian numbers (DOI 10.1145/364520.364540): the stream LAMMPS draws velocities and random positions from, bit for bit.

use super::state::Vec3;

const MULTIPLIER: i64 = 16807;
const MODULUS: i64 = 2147483647;
const RECIPROCAL: f64 = 1.0 / MODULUS as f64;

/// Largest useful seed: the modulus itself would yield zeros forever.
pub const MAX_SEED: u32 = 2147483646;

/// The generator.
#[derive(Clone, Debug, PartialEq)]
pub struct RanPark {
    state: i64,
    /// The second number of the last Gaussian pair.
    kept: Option<f64>,
}

impl RanPark {
    /// A stream from a seed of 1 to [`MAX_SEED`]; other seeds (0 and multiples of the modulus) count as 1.
    pub fn new(seed: u32) -> Self {
        let state = i64::from(seed) % MODULUS;
        Self { state: if state == 0 { 1 } else { state }, kept: None }
    }

    /// The next number in (0, 1).
    pub fn uniform(&mut self) -> f64 {
        // The product stays below 2^46, so that Schrage's trick against overflow is not needed.
        self.state = MULTIPLIER * self.state % MODULUS;
        RECIPROCAL * self.state as f64
    }

    /// The next number of a normal distribution with mean 0 and variance 1.
    pub fn gaussian(&mut self) -> f64 {
        if let Some(second) = self.kept.take() {
            return second;
        }
        let (first, second) = polar_pair(|| self.uniform());
        self.kept = Some(second);
        first
    }

    /// Draws `count` numbers and throws them away.
    pub fn skip(&mut self, count: usize) {
        for _ in 0..count {
            self.uniform();
        }
    }

    /// Starts a new stream that depends on a position to its last bit (`velocity create ... loop geom`):
    /// Jenkins' one-at-a-time hash of seed and coordinates. Five numbers are thrown away to decorrelate close hashes.
    pub fn reset_at(&mut self, seed: u32, x: &Vec3) {
        let mut hash = 0u32;
        let bytes = seed.to_le_bytes().into_iter().chain(x.iter().flat_map(|c| c.to_le_bytes()));
        for byte in bytes {
            // The hash takes its bytes as signed characters.
            hash = hash.wrapping_add(i32::from(byte as i8) as u32);
            hash = hash.wrapping_add(hash << 10);
            hash ^= hash >> 6;
        }
        hash = hash.wrapping_add(hash << 3);
        hash ^= hash >> 11;
        hash = hash.wrapping_add(hash << 15);
        self.state = i64::from(hash & 0x7ff_ffff).max(1);
        self.kept = None;
        self.skip(5);
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

    #[test]
    fn the_ten_thousandth_state_is_the_published_one() {
        // Park and Miller 1988: from seed 1 the 10000th state is 1043618065.
        let mut random = RanPark::new(1);
        random.skip(10_000);
        assert_eq!(random.state, 1_043_618_065);
    }

    #[test]
    fn gaussian_numbers_have_unit_variance() {
        let mut random = RanPark::new(87287);
        let n = 100_000;
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..n {
            let g = random.gaussian();
            sum += g;
            square += g * g;
        }
        assert!((sum / n as f64).abs() < 0.01);
        assert!((square / n as f64 - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_position_seeds_its_own_stream() {
        let (mut a, mut b) = (RanPark::new(1), RanPark::new(2));
        a.gaussian();
        a.reset_at(5, &Vec3::new(1.0, -2.0, 0.5));
        b.reset_at(5, &Vec3::new(1.0, -2.0, 0.5));
        assert_eq!(a, b);
        b.reset_at(5, &Vec3::new(1.0, 2.0, 0.5));
        assert_ne!(a, b);
    }
}
