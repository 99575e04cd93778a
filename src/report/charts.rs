//! The charts of the page.

use super::chart::{COLORS, Chart, Mark, Series};
use super::content::Facts;
use super::front::{Found, SAFE};
use super::lammps;
use super::measure::{ENERGIES, MISSING};
use super::page::Block;
use super::statistics::order as fitted;
use super::store::Record;

/// Precisions with their colors and marks.
const PRECISIONS: [(&str, usize, Mark); 3] =
    [("single", 0, Mark::Triangle), ("mixed", 1, Mark::Dot), ("double", 2, Mark::Square)];

fn series(name: &str, color: usize, mark: Mark, line: bool, points: Vec<(f64, f64)>) -> Series {
    Series { name: name.into(), color: COLORS[color], mark, line, points }
}

fn push(blocks: &mut Vec<Block>, name: &str, chart: &Chart, caption: &str) -> Result<(), String> {
    if !chart.is_empty() {
        blocks.push(Block::Figure { name: name.into(), svg: chart.svg()?, caption: caption.into() });
    }
    Ok(())
}

/// Errors against time: trajectory, fluctuation and force.
pub fn work(facts: &Facts<'_>, points: &[Found], blocks: &mut Vec<Block>) -> Result<(), String> {
    let x = "wall seconds for a unit of simulated time".to_string();
    for (potential, title, file) in
        [("own", "script's potential", "work"), ("force-shifted", "force-shifted potential", "work-shifted")]
    {
        let of: Vec<&Found> = points.iter().filter(|p| p.potential == potential && p.fault.is_empty()).collect();
        let chart = |y: &str, value: &dyn Fn(&Found) -> Option<f64>, error: &str, joined: bool| {
            let at = |p: &&Found| value(p).map(|v| (p.time.median, v));
            let mut all: Vec<Series> = Vec::new();
            if let Some(own) = facts.own(points).filter(|own| own.potential == potential) {
                all.push(series("script's settings", 3, Mark::Frame, false, at(&own).into_iter().collect()));
            }
            let front = |p: &&&Found| p.front;
            let mut ringed: Vec<(f64, f64)> = of.iter().filter(front).filter_map(at).collect();
            ringed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            all.push(series("Pareto front", 6, Mark::Ring, joined, ringed));
            let drifting = of.iter().filter(front).filter(|p| facts.drifts(p)).filter_map(at).collect();
            all.push(series("front, but energy drifts", 3, Mark::Struck, false, drifting));
            for (name, color, mark) in PRECISIONS {
                let own = |p: &&&Found| p.precision == name && p.integrator == "own" && p.is_sound();
                all.push(series(name, color, mark, false, of.iter().filter(own).filter_map(at).collect()));
            }
            let lacking = |p: &&&Found| p.integrator == "own" && !p.is_sound();
            all.push(series(
                "lists lack pairs, or may",
                3,
                Mark::Cross,
                false,
                of.iter().filter(lacking).filter_map(at).collect(),
            ));
            let euler2 = |p: &&&Found| p.integrator != "own";
            all.push(series("nve/euler2", 5, Mark::Dot, false, of.iter().filter(euler2).filter_map(at).collect()));
            if potential == "own" {
                let rows = lammps::rows(facts.store);
                let peer = rows.filter_map(|row| row.number("seconds_per_time").zip(row.number(error)));
                all.push(series("LAMMPS (double, CPU)", 4, Mark::Square, false, peer.collect()));
            }
            Chart { title: format!("{y} against time, {title}"), x: x.clone(), y: y.into(), series: all }
        };
        let trajectory = chart("RMS trajectory error", &|p| p.trajectory, "rms_error", true);
        push(blocks, file, &trajectory, "Trajectory error against time; the front is of this chart.")?;
        let fluctuation = chart("Energy fluctuation per atom", &|p| p.fluctuation, "fluctuation", false);
        push(
            blocks,
            &format!("{file}-energy"),
            &fluctuation,
            "Fluctuation of the continuous energy against time; ringed is the front of the chart above.",
        )?;
        if potential == "own" {
            let force = chart("RMS force error", &|p| p.force, "force_error_rms", false);
            push(
                blocks,
                "work-force",
                &force,
                "Force error, relative to the RMS force, against time; ringed is the front of the first chart.",
            )?;
        }
    }
    Ok(())
}

/// Trajectory errors against the time step, and what is fitted.
pub fn order(facts: &Facts<'_>, blocks: &mut Vec<Block>) -> Result<(), String> {
    let mut all = Vec::new();
    for (potential, integrator, name, color) in [
        ("own", "own", "script's", 1),
        ("force-shifted", "own", "force-shifted", 2),
        ("own", "nve/euler2", "nve/euler2", 5),
    ] {
        for (precision, _, mark) in PRECISIONS {
            let rows = facts.trajectories(potential, integrator);
            let rows = rows.iter().filter(|row| row.text("precision") == precision);
            let points = rows.filter_map(|row| row.number("dt_used").zip(row.number("rms_error"))).collect();
            // Errors of the two potentials are often the same: open marks stand around the others.
            let mark = if potential == "own" { mark } else { mark.open() };
            all.push(series(&format!("{name}, {precision}"), color, mark, false, points));
        }
        let points = facts.convergence(potential, integrator);
        if let Some((slope, _)) = fitted(&points) {
            let mean =
                |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(|p| of(p).ln()).sum::<f64>() / points.len() as f64;
            let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
            let line = points.iter().map(|p| (p.0, (y + slope * (p.0.ln() - x)).exp())).collect();
            all.push(series(&format!("{name}: order {slope:.2}"), color, Mark::None, true, line));
        }
    }
    let chart = Chart {
        title: "Trajectory error against time step".into(),
        x: "dt".into(),
        y: "RMS trajectory error".into(),
        series: all,
    };
    push(blocks, "order", &chart, "Lines are the fitted orders.")
}

/// Fluctuations of both energies against the time step, and the predicted walk.
pub fn energy(facts: &Facts<'_>, blocks: &mut Vec<Block>) -> Result<(), String> {
    let usual = facts.plan.usual.name();
    let rows: Vec<Record<'_>> = facts.store.rows(&ENERGIES).filter(|row| row.text("rebuild") == SAFE).collect();
    let of = |potential: &str, precision: &str, value: &dyn Fn(&Record<'_>) -> Option<f64>| {
        let is = |row: &&Record<'_>| {
            row.text("potential") == potential && row.text("integrator") == "own" && row.text("precision") == precision
        };
        rows.iter().filter(is).filter_map(|row| row.number("dt").zip(value(row))).collect::<Vec<_>>()
    };
    let mut all = Vec::new();
    if facts.study.jumps() {
        all.push(series("E plain", 3, Mark::Cross, true, of("own", usual, &|row| row.number("fluctuation_plain"))));
    }
    for (name, color, mark) in PRECISIONS {
        let label = if facts.study.jumps() { "E - N U(rc)" } else { "E" };
        all.push(series(
            &format!("{label}, {name}"),
            color,
            mark,
            true,
            of("own", name, &|row| row.number("fluctuation")),
        ));
    }
    let walk = |row: &Record<'_>| row.number("walk_predicted").zip(row.number("time")).map(|(d, t)| (d * t).sqrt());
    all.push(series("predicted walk, RMS at the end", 6, Mark::None, true, of("own", usual, &walk)));
    all.push(series(
        "force-shifted, E",
        4,
        Mark::Dot,
        true,
        of("force-shifted", usual, &|row| row.number("fluctuation")),
    ));
    let chart = Chart {
        title: "Energy fluctuation per atom against time step".into(),
        x: "dt".into(),
        y: "RMS fluctuation".into(),
        series: all,
    };
    push(
        blocks,
        "energy",
        &chart,
        "A random walk has no bounded fluctuation: what the run shows of it depends on its length.",
    )
}

/// Time and missing pairs against the skin, with the script's time step.
pub fn skins(facts: &Facts<'_>, points: &[Found], blocks: &mut Vec<Block>) -> Result<(), String> {
    let dt = facts.study.program.timestep;
    let own = |p: &&Found| p.potential == "own" && p.integrator == "own" && p.dt == dt && p.rebuild == SAFE;
    let all = PRECISIONS.map(|(name, color, mark)| {
        let of = points.iter().filter(own).filter(|p| p.precision == name && p.fault.is_empty());
        let mut of: Vec<(f64, f64)> = of.map(|p| (p.skin, p.time.median)).collect();
        of.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        series(name, color, mark, true, of)
    });
    let y = "wall seconds for a unit of simulated time".to_string();
    let title = format!("Time against skin, dt {dt}, {SAFE}");
    push(
        blocks,
        "skins",
        &Chart { title, x: "skin".into(), y, series: all.to_vec() },
        "List builds are part of the time.",
    )?;
    let mut policies: Vec<&str> = Vec::new();
    for row in facts.store.rows(&MISSING) {
        if !policies.contains(&row.text("rebuild")) {
            policies.push(row.text("rebuild"));
        }
    }
    let all = policies.iter().enumerate().map(|(k, policy)| {
        let rows =
            facts.store.rows(&MISSING).filter(|row| row.text("rebuild") == *policy && row.number("dt") == Some(dt));
        let mut of: Vec<(f64, f64)> = rows
            .filter_map(|row| Some((row.number("skin")?, row.number("missing")? / row.number("pairs")?.max(1.0))))
            .collect();
        of.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        series(policy, k % COLORS.len(), Mark::Dot, true, of)
    });
    let title = format!("Missing pairs against skin, dt {dt}");
    let chart =
        Chart { title, x: "skin".into(), y: "part of the pairs within the cutoff".into(), series: all.collect() };
    push(blocks, "missing", &chart, "Policies that lack no pair have no point here: logarithms know no 0.")
}
