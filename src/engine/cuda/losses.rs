//! Atoms that leave through an open side and are lost: taken off the device, where the rest of the particles stays.

use super::engine::Engine;
use super::layout::{BEGIN_BUILD, MOST_LOST, TROUBLE_LOST};
use crate::system::LostAtoms;
use crate::system::state::Holes;

impl Engine {
    /// Says how lost particles are to be taken out, where the build had to stop for nothing else and is to begin anew; false where
    /// it has to begin on the host.
    pub(super) fn lose(&mut self) -> Result<bool, String> {
        let Some(losses) = self.memory.find("losses") else { return Ok(false) };
        let told = self.program.lost != LostAtoms::Error && self.control.lost <= MOST_LOST;
        if self.control.trouble != TROUBLE_LOST || !told {
            return Ok(false);
        }
        let (n, count, room) = (self.control.n as usize, self.control.lost as usize, MOST_LOST as usize);
        let column = |k: usize| losses.read::<u32>(k * room, count);
        let (places, axes, homes) = (column(0)?, column(1)?, column(2)?);
        let lost: Vec<(usize, usize)> =
            homes.iter().zip(&axes).map(|(home, axis)| (*home as usize, *axis as usize)).collect();
        let Holes { left, filled } = Holes::new(n, &lost);
        let mut homes = vec![0; count];
        for (home, old) in filled {
            homes[old - left] = home as u32;
        }
        // Places where particles lie on the device, too; the order there is of no account.
        let everyone: Vec<(usize, usize)> = places.iter().map(|place| (*place as usize, 0)).collect();
        let filled = Holes::new(n, &everyone).filled;
        let (mut from, mut to): (Vec<u32>, Vec<u32>) =
            filled.iter().map(|(to, from)| (*from as u32, *to as u32)).unzip();
        // Where one of the last is lost itself there is nothing to fill.
        from.resize(count, 0);
        to.resize(count, 0);
        losses.write(0, &from)?;
        losses.write(room, &to)?;
        losses.write(2 * room, &homes)?;
        self.memory.get("counts").clear()?;
        self.lost += count;
        (self.control.n, self.control.holes) = (left as u32, count as u32);
        // Shrink-wrapped sides were looked up with all of them, as LAMMPS does.
        (self.control.begin, self.control.bounded) = (BEGIN_BUILD, 1);
        Ok(true)
    }
}
