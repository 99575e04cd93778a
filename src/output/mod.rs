//! What the user sees: log, thermo table, dumps, trajectories, reports.

pub mod console;
pub mod printf;

pub use console::Console;
pub use printf::Printf;
