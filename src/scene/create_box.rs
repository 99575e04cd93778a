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
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        if !(lo[axis] < hi[axis] && (hi[axis] - lo[axis]).is_finite()) {
            return Err(format!("the box has no extent along {name}: it goes from {} to {}", lo[axis], hi[axis]));
        }
        if lo[axis] < -LARGEST || hi[axis] > LARGEST {
            return Err(format!("the box is too large along {name}: it goes from {} to {}", lo[axis], hi[axis]));
        }
    }
    Ok(())
}
