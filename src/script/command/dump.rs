//! `dump`, `dump_modify`, `undump` (doc pages of those names).

use super::number_format::{ColumnName, FormatChange, column_name};
use super::{Args, Complaint};
use crate::script::Name;

/// `dump ID group style N file ...`.
#[derive(Clone, Debug, PartialEq)]
pub struct DumpCommand {
    pub id: Name,
    pub group: Name,
    /// Snapshots are written at steps that are multiples of this.
    pub every: i64,
    pub file: Name,
    pub style: DumpStyle,
    /// Index of the style's word, for complaints.
    pub style_word: usize,
}

/// What a dump writes.
#[derive(Clone, Debug, PartialEq)]
pub enum DumpStyle {
    Atom,
    Custom(Vec<DumpColumn>),
    Xyz,
    Dcd,
    Xtc,
    Netcdf(Vec<DumpColumn>),
    /// Ours: any format that chemfiles writes, by the file's extension or by name.
    Chemfiles {
        format: Option<Name>,
    },
}

impl DumpStyle {
    /// Name in the `dump` command.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Atom => "atom",
            Self::Custom(_) => "custom",
            Self::Xyz => "xyz",
            Self::Dcd => "dcd",
            Self::Xtc => "xtc",
            Self::Netcdf(_) => "netcdf",
            Self::Chemfiles { .. } => "chemfiles",
        }
    }
}

/// A column of `dump custom`; axes are 0, 1, 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DumpColumn {
    Id,
    Type,
    Mass,
    Element,
    /// Always 0: there is one process.
    Proc,
    /// Always 1.
    ProcPlusOne,
    /// `x`: position as it is.
    Position(usize),
    /// `xs`: as a fraction of the box.
    Scaled(usize),
    /// `xu`: periodic images undone.
    Unwrapped(usize),
    /// `xsu`: both.
    ScaledUnwrapped(usize),
    /// `ix`: periodic image.
    Image(usize),
    /// `vx`.
    Velocity(usize),
    /// `fx`.
    Force(usize),
}

/// Every column by name.
#[rustfmt::skip]
pub const DUMP_COLUMNS: &[(&str, DumpColumn)] = &[
    ("id", DumpColumn::Id), ("type", DumpColumn::Type), ("mass", DumpColumn::Mass), ("element", DumpColumn::Element),
    ("proc", DumpColumn::Proc), ("procp1", DumpColumn::ProcPlusOne),
    ("x", DumpColumn::Position(0)), ("y", DumpColumn::Position(1)), ("z", DumpColumn::Position(2)),
    ("xs", DumpColumn::Scaled(0)), ("ys", DumpColumn::Scaled(1)), ("zs", DumpColumn::Scaled(2)),
    ("xu", DumpColumn::Unwrapped(0)), ("yu", DumpColumn::Unwrapped(1)), ("zu", DumpColumn::Unwrapped(2)),
    ("xsu", DumpColumn::ScaledUnwrapped(0)), ("ysu", DumpColumn::ScaledUnwrapped(1)), ("zsu", DumpColumn::ScaledUnwrapped(2)),
    ("ix", DumpColumn::Image(0)), ("iy", DumpColumn::Image(1)), ("iz", DumpColumn::Image(2)),
    ("vx", DumpColumn::Velocity(0)), ("vy", DumpColumn::Velocity(1)), ("vz", DumpColumn::Velocity(2)),
    ("fx", DumpColumn::Force(0)), ("fy", DumpColumn::Force(1)), ("fz", DumpColumn::Force(2)),
];

impl DumpColumn {
    /// Name in the `dump` command, which is its header too.
    pub fn name(self) -> &'static str {
        DUMP_COLUMNS.iter().find(|(_, column)| *column == self).map_or("", |(name, _)| name)
    }
}

const STYLES: &[&str] = &["atom", "custom", "xyz", "dcd", "xtc", "netcdf", "chemfiles"];
/// Styles of LAMMPS that octant lacks, so that messages can say so.
#[rustfmt::skip]
const MISSING_STYLES: &[&str] = &[
    "adios", "cfg", "custom/adios", "custom/gz", "custom/mpiio", "custom/zstd", "atom/gz", "atom/zstd", "atom/adios",
    "cfg/gz", "cfg/zstd", "cfg/uef", "extxyz", "grid", "grid/vtk", "h5md", "image", "local", "local/gz", "local/zstd",
    "molfile", "movie", "netcdf/mpiio", "vtk", "xyz/gz", "xyz/zstd", "yaml",
];

impl DumpCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let id = args.name("a dump ID")?;
        let group = args.name("a group")?;
        let style_word = args.position();
        let style = args.text("a dump style")?;
        if !STYLES.contains(&style) {
            let known = if MISSING_STYLES.contains(&style) { "" } else { " (nor known)" };
            let why = format!("dump style '{style}' is not part of octant{known}; available: {}", STYLES.join(", "));
            return Err(Complaint::new(style_word, why));
        }
        let every = args.integer("the number of steps between snapshots", 1)?;
        let file = args.name("a file name")?;
        check_file_name(&file, style)?;
        let style = match style {
            "atom" => DumpStyle::Atom,
            "xyz" => DumpStyle::Xyz,
            "dcd" => DumpStyle::Dcd,
            "xtc" => DumpStyle::Xtc,
            "custom" => DumpStyle::Custom(columns(args)?),
            "netcdf" => DumpStyle::Netcdf(columns(args)?),
            _ => DumpStyle::Chemfiles {
                format: match args.peek() {
                    Some("format") => {
                        args.text("format")?;
                        Some(args.name("the name of a chemfiles format")?)
                    }
                    _ => None,
                },
            },
        };
        args.done()?;
        Ok(Self { id, group, every, file, style, style_word })
    }
}

fn check_file_name(file: &Name, style: &str) -> Result<(), Complaint> {
    let text = &file.text;
    let complaint = |why: String| Err(Complaint::new(file.word, why));
    if text.contains('%') {
        return complaint(format!("one file a process ('%' in '{text}') is not part of octant"));
    }
    let native = matches!(style, "atom" | "custom" | "xyz");
    if native {
        for ending in [".gz", ".bz2", ".zst", ".xz", ".lzma", ".lz4"] {
            if text.ends_with(ending) {
                return complaint(format!("compressed dumps ('{ending}') are not part of octant"));
            }
        }
        if text.ends_with(".bin") || text.ends_with(".lammpsbin") {
            return complaint(format!("binary dumps ('{text}') are not part of octant"));
        }
        if text.matches('*').count() > 1 {
            return complaint(format!("expected at most one '*' in the file name, got '{text}'"));
        }
    } else if text.contains('*') {
        return complaint(format!("dump style {style} writes one file, got '*' in '{text}'"));
    }
    Ok(())
}

fn columns(args: &mut Args<'_>) -> Result<Vec<DumpColumn>, Complaint> {
    let mut columns = vec![dump_column(args)?];
    while args.left() > 0 {
        columns.push(dump_column(args)?);
    }
    Ok(columns)
}

fn dump_column(args: &mut Args<'_>) -> Result<DumpColumn, Complaint> {
    let word = args.position();
    let text = args.text("a column")?;
    if let Some((_, column)) = DUMP_COLUMNS.iter().find(|(name, _)| *name == text) {
        return Ok(*column);
    }
    let what = match text.get(..2) {
        Some("c_" | "C_") => "computes",
        Some("f_" | "F_") => "values of fixes",
        Some("v_") => "atom-style variables",
        Some("i_" | "d_" | "i2" | "d2") if text.contains('_') => "custom atom properties",
        _ if matches!(
            text,
            "mol"
                | "q"
                | "mux"
                | "muy"
                | "muz"
                | "mu"
                | "radius"
                | "diameter"
                | "typelabel"
                | "heatflow"
                | "temperature"
        ) || text.starts_with("omega")
            || text.starts_with("angmom")
            || text.starts_with("tq") =>
        {
            "atom properties beyond atom_style atomic"
        }
        _ => {
            let names: Vec<&str> = DUMP_COLUMNS.iter().map(|(name, _)| *name).collect();
            let why = format!("unknown column '{text}'");
            return Err(Complaint::new(word, why).with_help(format!("columns: {}", names.join(" "))));
        }
    };
    Err(Complaint::new(word, format!("{what} ('{text}') are not part of octant")))
}

/// The order of atoms in a snapshot (`dump_modify sort`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SortBy {
    /// As stored.
    Off,
    /// By id.
    Id,
    /// By a column, from 1; descending if negative.
    Column(i64),
}

/// One `dump_modify` setting and the word that names it.
#[derive(Clone, Debug, PartialEq)]
pub struct DumpSetting {
    pub word: usize,
    pub change: DumpChange,
}

/// What `dump_modify` can change.
#[derive(Clone, Debug, PartialEq)]
pub enum DumpChange {
    Append(bool),
    ColumnName(ColumnName),
    /// No snapshot before this step; `None` for no such bound.
    Delay(Option<i64>),
    /// One name a type.
    Element(Vec<String>),
    Every(i64),
    /// A snapshot at the first step of the next run, whatever it is.
    First(bool),
    Flush(bool),
    Format(FormatChange),
    /// `header no`: no ITEM lines.
    Header(bool),
    /// Image counts as columns (atom style).
    Image(bool),
    /// Oldest of several files are deleted beyond this number; `None` keeps all.
    MaxFiles(Option<usize>),
    /// Digits of the step in a file name with `*`.
    Pad(usize),
    /// Atoms are wrapped into the box for the dump.
    Pbc(bool),
    /// Scaled coordinates (atom style).
    Scale(bool),
    Sort(SortBy),
    /// Simulated time in each snapshot.
    Time(bool),
    /// The unit system in each file.
    Units(bool),
    /// Positions with periodic images undone (dcd, xtc, chemfiles).
    Unwrap(bool),
    /// Steps of 1 / precision nm (xtc).
    Precision(u32),
    /// Length conversion (xtc).
    LengthFactor(f64),
    /// Time conversion (xtc).
    TimeFactor(f64),
}

/// `dump_modify ID keyword value ...`, in the order written.
#[derive(Clone, Debug, PartialEq)]
pub struct DumpModifyCommand {
    pub id: Name,
    pub settings: Vec<DumpSetting>,
}

impl DumpModifyCommand {
    /// Needs no knowledge of the dump, but for `element`, which takes every word up to the next keyword.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let id = args.name("a dump ID")?;
        let mut settings = Vec::new();
        while settings.is_empty() || args.left() > 0 {
            let word = args.position();
            settings.push(DumpSetting { word, change: dump_change(args)? });
        }
        Ok(Self { id, settings })
    }
}

fn dump_change(args: &mut Args<'_>) -> Result<DumpChange, Complaint> {
    let word = args.position();
    Ok(match args.text("a dump_modify keyword")? {
        "append" => DumpChange::Append(args.yes_no("append")?),
        "colname" => DumpChange::ColumnName(column_name(args)?),
        "delay" => DumpChange::Delay(Some(args.integer("a step", i64::MIN)?).filter(|step| *step >= 0)),
        "element" => DumpChange::Element(elements(args)?),
        "every" => {
            if let Some(variable) = args.peek().filter(|text| text.starts_with("v_")) {
                let why = format!("a variable as the interval ('{variable}') is not part of octant");
                return Err(Complaint::new(word + 1, why));
            }
            DumpChange::Every(args.integer("the number of steps between snapshots", 1)?)
        }
        "first" => DumpChange::First(args.yes_no("first")?),
        "flush" => DumpChange::Flush(args.yes_no("flush")?),
        "format" => DumpChange::Format(FormatChange::parse(args)?),
        "header" => DumpChange::Header(args.yes_no("header")?),
        "image" => DumpChange::Image(args.yes_no("image")?),
        "maxfiles" => {
            let at = args.position();
            match args.integer("a number of files, or -1", -1)? {
                -1 => DumpChange::MaxFiles(None),
                0 => return Err(Complaint::new(at, "expected a number of files above 0, or -1, got '0'")),
                n => DumpChange::MaxFiles(usize::try_from(n).ok()),
            }
        }
        "pad" => {
            let at = args.position();
            let digits = args.integer("a number of digits", 0)?;
            match usize::try_from(digits) {
                Ok(digits) if digits <= 20 => DumpChange::Pad(digits),
                _ => return Err(Complaint::new(at, format!("expected at most 20 digits, got '{digits}'"))),
            }
        }
        "pbc" => DumpChange::Pbc(args.yes_no("pbc")?),
        "precision" => {
            let at = args.position();
            match args.integer("a precision", 1)? {
                n @ (10 | 100 | 1000 | 10_000 | 100_000 | 1_000_000) => DumpChange::Precision(n as u32),
                n => return Err(Complaint::new(at, format!("expected a power of ten from 10 to 1000000, got '{n}'"))),
            }
        }
        "scale" => DumpChange::Scale(args.yes_no("scale")?),
        "sfactor" => DumpChange::LengthFactor(args.number_where("a length factor", "above 0", |x| x > 0.0)?),
        "tfactor" => DumpChange::TimeFactor(args.number_where("a time factor", "above 0", |x| x > 0.0)?),
        "sort" => DumpChange::Sort(match args.peek() {
            Some("off") => {
                args.text("off")?;
                SortBy::Off
            }
            Some("id") => {
                args.text("id")?;
                SortBy::Id
            }
            _ => match args.integer("off, id or a column", i64::MIN)? {
                0 => return Err(Complaint::new(word + 1, "expected off, id or a column from 1, got '0'")),
                column => SortBy::Column(column),
            },
        }),
        "time" => DumpChange::Time(args.yes_no("time")?),
        "units" => DumpChange::Units(args.yes_no("units")?),
        "unwrap" => DumpChange::Unwrap(args.yes_no("unwrap")?),
        text => {
            let known = MISSING_KEYWORDS.contains(&text);
            let why = if known {
                format!("dump_modify {text} is not part of octant")
            } else {
                format!("unknown dump_modify keyword '{text}'")
            };
            return Err(Complaint::new(word, why).with_help(format!("available: {}", KEYWORDS.join(", "))));
        }
    })
}

#[rustfmt::skip]
const KEYWORDS: &[&str] = &[
    "append", "colname", "delay", "element", "every", "first", "flush", "format", "header", "image", "maxfiles", "pad", "pbc",
    "precision", "scale", "sfactor", "sort", "tfactor", "time", "units", "unwrap",
];

#[rustfmt::skip]
const MISSING_KEYWORDS: &[&str] = &[
    "acolor", "adiam", "amap", "at", "backcolor", "balance", "bcolor", "bdiam", "boxcolor", "buffer", "checksum", "color",
    "bitrate", "compression_level", "every/time", "fileper", "framerate", "label", "nfile", "region", "refresh", "skip",
    "thermo", "thresh", "triclinic/general", "types", "typelabel",
];

/// The words up to the next keyword: element names are no keywords.
fn elements(args: &mut Args<'_>) -> Result<Vec<String>, Complaint> {
    let mut names = vec![args.text("element names, one a type")?.to_string()];
    while let Some(text) = args.peek().filter(|text| !KEYWORDS.contains(text) && !MISSING_KEYWORDS.contains(text)) {
        names.push(text.to_string());
        args.text("an element name")?;
    }
    Ok(names)
}

/// `undump ID`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UndumpCommand {
    pub id: Name,
}

impl UndumpCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let id = args.name("a dump ID")?;
        args.done()?;
        Ok(Self { id })
    }
}
