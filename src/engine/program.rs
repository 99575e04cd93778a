//! The step of a scene as data: what a backend has to know, and nothing of scripts.

use crate::dynamics::{Fix, Phase};
use crate::neighbor::{Policy, SearchPlan};
use crate::pair::PairTable;
use crate::system::{LostAtoms, Units};

/// When and how storage order is sorted in space (LAMMPS doc page `atom_modify`, keyword sort). Results do not depend on it,
/// but the order of unsorted dumps and of `velocity ... loop local` does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StorageSort {
    /// At a run's set-up and at the first list build after every so many steps.
    pub every: i64,
    /// Edge of the bins, length units; 0 for half the largest neighbor cutoff.
    pub bin: f64,
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
    /// First and last step of the run, from which and to which what changes with time is counted.
    pub range: (i64, i64),
    pub policy: Policy,
    pub search: SearchPlan,
    pub lost: LostAtoms,
    /// `None`: storage order stays as it is.
    pub storage_sort: Option<StorageSort>,
}

/// One stage of a step, in the order a backend runs them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// A phase of fix number `1`.
    Fix(Phase, usize),
    /// Has a particle moved beyond half the skin?
    Check,
    /// Wrap, sort, list.
    Build,
    /// Pair forces.
    Force,
}

impl Program {
    /// The stages of a step; what the scene lacks is not there.
    pub fn stages(&self) -> Vec<Stage> {
        let acting = |phase| {
            let fixes = self.fixes.iter().enumerate().filter(move |(_, fix)| fix.acts(phase));
            fixes.map(move |(k, _)| Stage::Fix(phase, k))
        };
        let mut stages: Vec<Stage> = acting(Phase::Initial).chain(acting(Phase::Moved)).collect();
        if !self.policy.once {
            if self.policy.check {
                stages.push(Stage::Check);
            }
            stages.push(Stage::Build);
        }
        stages.push(Stage::Force);
        stages.extend(acting(Phase::Force).chain(acting(Phase::Last)).chain(acting(Phase::Measured)));
        stages
    }

    /// What the step does and what it leaves out, line by line.
    pub fn explain(&self) -> Vec<String> {
        let name = |stage: &Stage| match stage {
            Stage::Fix(phase, k) => {
                let part = match phase {
                    Phase::Initial => " (first half)",
                    Phase::Last => " (second half)",
                    Phase::Measured => " (scale)",
                    Phase::Moved | Phase::Force => "",
                };
                format!("{}{part}", self.fixes[*k].style)
            }
            Stage::Check => "displacement check".into(),
            Stage::Build => "wrap, sort, list".into(),
            Stage::Force => format!("{} forces", self.pair.style),
        };
        let stages: Vec<String> = self.stages().iter().map(name).collect();
        let mut left_out = vec!["energy and virial on steps that print none"];
        if self.pair.types == 1 {
            left_out.push("look-up of coefficients by type (one type)");
        }
        if !self.pair.shift {
            left_out.push("energy shift at the cutoff");
        }
        if !self.policy.check || self.policy.once {
            left_out.push("displacement check");
        }
        if !self.moves() {
            left_out.push("motion (no fix)");
        }
        vec![format!("Step: {}", stages.join(" -> ")), format!("Left out: {}", left_out.join("; "))]
    }

    /// Whether some fix moves particles in time.
    pub fn moves(&self) -> bool {
        self.fixes.iter().any(|fix| fix.acts(Phase::Initial))
    }

    /// Places of the first two fixes that both move some of the atoms with these group bits in time, if there are such.
    pub fn moved_twice(&self, masks: &[u32]) -> Option<(usize, usize)> {
        let moves = |fix: &Fix| fix.acts(Phase::Initial);
        self.sharing(masks, moves, moves)
    }

    /// Whether a thermostat comes before a fix that kicks some of the same atoms: it then scales them before that kick, which
    /// the kinetic energy it goes by must not hold.
    pub fn thermostat_precedes(&self, masks: &[u32]) -> bool {
        self.sharing(masks, |fix| fix.acts(Phase::Measured), |fix| fix.acts(Phase::Last)).is_some()
    }

    /// Places of two fixes, of these sorts in this order, that have an atom in common.
    fn sharing(
        &self,
        masks: &[u32],
        first: impl Fn(&Fix) -> bool,
        second: impl Fn(&Fix) -> bool,
    ) -> Option<(usize, usize)> {
        let pairs = (0..self.fixes.len()).flat_map(|i| (i + 1..self.fixes.len()).map(move |j| (i, j)));
        let mut of_these = pairs.filter(|(i, j)| first(&self.fixes[*i]) && second(&self.fixes[*j]));
        let shares = |(i, j): &(usize, usize)| {
            let (a, b) = (self.fixes[*i].group, self.fixes[*j].group);
            masks.iter().any(|mask| mask & a != 0 && mask & b != 0)
        };
        of_these.find(shares)
    }

    /// The part of the run that lies behind at a step.
    pub fn progress(&self, step: i64) -> f64 {
        let (first, last) = self.range;
        if step == first { 0.0 } else { (step - first) as f64 / (last - first) as f64 }
    }

    /// dt / 2 / mass for each type, in velocity per force.
    pub fn half_kicks(&self) -> Vec<f64> {
        let half = 0.5 * self.timestep * self.units.ftm2v;
        self.masses.iter().map(|m| half / m).collect()
    }
}
