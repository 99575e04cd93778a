//! What the user sees: log, thermo table, dumps, trajectories, reports.

pub mod console;
pub mod printf;
pub mod writable;

pub use console::{Console, Echo};
pub use writable::check_writable;
