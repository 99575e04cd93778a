//! From a script to a finished run: reads commands one by one, judges the whole script first, then carries it out.

mod commands;
mod data;
mod driven;
mod energies;
mod environment;
mod good_state;
mod judge;
mod pair;
mod run;
mod run_loop;
mod settings;
mod state;
mod watch;

pub use driven::{Driven, Prepared, is_interrupted};
pub use judge::{FirstRun, Judged, Neighbors, check, check_text, first_run, neighbors, run, stop_on_interrupt};
pub use run::Outcome;
pub use settings::{BackendChoice, OnError, Settings};

use std::collections::BTreeMap;

use crate::engine::{Backend, GoodState};
use crate::output::dump::DumpObserver;
use crate::output::{Console, RunSummary, ThermoTable, WrittenFile};
use crate::scene::SceneBuilder;
use crate::script::Interpreter;
use crate::script::command::dump::{DumpCommand, DumpModifyCommand};
use crate::script::command::thermo::ThermoStyleCommand;
use environment::LastRun;

/// What the script has made of the session so far; cloned when the judged part ends and the real one begins.
#[derive(Clone)]
struct ScriptState {
    interpreter: Interpreter,
    scene: SceneBuilder,
    thermo_every: i64,
    thermo: ThermoTable,
    thermo_style: ThermoStyleCommand,
    dumps: Vec<DumpSetup>,
    /// Where each fix was defined (`file:line`), by its id.
    fix_places: BTreeMap<String, String>,
    /// Sums of the last run, as long as they describe the current particles.
    last_run: Option<LastRun>,
    /// A run has been judged: values that depend on it are unknown.
    judged_run: bool,
    /// A run has set the engine up and nothing has changed since (`run ... pre no`).
    continues: bool,
}

/// A dump as the script describes it.
#[derive(Clone)]
struct DumpSetup {
    command: DumpCommand,
    changes: Vec<DumpModifyCommand>,
    /// The group's bits when the dump was defined.
    group: u32,
}

/// What exists only while a script is carried out.
struct Live<'a> {
    settings: &'a Settings,
    console: Console,
    backend: Box<dyn Backend>,
    /// Open dumps by id.
    dumps: Vec<(String, Box<dyn DumpObserver>)>,
    files: Vec<WrittenFile>,
    report: crate::output::Report,
    /// Wall seconds of the last set-up: particles taken over, kernels, list, forces.
    set_up_seconds: f64,
    /// Statistics of the last run.
    summary: Option<RunSummary>,
    /// Steps of all runs so far.
    steps: i64,
    /// Step of the particles in the scene, which a run brings from the engine for outputs and at its end.
    particles_step: i64,
    checkpoints: good_state::Checkpoints,
    /// The latest state of a run that has passed all checks and is no longer in the scene.
    good: Option<GoodState>,
    /// Step at which the energy or the temperature was found to have jumped in the last run: states from there on are not to be
    /// relied upon.
    alarm: Option<i64>,
    /// The same of an earlier run: what the current one began with is not to be relied upon.
    doubt: Option<i64>,
    /// A last good state has been written for what ended the script.
    kept: bool,
    started: std::time::Instant,
}
