//! `octant bench`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::run::INTERRUPTED;
use super::{EngineArgs, PrecisionArg, radius, size};
use crate::Error;
use crate::bench::{self, Ended, Options, Row, Said, Scene};
use crate::engine::Precision;
use crate::engine::tuned::Choices;
use crate::output::check_writable;
use crate::session;

/// What `octant bench --help` tells below the options.
pub const BENCH_HELP: &str = "\
Every precision starts from the same melted liquid (2 000 steps; 200 above 2 million atoms) and takes turns with the others, round
after round; list builds are part of what is timed. Beside the speed stand the force error (against f64 sums over all pairs: of all
atoms up to 32 000, of a sample above, smaller where there are more than 20 million atoms), the drift of the energy (up to 2 million
atoms) and the pairs that a list built during the run lacks or has too much, which must be none. Above 2 million atoms precisions
follow each other. Exit code 1: a list was wrong, or the energy drifted.";

#[derive(Args)]
pub struct BenchArgs {
    #[command(flatten)]
    engine: EngineArgs,
    /// Arithmetic, one or several.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "mixed,double")]
    precision: Vec<PrecisionArg>,
    /// Numbers of atoms; each is rounded to the nearest box of fcc cells.
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "4000,32000,131072", value_parser = size)]
    sizes: Vec<usize>,
    /// Skin in sigma, or that of the table which a tuning run has made.
    #[arg(long, value_name = "S|auto", default_value = "auto", value_parser = skin)]
    skin: Auto<f64>,
    /// Steps of a timed leg, or as many as take half a second.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = steps)]
    steps: Auto<i64>,
    /// Timed legs of each precision, in turns; the table has median, least and most.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// What is run: the liquid, or a variant of it.
    #[arg(long, value_enum, default_value_t)]
    scene: SceneArg,
    /// Write the table as CSV, with all columns.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Try skins of 0.2 to 1.4 and, on a GPU, ways to make the kernels, and write a table with the fastest to FILE.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "tuned.txt", conflicts_with_all = ["csv", "skin"])]
    tune: Option<PathBuf>,
}

/// A value, or that the program shall find one.
#[derive(Clone, Copy)]
struct Auto<T>(Option<T>);

#[derive(Clone, Copy, Default, ValueEnum)]
enum SceneArg {
    /// The Lennard-Jones liquid.
    #[default]
    Lj,
    /// The same with a Morse potential.
    Morse,
    /// Two types at random, with a cutoff for each pair of types.
    TwoTypes,
    /// Energy and virial at every step.
    Sums,
}

/// `auto`, or what `parse` makes of the text.
fn auto<T>(text: &str, parse: impl FnOnce(&str) -> Result<T, String>) -> Result<Auto<T>, String> {
    if text == "auto" {
        Ok(Auto(None))
    } else {
        parse(text).map(|value| Auto(Some(value))).map_err(|m| m + ", or auto")
    }
}

fn skin(text: &str) -> Result<Auto<f64>, String> {
    auto(text, radius)
}

fn steps(text: &str) -> Result<Auto<i64>, String> {
    let count = |text: &str| text.parse().ok().filter(|n| (1..=1_000_000_000).contains(n));
    auto(text, |text| count(text).ok_or_else(|| "expected 1 to 1 000 000 000 steps".into()))
}

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

fn measure(options: &Options, csv: Option<&Path>) -> Result<ExitCode, Error> {
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

fn tune(options: &Options, path: &Path) -> Result<ExitCode, Error> {
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
