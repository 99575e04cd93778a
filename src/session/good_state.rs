//! What is kept of a run: the last good state when one stops, and on the way where that is asked for (`--on-error checkpoint`).

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::run::RunError;
use super::watch::{Watch, short, would_do};
use super::{Live, OnError, ScriptState, data};
use crate::Error;
use crate::engine::{Fault, GoodState, Program, StiffPair, Stop, Stride, shorter_timestep};
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
        match data::write_good_state(&self.good_path(), script, good, program) {
            Ok(()) => self.stays(good.step),
            Err(e) => format!("the state of step {} could not be written: {e}", good.step),
        }
    }

    /// Where the state of a step is, and whether it can be relied upon.
    fn stays(&self, step: i64) -> String {
        let when = match (self.alarm, self.doubt) {
            (_, Some(doubt)) => format!(", doubtful after the warning of step {doubt},"),
            (Some(alarm), None) if step >= alarm => format!(", doubtful after the warning of step {alarm},"),
            (Some(_), None) => ", before the warning,".into(),
            (None, None) => String::new(),
        };
        format!("the state of step {step}{when} is in {} (read_data takes it)", self.good_path().display())
    }

    /// A run begins with the particles of the scene.
    pub fn begin_watched(&mut self, step: i64) {
        self.doubt = self.doubt.or(self.alarm);
        (self.particles_step, self.good, self.alarm) = (step, None, None);
    }

    /// A script ends early that has made steps: what they led to is kept, or what there was before the energy jumped.
    pub fn keep_scene(&mut self, script: &ScriptState) {
        if self.steps == 0 || self.kept || self.settings.no_files {
            return;
        }
        let Ok((program, ..)) = script.scene.program(self.settings.search) else { return };
        let text = match (self.alarm, self.checkpoints.written, self.good.take()) {
            (Some(_), Some(step), good) if good.as_ref().is_none_or(|good| good.step <= step) => Some(self.stays(step)),
            (Some(_), _, Some(good)) => Some(self.keep(script, &good, &program)),
            _ => of_scene(script, script.scene.step).map(|good| self.keep(script, &good, &program)),
        };
        if let Some(text) = text {
            self.console.line(&capital(&text));
        }
        self.kept = true;
    }

    /// The script is at its end: the last checkpoint is of its last step.
    pub fn last_checkpoint(&mut self, script: &ScriptState) {
        let step = script.scene.step;
        if self.steps == 0 || self.alarm.is_some() || self.checkpoints.failed || self.checkpoints.written == Some(step)
        {
            return;
        }
        self.particles_step = step;
        if let Ok((program, ..)) = script.scene.program(self.settings.search) {
            self.write_checkpoint(script, &program);
        }
    }

    /// The latest state that can be relied upon, for a run that has come to an end this way; `watch` is that of a run under way.
    fn last_good(
        &mut self,
        why: &mut Trouble,
        script: &ScriptState,
        program: &Arc<Program>,
        watch: Option<&Watch>,
    ) -> Option<GoodState> {
        let engine = match why {
            Trouble::Stop(Stop::Fault(fault)) => fault.last_good.take().map(|good| *good),
            // Of a device that has failed nothing can be had.
            Trouble::Stop(Stop::Device(_)) => None,
            _ if watch.is_none() => None,
            Trouble::Broken(_) => self.backend.last_build().ok().flatten(),
            Trouble::Complaint(_) | Trouble::Error(_) => {
                let mut state = script.scene.state.clone();
                let fetched = self.backend.fetch(&mut state).is_ok();
                let (step, simulation_box) = (self.backend.step(), self.backend.simulation_box().clone());
                fetched.then_some(GoodState { step, state, simulation_box })
            }
        };
        let engine = engine.filter(|good| can_be_read(&good.state, &good.simulation_box));
        let Some(watch) = watch else {
            return engine.or_else(|| of_scene(script, self.particles_step).filter(|_| self.steps > 0));
        };
        // A script makes what its first run begins with; whatever came later is kept.
        let scene = of_scene(script, self.particles_step);
        let kept = self.good.take().filter(|good| can_be_read(&good.state, &good.simulation_box));
        let clean = if watch.is_clean(self.particles_step) { scene.clone().or(kept) } else { kept };
        // What the engine has may be later, but nobody has looked at it yet.
        match engine {
            Some(good) if clean.as_ref().is_none_or(|clean| good.step > clean.step) => {
                if self.passes(&good, program, watch) { Some(good) } else { clean.or(scene).or(Some(good)) }
            }
            _ => clean.or(scene),
        }
    }

    /// Whether a state passes the checks of its run, all at once: it is from before any jump, its energy is what it was, and its
    /// fastest particle gives no sign. The engine is asked for energies anew, so it must not be needed any more.
    fn passes(&mut self, good: &GoodState, program: &Arc<Program>, watch: &Watch) -> bool {
        if watch.is_alarmed() && !watch.is_clean(good.step) {
            return false;
        }
        let calm = Stride::fastest(program, &good.state).is_none_or(|stride| watch.is_calm(&stride, &good.state));
        if !calm || !watch.needs().energy {
            return calm;
        }
        let loaded = self.backend.load(program.clone(), &good.state, &good.simulation_box, good.step);
        if loaded.is_err() || self.backend.set_up(watch.needs()).is_err() {
            return false;
        }
        let neighbors = self.backend.statistics();
        self.backend.sums().is_ok_and(|sums| watch.accepts(good.step, &sums, good.state.len(), &neighbors))
    }
}

/// Ends a run that went wrong: the last good state goes to a data file, and the message says where. `watch` is that of a run
/// under way.
pub fn fail(
    mut why: Trouble,
    script: &ScriptState,
    live: &mut Live<'_>,
    program: &Arc<Program>,
    mut watch: Option<&mut Watch>,
) -> RunError {
    live.console.set_bar(None);
    for sign in watch.as_mut().map(|watch| watch.take_found()).unwrap_or_default() {
        live.console.warning(&sign);
    }
    let watch = watch.as_deref();
    live.console.end_table();
    live.kept = true;
    live.alarm = watch.and_then(Watch::alarm);
    if watch.is_some() && !matches!(why, Trouble::Stop(Stop::Device(_))) {
        live.report_stop(script.scene.state.len());
    }
    let limited = matches!(&why, Trouble::Stop(Stop::Fault(fault)) if fault.is_limited(program));
    let good = live.last_good(&mut why, script, program, watch);
    let advice = match (&why, &good) {
        (Trouble::Stop(Stop::Fault(fault)), good) => advice(fault, limited, live, program, watch, good.as_ref()),
        (Trouble::Broken(_), Some(good)) => of_timestep(program, watch, good, None),
        _ => Vec::new(),
    };
    let checkpoint = live.checkpoints.written.filter(|_| watch.is_some());
    let kept = match (checkpoint, good) {
        _ if live.settings.no_files => None,
        (Some(step), good) if good.as_ref().is_none_or(|good| good.step <= step) => Some(live.stays(step)),
        (_, good) => good.map(|good| live.keep(script, &good, program)),
    };
    // The words of what went wrong with output point into the script, or to a file.
    if let (Trouble::Complaint(_) | Trouble::Error(_), Some(text)) = (&why, &kept) {
        live.console.line(&capital(text));
    }
    let ended = |message: String| {
        let lines: Vec<String> = [message].into_iter().chain(advice).chain(kept).collect();
        RunError::Error(Error::Fault(lines.join("\n  ")))
    };
    match why {
        Trouble::Stop(why) => ended(why.to_string()),
        Trouble::Broken(text) => ended(text),
        Trouble::Complaint(complaint) => RunError::Complaint(complaint),
        Trouble::Error(error) => RunError::Error(error),
    }
}

/// What helps: in words, and a timestep where one would. `limited`: `fix nve/limit` moves the particle at fault.
fn advice(
    fault: &Fault,
    limited: bool,
    live: &Live<'_>,
    program: &Program,
    watch: Option<&Watch>,
    good: Option<&GoodState>,
) -> Vec<String> {
    let mut lines: Vec<String> = fault.advice(live.settings.precision, limited).into_iter().collect();
    if let Some(good) = good.filter(|good| fault.has_come_too_far() && good.step < fault.step) {
        lines.extend(of_timestep(program, watch, good, Some(fault.id)));
    }
    lines
}

/// The stiffest pair of a good state, where it is too stiff for the timestep, and a timestep that would do from there on: for the
/// fastest particle, that pair, and the particle with this id.
fn of_timestep(program: &Program, watch: Option<&Watch>, good: &GoodState, id: Option<u32>) -> Vec<String> {
    let stiff = StiffPair::of(program, &good.state, &good.simulation_box);
    let told = stiff.filter(|pair| pair.omega_dt(program) > StiffPair::COARSE).map(|pair| {
        let ([a, b], r, omega_dt) = (pair.ids, short(pair.distance), short(pair.omega_dt(program)));
        format!(
            "at step {} the stiffest pair is atoms {a} and {b} at distance {r} (omega dt = {omega_dt}, stable below 2)",
            good.step
        )
    });
    let needed = shorter_timestep(program, good, id);
    let proposed = watch.and_then(Watch::proposed).into_iter().chain(needed).reduce(f64::min);
    told.into_iter().chain(proposed.map(would_do)).collect()
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
