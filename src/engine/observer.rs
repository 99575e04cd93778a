//! What leaves a run: observers are shown the state at the steps they ask for.

use crate::output::Console;
use crate::system::{SimulationBox, State};

/// What an observer wants computed at a step, so that other steps need not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Pair energy.
    pub energy: bool,
    /// Virial tensor.
    pub virial: bool,
    /// Trace of the virial, which is all that the scalar pressure takes; where nothing else is asked for, only the sum of the
    /// virial's first three terms is valid.
    pub pressure: bool,
    /// Positions, velocities, images brought back to [`State`].
    pub positions: bool,
    /// Forces brought back to [`State`].
    pub forces: bool,
}

impl Needs {
    /// Whether pairs have to be summed up.
    pub fn sums(self) -> bool {
        self.energy || self.virial || self.pressure
    }

    /// What either wants.
    pub fn union(self, other: Self) -> Self {
        Self {
            energy: self.energy || other.energy,
            virial: self.virial || other.virial,
            pressure: self.pressure || other.pressure,
            positions: self.positions || other.positions,
            forces: self.forces || other.forces,
        }
    }
}

/// Global sums at one step. Tensors in the order xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Sum of m v_a v_b, mass times velocity squared (twice the kinetic energy on the trace, before `mvv2e`).
    pub kinetic: [f64; 6],
    /// Pair energy, energy units; valid if asked for.
    pub potential: f64,
    /// Sum over pairs of r_a f_b, energy units; valid if asked for.
    pub virial: [f64; 6],
    /// Energy that thermostats have taken, energy units.
    pub bath: f64,
}

impl Sums {
    /// What of them is infinite or not a number; what was not asked for is left out of account as long as it is a number.
    pub fn broken(&self) -> Option<&'static str> {
        let named = [
            ("kinetic energy", &self.kinetic[..]),
            ("potential energy", std::slice::from_ref(&self.potential)),
            ("virial", &self.virial),
        ];
        named.into_iter().find(|(_, numbers)| numbers.iter().any(|x| !x.is_finite())).map(|(name, _)| name)
    }
}

/// Sums of a step that a run has passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    pub step: i64,
    pub sums: Sums,
}

/// Counts that the end-of-run statistics print.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeighborStatistics {
    /// List builds of this run, without the one at set-up.
    pub builds: u64,
    /// Builds triggered at the first step that allowed one; `None` when the check is off.
    pub dangerous: Option<u64>,
    /// Pairs in the half list of the last build.
    pub pairs: u64,
    /// Times since the set-up began, it included, that a GPU had to stop for the host and begin anew where it was: arrays
    /// had to grow, the grid or a shrink-wrapped side to move. A CPU has no need of that.
    pub redone: u64,
}

/// The simulation at one step.
pub struct Snapshot<'a> {
    pub step: i64,
    /// First step of this run.
    pub first_step: i64,
    /// Last step of this run.
    pub last_step: i64,
    /// Timestep length, time units.
    pub timestep: f64,
    pub state: &'a State,
    pub simulation_box: &'a SimulationBox,
    pub sums: &'a Sums,
    pub neighbors: NeighborStatistics,
    /// Wall seconds since this run's first step.
    pub elapsed_seconds: f64,
}

/// Something that looks at the simulation every so often.
pub trait Observer {
    /// The first step after `after` that this observer wants to see, given that the run ends at `last`.
    fn next(&self, after: i64, last: i64) -> Option<i64>;
    /// What it wants computed at the steps it sees.
    fn needs(&self) -> Needs;
    /// Looks.
    fn observe(&mut self, snapshot: &Snapshot<'_>, console: &mut Console) -> Result<(), crate::Error>;
}
