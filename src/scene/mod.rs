//! The meaning of a script: lattices, regions, atoms, velocities, data files.

pub mod builder;
pub mod create_atoms;
pub mod create_box;
pub mod data_file;
pub mod group;
pub mod group_functions;
pub mod group_motion;
pub mod lattice;
pub mod mass;
pub mod region;
#[cfg(test)]
pub(crate) mod test_support;
pub mod type_range;
pub mod velocity;

pub use builder::SceneBuilder;
pub use create_atoms::{CreateContext, create_atoms};
pub use create_box::create_box;
pub use group::Groups;
pub use lattice::Lattice;
pub use region::{Region, Regions};
pub use velocity::{VelocityContext, velocity};
