//! What a force that jumps at the cutoff does to the energy: a random walk, worked out beforehand.
//!
//! Velocity Verlet does the work of a pair's force over a step with the mean of the forces at both ends, the trapezoidal rule. A pair that
//! crosses the cutoff at a radial velocity u moves by u dt in that step, s of it inside, where it should do the work F s; it does
//! F u dt / 2, F being the force at the cutoff. As the step knows nothing of the crossing, s is uniform between 0 and u dt: the mean of the
//! error is 0, its variance (F u dt)^2 / 12. With n pairs a length of distance at the cutoff, n <|u|> cross it in a unit of time, and
//! with the Gaussian velocities of a temperature T, <|u|^3> = 2 (2 / pi)^(1/2) (k T / mu)^(3/2), mu being the reduced mass. So the variance
//! of E - N_pairs U(cutoff) grows by n F^2 dt^2 / 12 <|u|^3> in a unit of time. In a uniform fluid n = N / 2 4 pi rc^2 rho g(rc).
//!
//! And what it does to forces: rounding decides on which side of the cutoff a pair is that lies on it.

use super::content::short;
use super::study::Study;
use crate::bench::exact;
use crate::pair::PairTable;
use crate::system::Units;

/// Half the width of the shell in which pairs at the cutoff are counted, as a part of the cutoff.
const HALF_WIDTH: f64 = 0.02;
/// Atoms whose pairs are counted.
const SAMPLE: usize = 2_000;

/// Variance that E - N_pairs U(cutoff) gains in a unit of time, energy units squared: `pairs` has the pairs a length at the cutoff for each
/// pair of types, row-major, both orders apart.
pub fn walk_rate(pair: &PairTable, pairs: &[f64], masses: &[f64], units: &Units, temperature: f64, dt: f64) -> f64 {
    let mut rate = 0.0;
    for (k, count) in pairs.iter().enumerate() {
        let (i, j) = (k / pair.types, k % pair.types);
        let Some(force) = force_at_cutoff(pair, k) else { continue };
        let reduced = masses[i] * masses[j] / (masses[i] + masses[j]);
        let squared = units.boltzmann * temperature / (reduced * units.mvv2e);
        let cubed = 2.0 * (2.0 / std::f64::consts::PI).sqrt() * squared.powf(1.5);
        rate += count * (force * dt).powi(2) / 12.0 * cubed;
    }
    rate
}

/// Force just within the cutoff of a pair of types, which counts as in `PairTable::pairs`, force units; none where the two do not see
/// each other.
fn force_at_cutoff(pair: &PairTable, k: usize) -> Option<f64> {
    let cutoff = pair.pairs[k].cutoff;
    // A hair inside: the force beyond is none.
    let inside = cutoff * (1.0 - 1e-12);
    let value = pair.evaluate(k / pair.types, k % pair.types, inside).filter(|_| cutoff > 0.0);
    value.map(|value| value.force_over_r * inside)
}

/// How far a worst atom's error may be from the force at a cutoff that explains it, as a part of it: what else f32 is off by.
const ALIKE: f64 = 0.02;

/// Says which force errors are as large as those of a pair on the wrong side of the cutoff: `worst` has precisions with f32 in them and
/// the errors of their worst atoms, over the RMS force. None where no error is.
pub fn of_force_errors(pair: &PairTable, worst: &[(&str, f64)], rms_force: f64, atoms: usize) -> Option<String> {
    let mut forces = (0..pair.pairs.len()).filter_map(|k| force_at_cutoff(pair, k)).map(f64::abs);
    let (relative, precisions) = forces.find_map(|force| {
        let relative = force / rms_force;
        let alike = |error: f64| (error - relative).abs() <= ALIKE * relative;
        let names: Vec<&str> = worst.iter().filter(|(_, error)| alike(*error)).map(|(name, _)| *name).collect();
        (relative > 0.0 && !names.is_empty()).then_some((relative, names))
    })?;
    Some(format!(
        "A pair whose distance is the cutoff to the last digits of f32 may be taken for one on the other side of it, and its two atoms are \
         off by the whole force there, {}, which is {} of the RMS force. The worst atom in {} precision is off by as much; one such pair \
         among {atoms} atoms alone makes an RMS of {}. What the arithmetic itself is off by is seen where the force ends at zero, as \
         force-shifted potentials have it.",
        short(relative * rms_force),
        short(relative),
        precisions.join(" and "),
        short(relative * (2.0 / atoms as f64).sqrt()),
    ))
}

/// Pairs a length at the cutoff of each pair of types, in the melted scene.
pub fn pairs(study: &Study) -> Vec<f64> {
    let (state, pair) = (study.melted().state(), &study.program.pair);
    let ids = exact::sample_of(state, SAMPLE);
    exact::pairs_at_cutoff(pair, state, &study.space, &ids, HALF_WIDTH * pair.largest_cutoff())
}

/// The same for the energy per atom.
pub fn walk_per_atom(study: &Study, dt: f64, temperature: f64) -> f64 {
    let program = &study.program;
    let rate = walk_rate(&program.pair, &pairs(study), &program.masses, &program.units, temperature, dt);
    rate / (study.atoms() as f64).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::PairCoefficients;

    fn argon() -> PairTable {
        let mut given = PairCoefficients::new("lj/cut", 2.5, 1).unwrap();
        given.set((1, 1), (1, 1), &["1.0", "1.0"]).unwrap();
        given.complete().unwrap().0
    }

    #[test]
    fn an_error_as_large_as_the_force_at_the_cutoff_is_a_pair_on_its_wrong_side() {
        let force = 24.0 * (2.5f64.powi(-7) - 2.0 * 2.5f64.powi(-13));
        let rms_force = 20.0;
        let said = |worst: f64| of_force_errors(&argon(), &[("single", worst), ("double", 1e-13)], rms_force, 32_000);
        let text = said(1.01 * force / rms_force).unwrap();
        let alone = (2.0 * (force / rms_force).powi(2) / 32_000.0).sqrt();
        for part in [short(force), short(alone), "worst atom in single precision".into()] {
            assert!(text.contains(&part), "no {part} in: {text}");
        }
        assert_eq!((said(0.5 * force / rms_force), said(1e-6)), (None, None));
    }

    #[test]
    fn the_walk_has_the_variance_of_crossings_drawn_at_random() {
        let pair = argon();
        let units = Units::named("lj").unwrap();
        let (dt, temperature) = (0.005, 0.7);
        let rate = walk_rate(&pair, &[100.0], &[2.0], units, temperature, dt);
        // F(2.5) = 24 (2 2.5^-13 - 2.5^-7), as LAMMPS's doc page pair_lj has it.
        let force = 24.0 * (2.0 * 2.5f64.powi(-13) - 2.5f64.powi(-7));
        // Crossings of pairs at even places near the cutoff, with radial velocities in even parts of their distribution: the work of the
        // trapezoidal rule less that of the path, squared.
        let sigma = (temperature / 1.0f64).sqrt();
        let (mut sum, n) = (0.0, 400);
        for k in 0..4 * n {
            let u = 6.0 * sigma * (k as f64 + 0.5) / (4 * n) as f64;
            let weight = 2.0 * (-0.5 * (u / sigma).powi(2)).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt());
            for m in 0..n {
                let s = u * dt * (m as f64 + 0.5) / n as f64;
                let error = force * (0.5 * u * dt - s);
                sum += weight * u * error * error / n as f64;
            }
        }
        let expected = 100.0 * sum * 6.0 * sigma / (4 * n) as f64;
        // The sums over places and velocities are exact to the square of their steps.
        assert!((rate / expected - 1.0).abs() < 1e-4, "{rate} {expected}");
    }
}
