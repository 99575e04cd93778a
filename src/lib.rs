//! Octant: molecular dynamics of atoms with short-range pair forces, from LAMMPS input scripts.

pub mod bench;
pub mod cli;
pub mod dynamics;
pub mod engine;
pub mod error;
pub mod neighbor;
pub mod output;
pub mod pair;
pub mod paper;
pub mod real;
pub mod report;
pub mod scene;
pub mod script;
pub mod session;
pub mod system;

pub use error::Error;
