//! Kinetic energy and temperature.

use super::state::State;
use super::units::Units;

/// Sum of m v^2 over the atoms of the groups in `mask`, in units of mass times velocity squared (twice the kinetic energy
/// before `mvv2e`), added in storage order. `masses` is indexed by type - 1.
pub fn sum_mass_velocity_squared(state: &State, masses: &[f64], mask: u32) -> f64 {
    let mut sum = 0.0;
    for ((v, &kind), &member) in state.v.iter().zip(&state.kind).zip(&state.mask) {
        if member & mask != 0 {
            sum += (v.x * v.x + v.y * v.y + v.z * v.z) * masses[kind as usize - 1];
        }
    }
    sum
}

/// Translational degrees of freedom of `count` atoms whose momentum is conserved: 3 N - 3 (negative without atoms).
pub fn degrees_of_freedom(count: usize) -> f64 {
    3.0 * count as f64 - 3.0
}

/// Temperature of `dof` degrees of freedom that hold `sum` = sum of m v^2: T = sum mvv2e / (dof k_B), 0 where nothing can move
/// (LAMMPS doc page `compute temp`).
pub fn temperature(sum: f64, dof: f64, units: &Units) -> f64 {
    if dof > 0.0 { sum * (units.mvv2e / (dof * units.boltzmann)) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::Vec3;

    #[test]
    fn two_atoms_share_three_degrees_of_freedom() {
        let mut state = State::default();
        state.push(1, 1, Vec3::zeros());
        state.push(2, 2, Vec3::zeros());
        state.v[0] = Vec3::new(1.0, 2.0, 3.0);
        state.v[1] = Vec3::new(0.0, 1.0, 0.0);
        let sum = sum_mass_velocity_squared(&state, &[2.0, 5.0], 1);
        assert_eq!(sum, 33.0);
        let units = Units::named("lj").unwrap();
        assert_eq!(temperature(sum, degrees_of_freedom(2), units), 11.0);
        assert_eq!(temperature(sum, degrees_of_freedom(1), units), 0.0);
    }
}
