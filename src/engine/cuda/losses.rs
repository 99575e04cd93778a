//! Atoms that leave through an open side and are lost: taken off the device, where the rest of the particles stays.

use super::engine::Engine;
use super::layout::{BEGIN_BUILD, TROUBLE_LOST};
use crate::engine::particles::homes_without;
use crate::system::{LostAtoms, Vec3};

/// Lost atoms of one build that are taken off one by one. A hole costs a copy on the device for each array of particles; a build
/// that begins on the host costs some milliseconds, whatever is lost.
const FEW: usize = 64;

impl Engine {
    /// Takes lost atoms off, where the build had to stop for nothing else; the last particles fill the holes, and the build is
    /// to begin anew. False where it has to begin on the host.
    pub(super) fn lose(&mut self) -> Result<bool, String> {
        let whole = self.memory.find("held_home").is_none();
        if self.control.trouble != TROUBLE_LOST || self.program.lost == LostAtoms::Error || whole {
            return Ok(false);
        }
        let lost = self.outside(&self.positions(true)?);
        if lost.is_empty() || lost.len() > FEW {
            return Ok(false);
        }
        let (n, pitch) = (self.control.n as usize, self.sizes.pitch as usize);
        let side = self.control.parity as usize;
        let mut homes: Vec<u32> = self.memory.get("held_home").read(side * pitch, n)?;
        homes = homes_without(&homes, &lost);
        let mut last = n;
        // From the highest place down: what fills a hole is then never lost itself.
        for (hole, _) in lost.iter().rev() {
            last -= 1;
            homes.swap_remove(*hole);
            if *hole != last {
                self.move_particle(last, *hole)?;
            }
        }
        self.memory.get("held_home").write(side * pitch, &homes)?;
        self.memory.get("counts").clear()?;
        self.lost += lost.len();
        self.control.n = last as u32;
        // Shrink-wrapped sides were looked up with all of them, as LAMMPS does.
        (self.control.begin, self.control.bounded) = (BEGIN_BUILD, 1);
        Ok(true)
    }

    /// Places of particles that are outside the box after wrapping, ascending, each with the first axis along which it is.
    fn outside(&self, positions: &[Vec3]) -> Vec<(usize, usize)> {
        let axis = |x: &Vec3| {
            let mut wrapped = *x;
            self.simulation_box.wrap_once(&mut wrapped, &mut [0; 3]);
            self.simulation_box.outside(&wrapped)
        };
        positions.iter().enumerate().filter_map(|(k, x)| axis(x).map(|axis| (k, axis))).collect()
    }

    /// Copies all that a build reads of a particle, but its place in storage order, to another place.
    fn move_particle(&self, from: usize, to: usize) -> Result<(), String> {
        let pitch = self.sizes.pitch as usize;
        let side = self.control.parity as usize;
        let store = if self.plan.shape.double_store { 8 } else { 4 };
        let columns = [
            ("x", store, 0, 3),
            ("v", store, 0, 3),
            ("held_x", 8, 3 * side, 3),
            ("held_v", store, 3 * side, 3),
            ("held_image", 4, 3 * side, 3),
            ("held_id", 4, side, 1),
            ("held_source", 4, side, 1),
            ("held_kind", 4, side, 1),
            ("held_mask", 4, side, 1),
        ];
        for (name, bytes, first, count) in columns {
            let Some(buffer) = self.memory.find(name) else { continue };
            for column in first..first + count {
                buffer.copy_entry(bytes, column * pitch + from, column * pitch + to)?;
            }
        }
        Ok(())
    }
}
