//! Forces between pairs: `pair_style`, `pair_coeff`, `pair_modify`, `pair_write`.

use super::rest;
use crate::output::pair_table::Spacing;
use crate::pair::Mixing;
use crate::script::statement::{Args, Complaint, Name};

/// `pair_style STYLE ARGS...` (doc page `pair_style`); the style judges its arguments.
#[derive(Clone, Debug, PartialEq)]
pub struct PairStyleCommand {
    pub style: Name,
    pub args: Vec<Name>,
}

impl PairStyleCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        Ok(Self { style: args.name("a pair style")?, args: rest(args, "an argument")? })
    }
}

/// `pair_coeff I J ARGS...` (doc page `pair_coeff`); type ranges such as `*`, `2*`, `1*3` are judged where the number of types is known.
#[derive(Clone, Debug, PartialEq)]
pub struct PairCoeffCommand {
    pub first: Name,
    pub second: Name,
    pub args: Vec<Name>,
}

impl PairCoeffCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        Ok(Self {
            first: args.name("an atom type or a range of types")?,
            second: args.name("a second atom type or range of types")?,
            args: rest(args, "a coefficient")?,
        })
    }
}

/// `pair_modify KEYWORD VALUE...` (doc page `pair_modify`); what is not mentioned stays as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairModifyCommand {
    /// Energies are shifted to 0 at the cutoff.
    pub shift: Option<bool>,
    /// Energy and pressure hold what lies beyond the cutoff.
    pub tail: Option<bool>,
    pub mixing: Option<Mixing>,
}

impl PairModifyCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let mut command = Self::default();
        loop {
            let word = args.position();
            match args.text("shift, tail or mix")? {
                "shift" => command.shift = Some(args.yes_no("a value for 'shift'")?),
                "mix" => command.mixing = Some(Mixing::ALL[args.choice("a mixing rule", &Mixing::NAMES)?]),
                "tail" => command.tail = Some(args.yes_no("a value for 'tail'")?),
                name @ ("table" | "table/disp" | "tabinner" | "tabinner/disp" | "compute" | "nofdotr" | "special"
                | "pair") => {
                    let message = format!("pair_modify {name} is not part of octant; available: shift, tail, mix");
                    return Err(Complaint::new(word, message));
                }
                other => return Err(Complaint::new(word, format!("expected shift, tail or mix, got '{other}'"))),
            }
            if args.left() == 0 {
                return Ok(command);
            }
        }
    }
}

/// `pair_write ITYPE JTYPE N STYLE INNER OUTER FILE KEYWORD` (doc page `pair_write`).
#[derive(Clone, Debug, PartialEq)]
pub struct PairWriteCommand {
    pub first: Name,
    pub second: Name,
    /// Rows of the table, at least 2.
    pub count: usize,
    pub spacing: Spacing,
    /// First and last distance, length units; 0 < inner < outer.
    pub inner: f64,
    pub outer: f64,
    pub file: Name,
    pub keyword: Name,
}

impl PairWriteCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let (first, second) = (args.name("an atom type")?, args.name("a second atom type")?);
        let count = args.integer("a number of rows", 2)? as usize;
        if args.peek() == Some("bitmap") {
            return Err(Complaint::new(
                args.position(),
                "tables of style bitmap are not part of octant; available: r, rsq",
            ));
        }
        let spacing = Spacing::ALL[args.choice("a style of table", &Spacing::NAMES)?];
        let inner = args.number_where("an inner distance", "above 0", |r| r > 0.0)?;
        let outer = args.number_where("an outer distance", &format!("above {inner}"), |r| r > inner)?;
        let (file, keyword) = (args.name("a file name")?, args.name("a keyword")?);
        if args.left() > 0 {
            return Err(Complaint::new(
                args.position(),
                "expected the end of the line: charges are not part of octant",
            ));
        }
        Ok(Self { first, second, count, spacing, inner, outer, file, keyword })
    }
}
