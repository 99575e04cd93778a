//! The particles, as a structure of arrays in storage order.

use std::collections::{BTreeMap, BTreeSet, HashMap};

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

/// What fills the holes that particles leave which are taken out of storage order as LAMMPS does: first those with axis 0, then 1,
/// then 2, from the first place to the last, the last particle of all filling each hole.
pub struct Holes {
    /// Particles that are left.
    pub left: usize,
    /// Places of theirs and, as they were, those of the particles that go there; others stay where they are.
    pub filled: BTreeMap<usize, usize>,
}

impl Holes {
    /// `lost` are places out of `n`, each with its axis; the work grows with their number alone.
    pub fn new(n: usize, lost: &[(usize, usize)]) -> Self {
        let axis: HashMap<usize, usize> = lost.iter().copied().collect();
        // Where those are that are lost along a later axis: they may have filled a hole before.
        let mut at: HashMap<usize, usize> = lost.iter().map(|(place, _)| (*place, *place)).collect();
        let (mut left, mut filled) = (n, BTreeMap::new());
        for now in 0..3 {
            let mut holes: BTreeSet<usize> =
                lost.iter().filter(|(_, axis)| *axis == now).map(|(place, _)| at[place]).collect();
            while let Some(hole) = holes.pop_first() {
                left -= 1;
                let last = filled.remove(&left).unwrap_or(left);
                if hole == left {
                    continue;
                }
                filled.insert(hole, last);
                if let Some(place) = at.get_mut(&last) {
                    *place = hole;
                    if axis[&last] == now {
                        holes.remove(&left);
                        holes.insert(hole);
                    }
                }
            }
        }
        Self { left, filled }
    }
}

/// Storage order after particles are taken out: `axis` has 0, 1 or 2 for those that are (see [`Holes`]), 3 for others. Returns
/// old places.
pub fn survivors(axis: &[usize]) -> Vec<usize> {
    let lost: Vec<(usize, usize)> = axis.iter().copied().enumerate().filter(|(_, axis)| *axis < 3).collect();
    let holes = Holes::new(axis.len(), &lost);
    let mut storage: Vec<usize> = (0..holes.left).collect();
    for (to, from) in holes.filled {
        storage[to] = from;
    }
    storage
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::RanPark;
    use crate::system::Side::{Fixed, Periodic, Shrink};

    #[test]
    fn holes_are_filled_axis_by_axis() {
        // Particles 1 and 6 leave along x, 0 along y: 6 is last and goes, 5 fills the hole of 1, then 4 that of 0.
        assert_eq!(survivors(&[1, 0, 3, 3, 3, 3, 0]), [4, 5, 2, 3]);
        assert_eq!(survivors(&[0, 0]), [0; 0]);
    }

    #[test]
    fn holes_are_filled_by_going_through_all_particles() {
        let mut random = RanPark::new(5);
        for _ in 0..2000 {
            let (n, part) = (1 + (12.0 * random.uniform()) as usize, random.uniform());
            let axis: Vec<usize> =
                (0..n).map(|_| if random.uniform() < part { (3.0 * random.uniform()) as usize } else { 3 }).collect();
            let mut storage: Vec<usize> = (0..n).collect();
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
            assert_eq!(survivors(&axis), storage, "{axis:?}");
        }
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
