//! What the command line decides.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::Value;

use crate::Error;
use crate::engine::cpu::{CpuBackend, CpuOptions};
use crate::engine::tuned::Choices;
use crate::engine::{Backend, Precision};
use crate::neighbor::SearchPlan;
use crate::real::Isa;

/// Which engine to run on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// The best there is.
    #[default]
    Auto,
    Cpu,
    Cuda,
}

/// What becomes of a run's particles when it cannot go on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum OnError {
    /// The last good state is written then.
    #[default]
    Stop,
    /// Good states are kept on disk while it runs as well, so that a kill or a power failure leaves one.
    Checkpoint {
        /// Wall seconds between two of them, or longer where they would take more than a twentieth of the time.
        seconds: f64,
    },
}

/// How to run a script.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// `-v NAME=VALUE`: index variables set before the script.
    pub variables: Vec<(String, String)>,
    pub backend: BackendChoice,
    /// GPU to run on; `None` for the first.
    pub device: Option<u32>,
    /// 0 for all cores.
    pub threads: usize,
    pub precision: Precision,
    pub search: SearchPlan,
    /// What the kernels of a GPU are made with, other than the table says: for the run that makes the table.
    pub choices: Option<Choices>,
    /// Log file; `None` for no log.
    pub log: Option<PathBuf>,
    /// Where the JSON report goes.
    pub json: Option<PathBuf>,
    /// Print what the engine was specialized to.
    pub explain: bool,
    /// Nothing on the screen.
    pub quiet: bool,
    pub on_error: OnError,
    /// What the script writes beside its log is left out: dumps, data files, tables, printed files, the last good state.
    pub no_files: bool,
}

impl Settings {
    /// Refuses what this build lacks.
    pub fn check(&self) -> Result<(), Error> {
        if cfg!(not(feature = "cuda")) && (self.backend == BackendChoice::Cuda || self.device.is_some()) {
            let what = self.device.map_or("--backend cuda".into(), |device| format!("--device {device}"));
            let text = format!("{what}: this octant was built without CUDA (cargo feature `cuda`)");
            return Err(Error::Unavailable(text));
        }
        match self.device {
            Some(device) if self.backend == BackendChoice::Cpu => {
                Err(Error::Unavailable(format!("--device {device} names a GPU, but --backend cpu uses none")))
            }
            _ => Ok(()),
        }
    }

    /// The engine these settings ask for, and a line for the user where it is not the one that was hoped for. A device that is
    /// named is insisted on.
    pub fn engine(&self) -> Result<(Box<dyn Backend>, Option<String>), Error> {
        match (self.backend, self.cuda_engine()) {
            (BackendChoice::Cpu, _) => Ok((Box::new(self.cpu_engine()?), None)),
            (_, Ok(engine)) => Ok((engine, None)),
            (BackendChoice::Cuda, Err(reason)) => Err(Error::Unavailable(format!("--backend cuda: {reason}"))),
            (BackendChoice::Auto, Err(reason)) if self.device.is_some() => Err(Error::Unavailable(reason)),
            (BackendChoice::Auto, Err(reason)) => {
                Ok((Box::new(self.cpu_engine()?), Some(format!("Running on the CPU: {reason}"))))
            }
        }
    }

    #[cfg(feature = "cuda")]
    fn cuda_engine(&self) -> Result<Box<dyn Backend>, String> {
        use crate::engine::cuda::{CudaBackend, CudaOptions, Tuning};
        if self.backend == BackendChoice::Cpu {
            return Err("not asked for".into());
        }
        let device = self.device.unwrap_or(0) as usize;
        let tuning = Tuning { choices: self.choices, ..Tuning::default() };
        let options = CudaOptions { device, precision: self.precision, tuning };
        let backend = CudaBackend::new(options).and_then(|backend| backend.check_compiler().map(|()| backend));
        Ok(Box::new(backend.map_err(|e| e.to_string())?))
    }

    #[cfg(not(feature = "cuda"))]
    fn cuda_engine(&self) -> Result<Box<dyn Backend>, String> {
        Err("this octant was built without CUDA".into())
    }

    /// The CPU engine. The environment variable `OCTANT_ISA` names an instruction set other than the best
    /// of this processor, so that results of another machine type can be had bit by bit.
    pub fn cpu_engine(&self) -> Result<CpuBackend, Error> {
        let isa = match std::env::var("OCTANT_ISA") {
            Ok(name) if !name.is_empty() => Some(Isa::named(&name).ok_or_else(|| {
                let known = Isa::ALL.map(Isa::name).join(", ");
                Error::Unavailable(format!("OCTANT_ISA={name} is no instruction set; known: {known}"))
            })?),
            _ => None,
        };
        CpuBackend::new(CpuOptions { threads: self.threads, precision: self.precision, isa })
    }

    /// For the report: how a script is run.
    pub fn describe(&self, script: &str, backend: &dyn Backend) -> BTreeMap<String, Value> {
        let entries = [
            ("script", Value::from(script)),
            ("backend", backend.describe().into()),
            ("threads", backend.threads().into()),
            ("precision", self.precision.name().into()),
            ("search", self.search.to_string().into()),
        ];
        let details = backend.details().into_iter().map(|(key, value)| (key, value.into()));
        entries.into_iter().chain(details).map(|(key, value)| (key.to_string(), value)).collect()
    }
}
