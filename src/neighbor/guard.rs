//! The band around a neighbor cutoff in which f32 arithmetic must not decide.

/// Rounding of a squared distance in f32 arithmetic, relative.
const ROUNDING: f64 = 8.0 / (1u64 << 24) as f64;

/// A quantum of fixed-point coordinates is at most this part of the smallest cutoff, or pairs are worked out in double
/// precision: finer than the rounding of f32.
pub const COARSEST_QUANTUM: f64 = 6e-8;

/// Squared distances, in quanta of fixed-point coordinates, below which a pair certainly is in the list and above which it
/// certainly is not. `quanta` a length unit; no coordinate is larger than `coordinate`. Differences are taken of fixed-point
/// coordinates, or of their values in f32, none of which is further than `span` (length units) from the origin they are
/// relative to.
pub fn limits(cutoff: f64, quanta: f64, coordinate: f64, span: f64) -> (f32, f32) {
    if cutoff <= 0.0 {
        // A pair that is switched off is listed where particles coincide, as in LAMMPS.
        return (-1.0, 4.0);
    }
    // A coordinate is off by half a quantum and by its own rounding, a distance by at most four of these.
    let error = 4.0 / quanta + 16.0 * f64::EPSILON * coordinate + 4.0 * f64::from(f32::EPSILON) * span;
    let band = ROUNDING + 2.0 * error / cutoff;
    let squared = (cutoff * quanta).powi(2);
    ((squared * (1.0 - band)) as f32, (squared * (1.0 + band)) as f32)
}
