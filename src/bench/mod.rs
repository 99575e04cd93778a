//! `octant bench`: speed, error and memory of the Lennard-Jones liquid that programs are compared on (LAMMPS `bench/in.lj`), run
//! as `octant run` runs a script.

pub(crate) mod drift;
pub(crate) mod exact;
mod measure;
mod row;
mod scene;
mod sizes;
mod tune;

use crate::Error;
use crate::engine::tuned::Table;
use crate::engine::{Backend, Precision};
use crate::session::{Prepared, Settings};
use measure::Case;
pub(crate) use measure::go;
pub use row::{Row, Spread, write_csv};
pub use scene::Scene;
pub use sizes::{Cells, FEWEST, MOST};
pub use tune::{Tried, tune};

/// What to measure and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Engine, device, threads; its precision is of no account.
    pub settings: Settings,
    pub precisions: Vec<Precision>,
    /// Numbers of atoms, as asked for.
    pub sizes: Vec<usize>,
    pub scene: Scene,
    /// Sigma; `None` for that of the table.
    pub skin: Option<f64>,
    /// Steps of a timed leg; `None` for about half a second.
    pub steps: Option<i64>,
    /// Timed legs of each precision.
    pub rounds: usize,
}

/// What comes out as it is measured.
pub enum Said<'a> {
    /// Something to know.
    Note(String),
    Row(&'a Row),
    Tried(&'a Tried),
}

/// How a benchmark ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    Finished,
    /// The user interrupted it; the rows so far are whole.
    Interrupted,
}

/// Why a measurement stopped.
pub(crate) enum Halt {
    Interrupted,
    Error(Error),
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Halt::Error(error)
    }
}

/// The engine in words.
pub(crate) struct Machine {
    pub backend: String,
    pub device: String,
    pub driver: String,
    /// As the table of choices has it.
    pub architecture: String,
    /// Holds the device, so that no row has the driver's own start in it.
    _held: Box<dyn Backend>,
}

impl Machine {
    /// Of the engine that the settings ask for, and a line for the user where it is not the one that was hoped for.
    pub fn new(settings: &Settings) -> Result<(Self, Option<String>), Error> {
        let (backend, note) = settings.engine()?;
        // "cuda, NVIDIA H100, mixed precision", "cpu, 2 threads, mixed precision, avx2".
        let words = backend.describe();
        let mut parts = words.split(", ");
        let name = parts.next().unwrap_or_default().to_string();
        let device = parts.filter(|part| !part.ends_with(" precision")).collect::<Vec<_>>().join(" ");
        let details = backend.details();
        let detail = |wanted: &str| details.iter().find(|(key, _)| *key == wanted).map(|(_, value)| value.clone());
        let (architecture, driver) = (detail("architecture"), detail("driver").unwrap_or_default());
        let architecture = architecture.unwrap_or_else(|| name.clone());
        Ok((Self { backend: name, device, driver, architecture, _held: backend }, note))
    }
}

/// Options with what follows from them.
struct Plan {
    machine: Machine,
    /// One a precision.
    settings: Vec<Settings>,
    skin: Option<f64>,
    steps: Option<i64>,
    rounds: usize,
}

impl Plan {
    fn new(options: &Options) -> Result<(Self, Option<String>), Error> {
        options.settings.check()?;
        let quiet = Settings { log: None, json: None, quiet: true, ..options.settings.clone() };
        let with = |precision: &Precision| Settings { precision: *precision, ..quiet.clone() };
        let settings: Vec<Settings> = options.precisions.iter().map(with).collect();
        let (machine, note) = Machine::new(&settings[0])?;
        let Options { skin, steps, rounds, .. } = *options;
        Ok((Self { machine, settings, skin, steps, rounds }, note))
    }

    /// Skin in sigma, of the command line or the table.
    fn skin(&self, settings: &Settings, atoms: usize, case: &Case) -> Result<f64, Error> {
        let tuned = || Table::built_in().skin(&self.machine.architecture, settings.precision, atoms);
        let skin = self.skin.unwrap_or_else(tuned);
        if !fits(case, skin) {
            let message =
                format!("--skin {skin}: a box of {} cells is narrower than twice cutoff and skin", case.cells);
            return Err(Error::Unavailable(message));
        }
        Ok(skin)
    }
}

/// The liquid of about so many atoms, melted, with a skin in sigma.
pub(crate) fn liquid(atoms: usize, skin: f64, settings: &Settings) -> Result<Prepared, Halt> {
    let case = Case { scene: Scene::Lj, asked: atoms, cells: Cells::nearest(atoms) };
    measure::melt(&case, skin, settings).map(|(melted, _)| melted)
}

/// Whether the nearest image is enough for a list with this skin.
fn fits(case: &Case, skin: f64) -> bool {
    case.cells.shortest() as f64 * Scene::cell_edge() > 2.0 * (case.scene.largest_cutoff() + skin)
}

/// The sizes of a benchmark as boxes; a number that is no such box is told of.
fn cases(options: &Options, say: &mut dyn FnMut(Said<'_>)) -> Vec<Case> {
    let case = |asked: &usize| {
        let cells = Cells::nearest(*asked);
        if cells.atoms() != *asked {
            say(Said::Note(format!("{asked} atoms: the nearest box has {cells} cells, {} atoms", cells.atoms())));
        }
        Case { scene: options.scene, asked: *asked, cells }
    };
    options.sizes.iter().map(case).collect()
}

/// Measures size after size; `say` gets every row as soon as it is there.
pub fn run(options: &Options, say: &mut dyn FnMut(Said<'_>)) -> Result<Ended, Error> {
    let (plan, note) = Plan::new(options)?;
    if let Some(note) = note {
        say(Said::Note(note));
    }
    for case in cases(options, say) {
        match measure::measure(&case, &plan, &mut |row| say(Said::Row(row))) {
            Ok(()) => {}
            Err(Halt::Interrupted) => return Ok(Ended::Interrupted),
            Err(Halt::Error(error)) => return Err(error),
        }
    }
    Ok(Ended::Finished)
}
