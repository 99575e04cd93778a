//! Scripts in pieces, for programs that measure: each piece is carried out as `octant run` does it, without screen and log, and
//! between pieces the simulation can be looked into.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

use serde_json::{Map, Value};

use super::environment::BetweenRuns;
use super::judge::{Checkpoint, go_on, judge, lacks, read};
use super::run::{Outcome, STOP};
use super::{Live, ScriptState, Settings};
use crate::Error;
use crate::engine::{Backend, Needs, Program, Reached};
use crate::output::{Console, Report, RunSummary};
use crate::scene::SceneBuilder;
use crate::script::{Complaint, Interpreter, Source};
use crate::system::{SimulationBox, State};

/// A scene as commands have made it, without an engine.
#[derive(Clone)]
pub struct Prepared(ScriptState);

impl Prepared {
    /// Judges commands that set a scene up and run nothing; `name` is what messages call them.
    pub fn new(name: &str, commands: &str, settings: &Settings) -> Result<Self, Error> {
        settings.check()?;
        let (_, end, ..) = judge(&Source::new(name, commands), settings, Console::discard())?;
        Ok(Self(end))
    }

    /// What a script file leaves at its end: all of it is judged and carried out, runs included, but no file is written. Dumps and
    /// columns of its thermo table are forgotten. `None` where the user interrupted it.
    pub fn at_end(script: &Path, settings: &Settings) -> Result<Option<Self>, Error> {
        settings.check()?;
        let settings = Settings { no_files: true, ..settings.clone() };
        let source = read(script)?;
        let (judged, end, checkpoint, _) = judge(&source, &settings, Console::discard())?;
        let Some(Checkpoint { mut state, statement }) = checkpoint.filter(|_| judged.runs > 0) else {
            end.scene.program(settings.search).map_err(|complaint| lacks(&source, "report", &complaint))?;
            let complaint = Complaint::new(0, "the script has no run, so there is nothing to study");
            return Err(lacks(&source, "report", &complaint).into());
        };
        let (backend, _) = settings.engine()?;
        let mut live = Live::new(&settings, Console::discard(), backend, Report::new(), Instant::now());
        if go_on(&mut state, statement, &mut live)? == Outcome::Interrupted {
            return Ok(None);
        }
        // Runs end between list builds.
        state.forget_output();
        Ok(Some(Self(state)))
    }

    /// The scene, to be changed in ways that no command has.
    pub(crate) fn scene_mut(&mut self) -> &mut SceneBuilder {
        self.0.last_run = None;
        self.0.continues = false;
        &mut self.0.scene
    }

    pub(crate) fn scene(&self) -> &SceneBuilder {
        &self.0.scene
    }

    pub fn state(&self) -> &State {
        &self.0.scene.state
    }

    /// To change particles in ways that no command has.
    pub fn state_mut(&mut self) -> &mut State {
        self.0.last_run = None;
        self.0.continues = false;
        &mut self.0.scene.state
    }

    /// `None` before a command has made one.
    pub fn simulation_box(&self) -> Option<&SimulationBox> {
        self.0.scene.space.as_ref()
    }

    /// The step as data, as a run would begin it now.
    pub fn program(&self, settings: &Settings) -> Result<Program, Error> {
        program(&self.0, settings)
    }

    /// The number that a variable of the script has at its end; `None` where there is none, or no number.
    pub(crate) fn variable(&mut self, name: &str) -> Option<f64> {
        let ScriptState { scene, interpreter, last_run, thermo, .. } = &mut self.0;
        let (scene, last_run) = (&*scene, last_run.as_ref());
        let mut environment = BetweenRuns { scene, last_run, unknown: false, per_atom: thermo.norm() };
        interpreter.variable_value(name, &mut environment).ok().map(|quantity| quantity.value)
    }
}

fn program(script: &ScriptState, settings: &Settings) -> Result<Program, Error> {
    let made = script.scene.program(settings.search);
    made.map(|(program, ..)| program).map_err(|complaint| Error::Fault(complaint.message))
}

/// A scene with an engine, which carries out commands as they are handed in.
pub struct Driven<'a> {
    script: ScriptState,
    live: Live<'a>,
    note: Option<String>,
    /// Wall seconds that it took to make the engine.
    engine_seconds: f64,
}

impl<'a> Driven<'a> {
    /// Makes the engine that the settings ask for; it takes the particles over at the first `run`.
    pub fn new(prepared: Prepared, settings: &'a Settings) -> Result<Self, Error> {
        let clock = Instant::now();
        let (backend, note) = settings.engine()?;
        let engine_seconds = clock.elapsed().as_secs_f64();
        let live = Live::new(settings, Console::discard(), backend, Report::new(), Instant::now());
        Ok(Self { script: prepared.0, live, note, engine_seconds })
    }

    /// A line for the user where the engine is not the one that was hoped for.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Carries out commands; those that follow an interrupted run are not.
    pub fn carry_out(&mut self, commands: &str) -> Result<Outcome, Error> {
        self.script.interpreter = Interpreter::new(Source::new("commands", commands), &[])?;
        match self.script.next()? {
            Some(first) => go_on(&mut self.script, first, &mut self.live),
            None => Ok(Outcome::Finished),
        }
    }

    /// Goes on step by step until the engine has built its list anew, `most` steps at most, and brings back the particles as
    /// they are right after that build. Tells whether there was one.
    pub fn step_to_build(&mut self, most: u64) -> Result<bool, Error> {
        let backend = &mut self.live.backend;
        let builds = backend.statistics().builds;
        for _ in 0..most {
            let reached = backend.advance(1, Needs::default(), &STOP).map_err(|why| Error::Fault(why.to_string()))?;
            if reached == Reached::Interrupted || STOP.load(Ordering::Relaxed) {
                return Ok(false);
            }
            if backend.statistics().builds != builds {
                backend.fetch(&mut self.script.scene.state)?;
                self.script.scene.step = backend.step();
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Wall seconds from a scene in memory to its first step: the engine is made, kernels are compiled or found in their cache,
    /// particles taken over, list and forces worked out. Of the last set-up; the engine's alone before the first.
    pub fn start_up(&self) -> f64 {
        self.engine_seconds + self.live.set_up_seconds
    }

    /// Statistics of the last run; `None` before the first.
    pub fn summary(&self) -> Option<&RunSummary> {
        self.live.summary.as_ref()
    }

    /// Thermo rows of all runs since the last call, values by column header.
    pub fn take_thermo(&mut self) -> Vec<Map<String, Value>> {
        std::mem::take(&mut self.live.report.thermo)
    }

    /// The step as data, as a run would begin it now.
    pub fn program(&self) -> Result<Program, Error> {
        program(&self.script, self.live.settings)
    }

    pub fn backend(&self) -> &dyn Backend {
        &*self.live.backend
    }

    /// Particles as the last run, or [`Driven::step_to_build`], left them.
    pub fn state(&self) -> &State {
        &self.script.scene.state
    }

    /// The scene as it stands; the engine is given up.
    pub fn into_prepared(self) -> Prepared {
        let Self { script, .. } = self;
        Prepared(script)
    }
}

/// Whether the user has asked for an end (Ctrl-C).
pub fn is_interrupted() -> bool {
    STOP.load(Ordering::Relaxed)
}
