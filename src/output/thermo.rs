//! The thermo table: columns, layouts and formats of `thermo_style` and `thermo_modify` (doc pages of those names).

use serde_json::{Map, Value};

use super::columns::{Formats, column_index};
use super::printf::Printf;
use super::quantities::{Number, Quantities, keyword};
use crate::engine::Needs;
use crate::script::Complaint;
use crate::script::command::thermo::{ThermoColumn, ThermoLine, ThermoModifyCommand, ThermoSource, ThermoStyleCommand};
use crate::system::{LostAtoms, Units};

const ONE: &[&str] = &["step", "temp", "epair", "emol", "etotal", "press"];
const MULTI: &[&str] =
    &["etotal", "ke", "temp", "pe", "ebond", "eangle", "edihed", "eimp", "evdwl", "ecoul", "elong", "press"];
/// LAMMPS puts the step first in its YAML table.
const YAML: &[&str] =
    &["step", "temp", "ke", "pe", "ebond", "eangle", "edihed", "eimp", "evdwl", "ecoul", "elong", "press"];

/// How LAMMPS prints integers and floating-point values in each layout, in C's words.
fn default_formats(line: ThermoLine) -> Result<(Printf, Printf), String> {
    let (integer, float) = match line {
        ThermoLine::One => ("%10d ", "% -14.8g"),
        ThermoLine::Multi => ("%14d", "%14.4f"),
        ThermoLine::Yaml => ("%d", "%.15g"),
    };
    Ok((Printf::parse(integer)?, Printf::parse(float)?))
}

/// One column of the table.
#[derive(Clone, Debug)]
struct Column {
    source: ThermoSource,
    header: String,
    integer: bool,
}

/// The values of one row.
#[derive(Clone, Debug, PartialEq)]
pub struct ThermoRow {
    pub step: i64,
    /// Wall seconds of the run so far.
    pub cpu: f64,
    /// One value a column.
    pub values: Vec<Number>,
}

/// What a thermo table shows and how.
#[derive(Clone, Debug)]
pub struct ThermoTable {
    /// `one` or `multi`, whose columns depend on whether the box changes; not of one's own choice.
    standard: bool,
    columns: Vec<Column>,
    line: ThermoLine,
    formats: Formats,
    norm: bool,
    flush: bool,
    lost: LostAtoms,
    modified: bool,
    /// Wall seconds and simulated time and step of the row before, for `tpcpu` and `spcpu`.
    previous: Option<(f64, f64, i64)>,
}

impl ThermoTable {
    /// A table with the defaults of a unit system. LAMMPS, too, forgets `thermo_modify` at a new `thermo_style`.
    pub fn new(style: &ThermoStyleCommand, units: &Units) -> Self {
        let (line, names, standard): (_, &[&str], _) = match style {
            ThermoStyleCommand::One => (ThermoLine::One, ONE, true),
            ThermoStyleCommand::Multi => (ThermoLine::Multi, MULTI, true),
            ThermoStyleCommand::Yaml => (ThermoLine::Yaml, YAML, true),
            ThermoStyleCommand::Custom(_) => (ThermoLine::One, &[], false),
        };
        let mut columns: Vec<Column> = names.iter().filter_map(|name| Column::of_keyword(name)).collect();
        if let ThermoStyleCommand::Custom(custom) = style {
            columns.extend(custom.iter().map(Column::new));
        }
        let formats = Formats::new(columns.len());
        let (norm, flush, lost) = (units.per_atom, false, LostAtoms::default());
        Self { standard, columns, line, formats, norm, flush, lost, modified: false, previous: None }
    }

    /// `thermo_modify`. Nothing is changed when there is a complaint.
    pub fn modify(&mut self, command: &ThermoModifyCommand) -> Result<(), Complaint> {
        let mut formats = self.formats.clone();
        let mut headers: Vec<String> = self.columns.iter().map(|column| column.header.clone()).collect();
        let find = |text: &str| column_index(text, self.columns.len(), |k| self.columns[k].name());
        for (word, change) in &command.names {
            match change {
                None => headers = self.columns.iter().map(|column| default_header(&column.source)).collect(),
                Some((column, header)) => {
                    let k = find(column).map_err(|why| Complaint::new(*word, why))?;
                    headers[k].clone_from(header);
                }
            }
        }
        for change in &command.formats {
            formats.change(change, find)?;
            let kinds: Vec<bool> = self.columns.iter().map(|column| column.integer).collect();
            // `one` and `multi` gain a volume column where the box changes; a line of formats may count it.
            formats.check(&kinds, usize::from(self.standard)).map_err(|why| Complaint::new(change.word, why))?;
        }
        self.formats = formats;
        for (column, header) in self.columns.iter_mut().zip(headers) {
            column.header = header;
        }
        self.norm = command.norm.unwrap_or(self.norm);
        self.flush = command.flush.unwrap_or(self.flush);
        self.lost = command.lost.unwrap_or(self.lost);
        self.line = command.line.unwrap_or(self.line);
        self.modified = true;
        Ok(())
    }

    /// To be called when a run begins: `one` and `multi` show the volume where the box changes (shrink-wrapped sides).
    pub fn start_run(&mut self, box_changes: bool) {
        self.previous = None;
        if self.standard {
            let shows = self.columns.last().is_some_and(|column| column.source == ThermoSource::Keyword("vol"));
            match (shows, box_changes) {
                (false, true) => self.columns.extend(Column::of_keyword("vol")),
                (true, false) => drop(self.columns.pop()),
                _ => (),
            }
        }
    }

    /// Some `thermo_modify` would be forgotten by a new `thermo_style`; LAMMPS warns then.
    pub fn is_modified(&self) -> bool {
        self.modified
    }

    /// Extensive values per atom.
    pub fn norm(&self) -> bool {
        self.norm
    }

    /// The log is flushed after every row.
    pub fn flush(&self) -> bool {
        self.flush
    }

    /// What to do when atoms are lost.
    pub fn lost(&self) -> LostAtoms {
        self.lost
    }

    /// Names of the variables that columns show, to be checked when the script is judged; with their words.
    pub fn variables(style: &ThermoStyleCommand) -> Vec<(&str, usize)> {
        let ThermoStyleCommand::Custom(columns) = style else { return Vec::new() };
        columns
            .iter()
            .filter_map(|column| match &column.source {
                ThermoSource::Variable(name) => Some((name.as_str(), column.word)),
                ThermoSource::Keyword(_) => None,
            })
            .collect()
    }

    /// What the columns need computed. A variable may ask for anything that is summed.
    pub fn needs(&self) -> Needs {
        self.columns.iter().fold(Needs::default(), |needs, column| {
            needs.union(match &column.source {
                ThermoSource::Keyword(name) => keyword(name).map_or(Needs::default(), |info| info.needs),
                ThermoSource::Variable(_) => {
                    Needs { energy: true, virial: true, pressure: true, positions: true, forces: true }
                }
            })
        })
    }

    /// Whether a row can be made of sums alone after its step has passed: it shows no particles, no wall time and no counts of
    /// list builds so far.
    pub fn shows_sums_alone(&self) -> bool {
        let needs = self.needs();
        let of_run = self.columns.iter().any(|column| match &column.source {
            ThermoSource::Keyword(name) => keyword(name).is_none_or(|info| info.of_run),
            ThermoSource::Variable(_) => true,
        });
        // The title of a row of several lines tells the wall time.
        !needs.positions && !needs.forces && !of_run && self.line != ThermoLine::Multi
    }

    /// Headers as the table prints them, which are the keys of [`ThermoTable::json`].
    pub fn headers(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| column.header.as_str())
    }

    /// Lines above the first row.
    pub fn header(&self) -> Vec<String> {
        match self.line {
            ThermoLine::One => {
                let cells = self.columns.iter().map(|column| {
                    let width = if column.integer { 11 } else { 14 };
                    format!("{:^width$}", column.header)
                });
                vec![cells.collect::<Vec<_>>().join(" ")]
            }
            ThermoLine::Multi => Vec::new(),
            ThermoLine::Yaml => {
                let names: String = self.headers().map(|header| format!("'{header}', ")).collect();
                vec!["---".into(), format!("keywords: [{names}]"), "data:".into()]
            }
        }
    }

    /// Lines below the last row.
    pub fn footer(&self) -> Vec<String> {
        match self.line {
            ThermoLine::Yaml => vec!["...".into()],
            ThermoLine::One | ThermoLine::Multi => Vec::new(),
        }
    }

    /// Evaluates the columns; `variables` gives the value of an equal-style variable by name.
    pub fn row(
        &mut self,
        quantities: &Quantities<'_>,
        variables: &mut dyn FnMut(&str) -> Result<f64, String>,
    ) -> Result<ThermoRow, String> {
        let (cpu, time, step) = (quantities.cpu(), quantities.time(), quantities.snapshot().step);
        let (cpu_before, time_before, step_before) = self.previous.unwrap_or((cpu, time, step));
        let per_second = |amount: f64| {
            let seconds = cpu - cpu_before;
            Number::Float(if seconds > 0.0 { amount / seconds } else { 0.0 })
        };
        let value = |column: &Column| match &column.source {
            ThermoSource::Keyword("tpcpu") => Ok(per_second(time - time_before)),
            ThermoSource::Keyword("spcpu") => Ok(per_second((step - step_before) as f64)),
            ThermoSource::Keyword(name) => {
                quantities.lookup(name).ok_or_else(|| format!("thermo keyword '{name}' has no value"))
            }
            ThermoSource::Variable(name) => variables(name).map(Number::Float),
        };
        let values = self.columns.iter().map(value).collect::<Result<_, _>>()?;
        self.previous = Some((cpu, time, step));
        Ok(ThermoRow { step, cpu, values })
    }

    /// A row as printed (several lines in `multi`).
    pub fn text(&self, row: &ThermoRow) -> Result<String, String> {
        let (integer, float) = default_formats(self.line)?;
        let cells = row.values.iter().enumerate().map(|(k, value)| self.formats.number(k, *value, &integer, &float));
        Ok(match self.line {
            ThermoLine::One => cells.collect::<Vec<_>>().join(" "),
            ThermoLine::Yaml => {
                let cells: String = cells.map(|cell| format!("{cell}, ")).collect();
                format!("  - [{cells}]")
            }
            ThermoLine::Multi => {
                let cpu = super::printf::format_g(row.cpu, 12, 7, false);
                let title = format!("------------ Step {:14} ----- CPU = {cpu} (sec) -------------", row.step);
                let pairs: Vec<String> =
                    self.headers().zip(cells).map(|(h, cell)| format!("{h:<8} = {cell}")).collect();
                let lines: Vec<String> = pairs.chunks(3).map(|three| three.join(" ")).collect();
                // Full lines end in the blank that would part them from the next value.
                format!("{title}\n{}", lines.join(" \n"))
            }
        })
    }

    /// A row as numbers by header; what is not finite becomes null.
    pub fn json(&self, row: &ThermoRow) -> Map<String, Value> {
        let value = |number: &Number| match number {
            Number::Integer(n) => Value::from(*n),
            Number::Float(x) => Value::from(*x),
        };
        self.headers().map(str::to_string).zip(row.values.iter().map(value)).collect()
    }
}

impl Column {
    fn new(column: &ThermoColumn) -> Self {
        let integer = match &column.source {
            ThermoSource::Keyword(name) => keyword(name).is_some_and(|info| info.integer),
            ThermoSource::Variable(_) => false,
        };
        Self { source: column.source.clone(), header: default_header(&column.source), integer }
    }

    fn of_keyword(name: &str) -> Option<Self> {
        let info = keyword(name)?;
        let source = ThermoSource::Keyword(info.name);
        Some(Self { source, header: info.header.to_string(), integer: info.integer })
    }

    /// As the column is called in `thermo_style custom`.
    fn name(&self) -> String {
        match &self.source {
            ThermoSource::Keyword(name) => (*name).to_string(),
            ThermoSource::Variable(name) => format!("v_{name}"),
        }
    }
}

fn default_header(source: &ThermoSource) -> String {
    match source {
        ThermoSource::Keyword(name) => keyword(name).map_or(*name, |info| info.header).to_string(),
        ThermoSource::Variable(name) => format!("v_{name}"),
    }
}

/// Which steps have a row: the first and the last of every run and the multiples of `every` (if not 0) between.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ThermoSchedule {
    pub every: i64,
    /// First step of the run.
    pub first: i64,
}

impl ThermoSchedule {
    /// The first step after `after` that has a row, in a run that ends at `last`.
    pub fn next(&self, after: i64, last: i64) -> Option<i64> {
        if after < self.first {
            return Some(self.first);
        }
        if after >= last {
            return None;
        }
        Some(next_multiple(after, self.every).map_or(last, |step| step.min(last)))
    }

    /// How many rows there are after `after` and before `end`, if all of them and `after` are evenly spaced; otherwise 0.
    pub fn evenly(&self, after: i64, end: i64) -> i64 {
        let even = self.every > 0 && after >= self.first && after % self.every == 0;
        if even && end > after { (end - 1 - after) / self.every } else { 0 }
    }
}

/// The first multiple of `every` after `after`; none if `every` is 0 or the answer too large.
pub(crate) fn next_multiple(after: i64, every: i64) -> Option<i64> {
    if every <= 0 { None } else { after.checked_sub(after.rem_euclid(every))?.checked_add(every) }
}

/// The line above the column headers, by which log readers find the table. Memory in bytes.
pub fn memory_line(bytes: u64) -> String {
    let mbytes = super::printf::format_g(bytes as f64 / 1024.0 / 1024.0, 0, 4, false);
    format!("Per MPI rank memory allocation (min/avg/max) = {mbytes} | {mbytes} | {mbytes} Mbytes")
}

#[cfg(test)]
#[path = "thermo_tests.rs"]
mod tests;
