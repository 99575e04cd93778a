//! What is kept of a run: the last good state when one stops, and on the way where that is asked for (`--on-error checkpoint`).

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::run::RunError;
use super::watch::{Watch, would_do};
use super::{Live, OnError, ScriptState, data};
use crate::Error;
use crate::engine::{Fault, GoodState, Program, Stop};
use crate::script::Complaint;
use crate::system::{SimulationBox, State, Vec3};

/// Checkpoints take no more than one part in so many of the wall time.
const PART_OF_TIME: u32 = 20;

/// Why the steps of a run end before their time.
pub enum Trouble {
    /// The engine stopped.
    Stop(Stop),
    /// The numbers of the current step are none.
    Broken(String),
    /// Output went wrong, not the particles.
    Complaint(Complaint),
    Error(Error),
}

impl From<Stop> for Trouble {
    fn from(why: Stop) -> Self {
        Self::Stop(why)
    }
}

impl From<Complaint> for Trouble {
    fn from(complaint: Complaint) -> Self {
        Self::Complaint(complaint)
    }
}

impl From<Error> for Trouble {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

/// The checkpoints of a session.
#[derive(Clone, Debug, Default)]
pub struct Checkpoints {
    /// Not before this; at once where there is none.
    due: Option<Instant>,
    /// Step of the last one.
    pub written: Option<i64>,
    failed: bool,
}

impl Live<'_> {
    /// Wall seconds between checkpoints, where they are asked for.
    pub fn checkpoint_seconds(&self) -> Option<f64> {
        match self.settings.on_error {
            OnError::Checkpoint { seconds } if !self.settings.no_files => Some(seconds),
            _ => None,
        }
    }

    /// Whether a checkpoint should be written now.
    pub fn wants_checkpoint(&self) -> bool {
        let due = self.checkpoints.due.is_none_or(|due| Instant::now() >= due);
        due && !self.checkpoints.failed && self.checkpoint_seconds().is_some()
    }

    /// Writes the particles of the scene as a checkpoint, if they are good. A run does not end for one that cannot be written.
    pub fn write_checkpoint(&mut self, script: &ScriptState, program: &Program) {
        let Some(seconds) = self.checkpoint_seconds() else { return };
        let Some(good) = of_scene(script, self.particles_step) else { return };
        let clock = Instant::now();
        match data::write_good_state(&self.good_path(), script, &good, program) {
            Ok(()) => self.checkpoints.written = Some(good.step),
            Err(e) => {
                self.checkpoints.failed = true;
                self.console.warning(&format!("no more checkpoints: {}: {e}", self.good_path().display()));
            }
        }
        let pause = Duration::from_secs_f64(seconds).max(PART_OF_TIME * clock.elapsed());
        self.checkpoints.due = Some(Instant::now() + pause);
    }

    /// Beside the log file.
    fn good_path(&self) -> PathBuf {
        self.settings.log.as_deref().and_then(Path::parent).unwrap_or(Path::new("")).join("last-good.data")
    }

    /// Writes a good state; what there is to say of it.
    fn keep(&mut self, script: &ScriptState, good: &GoodState, program: &Program) -> String {
        let path = self.good_path();
        match data::write_good_state(&path, script, good, program) {
            Ok(()) => format!("the state of step {} is in {} (read_data takes it)", good.step, path.display()),
            Err(e) => format!("the state of step {} could not be written: {e}", good.step),
        }
    }

    /// A script ends early that has made steps: what they led to is kept.
    pub fn keep_scene(&mut self, script: &ScriptState) {
        if self.steps == 0 || self.kept || self.settings.no_files {
            return;
        }
        let Ok((program, ..)) = script.scene.program(self.settings.search) else { return };
        if let Some(good) = of_scene(script, script.scene.step) {
            let text = self.keep(script, &good, &program);
            self.console.line(&capital(&text));
        }
    }

    /// The script is at its end: the last checkpoint is of its last step.
    pub fn last_checkpoint(&mut self, script: &ScriptState) {
        let step = script.scene.step;
        if self.steps == 0 || self.alarmed || self.checkpoints.failed || self.checkpoints.written == Some(step) {
            return;
        }
        self.particles_step = step;
        if let Ok((program, ..)) = script.scene.program(self.settings.search) {
            self.write_checkpoint(script, &program);
        }
    }

    /// The latest state that can be relied upon, for a run that has come to an end this way.
    fn last_good(&self, why: &mut Trouble, script: &ScriptState, under_way: bool) -> Option<GoodState> {
        let engine = match why {
            Trouble::Stop(Stop::Fault(fault)) => fault.last_good.take().map(|good| *good),
            // Of a device that has failed nothing can be had.
            Trouble::Stop(Stop::Device(_)) => None,
            _ if !under_way => None,
            Trouble::Broken(_) => self.backend.last_build().ok().flatten(),
            Trouble::Complaint(_) | Trouble::Error(_) => {
                let mut state = script.scene.state.clone();
                let fetched = self.backend.fetch(&mut state).is_ok();
                let (step, simulation_box) = (self.backend.step(), self.backend.simulation_box().clone());
                fetched.then_some(GoodState { step, state, simulation_box })
            }
        };
        let engine = engine.filter(|good| can_be_read(&good.state, &good.simulation_box));
        // A script makes what its first run begins with; whatever came later is kept.
        engine.or_else(|| of_scene(script, self.particles_step).filter(|_| under_way || self.steps > 0))
    }
}

/// Ends a run that went wrong: the last good state goes to a data file, and the message says where. `watch` is that of a run
/// under way.
pub fn fail(
    mut why: Trouble,
    script: &ScriptState,
    live: &mut Live<'_>,
    program: &Program,
    mut watch: Option<&mut Watch>,
) -> RunError {
    live.console.set_bar(None);
    for sign in watch.as_mut().map(|watch| watch.take_found()).unwrap_or_default() {
        live.console.warning(&sign);
    }
    let watch = watch.as_deref();
    live.console.end_table();
    live.kept = true;
    let advice = match &why {
        Trouble::Stop(Stop::Fault(fault)) => advice(fault, live, program, watch),
        Trouble::Broken(_) => [None, watch.and_then(Watch::proposed).map(would_do)],
        _ => [None, None],
    };
    let checkpoint = live.checkpoints.written.filter(|_| watch.is_some_and(Watch::is_alarmed));
    let kept = if live.settings.no_files {
        None
    } else if let Some(step) = checkpoint {
        Some(format!(
            "the state of step {step}, before the warning, is in {} (read_data takes it)",
            live.good_path().display()
        ))
    } else {
        let good = live.last_good(&mut why, script, watch.is_some());
        good.map(|good| live.keep(script, &good, program))
    };
    // The words of what went wrong with output point into the script, or to a file.
    if let (Trouble::Complaint(_) | Trouble::Error(_), Some(text)) = (&why, &kept) {
        live.console.line(&capital(text));
    }
    let ended = |message: String| {
        let lines: Vec<String> = [Some(message)].into_iter().chain(advice).chain([kept]).flatten().collect();
        RunError::Error(Error::Fault(lines.join("\n  ")))
    };
    match why {
        Trouble::Stop(why) => ended(why.to_string()),
        Trouble::Broken(text) => ended(text),
        Trouble::Complaint(complaint) => RunError::Complaint(complaint),
        Trouble::Error(error) => RunError::Error(error),
    }
}

/// What helps: in words, and a timestep where one would.
fn advice(fault: &Fault, live: &Live<'_>, program: &Program, watch: Option<&Watch>) -> [Option<String>; 2] {
    let timestep = watch.and_then(Watch::proposed).or_else(|| fault.timestep(program));
    let timestep = timestep.filter(|_| fault.has_come_too_far());
    [fault.advice(live.settings.precision), timestep.map(would_do)]
}

/// The particles of the scene, which are those of a step, unless they are no numbers or out of the box.
fn of_scene(script: &ScriptState, step: i64) -> Option<GoodState> {
    let (state, simulation_box) = (&script.scene.state, script.scene.space.as_ref()?);
    can_be_read(state, simulation_box).then(|| GoodState {
        step,
        state: state.clone(),
        simulation_box: simulation_box.clone(),
    })
}

/// Whether `read_data` takes these particles: numbers, and within fixed sides.
fn can_be_read(state: &State, simulation_box: &SimulationBox) -> bool {
    let finite = state.x.iter().chain(&state.v).flat_map(|v| v.iter()).all(|c| c.is_finite());
    if state.is_empty() || !finite {
        return false;
    }
    let mut space = simulation_box.clone();
    let wrapped = |x: &Vec3| {
        let (mut x, mut image) = (*x, [0; 3]);
        simulation_box.wrap(&mut x, &mut image);
        x
    };
    let x: Vec<Vec3> = state.x.iter().map(wrapped).collect();
    space.shrink_wrap(&x);
    x.iter().all(|x| space.outside(x).is_none())
}

/// As a sentence begins.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
