//! What the page says of energies, lists, averages and prices.

use super::charts;
use super::content::{Facts, maybe, named, short, table, with_error};
use super::cutoff;
use super::front::{self, Found, SAFE};
use super::measure::{AVERAGES, ENERGIES, MISSING};
use super::page::Block;
use super::price::{OFF_AGAIN, PRICES};
use super::store::Record;
use crate::bench::Spread;
use crate::output::printf::format_g;

impl Facts<'_> {
    pub fn energy(&self, blocks: &mut Vec<Block>) -> Result<(), String> {
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
        if let Some((measured, error, predicted)) = self.walk() {
            blocks.push(Block::Text(format!(
                "Over all time steps, the most exact precision: D / dt^2 is {} measured (weighted by the errors), {} predicted.",
                with_error(Some(measured), Some(error)),
                short(predicted)
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
                named(row.text("potential")),
                named(row.text("integrator")),
                text("precision"),
                text("dt"),
                text("skin"),
                text("rebuild"),
                pair("drift_plain", "drift_plain_error"),
                maybe(number("fluctuation_plain")),
                pair("drift", "drift_error"),
                maybe(number("fluctuation")),
                with_error(walked, walked_error),
                maybe(number("walk_predicted").map(|d| d * atoms * atoms)),
                maybe(rms),
            ]
        });
        let heads = [
            "potential",
            "integrator",
            "precision",
            "dt",
            "skin",
            "neigh_modify",
            "E plain: drift",
            "fluctuation",
            "E continuous: drift",
            "fluctuation",
            "D measured",
            "D predicted",
            "RMS walk in this run, per atom",
        ];
        blocks.push(table(&heads, rows.collect()));
        blocks.push(Block::Text(format!(
            "Drifts are per atom and time unit, slopes of straight lines over a time of {} with standard errors that know of correlation; \
             fluctuations are per atom, RMS about that line. D is of the whole scene, energy units squared a time unit; measured, it is how \
             fast the variance of two energies grows from times between them of a fortieth of the run to those of an eighth, where the \
             integrator's own noise is forgotten within the shorter one (in quick studies it is not). A walk makes a drift too, which the scatter \
             about a line does not tell: the slope of a walk scatters by (6 D / 5 T)^(1/2) in a run of length T, which is part of the stated error \
             (D predicted, or measured where that is clearly more). Drifts of two runs differ by less than their errors unless something else drives them.",
            short(self.plan.energy_time())
        )));
        charts::energy(self, blocks)
    }

    /// D / dt^2 of the whole scene over all time steps: measured, its standard error, predicted.
    fn walk(&self) -> Option<(f64, f64, f64)> {
        let is = |row: &Record<'_>| ["potential", "integrator"].iter().all(|column| row.text(column) == "own");
        let rows: Vec<Record<'_>> =
            self.store.rows(&ENERGIES).filter(|row| is(row) && row.text("rebuild") == SAFE).collect();
        let precision =
            ["double", "mixed", "single"].into_iter().find(|p| rows.iter().any(|row| row.text("precision") == *p))?;
        let squared = (self.study.atoms() as f64).powi(2);
        let of = rows.iter().filter(|row| row.text("precision") == precision).filter_map(|row| {
            let scale = squared / row.number("dt")?.powi(2);
            let [walk, error, predicted] = ["walk", "walk_error", "walk_predicted"].map(|column| row.number(column));
            Some((walk? * scale, error? * scale, predicted? * scale))
        });
        let of: Vec<(f64, f64, f64)> = of.filter(|(_, error, predicted)| *error > 0.0 && *predicted > 0.0).collect();
        let weight: f64 = of.iter().map(|w| w.1.powi(-2)).sum();
        let mean =
            |value: &dyn Fn(&(f64, f64, f64)) -> f64| of.iter().map(|w| value(w) * w.1.powi(-2)).sum::<f64>() / weight;
        (!of.is_empty()).then(|| (mean(&|w| w.0), weight.powf(-0.5), mean(&|w| w.2)))
    }

    pub fn lists(&self, points: &[Found], blocks: &mut Vec<Block>) -> Result<(), String> {
        blocks.push(Block::Heading("Skin and rebuild policy".into()));
        blocks.push(Block::Text(format!(
            "At {} moments, 7 steps apart, the list in use was compared with all pairs within the cutoff of up to {} atoms. With {SAFE} \
             no pair can be missing. Where none was seen to be, \"at most\" is the part that 95 % confidence leaves (three over the pairs looked \
             at): policies that check nothing count as whole from 1e-6 on.",
            self.plan.scale.looks, self.plan.scale.look_atoms
        )));
        let usual = self.plan.usual.name();
        let rows = self.store.rows(&MISSING).map(|row| {
            let of = points.iter().find(|p| p.precision == usual && p.is_of(&row, false));
            let (part, most) = front::missing(&row);
            let text = |column: &str| row.text(column).to_string();
            vec![
                text("rebuild"),
                text("skin"),
                text("dt"),
                text("pairs"),
                text("missing"),
                maybe(part),
                maybe(most),
                text("missing_worst_look"),
                maybe(of.map(|p| p.time.median).filter(|time| *time > 0.0)),
                maybe(of.and_then(|p| p.trajectory)),
                text("fault"),
            ]
        });
        let heads = [
            "neigh_modify",
            "skin",
            "dt",
            "pairs looked at",
            "missing",
            "part",
            "at most",
            "missing in the worst look",
            &format!("s per time unit, {usual}"),
            "trajectory error",
            "fault",
        ];
        blocks.push(table(&heads, rows.collect()));
        charts::skins(self, points, blocks)
    }

    pub fn averages(&self, blocks: &mut Vec<Block>) {
        blocks.push(Block::Heading("Averages".into()));
        blocks.push(Block::Text(
            "Potential energy per atom and pressure of the same runs, with error bars by blocking (Flyvbjerg and Petersen 1989). Runs begin at \
             the same melted state and keep its energy; where the script has a thermostat, one more run was made with it, of which the first \
             fifth is left out.".into(),
        ));
        let reference = |name: &str| self.reference(name);
        let off = |row: &Record<'_>, value: &str, error: &str, name: &str| {
            let (value, error) = (row.number(value)?, row.number(error)?);
            Some(format!("{} error bars", format_g((value - reference(name)?) / error, 0, 3, false)))
        };
        let judged = |row: &Record<'_>, why_not: &str| {
            let of = [("U", "potential_energy", "potential_energy_error"), ("P", "pressure", "pressure_error")];
            let of = of.into_iter().filter(|(name, ..)| reference(name).is_some());
            let cell = |(name, value, error)| match why_not {
                "" => off(row, value, error, name).unwrap_or_default(),
                why => format!("not judged: {why}"),
            };
            of.map(cell).collect::<Vec<String>>()
        };
        let held = self.store.rows(&AVERAGES).filter(|row| row.text("fault").is_empty()).map(|row| {
            let text = |column: &str| row.text(column).to_string();
            let pair = |value: &str, error: &str| with_error(row.number(value), row.number(error));
            let mut cells = vec![
                named("own"),
                format!("script's, with {}", self.study.thermostats.join(", ")),
                text("precision"),
                text("dt"),
                self.study.program.policy.skin.to_string(),
                SAFE.into(),
                pair("temperature", "temperature_error"),
                pair("potential_energy", "potential_energy_error"),
                pair("pressure", "pressure_error"),
            ];
            cells.extend(judged(&row, ""));
            cells
        });
        let rows = self.store.rows(&ENERGIES).filter(|row| row.text("fault").is_empty()).map(|row| {
            let text = |column: &str| row.text(column).to_string();
            let mut cells = vec![
                named(row.text("potential")),
                named(row.text("integrator")),
                text("precision"),
                text("dt"),
                text("skin"),
                text("rebuild"),
                maybe(row.number("temperature")),
                with_error(row.number("potential_energy"), row.number("potential_energy_error")),
                with_error(row.number("pressure"), row.number("pressure_error")),
            ];
            let why_not = match row.text("potential") {
                "own" if self.study.thermostats.is_empty() => "",
                "own" => "no thermostat, another temperature",
                _ => "another Hamiltonian",
            };
            cells.extend(judged(&row, why_not));
            cells
        });
        let rows = held.chain(rows);
        let rows: Vec<Vec<String>> = rows.collect();
        let mut heads: Vec<String> =
            ["potential", "integrator", "precision", "dt", "skin", "neigh_modify", "T", "U per atom", "P"]
                .map(String::from)
                .to_vec();
        heads.extend(reference("U").map(|u| format!("U from {}", short(u))));
        heads.extend(reference("P").map(|p| format!("P from {}", short(p))));
        blocks.push(Block::Table(heads, rows));
    }

    pub fn prices(&self, blocks: &mut Vec<Block>) {
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
        let total = |name: &str, column: &str| -> f64 {
            self.store.rows(&PRICES).filter(|row| row.text("option") == name).filter_map(|row| row.number(column)).sum()
        };
        let rows = names.iter().map(|(name, base)| {
            let builds = 1000.0 * total(name, "builds") / total(name, "steps").max(1.0);
            let lost = total(name, "lost");
            let times = spread(rounds.iter().filter_map(|round| of(name, round)).collect());
            let ratios = rounds.iter().filter_map(|round| Some(of(name, round)? / of(base, round)?)).collect();
            let ratio = if name == base { "1".to_string() } else { words(spread(ratios)) };
            vec![
                name.to_string(),
                words(times),
                ratio,
                base.to_string(),
                format_g(builds, 0, 3, false),
                if lost > 0.0 { lost.to_string() } else { String::new() },
            ]
        });
        blocks.push(Block::Heading("What each option costs".into()));
        blocks.push(table(
            &["option", "microseconds a step", "ratio", "compared with", "builds in 1000 steps", "atoms lost"],
            rows.collect(),
        ));
        let off = self
            .store
            .rows(&PRICES)
            .filter(|row| row.text("option") == OFF_AGAIN && !row.text("same_program").is_empty());
        let (same, all) =
            off.fold((0, 0), |(same, all), row| (same + usize::from(row.text("same_program") == "yes"), all + 1));
        blocks.push(Block::Text(format!(
            "Ratios are of legs of the same round; median, least and most of {} rounds, in {} precision, with the script's dt and skin and {SAFE}. \
             What is off costs nothing: in {same} of {all} rounds, after all these were switched on and off again, the step as data and what the \
             engine says of its kernels (run --explain) were the same as if they had never been on. A free side with room beyond it costs what \
             the atoms at a surface have in fewer neighbors, and what they make of the room. Where atoms leave for good, every build in \
             which one is lost is made by the host, on a GPU with all particles fetched and written anew: that is no price of the side, but \
             of the loss, and it ends with it. Walls keep all atoms, so they are compared with the periodic scene.",
            self.plan.scale.price_rounds,
            self.plan.usual.name()
        )));
    }
}
