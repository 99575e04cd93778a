//! `dump_modify` (doc page of that name).

use super::number_format::{ColumnName, FormatChange, column_name};
use crate::script::{Args, Complaint, Name};

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
