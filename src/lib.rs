//! Octant: molecular dynamics of atoms with short-range pair forces, from LAMMPS input scripts.

pub mod engine;
pub mod error;
pub mod output;
pub mod scene;
pub mod script;
pub mod system;

pub use error::Error;
