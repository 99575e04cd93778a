//! What is simulated: particles, box, units.

pub mod memory;
pub mod random;
pub mod simulation_box;
pub mod state;
pub mod temperature;
pub mod units;

pub use random::RanPark;
pub use simulation_box::{Side, SimulationBox};
pub use state::{GROUP_ALL, State, Vec3};
pub use units::Units;
