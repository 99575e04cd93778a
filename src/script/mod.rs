//! The input language as text: lexer, spans, variables and formulas, one parser per command.

pub mod command;
pub mod condition;
pub mod environment;
pub mod formula;
pub mod interpreter;
pub mod lexer;
pub mod mapped;
pub mod ranmar;
pub mod source;
pub mod statement;
pub mod substitute;
pub mod suggest;
#[cfg(test)]
pub(crate) mod testing;
pub mod variables;

pub use command::Command;
pub use environment::{Environment, NoSimulation, Quantity};
pub use interpreter::Interpreter;
pub use source::{InputError, Source, Span};
pub use statement::{Args, Complaint, Name, Statement, Word, parse_number};
