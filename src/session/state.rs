//! The script's side of a session, and the end of a run.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use super::environment::BetweenRuns;
use super::good_state::Checkpoints;
use super::run::Outcome;
use super::{Live, ScriptState, Settings};
use crate::Error;
use crate::engine::Backend;
use crate::output::{
    Console, MemoryReport, NeighborReport, Report, RunSummary, ThermoTable, TimingReport, wall_time_line,
};
use crate::scene::SceneBuilder;
use crate::script::command::thermo::ThermoStyleCommand;
use crate::script::{InputError, Interpreter, Source, Statement};

impl ScriptState {
    /// Nothing read yet.
    pub fn new(source: &Arc<Source>, settings: &Settings) -> Result<Self, InputError> {
        let scene = SceneBuilder::default();
        let thermo_style = ThermoStyleCommand::One;
        Ok(Self {
            interpreter: Interpreter::new(source.clone(), &settings.variables)?,
            thermo: ThermoTable::new(&thermo_style, scene.units),
            scene,
            thermo_every: 0,
            thermo_style,
            dumps: Vec::new(),
            fix_places: BTreeMap::new(),
            last_run: None,
            judged_run: false,
            continues: false,
        })
    }

    /// The next command of the script, with the simulation as it stands for its formulas.
    pub fn next(&mut self) -> Result<Option<Statement>, InputError> {
        let mut environment = BetweenRuns {
            scene: &self.scene,
            last_run: self.last_run.as_ref(),
            unknown: self.judged_run,
            per_atom: self.thermo.norm(),
        };
        self.interpreter.next(&mut environment)
    }
}

impl ScriptState {
    /// Dumps and the thermo table are as if no command had mentioned them; what becomes of lost atoms stays.
    pub fn forget_output(&mut self) {
        self.dumps.clear();
        (self.thermo_every, self.thermo_style) = (0, ThermoStyleCommand::One);
        self.thermo = ThermoTable::new(&self.thermo_style, self.scene.units);
    }
}

impl<'a> Live<'a> {
    /// Nothing carried out yet.
    pub fn new(
        settings: &'a Settings,
        console: Console,
        backend: Box<dyn Backend>,
        report: Report,
        started: Instant,
    ) -> Self {
        let (dumps, files, summary) = (Vec::new(), Vec::new(), None);
        Self {
            settings,
            console,
            backend,
            dumps,
            files,
            report,
            set_up_seconds: 0.0,
            summary,
            steps: 0,
            particles_step: 0,
            checkpoints: Checkpoints::default(),
            good: None,
            alarm: None,
            doubt: None,
            kept: false,
            started,
        }
    }
}

impl Live<'_> {
    /// Adds a run to the report; times add up over all runs.
    pub fn report_run(&mut self, summary: &RunSummary) {
        let before = self.report.timing;
        let mut stages = summary.stages;
        stages.add(&before.stages);
        self.steps += summary.steps;
        self.report.atoms = summary.atoms as u64;
        self.report.neighbors = NeighborReport::new(&summary.neighbors, self.backend.work(), summary.atoms);
        self.report.memory = MemoryReport::new(self.backend.bytes(), summary.atoms);
        self.report.timing = TimingReport::new(before.loop_s + summary.loop_seconds, self.steps, stages);
        self.summary = Some(summary.clone());
    }

    /// What is known of a run that stops: its neighbors and its memory.
    pub fn report_stop(&mut self, atoms: usize) {
        self.report.atoms = atoms as u64;
        self.report.neighbors = NeighborReport::new(&self.backend.statistics(), self.backend.work(), atoms);
        self.report.memory = MemoryReport::new(self.backend.bytes(), atoms);
    }

    /// The last lines: wall time, what was written and how fast; and the JSON report.
    pub fn finish(&mut self, outcome: Outcome) -> Result<(), Error> {
        if outcome == Outcome::Interrupted {
            self.console.line("Interrupted: the step was finished, all files are whole");
        }
        // Logs end with the wall time, as LAMMPS's do; the summary is for whoever sits at the screen.
        self.console.line(&wall_time_line(self.started.elapsed().as_secs_f64()));
        let timing = &self.report.timing;
        if self.steps > 0 {
            let rate = timing.steps_per_s * self.report.atoms as f64 / 1e6;
            let text = format!("{:.1} steps/s, {rate:.3} million atom-steps/s", timing.steps_per_s);
            self.console.screen_only(&format!("Ran {} steps of {} atoms: {text}", self.steps, self.report.atoms));
        }
        for file in &self.files {
            let size = indicatif::HumanBytes(file.bytes);
            self.console
                .screen_only(&format!("Wrote {}: {}, {} snapshots, {size}", file.path, file.format, file.frames));
        }
        if let Some(log) = self.console.log_path().map(|p| p.display().to_string()) {
            self.console.screen_only(&format!("Wrote {log}: log"));
        }
        self.console.flush();
        if let Some(fault) = self.console.take_fault() {
            return Err(fault);
        }
        self.write_report(None)
    }

    /// The JSON report, where it is asked for; of a run that came to an end by an error as well.
    pub fn write_report(&mut self, error: Option<String>) -> Result<(), Error> {
        let Some(path) = &self.settings.json else { return Ok(()) };
        self.report.files.clone_from(&self.files);
        self.report.warnings = self.console.warnings().to_vec();
        self.report.error = error;
        self.report.write(path)
    }
}
