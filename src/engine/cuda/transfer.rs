//! What goes between host and device: constants, particles, results.

use super::device::{Buffer, Plain};
use super::engine::Engine;
use super::layout::{PLACE_BITS, RUNS, TOTALS};
use super::plan::Plan;
use crate::engine::backend::Pair;
use crate::engine::fault::GoodState;
use crate::engine::particles::Particles;
use crate::system::{State, Vec3};

/// Room for the bounds that a block leaves.
const EACH: usize = TOTALS as usize;

/// Up to one in so many rows of the list are read one by one.
const FEW_ROWS: usize = 16;

impl Engine {
    pub(super) fn write_constants(&self) -> Result<(), String> {
        let Plan {
            shape, visits, visit_starts, limits, coefficients, images, fixed_shifts, shifts, half_kicks, ..
        } = &self.plan;
        let at = |name| self.memory.get(name);
        at("visits").write(0, visits)?;
        at("visit_starts").write(0, visit_starts)?;
        at("limits").write(0, limits)?;
        write_reals(at("coefficients"), coefficients, shape.double_pairs)?;
        at("masses").write(0, &self.program.masses)?;
        write_reals(at("half_kicks"), half_kicks, shape.double_store)?;
        for (name, values) in [("fixed_shifts", fixed_shifts), ("images", images)] {
            if let Some(buffer) = self.memory.find(name) {
                buffer.write(0, values)?;
            }
        }
        self.write_baths()?;
        self.memory.find("shifts").map_or(Ok(()), |buffer| buffer.write(0, shifts))
    }

    /// Puts particles on the device, to be sorted and listed from there.
    pub(super) fn write_particles(&mut self, particles: &Particles) -> Result<(), String> {
        let pitch = self.sizes.pitch as usize;
        let shape = &self.plan.shape;
        let column = |from: &[Vec3], axis: usize| -> Vec<f64> { from.iter().map(|x| x[axis]).collect() };
        let at = |name| self.memory.get(name);
        for axis in 0..3 {
            let (x, v) = (column(&particles.x, axis), column(&particles.v, axis));
            at("held_x").write(axis * pitch, &x)?;
            if shape.double_store {
                at("x").write(axis * pitch, &x)?;
                at("v").write(axis * pitch, &v)?;
                at("held_v").write(axis * pitch, &v)?;
            } else {
                let v: Vec<f32> = v.iter().map(|v| *v as f32).collect();
                at("x").write(axis * pitch, &vec![0.0f32; v.len()])?;
                at("v").write(axis * pitch, &v)?;
                at("held_v").write(axis * pitch, &v)?;
            }
            let image: Vec<i32> = particles.image.iter().map(|image| image[axis]).collect();
            at("held_image").write(axis * pitch, &image)?;
        }
        at("held_id").write(0, &particles.id)?;
        at("held_source").write(0, &particles.home)?;
        for (name, values) in
            [("held_home", &particles.home), ("held_kind", &particles.kind), ("held_mask", &particles.mask)]
        {
            if let Some(buffer) = self.memory.find(name) {
                buffer.write(0, values)?;
            }
        }
        at("counts").clear()?;
        self.control.n = particles.len() as u32;
        self.control.parity = 0;
        Ok(())
    }

    /// Brings back particles as they are now, or as the last build left them; in the order of that build.
    pub(super) fn read_particles(&self, now: bool) -> Result<Particles, String> {
        let (n, pitch) = (self.control.n as usize, self.sizes.pitch as usize);
        let side = self.control.parity as usize;
        let store = self.plan.shape.double_store;
        let read = |name: &str, at: usize| read_reals(self.memory.get(name), at, n, store);
        let mut axes: [(Vec<f64>, Vec<f64>, Vec<i32>); 3] = Default::default();
        for (axis, to) in axes.iter_mut().enumerate() {
            let at = (side * 3 + axis) * pitch;
            let mut x: Vec<f64> = self.memory.get("held_x").read(at, n)?;
            let v = if now { read("v", axis * pitch)? } else { read("held_v", at)? };
            if now {
                let moved = read("x", axis * pitch)?;
                if store {
                    x = moved;
                } else {
                    x.iter_mut().zip(moved).for_each(|(x, d)| *x += d);
                }
            }
            *to = (x, v, self.memory.get("held_image").read(at, n)?);
        }
        let source: Vec<u32> = self.memory.get("held_source").read(side * pitch, n)?;
        let home = match self.memory.find("held_home") {
            Some(buffer) => buffer.read(side * pitch, n)?,
            None => source.clone(),
        };
        let of = |values: &[u32]| source.iter().map(|k| values[*k as usize]).collect();
        let [(x, vx, ix), (y, vy, iy), (z, vz, iz)] = axes;
        Ok(Particles {
            x: (0..n).map(|k| Vec3::new(x[k], y[k], z[k])).collect(),
            v: (0..n).map(|k| Vec3::new(vx[k], vy[k], vz[k])).collect(),
            image: (0..n).map(|k| [ix[k], iy[k], iz[k]]).collect(),
            kind: of(&self.sources.kind),
            id: of(&self.sources.id),
            mask: of(&self.sources.mask),
            home,
        })
    }

    /// Forces in the order of the last build, force units.
    pub(super) fn forces(&self) -> Result<Vec<Vec3>, String> {
        let (n, pitch) = (self.control.n as usize, self.sizes.pitch as usize);
        let axis = |a: usize| read_reals(self.memory.get("f"), a * pitch, n, self.plan.shape.double_pairs);
        let (x, y, z) = (axis(0)?, axis(1)?, axis(2)?);
        Ok((0..n).map(|k| Vec3::new(x[k], y[k], z[k])).collect())
    }

    pub fn fetch(&self, state: &mut State) -> Result<(), String> {
        self.compiler.device.bind()?;
        if let Some(particles) = &self.loaded {
            particles.store(state);
            return Ok(());
        }
        let particles = self.read_particles(true)?;
        particles.store(state);
        for (home, f) in particles.home.iter().zip(self.forces()?) {
            state.f[*home as usize] = f;
        }
        Ok(())
    }

    /// Particles as the last build left them, if there was one.
    pub fn last_build(&self) -> Result<Option<GoodState>, String> {
        self.compiler.device.bind()?;
        let held = self.held()?;
        Ok(self.situation(&held, &held).last_build())
    }

    pub fn neighbor_counts(&self) -> Result<Vec<u32>, String> {
        self.compiler.device.bind()?;
        let particles = self.read_particles(false)?;
        let row: Vec<u32> = self.memory.get("neighbors").read(0, particles.len())?;
        let mut counts = vec![0; particles.len()];
        for (home, count) in particles.home.iter().zip(row) {
            counts[*home as usize] = count;
        }
        Ok(counts)
    }

    /// Pairs of the list whose first particle's id is wanted, sorted.
    pub fn order(&self) -> Result<Vec<u32>, String> {
        self.compiler.device.bind()?;
        Ok(self.read_particles(false)?.id)
    }

    pub fn pairs_where(&self, wanted: &dyn Fn(u32) -> bool) -> Result<Vec<Pair>, String> {
        self.compiler.device.bind()?;
        let held = self.read_particles(false)?;
        let (n, shape) = (held.len(), &self.plan.shape);
        let row: Vec<u32> = self.memory.get("neighbors").read(0, n)?;
        let rows: Vec<usize> = (0..n).filter(|i| wanted(held.id[*i])).collect();
        // A list can be far larger than the host's memory: where few rows are wanted, they alone come.
        let whole = if rows.len() > n / FEW_ROWS { self.entries(0, self.sizes.list as usize)? } else { Vec::new() };
        let homes: Vec<u32> = self.memory.find("homes").map_or(Ok(Vec::new()), |homes| homes.read(0, n))?;
        let runs: Vec<u32> = self
            .memory
            .find("runs")
            .map_or(Ok(Vec::new()), |runs| runs.read(0, self.plan.scene.buckets as usize * RUNS as usize))?;
        // A short entry in full: see `runs_of` in the kernels.
        let full = |i: usize, entry: u64| match homes.get(i) {
            Some(home) => {
                let run = *home as usize * RUNS as usize + (entry >> PLACE_BITS) as usize;
                u64::from(runs[run].wrapping_add(entry as u32))
            }
            None => entry,
        };
        let lengths = self.held_box.lengths();
        let mut pairs = Vec::new();
        for i in rows {
            let stretches = (0..(row[i] as usize).div_ceil(shape.chunk() as usize)).map(|k| self.stretch(&whole, k, i));
            let entries = stretches.collect::<Result<Vec<_>, _>>()?.concat();
            for entry in entries[..row[i] as usize].iter().map(|entry| full(i, *entry)) {
                let j = (entry & ((1 << shape.index_bits) - 1)) as usize;
                let image = if shape.images {
                    let [x, y, z, _] = self.plan.images[(entry >> shape.index_bits) as usize];
                    [x, y, z]
                } else {
                    // Coordinates go around with the box: the nearest image is the only one in reach.
                    let images = |a: usize| ((held.x[i][a] - held.x[j][a]) / lengths[a]).round() as i32;
                    std::array::from_fn(|a| if self.simulation_box.periodic(a) { images(a) } else { 0 })
                };
                pairs.push((held.id[i], held.id[j], image));
            }
        }
        pairs.sort_unstable();
        Ok(pairs)
    }

    /// The stretch number `k` of a particle's row, out of the whole list where it is there.
    fn stretch(&self, whole: &[u64], k: usize, particle: usize) -> Result<Vec<u64>, String> {
        let chunk = self.plan.shape.chunk() as usize;
        let at = (k * self.sizes.pitch as usize + particle) * chunk;
        whole.get(at..at + chunk).map_or_else(|| self.entries(at, chunk), |found| Ok(found.to_vec()))
    }

    /// Entries of the list as they lie.
    fn entries(&self, at: usize, count: usize) -> Result<Vec<u64>, String> {
        let list = self.memory.get("list");
        fn widen<T: Plain + Into<u64>>(entries: Vec<T>) -> Vec<u64> {
            entries.into_iter().map(Into::into).collect()
        }
        match self.plan.shape.entry() {
            2 => Ok(widen(list.read::<u16>(at, count)?)),
            4 => Ok(widen(list.read::<u32>(at, count)?)),
            _ => list.read(at, count),
        }
    }

    /// Bounds of all positions, low and high, as the blocks of the sort left them; zeros where there are no particles.
    pub(super) fn block_bounds(&self) -> Result<(Vec3, Vec3), String> {
        let all: Vec<f64> = self.memory.get("block_sums").read(0, EACH * self.compiled.sort.blocks as usize)?;
        let least = |side: usize| all.chunks_exact(EACH).map(|block| block[side]).fold(f64::INFINITY, f64::min);
        let bounds = (Vec3::from_fn(|a, _| least(a)), Vec3::from_fn(|a, _| -least(a + 3)));
        Ok(if self.control.n == 0 { Default::default() } else { bounds })
    }
}

fn write_reals(buffer: &Buffer, values: &[f64], double: bool) -> Result<(), String> {
    write_reals_at(buffer, 0, values, double)
}

pub(super) fn write_reals_at(buffer: &Buffer, at: usize, values: &[f64], double: bool) -> Result<(), String> {
    if double {
        buffer.write(at, values)
    } else {
        let values: Vec<f32> = values.iter().map(|x| *x as f32).collect();
        buffer.write(at, &values)
    }
}

pub(super) fn read_reals(buffer: &Buffer, at: usize, count: usize, double: bool) -> Result<Vec<f64>, String> {
    fn read<T: Plain>(buffer: &Buffer, at: usize, count: usize) -> Result<Vec<T>, String> {
        buffer.read(at, count)
    }
    if double {
        read(buffer, at, count)
    } else {
        Ok(read::<f32>(buffer, at, count)?.into_iter().map(f64::from).collect())
    }
}
