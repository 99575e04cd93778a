//! The machine-readable report of a run (`--json`).

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use serde_json::{Map, Value};

use super::{StageTimes, WrittenFile, write_whole};
use crate::Error;
use crate::engine::{NeighborStatistics, Work};

/// Everything a program may want to know of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Version of octant.
    pub version: String,
    /// How it was run: script, backend, precision, search, threads.
    pub settings: BTreeMap<String, Value>,
    pub atoms: u64,
    /// Rows of the thermo tables of all runs, values by column header.
    pub thermo: Vec<Map<String, Value>>,
    pub neighbors: NeighborReport,
    pub timing: TimingReport,
    pub memory: MemoryReport,
    pub files: Vec<WrittenFile>,
    /// Texts of the warnings, in order.
    pub warnings: Vec<String>,
    /// What ended the script before its time; null where nothing did.
    pub error: Option<String>,
}

/// The list at the end, and how often it was built in the last run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct NeighborReport {
    /// Pairs, each once.
    pub total: u64,
    /// Pairs over atoms.
    pub per_atom: f64,
    pub builds: u64,
    /// Null where dangerous builds are not checked for.
    pub dangerous: Option<u64>,
    /// Times in the last run that arrays had to grow or the grid to move on a GPU, and steps to be redone.
    pub redone: u64,
    /// Distances that the last build tested, over atoms.
    pub distance_tests_per_atom: f64,
    /// Entries of the full list over atoms: each pair counts twice.
    pub list_entries_per_atom: f64,
}

/// What the simulation took at the end of the last run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MemoryReport {
    /// Particles, lists and working memory.
    pub bytes: u64,
    pub bytes_per_atom: f64,
}

impl MemoryReport {
    pub fn new(bytes: usize, atoms: usize) -> Self {
        let bytes_per_atom = if atoms > 0 { bytes as f64 / atoms as f64 } else { 0.0 };
        Self { bytes: bytes as u64, bytes_per_atom }
    }
}

impl NeighborReport {
    pub fn new(statistics: &NeighborStatistics, work: Work, atoms: usize) -> Self {
        let per_atom = if atoms > 0 { statistics.pairs as f64 / atoms as f64 } else { 0.0 };
        let NeighborStatistics { builds, dangerous, pairs, redone } = *statistics;
        let Work { distance_tests_per_atom, list_entries_per_atom } = work;
        Self { total: pairs, per_atom, builds, dangerous, redone, distance_tests_per_atom, list_entries_per_atom }
    }
}

/// Wall times over all runs, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TimingReport {
    pub loop_s: f64,
    pub steps_per_s: f64,
    pub stages: StageTimes,
}

impl TimingReport {
    pub fn new(loop_s: f64, steps: i64, stages: StageTimes) -> Self {
        let steps_per_s = if loop_s > 0.0 { steps as f64 / loop_s } else { 0.0 };
        Self { loop_s, steps_per_s, stages }
    }
}

impl Report {
    /// An empty report of this version.
    pub fn new() -> Self {
        Self { version: env!("CARGO_PKG_VERSION").to_string(), ..Self::default() }
    }

    /// Writes the report, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let written = write_whole(path, |out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            out.write_all(b"\n")
        });
        written.map_err(|e| Error::file(path, "cannot write", e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_written_whole_with_the_documented_names() {
        let path = std::env::temp_dir().join(format!("octant-report-{}.json", std::process::id()));
        let statistics = NeighborStatistics { builds: 3, dangerous: None, pairs: 10, redone: 2 };
        let mut report = Report { atoms: 4, ..Report::new() };
        report.neighbors =
            NeighborReport::new(&statistics, Work { distance_tests_per_atom: 470.5, list_entries_per_atom: 5.0 }, 4);
        report.memory = MemoryReport::new(4000, 4);
        report.timing = TimingReport::new(2.0, 100, StageTimes { pair: 1.5, ..StageTimes::default() });
        report.thermo.push(
            [("Step".to_string(), Value::from(0)), ("Temp".to_string(), Value::from(f64::NAN))].into_iter().collect(),
        );
        report.files.push(WrittenFile { path: "a.dump".into(), format: "atom".into(), frames: 2, bytes: 99 });
        report.write(&path).unwrap();
        let read: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        assert_eq!(read["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!(read["neighbors"]["per_atom"], 2.5);
        assert_eq!(read["neighbors"]["dangerous"], Value::Null);
        assert_eq!(read["neighbors"]["redone"], 2);
        assert_eq!(read["neighbors"]["distance_tests_per_atom"], 470.5);
        assert_eq!(read["memory"]["bytes_per_atom"], 1000.0);
        assert_eq!(read["timing"]["steps_per_s"], 50.0);
        assert_eq!(read["timing"]["stages"]["pair"], 1.5);
        assert_eq!(read["thermo"][0]["Temp"], Value::Null);
        assert_eq!(read["files"][0]["frames"], 2);
        std::fs::remove_file(&path).unwrap();
        let nowhere = path.join("below.json");
        assert!(report.write(&nowhere).is_err());
    }
}
