//! The input language as text: lexer, spans, variables and formulas, one parser per command.

pub mod command;
pub mod environment;
pub mod source;
pub mod statement;
#[cfg(test)]
pub(crate) mod testing;

pub use command::Command;
pub use environment::{Environment, NoSimulation, Quantity};
pub use source::{InputError, Source, Span};
pub use statement::{Args, Complaint, Name, Statement, Word, parse_number};
