//! Masses of atom types (LAMMPS doc page `mass`).

use super::type_range::type_range;
use crate::script::Complaint;
use crate::script::command::mass::MassCommand;

/// Carries out a `mass` command; `masses` is indexed by type - 1.
pub fn set_mass(command: &MassCommand, masses: &mut [Option<f64>]) -> Result<(), Complaint> {
    for kind in type_range(&command.types, masses.len())? {
        masses[kind as usize - 1] = Some(command.mass);
    }
    Ok(())
}

/// All masses as plain numbers; the first type without one is the error.
pub fn all_masses(masses: &[Option<f64>]) -> Result<Vec<f64>, String> {
    let missing = |k: usize| format!("the mass of atom type {} is not set", k + 1);
    masses.iter().enumerate().map(|(k, m)| m.ok_or_else(|| missing(k))).collect()
}
