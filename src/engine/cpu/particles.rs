//! The particles of the CPU engine, in cell order.

use rayon::prelude::*;

use crate::neighbor::{Cells, Grid, Search};
use crate::system::state::survivors;
use crate::system::{SimulationBox, State, Vec3};

/// What pair arithmetic reads of a particle, half a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Site {
    /// Position, length units.
    pub x: [f64; 3],
    /// Type from 0.
    pub kind: u32,
    /// Place in storage order.
    pub home: u32,
}

impl Site {
    pub fn position(&self) -> Vec3 {
        Vec3::from(self.x)
    }
}

/// A particle that is no longer in the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lost {
    pub place: usize,
    /// Before it was wrapped, length units.
    pub position: Vec3,
    /// It has moved farther than the box is long since the last build.
    pub far: bool,
}

/// Structure of arrays, sorted by (cell, octant), ties by id. One entry a particle each.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    pub site: Vec<Site>,
    pub v: Vec<Vec3>,
    pub f: Vec<Vec3>,
    pub image: Vec<[i32; 3]>,
    pub id: Vec<u32>,
    pub mask: Vec<u32>,
}

impl Particles {
    /// Bytes of one particle in all arrays.
    pub const BYTES: usize = size_of::<Site>() + 2 * size_of::<Vec3>() + size_of::<[i32; 3]>() + 2 * size_of::<u32>();

    /// Copies a state.
    pub fn load(state: &State) -> Self {
        let site = |k: usize| Site { x: state.x[k].into(), kind: state.kind[k] - 1, home: k as u32 };
        Self {
            site: (0..state.len()).map(site).collect(),
            v: state.v.clone(),
            f: state.f.clone(),
            image: state.image.clone(),
            id: state.id.clone(),
            mask: state.mask.clone(),
        }
    }

    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Takes velocities and groups over from a state of the same particles.
    pub fn take_over_motion(&mut self, state: &State) {
        for ((site, v), mask) in self.site.iter().zip(&mut self.v).zip(&mut self.mask) {
            let home = site.home as usize;
            if let (Some(new_v), Some(new_mask)) = (state.v.get(home), state.mask.get(home)) {
                (*v, *mask) = (*new_v, *new_mask);
            }
        }
    }

    /// Writes everything back in storage order.
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
            let home = self.site[k].home as usize;
            state.id[home] = self.id[k];
            state.kind[home] = self.site[k].kind + 1;
            state.x[home] = self.site[k].position();
            state.v[home] = self.v[k];
            state.f[home] = self.f[k];
            state.image[home] = self.image[k];
            state.mask[home] = self.mask[k];
        }
    }

    /// Reorders all arrays by the order the cells were sorted in; `spare` holds the arrays swapped out.
    pub fn reorder(&mut self, cells: &Cells, spare: &mut Self) {
        fn gather<T: Copy + Send + Sync>(from: &mut Vec<T>, spare: &mut Vec<T>, cells: &Cells) {
            spare.clear();
            spare.par_extend(cells.sources().map(|k| from[k as usize]));
            std::mem::swap(from, spare);
        }
        gather(&mut self.site, &mut spare.site, cells);
        gather(&mut self.v, &mut spare.v, cells);
        gather(&mut self.f, &mut spare.f, cells);
        gather(&mut self.image, &mut spare.image, cells);
        gather(&mut self.id, &mut spare.id, cells);
        gather(&mut self.mask, &mut spare.mask, cells);
    }

    /// Places of all particles with a position or velocity that is no number.
    pub fn broken(&self) -> Vec<usize> {
        let fine = |k: usize| self.site[k].x.iter().chain(self.v[k].iter()).all(|c| c.is_finite());
        (0..self.len()).filter(|k| !fine(*k)).collect()
    }

    /// Wraps everything into the box; returns the places of particles that are lost: beyond a fixed side, or more than a box
    /// length outside (LAMMPS wraps by one image, even at a set-up, and loses what is still outside).
    pub fn wrap(&mut self, simulation_box: &SimulationBox) -> Vec<Lost> {
        let wrap_one = |(k, (site, image)): (usize, (&mut Site, &mut [i32; 3]))| {
            let mut x = site.position();
            let from = x;
            simulation_box.wrap_once(&mut x, image);
            site.x = x.into();
            let far = |axis| simulation_box.periodic(axis);
            simulation_box.outside(&x).map(|axis| Lost { place: k, position: from, far: far(axis) })
        };
        let pairs = self.site.par_iter_mut().with_min_len(4096).zip(self.image.par_iter_mut());
        pairs.enumerate().filter_map(wrap_one).collect()
    }

    /// Removes particles (ascending places) as LAMMPS does: axis after axis those that are beyond it, in storage order, the
    /// last particle filling each hole.
    pub fn remove(&mut self, lost: &[Lost], simulation_box: &SimulationBox) {
        let n = self.len();
        let mut pass = vec![3; n];
        for one in lost {
            let site = &self.site[one.place];
            pass[site.home as usize] = simulation_box.outside(&site.position()).unwrap_or(3);
        }
        let storage = survivors(&pass);
        let mut home = vec![u32::MAX; n];
        for (new, old) in storage.iter().enumerate() {
            home[*old] = new as u32;
        }
        for site in &mut self.site {
            site.home = home[site.home as usize];
        }
        let keep: Vec<bool> = self.site.iter().map(|s| s.home != u32::MAX).collect();
        retain(&mut self.v, &keep);
        retain(&mut self.f, &keep);
        retain(&mut self.image, &keep);
        retain(&mut self.id, &keep);
        retain(&mut self.mask, &keep);
        retain(&mut self.site, &keep);
    }

    /// Sorts storage order into bins of about `bin` (X fastest), as LAMMPS does: inside a bin the order stays.
    pub fn sort_storage(&mut self, simulation_box: &SimulationBox, bin: f64) {
        let lengths = simulation_box.lengths();
        let inverse = 1.0 / bin;
        // As LAMMPS does it: a bin more or less is seen in dumps that are not sorted.
        let bins = lengths.map(|l| (l * inverse).floor().clamp(1.0, 1e6));
        if bins.product() <= 1.0 {
            return;
        }
        let place = |x: f64, axis: usize| {
            let inverse = bins[axis] / lengths[axis];
            ((x - simulation_box.lo[axis]) * inverse).floor().clamp(0.0, bins[axis] - 1.0) as u64
        };
        let mut order: Vec<(u64, u32, u32)> = Vec::with_capacity(self.len());
        for (k, site) in self.site.iter().enumerate() {
            let [x, y, z] = std::array::from_fn(|axis| place(site.x[axis], axis));
            order.push(((z * bins.y as u64 + y) * bins.x as u64 + x, site.home, k as u32));
        }
        order.par_sort_unstable();
        for (home, (_, _, k)) in order.iter().enumerate() {
            self.site[*k as usize].home = home as u32;
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
        let (lo, hi) =
            self.site.par_iter().with_min_len(4096).map(|s| (s.x, s.x)).fold(empty, join).reduce(empty, join);
        if self.len() == 0 { (Vec3::zeros(), Vec3::zeros()) } else { (lo.into(), hi.into()) }
    }

    /// The grid for the current positions.
    pub fn grid(&self, search: Search, simulation_box: &SimulationBox, radius: f64) -> Grid {
        let (lo, hi) = self.bounds();
        Grid::new(search, simulation_box, &lo, &hi, radius)
    }
}

fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut k = 0;
    values.retain(|_| {
        k += 1;
        keep[k - 1]
    });
}
