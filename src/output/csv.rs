//! Tables as CSV.

use std::path::Path;

use super::write_whole;
use crate::Error;

/// Writes a table, whole or not at all: a line of column names, then a line a row. Cells with commas, quotes or line ends are quoted.
pub fn write_csv(path: &Path, heads: &[&str], rows: &[Vec<String>]) -> Result<(), Error> {
    let quoted = |cell: &String| {
        if cell.contains([',', '"', '\n']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.clone() }
    };
    let written = write_whole(path, |out| {
        writeln!(out, "{}", heads.join(","))?;
        for row in rows {
            writeln!(out, "{}", row.iter().map(quoted).collect::<Vec<_>>().join(","))?;
        }
        Ok(())
    });
    written.map_err(|e| Error::file(path, "cannot write", e))
}
