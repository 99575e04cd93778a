//! What each command says, as typed data: one parser per command, no meaning yet.

pub mod dump;
pub mod dump_modify;
pub mod number_format;
pub mod thermo;

use super::{Complaint, Statement};

/// A parsed command.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    Run,
}

impl Command {
    /// Parses a statement.
    pub fn parse(statement: &Statement) -> Result<Self, Complaint> {
        Err(Complaint::new(0, format!("unknown command '{}'", statement.name())))
    }
}
