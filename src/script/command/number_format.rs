//! The `format` keyword that `thermo_modify` and `dump_modify` share.

use crate::output::printf::Printf;
use crate::script::{Args, Complaint};

/// One `format` setting (doc pages `thermo_modify`, `dump_modify`).
#[derive(Clone, Debug, PartialEq)]
pub struct FormatChange {
    /// Index of the word that names the target, for complaints.
    pub word: usize,
    pub target: FormatTarget,
}

/// Which columns get which format. A column's own format wins over `int` and `float`, those over `line`.
#[derive(Clone, Debug, PartialEq)]
pub enum FormatTarget {
    /// Back to the defaults.
    None,
    /// One format a column.
    Line(Vec<Printf>),
    /// All integer columns.
    Integer(Printf),
    /// All floating-point columns.
    Float(Printf),
    /// One column, by number (negative from the end) or, in the thermo table, by keyword.
    Column(String, Printf),
}

impl FormatChange {
    /// Reads what follows the word `format`.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let word = args.position();
        let target = match args.text("line, int, float, a column or none")? {
            "none" => FormatTarget::None,
            "line" => {
                let at = args.position();
                let formats = args.text("formats, one a column")?.split_whitespace().map(Printf::parse);
                FormatTarget::Line(formats.collect::<Result<_, _>>().map_err(|why| Complaint::new(at, why))?)
            }
            "int" => FormatTarget::Integer(one_format(args)?),
            "float" => FormatTarget::Float(one_format(args)?),
            column => FormatTarget::Column(column.to_string(), one_format(args)?),
        };
        Ok(Self { word, target })
    }
}

fn one_format(args: &mut Args<'_>) -> Result<Printf, Complaint> {
    let at = args.position();
    Printf::parse(args.text("a number format such as %g")?.trim()).map_err(|why| Complaint::new(at, why))
}

/// A `colname` setting: a column (number or keyword) and its new header; `None` puts all headers back.
pub type ColumnName = Option<(String, String)>;

/// Reads what follows the word `colname`.
pub fn column_name(args: &mut Args<'_>) -> Result<ColumnName, Complaint> {
    let column = args.text("a column, or default")?;
    if column == "default" {
        return Ok(None);
    }
    let at = args.position();
    let header = args.text("a column header")?;
    if header.is_empty() || header.contains(char::is_whitespace) {
        return Err(Complaint::new(at, format!("expected a column header without blanks, got '{header}'")));
    }
    Ok(Some((column.to_string(), header.to_string())))
}
