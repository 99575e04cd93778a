//! What the command line decides.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::Value;

use crate::Error;
use crate::engine::cpu::{CpuBackend, CpuOptions};
use crate::engine::{Backend, Precision};
use crate::neighbor::Search;
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
    pub search: Search,
    /// Log file; `None` for no log.
    pub log: Option<PathBuf>,
    /// Where the JSON report goes.
    pub json: Option<PathBuf>,
    /// Print what the engine was specialized to.
    pub explain: bool,
    /// Nothing on the screen.
    pub quiet: bool,
}

impl Settings {
    /// Refuses what this build lacks.
    pub fn check(&self) -> Result<(), Error> {
        if self.backend == BackendChoice::Cuda {
            return Err(Error::Unavailable(
                "backend cuda is not part of this version of octant; --backend cpu (or auto) runs on the processor"
                    .into(),
            ));
        }
        if let Some(device) = self.device {
            return Err(Error::Unavailable(format!("--device {device}: this version of octant runs on no GPU")));
        }
        Ok(())
    }

    /// The engine these settings ask for. The environment variable `OCTANT_ISA` names an instruction set other than the best
    /// of this processor, so that results of another machine type can be had bit by bit.
    pub fn engine(&self) -> Result<CpuBackend, Error> {
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
            ("search", self.search.name().into()),
        ];
        let details = backend.details().into_iter().map(|(key, value)| (key, value.into()));
        entries.into_iter().chain(details).map(|(key, value)| (key.to_string(), value)).collect()
    }
}
