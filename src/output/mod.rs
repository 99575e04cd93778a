//! What the user sees: log, thermo table, dumps, trajectories, reports.

pub mod console;

pub use console::Console;
