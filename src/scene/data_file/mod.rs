//! LAMMPS data files (doc pages `read_data`, `write_data`).

mod header;
mod lines;
mod read;
mod write;

use std::sync::Arc;

pub use read::read_data;
pub use write::{CoefficientLines, WriteData, write_data};

use crate::script::{Source, Word};
use crate::system::{SimulationBox, State};

/// What a data file says.
#[derive(Clone, Debug)]
pub struct DataFile {
    /// The text, for errors about coefficients that are judged later.
    pub source: Arc<Source>,
    pub simulation_box: SimulationBox,
    /// Number of atom types the file declares.
    pub types: usize,
    /// Indexed by type - 1; `None` without a `Masses` section.
    pub masses: Vec<Option<f64>>,
    /// `Pair Coeffs`: lines of a type and the coefficients of its pair with itself.
    pub pair_coefficients: Option<CoefficientSection>,
    /// `PairIJ Coeffs`: lines of two types and their coefficients.
    pub pair_ij_coefficients: Option<CoefficientSection>,
    /// Atoms in the order of the file, wrapped into the box, with velocities if the file has them.
    pub state: State,
}

/// A section of coefficients, to be judged by the pair style.
#[derive(Clone, Debug, PartialEq)]
pub struct CoefficientSection {
    /// The section's title, for errors about the whole of it.
    pub title: Word,
    /// The pair style named in the title's comment.
    pub style: Option<Word>,
    /// The words of every line, the types first; types are within range.
    pub lines: Vec<Vec<Word>>,
}
