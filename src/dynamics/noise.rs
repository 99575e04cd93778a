//! Random numbers that depend on what they are for and on nothing drawn before: Philox4x32-10 of Salmon, Moraes, Dror and Shaw
//! 2011 (doi:10.1145/2063384.2063405). A particle's at a step follow from seed, id and step, so that neither order nor threads
//! nor backend change them.
//!
//! The rounds are written once over [`Words`]: on the host they are carried out, for a GPU they are written down.

/// Arithmetic of unsigned words of 32 bits.
pub trait Words {
    type Word: Clone;
    fn constant(&mut self, value: u32) -> Self::Word;
    /// Modulo 2^32.
    fn add(&mut self, a: &Self::Word, b: &Self::Word) -> Self::Word;
    fn xor(&mut self, a: &Self::Word, b: &Self::Word) -> Self::Word;
    /// The product's upper and lower half.
    fn product(&mut self, a: &Self::Word, b: &Self::Word) -> (Self::Word, Self::Word);
}

const ROUNDS: usize = 10;
const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
/// Golden ratio and the square root of 3 less 1, by which keys grow from round to round.
const GROWTH: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// The four words that belong to a counter under a key.
#[inline(always)]
pub fn philox<W: Words>(w: &mut W, counter: [W::Word; 4], key: [W::Word; 2]) -> [W::Word; 4] {
    let [m0, m1] = MULTIPLIERS.map(|m| w.constant(m));
    let [g0, g1] = GROWTH.map(|g| w.constant(g));
    let ([mut a, mut b, mut c, mut d], [mut k0, mut k1]) = (counter, key);
    for round in 0..ROUNDS {
        if round > 0 {
            (k0, k1) = (w.add(&k0, &g0), w.add(&k1, &g1));
        }
        let ((high0, low0), (high1, low1)) = (w.product(&a, &m0), w.product(&c, &m1));
        (a, c) = (w.xor(&high1, &b), w.xor(&high0, &d));
        (a, c) = (w.xor(&a, &k0), w.xor(&c, &k1));
        (b, d) = (low1, low0);
    }
    [a, b, c, d]
}

/// Words that belong to a particle at a step, of which three are used; `step` as its lower and its upper half.
#[inline(always)]
fn words_of<W: Words>(w: &mut W, seed: W::Word, id: W::Word, step: [W::Word; 2]) -> [W::Word; 4] {
    let zero = w.constant(0);
    let [low, high] = step;
    philox(w, [id, low, high, zero.clone()], [seed, zero])
}

/// A word as a number is this, taken as signed, times 2^-32: evenly spread from -1/2 to 1/2, its mean 2^-33 off zero.
pub const UNIT: f64 = 1.0 / (1u64 << 32) as f64;

struct Host;

impl Words for Host {
    type Word = u32;
    #[inline(always)]
    fn constant(&mut self, value: u32) -> u32 {
        value
    }
    #[inline(always)]
    fn add(&mut self, a: &u32, b: &u32) -> u32 {
        a.wrapping_add(*b)
    }
    #[inline(always)]
    fn xor(&mut self, a: &u32, b: &u32) -> u32 {
        a ^ b
    }
    #[inline(always)]
    fn product(&mut self, a: &u32, b: &u32) -> (u32, u32) {
        let product = u64::from(*a) * u64::from(*b);
        ((product >> 32) as u32, product as u32)
    }
}

/// Three random numbers from -1/2 to 1/2 for a particle at a step.
#[inline(always)]
pub fn noise(seed: u32, id: u32, step: i64) -> [f64; 3] {
    let [x, y, z, _] = words_of(&mut Host, seed, id, [step as u32, (step >> 32) as u32]);
    [x, y, z].map(|word| f64::from(word as i32) * UNIT)
}

/// Writes statements of CUDA C down; a word is the name of one.
#[cfg(feature = "cuda")]
#[derive(Default)]
struct Statements {
    text: String,
    names: usize,
}

#[cfg(feature = "cuda")]
impl Statements {
    fn name(&mut self, value: &str) -> String {
        let name = format!("w{}", self.names);
        self.names += 1;
        self.text += &format!("    const u32 {name} = {value};\n");
        name
    }
}

#[cfg(feature = "cuda")]
impl Words for Statements {
    type Word = String;
    fn constant(&mut self, value: u32) -> String {
        format!("{value}u")
    }
    fn add(&mut self, a: &String, b: &String) -> String {
        self.name(&format!("{a} + {b}"))
    }
    fn xor(&mut self, a: &String, b: &String) -> String {
        self.name(&format!("{a} ^ {b}"))
    }
    fn product(&mut self, a: &String, b: &String) -> (String, String) {
        (self.name(&format!("__umulhi({a}, {b})")), self.name(&format!("{a} * {b}")))
    }
}

/// [`noise`] as a function in CUDA C.
#[cfg(feature = "cuda")]
pub fn cuda_text() -> String {
    let mut statements = Statements::default();
    let step = ["(u32)step".to_string(), "(u32)(step >> 32)".to_string()].map(|half| statements.name(&half));
    let [x, y, z, _] = words_of(&mut statements, "seed".into(), "id".into(), step);
    let mut text = statements.text;
    for (axis, word) in [x, y, z].iter().enumerate() {
        text += &format!("    noise[{axis}] = (real)(int){word} * (real){UNIT:e};\n");
    }
    format!("__device__ __forceinline__ void noise_of(u32 seed, u32 id, i64 step, real noise[3]) {{\n{text}}}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors that come with the authors' library (Random123, `kat_vectors`).
    #[test]
    fn published_vectors_are_met() {
        let most = u32::MAX;
        let known = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([most; 4], [most; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, words) in known {
            assert_eq!(philox(&mut Host, counter, key), words);
        }
    }

    #[test]
    fn numbers_are_even_and_differ_with_each_part_of_the_key() {
        let n = 30_000;
        let (mut mean, mut square, mut product) = (0.0, 0.0, 0.0);
        for id in 0..n {
            let [x, y, z] = noise(4711, id, 1 << 40);
            assert!([x, y, z].iter().all(|u| (-0.5..0.5).contains(u)));
            mean += (x + y + z) / 3.0;
            square += (x * x + y * y + z * z) / 3.0;
            product += x * y + y * z + z * x;
        }
        // Means of n numbers of variance 1/12, 1/180 and 3/144, within four standard errors.
        let within = |sum: f64, expected: f64, variance: f64| {
            (sum / f64::from(n) - expected).abs() < 4.0 * (variance / f64::from(n)).sqrt()
        };
        assert!(within(mean, 0.0, 1.0 / 36.0) && within(square, 1.0 / 12.0, 1.0 / 540.0), "{mean} {square}");
        assert!(within(product, 0.0, 3.0 / 144.0), "{product}");
        let one = noise(1, 2, 3);
        for other in [noise(2, 2, 3), noise(1, 3, 3), noise(1, 2, 4), noise(1, 2, 3 + (1 << 32))] {
            assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() > 1e-6));
        }
    }
}
