//! Forces between pairs: `pair_style`, `pair_coeff`, `pair_modify`.

use super::rest;
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

/// `pair_modify KEYWORD VALUE...` (doc page `pair_modify`), judged together with the pair style.
#[derive(Clone, Debug, PartialEq)]
pub struct PairModifyCommand {
    pub args: Vec<Name>,
}

impl PairModifyCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let first = args.name("a keyword")?;
        let mut all = vec![first];
        all.extend(rest(args, "a value")?);
        Ok(Self { args: all })
    }
}
