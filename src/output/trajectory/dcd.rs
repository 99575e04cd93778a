//! The step numbers in the header of a DCD file, which chemfiles leaves at zero.
//!
//! Layout of the first record (CHARMM; the MDAnalysis and VMD readers): marker 84, "CORD", number of frames, first step,
//! steps between frames, last step, ..., and as the tenth word after it the timestep as a 32-bit float.

use std::fs::OpenOptions;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

const FIRST_STEP: u64 = 12;
const LAST_STEP: u64 = 20;
const TIMESTEP: u64 = 44;

/// What LAMMPS writes there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Steps {
    pub first: i64,
    pub every: i64,
    pub last: i64,
    /// Time units of the scene, as LAMMPS has it.
    pub timestep: f64,
}

/// Writes the steps into a complete file; of one that was appended to, the last step only.
pub(super) fn write_steps(path: &Path, steps: Steps, appended: bool) -> std::io::Result<()> {
    let mut file = OpenOptions::new().read(true).write(true).open(path)?;
    let mut start = [0; 8];
    file.read_exact(&mut start)?;
    // Only 32-bit markers in the machine's order, as chemfiles writes them; anything else is not ours to change.
    if start != [84_u32.to_ne_bytes(), *b"CORD"].concat()[..] {
        return Ok(());
    }
    let word = |n: i64| i32::try_from(n).unwrap_or(i32::MAX).to_ne_bytes();
    if !appended {
        file.seek(SeekFrom::Start(FIRST_STEP))?;
        file.write_all(&word(steps.first))?;
        file.write_all(&word(steps.every))?;
        file.seek(SeekFrom::Start(TIMESTEP))?;
        file.write_all(&(steps.timestep as f32).to_ne_bytes())?;
    }
    file.seek(SeekFrom::Start(LAST_STEP))?;
    file.write_all(&word(steps.last))?;
    file.flush()
}
