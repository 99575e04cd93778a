//! What the page says: every number of it was measured and stands in a CSV file.

use super::Options;
use super::charts;
use super::front::{self, Found, SAFE};
use super::measure::{ENERGIES, FORCES, MISSING, TRAJECTORIES};
use super::page::Block;
use super::plan::Plan;
use super::point::{self, is_safe};
use super::price::{OFF_AGAIN, PRICES};
use super::statistics::order;
use super::store::{Record, Store};
use super::study::Study;
use super::{cutoff, lammps};
use crate::bench::Spread;
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
fn with_error(value: Option<f64>, error: Option<f64>) -> String {
    match (value, error) {
        (Some(value), Some(error)) => format!("{} ± {}", short(value), format_g(error, 0, 2, false)),
        (Some(value), None) => short(value),
        _ => String::new(),
    }
}

fn maybe(x: Option<f64>) -> String {
    x.map_or(String::new(), short)
}

fn table(heads: &[&str], rows: Vec<Vec<String>>) -> Block {
    Block::Table(heads.iter().map(|head| head.to_string()).collect(), rows)
}

impl Facts<'_> {
    /// The point that the script itself names, in the usual precision.
    fn own<'a>(&self, points: &'a [Found]) -> Option<&'a Found> {
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
        let settings = |p: &Found| {
            let policy = if p.rebuild == own.rebuild { String::new() } else { format!(", neigh_modify {}", p.rebuild) };
            format!("dt {}, {}, skin {}{policy}", p.dt, p.precision, p.skin)
        };
        let lacking = own.missing.filter(|missing| *missing > 0.0);
        match (front::better(points, own), lacking) {
            (Some(best), None) => format!(
                "{}: same error, {:.1} times faster than the script's settings ({}).",
                settings(best),
                own.time.median / best.time.median,
                settings(own)
            ),
            (Some(best), Some(missing)) => format!(
                "{}: no more error, no pair missing, {:.1} times faster than the script's settings ({}), whose lists lack {} of \
                 the pairs within the cutoff.",
                settings(best),
                own.time.median / best.time.median,
                settings(own),
                short(missing)
            ),
            (None, Some(missing)) => format!(
                "Take neigh_modify {SAFE}: the lists of the script's settings ({}) lack {} of the pairs within the cutoff; \
                 nothing measured that lacks none is faster by a twentieth at the same error.",
                settings(own),
                short(missing)
            ),
            (None, None) => format!(
                "Stay with the script's settings ({}): nothing measured is faster by a twentieth at the same error.",
                settings(own)
            ),
        }
    }

    pub fn blocks(&self, points: &[Found]) -> Result<Vec<Block>, String> {
        let mut blocks = vec![
            Block::Title(format!("Error against run time: {}", self.options.script.display())),
            Block::Advice(self.advice(points)),
        ];
        if self.interrupted {
            blocks.push(Block::Text("The study was interrupted: this is what is there so far. The same command goes on.".into()));
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
            ("scene", format!("{}: what the script leaves at its end, {} atoms", self.options.script.display(), study.atoms())),
            ("potential", format!("{}, largest cutoff {}", program.pair.style, program.pair.largest_cutoff())),
            ("script's settings", format!("dt {}, skin {}, {}", program.timestep, program.policy.skin, point::rebuild(&program.policy))),
            ("units", program.units.name.into()),
            ("temperature", short(study.temperature)),
            ("engine", [&machine.backend, &machine.device, &machine.driver].map(String::as_str).join(" ").trim().into()),
            ("octant", format!("{}, {}", env!("CARGO_PKG_VERSION"), today())),
            ("extent", if self.options.quick { "quick: few points, short runs".into() } else { "full".to_string() }),
        ];
        if let Some(fastest) = plan.fastest {
            rows.push(("fastest time", format!("{}: 1 / w, w^2 = <F^2 / m> / (3 k T)", short(fastest))));
        }
        let lammps = if self.no_lammps.is_empty() {
            "measured on the same scene, on the CPU".into()
        } else {
            format!("not measured: {}", self.no_lammps)
        };
        rows.push(("LAMMPS", lammps));
        blocks.push(table(&["", ""], rows.into_iter().map(|(name, value)| vec![name.into(), value]).collect()));
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
             in both are ringed and joined; those whose lists lack pairs are on no front.",
            plan.scale.rounds,
            short(plan.span.reference_dt),
            short(plan.span.time)
        )));
        charts::work(self, points, blocks)?;
        let mut front: Vec<&Found> = points.iter().filter(|p| p.front).collect();
        front.sort_unstable_by(|a, b| (&a.potential, &a.integrator).cmp(&(&b.potential, &b.integrator))
            .reverse().then(a.time.median.total_cmp(&b.time.median)));
        let own = self.own(points).filter(|own| !own.front);
        let row = |p: &Found| {
            let time = format!("{} ({} to {})", short(p.time.median), short(p.time.least), short(p.time.most));
            let integrator = if p.integrator == "own" { "script's" } else { &p.integrator };
            let potential = if p.potential == "own" { "script's" } else { &p.potential };
            vec![
                potential.into(), integrator.into(), p.precision.clone(), p.dt.to_string(), p.skin.to_string(), p.rebuild.clone(), time,
                maybe(p.trajectory), maybe(p.fluctuation), with_error(p.drift.map(|d| d.0), p.drift.map(|d| d.1)), maybe(p.force),
                maybe(p.missing), if p.front { "front".into() } else { "script's settings".into() },
            ]
        };
        let heads = ["potential", "integrator", "precision", "dt", "skin", "neigh_modify", "s per time unit", "trajectory error",
            "energy fluctuation", "energy drift", "force error", "pairs missing", ""];
        blocks.push(table(&heads, own.into_iter().chain(front).map(row).collect()));
        let faults: Vec<Vec<String>> = points.iter().filter(|p| !p.fault.is_empty()).map(|p| {
            vec![p.potential.clone(), p.integrator.clone(), p.precision.clone(), p.dt.to_string(), p.rebuild.clone(), p.fault.clone()]
        }).collect();
        if !faults.is_empty() {
            blocks.push(Block::Text("Settings that broke the scene:".into()));
            blocks.push(table(&["potential", "integrator", "precision", "dt", "neigh_modify", "what happened"], faults));
        }
        blocks.push(Block::Text(
            "Force errors are against sums over all pairs in double precision on the melted positions, relative to the RMS force:".into(),
        ));
        let forces = self.store.rows(&FORCES).map(|row| {
            let cells = ["potential", "precision"].map(|column| row.text(column).to_string());
            let numbers = ["force_error_rms", "force_error_worst"].map(|column| maybe(row.number(column)));
            cells.into_iter().chain(numbers).chain([row.text("atoms").to_string()]).collect()
        });
        let lammps = self.store.rows(&lammps::LAMMPS).next().map(|row| {
            let numbers = ["force_error_rms", "force_error_worst"].map(|column| maybe(row.number(column)));
            ["own".into(), "LAMMPS".to_string()].into_iter().chain(numbers).chain([String::new()]).collect()
        });
        blocks.push(table(&["potential", "precision", "RMS", "worst atom", "atoms compared"], forces.chain(lammps).collect()));
        Ok(())
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
                rows.push(vec![name.into(), with_error(Some(slope), Some(error)), points.len().to_string(), range, expected.into()]);
            }
        }
        blocks.push(table(&["", "fitted order", "steps fitted", "dt", "expected"], rows));
        blocks.push(Block::Text(
            "The order is the slope of the logarithm of the trajectory error over that of dt, fitted to time steps up to the script's, in the \
             most exact precision measured. The reference's own error, at an eighth of the smallest step, makes it larger by up to 0.01. \
             Where a potential is cut off plainly, every pair that crosses the cutoff in a step is kicked with the whole force too early or too \
             late: errors of that kind are of first order and have random signs, so small steps lose the second order.".into(),
        ));
        charts::order(self, blocks)
    }

    /// Time steps up to the script's, and trajectory errors, in the most exact precision measured of them.
    pub fn convergence(&self, potential: &str, integrator: &str) -> Vec<(f64, f64)> {
        let rows: Vec<Record<'_>> = self.trajectories(potential, integrator);
        let precision = ["double", "mixed", "single"].into_iter().find(|name| rows.iter().any(|row| row.text("precision") == *name));
        let most = self.study.program.timestep * 1.001;
        let points = rows.iter().filter(|row| Some(row.text("precision")) == precision);
        let mut points: Vec<(f64, f64)> =
            points.filter_map(|row| row.number("dt_used").zip(row.number("rms_error"))).filter(|p| p.0 <= most).collect();
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

    fn energy(&self, blocks: &mut Vec<Block>) -> Result<(), String> {
        blocks.push(Block::Heading("Energy: integrator and truncation apart".into()));
        let atoms = self.study.atoms() as f64;
        if self.study.jumps() {
            let pairs: f64 = cutoff::pairs(self.study).iter().sum();
            let (rc, volume) = (self.study.program.pair.largest_cutoff(), self.study.space.volume());
            let g = pairs / (0.5 * atoms * 4.0 * std::f64::consts::PI * rc * rc * atoms / volume);
            blocks.push(Block::Text(format!(
                "The potential jumps at the cutoff, so E counts every pair that comes and goes: the noise of \"E plain\" is not the integrator's. \
                 E - N_pairs U(rc) (the energy of pair_modify shift yes, which has the same forces and so the same trajectory) is continuous. \
                 What is left of the cutoff in it is the step of the force. Velocity Verlet does the work of a pair over a step with the mean of \
                 the forces at its ends; a pair that crosses rc at radial velocity u is off by F(rc) (u dt / 2 - s), s being uniform between 0 \
                 and u dt, so its variance is (F(rc) u dt)^2 / 12. With n pairs a length at rc, n <|u|> cross a time unit, and the energy walks \
                 at random: its variance grows by D = n F(rc)^2 dt^2 / 12 <|u|^3> a time unit, <|u|^3> = 2 (2 / pi)^(1/2) (k T / mu)^(3/2), mu \
                 the reduced mass, summed over pairs of types. Here n = {}{}.",
                short(pairs),
                if self.study.program.pair.types == 1 { format!(", g(rc) = {}", short(g)) } else { String::new() }
            )));
        }
        let rows = self.store.rows(&ENERGIES).filter(|row| row.text("fault").is_empty()).map(|row| {
            let number = |column: &str| row.number(column);
            let pair = |value: &str, error: &str| with_error(number(value), number(error));
            let text = |column: &str| row.text(column).to_string();
            let walked = number("walk").map(|d| d * atoms * atoms);
            let walked_error = number("walk_error").map(|d| d * atoms * atoms);
            let rms = number("walk_predicted").zip(number("time")).map(|(d, t)| (d * t).sqrt());
            vec![
                text("potential"), text("integrator"), text("precision"), text("dt"), text("rebuild"),
                pair("drift_plain", "drift_plain_error"), maybe(number("fluctuation_plain")), pair("drift", "drift_error"),
                maybe(number("fluctuation")), with_error(walked, walked_error), maybe(number("walk_predicted").map(|d| d * atoms * atoms)),
                maybe(rms),
            ]
        });
        let heads = ["potential", "integrator", "precision", "dt", "neigh_modify", "E plain: drift", "fluctuation", "E continuous: drift",
            "fluctuation", "D measured", "D predicted", "RMS walk in this run, per atom"];
        blocks.push(table(&heads, rows.collect()));
        blocks.push(Block::Text(format!(
            "Drifts are per atom and time unit, slopes of straight lines over a time of {} with standard errors that know of correlation; \
             fluctuations are per atom, RMS about that line. D is of the whole scene, energy units squared a time unit; measured, it is how \
             fast the variance of two energies grows with the time between them. A walk makes a drift too: of the order of its RMS over the \
             length of the run.",
            short(self.plan.energy_time())
        )));
        charts::energy(self, blocks)
    }

    fn lists(&self, points: &[Found], blocks: &mut Vec<Block>) -> Result<(), String> {
        blocks.push(Block::Heading("Skin and rebuild policy".into()));
        blocks.push(Block::Text(format!(
            "At {} moments, 7 steps apart, the list in use was compared with all pairs within the cutoff of up to {} atoms. With {SAFE} \
             no pair can be missing.",
            self.plan.scale.looks, self.plan.scale.look_atoms
        )));
        let rows = self.store.rows(&MISSING).map(|row| {
            let part = row.number("missing").zip(row.number("pairs")).map(|(m, all)| m / all.max(1.0));
            let text = |column: &str| row.text(column).to_string();
            vec![text("rebuild"), text("skin"), text("dt"), text("pairs"), text("missing"), maybe(part), text("missing_worst_look"), text("fault")]
        });
        let heads = ["neigh_modify", "skin", "dt", "pairs looked at", "missing", "part", "missing in the worst look", "fault"];
        blocks.push(table(&heads, rows.collect()));
        charts::skins(self, points, blocks)
    }

    fn averages(&self, blocks: &mut Vec<Block>) {
        blocks.push(Block::Heading("Averages".into()));
        blocks.push(Block::Text(
            "Potential energy per atom and pressure of the same runs, with error bars by blocking (Flyvbjerg and Petersen 1989). Runs begin at \
             the same melted state and keep its energy.".into(),
        ));
        let reference = |name: &str| self.options.reference.iter().find(|(of, _)| of == name).map(|(_, value)| *value);
        let off = |row: &Record<'_>, value: &str, error: &str, name: &str| {
            let (value, error) = (row.number(value)?, row.number(error)?);
            Some(format!("{} error bars", format_g((value - reference(name)?) / error, 0, 3, false)))
        };
        let rows = self.store.rows(&ENERGIES).filter(|row| row.text("fault").is_empty()).map(|row| {
            let text = |column: &str| row.text(column).to_string();
            let mut cells = vec![
                text("potential"), text("integrator"), text("precision"), text("dt"), text("rebuild"), maybe(row.number("temperature")),
                with_error(row.number("potential_energy"), row.number("potential_energy_error")),
                with_error(row.number("pressure"), row.number("pressure_error")),
            ];
            if reference("U").is_some() {
                cells.push(off(&row, "potential_energy", "potential_energy_error", "U").unwrap_or_default());
            }
            if reference("P").is_some() {
                cells.push(off(&row, "pressure", "pressure_error", "P").unwrap_or_default());
            }
            cells
        });
        let rows: Vec<Vec<String>> = rows.collect();
        let mut heads: Vec<String> =
            ["potential", "integrator", "precision", "dt", "neigh_modify", "T", "U per atom", "P"].map(String::from).to_vec();
        heads.extend(reference("U").map(|u| format!("U from {}", short(u))));
        heads.extend(reference("P").map(|p| format!("P from {}", short(p))));
        blocks.push(Block::Table(heads, rows));
    }

    fn prices(&self, blocks: &mut Vec<Block>) {
        let mut names: Vec<(&str, &str)> = Vec::new();
        for row in self.store.rows(&PRICES) {
            if !names.iter().any(|(name, _)| *name == row.text("option")) {
                names.push((row.text("option"), row.text("compared_with")));
            }
        }
        if names.is_empty() {
            return;
        }
        let of = |name: &str, round: &str| {
            let mut rows = self.store.rows(&PRICES);
            rows.find(|row| row.text("option") == name && row.text("round") == round)
                .and_then(|row| row.number("microseconds_per_step"))
        };
        let rounds: Vec<String> = (1..=self.plan.scale.price_rounds).map(|round| round.to_string()).collect();
        let spread = |values: Vec<f64>| (!values.is_empty()).then(|| Spread::of(&values));
        let words = |s: Option<Spread>| {
            s.map_or("-".into(), |s| format!("{} ({} to {})", short(s.median), short(s.least), short(s.most)))
        };
        let rows = names.iter().map(|(name, base)| {
            let times = spread(rounds.iter().filter_map(|round| of(name, round)).collect());
            let ratios = rounds.iter().filter_map(|round| Some(of(name, round)? / of(base, round)?)).collect();
            let ratio = if name == base { "1".to_string() } else { words(spread(ratios)) };
            vec![name.to_string(), words(times), ratio, base.to_string()]
        });
        blocks.push(Block::Heading("What each option costs".into()));
        blocks.push(table(&["option", "microseconds a step", "ratio", "compared with"], rows.collect()));
        let off = self.store.rows(&PRICES).filter(|row| row.text("option") == OFF_AGAIN && !row.text("same_program").is_empty());
        let (same, all) = off.fold((0, 0), |(same, all), row| (same + usize::from(row.text("same_program") == "yes"), all + 1));
        blocks.push(Block::Text(format!(
            "Ratios are of legs of the same round; median, least and most of {} rounds, in {} precision, with the script's dt and skin and {SAFE}. \
             What is off costs nothing: in {same} of {all} rounds, after all these were switched on and off again, the step as data and what the \
             engine says of its kernels (run --explain) were the same as if they had never been on.",
            self.plan.scale.price_rounds,
            self.plan.usual.name()
        )));
    }
}
