//! What the user sees: log, thermo table, dumps, trajectories, reports.

pub mod columns;
pub mod console;
pub mod facts;
pub mod printf;
pub mod quantities;
pub mod summary;
pub mod thermo;
pub mod writable;

pub use console::{Console, Echo};
pub use facts::SceneFacts;
pub use quantities::{Number, Quantities};
pub use summary::{RunSummary, StageTimes};
pub use thermo::{ThermoRow, ThermoSchedule, ThermoTable};
pub use writable::check_writable;
