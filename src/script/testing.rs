//! Helpers of unit tests.

use super::{Interpreter, NoSimulation, Source, Statement};

/// The only command of a line, as the interpreter reads it.
pub(crate) fn statement(line: &str) -> Statement {
    let mut script = Interpreter::new(Source::new("test", line), &[]).unwrap();
    script.next(&mut NoSimulation).unwrap().unwrap()
}
