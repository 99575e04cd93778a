//! What the step loop asks of an engine.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::fault::Fault;
use super::observer::{Needs, NeighborStatistics, Sums};
use super::program::Program;
use crate::system::{SimulationBox, State};

/// How far [`Backend::advance`] came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// All steps asked for.
    End,
    /// The user interrupted; the step under way was finished.
    Interrupted,
}

/// Wall seconds by stage, summed since [`Backend::load`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageSeconds {
    /// Pair forces.
    pub pair: f64,
    /// Has a particle moved too far?
    pub check: f64,
    /// Wrap and sort into cells.
    pub sort: f64,
    /// Neighbor list.
    pub list: f64,
    /// Fixes.
    pub modify: f64,
}

impl StageSeconds {
    /// All that neighbors take.
    pub fn neighbor(&self) -> f64 {
        self.check + self.sort + self.list
    }
}

/// How much the last list build had to do and left to do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    pub distance_tests_per_atom: f64,
    /// Entries of the full list.
    pub list_entries_per_atom: f64,
}

/// An engine that owns the particles while a run lasts.
pub trait Backend {
    /// Name and device for the log, such as "cpu, 2 threads".
    fn describe(&self) -> String;
    /// Further settings for the report, by name.
    fn details(&self) -> Vec<(&'static str, String)>;
    /// Host threads it uses.
    fn threads(&self) -> usize;
    /// Takes the particles over; `step` is the number of the current step.
    fn load(&mut self, program: Arc<Program>, state: &State, simulation_box: &SimulationBox, step: i64);
    /// Set-up of a run: wrap, sort, list, forces. Statistics and times start from zero.
    fn set_up(&mut self, needs: Needs) -> Result<(), Fault>;
    /// Goes on without set-up (`run pre no`) from `step`: list, forces, coefficients, fixes and skin stay what they were. New
    /// velocities and groups are taken over, and so are timestep, masses, rebuild policy and what becomes of lost atoms.
    /// Counts of builds go on.
    fn continue_run(&mut self, program: &Program, state: &State, step: i64);
    /// Runs `steps` steps; what `needs` asks for is computed at the last of them.
    fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Fault>;
    /// Number of the current step.
    fn step(&self) -> i64;
    /// Brings particles back in storage order.
    fn fetch(&self, state: &mut State);
    /// Sums of the current step; energy and virial as far as asked for.
    fn sums(&mut self) -> Sums;
    /// The box, which follows the particles where it shrink-wraps.
    fn simulation_box(&self) -> &SimulationBox;
    fn statistics(&self) -> NeighborStatistics;
    fn seconds(&self) -> StageSeconds;
    fn work(&self) -> Work;
    /// Neighbors of every particle within its neighbor cutoff at the last build, in storage order.
    fn neighbor_counts(&self) -> Vec<u32>;
    /// Bytes held for particles and lists.
    fn bytes(&self) -> usize;
    /// Particles removed since [`Backend::load`] because they left through a fixed side.
    fn lost(&self) -> usize;
    /// What the loaded program was specialized to on this backend, line by line.
    fn explain(&self) -> Vec<String>;
}
