//! `octant report`: error against run time of the user's own scene, by precision, time step, list and integrator.

mod broken;
mod chart;
mod charts;
mod content;
mod cutoff;
mod front;
mod lammps;
mod measure;
mod pace;
mod page;
mod plan;
mod point;
mod price;
mod sections;
mod statistics;
mod store;
mod study;

use std::path::PathBuf;

use crate::Error;
use crate::bench::{Ended, Halt};
use crate::engine::Precision;
use crate::session::{Settings, is_interrupted};
use content::Facts;
use lammps::Lammps;
use measure::References;
use plan::{Job, Plan, Work};
use store::{Store, Table};
use study::Study;

/// What to study and how.
#[derive(Clone, Debug)]
pub struct Options {
    pub script: PathBuf,
    /// Engine, device, threads, variables of the script.
    pub settings: Settings,
    /// At least one.
    pub precisions: Vec<Precision>,
    /// Time units; the script's own is always among them. `None` for a grid around it.
    pub dts: Option<Vec<f64>>,
    /// Length units; the script's own is always among them. `None` for a grid.
    pub skins: Option<Vec<f64>>,
    /// Values to compare averages with: U (energy units per atom) and P (pressure units).
    pub reference: Vec<(String, f64)>,
    pub quick: bool,
    /// Folder for pages, figures and tables; it is made if need be.
    pub out: PathBuf,
    /// A Python that has LAMMPS; `None` to look for one.
    pub python: Option<PathBuf>,
}

/// What comes out as it is measured.
pub enum Said<'a> {
    /// Something to know.
    Note(String),
    /// Measurements done and in all, work done and in all (steps, about), and what comes next.
    Progress { done: usize, all: usize, work: (f64, f64), next: &'a str },
    /// The sentence to take away.
    Advice(String),
}

const TABLES: [&Table; 8] = [
    &measure::FORCES,
    &measure::TRAJECTORIES,
    &measure::ENERGIES,
    &measure::AVERAGES,
    &measure::MISSING,
    &measure::SPEEDS,
    &price::PRICES,
    &lammps::LAMMPS,
];

/// Measures what the folder does not hold yet, and writes the pages.
pub fn run(options: &Options, say: &mut dyn FnMut(Said<'_>)) -> Result<Ended, Error> {
    match study(options, say) {
        Ok(ended) => Ok(ended),
        Err(Halt::Interrupted) => Ok(Ended::Interrupted),
        Err(Halt::Error(error)) => Err(error),
    }
}

fn study(options: &Options, say: &mut dyn FnMut(Said<'_>)) -> Result<Ended, Halt> {
    let scale = if options.quick { plan::QUICK } else { plan::FULL };
    let Some(study) = Study::new(&options.script, &options.settings, scale.force_atoms)? else {
        return Ok(Ended::Interrupted);
    };
    study.notes.iter().for_each(|note| say(Said::Note(note.clone())));
    let lammps = Lammps::find(&study, options.python.as_deref(), study.threads());
    let no_lammps = lammps.as_ref().err().cloned().unwrap_or_default();
    if !no_lammps.is_empty() {
        say(Said::Note(format!("LAMMPS is not measured: {no_lammps}")));
    }
    let plan = Plan::new(&study, options, lammps.as_ref().ok())?;
    let settings = settings(options, &study, &plan)?;
    if let Some(note) = Store::strange(&options.out, &TABLES, &settings) {
        say(Said::Note(note));
    }
    let mut store = Store::open(&options.out, &TABLES, &settings)?;
    if store.len() > 0 {
        say(Said::Note(format!("{} rows are in {} already", store.len(), options.out.display())));
    }
    let ended = measure(&study, &plan, lammps.as_ref().ok(), &mut store, say)?;
    let interrupted = ended == Ended::Interrupted;
    let facts = Facts { study: &study, plan: &plan, store: &store, options, no_lammps: &no_lammps, interrupted };
    let points = front::points(&store);
    let blocks = facts.blocks(&points).map_err(Error::Unavailable)?;
    page::write(&options.out, &blocks)?;
    say(Said::Advice(facts.advice(&points)));
    Ok(ended)
}

/// Does what is left to do, in order.
fn measure(
    study: &Study,
    plan: &Plan,
    lammps: Option<&Lammps>,
    store: &mut Store,
    say: &mut dyn FnMut(Said<'_>),
) -> Result<Ended, Halt> {
    let left: Vec<&Job> = plan.jobs.iter().filter(|job| !store.has(job.table, &job.key)).collect();
    let work: f64 = left.iter().map(|job| job.steps).sum();
    let (mut spent, references) = (0.0, References::default());
    for (done, job) in left.iter().enumerate() {
        let next = format!("{} {}", job.table.name, job.key.join(", "));
        say(Said::Progress { done, all: left.len(), work: (spent, work), next: &next });
        let cells = match &job.work {
            Work::Forces(potential, precision) => measure::forces(study, *potential, *precision),
            Work::Trajectory(point) => measure::trajectory(study, point, plan.span, &references),
            Work::Energies(point) => {
                measure::energies(study, point, plan.energy_time(), plan.scale.samples, plan.fastest)
            }
            Work::Averages(precision) => measure::averages(study, *precision, plan.averages_time(), plan.scale.samples),
            Work::Missing(point) => measure::missing(study, point, plan.scale.looks, plan.scale.look_atoms),
            Work::Speed(point) => measure::speed(study, point, plan.scale.leg),
            Work::Price(option) => price::price(study, plan.usual, *option, plan.scale.leg),
            Work::Lammps(dt) => match lammps {
                Some(lammps) => lammps.measure(study, plan, *dt, &references),
                None => continue,
            },
        };
        match cells {
            Ok(_) if is_interrupted() => return Ok(Ended::Interrupted),
            Ok(cells) => store.put(job.table, job.key.clone(), cells)?,
            Err(Halt::Interrupted) => return Ok(Ended::Interrupted),
            Err(error) => return Err(error),
        }
        spent += job.steps;
    }
    Ok(Ended::Finished)
}

/// All that decides what a row holds: rows of other settings are not gone on from. LAMMPS's rows say themselves of which version they are.
fn settings(options: &Options, study: &Study, plan: &Plan) -> Result<String, Error> {
    let path = &options.script;
    let script = std::fs::read_to_string(path).map_err(|e| Error::file(path, "cannot read", e))?;
    let machine = &study.machine;
    let names: Vec<&str> = options.precisions.iter().map(|precision| precision.name()).collect();
    Ok(format!(
        "octant {} report\nengine: {} {} {}\nextent: {:?}\nprecisions: {}\ndts: {:?}\nskins: {:?}\nvariables: {:?}\n\
         melted: {:016x}\nscript: {}\n\n{script}",
        env!("CARGO_PKG_VERSION"),
        machine.backend,
        machine.device,
        machine.driver,
        plan.scale,
        names.join(", "),
        options.dts,
        options.skins,
        options.settings.variables,
        study.digest(),
        path.display(),
    ))
}
