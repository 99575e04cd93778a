//! What the backend asks of a loaded program, whatever its precision.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::engine::{Engine, by_type};
use super::mode::Mode;
use super::moving::Moving;
use super::sums::kinetic_sums;
use crate::engine::backend::{Pair, Reached, StageSeconds, Work};
use crate::engine::fault::{Fault, GoodState};
use crate::engine::observer::{Needs, NeighborStatistics, Sums};
use crate::engine::particles::Particles;
use crate::engine::program::Program;
use crate::neighbor::Policy;
use crate::real::lanes::{Element, FixedSlot};
use crate::system::{GROUP_ALL, SimulationBox, State, Vec3};

/// What a backend asks of a loaded program, whatever its precision; see [`crate::engine::Backend`].
pub trait Loaded: Send + Sync {
    fn set_up(&mut self, needs: Needs) -> Result<(), Fault>;
    fn go_on(&mut self, program: &Program, state: &State, step: i64);
    fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Fault>;
    fn step(&self) -> i64;
    fn fetch(&self, state: &mut State);
    fn last_build(&self) -> Option<GoodState>;
    fn sums(&self) -> Sums;
    fn memories(&self) -> Vec<Vec<f64>>;
    fn simulation_box(&self) -> &SimulationBox;
    fn statistics(&self) -> NeighborStatistics;
    fn seconds(&self) -> StageSeconds;
    fn work(&self) -> Work;
    fn neighbor_counts(&self) -> Vec<u32>;
    fn pairs_where(&self, wanted: &dyn Fn(u32) -> bool) -> Vec<Pair>;
    fn order(&self) -> Vec<u32>;
    fn bytes(&self) -> usize;
    fn lost(&self) -> usize;
    fn explain(&self) -> Vec<String>;
}

impl<M: Mode> Loaded for Engine<M> {
    fn set_up(&mut self, needs: Needs) -> Result<(), Fault> {
        self.statistics.builds = 0;
        self.statistics.dangerous = self.program.policy.check.then_some(0);
        self.build(true)?;
        self.set_up_thermostats();
        let result = self.forces(needs);
        self.seconds = StageSeconds::default();
        result
    }

    /// Takes over what a script may change without a set-up.
    fn go_on(&mut self, program: &Program, state: &State, step: i64) {
        let policy = Policy { skin: self.program.policy.skin, ..program.policy };
        let (timestep, masses, lost, range) = (program.timestep, program.masses.clone(), program.lost, program.range);
        self.program = Arc::new(Program { policy, timestep, masses, lost, range, ..Program::clone(&self.program) });
        self.half_kicks = by_type(self.program.half_kicks().into_iter());
        self.masses = by_type(self.program.masses.iter().copied());
        self.statistics.dangerous = policy.check.then(|| self.statistics.dangerous.unwrap_or(0));
        self.seconds = StageSeconds::default();
        self.step = step;
        for (k, home) in self.held.home.iter().enumerate() {
            if let (Some(v), Some(mask)) = (state.v.get(*home as usize), state.mask.get(*home as usize)) {
                for axis in 0..3 {
                    self.moving.v[axis][k] = M::Store::of(v[axis]);
                }
                (self.held.mask[k], self.moving.mask[k]) = (*mask, *mask);
            }
        }
        self.take_turns();
    }

    fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Fault> {
        for k in 1..=steps {
            let stopped = self.one_step(if k == steps { needs } else { Needs::default() });
            if let Err(fault) = stopped {
                self.half_done = false;
                return Err(fault);
            }
            if stop.load(Ordering::Relaxed) {
                if !(k == steps && needs.energy && needs.virial) {
                    // Whoever looks at the last step may want its sums.
                    self.forces(Needs { energy: true, virial: true, ..Needs::default() })?;
                }
                self.finish_step();
                return Ok(Reached::Interrupted);
            }
        }
        if steps > 0 {
            self.finish_step();
        }
        Ok(Reached::End)
    }

    fn step(&self) -> i64 {
        self.step
    }

    fn fetch(&self, state: &mut State) {
        if self.held.len() == 0 {
            return self.staging.store(state);
        }
        self.held.store(state);
        for frame in &self.moving.frames {
            for k in frame.first..frame.end {
                let home = self.held.home[k] as usize;
                let place = |axis: usize| self.moving.x[axis][k].double() + frame.origin[axis];
                state.x[home] = Vec3::from(std::array::from_fn(place));
                state.v[home] = Vec3::from(std::array::from_fn(|axis| self.moving.v[axis][k].double()));
                state.f[home] = self.moving.force(k);
            }
        }
    }

    fn last_build(&self) -> Option<GoodState> {
        self.scene(&self.held).last_build()
    }

    fn sums(&self) -> Sums {
        Sums {
            kinetic: kinetic_sums(&self.moving, &self.program.masses, self.isa),
            potential: self.pair_sums.energy,
            virial: self.pair_sums.virial,
            bath: self.bath(),
        }
    }

    fn memories(&self) -> Vec<Vec<f64>> {
        let mut memories = vec![Vec::new(); self.program.fixes.len()];
        for thermostat in &self.thermostats {
            memories[thermostat.place].clone_from(&thermostat.memory);
        }
        memories
    }

    fn simulation_box(&self) -> &SimulationBox {
        &self.simulation_box
    }

    fn statistics(&self) -> NeighborStatistics {
        self.statistics
    }

    fn seconds(&self) -> StageSeconds {
        self.seconds
    }

    fn work(&self) -> Work {
        let atoms = self.moving.len().max(1) as f64;
        Work {
            distance_tests_per_atom: self.list.tests as f64 / atoms,
            list_entries_per_atom: self.list.pairs() as f64 / atoms,
        }
    }

    fn neighbor_counts(&self) -> Vec<u32> {
        let mut counts = vec![0; self.held.len()];
        self.list.for_each_row(|k, _, row| counts[self.held.home[k] as usize] += row.len() as u32);
        counts
    }

    fn pairs_where(&self, wanted: &dyn Fn(u32) -> bool) -> Vec<Pair> {
        let id = &self.held.id;
        let mut pairs = Vec::new();
        self.list.for_each_row(|i, part, row| {
            if !wanted(id[i]) {
                return;
            }
            pairs.extend(row.iter().map(|slot| {
                let (j, image) = part.particle(*slot);
                (id[i], id[j], image)
            }));
        });
        pairs.sort_unstable();
        pairs
    }

    fn order(&self) -> Vec<u32> {
        self.held.id.clone()
    }

    fn bytes(&self) -> usize {
        // The particles as they move, as the last build left them, and where the next begins.
        let order = self.storage_order.capacity() * size_of::<(u64, u32, u32)>();
        let particles =
            order + self.moving.len() * (Moving::<M>::BYTES + 2 * Particles::BYTES + size_of::<FixedSlot>());
        let fallback = self.fallback.as_ref().map_or(0, |f| f.tiles.bytes() + f.slots.len() * (32 + 24));
        particles + self.cells.bytes() + self.list.bytes() + self.tiles.bytes() + self.pool.bytes() + fallback
    }

    fn lost(&self) -> usize {
        self.lost
    }

    fn explain(&self) -> Vec<String> {
        let pair = &self.program.pair;
        let lanes = self.kernel.lanes();
        let constants = match pair.types {
            1 => "one type: its constants stay in registers".to_string(),
            n if n <= lanes => format!("{n} types: constants are picked within registers"),
            n => format!("{n} types: constants are read from a table"),
        };
        let mut lines = vec![format!("Pair loop: {lanes} pairs at a time ({}); {constants}", self.isa.name())];
        let parts = || self.list.blocks().iter().flat_map(|block| block.parts());
        let (all, shifted) = (parts().count(), parts().filter(|part| part.images).count());
        lines.push(match shifted {
            0 => format!("Periodic shifts: none in {all} blocks"),
            n => format!("Periodic shifts: added as tiles are copied, in {n} of {all} blocks; the pair loop has none"),
        });
        let mut motion = Vec::new();
        if self.program.fixes.iter().all(|fix| fix.group == GROUP_ALL) {
            motion.push("look-up of groups (all fixes act on all atoms)");
        }
        if self.half_kicks.len() == 1 {
            motion.push("look-up of masses (one mass)");
        }
        if self.fallback.is_none() {
            motion.push("pair arithmetic in another precision");
        }
        if !motion.is_empty() {
            lines.push(format!("Left out here: {}", motion.join("; ")));
        }
        let work = self.work();
        let bytes = self.bytes() as f64 / self.moving.len().max(1) as f64;
        let (tests, entries) = (work.distance_tests_per_atom, work.list_entries_per_atom);
        lines.push(format!("An atom: {bytes:.0} bytes, {entries:.1} list entries out of {tests:.0} distances tested"));
        lines
    }
}
