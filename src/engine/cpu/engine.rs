//! A program with its particles: builds and steps.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::force::{PairKernel, PairSums, PairTask, pair_kernel};
use super::list::{List, Membership, Sorted};
use super::mode::{Double, Mode, Slot};
use super::motion::{FixKernel, Kicks, Piece, fix_kernel, kinetic_sums};
use super::moving::{Frame, Moving, PIECE, Pack};
use super::particles::Particles;
use super::scratch::{Pool, Tiles};
use super::trouble::Scene;
use crate::engine::backend::{Reached, StageSeconds, Work};
use crate::engine::fault::{Fault, FaultKind};
use crate::engine::observer::{Needs, NeighborStatistics, Sums};
use crate::engine::program::{Program, StorageSort};
use crate::neighbor::{Cells, Decision, LAMMPS_BIN, Policy};
use crate::real::Isa;
use crate::real::lanes::{DoubleSlot, Element, FixedSlot, with_simd};
use crate::system::parallel;
use crate::system::{LostAtoms, SimulationBox, State, Vec3};

/// What a backend asks of a loaded program, whatever its precision; see [`crate::engine::Backend`].
pub trait Loaded: Send + Sync {
    fn set_up(&mut self, needs: Needs) -> Result<(), Fault>;
    fn go_on(&mut self, program: &Program, state: &State, step: i64);
    fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Fault>;
    fn step(&self) -> i64;
    fn fetch(&self, state: &mut State);
    fn sums(&self) -> Sums;
    fn simulation_box(&self) -> &SimulationBox;
    fn statistics(&self) -> NeighborStatistics;
    fn seconds(&self) -> StageSeconds;
    fn work(&self) -> Work;
    fn neighbor_counts(&self) -> Vec<u32>;
    fn pairs(&self) -> Vec<(u32, u32, [i32; 3])>;
    fn bytes(&self) -> usize;
    fn lost(&self) -> usize;
    fn explain(&self) -> Vec<String>;
}

/// Pair arithmetic in double precision for a faster mode, where fixed point cannot hold the scene.
struct Fallback {
    kernel: Box<dyn PairKernel<Double>>,
    tiles: Tiles<DoubleSlot>,
    slots: Vec<DoubleSlot>,
    f: [Vec<f64>; 3],
}

/// A quantum of fixed-point coordinates is at most this part of the smallest cutoff, or double precision takes over: finer
/// than the rounding of f32.
const COARSEST_QUANTUM: f64 = 6e-8;

/// Whole numbers of quanta up to this are exact in doubles, with room to round them.
const MOST_QUANTA: f64 = (1u64 << 50) as f64;

/// A program with its particles.
pub struct Engine<M: Mode> {
    program: Arc<Program>,
    isa: Isa,
    simulation_box: SimulationBox,
    step: i64,
    /// Steps since the last build.
    ago: u64,
    /// Particles as they move.
    moving: Moving<M>,
    /// Particles as they were right after the last build.
    held: Particles,
    held_box: SimulationBox,
    held_step: i64,
    /// Where a build begins; as many as `held` between builds.
    staging: Particles,
    /// Storage order is sorted at the first build from this step on.
    next_sort: i64,
    cells: Cells,
    fixed: Vec<FixedSlot>,
    list: List,
    kernel: Box<dyn PairKernel<M>>,
    fallback: Option<Box<Fallback>>,
    /// Fixed point cannot hold this scene.
    too_coarse: bool,
    tiles: Tiles<M::Slot>,
    pool: Pool,
    fixes: Vec<Box<dyn FixKernel<M>>>,
    half_kicks: Vec<M::Store>,
    neighbor_cutoffs: Vec<f64>,
    /// No particle has moved further than this since the last build, length units.
    travel: f64,
    /// The second half of the last step is still to be done.
    half_done: bool,
    pair_sums: PairSums,
    statistics: NeighborStatistics,
    seconds: StageSeconds,
    lost: usize,
}

impl<M: Mode> Engine<M> {
    pub fn new(
        program: Arc<Program>,
        state: &State,
        simulation_box: &SimulationBox,
        step: i64,
        isa: Isa,
        threads: usize,
    ) -> Self {
        let kernel = pair_kernel(&program.pair, isa).expect("the scene names a registered pair style");
        Self {
            isa,
            simulation_box: simulation_box.clone(),
            step,
            ago: 0,
            moving: Moving::default(),
            held: Particles::default(),
            held_box: simulation_box.clone(),
            held_step: step,
            staging: Particles::load(state),
            next_sort: step,
            cells: Cells::default(),
            fixed: Vec::new(),
            list: List::default(),
            kernel,
            fallback: None,
            too_coarse: false,
            tiles: Tiles::new(threads),
            pool: Pool::new(threads),
            fixes: program.fixes.iter().filter_map(|fix| fix_kernel(fix, isa)).collect(),
            half_kicks: half_kicks::<M>(&program),
            neighbor_cutoffs: program.pair.neighbor_cutoffs(program.policy.skin),
            travel: 0.0,
            half_done: false,
            pair_sums: PairSums::default(),
            statistics: NeighborStatistics::default(),
            seconds: StageSeconds::default(),
            lost: 0,
            program,
        }
    }

    fn scene<'a>(&'a self, now: &'a Particles) -> Scene<'a> {
        Scene {
            step: self.step,
            now,
            now_box: &self.simulation_box,
            held: &self.held,
            held_box: &self.held_box,
            held_step: self.held_step,
        }
    }

    /// Particles as they are now, in `staging`.
    fn stage(&mut self) {
        if self.held.len() == 0 {
            return;
        }
        let Self { staging, held, moving, .. } = self;
        staging.clone_from(held);
        moving.copy_to(staging);
    }

    /// Wraps, sorts, lists.
    fn build(&mut self, set_up: bool) -> Result<(), Fault> {
        let clock = Instant::now();
        self.stage();
        let broken = self.staging.broken();
        if !broken.is_empty() {
            return Err(self.scene(&self.staging).fault(FaultKind::Position, &broken));
        }
        if self.simulation_box.shrinks() {
            let (low, high) = self.staging.bounds();
            if self.staging.len() > 0 {
                self.simulation_box.shrink_wrap(&[low, high]);
            }
        }
        let lost = self.staging.wrap(&self.simulation_box);
        if !lost.is_empty() {
            if self.program.lost == LostAtoms::Error {
                return Err(self.scene(&self.staging).lost(&lost));
            }
            self.lost += lost.len();
            self.staging.remove(&lost, &self.simulation_box);
        }
        let radius = self.neighbor_cutoffs.iter().copied().fold(0.0, f64::max);
        self.sort_storage(set_up, radius);
        let grid = self.staging.grid(self.program.search, &self.simulation_box, radius);
        let Self { staging, held, cells, .. } = self;
        cells.build(staging.len(), grid.cells(), |k| grid.key(&staging.x[k]), &staging.id);
        held.gather(staging, cells);
        self.moving.take(&mut self.held, &grid, &self.cells, &self.simulation_box);
        self.seconds.sort += clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        let quanta = List::quanta(&grid);
        self.moving.quanta = quanta;
        let smallest = self.neighbor_cutoffs.iter().copied().filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
        let coordinate = self.simulation_box.lo.amax().max(self.simulation_box.hi.amax());
        let images = self.simulation_box.lengths().amax() + 2.0 * radius;
        self.too_coarse =
            1.0 / quanta > COARSEST_QUANTUM * smallest || (coordinate + 2.0 * images) * quanta > MOST_QUANTA;
        self.moving.pack(self.isa, quanta, &mut self.fixed);
        let membership =
            Membership::new(self.program.pair.types, &self.neighbor_cutoffs, &self.simulation_box, quanta, self.isa);
        let sorted = Sorted { particles: &self.held, fixed: &self.fixed, grid: &grid, cells: &self.cells };
        self.list.build(sorted, &membership, self.isa, self.kernel.lanes(), &self.pool);
        self.statistics.pairs = self.list.pairs() / 2;
        let mut slots = std::mem::take(&mut self.moving.slots);
        self.moving.pack(self.isa, quanta, &mut slots);
        self.moving.slots = slots;
        self.held_box.clone_from(&self.simulation_box);
        self.held_step = self.step;
        self.ago = 0;
        self.travel = 0.0;
        self.seconds.list += clock.elapsed().as_secs_f64();
        Ok(())
    }

    fn sort_storage(&mut self, set_up: bool, radius: f64) {
        let Some(StorageSort { every, bin }) = self.program.storage_sort else { return };
        let bin = if bin > 0.0 { bin } else { LAMMPS_BIN * radius };
        if every > 0 && bin > 0.0 && (set_up || self.step >= self.next_sort) {
            self.staging.sort_storage(&self.simulation_box, bin);
            self.next_sort = (self.step / every + 1) * every;
        }
    }

    fn forces(&mut self, needs: Needs) -> Result<(), Fault> {
        let sums = needs.energy || needs.virial;
        let lengths = self.held_box.lengths().into();
        if M::Slot::FIXED && self.is_out_of_range() {
            self.forces_in_double(sums, lengths);
        } else {
            let Self { moving, list, tiles, kernel, .. } = self;
            let n = moving.len();
            let task = PairTask { list, slots: &moving.slots, quanta: moving.quanta, lengths, tiles, sums };
            self.pair_sums = kernel.forces(&task, moving.f.each_mut().map(|a| &mut a[..n]));
        }
        if self.pair_sums.broken {
            let finite = |k: &usize| self.moving.force(*k).iter().all(|c| c.is_finite());
            let broken: Vec<usize> = (0..self.moving.len()).filter(|k| !finite(k)).collect();
            if !broken.is_empty() {
                self.stage();
                return Err(self.scene(&self.staging).fault(FaultKind::Force, &broken));
            }
        }
        Ok(())
    }

    /// Whether differences of fixed-point coordinates could be wrong: the grid is too coarse for them, or particles have moved
    /// far since the build, which a script without rebuilds allows.
    fn is_out_of_range(&mut self) -> bool {
        let radius = self.neighbor_cutoffs.iter().copied().fold(0.0, f64::max);
        if !self.too_coarse && self.travel > radius {
            self.travel = self.moving.displacement().sqrt();
        }
        self.too_coarse || self.travel > radius
    }

    fn forces_in_double(&mut self, sums: bool, lengths: [f64; 3]) {
        let Self { moving, list, kernel, fallback, isa, program, .. } = self;
        let threads = rayon::current_num_threads();
        let fallback = fallback.get_or_insert_with(|| {
            let kernel = pair_kernel(&program.pair, *isa).expect("the scene names a registered pair style");
            let (slots, f) = (Vec::new(), [Vec::new(), Vec::new(), Vec::new()]);
            Box::new(Fallback { kernel, tiles: Tiles::new(threads), slots, f })
        });
        let n = moving.len();
        moving.pack(*isa, 1.0, &mut fallback.slots);
        fallback.f.iter_mut().for_each(|axis| axis.resize(n, 0.0));
        let Fallback { kernel: double, tiles, slots, f } = &mut **fallback;
        // Rows are filled up for the faster kernel's lanes, of which there are at least as many.
        debug_assert!(kernel.lanes().is_multiple_of(double.lanes()));
        let task = PairTask { list, slots, quanta: 1.0, lengths, tiles, sums };
        self.pair_sums = double.forces(&task, f.each_mut().map(|axis| &mut axis[..]));
        for (to, from) in moving.f.iter_mut().zip(&fallback.f) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = M::Force::of(*from);
            }
        }
    }

    /// The second half of the last step if it is still to be done, then the first half of the next one if there is one.
    fn move_particles(&mut self, initial: bool) {
        let last = std::mem::take(&mut self.half_done);
        let Self { moving, fixes, program, half_kicks, isa, .. } = self;
        let kicks = Kicks { dt: M::Store::of(program.timestep), half: &half_kicks[..] };
        let (frames, quanta, isa) = (std::mem::take(&mut moving.frames), moving.quanta, *isa);
        let work = |first: usize, mut piece: Piece<'_, M>| {
            let mut travel = 0.0;
            if last {
                fixes.iter().for_each(|fix| fix.last(&mut piece, &kicks));
            }
            if initial {
                for fix in fixes.iter() {
                    travel += fix.initial(&mut piece, &kicks).sqrt();
                }
                let frames: &[Frame] = &frames;
                let Piece { x, kind, slots, .. } = piece;
                let x = x.map(|axis| &*axis);
                with_simd(isa, Pack::<M, M::Slot> { first, x, kinds: kind, frames, quanta, to: slots });
            }
            travel
        };
        let travel = parallel::each(Piece::all(moving), PIECE, &work, &f64::max);
        moving.frames = frames;
        // Rounding of the sum must not let a particle slip through the check.
        self.travel = (self.travel + travel) * (1.0 + 4.0 * f64::EPSILON);
    }

    /// Has any particle moved further than the policy allows? Particles are only looked at if one can have.
    fn moved_too_far(&mut self) -> bool {
        let trigger = self.program.policy.trigger();
        // In single precision, positions round as they are added up.
        let slack = if M::RELATIVE { 0.99 } else { 1.0 - 1e-12 };
        if self.travel < slack * trigger.sqrt() {
            return false;
        }
        let squared = self.moving.displacement();
        self.travel = squared.sqrt();
        squared > trigger
    }

    fn one_step(&mut self, needs: Needs) -> Result<(), Fault> {
        let mut clock = Instant::now();
        let mut lap = move || {
            let now = Instant::now();
            let passed = now - clock;
            clock = now;
            passed.as_secs_f64()
        };
        self.step += 1;
        self.ago += 1;
        self.move_particles(true);
        self.seconds.modify += lap();
        let build = match self.program.policy.decide(self.ago) {
            Decision::Keep => false,
            Decision::Build => true,
            Decision::Check { first_chance } => {
                let far = self.moved_too_far();
                if far && first_chance {
                    self.statistics.dangerous = self.statistics.dangerous.map(|n| n + 1);
                }
                self.seconds.check += lap();
                far
            }
        };
        if build {
            self.build(false)?;
            self.statistics.builds += 1;
            lap();
        }
        self.forces(needs)?;
        self.half_done = true;
        self.seconds.pair += lap();
        Ok(())
    }

    fn finish_step(&mut self) {
        let clock = Instant::now();
        self.move_particles(false);
        self.seconds.modify += clock.elapsed().as_secs_f64();
    }
}

/// dt / 2 / mass by type; one number where all types have the same.
fn half_kicks<M: Mode>(program: &Program) -> Vec<M::Store> {
    let mut kicks: Vec<M::Store> = program.half_kicks().into_iter().map(M::Store::of).collect();
    if kicks.iter().all(|kick| *kick == kicks[0]) {
        kicks.truncate(1);
    }
    kicks
}

impl<M: Mode> Loaded for Engine<M> {
    fn set_up(&mut self, needs: Needs) -> Result<(), Fault> {
        self.statistics.builds = 0;
        self.statistics.dangerous = self.program.policy.check.then_some(0);
        self.build(true)?;
        let result = self.forces(needs);
        self.seconds = StageSeconds::default();
        result
    }

    /// Takes over what a script may change without a set-up.
    fn go_on(&mut self, program: &Program, state: &State, step: i64) {
        let policy = Policy { skin: self.program.policy.skin, ..program.policy };
        let (timestep, masses, lost) = (program.timestep, program.masses.clone(), program.lost);
        self.program = Arc::new(Program { policy, timestep, masses, lost, ..Program::clone(&self.program) });
        self.half_kicks = half_kicks::<M>(&self.program);
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

    fn sums(&self) -> Sums {
        Sums {
            kinetic: kinetic_sums(&self.moving, &self.program.masses),
            potential: self.pair_sums.energy,
            virial: self.pair_sums.virial,
        }
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

    fn pairs(&self) -> Vec<(u32, u32, [i32; 3])> {
        let id = &self.held.id;
        let mut pairs = Vec::new();
        self.list.for_each_row(|i, part, row| {
            pairs.extend(row.iter().map(|slot| {
                let (j, image) = part.particle(*slot);
                (id[i], id[j], image)
            }));
        });
        pairs.sort_unstable();
        pairs
    }

    fn bytes(&self) -> usize {
        // The particles as they move, as the last build left them, and where the next begins.
        let particles = self.moving.len() * (Moving::<M>::BYTES + 2 * Particles::BYTES + size_of::<FixedSlot>());
        let fallback = self.fallback.as_ref().map_or(0, |f| f.tiles.bytes() + f.slots.len() * (32 + 24));
        particles + self.cells.bytes() + self.list.bytes() + self.tiles.bytes() + self.pool.bytes() + fallback
    }

    fn lost(&self) -> usize {
        self.lost
    }

    fn explain(&self) -> Vec<String> {
        Vec::new()
    }
}
