//! One scene of one size, melted once and measured in every precision.

use serde_json::Value;

use super::exact::{self, Atom};
use super::row::{Row, Spread, Stages};
use super::scene::{Scene, TIMESTEP};
use super::sizes::Cells;
use super::{Halt, Plan, drift};
use crate::engine::Precision;
use crate::output::{RunSummary, StageTimes};
use crate::session::{Driven, Outcome, Prepared, Settings, is_interrupted};
use crate::system::SimulationBox;

/// Steps before anything is timed, and up to how many atoms; above them a melt takes too long.
const MELTING: i64 = 2_000;
const MELTS_IN_FULL: usize = 2_000_000;
const SHORT_MELTING: i64 = 200;
/// Up to this many atoms all precisions are held at once and take turns; above it one follows the other.
const TAKES_TURNS: usize = 2_000_000;
/// Up to this many atoms the drift of the energy is measured.
const MOST_FOR_DRIFT: usize = 2_000_000;
/// Atom-steps of the leg that tells how fast the others will be, which also warms up; its length in steps.
const PILOT_ATOM_STEPS: usize = 4_000_000;
const PILOT_STEPS: (usize, usize) = (20, 1_000);
/// Seconds of a timed leg whose length is found out, and its least steps: several lists are built in them.
const LEG_SECONDS: f64 = 0.5;
const LEAST_STEPS: i64 = 50;
/// The leg for the drift of the energy, as a multiple of a timed one; its length in steps, its least atom-steps (energies of small
/// scenes scatter more), and energies looked at.
const DRIFT_LEGS: i64 = 2;
const DRIFT_STEPS: (i64, i64) = (400, 20_000);
const DRIFT_ATOM_STEPS: usize = 8_000_000;
const ENERGIES: i64 = 100;
/// Steps within which a liquid builds a list.
const STEPS_TO_BUILD: u64 = 1_000;

/// What is measured: one scene, one size.
pub struct Case {
    pub scene: Scene,
    pub asked: usize,
    pub cells: Cells,
}

/// One precision of it.
struct Leg<'a> {
    settings: &'a Settings,
    skin: f64,
    driven: Driven<'a>,
    start_up: f64,
    force_error: (f64, f64),
    steps: i64,
    runs: Vec<RunSummary>,
    /// Builds, and dangerous ones, before the first timed leg.
    before: (u64, Option<u64>),
}

/// Steps of the melt.
pub fn melting(atoms: usize) -> i64 {
    if atoms <= MELTS_IN_FULL { MELTING } else { SHORT_MELTING }
}

/// The liquid, and the seconds from the crystal in memory to its first step.
pub fn melt(case: &Case, skin: f64, settings: &Settings) -> Result<(Prepared, f64), Halt> {
    let mut prepared = Prepared::new("bench", &case.scene.script(case.cells, skin), settings)?;
    case.scene.finish(prepared.state_mut());
    let mut driven = Driven::new(prepared, settings)?;
    go(&mut driven, &format!("run {}", melting(case.cells.atoms())))?;
    let start_up = driven.start_up();
    Ok((driven.into_prepared(), start_up))
}

/// Measures a case; `found` gets its rows as they are there, one a precision, in their order.
pub fn measure(case: &Case, plan: &Plan, found: &mut dyn FnMut(&Row)) -> Result<(), Halt> {
    let atoms = case.cells.atoms();
    let first = &plan.settings[0];
    let (melted, start_up) = melt(case, plan.skin(first, atoms, case)?, first)?;
    let simulation_box = melted.simulation_box().expect("the script makes a box").clone();
    let ids = exact::sample(melted.state());
    // Of the positions as they are handed over, so that what a precision rounds of them counts.
    let pair = melted.program(first)?.pair;
    let exact = exact::look_up(&pair, 0.0, melted.state(), &simulation_box, &ids, 0.0);
    let together = if atoms <= TAKES_TURNS { plan.settings.len() } else { 1 };
    for settings in plan.settings.chunks(together) {
        let mut legs = Vec::new();
        for settings in settings {
            let mut leg = Leg::begin(case, plan, &melted, settings, (&ids, &exact))?;
            if settings.precision == first.precision {
                leg.start_up = start_up;
            }
            legs.push(leg);
        }
        for round in 0..plan.rounds {
            let from = round % legs.len();
            legs.rotate_left(from);
            for leg in &mut legs {
                go(&mut leg.driven, &format!("run {} pre no", leg.steps))?;
                leg.runs.extend(leg.driven.summary().cloned());
            }
            legs.rotate_right(from);
        }
        for leg in legs {
            found(&leg.row(case, plan, &ids, &simulation_box)?);
        }
    }
    Ok(())
}

impl<'a> Leg<'a> {
    /// Sets up on the melted liquid, compares forces there, and finds out how long a timed leg has to be.
    fn begin(
        case: &Case,
        plan: &Plan,
        melted: &Prepared,
        settings: &'a Settings,
        (ids, exact): (&[u32], &[Atom]),
    ) -> Result<Self, Halt> {
        let atoms = melted.state().len();
        let skin = plan.skin(settings, atoms, case)?;
        let mut driven = Driven::new(melted.clone(), settings)?;
        go(&mut driven, &format!("neighbor {skin} bin\nrun 0"))?;
        let start_up = driven.start_up();
        let force_error = exact::force_errors(ids, exact, driven.state());
        let pilot = (PILOT_ATOM_STEPS / atoms).clamp(PILOT_STEPS.0, PILOT_STEPS.1);
        go(&mut driven, &format!("thermo {}\nrun {pilot} pre no", case.scene.thermo()))?;
        let ran = driven.summary().expect("a run leaves a summary");
        let before = (ran.neighbors.builds, ran.neighbors.dangerous);
        let steps = plan.steps.unwrap_or_else(|| leg_steps(ran.steps_per_second()));
        Ok(Self { settings, skin, driven, start_up, force_error, steps, runs: Vec::new(), before })
    }

    /// The energy's drift and the list's pairs, then everything together.
    fn row(mut self, case: &Case, plan: &Plan, ids: &[u32], space: &SimulationBox) -> Result<Row, Halt> {
        let (atoms, settings) = (case.cells.atoms(), self.settings);
        let bytes_per_atom = self.driven.backend().bytes() as f64 / atoms as f64;
        let work = self.driven.backend().work();
        let (drift, drift_steps) = if atoms <= MOST_FOR_DRIFT { self.drift(atoms)? } else { (None, 0) };
        let missing_extra = self.missing_extra(ids, space)?;
        let rates: Vec<f64> = self.runs.iter().map(RunSummary::steps_per_second).collect();
        let steps = self.runs.iter().map(|run| run.steps).sum::<i64>() as f64;
        let mut seconds = StageTimes::default();
        self.runs.iter().for_each(|run| seconds.add(&run.stages));
        let us = |seconds: f64| seconds * 1e6 / steps;
        let last = self.runs.last().expect("there is a round").neighbors;
        let builds = last.builds - self.before.0;
        let each_build = |of: f64| (builds > 0).then(|| of / builds as f64);
        Ok(Row {
            scene: case.scene.name(),
            asked: case.asked,
            atoms,
            cells: case.cells.to_string(),
            precision: settings.precision.name(),
            backend: plan.machine.backend.clone(),
            device: plan.machine.device.clone(),
            driver: plan.machine.driver.clone(),
            skin: self.skin,
            melted: melting(atoms),
            steps: self.steps,
            rounds: plan.rounds,
            steps_per_s: Spread::of(&rates),
            stages: Stages {
                pair: us(seconds.pair),
                list: us(seconds.list),
                sort: us(seconds.sort),
                check: us(seconds.check),
                modify: us(seconds.modify),
                output: us(seconds.output),
                other: us(seconds.other),
            },
            steps_per_build: each_build(steps),
            build_us: each_build((seconds.list + seconds.sort) * 1e6),
            list_entries_per_atom: work.list_entries_per_atom,
            bytes_per_atom,
            start_up: self.start_up,
            drift,
            drift_steps,
            force_error: self.force_error,
            missing_extra,
            sampled: ids.len(),
            dangerous: last.dangerous.zip(self.before.1).map(|(after, before)| after - before),
        })
    }

    /// Slope of the total energy in a longer leg, and its steps.
    fn drift(&mut self, atoms: usize) -> Result<(Option<(f64, f64)>, i64), Halt> {
        let least = DRIFT_STEPS.0.max((DRIFT_ATOM_STEPS / atoms) as i64);
        let steps = least.max(DRIFT_LEGS * self.steps).min(DRIFT_STEPS.1);
        self.driven.take_thermo();
        let every = (steps / ENERGIES).max(1);
        let whole = every * (steps / every);
        go(&mut self.driven, &format!("thermo {every}\nthermo_modify norm yes\nrun {whole} pre no"))?;
        let value = |row: &serde_json::Map<String, Value>, name: &str| row.get(name).and_then(Value::as_f64);
        let rows = self.driven.take_thermo();
        let points = rows.iter().filter_map(|row| value(row, "Step").map(|s| s * TIMESTEP).zip(value(row, "TotEng")));
        Ok((drift::slope(&points.collect::<Vec<_>>()), whole))
    }

    /// Pairs that the list of the next build lacks, and those that it has too much; `None` where there was no build.
    fn missing_extra(&mut self, ids: &[u32], space: &SimulationBox) -> Result<Option<(usize, usize)>, Halt> {
        if !self.driven.step_to_build(STEPS_TO_BUILD)? {
            return if is_interrupted() { Err(Halt::Interrupted) } else { Ok(None) };
        }
        let program = self.driven.program()?;
        let band = rounding(self.settings.precision, space);
        let atoms = exact::look_up(&program.pair, self.skin, self.driven.state(), space, ids, band);
        let listed = self.driven.backend().pairs_where(&|id| ids.binary_search(&id).is_ok())?;
        let mut listed: Vec<(u32, u32)> = listed.into_iter().map(|(i, j, _)| (i, j)).collect();
        listed.sort_unstable();
        Ok(Some(exact::missing_and_extra(ids, &atoms, &listed)))
    }
}

/// Distance to a neighbor cutoff within which rounding decides, sigma: of f64 in the box, or of f32 in a cell.
fn rounding(precision: Precision, space: &SimulationBox) -> f64 {
    let f64_in_the_box = 1e-12 * space.lengths().amax();
    if precision == Precision::Single { f64_in_the_box + 2e-6 } else { f64_in_the_box }
}

/// Steps of a leg at so many steps a second.
fn leg_steps(rate: f64) -> i64 {
    ((rate * LEG_SECONDS) as i64).max(LEAST_STEPS)
}

/// Carries out commands; an interruption ends the benchmark.
pub fn go(driven: &mut Driven<'_>, commands: &str) -> Result<(), Halt> {
    match driven.carry_out(commands)? {
        Outcome::Finished => Ok(()),
        Outcome::Interrupted => Err(Halt::Interrupted),
    }
}
