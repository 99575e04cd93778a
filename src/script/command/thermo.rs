//! `thermo`, `thermo_style`, `thermo_modify` (doc pages of those names).

use super::number_format::{ColumnName, FormatChange, column_name};
use crate::output::quantities::keyword;
use crate::script::{Args, Complaint};
use crate::system::LostAtoms;

/// `thermo N`: a table row every N steps; 0 for the first and the last step of a run only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThermoCommand {
    pub every: i64,
}

impl ThermoCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let word = args.position();
        if let Some(variable) = args.peek().filter(|text| text.starts_with("v_")) {
            let why = format!("a variable as the interval ('{variable}') is not part of octant");
            return Err(Complaint::new(word, why).with_help("give a number of steps"));
        }
        let every = args.integer("the number of steps between rows", 0)?;
        args.done()?;
        Ok(Self { every })
    }
}

/// `thermo_style`: what the table shows.
#[derive(Clone, Debug, PartialEq)]
pub enum ThermoStyleCommand {
    /// Step Temp E_pair E_mol TotEng Press, a row a line.
    One,
    /// A block of lines a row.
    Multi,
    /// The columns of `multi`, as YAML.
    Yaml,
    /// Columns of one's own.
    Custom(Vec<ThermoColumn>),
}

/// A column of `thermo_style custom` and its word in the command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ThermoColumn {
    pub word: usize,
    pub source: ThermoSource,
}

/// Where a column's values come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ThermoSource {
    /// A keyword of [`crate::output::quantities::KEYWORDS`].
    Keyword(&'static str),
    /// An equal-style variable, by name.
    Variable(String),
}

impl ThermoStyleCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let style = match args.choice("a thermo style", &["one", "multi", "yaml", "custom"])? {
            0 => Self::One,
            1 => Self::Multi,
            2 => Self::Yaml,
            _ => {
                let mut columns = vec![thermo_column(args)?];
                while args.left() > 0 {
                    columns.push(thermo_column(args)?);
                }
                Self::Custom(columns)
            }
        };
        args.done()?;
        Ok(style)
    }
}

fn thermo_column(args: &mut Args<'_>) -> Result<ThermoColumn, Complaint> {
    let word = args.position();
    let text = args.text("a thermo keyword")?;
    let source = if let Some(name) = text.strip_prefix("v_") {
        if name.contains('[') {
            return Err(Complaint::new(word, format!("vector-style variables ('{text}') are not part of octant")));
        }
        if name.is_empty() {
            return Err(Complaint::new(word, "expected a variable name after v_, got none"));
        }
        ThermoSource::Variable(name.to_string())
    } else if text.starts_with("c_") {
        return Err(Complaint::new(word, format!("computes ('{text}') are not part of octant")));
    } else if text.starts_with("f_") {
        return Err(Complaint::new(word, format!("values of fixes ('{text}') are not part of octant")));
    } else {
        match keyword(text) {
            Some(info) => ThermoSource::Keyword(info.name),
            None => return Err(Complaint::new(word, format!("unknown thermo keyword '{text}'"))),
        }
    };
    Ok(ThermoColumn { word, source })
}

/// How rows are laid out (`thermo_modify line`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThermoLine {
    One,
    Multi,
    Yaml,
}

/// `thermo_modify`: what is not mentioned stays as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThermoModifyCommand {
    /// Extensive values per atom.
    pub norm: Option<bool>,
    /// Files are flushed after every row.
    pub flush: Option<bool>,
    pub lost: Option<LostAtoms>,
    pub line: Option<ThermoLine>,
    pub formats: Vec<FormatChange>,
    /// Headers, each with the index of the word that names the column.
    pub names: Vec<(usize, ColumnName)>,
}

impl ThermoModifyCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let mut command = Self::default();
        loop {
            let word = args.position();
            match args.text("a thermo_modify keyword")? {
                "norm" => command.norm = Some(args.yes_no("norm")?),
                "flush" => command.flush = Some(args.yes_no("flush")?),
                "lost" => {
                    let choice = args.choice("what to do about lost atoms", &["ignore", "warn", "error"])?;
                    command.lost = Some([LostAtoms::Ignore, LostAtoms::Warn, LostAtoms::Error][choice]);
                }
                "line" => {
                    let choice = args.choice("a layout", &["one", "multi", "yaml"])?;
                    command.line = Some([ThermoLine::One, ThermoLine::Multi, ThermoLine::Yaml][choice]);
                }
                "format" => command.formats.push(FormatChange::parse(args)?),
                "colname" => {
                    let at = args.position();
                    command.names.push((at, column_name(args)?));
                }
                known @ ("lost/bond" | "warn" | "temp" | "press" | "triclinic/general") => {
                    let why = format!("thermo_modify {known} is not part of octant");
                    let help = "available: norm, flush, lost, line, format, colname";
                    return Err(Complaint::new(word, why).with_help(help));
                }
                unknown => {
                    let why = format!("expected norm, flush, lost, line, format or colname, got '{unknown}'");
                    return Err(Complaint::new(word, why));
                }
            }
            if args.left() == 0 {
                return Ok(command);
            }
        }
    }
}
