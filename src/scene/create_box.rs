//! `create_box` (LAMMPS doc page `create_box`).

use super::region::Region;
use crate::script::Complaint;
use crate::script::command::create_box::CreateBoxCommand;
use crate::system::{Side, SimulationBox, Vec3};

/// Makes the box around a region; returns it with the number of atom types.
/// Errors: a region without bounds, or with no extent along an axis.
pub fn create_box(
    command: &CreateBoxCommand,
    region: &Region,
    sides: [[Side; 2]; 3],
) -> Result<(SimulationBox, usize), Complaint> {
    let Some([lo, hi]) = region.bounds() else {
        let message = format!("region '{}' has no bounds (it lies outside of its shape)", command.region.text);
        return Err(Complaint::new(command.region.word, message));
    };
    check_bounds(&lo, &hi).map_err(|message| Complaint::new(command.region.word, message))?;
    Ok((SimulationBox::new(lo, hi, sides), command.types))
}

/// What is wrong with the bounds of a box, if anything.
pub(super) fn check_bounds(lo: &Vec3, hi: &Vec3) -> Result<(), String> {
    const LARGEST: f64 = 1.0e15;
    /// Volumes and pressures must stay numbers.
    const THINNEST: f64 = 1.0e-50;
    /// Positions must differ inside the box: an edge is at least this part of its coordinates.
    const RESOLUTION: f64 = 1.0e-10;
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        if !(lo[axis] < hi[axis] && (hi[axis] - lo[axis]).is_finite()) {
            return Err(format!("the box has no extent along {name}: it goes from {:?} to {:?}", lo[axis], hi[axis]));
        }
        if lo[axis] < -LARGEST || hi[axis] > LARGEST {
            return Err(format!("the box is too large along {name}: it goes from {:?} to {:?}", lo[axis], hi[axis]));
        }
        let coordinate = lo[axis].abs().max(hi[axis].abs());
        if hi[axis] - lo[axis] < THINNEST.max(RESOLUTION * coordinate) {
            return Err(format!("the box is too thin along {name}: it goes from {:?} to {:?}", lo[axis], hi[axis]));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::scene::test_support::Scene;

    #[test]
    fn a_box_needs_bounds_with_extent() {
        let mut scene = Scene::new("region o sphere 0 0 0 3 side out\nregion f block 0 0 0 4 0 4");
        assert_eq!(scene.complaint("create_box 1 o").0, 2);
        assert!(scene.complaint("create_box 1 f").1.contains("no extent along x"));
        assert_eq!(scene.complaint("create_box 0 o").0, 1);
        assert!(scene.complaint("create_box 1 o bond/types 2").1.contains("bond/types"));
        scene.run("region s sphere 0 1 2 3").unwrap();
        scene.run("create_box 2 s").unwrap();
        let simulation_box = scene.simulation_box.unwrap();
        assert_eq!(simulation_box.lo.as_slice(), [-3.0, -2.0, -1.0]);
        assert_eq!(simulation_box.hi.as_slice(), [3.0, 4.0, 5.0]);
    }
}
