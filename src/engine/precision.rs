//! How exactly a run computes.

/// Arithmetic of positions, pairs and sums (`--precision`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Positions relative to cells, velocities and pairs in f32; energies, virials and other global sums in f64.
    Single,
    /// Positions and velocities in f64, pair arithmetic in f32 on differences of fixed-point coordinates, global sums in f64.
    #[default]
    Mixed,
    /// All in f64.
    Double,
}

impl Precision {
    pub const ALL: [Precision; 3] = [Precision::Single, Precision::Mixed, Precision::Double];

    pub fn name(self) -> &'static str {
        ["single", "mixed", "double"][self as usize]
    }
}
