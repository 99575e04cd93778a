//! What is simulated: particles, box, units.

pub mod clock;
pub mod memory;
pub mod parallel;
pub mod random;
pub mod simulation_box;
pub mod state;
pub mod temperature;
pub mod units;

pub use clock::Clock;
pub use random::RanPark;
pub use simulation_box::{LostAtoms, Side, SimulationBox};
pub use state::{GROUP_ALL, State, Vec3};
pub use units::Units;
