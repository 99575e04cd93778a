//! Runs a scene.
pub mod observer;
pub use observer::{Needs, NeighborStatistics, Observer, Snapshot, Sums};
