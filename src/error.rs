//! Everything that can go wrong, for people: input errors carry their place, faults their step and atom.

use std::path::{Path, PathBuf};

use crate::script::InputError;

/// Error of the library's public functions.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The script or a data file is at fault.
    #[error(transparent)]
    Input(#[from] Box<InputError>),
    /// A file could not be read or written.
    #[error("{path}: {action}: {source}", path = path.display())]
    File { path: PathBuf, action: &'static str, source: std::io::Error },
    /// The dynamics went wrong.
    #[error("{0}")]
    Fault(String),
    /// This build or machine lacks what was asked for.
    #[error("{0}")]
    Unavailable(String),
}

impl From<InputError> for Error {
    fn from(error: InputError) -> Self {
        Self::Input(Box::new(error))
    }
}

impl Error {
    /// A file error; `action` reads like "cannot write".
    pub fn file(path: impl AsRef<Path>, action: &'static str, source: std::io::Error) -> Self {
        Self::File { path: path.as_ref().to_path_buf(), action, source }
    }
}
