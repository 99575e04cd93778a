//! What output needs to know of the scene beside the state.

use crate::engine::Snapshot;
use crate::pair::Tail;
use crate::system::{Clock, Units};

/// The scene as output sees it: constants of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFacts {
    pub units: &'static Units,
    /// Mass of each type, mass units; index is type - 1.
    pub masses: Vec<f64>,
    /// Lattice spacings along x, y, z, length units; 1 where no lattice was defined.
    pub lattice: [f64; 3],
    pub clock: Clock,
    /// The step that `elaplong` counts from (`run ... start`), where it is not the first of the run.
    pub counting_from: Option<i64>,
    /// Atoms after the last set-up: LAMMPS counts degrees of freedom then, and atoms lost later do not change them. `None`:
    /// those there are.
    pub thermal_atoms: Option<usize>,
    /// Of the atoms at the last set-up, as in LAMMPS.
    pub tail: Tail,
}

impl SceneFacts {
    /// Facts of a scene whose time began at step 0 and that has no lattice.
    pub fn new(units: &'static Units, masses: Vec<f64>) -> Self {
        Self {
            units,
            masses,
            lattice: [1.0; 3],
            clock: Clock::default(),
            counting_from: None,
            thermal_atoms: None,
            tail: Tail::default(),
        }
    }

    /// Number of atom types.
    pub fn types(&self) -> usize {
        self.masses.len()
    }

    /// Mass of an atom type, from 1.
    pub fn mass(&self, kind: u32) -> f64 {
        (kind as usize).checked_sub(1).and_then(|k| self.masses.get(k)).copied().unwrap_or(0.0)
    }

    /// Simulated time, time units.
    pub fn time(&self, snapshot: &Snapshot<'_>) -> f64 {
        self.clock.at(snapshot.step, snapshot.timestep)
    }
}
