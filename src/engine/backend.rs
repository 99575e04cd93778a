//! What the step loop asks of an engine.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::fault::{Fault, GoodState};
use super::observer::{Needs, NeighborStatistics, Record, Sums};
use super::program::Program;
use crate::Error;
use crate::system::{SimulationBox, State};

/// How far [`Backend::advance`] came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// All steps asked for.
    End,
    /// The user interrupted; the step under way was finished.
    Interrupted,
}

/// Why a run cannot go on.
#[derive(Clone, Debug)]
pub enum Stop {
    /// The dynamics went wrong.
    Fault(Fault),
    /// The device did: out of memory, for instance.
    Device(String),
}

impl Stop {
    /// What went wrong with the dynamics, if that is why.
    pub fn fault(self) -> Option<Fault> {
        match self {
            Stop::Fault(fault) => Some(fault),
            Stop::Device(_) => None,
        }
    }
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Stop::Fault(fault)
    }
}

impl From<String> for Stop {
    fn from(message: String) -> Self {
        Stop::Device(message)
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stop::Fault(fault) => fault.fmt(f),
            Stop::Device(message) => f.write_str(message),
        }
    }
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

/// Ids of two neighbors, and the periodic image in which the second is seen.
pub type Pair = (u32, u32, [i32; 3]);

/// An engine that owns the particles while a run lasts.
pub trait Backend {
    /// Name and device for the log, such as "cpu, 2 threads".
    fn describe(&self) -> String;
    /// Further settings for the report, by name.
    fn details(&self) -> Vec<(&'static str, String)>;
    /// Host threads it uses.
    fn threads(&self) -> usize;
    /// Takes the particles over; `step` is the number of the current step.
    fn load(
        &mut self,
        program: Arc<Program>,
        state: &State,
        simulation_box: &SimulationBox,
        step: i64,
    ) -> Result<(), Error>;
    /// Set-up of a run: wrap, sort, list, forces. Statistics and times start from zero.
    fn set_up(&mut self, needs: Needs) -> Result<(), Stop>;
    /// Goes on without set-up (`run pre no`) from `step`: list, forces, coefficients, fixes and skin stay what they were. New
    /// velocities and groups are taken over, and so are timestep, masses, rebuild policy and what becomes of lost atoms.
    /// Counts of builds go on.
    fn continue_run(&mut self, program: &Program, state: &State, step: i64) -> Result<(), Error>;
    /// Runs `steps` steps; what `needs` asks for is computed at the last of them.
    fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Stop>;
    /// A run is about to go over so many outputs, as [`Backend::advance_recording`] has them: what that takes may be prepared
    /// before its first step.
    fn expect_outputs(&mut self, _outputs: (u64, u64), _needs: Needs) -> Result<(), Error> {
        Ok(())
    }
    /// Runs on over outputs that want sums alone, up to `count` of them and `stride` steps apart: `needs` is computed at each,
    /// positions and forces only at the step it ends at. It ends at any of the outputs, which it has to reach soon enough for
    /// someone who waits for them, or where it is interrupted. Appends a record for each output that lies behind, in order,
    /// with what went wrong after it as well; the step it ends at is no record, its sums are asked for as ever.
    fn advance_recording(
        &mut self,
        (stride, _count): (u64, u64),
        needs: Needs,
        stop: &AtomicBool,
        _records: &mut Vec<Record>,
    ) -> Result<Reached, Stop> {
        self.advance(stride, needs, stop)
    }
    /// Number of the current step.
    fn step(&self) -> i64;
    /// Brings particles back in storage order.
    fn fetch(&self, state: &mut State) -> Result<(), Error>;
    /// Particles as the last list build left them; `None` before the first.
    fn last_build(&self) -> Result<Option<GoodState>, Error>;
    /// Sums of the current step; energy and virial as far as asked for.
    fn sums(&mut self) -> Result<Sums, Error>;
    /// What each fix of the program keeps from step to step, for the next run.
    fn memories(&self) -> Vec<Vec<f64>>;
    /// The box, which follows the particles where it shrink-wraps.
    fn simulation_box(&self) -> &SimulationBox;
    fn statistics(&self) -> NeighborStatistics;
    fn seconds(&self) -> StageSeconds;
    fn work(&self) -> Work;
    /// Neighbors of every particle within its neighbor cutoff at the last build, in storage order.
    fn neighbor_counts(&self) -> Result<Vec<u32>, Error>;
    /// All pairs of the full list of the last build, as ids and the periodic image in which the second is seen; sorted.
    fn pairs(&self) -> Result<Vec<Pair>, Error> {
        self.pairs_where(&|_| true)
    }
    /// Those of them whose first particle's id is wanted.
    fn pairs_where(&self, wanted: &dyn Fn(u32) -> bool) -> Result<Vec<Pair>, Error>;
    /// Ids of the particles in the order in which the last build laid them into memory.
    fn order(&self) -> Result<Vec<u32>, Error>;
    /// Bytes held for particles and lists.
    fn bytes(&self) -> usize;
    /// Particles removed since [`Backend::load`] because they left through a fixed side.
    fn lost(&self) -> usize;
    /// What the loaded program was specialized to on this backend, line by line.
    fn explain(&self) -> Vec<String>;
    /// What a user should know of the preparations since the last call, line by line.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}
