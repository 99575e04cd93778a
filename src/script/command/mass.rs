//! `mass I value` (LAMMPS doc page `mass`).

use crate::script::{Args, Complaint, Name};

/// A `mass` command.
#[derive(Clone, Debug, PartialEq)]
pub struct MassCommand {
    /// A type or a range of types such as `*`, `2*`, `*3`, `2*3`; see [`crate::scene::type_range`].
    pub types: Name,
    /// Mass, above 0, mass units.
    pub mass: f64,
}

impl MassCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let types = args.name("an atom type")?;
        let mass = args.number_where("a mass", "above 0", |m| m > 0.0)?;
        args.done()?;
        Ok(Self { types, mass })
    }
}
