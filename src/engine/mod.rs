//! Runs a scene: the backend trait, the program of a step, observers; engines beneath.

pub mod backend;
pub mod cpu;
#[cfg(feature = "cuda")]
pub mod cuda;
pub mod fault;
pub mod observer;
mod particles;
pub mod precision;
pub mod program;
mod stiff_pair;
pub mod stride;
mod trouble;
pub mod tuned;

pub use backend::{Backend, Pair, Reached, StageSeconds, Stop, Work};
pub use fault::{Fault, FaultKind, GoodState};
pub use observer::{Needs, NeighborStatistics, Observer, Record, Snapshot, Sums};
pub use precision::Precision;
pub use program::{Program, Stage, StorageSort};
pub use stiff_pair::StiffPair;
pub use stride::{Stride, shorter_timestep};
