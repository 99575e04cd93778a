//! A line of the result: CSV for programs, a table for readers.

use std::path::Path;

use crate::Error;
use crate::output;
use crate::output::printf::format_g;

/// Median, least and most over the rounds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    pub median: f64,
    pub least: f64,
    pub most: f64,
}

impl Spread {
    /// Of at least one value; of an even number of values the middle of the two in the middle.
    pub fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let (n, middle) = (sorted.len(), sorted.len() / 2);
        let median = if n % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) };
        Self { median, least: sorted[0], most: sorted[n - 1] }
    }

    pub fn scaled(self, by: f64) -> Self {
        Self { median: self.median * by, least: self.least * by, most: self.most * by }
    }
}

/// Microseconds a step of each stage, over all rounds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stages {
    pub pair: f64,
    pub list: f64,
    pub sort: f64,
    pub check: f64,
    pub modify: f64,
    pub output: f64,
    pub other: f64,
}

/// What was measured of one scene and size in one precision.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    pub scene: &'static str,
    /// Atoms that were asked for, and those of the box that comes nearest.
    pub asked: usize,
    pub atoms: usize,
    /// Cells of the crystal along each axis, "10x10x10".
    pub cells: String,
    pub precision: &'static str,
    pub backend: String,
    pub device: String,
    /// CUDA version of the GPU's driver; empty without one.
    pub driver: String,
    /// Sigma.
    pub skin: f64,
    /// Steps before anything was timed.
    pub melted: i64,
    /// Steps of a timed leg.
    pub steps: i64,
    pub rounds: usize,
    pub steps_per_s: Spread,
    pub stages: Stages,
    /// Steps over list builds in the timed legs; `None` where no list was built.
    pub steps_per_build: Option<f64>,
    /// Microseconds of sort and list a build.
    pub build_us: Option<f64>,
    pub list_entries_per_atom: f64,
    pub bytes_per_atom: f64,
    /// Seconds from the scene in memory to the first step, of the first engine of this scene, size and precision.
    pub start_up: f64,
    /// Drift of the total energy, epsilon per atom and tau, and its standard error; `None` where it was not measured.
    pub drift: Option<(f64, f64)>,
    /// Steps in which the drift was measured.
    pub drift_steps: i64,
    /// Force error over the RMS force: RMS over the sample, and of its worst atom.
    pub force_error: (f64, f64),
    /// Pairs that the list lacks, and pairs that it has too much; `None` where the legs after the melt had no build.
    pub missing_extra: Option<(usize, usize)>,
    /// Atoms whose forces and pairs were compared.
    pub sampled: usize,
    /// Builds of the timed legs that may have come too late.
    pub dangerous: Option<u64>,
}

/// Energy drift beyond three standard errors that is no good run's, epsilon per atom and tau: eight times the largest value found in
/// mixed and double precision (2.4e-6, with an error of 1e-6; validation/results/h100/bench.csv).
const MOST_DRIFT: f64 = 2e-5;

impl Row {
    /// What is wrong with the run; empty where the list is complete and the energy stays.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        if let Some((missing, extra)) = self.missing_extra.filter(|found| *found != (0, 0)) {
            faults.push(format!("the list lacks {missing} pairs and has {extra} too many"));
        }
        if let Some((drift, error)) = self.drift
            && (drift.abs() - 3.0 * error > MOST_DRIFT || drift.is_nan())
        {
            faults.push(format!("the energy drifts by {drift:.1e} per atom and time unit"));
        }
        let about = format!("{}, {} atoms, {}", self.scene, self.atoms, self.precision);
        faults.into_iter().map(|fault| format!("{about}: {fault}")).collect()
    }

    /// Million atom-steps a second.
    pub fn rate(&self) -> Spread {
        self.steps_per_s.scaled(self.atoms as f64 * 1e-6)
    }

    /// Column names and cells; a cell without a value is empty.
    pub fn cells(&self) -> Vec<(&'static str, String)> {
        let number = |x: f64| format_g(x, 0, 6, false);
        let maybe = |x: Option<f64>| x.map_or(String::new(), number);
        let (steps, rate, stages) = (self.steps_per_s, self.rate(), &self.stages);
        let pairs =
            |of: &dyn Fn((usize, usize)) -> usize| self.missing_extra.map_or(String::new(), |p| of(p).to_string());
        vec![
            ("scene", self.scene.into()),
            ("asked", self.asked.to_string()),
            ("atoms", self.atoms.to_string()),
            ("cells", self.cells.clone()),
            ("precision", self.precision.into()),
            ("backend", self.backend.clone()),
            ("device", self.device.clone()),
            ("driver", self.driver.clone()),
            ("skin", number(self.skin)),
            ("melted", self.melted.to_string()),
            ("steps", self.steps.to_string()),
            ("rounds", self.rounds.to_string()),
            ("steps_per_s", number(steps.median)),
            ("steps_per_s_least", number(steps.least)),
            ("steps_per_s_most", number(steps.most)),
            ("matom_steps_per_s", number(rate.median)),
            ("matom_steps_per_s_least", number(rate.least)),
            ("matom_steps_per_s_most", number(rate.most)),
            ("pair_us", number(stages.pair)),
            ("list_us", number(stages.list)),
            ("sort_us", number(stages.sort)),
            ("check_us", number(stages.check)),
            ("modify_us", number(stages.modify)),
            ("output_us", number(stages.output)),
            ("other_us", number(stages.other)),
            ("steps_per_build", maybe(self.steps_per_build)),
            ("build_us", maybe(self.build_us)),
            ("list_entries_per_atom", number(self.list_entries_per_atom)),
            ("bytes_per_atom", number(self.bytes_per_atom)),
            ("start_up_s", number(self.start_up)),
            ("drift", maybe(self.drift.map(|d| d.0))),
            ("drift_error", maybe(self.drift.map(|d| d.1))),
            ("drift_steps", self.drift_steps.to_string()),
            ("force_error_rms", number(self.force_error.0)),
            ("force_error_worst", number(self.force_error.1)),
            ("pairs_missing", pairs(&|p| p.0)),
            ("pairs_extra", pairs(&|p| p.1)),
            ("sampled_atoms", self.sampled.to_string()),
            ("dangerous_builds", self.dangerous.map_or(String::new(), |n| n.to_string())),
            ("version", env!("CARGO_PKG_VERSION").into()),
        ]
    }

    /// The heads of the table's columns.
    pub fn heads() -> String {
        line(HEADS.iter().map(|(head, width)| (head.to_string(), *width)))
    }

    /// A line of the table.
    pub fn table_line(&self) -> String {
        let (rate, s) = (self.rate(), &self.stages);
        let number = |x: f64| format_g(x, 0, 4, false);
        let drift = self.drift.map_or("-".into(), |(drift, error)| format!("{drift:.1e}±{error:.0e}"));
        let pairs = self.missing_extra.map_or("-".into(), |(missing, extra)| format!("{missing}/{extra}"));
        let cells = [
            self.scene.into(),
            self.atoms.to_string(),
            self.precision.into(),
            number(self.skin),
            format!("{} ({} to {})", number(rate.median), number(rate.least), number(rate.most)),
            number(self.steps_per_s.median),
            number(s.pair),
            number(s.list),
            number(s.sort),
            number(s.check + s.modify),
            number(s.output + s.other),
            self.steps_per_build.map_or("-".into(), number),
            number(self.bytes_per_atom),
            format_g(self.start_up, 0, 3, false),
            format!("{:.1e}", self.force_error.0),
            drift,
            pairs,
        ];
        line(cells.into_iter().zip(HEADS).map(|(cell, (_, width))| (cell, width)))
    }
}

/// Heads of the table and widths of its columns.
const HEADS: [(&str, usize); 17] = [
    ("scene", 9),
    ("atoms", 9),
    ("precision", 9),
    ("skin", 4),
    ("M atom-steps/s", 26),
    ("steps/s", 8),
    ("us: pair", 8),
    ("list", 7),
    ("sort", 7),
    ("motion", 7),
    ("other", 7),
    ("steps/build", 11),
    ("B/atom", 6),
    ("start s", 7),
    ("force error", 11),
    ("drift", 14),
    ("pairs -/+", 9),
];

fn line(cells: impl Iterator<Item = (String, usize)>) -> String {
    let padded: Vec<String> = cells.map(|(cell, width)| format!("{cell:>width$}")).collect();
    padded.join(" ")
}

/// Writes the table, whole or not at all.
pub fn write_csv(path: &Path, rows: &[Row]) -> Result<(), Error> {
    let heads: Vec<&str> = Row::default().cells().into_iter().map(|(head, _)| head).collect();
    let cells: Vec<Vec<String>> =
        rows.iter().map(|row| row.cells().into_iter().map(|(_, cell)| cell).collect()).collect();
    output::write_csv(path, &heads, &cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_of_odd_and_even() {
        assert_eq!(Spread::of(&[3.0, 1.0, 2.0]), Spread { median: 2.0, least: 1.0, most: 3.0 });
        assert_eq!(Spread::of(&[4.0, 1.0]), Spread { median: 2.5, least: 1.0, most: 4.0 });
    }

    #[test]
    fn faults_are_named() {
        let good = Row { missing_extra: Some((0, 0)), drift: Some((1e-6, 1e-6)), ..Row::default() };
        assert!(good.faults().is_empty() && Row::default().faults().is_empty());
        let bad = Row { missing_extra: Some((0, 2)), drift: Some((-0.1, 0.01)), scene: "lj", ..good.clone() };
        assert_eq!(bad.faults().len(), 2);
        assert!(bad.faults()[0].starts_with("lj, 0 atoms, : the list lacks 0 pairs and has 2 too many"));
        assert_eq!(Row { drift: Some((f64::NAN, 0.0)), ..good }.faults().len(), 1);
    }

    #[test]
    fn commas_are_quoted_and_columns_agree() {
        let path = std::env::temp_dir().join(format!("octant-bench-{}.csv", std::process::id()));
        write_csv(&path, &[Row { device: "a, \"b\"".into(), ..Row::default() }]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[1].contains("\"a, \"\"b\"\"\""));
        assert_eq!(lines[0].matches(',').count() + 1, lines[1].matches(',').count());
        assert_eq!(Row::heads().len(), Row::default().table_line().chars().count());
    }
}
