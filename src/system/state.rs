//! The particles, as a structure of arrays in storage order.

use nalgebra::Vector3;

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

    /// Largest id, 0 for an empty state.
    pub fn max_id(&self) -> u32 {
        self.id.iter().copied().max().unwrap_or(0)
    }

    /// Componentwise lowest and highest position; zeros for an empty state.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let first = self.x.first().copied().unwrap_or_default();
        self.x.iter().fold((first, first), |(lo, hi), x| (lo.inf(x), hi.sup(x)))
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
