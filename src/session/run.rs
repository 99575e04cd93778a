//! One `run` command: set-up, steps, output, statistics.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use super::environment::{InsideRun, LastRun, facts};
use super::{Live, ScriptState};
use crate::Error;
use crate::engine::{Fault, Needs, Program, Reached, Snapshot, Sums};
use crate::output::printf::format_g;
use crate::output::summary::cpu_seconds;
use crate::output::thermo::memory_line;
use crate::output::{Progress, Quantities, RunSummary, SceneFacts, StageTimes, ThermoSchedule};
use crate::scene::builder::g8;
use crate::script::Complaint;
use crate::script::command::run::RunCommand;

/// How a script ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Finished,
    /// The user interrupted it; everything written is whole.
    Interrupted,
}

/// Set by the first Ctrl-C.
pub static STOP: AtomicBool = AtomicBool::new(false);

/// The engine comes back at least this often for the progress bar.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(200);

/// First and last step of a run command.
pub fn steps(command: &RunCommand, now: i64) -> Result<(i64, i64), Complaint> {
    let last = if command.upto { Some(command.steps) } else { now.checked_add(command.steps) };
    match last {
        Some(last) if last < now => Err(Complaint::new(1, format!("upto {last} lies before the current step {now}"))),
        Some(last) => Ok((now, last)),
        None => Err(Complaint::new(1, "too many steps")),
    }
}

/// Carries the run out.
pub fn run(script: &mut ScriptState, live: &mut Live<'_>, command: &RunCommand) -> Result<Outcome, RunError> {
    let (first, last) = steps(command, script.scene.step)?;
    let (program, mixed, mixable) = script.scene.program(live.settings.search)?;
    if live.settings.explain {
        explain(&program, live);
    }
    let mut facts = facts(&script.scene);
    facts.counting_from = command.start;
    script.thermo.start_run(script.scene.space()?.shrinks());
    let schedule = ThermoSchedule { every: script.thermo_every, first };
    let keep = !command.pre && script.continues;
    facts.thermal_atoms = script.last_run.as_ref().filter(|_| keep).map(|r| r.thermal_atoms);
    open_dumps(script, live, &Arc::new(facts.clone()))?;

    let thermo_needs = script.thermo.needs();
    // Formulas between runs, and a run without set-up, may ask for the sums of the last step.
    let last_needs = Needs { energy: true, virial: true, ..Needs::default() };
    let mut first_needs = if first == last { thermo_needs.union(last_needs) } else { thermo_needs };
    for (_, dump) in &live.dumps {
        first_needs = first_needs.union(dump.needs());
    }
    let program = Arc::new(program);
    if keep {
        live.backend.continue_run(&program, &script.scene.state, first);
    } else {
        set_up_messages(&program, mixed, mixable, script, live);
        let space = script.scene.space()?;
        live.backend.load(program.clone(), &script.scene.state, space, first);
        let set_up = live.backend.set_up(first_needs);
        set_up.map_err(|fault| stop(fault, script, live, &program))?;
        facts.thermal_atoms = Some(script.scene.state.len() - live.backend.lost());
    }
    let facts = Arc::new(facts);
    // A set-up that fails leaves no files.
    for (_, dump) in &mut live.dumps {
        dump.set_facts(facts.clone());
        dump.begin_run(first)?;
    }
    live.console.line(&memory_line(live.backend.bytes() as u64));
    for line in script.thermo.header() {
        live.console.line(&line);
    }
    live.console.begin_table();

    let started = Instant::now();
    let cpu_before = cpu_seconds();
    let atoms = script.scene.state.len();
    let mut progress = Progress::start(first, last, atoms, live.settings.quiet, &mut live.console);
    let mut output_seconds = 0.0;
    let mut reached = Reached::End;
    let mut lost = 0;
    let mut sums = Sums::default();
    let mut now = first;
    loop {
        let end = now == last || reached == Reached::Interrupted;
        let due = |next: Option<i64>| next == Some(now);
        let thermo_due = end || due(schedule.next(now - 1, last));
        let dump_due: Vec<bool> = live.dumps.iter().map(|(_, d)| due(d.next(now - 1, last))).collect();
        let clock = Instant::now();
        if thermo_due || dump_due.contains(&true) {
            // Energies and pressures need no particles on this side.
            let reads_particles = thermo_needs.positions || thermo_needs.forces || dump_due.contains(&true);
            if end || reads_particles || live.backend.lost() > lost {
                live.backend.fetch(&mut script.scene.state);
            }
            // Without set-up, energy and virial of the last run still stand.
            sums = live.backend.sums();
            let space = live.backend.simulation_box().clone();
            script.scene.space = Some(space.clone());
            script.scene.step = now;
            if live.backend.lost() > lost {
                lost = live.backend.lost();
                if program.lost == crate::engine::LostAtoms::Warn {
                    live.console.warning(&format!("{lost} atoms left through a free side and are gone by step {now}"));
                }
            }
            let state = std::mem::take(&mut script.scene.state);
            let snapshot = Snapshot {
                step: now,
                first_step: first,
                last_step: last,
                timestep: program.timestep,
                state: &state,
                simulation_box: &space,
                sums: &sums,
                neighbors: live.backend.statistics(),
                elapsed_seconds: started.elapsed().as_secs_f64(),
            };
            let shown = show(script, live, &snapshot, &facts, command.stop.unwrap_or(last), thermo_due, &dump_due);
            script.scene.state = state;
            shown?;
        }
        output_seconds += clock.elapsed().as_secs_f64();
        if end {
            break;
        }
        let thermo_next = schedule.next(now, last);
        let dump_next = live.dumps.iter().filter_map(|(_, d)| d.next(now, last));
        let next = dump_next.chain(thermo_next).chain([last]).min().unwrap_or(last);
        while now < next && reached == Reached::End {
            // A bar moves only when the engine comes back.
            let pace = if progress.is_shown() && now > first {
                let rate = (now - first) as f64 / started.elapsed().as_secs_f64();
                (rate * PROGRESS_INTERVAL.as_secs_f64()) as i64
            } else if progress.is_shown() {
                1
            } else {
                next - now
            };
            let ahead = pace.clamp(1, next - now);
            let mut needs = Needs::default();
            if now + ahead == next {
                needs = if next == last { thermo_needs.union(last_needs) } else { thermo_needs };
                for (_, dump) in live.dumps.iter().filter(|(_, d)| d.next(now, last) == Some(next)) {
                    needs = needs.union(dump.needs());
                }
            }
            let advanced = live.backend.advance(ahead as u64, needs, &STOP);
            reached = advanced.map_err(|fault| stop(fault, script, live, &program))?;
            now = live.backend.step();
            progress.reach(now);
        }
    }
    progress.finish(&mut live.console);
    for line in script.thermo.footer() {
        live.console.line(&line);
    }

    let loop_seconds = started.elapsed().as_secs_f64();
    let engine = live.backend.seconds();
    let busy = engine.pair + engine.neighbor + engine.modify + output_seconds;
    let stages = StageTimes {
        pair: engine.pair,
        neighbor: engine.neighbor,
        output: output_seconds,
        modify: engine.modify,
        other: (loop_seconds - busy).max(0.0),
    };
    let summary = RunSummary {
        units: script.scene.units,
        loop_seconds,
        cpu_seconds: cpu_seconds().zip(cpu_before).map(|(after, before)| after - before),
        steps: now - first,
        timestep: program.timestep,
        atoms: script.scene.state.len(),
        threads: live.backend.threads(),
        stages,
        neighbors: live.backend.statistics(),
    };
    // Readers of logs take every line up to the loop time for data, so warnings wait for it.
    for (k, line) in summary.lines(command.post).iter().enumerate() {
        live.console.line(line);
        if k == 0 {
            live.console.end_table();
        }
    }
    live.report_run(&summary);
    script.last_run = Some(LastRun {
        sums,
        neighbors: summary.neighbors,
        first_step: first,
        seconds: loop_seconds,
        thermal_atoms: facts.thermal_atoms.unwrap_or(summary.atoms),
    });
    script.continues = true;
    if let Some(fault) = live.console.take_fault() {
        return Err(fault.into());
    }
    Ok(if reached == Reached::Interrupted { Outcome::Interrupted } else { Outcome::Finished })
}

/// Error of a run: of the command itself or of what happened.
pub enum RunError {
    Complaint(Complaint),
    Error(Error),
}

impl From<Complaint> for RunError {
    fn from(complaint: Complaint) -> Self {
        Self::Complaint(complaint)
    }
}

impl From<Error> for RunError {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

/// Shows a step to the thermo table and to the dumps that are due.
fn show(
    script: &mut ScriptState,
    live: &mut Live<'_>,
    snapshot: &Snapshot<'_>,
    facts: &SceneFacts,
    stop: i64,
    thermo_due: bool,
    dump_due: &[bool],
) -> Result<(), RunError> {
    if thermo_due {
        let range = (facts.counting_from.unwrap_or(snapshot.first_step), stop);
        let quantities = Quantities::new(snapshot, facts, script.thermo.norm());
        let (interpreter, scene) = (&mut script.interpreter, &script.scene);
        let row = script.thermo.row(&quantities, &mut |name| {
            let mut environment = InsideRun { scene, quantities: &quantities, range };
            interpreter.variable_value(name, &mut environment).map(|q| q.value)
        });
        let row = row.map_err(|m| Complaint::new(0, m))?;
        let text = script.thermo.text(&row).map_err(|m| Complaint::new(0, m))?;
        live.console.line(&text);
        live.report.thermo.push(script.thermo.json(&row));
        if script.thermo.flush() {
            live.console.flush();
        }
    }
    for ((_, dump), due) in live.dumps.iter_mut().zip(dump_due) {
        if *due {
            dump.observe(snapshot, &mut live.console)?;
        }
    }
    Ok(())
}

/// Opens the dumps the script has defined since the last run.
fn open_dumps(script: &ScriptState, live: &mut Live<'_>, facts: &Arc<SceneFacts>) -> Result<(), RunError> {
    for setup in &script.dumps {
        let id = &setup.command.id.text;
        if live.dumps.iter().any(|(open, _)| open == id) {
            continue;
        }
        live.dumps.push((id.clone(), setup.open(facts.clone())?));
    }
    Ok(())
}

/// What LAMMPS tells before the first step, as far as it applies here.
fn set_up_messages(program: &Program, mixed: usize, mixable: usize, script: &ScriptState, live: &mut Live<'_>) {
    let policy = &program.policy;
    let yes = |b: bool| if b { "yes" } else { "no" };
    let cutoff = program.pair.largest_cutoff() + policy.skin;
    let mixing = script.scene.pair.as_ref().map_or("geometric", |p| p.mixing.name());
    let lines = [
        format!("Generated {mixed} of {mixable} mixed pair_coeff terms from {mixing} mixing rule"),
        "Neighbor list info ...".into(),
        if policy.once {
            "  update: at the start of the run only".into()
        } else {
            let (every, delay) = (policy.every, policy.delay);
            format!("  update: every = {every} steps, delay = {delay} steps, check = {}", yes(policy.check))
        },
        format!("  master list distance cutoff = {}", g8(cutoff)),
        format!("  search: {}, full list, {}", program.search.name(), live.backend.describe()),
        "Setting up Verlet run ...".into(),
        format!("  Unit style    : {}", program.units.name),
        format!("  Current step  : {}", script.scene.step),
        format!("  Time step     : {}", format_g(program.timestep, 0, 6, false)),
    ];
    for line in &lines {
        live.console.line(line);
    }
    if program.fixes.is_empty() {
        live.console.warning("no fix integrates the motion: atoms stay where they are");
    }
}

/// `--explain`: what the engine was specialized to, and what it left out.
fn explain(program: &Program, live: &mut Live<'_>) {
    for line in program.explain() {
        live.console.line(&line);
    }
}

/// Ends a run that went wrong: the last good state goes to a data file, and the message says where.
fn stop(fault: Fault, script: &ScriptState, live: &mut Live<'_>, program: &Program) -> RunError {
    live.console.set_bar(None);
    live.console.end_table();
    let mut message = fault.to_string();
    if let Some(good) = &fault.last_good {
        let path = good_state_path(live.settings.log.as_deref());
        match super::data::write_good_state(&path, script, good, program) {
            Ok(()) => {
                message += &format!("\n  the state of step {} is in {} (read_data takes it)", good.step, path.display())
            }
            Err(e) => message += &format!("\n  the state of step {} could not be written: {e}", good.step),
        }
    }
    RunError::Error(Error::Fault(message))
}

/// Beside the log file.
fn good_state_path(log: Option<&Path>) -> PathBuf {
    log.and_then(Path::parent).unwrap_or(Path::new("")).join("last-good.data")
}
