//! What each command does to the session, in both passes.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use super::environment::{AtRunStart, BetweenRuns, facts};
use super::run::{Outcome, RunError, run, steps};
use super::{DumpSetup, Live, ScriptState, data};
use crate::Error;
use crate::engine::StorageSort;
use crate::output::{Console, DumpObserver, Echo, SceneFacts, ThermoTable, check_writable, open_dump};
use crate::scene::builder::Messages;
use crate::script::command::{Command, FixCommand, LogCommand, NeighModifyCommand, PrintCommand};
use crate::script::{Complaint, Name, Statement};
use crate::system::LostAtoms;

/// Who carries a command out.
pub enum Pass<'a, 'b> {
    /// The script is judged: nothing runs, no file is written.
    Judging(&'a mut Console),
    Live(&'a mut Live<'b>),
}

impl Pass<'_, '_> {
    /// Whether files are written.
    fn writes(&self) -> bool {
        matches!(self, Pass::Live(live) if !live.settings.no_files)
    }

    fn console(&mut self) -> &mut Console {
        match self {
            Pass::Judging(console) => console,
            Pass::Live(live) => &mut live.console,
        }
    }
}

/// What follows a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Done {
    Next,
    Interrupted,
}

/// Carries a command out.
pub fn carry_out(
    script: &mut ScriptState,
    statement: &Statement,
    command: &Command,
    mut pass: Pass<'_, '_>,
) -> Result<Done, Error> {
    match command {
        Command::Run(command) => {
            let done = match pass {
                Pass::Judging(_) => script.judge_run(command).map(|()| Done::Next).map_err(RunError::Complaint),
                Pass::Live(live) => run(script, live, command).map(|outcome| match outcome {
                    Outcome::Finished => Done::Next,
                    Outcome::Interrupted => Done::Interrupted,
                }),
            };
            return done.map_err(|error| match error {
                RunError::Complaint(complaint) => statement.complain(complaint).into(),
                RunError::Error(error) => error,
            });
        }
        Command::ReadData(command) => {
            for line in data::read(script, statement, command)? {
                pass.console().line(&line);
            }
        }
        Command::WriteData(command) => {
            if let Pass::Live(live) = &pass {
                data::write(script, statement, command, !live.settings.no_files)?;
            } else {
                let path = command.path_at(script.scene.step);
                let writable = check_writable(&path).map_err(|m| Complaint::new(1, m));
                writable.map_err(|c| statement.complain(c))?;
                data::judge_write(script).map_err(|c| statement.complain(c))?;
            }
        }
        Command::PairWrite(command) => {
            let line = script.pair_write(command, pass.writes()).map_err(|c| statement.complain(c))?;
            line.into_iter().for_each(|line| pass.console().line(&line));
        }
        Command::Log(command) => log(command, pass.console()).map_err(|e| match e {
            Error::File { path, source, .. } => {
                let message = format!("cannot write '{}': {source}", path.display());
                statement.complain(Complaint::new(1, message)).into()
            }
            other => other,
        })?,
        Command::Undump(command) => {
            script.undump(&command.id).map_err(|c| statement.complain(c))?;
            if let Pass::Live(live) = pass {
                live.close_dump(&command.id.text)?;
            }
        }
        Command::DumpModify(command) => {
            script.modify_dump(command).map_err(|c| statement.complain(c))?;
            if let Pass::Live(live) = pass
                && let Some((_, open)) = live.dumps.iter_mut().find(|(id, _)| *id == command.id.text)
            {
                open.modify(command).map_err(|c| statement.complain(c))?;
            }
        }
        Command::Print(command) => {
            let writes = pass.writes();
            print(command, pass.console(), writes).map_err(|c| statement.complain(c))?;
        }
        Command::Echo(command) => {
            pass.console().set_echo(match (command.screen, command.log) {
                (false, false) => Echo::None,
                (true, false) => Echo::Screen,
                (false, true) => Echo::Log,
                (true, true) => Echo::Both,
            });
        }
        other => {
            let lines = script.apply(statement, other).map_err(|c| statement.complain(c))?;
            for line in lines {
                pass.console().message(&line);
            }
        }
    }
    Ok(Done::Next)
}

fn log(command: &LogCommand, console: &mut Console) -> Result<(), Error> {
    match &command.file {
        Some(file) => console.open_log(Path::new(&file.text), command.append),
        None => {
            console.close_log();
            Ok(())
        }
    }
}

fn print(command: &PrintCommand, console: &mut Console, live: bool) -> Result<(), Complaint> {
    if command.screen {
        console.line(&command.text)
    } else {
        console.log_only(&command.text)
    }
    let Some((file, append)) = &command.file else { return Ok(()) };
    if !live {
        return check_writable(&file.text).map_err(|m| Complaint::new(file.word, m));
    }
    let opened = OpenOptions::new().create(true).write(true).append(*append).truncate(!append).open(&file.text);
    let written = opened.and_then(|mut f| writeln!(f, "{}", command.text));
    written.map_err(|e| Complaint::new(file.word, format!("cannot write '{}': {e}", file.text)))
}

impl ScriptState {
    /// Commands that only change the scene, and what they print.
    fn apply(&mut self, statement: &Statement, command: &Command) -> Result<Messages, Complaint> {
        let scene = &mut self.scene;
        let nothing = Ok(Messages::new());
        // A run cannot go on without set-up where there are new atoms or other stages.
        let needs_set_up = matches!(
            command,
            Command::CreateAtoms(_)
                | Command::PairStyle(_)
                | Command::Fix(_)
                | Command::Unfix(_)
                | Command::AtomModify(_)
        );
        if needs_set_up {
            self.continues = false;
        }
        match command {
            Command::Units(c) => {
                scene.set_units(c.units)?;
                self.thermo = ThermoTable::new(&self.thermo_style, c.units);
                nothing
            }
            Command::AtomStyle(_) | Command::Dimension(_) => scene.before_box().and(nothing),
            Command::AtomModify(c) => {
                if let Some((every, bin)) = c.sort {
                    scene.storage_sort = (every > 0).then_some(StorageSort { every, bin });
                }
                nothing
            }
            Command::Boundary(c) => {
                scene.before_box()?;
                scene.sides = c.sides;
                nothing
            }
            Command::Newton(c) if c.pair => nothing,
            Command::Newton(_) => {
                Err(Complaint::new(1, "newton off is not part of octant, which has full lists anyway"))
            }
            Command::Lattice(c) => scene.lattice(c),
            Command::Region(c) => scene.region(c),
            Command::CreateBox(c) => scene.create_box(c),
            Command::CreateAtoms(c) => scene.create_atoms(c),
            Command::Mass(c) => scene.mass(c),
            Command::Group(c) => scene.group(c),
            Command::Velocity(c) => scene.velocity(c),
            Command::PairStyle(c) => self.pair_style(&c.style, &mut statement.args_from(c.style.word + 1)),
            Command::PairCoeff(c) => self.pair_coeff(c),
            Command::PairModify(c) => self.pair_modify(c),
            Command::Neighbor(c) => {
                scene.policy.skin = c.skin;
                nothing
            }
            Command::NeighModify(c) => self.neigh_modify(c),
            Command::Fix(FixCommand { id, group, style, .. }) => {
                let mut args = statement.args_from(style.word + 1);
                let messages = scene.fix(id, group, style, &mut args)?;
                self.fix_places.insert(id.text.clone(), statement.place());
                Ok(messages)
            }
            Command::Unfix(c) => scene.unfix(&c.id),
            Command::Timestep(c) => {
                scene.set_timestep(c.timestep);
                nothing
            }
            Command::ResetTimestep(c) => {
                if let Some(dump) = self.dumps.first() {
                    let message = format!("not while there are dumps ({}); undump them first", dump.command.id.text);
                    return Err(Complaint::new(0, message));
                }
                scene.reset_step(c.step, c.time);
                nothing
            }
            Command::Thermo(c) => {
                self.thermo_every = c.every;
                nothing
            }
            Command::ThermoStyle(c) => {
                scene.space()?;
                for (name, word) in ThermoTable::variables(c) {
                    if !self.interpreter.has_variable(name) {
                        return Err(Complaint::new(word, format!("undefined variable '{name}'")));
                    }
                }
                let forgets = self.thermo.is_modified();
                self.thermo = ThermoTable::new(c, scene.units);
                self.thermo_style = c.clone();
                scene.lost = LostAtoms::default();
                Ok(if forgets { vec!["WARNING: a new thermo_style forgets thermo_modify".into()] } else { vec![] })
            }
            Command::ThermoModify(c) => {
                self.thermo.modify(c)?;
                scene.lost = self.thermo.lost();
                nothing
            }
            Command::Dump(c) => {
                scene.space()?;
                let group = scene.groups.find(&c.group)?;
                if self.dumps.iter().any(|d| d.command.id == c.id) {
                    return Err(Complaint::new(c.id.word, format!("dump ID '{}' is in use", c.id.text)));
                }
                if let Some(other) = self.dumps.iter().find(|d| d.command.file.text == c.file.text) {
                    let message = format!("dump '{}' writes to '{}' already", other.command.id.text, c.file.text);
                    return Err(Complaint::new(c.file.word, message));
                }
                let setup = DumpSetup { command: c.clone(), changes: Vec::new(), group };
                setup.open(Arc::new(facts(scene)))?;
                self.dumps.push(setup);
                nothing
            }
            Command::Run(_)
            | Command::ReadData(_)
            | Command::WriteData(_)
            | Command::PairWrite(_)
            | Command::Log(_)
            | Command::Undump(_)
            | Command::DumpModify(_)
            | Command::Print(_)
            | Command::Echo(_) => nothing,
        }
    }

    /// Judges a run: everything it needs is there; time passes, nothing moves.
    fn judge_run(&mut self, command: &crate::script::command::RunCommand) -> Result<(), Complaint> {
        let (first, last) = steps(command, self.scene.step)?;
        self.scene.program(crate::neighbor::SearchPlan::default())?;
        self.judge_thermo_variables((command.start.unwrap_or(first), command.stop.unwrap_or(last)))?;
        self.scene.step = last;
        self.judged_run = true;
        Ok(())
    }

    /// Formulas of the thermo table must have values at the first step, as far as that can be told.
    fn judge_thermo_variables(&mut self, range: (i64, i64)) -> Result<(), Complaint> {
        let per_atom = self.thermo.norm();
        for (name, _) in ThermoTable::variables(&self.thermo_style) {
            let scene = BetweenRuns { scene: &self.scene, last_run: None, unknown: true, per_atom };
            let value = self.interpreter.variable_value(name, &mut AtRunStart { scene, range });
            value.map_err(|message| Complaint::new(0, format!("thermo column v_{name}: {message}")))?;
        }
        Ok(())
    }

    fn neigh_modify(&mut self, command: &NeighModifyCommand) -> Result<Messages, Complaint> {
        let policy = &mut self.scene.policy;
        if let Some(every) = command.every {
            policy.every = every.unsigned_abs();
        }
        if let Some(delay) = command.delay {
            policy.delay = delay.unsigned_abs();
        }
        policy.check = command.check.unwrap_or(policy.check);
        policy.once = command.once.unwrap_or(policy.once);
        Ok(Messages::new())
    }

    fn dump_place(&self, id: &Name) -> Result<usize, Complaint> {
        self.dumps.iter().position(|d| d.command.id.text == id.text).ok_or_else(|| {
            let known: Vec<_> = self.dumps.iter().map(|d| d.command.id.text.as_str()).collect();
            let known =
                if known.is_empty() { "there is none".into() } else { format!("defined: {}", known.join(", ")) };
            Complaint::new(id.word, format!("expected a dump ID, got '{}' ({known})", id.text))
        })
    }

    fn undump(&mut self, id: &Name) -> Result<(), Complaint> {
        let place = self.dump_place(id)?;
        self.dumps.remove(place);
        Ok(())
    }

    fn modify_dump(&mut self, command: &crate::script::command::dump::DumpModifyCommand) -> Result<(), Complaint> {
        let place = self.dump_place(&command.id)?;
        let mut changed = self.dumps[place].clone();
        changed.changes.push(command.clone());
        changed.open(Arc::new(facts(&self.scene)))?;
        self.dumps[place] = changed;
        Ok(())
    }
}

impl DumpSetup {
    /// Makes the dump with all its settings; its file is opened when a run begins.
    pub fn open(&self, facts: Arc<SceneFacts>) -> Result<Box<dyn DumpObserver>, Complaint> {
        let mut dump = open_dump(&self.command, self.group, facts)?;
        for change in &self.changes {
            dump.modify(change)?;
        }
        Ok(dump)
    }
}

impl Live<'_> {
    /// Closes a dump and remembers its file.
    fn close_dump(&mut self, id: &str) -> Result<(), Error> {
        if let Some(place) = self.dumps.iter().position(|(open, _)| open == id) {
            let (_, mut dump) = self.dumps.remove(place);
            let closed = dump.close();
            self.files.push(dump.report());
            closed?;
        }
        Ok(())
    }

    /// Closes all dumps; the first error is the one reported.
    pub fn close_dumps(&mut self) -> Result<(), Error> {
        let ids: Vec<String> = self.dumps.iter().map(|(id, _)| id.clone()).collect();
        let closed: Vec<_> = ids.iter().map(|id| self.close_dump(id)).collect();
        closed.into_iter().collect()
    }
}
