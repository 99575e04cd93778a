//! Text dumps in LAMMPS's own formats: `atom`, `custom`, `xyz`.

use super::series::Series;
use super::{Cell, Frame, SnapshotWriter, WrittenFile};
use crate::Error;
use crate::engine::Needs;
use crate::output::columns::{Formats, Kind, column_index};
use crate::output::printf::{format_e, format_f, format_g};
use crate::output::{Console, Number, SceneFacts};
use crate::script::Complaint;
use crate::script::command::dump::{DumpChange, DumpColumn, DumpCommand, DumpStyle, SortBy};
use crate::script::command::number_format::FormatTarget;
use crate::system::{Side, SimulationBox};

/// LAMMPS's name of an atom whose type has none.
const NAMELESS: &str = "C";

enum Layout {
    /// ITEM sections, a table of columns; `atom` derives them from `scale` and `image`.
    Items,
    /// A count, a comment, then name and position.
    Xyz,
}

pub(super) struct TextWriter {
    style: DumpStyle,
    layout: Layout,
    columns: Vec<DumpColumn>,
    headers: Vec<String>,
    formats: Formats,
    scale: bool,
    image: bool,
    header: bool,
    time: bool,
    units: bool,
    elements: Option<Vec<String>>,
    series: Series,
}

impl TextWriter {
    pub fn new(command: &DumpCommand) -> Self {
        let (layout, columns) = match &command.style {
            DumpStyle::Custom(columns) => (Layout::Items, columns.clone()),
            DumpStyle::Xyz => {
                let position = (0..3).map(DumpColumn::Position);
                (Layout::Xyz, std::iter::once(DumpColumn::Element).chain(position).collect())
            }
            _ => (Layout::Items, Vec::new()),
        };
        let mut writer = Self {
            style: command.style.clone(),
            layout,
            columns,
            headers: Vec::new(),
            formats: Formats::default(),
            scale: true,
            image: false,
            header: true,
            time: false,
            units: false,
            elements: None,
            series: Series::new(&command.file.text),
        };
        writer.set_columns();
        writer
    }

    /// Columns of the `atom` style follow its settings; headers and formats start afresh.
    fn set_columns(&mut self) {
        if self.style == DumpStyle::Atom {
            let position = if self.scale { DumpColumn::Scaled } else { DumpColumn::Position };
            self.columns = vec![DumpColumn::Id, DumpColumn::Type];
            self.columns.extend((0..3).map(position));
            if self.image {
                self.columns.extend((0..3).map(DumpColumn::Image));
            }
        }
        self.headers = self.columns.iter().map(|column| column.name().to_string()).collect();
        self.formats = Formats::new(self.columns.len());
    }

    fn cell<'a>(&'a self, column: DumpColumn, frame: &Frame<'_>, atom: usize, kind_name: &'a str) -> Cell<'a> {
        let state = frame.snapshot.state;
        let lo = &frame.snapshot.simulation_box.lo;
        let scaled = |axis: usize| (frame.place(atom).0[axis] - lo[axis]) * frame.inverse[axis];
        let kind = state.kind[atom];
        let integer = |n: i64| Cell::Number(Number::Integer(n));
        let float = |x: f64| Cell::Number(Number::Float(x));
        match column {
            DumpColumn::Id => integer(state.id[atom].into()),
            DumpColumn::Type => integer(kind.into()),
            DumpColumn::Mass => float(frame.facts.mass(kind)),
            DumpColumn::Element => Cell::Text(kind_name),
            DumpColumn::Proc => integer(0),
            DumpColumn::ProcPlusOne => integer(1),
            DumpColumn::Position(axis) => float(frame.place(atom).0[axis]),
            DumpColumn::Scaled(axis) => float(scaled(axis)),
            DumpColumn::Unwrapped(axis) => float(frame.unwrapped(atom)[axis]),
            DumpColumn::ScaledUnwrapped(axis) => float(scaled(axis) + f64::from(frame.place(atom).1[axis])),
            DumpColumn::Image(axis) => integer(frame.place(atom).1[axis].into()),
            DumpColumn::Velocity(axis) => float(state.v[atom][axis]),
            DumpColumn::Force(axis) => float(state.f[atom][axis]),
        }
    }

    fn head(&self, frame: &Frame<'_>, out: &mut String) {
        let snapshot = frame.snapshot;
        let (step, count) = (snapshot.step, frame.atoms.len());
        let time = frame.facts.time(snapshot);
        match self.layout {
            Layout::Xyz => {
                let time = if self.time { format!(" Time: {}", format_f(time, 0, 6, false)) } else { String::new() };
                *out += &format!("{count}\n Atoms. Timestep: {step}{time}\n");
            }
            Layout::Items => {
                if self.units && self.series.begins_file() {
                    *out += &format!("ITEM: UNITS\n{}\n", frame.facts.units.name);
                }
                if self.time {
                    *out += &format!("ITEM: TIME\n{}\n", format_g(time, 0, 16, false));
                }
                *out += &format!("ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{count}\n");
                *out += &box_bounds(snapshot.simulation_box);
                *out += &format!("ITEM: ATOMS {}\n", self.headers.join(" "));
            }
        }
    }

    /// Names of the types as this dump shows them.
    fn names(&self, facts: &SceneFacts) -> Vec<String> {
        match (&self.elements, &self.layout) {
            (Some(names), _) => names.clone(),
            (None, Layout::Items) => vec![NAMELESS.to_string(); facts.types()],
            (None, Layout::Xyz) => (1..=facts.types()).map(|kind| kind.to_string()).collect(),
        }
    }
}

/// The ITEM of the box: the kind of each side and the bounds with all their digits.
fn box_bounds(simulation_box: &SimulationBox) -> String {
    let letter = |side: &Side| match side {
        Side::Periodic => 'p',
        Side::Fixed => 'f',
        Side::Shrink => 's',
    };
    let sides = simulation_box.sides.iter().map(|pair| pair.iter().map(letter).collect::<String>());
    let mut text = format!("ITEM: BOX BOUNDS {}\n", sides.collect::<Vec<_>>().join(" "));
    for axis in 0..3 {
        let bound = |x: f64| format_e(x, 0, 16, true);
        text += &format!("{} {}\n", bound(simulation_box.lo[axis]), bound(simulation_box.hi[axis]));
    }
    text
}

fn kind_of(column: DumpColumn) -> Kind {
    match column {
        DumpColumn::Id | DumpColumn::Type | DumpColumn::Proc | DumpColumn::ProcPlusOne | DumpColumn::Image(_) => {
            Kind::Integer
        }
        DumpColumn::Element => Kind::Text,
        _ => Kind::Float,
    }
}

impl SnapshotWriter for TextWriter {
    fn needs(&self) -> Needs {
        let forces = self.columns.iter().any(|column| matches!(column, DumpColumn::Force(_)));
        Needs { positions: true, forces, ..Needs::default() }
    }

    fn change(&mut self, change: &DumpChange, facts: &SceneFacts) -> Result<bool, Complaint> {
        let is_xyz = matches!(self.layout, Layout::Xyz);
        match change {
            DumpChange::Append(append) => self.series.append = *append,
            DumpChange::Flush(flush) => self.series.flush = *flush,
            DumpChange::MaxFiles(most) => self.series.max_files = *most,
            DumpChange::Pad(digits) => self.series.pad = *digits,
            DumpChange::Time(time) => self.time = *time,
            DumpChange::Units(units) => self.units = *units,
            DumpChange::Header(header) if !is_xyz => self.header = *header,
            DumpChange::Image(image) if self.style == DumpStyle::Atom => {
                self.image = *image;
                self.set_columns();
            }
            DumpChange::Scale(scale) if self.style == DumpStyle::Atom => {
                self.scale = *scale;
                self.set_columns();
            }
            DumpChange::Element(names) if self.style != DumpStyle::Atom => {
                if names.len() != facts.types() {
                    let why = format!("expected {} element names, one a type, got {}", facts.types(), names.len());
                    return Err(Complaint::new(0, why));
                }
                self.elements = Some(names.clone());
            }
            DumpChange::Format(format) => {
                if is_xyz && !matches!(format.target, FormatTarget::Line(_) | FormatTarget::None) {
                    return Err(Complaint::new(format.word, "dump style xyz takes format line or format none"));
                }
                let (headers, columns) = (&self.headers, self.columns.len());
                self.formats.change(format, |text| {
                    column_index(text, columns, |k| headers.get(k).cloned().unwrap_or_default())
                })?;
            }
            DumpChange::ColumnName(None) if !is_xyz => {
                self.headers = self.columns.iter().map(|column| column.name().to_string()).collect();
            }
            DumpChange::ColumnName(Some((column, name))) if !is_xyz => {
                let columns = &self.columns;
                let k = column_index(column, columns.len(), |k| columns[k].name().to_string())
                    .map_err(|why| Complaint::new(0, why))?;
                self.headers[k].clone_from(name);
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn check(&self, sort: SortBy) -> Result<(), String> {
        if let SortBy::Column(column) = sort {
            let columns = match self.layout {
                // LAMMPS counts id and type before the three coordinates.
                Layout::Xyz => 5,
                Layout::Items => self.columns.len(),
            };
            if column.unsigned_abs() > columns as u64 {
                return Err(format!("expected a column up to {columns}, got {column}"));
            }
        }
        let kinds: Vec<Kind> = self.columns.iter().map(|column| kind_of(*column)).collect();
        self.formats.check_kinds(&kinds, 0)
    }

    fn write(&mut self, frame: &Frame<'_>, _: &mut Console) -> Result<(), Error> {
        let mut out = String::with_capacity(frame.atoms.len().saturating_mul(12 * self.columns.len()));
        if self.header {
            self.head(frame, &mut out);
        }
        let names = self.names(frame.facts);
        let kinds: Vec<Kind> = self.columns.iter().map(|column| kind_of(*column)).collect();
        for &atom in &frame.atoms {
            let kind = frame.snapshot.state.kind[atom] as usize;
            let name = names.get(kind.wrapping_sub(1)).map_or(NAMELESS, String::as_str);
            for (k, column) in self.columns.iter().enumerate() {
                if k > 0 {
                    out.push(' ');
                }
                let chosen = self.formats.chosen(k, kinds[k]);
                match (self.cell(*column, frame, atom, name), chosen) {
                    (Cell::Number(Number::Integer(n)), Some(format)) => out += &format.integer(n),
                    (Cell::Number(Number::Integer(n)), None) => out += &n.to_string(),
                    (Cell::Number(Number::Float(x)), Some(format)) => out += &format.float(x),
                    (Cell::Number(Number::Float(x)), None) => out += &format_g(x, 0, 6, false),
                    (Cell::Text(text), Some(format)) => out += &format.text(text),
                    (Cell::Text(text), None) => out += text,
                }
            }
            out.push('\n');
        }
        self.series.write(frame.snapshot.step, out.as_bytes())
    }

    fn sort_value(&self, column: usize, frame: &Frame<'_>, atom: usize) -> f64 {
        let column = match self.layout {
            Layout::Items => self.columns.get(column).copied(),
            Layout::Xyz => match column {
                0 => Some(DumpColumn::Id),
                1 => Some(DumpColumn::Type),
                _ => Some(DumpColumn::Position((column - 2).min(2))),
            },
        };
        match column.map(|column| self.cell(column, frame, atom, "")) {
            Some(Cell::Number(number)) => number.value(),
            // Names sort as their types do.
            _ => f64::from(frame.snapshot.state.kind[atom]),
        }
    }

    fn open(&mut self) -> Result<(), Error> {
        self.series.open()
    }

    fn close(&mut self) -> Result<(), Error> {
        self.series.close()
    }

    fn report(&self) -> WrittenFile {
        WrittenFile {
            path: self.series.pattern().to_string(),
            format: self.style.name().to_string(),
            frames: self.series.frames(),
            bytes: self.series.bytes(),
        }
    }
}
