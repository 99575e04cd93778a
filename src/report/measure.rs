//! What is measured of a point: errors of its forces, of its trajectory, of its energy; missing pairs; time.

use std::cell::OnceCell;

use serde_json::Value;

use super::point::{Integrator, KEYS, Point, Potential};
use super::statistics::{about_line, blocked, slope_of_walk, walk};
use super::store::Table;
use super::study::Study;
use crate::Error;
use crate::bench::{Halt, drift, exact, go};
use crate::engine::Precision;
use crate::output::printf::format_g;
use crate::session::Driven;

/// Force errors of a potential in a precision, relative to the RMS force.
pub static FORCES: Table = Table {
    name: "forces",
    keys: &["potential", "precision"],
    values: &["force_error_rms", "force_error_worst", "rms_force", "atoms"],
};
/// Distance from the reference trajectory at its end, length units.
pub static TRAJECTORIES: Table = Table {
    name: "trajectories",
    keys: KEYS,
    values: &["dt_used", "steps", "time", "rms_error", "worst_error", "fault"],
};
/// Energies per atom, energy units; drifts a time unit. Plain is E as the bare potential has it, continuous is E - N_pairs U(cutoff).
pub static ENERGIES: Table = Table {
    name: "energies",
    keys: KEYS,
    values: &[
        "time",
        "steps",
        "samples",
        "drift_plain",
        "drift_plain_error",
        "fluctuation_plain",
        "drift",
        "drift_error",
        "fluctuation",
        "walk",
        "walk_error",
        "walk_predicted",
        "temperature",
        "potential_energy",
        "potential_energy_error",
        "pressure",
        "pressure_error",
        "fault",
    ],
};
/// Averages with the script's thermostats.
pub static AVERAGES: Table = Table {
    name: "averages",
    keys: &["precision", "dt"],
    values: &[
        "time",
        "steps",
        "temperature",
        "temperature_error",
        "potential_energy",
        "potential_energy_error",
        "pressure",
        "pressure_error",
        "fault",
    ],
};
/// Pairs within the cutoff that the list lacks.
pub static MISSING: Table = Table {
    name: "missing",
    keys: KEYS,
    values: &["looks", "atoms", "pairs", "missing", "missing_worst_look", "fault"],
};
/// Wall time of legs.
pub static SPEEDS: Table = Table {
    name: "speeds",
    keys: &["round", "potential", "integrator", "precision", "dt", "skin", "rebuild"],
    values: &["steps", "seconds", "seconds_per_time", "builds", "fault"],
};

/// A number with all digits that matter here.
pub fn number(x: f64) -> String {
    format_g(x, 0, 8, false)
}

fn maybe(x: Option<f64>) -> String {
    x.map_or(String::new(), number)
}

/// Cells of a row, or what went wrong with the dynamics: that a scene breaks is a result as well.
fn or_fault(table: &Table, measured: Result<Vec<String>, Halt>) -> Result<Vec<String>, Halt> {
    match measured {
        Err(Halt::Error(Error::Fault(message))) => {
            let mut cells = vec![String::new(); table.values.len()];
            cells[table.values.len() - 1] = message.lines().next().unwrap_or_default().to_string();
            Ok(cells)
        }
        other => other,
    }
}

pub fn forces(study: &Study, potential: Potential, precision: Precision) -> Result<Vec<String>, Halt> {
    let exact = study.exact(potential)?;
    let mut driven = study.begin(&Point { potential, policy: study.safe(), ..study.own(precision) })?;
    go(&mut driven, "run 0")?;
    let (rms, worst) = exact::force_errors(exact.ids, exact.atoms, driven.state());
    let relative = |error: f64| if study.still { String::new() } else { number(error) };
    Ok(vec![relative(rms), relative(worst), number(study.rms_force()?), exact.ids.len().to_string()])
}

/// Positions by id at the end of reference runs, worked out when they are first asked for.
#[derive(Default)]
pub struct References {
    ends: [OnceCell<Vec<(u32, crate::system::Vec3)>>; 2],
}

/// How trajectories are compared.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Time units.
    pub time: f64,
    /// Time step of the reference, time units.
    pub reference_dt: f64,
}

fn ends(driven: &Driven<'_>) -> Vec<(u32, crate::system::Vec3)> {
    let state = driven.state();
    state.order_by_id().into_iter().map(|k| (state.id[k], state.x[k])).collect()
}

/// Steps that fill the time, and their length, which differs a little from the one asked for.
pub fn whole(time: f64, dt: f64) -> (u64, f64) {
    let steps = (time / dt).round().max(1.0);
    (steps as u64, time / steps)
}

impl References {
    fn end(&self, study: &Study, potential: Potential, span: Span) -> Result<&[(u32, crate::system::Vec3)], Halt> {
        let cell = &self.ends[potential as usize];
        if cell.get().is_none() {
            let (steps, dt) = whole(span.time, span.reference_dt);
            let point = Point { potential, dt, policy: study.safe(), ..study.own(Precision::Double) };
            let mut driven = study.begin(&point)?;
            go(&mut driven, &format!("run {steps}"))?;
            let _ = cell.set(ends(&driven));
        }
        Ok(cell.get().expect("it was just set"))
    }

    /// RMS and largest distance of positions by id from the reference.
    pub fn distance(
        &self,
        study: &Study,
        potential: Potential,
        span: Span,
        found: &[(u32, crate::system::Vec3)],
    ) -> Result<(f64, f64), Halt> {
        let reference = self.end(study, potential, span)?;
        if reference.len() != found.len() || reference.iter().zip(found).any(|(a, b)| a.0 != b.0) {
            return Err(Error::Fault("atoms were lost, trajectories cannot be compared".into()).into());
        }
        let squares = reference.iter().zip(found).map(|(a, b)| study.nearest(a.1 - b.1).norm_squared());
        let (sum, most) = squares.fold((0.0, 0.0f64), |(sum, most), d| (sum + d, most.max(d)));
        Ok(((sum / found.len().max(1) as f64).sqrt(), most.sqrt()))
    }
}

pub fn trajectory(study: &Study, point: &Point, span: Span, references: &References) -> Result<Vec<String>, Halt> {
    let measured = || {
        let (steps, dt) = whole(span.time, point.dt);
        let mut driven = study.begin(&Point { dt, ..*point })?;
        go(&mut driven, &format!("run {steps}"))?;
        let (rms, worst) = references.distance(study, point.potential, span, &ends(&driven))?;
        Ok(vec![dt.to_string(), steps.to_string(), number(span.time), number(rms), number(worst), String::new()])
    };
    or_fault(&TRAJECTORIES, measured())
}

/// Rows of a run with energies at even steps: time, total energy, potential energy, temperature, pressure.
struct Series(Vec<[f64; 5]>);

impl Series {
    fn measure(study: &Study, point: &Point, shift: bool, time: f64, samples: u64) -> Result<(Self, u64), Halt> {
        let mut driven = study.begin(point)?;
        go(&mut driven, &study.truncation(shift))?;
        Self::run(&mut driven, study, point.dt, time, samples)
    }

    fn run(driven: &mut Driven<'_>, study: &Study, dt: f64, time: f64, samples: u64) -> Result<(Self, u64), Halt> {
        let steps = (time / dt).round().max(samples as f64) as u64;
        let every = (steps / samples).max(1);
        let steps = every * (steps / every);
        go(driven, &format!("thermo {every}\nrun {steps}"))?;
        let first = study.melted().scene().step as f64;
        let value = |row: &serde_json::Map<String, Value>, name: &str| row.get(name).and_then(Value::as_f64);
        let rows = driven.take_thermo();
        let rows = rows.iter().filter_map(|row| {
            let [step, etotal, pe, temp, press] =
                ["Step", "TotEng", "PotEng", "Temp", "Press"].map(|name| value(row, name));
            Some([(step? - first) * dt, etotal?, pe?, temp?, press?])
        });
        let rows: Vec<_> = rows.collect();
        if rows.iter().flatten().any(|x| !x.is_finite()) {
            return Err(Error::Fault("the energy is no finite number".into()).into());
        }
        Ok((Self(rows), steps))
    }

    fn of(&self, column: usize) -> Vec<f64> {
        self.0.iter().map(|row| row[column]).collect()
    }

    fn energies(&self) -> Vec<(f64, f64)> {
        self.0.iter().map(|row| (row[0], row[1])).collect()
    }
}

/// Averages of a scene with its thermostats on; the first part of the run is left to them.
pub fn averages(study: &Study, precision: Precision, time: f64, samples: u64) -> Result<Vec<String>, Halt> {
    const SETTLING: usize = 5;
    let measured = || {
        let point = Point { policy: study.safe(), ..study.own(precision) };
        let (prepared, commands) = study.with_thermostats(&point).expect("this is measured of scenes with thermostats");
        let mut driven = Driven::new(prepared, study.settings(precision))?;
        go(&mut driven, &commands)?;
        let (Series(mut rows), steps) = Series::run(&mut driven, study, point.dt, time, samples)?;
        rows.drain(..rows.len() / SETTLING);
        let kept = Series(rows);
        let [potential, temperature, pressure] = [2, 3, 4].map(|column| blocked(&kept.of(column)));
        let cells = [temperature, potential, pressure]
            .into_iter()
            .flat_map(|of| [maybe(of.map(|p| p.0)), maybe(of.map(|p| p.1))]);
        Ok([number(steps as f64 * point.dt), steps.to_string()]
            .into_iter()
            .chain(cells)
            .chain([String::new()])
            .collect())
    };
    or_fault(&AVERAGES, measured())
}

/// How long the integrator's own noise of the energy is remembered, in the scene's fastest times: three of them are enough in a liquid.
const MEMORY: f64 = 4.0;

/// Energies over a time, time units, looked at so many times. `fastest` is the scene's fastest time.
pub fn energies(
    study: &Study,
    point: &Point,
    time: f64,
    samples: u64,
    fastest: Option<f64>,
) -> Result<Vec<String>, Halt> {
    let measured = || {
        let own_shift = study.program.pair.shift;
        let (own, steps) = Series::measure(study, point, own_shift, time, samples)?;
        let jumps = point.potential == Potential::Own && study.jumps();
        let other = if jumps { Some(Series::measure(study, point, !own_shift, time, samples)?.0) } else { None };
        let (plain, continuous) = match &other {
            Some(other) if own_shift => (other, &own),
            Some(other) => (&own, other),
            None => (&own, &own),
        };
        let temp = own.of(3);
        let temperature = temp.iter().sum::<f64>() / temp.len().max(1) as f64;
        let (energies, bare) = (continuous.energies(), plain.energies());
        let (slope, slope_bare) = (drift::slope(&energies), drift::slope(&bare));
        let walked = fastest.and_then(|fastest| walk(&energies, MEMORY * fastest));
        let predicted = match (point.potential, point.integrator) {
            (Potential::Own, Integrator::Own) => Some(super::cutoff::walk_per_atom(study, point.dt, temperature)),
            _ => None,
        };
        let (potential, pressure) = (blocked(&own.of(2)), blocked(&own.of(4)));
        // A line does not know that it goes through a walk: what lies about it is far less than what the walk does to its slope.
        let clear = walked.filter(|(rate, error)| *rate > 2.0 * error).map_or(0.0, |(rate, _)| rate);
        let rate = predicted.unwrap_or(0.0).max(clear);
        let by_walk = slope_of_walk(rate, steps as f64 * point.dt);
        Ok(vec![
            number(steps as f64 * point.dt),
            steps.to_string(),
            energies.len().to_string(),
            maybe(slope_bare.map(|s| s.0)),
            maybe(slope_bare.map(|s| s.1.hypot(by_walk))),
            number(about_line(&bare)),
            maybe(slope.map(|s| s.0)),
            maybe(slope.map(|s| s.1.hypot(by_walk))),
            number(about_line(&energies)),
            maybe(walked.map(|w| w.0)),
            maybe(walked.map(|w| w.1)),
            maybe(predicted),
            number(temperature),
            maybe(potential.map(|p| p.0)),
            maybe(potential.map(|p| p.1)),
            maybe(pressure.map(|p| p.0)),
            maybe(pressure.map(|p| p.1)),
            String::new(),
        ])
    };
    or_fault(&ENERGIES, measured())
}

/// Steps between two looks at the list: no divisor of usual intervals between builds, so that all ages of a list are seen.
const STEPS_TO_LOOK: u64 = 7;

/// Looks at lists of all ages, each time at the pairs of at most so many atoms.
pub fn missing(study: &Study, point: &Point, looks: u64, atoms: usize) -> Result<Vec<String>, Halt> {
    let measured = || {
        let mut driven = study.begin(point)?;
        go(&mut driven, "run 0")?;
        let (mut pairs, mut lacks, mut worst, mut sampled) = (0, 0, 0, 0);
        for _ in 0..looks {
            go(&mut driven, &format!("run {STEPS_TO_LOOK} pre no"))?;
            let (state, space) = (driven.state(), driven.backend().simulation_box());
            let ids = exact::sample_of(state, atoms);
            // Distances that rounding to f32 decides are of no account.
            let band = 1e-6 * study.program.pair.largest_cutoff();
            let within = exact::look_up(&study.program.pair, 0.0, state, space, &ids, band);
            let listed = driven.backend().pairs_where(&|id| ids.binary_search(&id).is_ok())?;
            let mut listed: Vec<(u32, u32)> = listed.into_iter().map(|(i, j, _)| (i, j)).collect();
            listed.sort_unstable();
            let (missing, _) = exact::missing_and_extra(&ids, &within, &listed);
            pairs += within.iter().map(|atom| atom.neighbors.len()).sum::<usize>();
            (lacks, worst, sampled) = (lacks + missing, worst.max(missing), ids.len());
        }
        let counts = [looks as usize, sampled, pairs, lacks, worst];
        Ok(counts.iter().map(usize::to_string).chain([String::new()]).collect())
    };
    or_fault(&MISSING, measured())
}

/// Steps before a leg whose length is found out; a leg's least steps; builds that a leg should have, and how often it is gone over for
/// them.
const PILOT_STEPS: u64 = 10;
const LEAST_STEPS: u64 = 50;
const BUILDS: u64 = 3;
const MOST_LEGS: u64 = 5;

/// A timed leg.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    pub steps: u64,
    pub seconds: f64,
    pub builds: u64,
}

/// Times an engine that has not run yet, for about so many seconds.
pub fn leg(driven: &mut Driven<'_>, seconds: f64) -> Result<Leg, Halt> {
    go(driven, &format!("run {PILOT_STEPS}"))?;
    let rate = driven.summary().expect("a run leaves a summary").steps_per_second();
    let steps = ((rate * seconds) as u64).clamp(LEAST_STEPS, 1_000_000);
    let mut leg = Leg { steps: 0, seconds: 0.0, builds: 0 };
    let before = driven.backend().statistics().builds;
    for _ in 0..MOST_LEGS {
        go(driven, &format!("run {steps} pre no"))?;
        leg.steps += steps;
        leg.seconds += driven.summary().expect("a run leaves a summary").loop_seconds;
        leg.builds = driven.backend().statistics().builds - before;
        if leg.builds >= BUILDS {
            break;
        }
    }
    Ok(leg)
}

pub fn speed(study: &Study, point: &Point, seconds: f64) -> Result<Vec<String>, Halt> {
    let measured = || {
        let leg = leg(&mut study.begin(point)?, seconds)?;
        let each = leg.seconds / (leg.steps as f64 * point.dt);
        Ok(vec![leg.steps.to_string(), number(leg.seconds), number(each), leg.builds.to_string(), String::new()])
    };
    or_fault(&SPEEDS, measured())
}
