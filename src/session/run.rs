//! One `run` command: set-up, steps, output, statistics.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::environment::{LastRun, facts};
use super::good_state::fail;
use super::run_loop::{RunLoop, announce};
use super::watch::Watch;
use super::{Live, ScriptState};
use crate::Error;
use crate::engine::{Needs, Program, Reached};
use crate::output::printf::format_g;
use crate::output::summary::cpu_seconds;
use crate::output::thermo::memory_line;
use crate::output::{RunSummary, SceneFacts, StageTimes, ThermoSchedule};
use crate::pair::Tail;
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

/// What the last step of a run computes whoever looks: formulas between runs, and a run without set-up, may ask for it.
pub const LAST_STEP: Needs = Needs { energy: true, virial: true, pressure: true, positions: false, forces: false };

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
    let (mut program, mixed, mixable) = script.scene.program(live.settings.search)?;
    program.range = (command.start.unwrap_or(first), command.stop.unwrap_or(last));
    if live.settings.explain {
        explain(&program, live);
    }
    let mut facts = facts(&script.scene);
    facts.counting_from = command.start;
    script.thermo.start_run(script.scene.space()?.shrinks());
    let keep = !command.pre && script.continues;
    let before = script.last_run.as_ref().filter(|_| keep);
    facts.thermal_atoms = before.map(|r| r.thermal_atoms);
    facts.tail = match before {
        // Counted at the set-up; `pair_modify` may have switched it off since.
        Some(before) if program.pair.tail => before.tail,
        Some(_) => Tail::default(),
        None => program.pair.tail(&script.scene.state.atoms_of(program.pair.types)),
    };
    open_dumps(script, live, &Arc::new(facts.clone()))?;

    let program = Arc::new(program);
    let schedule = ThermoSchedule { every: script.thermo_every, first };
    let mut watch = Watch::new(program.clone(), first, keep);
    live.begin_watched(first);
    if keep {
        live.backend.continue_run(&program, &script.scene.state, first)?;
    } else {
        set_up_messages(&program, mixed, mixable, script, live);
        let space = script.scene.space()?;
        let clock = Instant::now();
        let loaded = live.backend.load(program.clone(), &script.scene.state, space, first);
        loaded.map_err(|why| fail(why.into(), script, live, &program, None))?;
        let needs = script.thermo.needs().union(watch.needs());
        let needs = live.dumps.iter().fold(needs, |needs, (_, dump)| needs.union(dump.needs()));
        let set_up = live.backend.set_up(if first == last { needs.union(LAST_STEP) } else { needs });
        live.set_up_seconds = clock.elapsed().as_secs_f64();
        set_up.map_err(|why| fail(why.into(), script, live, &program, None))?;
        facts.thermal_atoms = Some(script.scene.state.len() - live.backend.lost());
    }
    let facts = Arc::new(facts);
    // A set-up that fails leaves no files.
    for (_, dump) in &mut live.dumps {
        dump.set_facts(facts.clone());
        dump.begin_run(first)?;
    }
    announce(script, live, &program, schedule, (first, last))?;
    for line in live.backend.notes() {
        live.console.line(&line);
    }
    if live.settings.explain && !keep {
        for line in live.backend.explain() {
            live.console.line(&line);
        }
    }
    let bytes = live.backend.bytes() as u64;
    let atoms = script.scene.state.len().max(1) as u64;
    live.console.line(&format!("Memory per atom: {} bytes (particles, list, working memory)", bytes / atoms));
    live.console.line(&memory_line(bytes));
    // Of the particles that the run begins with.
    let space = live.backend.simulation_box();
    for sign in watch.look(first, &script.scene.state, None, space, &live.backend.statistics()) {
        live.console.warning(&sign);
    }
    for line in script.thermo.header() {
        live.console.line(&line);
    }
    live.console.begin_table();

    let cpu_before = cpu_seconds();
    let mut steps = RunLoop::new(script, live, program.clone(), facts.clone(), schedule, (first, last), watch);
    steps.stop = command.stop.unwrap_or(last);
    let reached = steps.go();
    let RunLoop { sums, loop_seconds, output_seconds, mut watch, .. } = steps;
    let reached = reached.map_err(|why| fail(why, script, live, &program, Some(&mut watch)))?;
    for line in script.thermo.footer() {
        live.console.line(&line);
    }
    let cpu_seconds = cpu_seconds().zip(cpu_before).map(|(after, before)| after - before);
    let summary = summarize(script, live, (first, loop_seconds, output_seconds, cpu_seconds));
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
        tail: facts.tail,
    });
    for (fix, memory) in script.scene.fixes.iter_mut().zip(live.backend.memories()) {
        fix.memory = memory;
    }
    script.continues = true;
    if let Some(fault) = live.console.take_fault() {
        return Err(fault.into());
    }
    Ok(if reached == Reached::Interrupted { Outcome::Interrupted } else { Outcome::Finished })
}

/// The statistics below the table.
fn summarize(
    script: &ScriptState,
    live: &Live<'_>,
    (first, loop_seconds, output_seconds, cpu_seconds): (i64, f64, f64, Option<f64>),
) -> RunSummary {
    let engine = live.backend.seconds();
    let busy = engine.pair + engine.neighbor() + engine.modify + output_seconds;
    let stages = StageTimes {
        pair: engine.pair,
        neighbor: engine.neighbor(),
        check: engine.check,
        sort: engine.sort,
        list: engine.list,
        output: output_seconds,
        modify: engine.modify,
        other: (loop_seconds - busy).max(0.0),
    };
    RunSummary {
        units: script.scene.units,
        loop_seconds,
        cpu_seconds,
        steps: script.scene.step - first,
        timestep: script.scene.timestep,
        atoms: script.scene.state.len(),
        threads: live.backend.threads(),
        stages,
        neighbors: live.backend.statistics(),
    }
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

/// Opens the dumps the script has defined since the last run.
fn open_dumps(script: &ScriptState, live: &mut Live<'_>, facts: &Arc<SceneFacts>) -> Result<(), RunError> {
    if live.settings.no_files {
        return Ok(());
    }
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
        format!("  search: {}, full list, {}", program.search, live.backend.describe()),
        "Setting up Verlet run ...".into(),
        format!("  Unit style    : {}", program.units.name),
        format!("  Current step  : {}", script.scene.step),
        format!("  Time step     : {}", format_g(program.timestep, 0, 6, false)),
    ];
    for line in &lines {
        live.console.line(line);
    }
    if program.pair.tail && !program.pair.has_tail() {
        let text = format!("pair style {} has no tail corrections: pair_modify tail adds nothing", program.pair.style);
        live.console.warning(&text);
    } else if program.pair.tail && script.scene.space.as_ref().is_some_and(|s| (0..3).any(|axis| !s.periodic(axis))) {
        live.console.warning("tail corrections (pair_modify tail) in a box with sides that are not periodic");
    }
    if let Some((first, second)) = program.moved_twice(&script.scene.state.mask) {
        let fix = |place: usize| {
            let fix = &program.fixes[place];
            let defined = script.fix_places.get(&fix.id).map_or("", String::as_str);
            format!("fix {} ({}, {defined})", fix.id, fix.style)
        };
        let (first, second) = (fix(first), fix(second));
        live.console.warning(&format!("One or more atoms are time integrated more than once: by {first} and {second}"));
    }
    if !program.moves() {
        live.console.warning("no fix integrates the motion: atoms stay where they are");
    }
}

/// `--explain`: what the engine was specialized to, and what it left out.
fn explain(program: &Program, live: &mut Live<'_>) {
    for line in program.explain() {
        live.console.line(&line);
    }
}
