//! A program with its particles: builds and steps.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use super::fallback::Fallback;
use super::force::{PairKernel, PairSums, PairTask, pair_kernel};
use super::list::{List, Sorted};
use super::membership::Membership;
use super::mode::{Mode, Slot};
use super::motion::{FixKernel, Kicks, Piece, fix_kernel};
use super::moving::{Frame, Moving, PIECE, Pack};
use super::scratch::{Pool, Tiles};
use super::sums::displacement;
use crate::dynamics::Phase;
use crate::dynamics::thermostat::{Moment, Thermostat};
use crate::engine::backend::StageSeconds;
use crate::engine::fault::{Fault, FaultKind};
use crate::engine::observer::{Needs, NeighborStatistics};
use crate::engine::particles::Particles;
use crate::engine::program::{Program, StorageSort};
use crate::engine::trouble::Scene;
use crate::neighbor::guard::COARSEST_QUANTUM;
use crate::neighbor::{Cells, Decision, LAMMPS_BIN};
use crate::real::Isa;
use crate::real::lanes::{Element, FixedSlot, with_simd};
use crate::system::parallel;
use crate::system::{LostAtoms, SimulationBox, State};

/// Whole numbers of quanta up to this are exact in doubles, with room to round them.
const MOST_QUANTA: f64 = (1u64 << 50) as f64;

/// A program with its particles.
pub struct Engine<M: Mode> {
    pub(super) program: Arc<Program>,
    pub(super) isa: Isa,
    pub(super) simulation_box: SimulationBox,
    pub(super) step: i64,
    /// Steps since the last build.
    pub(super) ago: u64,
    /// Particles as they move.
    pub(super) moving: Moving<M>,
    /// Particles as they were right after the last build.
    pub(super) held: Particles,
    pub(super) held_box: SimulationBox,
    pub(super) held_step: i64,
    /// Where a build begins; as many as `held` between builds.
    pub(super) staging: Particles,
    /// Storage order is sorted at the first build from this step on.
    pub(super) next_sort: i64,
    pub(super) storage_order: Vec<(u64, u32, u32)>,
    pub(super) cells: Cells,
    pub(super) fixed: Vec<FixedSlot>,
    pub(super) membership: Membership,
    pub(super) list: List,
    pub(super) kernel: Box<dyn PairKernel<M>>,
    pub(super) fallback: Option<Box<Fallback>>,
    /// Fixed point cannot hold this scene.
    pub(super) too_coarse: bool,
    pub(super) tiles: Tiles<M::Slot>,
    pub(super) pool: Pool,
    pub(super) fixes: Vec<Box<dyn FixKernel<M>>>,
    /// Of each fix, the factors on velocities at the end of the last step and at the start of this one.
    pub(super) scales: Vec<[f64; 2]>,
    pub(super) thermostats: Vec<Thermostat>,
    /// A thermostat precedes another fix that kicks the same atoms: each fix ends the step by itself.
    pub(super) in_turn: bool,
    pub(super) half_kicks: Vec<M::Store>,
    pub(super) masses: Vec<M::Force>,
    pub(super) neighbor_cutoffs: Vec<f64>,
    /// No particle has moved further than this since the last build, length units.
    pub(super) travel: f64,
    /// The second half of the last step is still to be done.
    pub(super) half_done: bool,
    pub(super) pair_sums: PairSums,
    pub(super) statistics: NeighborStatistics,
    pub(super) seconds: StageSeconds,
    pub(super) lost: usize,
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
            storage_order: Vec::new(),
            membership: Membership::default(),
            cells: Cells::default(),
            fixed: Vec::new(),
            list: List::default(),
            kernel,
            fallback: None,
            too_coarse: false,
            tiles: Tiles::new(threads),
            pool: Pool::new(threads),
            fixes: program.fixes.iter().filter_map(|fix| fix_kernel(fix, isa)).collect(),
            scales: vec![[1.0; 2]; program.fixes.len()],
            thermostats: Thermostat::all(&program.fixes),
            in_turn: false,
            half_kicks: by_type(program.half_kicks().into_iter()),
            masses: by_type(program.masses.iter().copied()),
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

    pub(super) fn scene<'a>(&'a self, now: &'a Particles) -> Scene<'a> {
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
        staging.copy_from(held);
        moving.copy_to(staging);
    }

    /// Wraps, sorts, lists.
    pub(super) fn build(&mut self, set_up: bool) -> Result<(), Fault> {
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
        let Self { staging, held, cells, program, .. } = self;
        cells.build(&grid, program.search.sort(), &staging.x, &staging.id);
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
        let types = self.program.pair.types;
        self.membership.update(types, &self.neighbor_cutoffs, &self.simulation_box, quanta, self.isa);
        let sorted = Sorted { particles: &self.held, fixed: &self.fixed, grid: &grid, cells: &self.cells };
        self.list.build(sorted, &self.membership, self.isa, self.kernel.lanes(), &self.pool);
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
            self.staging.sort_storage(&self.simulation_box, bin, &mut self.storage_order);
            self.next_sort = (self.step / every + 1) * every;
        }
    }

    pub(super) fn forces(&mut self, needs: Needs) -> Result<(), Fault> {
        let sums = needs.sums();
        let lengths = self.held_box.lengths().into();
        if M::Slot::FIXED && self.is_out_of_range() {
            self.forces_in_double(sums, lengths);
        } else {
            let Self { moving, list, tiles, kernel, .. } = self;
            let n = moving.len();
            let task = PairTask { list, slots: &moving.slots, quanta: moving.quanta, lengths, tiles, sums };
            self.pair_sums = kernel.forces(&task, moving.f.each_mut().map(|a| &mut a[..n]));
        }
        self.add_forces();
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

    /// What fixes add to the forces of the pairs.
    fn add_forces(&mut self) {
        if !self.fixes.iter().any(|fix| fix.acts(Phase::Force)) {
            return;
        }
        let Self { moving, fixes, program, half_kicks, masses, held, step, .. } = self;
        let (dt, ids, step) = (M::Store::of(program.timestep), &held.id[..], *step);
        let progress = program.progress(step);
        let work = |first: usize, mut piece: Piece<'_, M>| {
            let kicks = Kicks { dt, half: half_kicks, masses, ids, step, progress, frames: &[], first };
            for fix in fixes.iter().filter(|fix| fix.acts(Phase::Force)) {
                fix.act(Phase::Force, &mut piece, &kicks, 1.0);
            }
        };
        parallel::each(Piece::all(moving), PIECE, &work, &|(), ()| ());
    }

    /// The second half of the last step if it is still to be done, then the first half of the next one if there is one.
    fn move_particles(&mut self, initial: bool) {
        let last = std::mem::take(&mut self.half_done);
        let all = 0..self.fixes.len();
        if self.thermostats.is_empty() {
            return self.pass(if last { &[Phase::Last] } else { &[] }, all, initial);
        }
        // The first half of the next step may be under way.
        let ending = self.step - i64::from(initial);
        let mut ends: &[Phase] = &[];
        if last && self.in_turn {
            self.end_in_turn(ending);
        } else if last {
            self.pass(&[Phase::Last], all.clone(), false);
            self.ask_thermostats(0..self.thermostats.len(), Moment::EndOfStep, ending);
            ends = &[Phase::Measured];
        }
        if initial {
            self.ask_thermostats(0..self.thermostats.len(), Moment::StartOfStep, self.step);
        }
        self.pass(ends, all, initial);
    }

    /// The second half of a step, one fix after another: a thermostat scales what the fixes before it and its own kick have left.
    fn end_in_turn(&mut self, step: i64) {
        let mut next = 0;
        for k in 0..self.thermostats.len() {
            let place = self.thermostats[k].place;
            self.pass(&[Phase::Last], next..place + 1, false);
            self.ask_thermostats(k..k + 1, Moment::EndOfStep, step);
            self.pass(&[Phase::Measured], place..place + 1, false);
            next = place + 1;
        }
        self.pass(&[Phase::Last], next..self.fixes.len(), false);
    }

    /// One pass over the particles: phases of some fixes that end a step, then the first half of a step if there is one.
    fn pass(&mut self, ends: &[Phase], which: Range<usize>, initial: bool) {
        let Self { moving, fixes, program, half_kicks, masses, isa, held, step, scales, .. } = self;
        let (dt, ids, step) = (M::Store::of(program.timestep), &held.id[..], *step);
        let progress = program.progress(step);
        let (frames, quanta, isa) = (std::mem::take(&mut moving.frames), moving.quanta, *isa);
        let work = |first: usize, mut piece: Piece<'_, M>| {
            let mut travel = 0.0;
            let frames: &[Frame] = &frames;
            let kicks = Kicks { dt, half: half_kicks, masses, ids, step, progress, frames, first };
            let mut act = |phase: Phase| {
                let start = usize::from(phase == Phase::Initial);
                let which = fixes[which.clone()].iter().zip(&scales[which.clone()]);
                for (fix, scale) in which.filter(|(fix, _)| fix.acts(phase)) {
                    travel += fix.act(phase, &mut piece, &kicks, scale[start]).sqrt();
                }
            };
            ends.iter().for_each(|phase| act(*phase));
            if initial {
                act(Phase::Initial);
                act(Phase::Moved);
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
        let squared = displacement(&self.moving, self.isa);
        self.travel = squared.sqrt();
        squared > trigger
    }

    pub(super) fn one_step(&mut self, needs: Needs) -> Result<(), Fault> {
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

    pub(super) fn finish_step(&mut self) {
        let clock = Instant::now();
        self.move_particles(false);
        self.seconds.modify += clock.elapsed().as_secs_f64();
    }
}

/// Numbers by type; one where all types have the same.
pub fn by_type<E: Element>(numbers: impl Iterator<Item = f64>) -> Vec<E> {
    let mut numbers: Vec<E> = numbers.map(E::of).collect();
    if numbers.iter().all(|number| *number == numbers[0]) {
        numbers.truncate(1);
    }
    numbers
}
