//! Dumps: snapshots of the atoms, written every so many steps (doc pages `dump`, `dump_modify`).
//!
//! A [`Dump`] decides when to write and which atoms in which order; a [`SnapshotWriter`] knows one file format.

mod series;
mod text;

use std::sync::Arc;

use super::facts::SceneFacts;
use super::quantities::Number;
use super::thermo::next_multiple;
use super::trajectory;
use super::{Console, check_writable};
use crate::Error;
use crate::engine::{Needs, Observer, Snapshot};
use crate::script::Complaint;
use crate::script::command::dump::{DumpChange, DumpCommand, DumpModifyCommand, DumpStyle, SortBy};
use crate::system::Vec3;

/// A file that a run wrote.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct WrittenFile {
    /// As named in the script.
    pub path: String,
    pub format: String,
    /// Snapshots in it, without those an appended file held before.
    pub frames: u64,
    pub bytes: u64,
}

/// A dump as the rest of the program sees it.
pub trait DumpObserver: Observer {
    /// `dump_modify`.
    fn modify(&mut self, command: &DumpModifyCommand) -> Result<(), Complaint>;
    /// Constants of the run that begins; to be called before every run.
    fn set_facts(&mut self, facts: Arc<SceneFacts>);
    /// To be called when a run begins, with its first step: opens the file where the format allows it before there is a
    /// snapshot.
    fn begin_run(&mut self, step: i64) -> Result<(), Error>;
    /// Completes the file. The dump may go on (and then appends); dropping a dump closes it too, silently.
    fn close(&mut self) -> Result<(), Error>;
    /// What has been written so far.
    fn report(&self) -> WrittenFile;
}

/// One file format.
pub(super) trait SnapshotWriter {
    /// What it writes of each atom.
    fn needs(&self) -> Needs;
    /// Takes over a setting; `Ok(false)` where the format has no such thing. The error is plain words.
    fn change(&mut self, change: &DumpChange, facts: &SceneFacts) -> Result<bool, Complaint>;
    /// Says what does not fit together after a `dump_modify`.
    fn check(&self, sort: SortBy) -> Result<(), String>;
    /// Writes one snapshot.
    fn write(&mut self, frame: &Frame<'_>, console: &mut Console) -> Result<(), Error>;
    /// The value that `sort COLUMN` (from 0) compares.
    fn sort_value(&self, column: usize, frame: &Frame<'_>, atom: usize) -> f64;
    /// Opens the file, if it can be opened without a snapshot.
    fn open(&mut self) -> Result<(), Error> {
        Ok(())
    }
    fn close(&mut self) -> Result<(), Error>;
    fn report(&self) -> WrittenFile;
}

/// The atoms of a snapshot to be written.
pub(super) struct Frame<'a> {
    pub snapshot: &'a Snapshot<'a>,
    pub facts: &'a SceneFacts,
    /// Storage indices, in the order of writing.
    pub atoms: Vec<usize>,
    /// 1 / edge lengths of the box.
    pub inverse: Vec3,
    /// Atoms are shown wrapped into the box.
    pub wraps: bool,
    /// Steps between snapshots; DCD files tell.
    #[cfg_attr(not(feature = "chemfiles"), expect(dead_code))]
    pub every: i64,
}

impl Frame<'_> {
    /// Position and periodic image of an atom, as to be shown.
    pub fn place(&self, atom: usize) -> (Vec3, [i32; 3]) {
        let (mut x, mut image) = (self.snapshot.state.x[atom], self.snapshot.state.image[atom]);
        if self.wraps {
            self.snapshot.simulation_box.wrap_once(&mut x, &mut image);
        }
        (x, image)
    }

    /// Position with periodic images undone.
    pub fn unwrapped(&self, atom: usize) -> Vec3 {
        let (x, image) = self.place(atom);
        self.snapshot.simulation_box.unwrap(&x, &image)
    }
}

/// A cell of a dump's table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cell<'a> {
    Number(Number),
    Text(&'a str),
}

struct Dump {
    style: &'static str,
    group_mask: u32,
    every: i64,
    first: bool,
    delay: Option<i64>,
    sort: SortBy,
    pbc: bool,
    last_written: Option<i64>,
    /// First step of the run; `first` means a set-up.
    run_start: Option<i64>,
    facts: Arc<SceneFacts>,
    writer: Box<dyn SnapshotWriter>,
}

/// Makes the dump of a `dump` command for the atoms of a group (bits of `State::mask`). Judges only: the file is opened
/// when a run begins.
pub fn open_dump(
    command: &DumpCommand,
    group_mask: u32,
    facts: Arc<SceneFacts>,
) -> Result<Box<dyn DumpObserver>, Complaint> {
    let path = &command.file;
    // One file a snapshot: the star stands for the step.
    let judged = path.text.replace('*', "0");
    check_writable(&judged).map_err(|why| Complaint::new(path.word, why))?;
    let writer: Box<dyn SnapshotWriter> = match &command.style {
        DumpStyle::Atom | DumpStyle::Custom(_) | DumpStyle::Xyz => Box::new(text::TextWriter::new(command)),
        DumpStyle::Dcd | DumpStyle::Xtc | DumpStyle::Netcdf(_) | DumpStyle::Chemfiles { .. } => {
            trajectory::writer(command, &facts)?
        }
    };
    // LAMMPS's defaults; most other formats have no room for ids.
    let by_id = !matches!(command.style, DumpStyle::Atom | DumpStyle::Custom(_));
    Ok(Box::new(Dump {
        style: command.style.name(),
        group_mask,
        every: command.every,
        first: false,
        delay: None,
        sort: if by_id { SortBy::Id } else { SortBy::Off },
        pbc: false,
        last_written: None,
        run_start: None,
        facts,
        writer,
    }))
}

/// Runs of this length are sorted first, then merged.
const RUN: usize = 64;

/// Sorts as LAMMPS does, whose order of equal elements is seen in its dumps: stable in runs of 64, but in a merge of two
/// neighboring runs the elements of the later run come first among equals.
fn merge_sort<T: Copy>(values: &mut Vec<T>, less: impl Fn(&T, &T) -> bool) {
    use std::cmp::Ordering::{Equal, Greater, Less};
    let order = |a: &T, b: &T| {
        if less(a, b) {
            Less
        } else if less(b, a) {
            Greater
        } else {
            Equal
        }
    };
    values.chunks_mut(RUN).for_each(|run| run.sort_by(order));
    let mut length = RUN;
    while length < values.len() {
        let mut merged = Vec::with_capacity(values.len());
        for pair in values.chunks(2 * length) {
            let (mut left, mut right) = pair.split_at(length.min(pair.len()));
            while let ([a, rest_left @ ..], [b, rest_right @ ..]) = (left, right) {
                if less(a, b) {
                    merged.push(*a);
                    left = rest_left;
                } else {
                    merged.push(*b);
                    right = rest_right;
                }
            }
            merged.extend_from_slice(left);
            merged.extend_from_slice(right);
        }
        *values = merged;
        length *= 2;
    }
}

/// The atoms of a group in the order asked for.
fn ordered(frame: &Frame<'_>, group_mask: u32, sort: SortBy, writer: &dyn SnapshotWriter) -> Vec<usize> {
    let state = frame.snapshot.state;
    let mut atoms: Vec<usize> = (0..state.len()).filter(|&k| state.mask[k] & group_mask != 0).collect();
    match sort {
        SortBy::Off => (),
        SortBy::Id => atoms.sort_unstable_by_key(|&k| state.id[k]),
        SortBy::Column(column) => {
            let index = usize::try_from(column.unsigned_abs()).unwrap_or(usize::MAX).saturating_sub(1);
            let mut keyed: Vec<(f64, usize)> = atoms.iter().map(|&k| (writer.sort_value(index, frame, k), k)).collect();
            let sign = if column > 0 { 1.0 } else { -1.0 };
            merge_sort(&mut keyed, |a, b| sign * a.0 < sign * b.0);
            atoms = keyed.into_iter().map(|(_, k)| k).collect();
        }
    }
    atoms
}

impl Observer for Dump {
    fn next(&self, after: i64, last: i64) -> Option<i64> {
        // A run's set-up asks from the step before its first: a step that the run before has already written is skipped.
        let after = self.last_written.map_or(after, |written| after.max(written));
        let begins = self.first && self.last_written.is_none() && after.checked_add(1) == self.run_start;
        let next = match self.delay {
            // A delay wins over `first`.
            Some(delay) if after < delay.saturating_sub(1) => next_multiple(delay - 1, self.every),
            _ if begins => after.checked_add(1),
            _ => next_multiple(after, self.every),
        };
        next.filter(|step| *step <= last)
    }

    fn needs(&self) -> Needs {
        self.writer.needs()
    }

    fn observe(&mut self, snapshot: &Snapshot<'_>, console: &mut Console) -> Result<(), Error> {
        let lengths = snapshot.simulation_box.lengths();
        let inverse = Vec3::new(1.0 / lengths.x, 1.0 / lengths.y, 1.0 / lengths.z);
        let (facts, atoms, every) = (&*self.facts, Vec::new(), self.every);
        let mut frame = Frame { snapshot, facts, atoms, inverse, wraps: self.pbc, every };
        frame.atoms = ordered(&frame, self.group_mask, self.sort, &*self.writer);
        self.writer.write(&frame, console)?;
        self.last_written = Some(snapshot.step);
        Ok(())
    }
}

impl DumpObserver for Dump {
    fn modify(&mut self, command: &DumpModifyCommand) -> Result<(), Complaint> {
        for setting in &command.settings {
            match &setting.change {
                DumpChange::Every(every) => self.every = *every,
                DumpChange::First(first) => self.first = *first,
                DumpChange::Delay(delay) => self.delay = *delay,
                DumpChange::Sort(sort) => self.sort = *sort,
                DumpChange::Pbc(pbc) => self.pbc = *pbc,
                change => {
                    let known = self.writer.change(change, &self.facts).map_err(|complaint| match complaint.word {
                        // The writer speaks of the setting as a whole.
                        0 => Complaint { word: setting.word, ..complaint },
                        _ => complaint,
                    })?;
                    if !known {
                        let why = format!("dump style {} has no such setting", self.style);
                        return Err(Complaint::new(setting.word, why));
                    }
                }
            }
            self.writer.check(self.sort).map_err(|why| Complaint::new(setting.word, why))?;
        }
        Ok(())
    }

    fn set_facts(&mut self, facts: Arc<SceneFacts>) {
        self.facts = facts;
    }

    fn begin_run(&mut self, step: i64) -> Result<(), Error> {
        self.run_start = Some(step);
        // LAMMPS takes a snapshot that is due at a set-up but delayed for written: `first` has had its chance.
        let due = (self.first && self.last_written.is_none()) || (self.every > 0 && step % self.every == 0);
        if due && self.delay.is_some_and(|delay| step < delay) {
            self.last_written = Some(step);
        }
        self.writer.open()
    }

    fn close(&mut self) -> Result<(), Error> {
        self.writer.close()
    }

    fn report(&self) -> WrittenFile {
        self.writer.report()
    }
}

impl Drop for Dump {
    fn drop(&mut self) {
        // Errors here have nobody to go to; who wants them calls `close`.
        let _ = self.writer.close();
    }
}

#[cfg(test)]
pub(super) mod tests;
