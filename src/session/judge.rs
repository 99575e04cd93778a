//! The two passes over a script: judge all of it, then carry it out.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::commands::{Done, Pass, carry_out};
use super::run::{Outcome, STOP};
use super::{Live, ScriptState, Settings};
use crate::Error;
use crate::engine::{FaultKind, Needs, Program, Stop};
use crate::neighbor::Grid;
use crate::output::Console;
use crate::output::Report;
use crate::scene::builder::list_fits;
use crate::script::{Command, Complaint, InputError, Source, Span, Statement};
use crate::system::{SimulationBox, State};

/// What `octant check` says of a good script.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Judged {
    pub commands: usize,
    pub runs: usize,
    pub atoms: usize,
}

impl fmt::Display for Judged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = |n: usize| if n == 1 { "" } else { "s" };
        let Self { commands, runs, atoms } = self;
        write!(f, "fine: {commands} command{}, {runs} run{}, {atoms} atoms", plural(*commands), plural(*runs))
    }
}

/// Reads a script file.
pub(super) fn read(script: &Path) -> Result<Arc<Source>, Error> {
    let bytes = std::fs::read(script).map_err(|e| Error::file(script, "cannot read", e))?;
    Ok(Source::from_bytes(script.display().to_string(), &bytes))
}

/// The point at which a script first needs more than judging: a run, or a file written.
pub(super) struct Checkpoint {
    pub state: ScriptState,
    pub statement: Statement,
}

/// A script with more commands than this, loops counted out, has no end.
const MOST_COMMANDS: usize = 1_000_000;

/// Judges a whole script: every command is parsed and applied, runs are set up on paper only. What the commands before the
/// first run print goes to `console`; the rest of the script is judged in silence.
pub(super) fn judge(
    source: &Arc<Source>,
    settings: &Settings,
    console: Console,
) -> Result<(Judged, ScriptState, Option<Checkpoint>, Console), Error> {
    let mut state = ScriptState::new(source, settings)?;
    let mut judged = Judged::default();
    let mut checkpoint = None;
    let mut shown = console;
    let mut silent = Console::discard();
    while let Some(statement) = state.next()? {
        judged.commands += 1;
        if judged.commands > MOST_COMMANDS {
            let message = format!("expected the script to end, got more than {MOST_COMMANDS} commands");
            let endless = Complaint::new(0, message).with_help("does a jump lead back to its label for ever?");
            return Err(statement.complain(endless).into());
        }
        let parsed = Command::parse(&statement);
        let acts = match &parsed {
            Ok(Command::Run(_) | Command::WriteData(_) | Command::PairWrite(_)) => true,
            Ok(Command::Print(print)) => print.file.is_some(),
            _ => false,
        };
        if acts && checkpoint.is_none() {
            checkpoint = Some(Checkpoint { state: state.clone(), statement: statement.clone() });
        }
        judged.runs += usize::from(matches!(&parsed, Ok(Command::Run(_))));
        let console = if checkpoint.is_none() { &mut shown } else { &mut silent };
        console.echo(&statement.echo);
        let done = parsed.map_err(|c| statement.complain(c).into());
        let done = done.and_then(|command| carry_out(&mut state, &statement, &command, Pass::Judging(console)));
        match done {
            Ok(_) => {}
            // A value that only a run can tell stands in this command: it is judged when it is reached.
            Err(_) if statement.tentative => {}
            Err(error) => return Err(error),
        }
    }
    judged.atoms = state.scene.state.len();
    Ok((judged, state, checkpoint, shown))
}

/// Judges a script and runs nothing.
pub fn check(script: &Path, settings: &Settings) -> Result<Judged, Error> {
    settings.check()?;
    let (judged, ..) = judge(&read(script)?, settings, Console::discard())?;
    Ok(judged)
}

/// Judges a script given as text; `name` is what messages call it.
pub fn check_text(name: &str, text: &str, settings: &Settings) -> Result<Judged, Error> {
    settings.check()?;
    let (judged, ..) = judge(&Source::new(name, text), settings, Console::discard())?;
    Ok(judged)
}

/// Judges a script, then runs it.
pub fn run(script: &Path, settings: &Settings) -> Result<Outcome, Error> {
    settings.check()?;
    let started = Instant::now();
    let source = read(script)?;
    let mut console = Console::new(settings.quiet).held();
    if let Some(log) = &settings.log {
        console.open_log(log, false)?;
    }
    console.line(&format!("Octant {} (reads LAMMPS input scripts)", env!("CARGO_PKG_VERSION")));
    let (_, end, checkpoint, mut console) = judge(&source, settings, console)?;
    let (backend, note) = settings.engine()?;
    if let Some(path) = &settings.json {
        crate::output::check_writable(path)
            .map_err(|m| Error::Unavailable(format!("--json {}: {m}", path.display())))?;
    }
    console.release()?;
    if let Some(note) = note {
        console.line(&note);
    }
    let mut report = Report::new();
    report.settings = settings.describe(&source.name, &*backend);
    let mut live = Live::new(settings, console, backend, report, started);
    let (mut state, outcome) = match checkpoint {
        None => (end, Ok(Outcome::Finished)),
        Some(Checkpoint { mut state, statement }) => {
            drop(end);
            let outcome = go_on(&mut state, statement, &mut live);
            if matches!(outcome, Ok(Outcome::Interrupted)) && live.checkpoint_seconds().is_none() {
                live.keep_scene(&state);
            }
            (state, outcome)
        }
    };
    live.console.echo(&state.interpreter.trailing_echo());
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => {
            live.console.log_only(&format!("ERROR: {error}"));
            live.console.flush();
            // What ended the script is what there is to tell, whatever becomes of the report.
            let _ = live.write_report(Some(error.to_string()));
            return Err(error);
        }
    };
    live.last_checkpoint(&state);
    live.finish(outcome)?;
    Ok(outcome)
}

/// Carries out a statement and all that follow.
pub(super) fn go_on(state: &mut ScriptState, first: Statement, live: &mut Live<'_>) -> Result<Outcome, Error> {
    let mut next = Some(first);
    let mut outcome = Outcome::Finished;
    let mut result = Ok(());
    while let Some(statement) = next {
        live.console.echo(&statement.echo);
        let command = Command::parse(&statement).map_err(|c| statement.complain(c));
        let done = match command {
            Ok(command) => carry_out(state, &statement, &command, Pass::Live(live)),
            Err(error) => Err(error.into()),
        };
        match done {
            Ok(Done::Next) => {}
            Ok(Done::Interrupted) => {
                outcome = Outcome::Interrupted;
                break;
            }
            Err(error) => {
                live.keep_scene(state);
                result = Err(error);
                break;
            }
        }
        if STOP.load(Ordering::Relaxed) {
            outcome = Outcome::Interrupted;
            break;
        }
        next = match state.next() {
            Ok(next) => next,
            Err(error) => {
                live.keep_scene(state);
                result = Err(error.into());
                break;
            }
        };
    }
    // Whatever happened, what was written is closed whole.
    let closed = live.close_dumps();
    result?;
    closed?;
    Ok(outcome)
}

/// What the first run of a script starts from.
#[derive(Clone, Debug)]
pub struct FirstRun {
    pub program: Program,
    pub state: State,
    pub simulation_box: SimulationBox,
    /// Number of the step.
    pub step: i64,
}

/// Judges a script given as text and returns what its first run starts from, or what there is at its end; `name` is what messages
/// call it.
pub fn first_run(name: &str, text: &str, settings: &Settings) -> Result<FirstRun, Error> {
    settings.check()?;
    start_of(&Source::new(name, text), settings, "first run")
}

/// The same for a source; `asker` is named if the script makes nothing that could be run.
fn start_of(source: &Arc<Source>, settings: &Settings, asker: &str) -> Result<FirstRun, Error> {
    let (_, end, checkpoint, _) = judge(source, settings, Console::discard())?;
    let scene = checkpoint.map_or(end, |c| c.state).scene;
    let (program, ..) = scene.program(settings.search).map_err(|c| lacks(source, asker, &c))?;
    let simulation_box = scene.space().map_err(|c| lacks(source, asker, &c))?.clone();
    Ok(FirstRun { program, simulation_box, step: scene.step, state: scene.state })
}

/// A script without a run may lack things; that shows at its end.
pub(super) fn lacks(source: &Arc<Source>, asker: &str, complaint: &Complaint) -> InputError {
    let length = source.text.trim_end().len();
    InputError::new(source, Span::new(length, length), format!("{asker}: {}", complaint.message))
}

/// Neighbors of every atom.
#[derive(Clone, Debug)]
pub struct Neighbors {
    /// (id, neighbors), by id.
    pub counts: Vec<(u32, u32)>,
    /// Largest neighbor cutoff, length units.
    pub radius: f64,
    /// The grid in words.
    pub grid: String,
}

/// Counts neighbors in the configuration a script has made when its first run begins (or when it ends). `cutoff` replaces
/// the cutoffs of all pairs.
pub fn neighbors(script: &Path, settings: &Settings, cutoff: Option<f64>) -> Result<Neighbors, Error> {
    settings.check()?;
    let source = read(script)?;
    let FirstRun { mut program, mut state, simulation_box, step } = start_of(&source, settings, "neighbors")?;
    if let Some(cutoff) = cutoff {
        program.policy.skin = 0.0;
        for pair in &mut program.pair.pairs {
            pair.cutoff = cutoff;
        }
        list_fits(&state, &simulation_box, cutoff).map_err(|c| lacks(&source, "neighbors", &c))?;
    }
    let radius = program.pair.neighbor_cutoffs(program.policy.skin).into_iter().fold(0.0, f64::max);
    let (mut backend, _) = settings.engine()?;
    backend.load(Arc::new(program), &state, &simulation_box, step)?;
    // Overlapping atoms have no finite force, but they have neighbors.
    match backend.set_up(Needs::default()) {
        Err(Stop::Fault(fault)) if fault.kind == FaultKind::Force => {}
        Err(why) => return Err(Error::Fault(why.to_string())),
        Ok(()) => {}
    }
    backend.fetch(&mut state)?;
    let mut counts: Vec<(u32, u32)> = state.id.iter().copied().zip(backend.neighbor_counts()?).collect();
    counts.sort_unstable();
    let (low, high) = state.bounds();
    let grid = Grid::new(settings.search, backend.simulation_box(), &low, &high, radius).to_string();
    Ok(Neighbors { counts, radius, grid })
}

/// Ctrl-C asks the run to stop after its step; a second one ends the program at once.
pub fn stop_on_interrupt(exit_code: i32) -> Result<(), Error> {
    ctrlc::set_handler(move || {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(exit_code);
        }
    })
    .map_err(|e| Error::Unavailable(format!("cannot listen for Ctrl-C: {e}")))
}
