//! The CPU engine: all cores, in lanes, in three precisions; the same bits for any number of threads.

mod block;
mod engine;
mod fallback;
mod force;
mod list;
mod loaded;
mod membership;
mod mode;
mod motion;
mod moving;
mod rows;
mod scratch;
mod search;
mod sums;
mod thermostats;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::backend::{Backend, Pair, Reached, StageSeconds, Stop, Work};
use super::fault::GoodState;
use super::observer::{Needs, NeighborStatistics, Sums};
use super::precision::Precision;
use super::program::Program;
use crate::Error;
use crate::real::Isa;
use crate::system::{SimulationBox, State};
use engine::Engine;
pub use list::LIST_BYTES;
use loaded::Loaded;
use mode::{Double, Mixed, Single};

/// How the CPU engine runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuOptions {
    /// 0 takes all cores.
    pub threads: usize,
    pub precision: Precision,
    /// `None` takes the best instruction set that the processor has.
    pub isa: Option<Isa>,
}

/// Runs programs on the host's cores.
pub struct CpuBackend {
    pool: rayon::ThreadPool,
    threads: usize,
    precision: Precision,
    isa: Isa,
    loaded: Option<Box<dyn Loaded>>,
}

impl CpuBackend {
    pub fn new(options: CpuOptions) -> Result<Self, Error> {
        let CpuOptions { threads, precision, isa } = options;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Error::Unavailable(format!("cannot start {threads} threads: {e}")))?;
        let threads = pool.current_num_threads();
        let isa = isa.unwrap_or_else(Isa::detect);
        if !isa.is_available() {
            return Err(Error::Unavailable(format!("this processor has no {}", isa.name())));
        }
        Ok(Self { pool, threads, precision, isa, loaded: None })
    }

    /// Instruction set that runs.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    fn on_pool<T: Send>(&mut self, work: impl FnOnce(&mut dyn Loaded) -> T + Send) -> T {
        let loaded = self.loaded.as_mut().expect("a program is loaded before it is run");
        self.pool.install(|| work(&mut **loaded))
    }

    fn loaded(&self) -> &dyn Loaded {
        self.loaded.as_deref().expect("a program is loaded before it is asked about")
    }
}

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        let (threads, plural) = (self.threads, if self.threads == 1 { "" } else { "s" });
        format!("cpu, {threads} thread{plural}, {} precision, {}", self.precision.name(), self.isa.name())
    }

    fn details(&self) -> Vec<(&'static str, String)> {
        vec![("isa", self.isa.name().into())]
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn load(
        &mut self,
        program: Arc<Program>,
        state: &State,
        simulation_box: &SimulationBox,
        step: i64,
    ) -> Result<(), Error> {
        let (isa, threads) = (self.isa, self.threads);
        self.loaded = Some(match self.precision {
            Precision::Double => Box::new(Engine::<Double>::new(program, state, simulation_box, step, isa, threads)),
            Precision::Mixed => Box::new(Engine::<Mixed>::new(program, state, simulation_box, step, isa, threads)),
            Precision::Single => Box::new(Engine::<Single>::new(program, state, simulation_box, step, isa, threads)),
        });
        Ok(())
    }

    fn set_up(&mut self, needs: Needs) -> Result<(), Stop> {
        Ok(self.on_pool(|loaded| loaded.set_up(needs))?)
    }

    fn continue_run(&mut self, program: &Program, state: &State, step: i64) -> Result<(), Error> {
        if let Some(loaded) = &mut self.loaded {
            loaded.go_on(program, state, step);
        }
        Ok(())
    }

    fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Stop> {
        Ok(self.on_pool(|loaded| loaded.advance(steps, needs, stop))?)
    }

    fn step(&self) -> i64 {
        self.loaded().step()
    }

    fn fetch(&self, state: &mut State) -> Result<(), Error> {
        self.loaded().fetch(state);
        Ok(())
    }

    fn last_build(&self) -> Result<Option<GoodState>, Error> {
        Ok(self.loaded().last_build())
    }

    fn sums(&mut self) -> Result<Sums, Error> {
        Ok(self.on_pool(|loaded| loaded.sums()))
    }

    fn memories(&self) -> Vec<Vec<f64>> {
        self.loaded().memories()
    }

    fn simulation_box(&self) -> &SimulationBox {
        self.loaded().simulation_box()
    }

    fn statistics(&self) -> NeighborStatistics {
        self.loaded().statistics()
    }

    fn seconds(&self) -> StageSeconds {
        self.loaded().seconds()
    }

    fn work(&self) -> Work {
        self.loaded().work()
    }

    fn neighbor_counts(&self) -> Result<Vec<u32>, Error> {
        Ok(self.loaded().neighbor_counts())
    }

    fn pairs_where(&self, wanted: &dyn Fn(u32) -> bool) -> Result<Vec<Pair>, Error> {
        Ok(self.loaded().pairs_where(wanted))
    }

    fn order(&self) -> Result<Vec<u32>, Error> {
        Ok(self.loaded().order())
    }

    fn bytes(&self) -> usize {
        self.loaded().bytes()
    }

    fn lost(&self) -> usize {
        self.loaded().lost()
    }

    fn explain(&self) -> Vec<String> {
        self.loaded().explain()
    }
}
