//! `octant bench`.

use std::process::ExitCode;

use super::run::INTERRUPTED;
use super::{BenchArgs, SceneArg};
use crate::Error;
use crate::bench::{self, Ended, Options, Row, Said, Scene};
use crate::engine::Precision;
use crate::engine::tuned::Choices;
use crate::output::check_writable;
use crate::session;

/// Measures, or tunes; prints rows as they come and writes them to the file.
pub fn bench(args: BenchArgs) -> Result<ExitCode, Error> {
    let mut precisions: Vec<Precision> = Vec::new();
    for precision in args.precision.iter().map(|p| Precision::ALL[*p as usize]) {
        if !precisions.contains(&precision) {
            precisions.push(precision);
        }
    }
    let options = Options {
        settings: args.engine.settings(),
        precisions,
        sizes: args.sizes,
        scene: args.scene.into(),
        skin: args.skin.0,
        steps: args.steps.0,
        rounds: args.rounds.into(),
    };
    for (option, file) in [("--csv", &args.csv), ("--tune", &args.tune)] {
        if let Some(path) = file {
            check_writable(path).map_err(|m| Error::Unavailable(format!("{option} {}: {m}", path.display())))?;
        }
    }
    session::stop_on_interrupt(INTERRUPTED.into())?;
    match &args.tune {
        Some(path) => tune(&options, path),
        None => measure(&options, args.csv.as_deref()),
    }
}

fn measure(options: &Options, csv: Option<&std::path::Path>) -> Result<ExitCode, Error> {
    let (mut rows, mut written): (Vec<Row>, _) = (Vec::new(), Ok(()));
    let ended = bench::run(options, &mut |said| match said {
        Said::Row(row) => {
            if rows.is_empty() {
                say!("{}", Row::heads());
            }
            say!("{}", row.table_line());
            rows.push(row.clone());
            // A benchmark that is cut off leaves the rows so far.
            if let (Some(path), Ok(())) = (csv, &written) {
                written = bench::write_csv(path, &rows);
            }
        }
        other => tell(&other),
    })?;
    written?;
    if let Some(path) = csv.filter(|_| !rows.is_empty()) {
        say!("Wrote {}: {} rows", path.display(), rows.len());
    }
    if ended == Ended::Interrupted {
        return Ok(INTERRUPTED.into());
    }
    let faults: Vec<String> = rows.iter().flat_map(Row::faults).collect();
    if faults.is_empty() { Ok(ExitCode::SUCCESS) } else { Err(Error::Fault(faults.join("\n"))) }
}

fn tune(options: &Options, path: &std::path::Path) -> Result<ExitCode, Error> {
    let (table, ended) = bench::tune(options, &mut |said| tell(&said))?;
    if ended == Ended::Interrupted {
        return Ok(INTERRUPTED.into());
    }
    std::fs::write(path, table.text()).map_err(|e| Error::file(path, "cannot write", e))?;
    say!("Wrote {}: in place of src/engine/tuned.txt it decides from the next build on", path.display());
    Ok(ExitCode::SUCCESS)
}

fn tell(said: &Said<'_>) {
    match said {
        Said::Note(note) => {
            say!("{note}");
        }
        Said::Tried(tried) => {
            let spread = tried.steps_per_s;
            let kernels = tried.choices.map_or(String::new(), |Choices { lanes, group, slices, blocks, ahead }| {
                format!(", lanes {lanes}, group {group}, slices {slices}, blocks {blocks}, ahead {ahead}")
            });
            say!(
                "{:>9} atoms, {:<6}, skin {:.2}{kernels}: {:.1} steps/s ({:.1} to {:.1}){}",
                tried.atoms,
                tried.precision,
                tried.skin,
                spread.median,
                spread.least,
                spread.most,
                if tried.best { ", the fastest" } else { "" }
            );
        }
        Said::Row(_) => {}
    }
}

impl From<SceneArg> for Scene {
    fn from(scene: SceneArg) -> Self {
        Scene::ALL[scene as usize]
    }
}
