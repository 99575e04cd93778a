//! Runs a scene: the backend trait, the program of a step, observers; engines beneath.

pub mod backend;
pub mod cpu;
pub mod fault;
pub mod observer;
pub mod precision;
pub mod program;

pub use backend::{Backend, Reached, StageSeconds, Work};
pub use fault::{Fault, FaultKind, GoodState};
pub use observer::{Needs, NeighborStatistics, Observer, Snapshot, Sums};
pub use precision::Precision;
pub use program::{Program, Stage, StorageSort};
