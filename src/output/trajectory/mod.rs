//! Trajectories in the binary and text formats of the chemfiles library (<https://chemfiles.org>): dump styles `dcd`, `xtc`,
//! `netcdf`, and `chemfiles`, which is ours. The only importer of the `chemfiles` crate, behind the feature of that name.

use super::SceneFacts;
use super::dump::SnapshotWriter;
use crate::script::Complaint;
use crate::script::command::dump::DumpCommand;

#[cfg(feature = "chemfiles")]
mod dcd;
#[cfg(feature = "chemfiles")]
mod warnings;
#[cfg(feature = "chemfiles")]
mod writer;

/// A format that trajectories can be written in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrajectoryFormat {
    pub name: String,
    /// With its dot.
    pub extension: Option<String>,
    pub velocities: bool,
    /// Text; such files may be compressed (`.gz`, `.bz2`, `.xz`).
    pub is_text: bool,
}

#[cfg(feature = "chemfiles")]
pub(super) fn writer(command: &DumpCommand, facts: &SceneFacts) -> Result<Box<dyn SnapshotWriter>, Complaint> {
    Ok(Box::new(writer::TrajectoryWriter::new(command, facts)?))
}

#[cfg(not(feature = "chemfiles"))]
pub(super) fn writer(command: &DumpCommand, _: &SceneFacts) -> Result<Box<dyn SnapshotWriter>, Complaint> {
    let why = "this build of octant has no chemfiles support; build with the default features";
    Err(Complaint::new(command.style_word, why))
}

/// Formats that chemfiles writes, but one frame a file.
#[cfg(feature = "chemfiles")]
const SINGLE_FRAME: &[&str] = &["Amber Restart", "CSSR", "LAMMPS Data"];

/// The formats of `dump ... chemfiles`, by name; none in a build without chemfiles.
#[cfg(feature = "chemfiles")]
pub fn trajectory_formats() -> Vec<TrajectoryFormat> {
    let mut formats: Vec<TrajectoryFormat> = chemfiles::formats_list()
        .into_iter()
        .filter(|format| format.write && format.positions && !SINGLE_FRAME.contains(&format.name))
        .map(|format| TrajectoryFormat {
            name: format.name.to_string(),
            extension: format.extension.map(str::to_string),
            velocities: format.velocities,
            // Binary formats cannot be written to memory either.
            is_text: format.memory && format.name != "MMTF",
        })
        .collect();
    formats.sort_by(|a, b| a.name.cmp(&b.name));
    formats
}

/// The formats of `dump ... chemfiles`, by name; none in a build without chemfiles.
#[cfg(not(feature = "chemfiles"))]
pub fn trajectory_formats() -> Vec<TrajectoryFormat> {
    Vec::new()
}

#[cfg(all(test, feature = "chemfiles"))]
mod tests;

#[cfg(all(test, not(feature = "chemfiles")))]
mod tests {
    use super::*;
    use crate::script::testing::statement;
    use crate::system::Units;

    #[test]
    fn a_build_without_chemfiles_says_so() {
        let facts = SceneFacts::new(Units::named("lj").unwrap(), vec![1.0]);
        let command = DumpCommand::parse(&mut statement("dump a all xtc 10 f.xtc").args()).unwrap();
        let error = writer(&command, &facts).err().unwrap();
        assert_eq!((error.word, error.message.contains("no chemfiles support")), (3, true));
    }
}
