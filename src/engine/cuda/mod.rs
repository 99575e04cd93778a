//! The CUDA engine: the whole step on the GPU, by kernels that hold what the scene needs.
//!
//! One cooperative launch runs many steps; its blocks wait for each other at barriers of the whole grid, so list builds,
//! which only the device knows the time of, cost no round trip to the host.

mod arrays;
mod cache;
mod compiled;
mod compiler;
mod device;
mod engine;
mod explain;
mod fixes;
pub mod inspect;
mod launches;
mod layout;
mod losses;
mod memory;
mod nvrtc;
mod plan;
pub mod ptx;
mod recording;
mod shape;
mod source;
mod thermostats;
mod transfer;

use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::backend::{Backend, Pair, Reached, StageSeconds, Stop, Work};
use super::fault::GoodState;
use super::observer::{Needs, NeighborStatistics, Record, Sums};
use super::precision::Precision;
use super::program::Program;
use crate::Error;
use crate::system::{SimulationBox, State};
use compiler::{Compiler, Loading};
use device::Device;
use engine::Engine;
pub use plan::Tuning;

/// How the CUDA engine runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CudaOptions {
    /// Number of the GPU among those that CUDA_VISIBLE_DEVICES leaves.
    pub device: usize,
    pub precision: Precision,
    pub tuning: Tuning,
}

/// Runs programs on a GPU.
pub struct CudaBackend {
    precision: Precision,
    tuning: Tuning,
    engine: Option<Engine>,
    /// Last, as the device has to outlive what is on it.
    compiler: Rc<Compiler>,
}

/// Refuses the scenes whose fixes have to end a step one after another: kernels kick all particles before they measure.
fn takes(program: &Program, state: &State) -> Result<(), Error> {
    if !program.thermostat_precedes(&state.mask) {
        return Ok(());
    }
    let text = "a thermostat (fix nvt) before another fix that integrates the same atoms: the GPU engine has no such order, the \
                CPU engine has (--backend cpu)";
    Err(Error::Unavailable(text.into()))
}

impl CudaBackend {
    /// The error says what is missing and how to get it.
    pub fn new(options: CudaOptions) -> Result<Self, Error> {
        let CudaOptions { device, precision, tuning } = options;
        Device::check_driver().map_err(Error::Unavailable)?;
        let loading = Loading::begin();
        let device = Device::open(device).map_err(Error::Unavailable)?;
        Ok(Self { compiler: Rc::new(Compiler::new(device, loading)), precision, tuning, engine: None })
    }

    /// Whether kernels can be compiled; the error says what is missing and how to get it.
    pub fn check_compiler(&self) -> Result<(), Error> {
        self.compiler.nvrtc().as_ref().map(|_| ()).map_err(|e| Error::Unavailable(e.clone()))
    }

    fn engine(&self) -> &Engine {
        self.engine.as_ref().expect("a program is loaded before it is asked about")
    }

    fn engine_mut(&mut self) -> &mut Engine {
        self.engine.as_mut().expect("a program is loaded before it is run")
    }
}

/// Name, compute capability and memory of every GPU, or why there is none.
pub fn devices() -> Result<Vec<String>, String> {
    let describe = |k| {
        let device = Device::open(k)?;
        device.bind()?;
        let ((major, minor), gib) = (device.capability, device.memory().1 as f64 / (1u64 << 30) as f64);
        Ok(format!("{k}: {}, compute capability {major}.{minor}, {gib:.0} GiB", device.name))
    };
    (0..Device::count()?).map(describe).collect()
}

impl Backend for CudaBackend {
    fn describe(&self) -> String {
        format!("cuda, {}, {} precision", self.compiler.device.name, self.precision.name())
    }

    fn details(&self) -> Vec<(&'static str, String)> {
        let device = &self.compiler.device;
        vec![
            ("device", device.ordinal.to_string()),
            ("architecture", device.architecture()),
            ("driver", device.driver.clone()),
        ]
    }

    fn threads(&self) -> usize {
        1
    }

    fn load(
        &mut self,
        program: Arc<Program>,
        state: &State,
        simulation_box: &SimulationBox,
        step: i64,
    ) -> Result<(), Error> {
        takes(&program, state)?;
        // What the last program held is given back first.
        self.engine = None;
        let (compiler, precision, tuning) = (self.compiler.clone(), self.precision, self.tuning);
        let engine = Engine::new(compiler, program, state, simulation_box, step, precision, tuning);
        self.engine = Some(engine.map_err(Error::Unavailable)?);
        Ok(())
    }

    fn set_up(&mut self, needs: Needs) -> Result<(), Stop> {
        self.engine_mut().set_up(needs)
    }

    fn continue_run(&mut self, program: &Program, state: &State, step: i64) -> Result<(), Error> {
        takes(program, state)?;
        self.engine_mut().go_on(program, state, step).map_err(Error::Unavailable)
    }

    fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Stop> {
        self.engine_mut().advance(steps, needs, stop)
    }

    fn expect_outputs(&mut self, outputs: (u64, u64), needs: Needs) -> Result<(), Error> {
        self.engine_mut().expect_outputs(outputs, needs).map_err(Error::Unavailable)
    }

    fn advance_recording(
        &mut self,
        outputs: (u64, u64),
        needs: Needs,
        stop: &AtomicBool,
        records: &mut Vec<Record>,
    ) -> Result<Reached, Stop> {
        self.engine_mut().advance_recording(outputs, needs, stop, records)
    }

    fn step(&self) -> i64 {
        self.engine().control.step
    }

    fn fetch(&self, state: &mut State) -> Result<(), Error> {
        self.engine().fetch(state).map_err(Error::Unavailable)
    }

    fn last_build(&self) -> Result<Option<GoodState>, Error> {
        self.engine().last_build().map_err(Error::Unavailable)
    }

    fn sums(&mut self) -> Result<Sums, Error> {
        self.engine_mut().sums().map_err(Error::Unavailable)
    }

    fn memories(&self) -> Vec<Vec<f64>> {
        self.engine().memories()
    }

    fn simulation_box(&self) -> &SimulationBox {
        &self.engine().simulation_box
    }

    fn statistics(&self) -> NeighborStatistics {
        self.engine().statistics()
    }

    fn seconds(&self) -> StageSeconds {
        self.engine().seconds()
    }

    fn work(&self) -> Work {
        let control = &self.engine().control;
        let atoms = f64::from(control.n.max(1));
        Work {
            distance_tests_per_atom: control.tests as f64 / atoms,
            list_entries_per_atom: control.entries as f64 / atoms,
        }
    }

    fn neighbor_counts(&self) -> Result<Vec<u32>, Error> {
        self.engine().neighbor_counts().map_err(Error::Unavailable)
    }

    fn pairs_where(&self, wanted: &dyn Fn(u32) -> bool) -> Result<Vec<Pair>, Error> {
        self.engine().pairs_where(wanted).map_err(Error::Unavailable)
    }

    fn order(&self) -> Result<Vec<u32>, Error> {
        self.engine().order().map_err(Error::Unavailable)
    }

    fn bytes(&self) -> usize {
        self.engine().memory.bytes()
    }

    fn lost(&self) -> usize {
        self.engine().lost
    }

    fn explain(&self) -> Vec<String> {
        explain::explain(self.engine())
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = self.compiler.take_notes();
        if let Some(engine) = &self.engine {
            notes.push(format!("Start-up: {:.3} s, beyond the driver's own", engine.start_up));
        }
        notes
    }
}
