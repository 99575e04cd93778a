//! What the user sees: log, thermo table, dumps, trajectories, reports.

pub mod calendar;
pub mod columns;
pub mod console;
pub mod csv;
pub mod dump;
pub mod facts;
pub mod json;
pub mod pair_table;
pub mod printf;
pub mod progress;
pub mod quantities;
pub mod summary;
pub mod thermo;
pub mod trajectory;
pub mod whole_file;
pub mod writable;

pub use console::{Console, Echo};
pub use csv::write_csv;
pub use dump::{DumpObserver, WrittenFile, open_dump};
pub use facts::SceneFacts;
pub use json::{MemoryReport, NeighborReport, Report, TimingReport};
pub use printf::Printf;
pub use progress::Progress;
pub use quantities::{Number, Quantities};
pub use summary::{RunSummary, StageTimes, wall_time_line};
pub use thermo::{ThermoRow, ThermoSchedule, ThermoTable};
pub use trajectory::trajectory_formats;
pub use whole_file::write_whole;
pub use writable::check_writable;
