//! `dump`, `undump` (doc pages of those names).

pub use super::dump_modify::{DumpChange, DumpModifyCommand, DumpSetting, SortBy};
use crate::script::{Args, Complaint, Name};

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
            let available = STYLES.join(", ");
            let why = if MISSING_STYLES.contains(&style) {
                format!("dump style '{style}' is not part of octant; available: {available}")
            } else {
                format!("unknown dump style '{style}'; available: {available}")
            };
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
