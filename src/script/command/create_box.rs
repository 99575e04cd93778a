//! `create_box N region-ID` (LAMMPS doc page `create_box`).

use crate::script::{Args, Complaint, Name};

/// A `create_box` command.
#[derive(Clone, Debug, PartialEq)]
pub struct CreateBoxCommand {
    /// Number of atom types.
    pub types: usize,
    pub region: Name,
}

/// More types than anyone uses; pair tables grow with their square.
pub const MAX_TYPES: i64 = 1000;

impl CreateBoxCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let word = args.position();
        let types = args.integer("the number of atom types", 1)?;
        if types > MAX_TYPES {
            return Err(Complaint::new(word, format!("expected at most {MAX_TYPES} atom types, got {types}")));
        }
        let region = args.name("a region ID")?;
        if region.text == "NULL" {
            return Err(Complaint::new(region.word, "general triclinic boxes are not part of octant"));
        }
        if let Some(keyword) = args.peek() {
            return Err(Complaint::new(
                args.position(),
                format!("expected the end of the line, got '{keyword}' (molecular topology is not part of octant)"),
            ));
        }
        Ok(Self { types: types as usize, region })
    }
}
