//! The tuning run: which skin and which kernels are the fastest, by size and precision.

use super::measure::{Case, go, melt};
use super::row::Spread;
use super::{Ended, Halt, Options, Plan, Said, cases, fits};
use crate::Error;
use crate::engine::tuned::{Choices, Found, Table};
use crate::output::calendar::today;
use crate::session::{Driven, Prepared, Settings};

/// Skins that are tried, in tenths of sigma.
const TENTHS: std::ops::RangeInclusive<u32> = 2..=14;

/// Particles a group and warps an octant that are tried.
const GROUPS: [(u32, u32); 6] = [(32, 1), (16, 2), (16, 4), (8, 8), (8, 16), (4, 32)];

/// Blocks on a multiprocessor that are tried. With one, scenes that keep more in registers than the benchmark's would have half
/// its threads.
const BLOCKS: std::ops::RangeInclusive<u32> = 2..=4;

/// Chunks ahead that are tried.
const AHEAD: std::ops::RangeInclusive<u32> = 0..=2;

/// Most threads a row.
const MOST_LANES: u32 = 32;

/// Steps before a leg whose length is found out.
const PILOT_STEPS: u32 = 50;

/// Seconds of a leg.
const LEG_SECONDS: f64 = 0.25;

/// Least steps of a leg: several lists are built even with the widest skin.
const LEAST_STEPS: i64 = 200;

/// A skin, and kernels, at one size in one precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tried {
    pub atoms: usize,
    pub precision: &'static str,
    pub skin: f64,
    /// On a GPU.
    pub choices: Option<Choices>,
    pub steps_per_s: Spread,
    /// It is the fastest of those tried.
    pub best: bool,
}

/// Tries all skins, and returns the table that this octant was built with after taking over the best of them.
pub fn tune(options: &Options, say: &mut dyn FnMut(Said<'_>)) -> Result<(Table, Ended), Error> {
    let (plan, note) = Plan::new(options)?;
    if let Some(note) = note {
        say(Said::Note(note));
    }
    let mut best: Vec<Vec<(usize, Found)>> = vec![Vec::new(); plan.settings.len()];
    let mut table = Table::built_in().clone();
    for case in cases(options, say) {
        for (settings, best) in plan.settings.iter().zip(&mut best) {
            match fastest(&case, &plan, settings, say) {
                Ok(found) => best.push((case.cells.atoms(), found)),
                Err(Halt::Interrupted) => return Ok((table, Ended::Interrupted)),
                Err(Halt::Error(error)) => return Err(error),
            }
        }
    }
    let machine = &plan.machine;
    let driver = if machine.driver.is_empty() { String::new() } else { format!(", driver {}", machine.driver) };
    let from = format!("{}, {}{driver}", today(), machine.device);
    for (settings, best) in plan.settings.iter().zip(&mut best) {
        best.sort_unstable_by_key(|(atoms, _)| *atoms);
        table.set(&machine.architecture, settings.precision, &ranges(best), &from);
    }
    Ok((table, Ended::Finished))
}

/// The fastest skin of a size and, on a GPU, the fastest kernels: with the skin that is best with those of the table, threads a
/// row with blocks, then groups, then chunks ahead; then skins beside it once more.
fn fastest(case: &Case, plan: &Plan, settings: &Settings, say: &mut dyn FnMut(Said<'_>)) -> Result<Found, Halt> {
    let (atoms, architecture) = (case.cells.atoms(), &plan.machine.architecture);
    let choices =
        architecture.starts_with("sm_").then(|| Table::built_in().choices(architecture, settings.precision, atoms));
    let skins: Vec<f64> = TENTHS.map(|tenths| f64::from(tenths) / 10.0).filter(|skin| fits(case, *skin)).collect();
    let (melted, _) = melt(case, skins[0], settings)?;
    let mut all: Vec<Tried> = Vec::new();
    let mut attempt = |found: &[Found]| -> Result<Found, Halt> {
        for Found { skin, choices } in found.iter().copied() {
            if all.iter().any(|one| (one.skin, one.choices) == (skin, choices)) {
                continue;
            }
            let settings = Settings { choices, ..settings.clone() };
            let steps_per_s = Spread::of(&rates(&melted, plan, &settings, skin)?);
            all.push(Tried { atoms, precision: settings.precision.name(), skin, choices, steps_per_s, best: false });
        }
        let best = all.iter().max_by(|a, b| a.steps_per_s.median.total_cmp(&b.steps_per_s.median));
        let best = best.expect("some skin fits into the smallest box");
        Ok(Found { skin: best.skin, choices: best.choices })
    };
    let mut best = attempt(&skins.iter().map(|skin| Found { skin: *skin, choices }).collect::<Vec<_>>())?;
    if let Some(now) = best.choices {
        let with = |choices: Choices| Found { skin: best.skin, choices: Some(choices) };
        let lanes = [now.lanes / 2, now.lanes, now.lanes * 2].into_iter().filter(|n| (1..=MOST_LANES).contains(n));
        let force = lanes.flat_map(|lanes| BLOCKS.map(move |blocks| with(Choices { lanes, blocks, ..now })));
        best = attempt(&force.collect::<Vec<_>>())?;
        let now = best.choices.unwrap_or(now);
        let lists = GROUPS.map(|(group, slices)| Found { choices: Some(Choices { group, slices, ..now }), ..best });
        best = attempt(&lists)?;
        let now = best.choices.unwrap_or(now);
        best =
            attempt(&AHEAD.map(|ahead| Found { choices: Some(Choices { ahead, ..now }), ..best }).collect::<Vec<_>>())?;
        let beside =
            [-0.1, -0.05, 0.05, 0.1].map(|more| Found { skin: ((best.skin + more) * 100.0).round() / 100.0, ..best });
        let beside: Vec<Found> =
            beside.into_iter().filter(|found| found.skin > 0.0 && fits(case, found.skin)).collect();
        best = attempt(&beside)?;
    }
    for one in &mut all {
        one.best = (one.skin, one.choices) == (best.skin, best.choices);
        say(Said::Tried(one));
    }
    Ok(best)
}

/// Steps a second of each round.
fn rates(melted: &Prepared, plan: &Plan, settings: &Settings, skin: f64) -> Result<Vec<f64>, Halt> {
    let mut driven = Driven::new(melted.clone(), settings)?;
    go(&mut driven, &format!("neighbor {skin} bin\nrun {PILOT_STEPS}"))?;
    let rate = |driven: &Driven<'_>| driven.summary().expect("a run leaves a summary").steps_per_second();
    let steps = plan.steps.unwrap_or(((rate(&driven) * LEG_SECONDS) as i64).max(LEAST_STEPS));
    let mut rates = Vec::new();
    for _ in 0..plan.rounds {
        go(&mut driven, &format!("run {steps} pre no"))?;
        rates.push(rate(&driven));
    }
    Ok(rates)
}

/// From what is best at sizes to what is from sizes on: each holds from the geometric mean with the size below.
fn ranges<T: Copy>(best: &[(usize, T)]) -> Vec<(usize, T)> {
    let middle = |k: usize| ((best[k - 1].0 as f64 * best[k].0 as f64).sqrt().round() as usize).max(1);
    (0..best.len()).map(|k| (if k == 0 { 0 } else { middle(k) }, best[k].1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skins_hold_from_between_the_sizes() {
        assert_eq!(ranges(&[(4_000, 0.4), (36_000, 0.5), (100_000, 0.6)]), [(0, 0.4), (12_000, 0.5), (60_000, 0.6)]);
    }
}
