//! `octant paper`.

use std::collections::HashSet;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use super::PaperArgs;
use super::run::INTERRUPTED;
use crate::Error;
use crate::bench::Ended;
use crate::engine::Precision;
use crate::output::{check_writable, write_csv};
use crate::paper::{self, Experiment, Listed, Options, Row, Said, TABLE_1};
use crate::session::{self, Settings};
use crate::system::Vec3;

/// Sizes, rounds, seconds of a round and halvings of the timestep, in full and with `--quick`.
const ROUNDS: usize = 5;
const ROUND_SECONDS: f64 = 0.1;
const HALVINGS: u32 = 6;
const QUICK_SIZES: [usize; 2] = [1000, 5000];
const QUICK_ROUNDS: usize = 2;
const QUICK_ROUND_SECONDS: f64 = 0.01;
const QUICK_HALVINGS: u32 = 2;

/// Runs the experiments; prints rows as they come and writes a file for each experiment.
pub fn paper(args: PaperArgs) -> Result<ExitCode, Error> {
    let full: Vec<usize> = TABLE_1.iter().map(|of| of.particles).collect();
    let (sizes, rounds, round_seconds, halvings) = match args.quick {
        true => (QUICK_SIZES.to_vec(), QUICK_ROUNDS, QUICK_ROUND_SECONDS, QUICK_HALVINGS),
        false => (full, ROUNDS, ROUND_SECONDS, HALVINGS),
    };
    let settings =
        Settings { precision: Precision::ALL[args.precision as usize], quiet: true, ..args.engine.settings() };
    settings.check()?;
    let mut sizes = args.sizes.unwrap_or(sizes);
    let mut seen = HashSet::new();
    sizes.retain(|size| seen.insert(*size));
    let options = Options { settings, sizes, rounds: args.rounds.map_or(rounds, usize::from), round_seconds, halvings };
    let out = args.out.as_path();
    fs::create_dir_all(out).map_err(|e| Error::file(out, "cannot create the folder", e))?;
    for experiment in paper::experiments() {
        let path = out.join(experiment.name).with_extension("csv");
        check_writable(&path).map_err(|m| Error::Unavailable(format!("--out {}: {m}", out.display())))?;
    }
    session::stop_on_interrupt(INTERRUPTED.into())?;
    run(&options, args.particles, out)
}

fn run(options: &Options, particles: bool, out: &Path) -> Result<ExitCode, Error> {
    let (mut current, mut rows, mut written): (Option<&Experiment>, Vec<Row>, _) = (None, Vec::new(), Ok(()));
    let ended = paper::run(options, &mut |said| match said {
        Said::Note(note) => {
            say!("{note}");
            true
        }
        Said::Begin(experiment) => {
            say!("{}{}\n", if current.is_some() { "\n" } else { "" }, experiment.title);
            say!("{}", experiment.heads());
            (current, rows) = (Some(experiment), Vec::new());
            true
        }
        Said::Row(row) => {
            let Some(experiment) = current else { return true };
            say!("{}", experiment.table_line(&row));
            rows.push(row);
            // Experiments that are cut off leave the rows so far.
            written = write(experiment, out, &rows);
            written.is_ok()
        }
        Said::Particles(listed) => {
            written = if particles { write_particles(&listed, out) } else { Ok(()) };
            written.is_ok()
        }
    })?;
    written?;
    if ended == Ended::Interrupted {
        return Ok(INTERRUPTED.into());
    }
    say!("\nWrote {}", out.display());
    Ok(ExitCode::SUCCESS)
}

fn write(experiment: &Experiment, out: &Path, rows: &[Row]) -> Result<(), Error> {
    let heads: Vec<&str> = rows.first().map_or(Vec::new(), |row| row.iter().map(|(head, _)| *head).collect());
    let cells: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(|(_, cell)| cell.clone()).collect()).collect();
    write_csv(&out.join(experiment.name).with_extension("csv"), &heads, &cells)
}

fn write_particles(listed: &Listed, out: &Path) -> Result<(), Error> {
    let of = |(id, (x, neighbors)): (usize, (&Vec3, &u32))| {
        vec![(id + 1).to_string(), x.x.to_string(), x.y.to_string(), x.z.to_string(), neighbors.to_string()]
    };
    let rows: Vec<Vec<String>> = listed.x.iter().zip(&listed.neighbors).enumerate().map(of).collect();
    write_csv(&out.join(format!("particles-{}.csv", listed.name)), &["id", "x", "y", "z", "neighbors"], &rows)
}
