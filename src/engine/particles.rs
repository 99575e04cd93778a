//! The particles at a list build, in double precision and cell order: what builds start from, and what is left when a run
//! goes wrong.

use rayon::prelude::*;

use crate::neighbor::axis::locate;
use crate::neighbor::search::row_major;
use crate::neighbor::{Cells, Grid, SearchPlan};
use crate::system::parallel;
use crate::system::state::survivors;
use crate::system::{SimulationBox, State, Vec3};

/// Particles wrapped, copied or gathered as one piece of work.
const PIECE: usize = 2048;

/// A particle that is no longer in the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lost {
    pub place: usize,
    /// Before it was wrapped, length units.
    pub position: Vec3,
    /// It has moved farther than the box is long since the last build.
    pub far: bool,
}

/// Structure of arrays, sorted by (cell, octant, part of the octant), ties by id. One entry a particle each.
#[derive(Debug, Default)]
pub struct Particles {
    /// Positions, length units.
    pub x: Vec<Vec3>,
    /// Velocities, length / time units.
    pub v: Vec<Vec3>,
    /// Types from 0.
    pub kind: Vec<u32>,
    /// Places in storage order.
    pub home: Vec<u32>,
    pub image: Vec<[i32; 3]>,
    pub id: Vec<u32>,
    pub mask: Vec<u32>,
}

impl Particles {
    /// Bytes of one particle in all arrays.
    pub const BYTES: usize = 2 * size_of::<Vec3>() + size_of::<[i32; 3]>() + 4 * size_of::<u32>();

    /// Copies a state, places in storage order.
    pub fn load(state: &State) -> Self {
        Self {
            x: state.x.clone(),
            v: state.v.clone(),
            kind: state.kind.iter().map(|kind| kind - 1).collect(),
            home: (0..state.len() as u32).collect(),
            image: state.image.clone(),
            id: state.id.clone(),
            mask: state.mask.clone(),
        }
    }

    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Becomes a copy, in the memory it has.
    pub fn copy_from(&mut self, from: &Self) {
        self.x.clone_from(&from.x);
        self.v.clone_from(&from.v);
        self.kind.clone_from(&from.kind);
        self.home.clone_from(&from.home);
        self.image.clone_from(&from.image);
        self.id.clone_from(&from.id);
        self.mask.clone_from(&from.mask);
    }

    /// Writes everything but forces back in storage order.
    pub fn store(&self, state: &mut State) {
        let n = self.len();
        state.id.resize(n, 0);
        state.kind.resize(n, 0);
        state.x.resize(n, Vec3::zeros());
        state.v.resize(n, Vec3::zeros());
        state.f.resize(n, Vec3::zeros());
        state.image.resize(n, [0; 3]);
        state.mask.resize(n, 0);
        for k in 0..n {
            let home = self.home[k] as usize;
            state.id[home] = self.id[k];
            state.kind[home] = self.kind[k] + 1;
            state.x[home] = self.x[k];
            state.v[home] = self.v[k];
            state.image[home] = self.image[k];
            state.mask[home] = self.mask[k];
        }
    }

    /// Becomes `from` in the order that the cells were sorted in.
    pub fn gather(&mut self, from: &Self, cells: &Cells) {
        fn one<T: Copy + Default + Send + Sync>(to: &mut Vec<T>, from: &[T], order: &[u32]) {
            to.resize(order.len(), T::default());
            let copy = |_: usize, (to, order): (&mut [T], &[u32])| {
                for (to, k) in to.iter_mut().zip(order) {
                    *to = from[*k as usize];
                }
            };
            parallel::each((&mut to[..], order), PIECE, &copy, &|(), ()| ());
        }
        let order = cells.sources();
        one(&mut self.x, &from.x, order);
        one(&mut self.v, &from.v, order);
        one(&mut self.kind, &from.kind, order);
        one(&mut self.home, &from.home, order);
        one(&mut self.image, &from.image, order);
        one(&mut self.id, &from.id, order);
        one(&mut self.mask, &from.mask, order);
    }

    /// Places of all particles with a position or velocity that is no number.
    pub fn broken(&self) -> Vec<usize> {
        let fine = |x: &Vec3, v: &Vec3| x.iter().chain(v.iter()).all(|c| c.is_finite());
        let all_fine = |_: usize, (x, v): (&[Vec3], &[Vec3])| x.iter().zip(v).all(|(x, v)| fine(x, v));
        if parallel::each((&self.x[..], &self.v[..]), PIECE, &all_fine, &|a, b| a && b) {
            return Vec::new();
        }
        (0..self.len()).filter(|k| !fine(&self.x[*k], &self.v[*k])).collect()
    }

    /// Wraps everything into the box; returns the places of particles that are lost: beyond a fixed side, or more than a box
    /// length outside (LAMMPS wraps by one image, even at a set-up, and loses what is still outside).
    pub fn wrap(&mut self, simulation_box: &SimulationBox) -> Vec<Lost> {
        let wrap = |first: usize, (x, image): (&mut [Vec3], &mut [[i32; 3]])| {
            let mut lost = Vec::new();
            for (k, (x, image)) in x.iter_mut().zip(image).enumerate() {
                let from = *x;
                simulation_box.wrap_once(x, image);
                if let Some(axis) = simulation_box.outside(x) {
                    lost.push(Lost { place: first + k, position: from, far: simulation_box.periodic(axis) });
                }
            }
            lost
        };
        let join = |mut a: Vec<Lost>, b: Vec<Lost>| {
            a.extend(b);
            a
        };
        parallel::each((&mut self.x[..], &mut self.image[..]), PIECE, &wrap, &join)
    }

    /// Removes particles (ascending places) as LAMMPS does: axis after axis those that are beyond it, in storage order, the
    /// last particle filling each hole.
    pub fn remove(&mut self, lost: &[Lost], simulation_box: &SimulationBox) {
        let n = self.len();
        let mut pass = vec![3; n];
        for one in lost {
            let axis = simulation_box.outside(&self.x[one.place]);
            pass[self.home[one.place] as usize] = axis.unwrap_or(3);
        }
        let storage = survivors(&pass);
        let mut home = vec![u32::MAX; n];
        for (new, old) in storage.iter().enumerate() {
            home[*old] = new as u32;
        }
        for place in &mut self.home {
            *place = home[*place as usize];
        }
        let keep: Vec<bool> = self.home.iter().map(|home| *home != u32::MAX).collect();
        retain(&mut self.x, &keep);
        retain(&mut self.v, &keep);
        retain(&mut self.kind, &keep);
        retain(&mut self.image, &keep);
        retain(&mut self.id, &keep);
        retain(&mut self.mask, &keep);
        retain(&mut self.home, &keep);
    }

    /// Sorts storage order into bins of about `bin` (X fastest), as LAMMPS does: inside a bin the order stays.
    /// `order` is scratch.
    pub fn sort_storage(&mut self, simulation_box: &SimulationBox, bin: f64, order: &mut Vec<(u64, u32, u32)>) {
        let lengths = simulation_box.lengths();
        let bins = storage_bins(simulation_box, bin);
        if bins.product() <= 1.0 {
            return;
        }
        let place = |x: f64, axis: usize| {
            let inverse = bins[axis] / lengths[axis];
            locate(x, simulation_box.lo[axis], inverse, bins[axis] - 1.0).0 as u64
        };
        let counts = [bins.x as u64, bins.y as u64, bins.z as u64];
        order.clear();
        for (k, (at, home)) in self.x.iter().zip(&self.home).enumerate() {
            let bin = std::array::from_fn(|axis| place(at[axis], axis));
            order.push((row_major(bin, counts), *home, k as u32));
        }
        order.par_sort_unstable();
        for (home, (_, _, k)) in order.iter().enumerate() {
            self.home[*k as usize] = home as u32;
        }
    }

    /// Bounds of all positions, low and high; zeros where there are none.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let empty = || ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let join = |(mut lo, mut hi): ([f64; 3], [f64; 3]), (a, b): ([f64; 3], [f64; 3])| {
            for axis in 0..3 {
                lo[axis] = lo[axis].min(a[axis]);
                hi[axis] = hi[axis].max(b[axis]);
            }
            (lo, hi)
        };
        let (lo, hi) = self
            .x
            .par_iter()
            .with_min_len(PIECE)
            .map(|x| ((*x).into(), (*x).into()))
            .fold(empty, join)
            .reduce(empty, join);
        if self.len() == 0 { (Vec3::zeros(), Vec3::zeros()) } else { (lo.into(), hi.into()) }
    }

    /// The grid for the current positions.
    pub fn grid(&self, plan: SearchPlan, simulation_box: &SimulationBox, radius: f64) -> Grid {
        let (lo, hi) = self.bounds();
        Grid::new(plan, simulation_box, &lo, &hi, radius)
    }
}

/// Bins of about `bin` along each axis that storage order is sorted by, as LAMMPS counts them: one more or less is seen in
/// dumps that are not sorted.
pub fn storage_bins(simulation_box: &SimulationBox, bin: f64) -> Vec3 {
    let inverse = 1.0 / bin;
    simulation_box.lengths().map(|l| (l * inverse).floor().clamp(1.0, 1e6))
}

fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut k = 0;
    values.retain(|_| {
        k += 1;
        keep[k - 1]
    });
}
