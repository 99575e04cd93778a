//! What the page says of the scene, of work and precision, and of the order: every number was measured and stands in a CSV file.

use super::Options;
use super::broken;
use super::charts;
use super::cutoff;
use super::front::{self, Found, Lists, SAFE};
use super::lammps;
use super::measure::{FORCES, TRAJECTORIES};
use super::page::Block;
use super::plan::Plan;
use super::point::{self, is_safe};
use super::statistics::order;
use super::store::{Record, Store};
use super::study::Study;
use crate::engine::Precision;
use crate::output::calendar::today;
use crate::output::printf::format_g;

/// All that a page is made of.
pub struct Facts<'a> {
    pub study: &'a Study,
    pub plan: &'a Plan,
    pub store: &'a Store,
    pub options: &'a Options,
    /// Why LAMMPS was not asked; empty where it was.
    pub no_lammps: &'a str,
    pub interrupted: bool,
}

/// Four digits, for people.
pub fn short(x: f64) -> String {
    format_g(x, 0, 4, false)
}

/// A number and its standard error.
pub fn with_error(value: Option<f64>, error: Option<f64>) -> String {
    match (value, error) {
        (Some(value), Some(error)) => format!("{} ± {}", short(value), format_g(error, 0, 2, false)),
        (Some(value), None) => short(value),
        _ => String::new(),
    }
}

pub fn maybe(x: Option<f64>) -> String {
    x.map_or(String::new(), short)
}

/// What people call a potential or an integrator of the tables.
pub fn named(name: &str) -> String {
    if name == "own" { "script's".into() } else { name.into() }
}

pub fn table(heads: &[&str], rows: Vec<Vec<String>>) -> Block {
    Block::Table(heads.iter().map(|head| head.to_string()).collect(), rows)
}

impl Facts<'_> {
    /// What averages are compared with: as the command line has it, or the script.
    pub fn reference(&self, name: &str) -> Option<f64> {
        let given = self.options.reference.iter().find(|(of, _)| of == name).map(|(_, value)| *value);
        given.or_else(|| self.study.reference.iter().find(|(of, _)| *of == name).map(|(_, value)| *value))
    }

    /// A drift that spoils a run of a thousand of the fastest times, energy units a time unit: a hundredth of k T.
    fn drift_limit(&self) -> Option<f64> {
        let energy = 0.01 * self.study.program.units.boltzmann * self.study.temperature;
        self.plan.fastest.map(|fastest| energy / (1000.0 * fastest)).filter(|limit| *limit > 0.0)
    }

    /// Whether a point's energy drifts more than that, beyond the error of the drift.
    pub fn drifts(&self, point: &Found) -> bool {
        self.drift_limit().is_some_and(|limit| point.drifts(limit))
    }

    /// The point that the script itself names, in the usual precision.
    pub fn own<'a>(&self, points: &'a [Found]) -> Option<&'a Found> {
        let program = &self.study.program;
        let rebuild = if is_safe(&program.policy) { SAFE.into() } else { point::rebuild(&program.policy) };
        points.iter().find(|p| {
            let names = (p.potential.as_str(), p.integrator.as_str(), p.precision.as_str());
            names == ("own", "own", self.plan.usual.name())
                && (p.dt, p.skin) == (program.timestep, program.policy.skin)
                && p.rebuild == rebuild
        })
    }

    /// One plain sentence.
    pub fn advice(&self, points: &[Found]) -> String {
        let Some(own) = self.own(points).filter(|own| own.time.median > 0.0) else {
            return "The script's own settings have not been measured yet, so there is nothing to advise.".into();
        };
        let usual = self.plan.usual.name();
        if !own.fault.is_empty() {
            return format!("The script's own settings do not hold in {usual} precision: {}.", own.fault);
        }
        let settings = |p: &Found| format!("dt {}, {}, skin {}, neigh_modify {}", p.dt, p.precision, p.skin, p.rebuild);
        let own_settings = settings(own);
        let times = |x: f64| format_g(x, 0, 2, false);
        if own.lists() == Lists::Whole {
            return match front::better(points, own) {
                Some(best) => format!(
                    "{}: same error, {} times faster than the script's settings ({own_settings}).",
                    settings(best),
                    times(best.faster(own).map_or(1.0, |f| f.0)),
                ),
                None => format!(
                    "Stay with the script's settings ({own_settings}): no setting is measurably faster at the same error."
                ),
            };
        }
        let missed = match own.lists() {
            Lists::Lack(part) => format!("instead of {} of those within the cutoff", short(part)),
            Lists::Unsure(most) => {
                format!("for certain, where it is only known that it is fewer than {} of them", short(most))
            }
            Lists::Whole => String::new(),
        };
        let Some(best) = front::fastest(points, own) else {
            return format!(
                "Take neigh_modify {SAFE}: 0 pairs missed {missed} by the script's settings ({own_settings}); nothing was measured that \
                 has its other errors."
            );
        };
        let cost = match (best.faster(own), own.faster(best)) {
            (Some((ratio, true)), _) => format!("{} times faster than", times(ratio)),
            (_, Some((ratio, true))) => format!("{} times slower than", times(ratio)),
            _ => "within the noise as fast as".into(),
        };
        format!("Take {}: 0 pairs missed {missed}, {cost} the script's settings ({own_settings}).", settings(best))
    }

    pub fn blocks(&self, points: &[Found]) -> Result<Vec<Block>, String> {
        let mut blocks = vec![
            Block::Title(format!("Error against run time: {}", self.options.script.display())),
            Block::Advice(self.advice(points)),
        ];
        if self.interrupted {
            blocks.push(Block::Text(
                "The study was interrupted: this is what is there so far. The same command goes on.".into(),
            ));
        }
        self.scene(&mut blocks);
        self.precision(points, &mut blocks)?;
        self.order(&mut blocks)?;
        self.energy(&mut blocks)?;
        self.lists(points, &mut blocks)?;
        self.averages(&mut blocks);
        self.prices(&mut blocks);
        Ok(blocks)
    }

    fn scene(&self, blocks: &mut Vec<Block>) {
        let (study, plan) = (self.study, self.plan);
        let program = &study.program;
        let machine = &study.machine;
        let mut rows = vec![
            (
                "scene",
                format!(
                    "{}: what the script leaves at its end, {} atoms",
                    self.options.script.display(),
                    study.atoms()
                ),
            ),
            ("potential", format!("{}, largest cutoff {}", program.pair.style, program.pair.largest_cutoff())),
            (
                "script's settings",
                format!("dt {}, skin {}, {}", program.timestep, program.policy.skin, point::rebuild(&program.policy)),
            ),
            ("units", program.units.name.into()),
            ("temperature", short(study.temperature)),
            (
                "engine",
                [&machine.backend, &machine.device, &machine.driver].map(String::as_str).join(" ").trim().into(),
            ),
            ("octant", format!("{}, {}", env!("CARGO_PKG_VERSION"), today())),
            ("extent", if self.options.quick { "quick: few points, short runs".into() } else { "full".to_string() }),
        ];
        if let Some(fastest) = plan.fastest {
            rows.push(("fastest time", format!("{}: {}", short(fastest), plan.pace)));
        }
        let mut how: Vec<&str> =
            lammps::rows(self.store).map(|row| row.text("how")).filter(|how| !how.is_empty()).collect();
        how.sort_unstable();
        how.dedup();
        let version = lammps::rows(self.store).next().map_or("", |row| row.text("version"));
        let lammps = match self.no_lammps {
            "" => format!("{version}, on the same scene, on the CPU, with what is fastest there: {}", how.join("; ")),
            why if version.is_empty() => format!("not measured: {why}"),
            why => format!("{version}, as measured before; not asked again: {why}"),
        };
        rows.push(("LAMMPS", lammps));
        blocks.push(table(&["", ""], rows.into_iter().map(|(name, value)| vec![name.into(), value]).collect()));
        blocks.extend(study.prepared.clone().map(Block::Text));
        if !study.thermostats.is_empty() {
            let styles = study.thermostats.join(", ");
            blocks.push(Block::Text(format!(
                "The script holds the temperature by {styles}. A thermostat hides what an integrator loses, so the scene was studied \
                 without it, atoms being moved by fix nve."
            )));
        }
    }

    fn precision(&self, points: &[Found], blocks: &mut Vec<Block>) -> Result<(), String> {
        let plan = self.plan;
        blocks.push(Block::Heading("Work and precision".into()));
        blocks.push(Block::Text(format!(
            "Every point is a way to run the scene. Its time is the median of {} rounds, list builds included. Its error is the RMS distance \
             of all atoms from a reference trajectory in double precision with dt {}, after a time of {}. Points that no other beats \
             in both are ringed and joined, the script's own settings are framed; those whose lists lack pairs, or may, are on no front.",
            plan.scale.rounds,
            short(plan.span.reference_dt),
            short(plan.span.time)
        )));
        charts::work(self, points, blocks)?;
        let mut front: Vec<&Found> = points.iter().filter(|p| p.front).collect();
        front.sort_unstable_by(|a, b| {
            (&a.potential, &a.integrator)
                .cmp(&(&b.potential, &b.integrator))
                .reverse()
                .then(a.time.median.total_cmp(&b.time.median))
        });
        let own = self.own(points).filter(|own| !own.front);
        let row = |p: &Found| {
            let time = format!("{} ({} to {})", short(p.time.median), short(p.time.least), short(p.time.most));
            vec![
                named(&p.potential),
                named(&p.integrator),
                p.precision.clone(),
                p.dt.to_string(),
                p.skin.to_string(),
                p.rebuild.clone(),
                time,
                maybe(p.trajectory),
                maybe(p.fluctuation),
                with_error(p.drift.map(|d| d.0), p.drift.map(|d| d.1)),
                maybe(p.force),
                maybe(p.missing),
                match (p.front, self.drifts(p)) {
                    (true, true) => "front, but drifts".into(),
                    (true, false) => "front".into(),
                    _ => "script's settings".into(),
                },
            ]
        };
        let heads = [
            "potential",
            "integrator",
            "precision",
            "dt",
            "skin",
            "neigh_modify",
            "s per time unit",
            "trajectory error",
            "energy fluctuation",
            "energy drift",
            "force error",
            "pairs missing",
            "",
        ];
        blocks.push(table(&heads, own.into_iter().chain(front).map(row).collect()));
        if points.iter().any(|p| p.front && self.drifts(p)) {
            blocks.push(Block::Text(format!(
                "A short trajectory does not show what an energy does in the long run: ringed points that are crossed out drift by more than \
                 {} a time unit and atom, a hundredth of k T in a thousand of the scene's fastest times.",
                short(self.drift_limit().unwrap_or(0.0))
            )));
        }
        let faults = broken::rows(points);
        if !faults.is_empty() {
            blocks.push(Block::Text(
                "Settings that broke the scene (skins and precisions of one row were measured each):".into(),
            ));
            blocks.push(table(&broken::HEADS, faults));
        }
        blocks.push(Block::Text(
            "Force errors are against sums over all pairs in double precision on the melted positions, relative to the RMS force:".into(),
        ));
        let forces = self.store.rows(&FORCES).map(|row| {
            let cells = ["potential", "precision"].map(|column| named(row.text(column)));
            let numbers = ["force_error_rms", "force_error_worst"].map(|column| maybe(row.number(column)));
            cells.into_iter().chain(numbers).chain([row.text("atoms").to_string()]).collect()
        });
        let lammps = lammps::rows(self.store).next().map(|row| {
            let numbers = ["force_error_rms", "force_error_worst"].map(|column| maybe(row.number(column)));
            [named("own"), "LAMMPS".to_string()].into_iter().chain(numbers).chain([String::new()]).collect()
        });
        blocks.push(table(
            &["potential", "precision", "RMS", "worst atom", "atoms compared"],
            forces.chain(lammps).collect(),
        ));
        blocks.extend(self.at_the_cutoff().map(Block::Text));
        Ok(())
    }

    /// Which force errors of the script's potential in f32 are those of pairs on the wrong side of the cutoff.
    fn at_the_cutoff(&self) -> Option<String> {
        let in_f32 =
            |row: &Record<'_>| row.text("potential") == "own" && row.text("precision") != Precision::Double.name();
        let rows: Vec<_> = self.store.rows(&FORCES).filter(in_f32).collect();
        let worst: Vec<_> =
            rows.iter().filter_map(|row| Some((row.text("precision"), row.number("force_error_worst")?))).collect();
        let rms_force = rows.first()?.number("rms_force")?;
        cutoff::of_force_errors(&self.study.program.pair, &worst, rms_force, self.study.atoms())
    }

    /// Fitted orders of convergence.
    fn order(&self, blocks: &mut Vec<Block>) -> Result<(), String> {
        blocks.push(Block::Heading("Order of the integrator".into()));
        let mut rows = Vec::new();
        for (name, potential, integrator, expected) in [
            ("script's potential and fixes", "own", "own", "2 where the force has no step at the cutoff"),
            ("force-shifted (lj/smooth/linear)", "force-shifted", "own", "2"),
            ("script's potential, nve/euler2", "own", "nve/euler2", "1: its velocities are of first order"),
        ] {
            let points = self.convergence(potential, integrator);
            if let Some((slope, error)) = order(&points) {
                let range = format!("{} to {}", short(points[0].0), short(points[points.len() - 1].0));
                rows.push(vec![
                    name.into(),
                    with_error(Some(slope), Some(error).filter(|_| points.len() > 2)),
                    points.len().to_string(),
                    range,
                    expected.into(),
                ]);
            }
        }
        blocks.push(table(&["", "fitted order", "steps fitted", "dt", "expected"], rows));
        blocks.push(Block::Text(
            "The order is the slope of the logarithm of the trajectory error over that of dt, fitted to time steps up to the script's, in the \
             most exact precision measured. The reference's own error, at an eighth of the smallest step, makes it larger by up to 0.02. \
             Where a potential is cut off plainly, every pair that crosses the cutoff in a step is kicked with the whole force too early or too \
             late: errors of that kind are of first order and have random signs; they are small, and show at small steps first.".into(),
        ));
        blocks.extend(self.truncation().map(Block::Text));
        charts::order(self, blocks)
    }

    /// What plain truncation makes of the order, as measured at the two smallest steps.
    fn truncation(&self) -> Option<String> {
        let (plain, shifted) = (self.convergence("own", "own"), self.convergence("force-shifted", "own"));
        let ([a, b, ..], [c, d, ..]) = (&plain[..], &shifted[..]) else { return None };
        let slope = |a: (f64, f64), b: (f64, f64)| order(&[a, b]).map(|(slope, _)| slope);
        let (own, other) = slope(*a, *b).zip(slope(*c, *d)).filter(|_| (a.0, b.0) == (c.0, d.0))?;
        Some(format!(
            "Measured: between the two smallest steps, dt {} and {}, the order is {} as the script cuts off and {} force-shifted; at the \
             smaller one the error is {} times that of the force-shifted potential.",
            short(a.0),
            short(b.0),
            format_g(own, 0, 3, false),
            format_g(other, 0, 3, false),
            format_g(a.1 / c.1, 0, 3, false)
        ))
    }

    /// Time steps up to the script's, and trajectory errors, in the most exact precision measured of them.
    pub fn convergence(&self, potential: &str, integrator: &str) -> Vec<(f64, f64)> {
        let rows: Vec<Record<'_>> = self.trajectories(potential, integrator);
        let precision = ["double", "mixed", "single"]
            .into_iter()
            .find(|name| rows.iter().any(|row| row.text("precision") == *name));
        let most = self.study.program.timestep * 1.001;
        let points = rows.iter().filter(|row| Some(row.text("precision")) == precision);
        let mut points: Vec<(f64, f64)> = points
            .filter_map(|row| row.number("dt_used").zip(row.number("rms_error")))
            .filter(|p| p.0 <= most)
            .collect();
        points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        points
    }

    /// Rows whose lists lack no pair.
    pub fn trajectories(&self, potential: &str, integrator: &str) -> Vec<Record<'_>> {
        let is = |row: &Record<'_>| {
            row.text("potential") == potential && row.text("integrator") == integrator && row.text("rebuild") == SAFE
        };
        self.store.rows(&TRAJECTORIES).filter(is).collect()
    }
}
