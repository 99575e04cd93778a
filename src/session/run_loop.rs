//! The steps of a run: advance to the next step that someone wants to see, show it, and so on.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::environment::InsideRun;
use super::good_state::Trouble;
use super::run::{LAST_STEP, STOP};
use super::watch::Watch;
use super::{Live, ScriptState};
use crate::Error;
use crate::engine::{GoodState, Needs, Program, Reached, Record, Snapshot, Sums};
use crate::output::{Progress, Quantities, SceneFacts, ThermoSchedule};
use crate::script::Complaint;
use crate::system::{LostAtoms, SimulationBox, State};

/// The engine comes back at least this often for the progress bar.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(200);

/// A run under way.
pub struct RunLoop<'r, 'l> {
    script: &'r mut ScriptState,
    live: &'r mut Live<'l>,
    program: Arc<Program>,
    facts: Arc<SceneFacts>,
    schedule: ThermoSchedule,
    first: i64,
    last: i64,
    now: i64,
    /// Step that formulas of time count to.
    pub stop: i64,
    started: Instant,
    /// Wall seconds spent on thermo rows and dumps.
    pub output_seconds: f64,
    /// Wall seconds of the whole run, known at its end.
    pub loop_seconds: f64,
    /// Particles lost so far.
    lost: usize,
    /// Those of the last step that was shown.
    pub sums: Sums,
    /// Energy and virial of the current step have been worked out.
    summed: bool,
    pub watch: Watch,
}

impl<'r, 'l> RunLoop<'r, 'l> {
    /// A run that is set up, from its first to its last step.
    pub fn new(
        script: &'r mut ScriptState,
        live: &'r mut Live<'l>,
        program: Arc<Program>,
        facts: Arc<SceneFacts>,
        schedule: ThermoSchedule,
        (first, last): (i64, i64),
        watch: Watch,
    ) -> Self {
        let (started, sums) = (Instant::now(), Sums::default());
        let (now, stop, lost) = (first, last, 0);
        let (output_seconds, loop_seconds) = (0.0, 0.0);
        Self {
            script,
            live,
            program,
            facts,
            schedule,
            first,
            last,
            now,
            stop,
            started,
            output_seconds,
            loop_seconds,
            lost,
            sums,
            summed: true,
            watch,
        }
    }

    /// Wall seconds since the run began.
    fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Runs to the end, or until the user interrupts; the step reached is always shown.
    pub fn go(&mut self) -> Result<Reached, Trouble> {
        let atoms = self.script.scene.state.len();
        let mut progress =
            Progress::start(self.first, self.last, atoms, self.live.settings.quiet, &mut self.live.console);
        let mut reached = Reached::End;
        loop {
            let end = self.now == self.last || reached == Reached::Interrupted;
            let clock = Instant::now();
            let fetched = self.observe(end)?;
            let fetched = self.look(fetched)?;
            let fetched = self.checkpoint(fetched)?;
            self.output_seconds += clock.elapsed().as_secs_f64();
            if end {
                // What comes after the run reads particles; the run is over before they come.
                self.loop_seconds = self.elapsed();
                self.fetch(fetched)?;
                progress.finish(&mut self.live.console);
                return Ok(reached);
            }
            reached = self.advance(&mut progress)?;
        }
    }

    /// Goes on to the next step that someone wants to see, or to one of several whose sums alone are wanted; those before it are
    /// shown.
    fn advance(&mut self, progress: &mut Progress) -> Result<Reached, Trouble> {
        let look = self.watch.next(self.now);
        let mut rows = self.rows_of_sums();
        if rows > 0 && !self.script.thermo.needs().sums() {
            // Rows without energies do not serve the watch.
            rows = rows.min((look - 1 - self.now) / self.schedule.every);
        }
        if rows > 1 && self.now + self.schedule.every <= look {
            let rows = rows.min(self.pace(progress) / self.schedule.every);
            if rows > 1 {
                return self.advance_over(rows, progress);
            }
        }
        let dumps = self.live.dumps.iter().filter_map(|(_, d)| d.next(self.now, self.last));
        let rows = self.schedule.next(self.now, self.last);
        let next = dumps.chain(rows).chain([self.last, look]).min().unwrap_or(self.last);
        let wanted = self.needs_at(next);
        let mut reached = Reached::End;
        while self.now < next && reached == Reached::End {
            let ahead = self.pace(progress).clamp(1, next - self.now);
            // A checkpoint may be written there.
            let between = self.live.checkpoint_seconds().map_or(Needs::default(), |_| self.watch.needs());
            let needs = if self.now + ahead == next { wanted } else { between };
            reached = self.live.backend.advance(ahead as u64, needs, &STOP)?;
            // Whoever interrupts is shown everything.
            self.summed = needs.sums() || reached == Reached::Interrupted;
            self.now = self.live.backend.step();
            progress.reach(self.now);
            if self.live.wants_checkpoint() {
                break;
            }
        }
        Ok(reached)
    }

    /// Rows that are ahead before anyone wants to see anything else, if all of them want sums alone.
    fn rows_of_sums(&self) -> i64 {
        rows_of_sums(self.script, self.live, &self.program, self.schedule, (self.now, self.last))
    }

    /// Goes on to one of so many rows, and shows those before it.
    fn advance_over(&mut self, rows: i64, progress: &mut Progress) -> Result<Reached, Trouble> {
        let needs = self.script.thermo.needs();
        let mut records = Vec::new();
        let outputs = (self.schedule.every as u64, rows as u64);
        let advanced = self.live.backend.advance_recording(outputs, needs, &STOP, &mut records);
        let clock = Instant::now();
        let space = self.live.backend.simulation_box().clone();
        for Record { step, sums } in records {
            (self.now, self.sums) = (step, sums);
            self.show(&space, true, &[])?;
            self.see(needs.sums());
        }
        self.output_seconds += clock.elapsed().as_secs_f64();
        let reached = advanced?;
        self.summed = needs.sums() || reached == Reached::Interrupted;
        self.now = self.live.backend.step();
        progress.reach(self.now);
        Ok(reached)
    }

    /// Steps until the engine should come back for the progress bar or a checkpoint.
    fn pace(&self, progress: &Progress) -> i64 {
        let done = (self.now - self.first) as f64;
        let shown = progress.is_shown().then_some(PROGRESS_INTERVAL.as_secs_f64());
        let intervals = [shown, self.live.checkpoint_seconds()].into_iter().flatten();
        match (intervals.min_by(f64::total_cmp), self.elapsed()) {
            (None, _) => i64::MAX,
            (Some(interval), seconds) if done > 0.0 && seconds > 0.0 => {
                ((done / seconds * interval) as i64).clamp(1, i64::MAX)
            }
            (Some(_), _) => 1,
        }
    }

    /// What has to be computed at a later step.
    fn needs_at(&self, step: i64) -> Needs {
        let due = |next: Option<i64>| next == Some(step);
        let mut needs = if step == self.last { LAST_STEP } else { Needs::default() };
        if due(self.schedule.next(self.now, self.last)) {
            needs = needs.union(self.script.thermo.needs());
        }
        if self.watch.next(self.now) == step {
            needs = needs.union(self.watch.needs());
        }
        let dumps = self.live.dumps.iter().filter(|(_, d)| due(d.next(self.now, self.last)));
        dumps.fold(needs, |needs, (_, dump)| needs.union(dump.needs()))
    }

    /// Shows the current step to the thermo table and to the dumps that are due; tells whether that took particles.
    fn observe(&mut self, end: bool) -> Result<bool, Trouble> {
        let due = |next: Option<i64>| next == Some(self.now);
        let thermo_due = end || due(self.schedule.next(self.now - 1, self.last));
        let dump_due: Vec<bool> = self.live.dumps.iter().map(|(_, d)| due(d.next(self.now - 1, self.last))).collect();
        let looks = self.watch.next(self.now - 1) == self.now && self.watch.needs().sums();
        if !thermo_due && !dump_due.contains(&true) && !looks {
            return Ok(false);
        }
        let lost = self.live.backend.lost();
        // Energies and pressures need no particles on this side.
        let columns = self.script.thermo.needs();
        let shows = thermo_due && (columns.positions || columns.forces);
        let fetched = shows || dump_due.contains(&true) || lost > self.lost;
        self.fetch(!fetched)?;
        if lost > self.lost && self.program.lost == LostAtoms::Warn {
            let text = format!("{lost} atoms left through a free side and are gone by step {}", self.now);
            self.live.console.warning(&text);
        }
        if lost > self.lost {
            self.watch.forget();
        }
        self.lost = lost;
        if thermo_due || looks {
            // Without set-up, energy and virial of the last run still stand.
            self.sums = self.live.backend.sums()?;
        }
        if thermo_due || dump_due.contains(&true) {
            let space = self.live.backend.simulation_box().clone();
            self.show(&space, thermo_due, &dump_due)?;
        }
        if thermo_due || looks {
            self.see(self.summed);
        }
        Ok(fetched)
    }

    /// Particles of the current step, unless they are there.
    fn fetch(&mut self, there: bool) -> Result<(), Trouble> {
        if !there {
            let aside = self.set_aside();
            if let Err(error) = self.live.backend.fetch(&mut self.script.scene.state) {
                if aside && let Some(good) = self.live.good.take() {
                    self.script.scene.state = good.state;
                }
                return Err(error.into());
            }
            self.live.particles_step = self.now;
        }
        Ok(())
    }

    /// The particles of the scene are about to be replaced: they are kept where they have passed all checks; tells whether
    /// they have.
    fn set_aside(&mut self) -> bool {
        let step = self.live.particles_step;
        if step == self.now || !self.watch.is_clean(step) {
            return false;
        }
        let Some(simulation_box) = self.script.scene.space.clone() else { return false };
        // The arrays of the one before are filled next.
        let arrays = self.live.good.take().map(|good| good.state).unwrap_or_default();
        let state = std::mem::replace(&mut self.script.scene.state, arrays);
        self.live.good = Some(GoodState { step, state, simulation_box });
        true
    }

    /// Shows sums to the watch, where they have the energy.
    fn see(&mut self, summed: bool) {
        if summed {
            let atoms = self.script.scene.state.len();
            self.watch.see(self.now, &self.sums, atoms, &self.live.backend.statistics());
        }
    }

    /// Has the watch look at particles, where they are there or it asks for them; tells whether they are.
    fn look(&mut self, fetched: bool) -> Result<bool, Trouble> {
        let neighbors = self.live.backend.statistics();
        if !fetched && !self.watch.asks_for_particles(self.now, &neighbors) && !self.watch.keeps(self.now) {
            return Ok(false);
        }
        self.fetch(fetched)?;
        let (space, state) = (self.live.backend.simulation_box(), &self.script.scene.state);
        for sign in self.watch.look(self.now, state, self.live.good.as_ref(), space, &neighbors) {
            self.live.console.warning(&sign);
        }
        self.live.alarm = self.watch.alarm();
        Ok(true)
    }

    /// Writes a checkpoint if it is time; tells whether particles are there.
    fn checkpoint(&mut self, fetched: bool) -> Result<bool, Trouble> {
        if self.watch.is_alarmed() || !self.live.wants_checkpoint() {
            return Ok(fetched);
        }
        let mut fetched = fetched;
        if self.summed && self.watch.needs().sums() {
            self.sums = self.live.backend.sums()?;
            self.see(true);
            fetched = self.look(fetched)?;
            if self.watch.is_alarmed() {
                return Ok(fetched);
            }
        }
        self.fetch(fetched)?;
        self.script.scene.space = Some(self.live.backend.simulation_box().clone());
        self.live.write_checkpoint(self.script, &self.program);
        Ok(true)
    }

    /// Shows the sums of the current step, and particles as they were last fetched, to the thermo table and the dumps.
    fn show(&mut self, space: &SimulationBox, thermo_due: bool, dump_due: &[bool]) -> Result<(), Trouble> {
        self.script.scene.space = Some(space.clone());
        self.script.scene.step = self.now;
        if let Some(name) = self.sums.broken().filter(|_| thermo_due) {
            let mut what = format!("step {}: the {name} is beyond the range of numbers", self.now);
            let mut state = State::default();
            self.live.backend.fetch(&mut state)?;
            let fastest = (0..state.len()).max_by(|a, b| state.v[*a].amax().total_cmp(&state.v[*b].amax()));
            if let Some(k) = fastest {
                what += &format!(
                    "; the fastest is atom {} with velocity components up to {:e}",
                    state.id[k],
                    state.v[k].amax()
                );
            }
            return Err(Trouble::Broken(what));
        }
        let state = std::mem::take(&mut self.script.scene.state);
        let snapshot = Snapshot {
            step: self.now,
            first_step: self.first,
            last_step: self.last,
            timestep: self.program.timestep,
            state: &state,
            simulation_box: space,
            sums: &self.sums,
            neighbors: self.live.backend.statistics(),
            elapsed_seconds: self.started.elapsed().as_secs_f64(),
        };
        let range = (self.facts.counting_from.unwrap_or(self.first), self.stop);
        let shown = show(self.script, self.live, &snapshot, &self.facts, range, thermo_due, dump_due);
        self.script.scene.state = state;
        shown
    }
}

/// Tells the engine of rows that are ahead in a run, for which it may have to prepare.
pub fn announce(
    script: &ScriptState,
    live: &mut Live<'_>,
    program: &Program,
    schedule: ThermoSchedule,
    range: (i64, i64),
) -> Result<(), Error> {
    let rows = rows_of_sums(script, live, program, schedule, range);
    if rows > 1 {
        let outputs = (schedule.every as u64, rows as u64);
        live.backend.expect_outputs(outputs, script.thermo.needs())?;
    }
    Ok(())
}

/// Rows of the thermo table that are ahead before anyone wants to see anything else; 0 where they take more than sums.
fn rows_of_sums(
    script: &ScriptState,
    live: &Live<'_>,
    program: &Program,
    schedule: ThermoSchedule,
    (now, last): (i64, i64),
) -> i64 {
    let space = live.backend.simulation_box();
    // Rows count atoms and measure the box: both must stay what they are.
    if space.shrinks() || program.lost != LostAtoms::Error || !script.thermo.shows_sums_alone() {
        return 0;
    }
    let dumps = live.dumps.iter().filter_map(|(_, d)| d.next(now, last));
    schedule.evenly(now, dumps.chain([last]).min().unwrap_or(last))
}

/// A thermo row and the snapshots of the dumps that are due.
fn show(
    script: &mut ScriptState,
    live: &mut Live<'_>,
    snapshot: &Snapshot<'_>,
    facts: &SceneFacts,
    range: (i64, i64),
    thermo_due: bool,
    dump_due: &[bool],
) -> Result<(), Trouble> {
    if thermo_due {
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
