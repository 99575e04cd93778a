//! The particles, as a structure of arrays in storage order.

use nalgebra::Vector3;

use super::simulation_box::SimulationBox;

/// A vector in the box, in the scene's units.
pub type Vec3 = Vector3<f64>;

/// Bit 0 of [`State::mask`]: group `all`.
pub const GROUP_ALL: u32 = 1;

/// All particles. Index is storage order (LAMMPS's `nlocal` order), which no output shows; ids are what users see.
/// Every array has one entry a particle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Atom ids (tags), unique, from 1.
    pub id: Vec<u32>,
    /// Atom types, from 1.
    pub kind: Vec<u32>,
    /// Positions, length units; wrapped into periodic boxes at list builds only.
    pub x: Vec<Vec3>,
    /// Velocities, length / time units.
    pub v: Vec<Vec3>,
    /// Forces, force units; those of the last force evaluation.
    pub f: Vec<Vec3>,
    /// Periodic image counts: unwrapped position = x + image * box length.
    pub image: Vec<[i32; 3]>,
    /// Group membership, bit g for group g; bit 0 is `all`.
    pub mask: Vec<u32>,
}

impl State {
    pub fn len(&self) -> usize {
        self.id.len()
    }

    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Adds a particle at rest in group `all`, image 0.
    pub fn push(&mut self, id: u32, kind: u32, x: Vec3) {
        self.id.push(id);
        self.kind.push(kind);
        self.x.push(x);
        self.v.push(Vec3::zeros());
        self.f.push(Vec3::zeros());
        self.image.push([0; 3]);
        self.mask.push(GROUP_ALL);
    }

    /// How many particles there are of each of so many types.
    pub fn atoms_of(&self, types: usize) -> Vec<usize> {
        let mut atoms = vec![0; types];
        for &kind in &self.kind {
            if let Some(n) = (kind as usize).checked_sub(1).and_then(|k| atoms.get_mut(k)) {
                *n += 1;
            }
        }
        atoms
    }

    /// Largest id, 0 for an empty state.
    pub fn max_id(&self) -> u32 {
        self.id.iter().copied().max().unwrap_or(0)
    }

    /// Componentwise lowest and highest position; zeros for an empty state.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        bounds(&self.x).unwrap_or_default()
    }

    /// Brings the particles to where a list build would have them: wrapped by one image, the box shrunk around them,
    /// those still outside gone. Returns how many are gone.
    pub fn settle(&mut self, simulation_box: &mut SimulationBox) -> usize {
        for (x, image) in self.x.iter_mut().zip(&mut self.image) {
            simulation_box.wrap_once(x, image);
        }
        simulation_box.shrink_wrap(&self.x);
        let pass: Vec<usize> = self.x.iter().map(|x| simulation_box.outside(x).unwrap_or(3)).collect();
        let gone = pass.iter().filter(|axis| **axis < 3).count();
        if gone > 0 {
            let storage = survivors(&pass);
            self.id = storage.iter().map(|k| self.id[*k]).collect();
            self.kind = storage.iter().map(|k| self.kind[*k]).collect();
            self.x = storage.iter().map(|k| self.x[*k]).collect();
            self.v = storage.iter().map(|k| self.v[*k]).collect();
            self.f = storage.iter().map(|k| self.f[*k]).collect();
            self.image = storage.iter().map(|k| self.image[*k]).collect();
            self.mask = storage.iter().map(|k| self.mask[*k]).collect();
        }
        gone
    }

    /// Storage indices in order of id.
    pub fn order_by_id(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.len()).collect();
        if !self.id.is_sorted() {
            order.sort_unstable_by_key(|&k| self.id[k]);
        }
        order
    }
}

/// Componentwise lowest and highest of some positions.
pub fn bounds(positions: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let first = *positions.first()?;
    Some(positions.iter().fold((first, first), |(lo, hi), x| (lo.inf(x), hi.sup(x))))
}

/// Storage order after particles are taken out as LAMMPS does: first those whose entry in `axis` is 0, then 1, then 2, the
/// last particle filling each hole; others stay. Returns old places.
pub fn survivors(axis: &[usize]) -> Vec<usize> {
    let mut storage: Vec<usize> = (0..axis.len()).collect();
    for now in 0..3 {
        let mut k = 0;
        while k < storage.len() {
            if axis[storage[k]] == now {
                storage.swap_remove(k);
            } else {
                k += 1;
            }
        }
    }
    storage
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::Side::{Fixed, Periodic, Shrink};

    #[test]
    fn holes_are_filled_axis_by_axis() {
        // Particles 1 and 6 leave along x, 0 along y: 6 is last and goes, 5 fills the hole of 1, then 4 that of 0.
        assert_eq!(survivors(&[1, 0, 3, 3, 3, 3, 0]), [4, 5, 2, 3]);
        assert_eq!(survivors(&[0, 0]), [0; 0]);
    }

    #[test]
    fn settling_wraps_shrinks_and_drops() {
        let mut state = State::default();
        for (id, x) in [(7, [1.0, 1.0, 4.5]), (3, [5.5, 2.0, 1.0]), (5, [2.0, -1.0, 1.5])] {
            state.push(id, 1, x.into());
        }
        let sides = [[Periodic; 2], [Fixed; 2], [Shrink, Fixed]];
        let mut simulation_box = SimulationBox::new(Vec3::zeros(), Vec3::new(5.0, 3.0, 5.0), sides);
        assert_eq!(state.settle(&mut simulation_box), 1);
        assert_eq!(state.id, [7, 3]);
        assert_eq!(state.x[1], Vec3::new(0.5, 2.0, 1.0));
        assert_eq!(state.image[1], [1, 0, 0]);
        assert_eq!(simulation_box.lo.z, 1.0 - 5.0e-4);
    }
}
