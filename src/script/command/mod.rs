//! What each command says, as typed data: one parser per command, no meaning yet.

pub mod create_atoms;
pub mod create_box;
pub mod group;
pub mod lattice;
pub mod mass;
pub mod read_data;
pub mod region;
pub mod velocity;
pub mod write_data;

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
