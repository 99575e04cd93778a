//! The step of a scene as data: what a backend has to know, and nothing of scripts.

use crate::dynamics::Fix;
use crate::neighbor::{Policy, Search};
use crate::pair::PairTable;
use crate::system::Units;

/// What becomes of atoms that leave through a fixed side (`thermo_modify lost`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LostAtoms {
    /// The run stops.
    #[default]
    Error,
    /// They are removed, with a warning.
    Warn,
    /// They are removed.
    Ignore,
}

/// Everything constant during a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    pub units: Units,
    pub pair: PairTable,
    /// Masses by type (from 0), mass units.
    pub masses: Vec<f64>,
    /// In the order of the script.
    pub fixes: Vec<Fix>,
    /// Timestep, time units.
    pub timestep: f64,
    pub policy: Policy,
    pub search: Search,
    pub lost: LostAtoms,
}

/// One stage of a step, in the order a backend runs them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// First half of fix number `0`.
    Initial(usize),
    /// Has a particle moved beyond half the skin?
    Check,
    /// Wrap, sort, list.
    Build,
    /// Pair forces.
    Force,
    /// Second half of fix number `0`.
    Last(usize),
}

impl Program {
    /// The stages of a step; what the scene lacks is not there.
    pub fn stages(&self) -> Vec<Stage> {
        let mut stages: Vec<Stage> = (0..self.fixes.len()).map(Stage::Initial).collect();
        if !self.policy.once {
            if self.policy.check {
                stages.push(Stage::Check);
            }
            stages.push(Stage::Build);
        }
        stages.push(Stage::Force);
        stages.extend((0..self.fixes.len()).map(Stage::Last));
        stages
    }

    /// dt / 2 / mass for each type, in velocity per force.
    pub fn half_kicks(&self) -> Vec<f64> {
        let half = 0.5 * self.timestep * self.units.ftm2v;
        self.masses.iter().map(|m| half / m).collect()
    }
}
