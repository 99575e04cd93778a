//! What the command line decides.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::Value;

use crate::Error;
use crate::engine::Backend;
use crate::neighbor::Search;

/// Which engine to run on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// The best there is.
    #[default]
    Auto,
    Cpu,
    Cuda,
}

/// Arithmetic of positions, pairs and sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    Single,
    Mixed,
    /// All in f64.
    #[default]
    Double,
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
        if self.precision != Precision::Double {
            return Err(Error::Unavailable("this version of octant computes in double precision only".into()));
        }
        Ok(())
    }

    /// For the report: how a script is run.
    pub fn describe(&self, script: &str, backend: &dyn Backend) -> BTreeMap<String, Value> {
        let precision = match self.precision {
            Precision::Single => "single",
            Precision::Mixed => "mixed",
            Precision::Double => "double",
        };
        let entries = [
            ("script", Value::from(script)),
            ("backend", backend.describe().into()),
            ("threads", backend.threads().into()),
            ("precision", precision.into()),
            ("search", self.search.name().into()),
        ];
        entries.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
    }
}
