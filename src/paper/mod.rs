//! `octant paper`: the experiments of Morillo et al. 2015 (doi:10.2312/vriphys.20151339), and those it leaves out, on any engine.

mod experiment;
mod figure4;
mod later;
mod measure;
mod orders;
mod scenes;
mod searches;
mod stability;
mod table1;

use std::cell::Cell;

use crate::Error;
use crate::bench::{Ended, Halt, Machine};
use crate::session::Settings;
pub use experiment::{Experiment, Row};
use measure::Lab;
pub use orders::SEARCHES as ORDERED;
pub use searches::{EXHAUSTIVE, Listed, SEARCHES};
pub use table1::{Published, TABLE_1, expected_neighbors};

/// What to measure and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Engine, device, threads, precision.
    pub settings: Settings,
    /// Numbers of particles of figure 5; the largest is, within bounds, that of figure 4 and of the distributions.
    pub sizes: Vec<usize>,
    /// Rounds of each time, and seeds of Table 1.
    pub rounds: usize,
    /// Seconds of a round, about; a build at least.
    pub round_seconds: f64,
    /// How the paper's step is left: its timestep is halved so many times.
    pub halvings: u32,
}

/// What comes out as it is measured.
pub enum Said {
    /// Something to know.
    Note(String),
    /// An experiment begins.
    Begin(&'static Experiment),
    /// A row of the experiment that began last.
    Row(Row),
    /// Particles that lists were built of.
    Particles(Listed),
}

/// The experiments, in the order in which they are run.
pub fn experiments() -> [&'static Experiment; 7] {
    [
        &table1::EXPERIMENT,
        &later::EXPERIMENT,
        &stability::EXPERIMENT,
        &figure4::EXPERIMENT,
        &orders::EXPERIMENT,
        &searches::DISTRIBUTIONS,
        &searches::FIGURE_5,
    ]
}

/// Runs all experiments; `say` gets every row as soon as it is there, and returns whether to go on. An error where the engine cannot be had or fails, or where two
/// searches find different numbers of neighbors.
pub fn run(options: &Options, say: &mut dyn FnMut(Said) -> bool) -> Result<Ended, Error> {
    options.settings.check()?;
    let (machine, note) = Machine::new(&options.settings)?;
    if let Some(note) = note {
        say(Said::Note(note));
    }
    let Options { rounds, round_seconds, halvings, .. } = *options;
    let broken = Cell::new(false);
    let lab = Lab { settings: options.settings.clone(), machine, rounds, round_seconds, halvings, broken };
    for experiment in experiments() {
        let mut listed = Vec::new();
        say(Said::Begin(experiment));
        let found = &mut |row| {
            if !say(Said::Row(row)) {
                lab.broken.set(true);
            }
        };
        let ran = match experiment.name {
            "table1" => table1::run(&lab, found),
            "later" => later::run(&options.sizes, &lab, found),
            "stability" => stability::run(&lab, found),
            "orders" => orders::run(&options.sizes, &lab, found),
            "figure4" => figure4::run(&options.sizes, &lab, found),
            "figure5" => searches::by_size(&options.sizes, &lab, found),
            _ => searches::by_distribution(&options.sizes, &lab, found).map(|all| listed = all),
        };
        match ran {
            Ok(()) => listed.drain(..).for_each(|one| lab.broken.set(!say(Said::Particles(one)) || lab.broken.get())),
            Err(Halt::Interrupted) => return Ok(Ended::Interrupted),
            Err(Halt::Error(error)) => return Err(error),
        }
    }
    Ok(Ended::Finished)
}
