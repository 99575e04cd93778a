//! The simulation as formulas see it between runs and inside them.

use crate::engine::{NeighborStatistics, Snapshot, Sums};
use crate::output::SceneFacts;
use crate::output::quantities::{Quantities, keyword};
use crate::pair::Tail;
use crate::scene::SceneBuilder;
use crate::scene::group_functions::{GroupContext, group_function, is_group_function};
use crate::script::{Environment, Quantity};
use crate::system::temperature::sum_mass_velocity_squared;
use crate::system::{SimulationBox, State};

/// A stand-in for values that only a run can tell; odd enough that no sensible condition holds for it by accident.
const STAND_IN: f64 = 0.7390851332151607;

/// What the last run left behind.
#[derive(Clone, Debug)]
pub struct LastRun {
    pub sums: Sums,
    pub neighbors: NeighborStatistics,
    pub first_step: i64,
    pub seconds: f64,
    /// See [`SceneFacts::thermal_atoms`].
    pub thermal_atoms: usize,
    pub tail: Tail,
}

/// The scene between runs.
pub struct BetweenRuns<'a> {
    pub scene: &'a SceneBuilder,
    /// Its sums stand until the next run, whatever is done to the atoms, as in LAMMPS.
    pub last_run: Option<&'a LastRun>,
    /// The script is judged and a run lies behind: what depends on it is unknown.
    pub unknown: bool,
    pub per_atom: bool,
}

/// Facts that output needs of a scene.
pub fn facts(scene: &SceneBuilder) -> SceneFacts {
    let masses = scene.masses.iter().map(|m| m.unwrap_or(0.0)).collect();
    let mut facts = SceneFacts::new(scene.units, masses);
    if let Some(lattice) = &scene.lattice {
        facts.lattice = lattice.spacing().into();
    }
    facts.clock = scene.clock;
    facts
}

impl Environment for BetweenRuns<'_> {
    fn thermo(&mut self, name: &str) -> Result<Option<Quantity>, String> {
        let Some(info) = keyword(name) else { return Ok(None) };
        let Some(space) = &self.scene.space else {
            return Err(format!("thermo keyword '{name}' before there is a simulation box"));
        };
        let dynamic = info.needs.sums() || info.needs.forces;
        let moved = self.unknown && !matches!(name, "step" | "elapsed" | "elaplong" | "dt" | "time" | "atoms");
        if moved {
            return Ok(Some(Quantity { value: STAND_IN, known: false }));
        }
        if dynamic && self.last_run.is_none() {
            return Err(format!("thermo keyword '{name}' needs forces, which the first run computes"));
        }
        let scene = self.scene;
        let mut facts = facts(scene);
        facts.thermal_atoms = self.last_run.map(|r| r.thermal_atoms);
        facts.tail = self.last_run.map_or(Tail::default(), |r| r.tail);
        let mut sums = self.last_run.map_or(Sums::default(), |r| r.sums);
        if self.last_run.is_none() {
            sums.kinetic[0] = sum_mass_velocity_squared(&scene.state, &facts.masses, 1);
        }
        let snapshot = Snapshot {
            step: scene.step,
            first_step: self.last_run.map_or(scene.step, |r| r.first_step),
            last_step: scene.step,
            timestep: scene.timestep,
            state: &scene.state,
            simulation_box: space,
            sums: &sums,
            neighbors: self.last_run.map_or(NeighborStatistics::default(), |r| r.neighbors),
            elapsed_seconds: self.last_run.map_or(0.0, |r| r.seconds),
        };
        let number = Quantities::new(&snapshot, &facts, self.per_atom).lookup(name);
        Ok(number.map(|n| Quantity::known(n.value())))
    }

    fn group(&mut self, function: &str, args: &[&str]) -> Result<Option<Quantity>, String> {
        let Some(space) = &self.scene.space else {
            if !is_group_function(function) {
                return Ok(None);
            }
            return Err(format!("group function {function}() before there is a simulation box"));
        };
        let value = evaluate_group(function, args, self.scene, &self.scene.state, space)?;
        let known = !self.unknown || matches!(function, "count" | "mass");
        Ok(value.map(|value| Quantity { value: if known { value } else { STAND_IN }, known }))
    }
}

/// The scene when a run is judged.
pub struct AtRunStart<'a> {
    pub scene: BetweenRuns<'a>,
    /// First and last step that formulas of time count from and to.
    pub range: (i64, i64),
}

impl Environment for AtRunStart<'_> {
    fn run_range(&mut self) -> (i64, i64) {
        self.range
    }

    fn thermo(&mut self, name: &str) -> Result<Option<Quantity>, String> {
        self.scene.thermo(name)
    }

    fn group(&mut self, function: &str, args: &[&str]) -> Result<Option<Quantity>, String> {
        self.scene.group(function, args)
    }
}

fn evaluate_group(
    function: &str,
    args: &[&str],
    scene: &SceneBuilder,
    state: &State,
    simulation_box: &SimulationBox,
) -> Result<Option<f64>, String> {
    let context = GroupContext {
        state,
        masses: &scene.masses,
        groups: &scene.groups,
        regions: &scene.regions,
        simulation_box,
        units: scene.units,
    };
    group_function(function, args, &context)
}

/// The scene at a step of a run.
pub struct InsideRun<'a> {
    pub scene: &'a SceneBuilder,
    pub quantities: &'a Quantities<'a>,
    /// First and last step that formulas of time count from and to.
    pub range: (i64, i64),
}

impl Environment for InsideRun<'_> {
    fn run_range(&mut self) -> (i64, i64) {
        self.range
    }

    fn thermo(&mut self, name: &str) -> Result<Option<Quantity>, String> {
        Ok(self.quantities.lookup(name).map(|n| Quantity::known(n.value())))
    }

    fn group(&mut self, function: &str, args: &[&str]) -> Result<Option<Quantity>, String> {
        let snapshot = self.quantities.snapshot();
        let value = evaluate_group(function, args, self.scene, snapshot.state, snapshot.simulation_box)?;
        Ok(value.map(Quantity::known))
    }
}
