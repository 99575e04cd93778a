//! A program with its particles on the device: arrays and constants, builds that begin on the host, faults.

use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use super::compiled::{Compiled, compile};
use super::compiler::Compiler;
use super::fixes::bath_numbers;
use super::layout::*;
use super::memory::{self, Memory, Sizes, Values};
use super::plan::{Given, Plan, Tuning};
use super::shape::Shape;
use super::transfer::write_reals_at;
use crate::dynamics::thermostat::Thermostat;
use crate::engine::Precision;
use crate::engine::backend::{StageSeconds, Stop};
use crate::engine::fault::{Fault, FaultKind};
use crate::engine::observer::{Needs, NeighborStatistics, Sums};
use crate::engine::particles::Particles;
use crate::engine::program::Program;
use crate::engine::trouble::Scene as Situation;
use crate::neighbor::{Policy, estimate};
use crate::system::{LostAtoms, SimulationBox, State, Vec3};

/// Room in rows beyond the mean of an even spread.
const ROOM: f64 = 1.4;

/// Ids, types and groups as they were loaded; the device knows particles by their place here.
#[derive(Default)]
pub(super) struct Sources {
    pub id: Vec<u32>,
    pub kind: Vec<u32>,
    pub mask: Vec<u32>,
}

/// A program with its particles.
pub struct Engine {
    pub program: Arc<Program>,
    pub(super) precision: Precision,
    pub(super) tuning: Tuning,
    pub simulation_box: SimulationBox,
    pub(super) held_box: SimulationBox,
    pub(super) held_step: i64,
    pub(super) sources: Sources,
    /// There is a list.
    pub(super) built: bool,
    /// Particles before the first set-up.
    pub(super) loaded: Option<Particles>,
    pub plan: Plan,
    pub compiled: Compiled,
    pub(super) sizes: Sizes,
    pub memory: Memory,
    /// As the last launch left it.
    pub control: Control,
    /// As the last launches left them: energy (of all rows) and virial by the one that was asked for them, kinetic sums by the
    /// last that came to an end.
    pub(super) sums: [f64; SUMS as usize],
    /// Of the virial more was asked for than its trace.
    pub(super) tensor: bool,
    /// Those of the current velocities are there.
    pub(super) summed: bool,
    /// Of the steps that the launches of the order under way have recorded.
    pub(super) recorded: Vec<Sums>,
    pub(super) thermostats: Vec<Thermostat>,
    pub lost: usize,
    /// The last launch came back for lost particles.
    pub(super) losing: bool,
    /// Times that arrays had to grow, or the grid to move.
    pub redone: u64,
    /// Runs of particles have been longer than short entries can say.
    pub(super) long_runs: bool,
    /// The step of the last set-up, from which on builds are counted.
    pub(super) counting_from: i64,
    pub(super) seconds_per_step: f64,
    pub(super) base: [u64; 5],
    /// The wall time that the first set-up took beyond opening the device.
    pub start_up: f64,
    /// Last, as the device has to outlive what is on it.
    pub(super) compiler: Rc<Compiler>,
}

impl Engine {
    pub fn new(
        compiler: Rc<Compiler>,
        program: Arc<Program>,
        state: &State,
        simulation_box: &SimulationBox,
        step: i64,
        precision: Precision,
        tuning: Tuning,
    ) -> Result<Self, String> {
        let clock = Instant::now();
        compiler.device.bind()?;
        let particles = Particles::load(state);
        let mut simulation_box = simulation_box.clone();
        shrink(&mut simulation_box, &particles);
        let plan = Plan::new(&Given {
            program: &program,
            simulation_box: &simulation_box,
            bounds: particles.bounds(),
            n: particles.len(),
            precision,
            double_pairs: false,
            long_runs: false,
            tuning,
            architecture: &compiler.device.architecture(),
        });
        let compiled = compile(&compiler, &program, &plan.shape, particles.len())?;
        let sources = Sources { id: particles.id.clone(), kind: particles.kind.clone(), mask: particles.mask.clone() };
        let thermostats = Thermostat::all(&program.fixes);
        let mut engine = Self {
            held_box: simulation_box.clone(),
            held_step: step,
            compiler,
            program,
            precision,
            tuning,
            simulation_box,
            sources,
            built: false,
            loaded: None,
            plan,
            compiled,
            sizes: Sizes::default(),
            memory: Memory::default(),
            control: Control { step, next_sort: step, ..Control::default() },
            sums: [0.0; SUMS as usize],
            tensor: false,
            summed: false,
            recorded: Vec::new(),
            thermostats,
            lost: 0,
            losing: false,
            redone: 0,
            long_runs: false,
            counting_from: step,
            seconds_per_step: 0.0,
            base: [0; 5],
            start_up: 0.0,
        };
        engine.allocate(&particles, state)?;
        engine.loaded = Some(particles);
        engine.start_up = clock.elapsed().as_secs_f64();
        Ok(engine)
    }

    /// Arrays for the current plan and so many particles.
    fn allocate(&mut self, particles: &Particles, state: &State) -> Result<(), String> {
        let n = particles.len();
        let plan = &self.plan;
        let radius = self.program.pair.neighbor_cutoffs(self.program.policy.skin).into_iter().fold(0.0, f64::max);
        let bytes = estimate::ListBytes { entry: plan.shape.entry(), stretch: 0 };
        let each = estimate::estimate(state, &self.simulation_box, radius, bytes).entries / n.max(1) as f64;
        let rows = self.tuning.capacity.map_or(each * ROOM + 16.0, f64::from).min(2e9);
        let values = Values {
            visits: plan.visits.len() as u64,
            types: plan.shape.types as u64,
            coefficients: plan.coefficients.len() as u64,
            codes: plan.images.len() as u64,
            baths: 2 * bath_numbers(&self.program.fixes) as u64,
        };
        self.sizes = Sizes {
            pitch: memory::pitch(n),
            buckets: plan.most_buckets,
            blocks: self.compiled.blocks().into(),
            records: 0,
            list: 0,
            values,
        };
        self.set_capacity(rows as u32);
        self.memory = Memory::default();
        self.memory = Memory::new(&self.compiler.device, &self.plan.shape, &self.sizes, n)?;
        self.write_constants()
    }

    pub(super) fn set_capacity(&mut self, wanted: u32) {
        let (lanes, chunk) = (self.plan.shape.lanes, self.plan.shape.chunk());
        let capacity = wanted.max(1).next_multiple_of(chunk);
        (self.plan.scene.capacity, self.plan.scene.pitch) = (capacity, self.sizes.pitch);
        // Every thread of a row reads its first chunk before it knows whether there is one: waiting for that would take longer.
        self.sizes.list = u64::from(capacity.max(lanes * chunk)) * self.sizes.pitch;
    }

    /// Set-up of a run.
    pub fn set_up(&mut self, needs: Needs) -> Result<(), Stop> {
        self.control.builds = 0;
        self.counting_from = self.control.step;
        self.control.dangerous = 0;
        self.redone = 0;
        let particles = match self.loaded.take() {
            Some(particles) => particles,
            None => self.read_particles(true)?,
        };
        self.control.half_done = 0;
        self.control.left = 0;
        self.ask(needs);
        self.build_from(particles, Order { sums: needs.sums().into(), set_up: 1, ..Order::default() })?;
        self.base = self.control.nanoseconds;
        Ok(())
    }

    /// A build that begins on the host: particles are looked at, the box and the grid follow them.
    pub(super) fn build_from(&mut self, mut particles: Particles, order: Order) -> Result<(), Stop> {
        // In storage order, by which the device knows particles from here on.
        let mut state = State::default();
        particles.store(&mut state);
        particles = Particles::load(&state);
        let broken = particles.broken();
        if !broken.is_empty() {
            return Err(self.fault(FaultKind::Position, &particles, &broken)?.into());
        }
        shrink(&mut self.simulation_box, &particles);
        let mut wrapped = Particles::default();
        wrapped.copy_from(&particles);
        let lost = wrapped.wrap(&self.simulation_box);
        if !lost.is_empty() {
            if self.program.lost == LostAtoms::Error {
                let held = self.held()?;
                return Err(self.situation(&wrapped, &held).lost(&lost).into());
            }
            self.lost += lost.len();
            wrapped.remove(&lost, &self.simulation_box);
            wrapped.store(&mut state);
            particles = Particles::load(&state);
        }
        if order.set_up != 0 {
            self.set_up_thermostats(&particles);
        }
        let plan = self.plan_for(particles.bounds(), particles.len());
        if !self.take_over(plan)? {
            let (shape, n) = (&self.plan.shape, particles.len());
            if *shape != self.compiled.shape {
                self.compiled = compile(&self.compiler, &self.program, shape, n)?;
            }
            self.allocate(&particles, &state)?;
        }
        self.sources = Sources { id: particles.id.clone(), kind: particles.kind.clone(), mask: particles.mask.clone() };
        self.write_particles(&particles)?;
        (self.control.begin, self.control.bounded) = (BEGIN_BUILD, 1);
        self.go(order)
    }

    /// A plan for particles within bounds, in the box as it is.
    fn plan_for(&self, bounds: (Vec3, Vec3), n: usize) -> Plan {
        let Self { program, simulation_box, precision, tuning, .. } = self;
        let double_pairs = self.plan.shape.double_pairs;
        let (precision, tuning, long_runs) = (*precision, *tuning, self.long_runs);
        let architecture = &self.compiler.device.architecture();
        Plan::new(&Given {
            program,
            simulation_box,
            bounds,
            n,
            precision,
            double_pairs,
            long_runs,
            tuning,
            architecture,
        })
    }

    /// Goes over to a plan; false where its kernels or arrays have to be made first.
    fn take_over(&mut self, plan: Plan) -> Result<bool, String> {
        let (capacity, n) = (self.plan.scene.capacity, plan.n as u64);
        let fits = n <= self.sizes.pitch
            && plan.most_buckets <= self.sizes.buckets
            && plan.visits.len() as u64 <= self.sizes.values.visits;
        self.plan = plan;
        if self.plan.shape != self.compiled.shape || !fits {
            return Ok(false);
        }
        self.set_capacity(capacity);
        self.write_constants()?;
        Ok(true)
    }

    /// Moves shrink-wrapped sides to where the particles are, which the device has looked up. False where the build then had to
    /// begin on the host, from which all that was ordered has been done.
    pub(super) fn follow_bounds(&mut self, order: Order) -> Result<bool, Stop> {
        let (low, high) = self.block_bounds()?;
        self.simulation_box.shrink_wrap(&[low, high]);
        let plan = self.plan_for((low, high), self.control.n as usize);
        if self.take_over(plan)? {
            self.control.bounded = 1;
            return Ok(true);
        }
        let particles = self.read_particles(true)?;
        self.build_from(particles, order).map(|()| false)
    }

    /// Goes over to pair arithmetic in double precision, with the list as it is: particles have moved further since the build
    /// than fixed-point coordinates stand, which a script without rebuilds allows.
    pub(super) fn fall_back(&mut self) -> Result<(), Stop> {
        let control = self.control;
        let (mut then, mut now) = (State::default(), State::default());
        let held = self.read_particles(false)?;
        held.store(&mut then);
        self.read_particles(true)?.store(&mut now);
        self.plan.shape.double_pairs = true;
        self.control.left = 0;
        self.build_from(held, Order::default())?;
        let Control { n, parity, entries, tests, .. } = self.control;
        self.control = Control { n, parity, entries, tests, begin: BEGIN_PACK, ..control };
        let (pitch, count, store) = (self.sizes.pitch as usize, n as usize, self.plan.shape.double_store);
        let source: Vec<u32> = self.memory.get("held_source").read(parity as usize * pitch, count)?;
        for axis in 0..3 {
            let column = |of: &dyn Fn(usize) -> f64| -> Vec<f64> { source.iter().map(|k| of(*k as usize)).collect() };
            let kept = |k: usize| if store { now.x[k][axis] } else { now.x[k][axis] - then.x[k][axis] };
            write_reals_at(self.memory.get("x"), axis * pitch, &column(&kept), store)?;
            write_reals_at(self.memory.get("v"), axis * pitch, &column(&|k| now.v[k][axis]), store)?;
        }
        Ok(())
    }

    pub(super) fn situation<'a>(&'a self, now: &'a Particles, held: &'a Particles) -> Situation<'a> {
        let (held_box, held_step) = (&self.held_box, self.held_step);
        Situation { step: self.control.step, now, now_box: &self.simulation_box, held, held_box, held_step }
    }

    /// Particles as the last build left them; none before the first.
    pub(super) fn held(&self) -> Result<Particles, String> {
        if self.built { self.read_particles(false) } else { Ok(Particles::default()) }
    }

    fn fault(&self, kind: FaultKind, now: &Particles, places: &[usize]) -> Result<Fault, String> {
        let held = self.held()?;
        Ok(self.situation(now, &held).fault(kind, places))
    }

    pub(super) fn force_fault(&mut self) -> Result<(), Stop> {
        let now = self.read_particles(true)?;
        let f = self.forces()?;
        let broken: Vec<usize> = (0..f.len()).filter(|k| !f[*k].iter().all(|c| c.is_finite())).collect();
        Err(self.fault(FaultKind::Force, &now, &broken)?.into())
    }

    /// Takes over what a script may change without a set-up.
    pub fn go_on(&mut self, program: &Program, state: &State, step: i64) -> Result<(), String> {
        self.compiler.device.bind()?;
        let policy = Policy { skin: self.program.policy.skin, ..program.policy };
        let (timestep, masses, lost, range) = (program.timestep, program.masses.clone(), program.lost, program.range);
        self.program = Arc::new(Program { policy, timestep, masses, lost, range, ..Program::clone(&self.program) });
        self.control.step = step;
        self.summed = false;
        self.base = self.control.nanoseconds;
        let shape = Shape::new(&self.program, &self.simulation_box, self.precision);
        let Shape { rebuilds, check, masses, .. } = shape;
        let wanted = Shape { rebuilds, check, masses, ..self.plan.shape.clone() };
        if wanted != self.compiled.shape {
            self.plan.shape = wanted;
            let blocks = self.compiled.blocks();
            self.compiled = compile(&self.compiler, &self.program, &self.plan.shape, self.control.n as usize)?;
            self.compiled.limit(blocks);
        }
        let scene = &mut self.plan.scene;
        (scene.dt, scene.every, scene.delay) = (timestep, policy.every, policy.delay);
        (scene.run_first, scene.run_steps) = (range.0, range.1 - range.0);
        self.plan.half_kicks = self.program.half_kicks();
        scene.half_kick = self.plan.half_kicks[0];
        self.write_constants()?;
        let particles = self.read_particles(true)?;
        let pitch = self.sizes.pitch as usize;
        for axis in 0..3 {
            let v: Vec<f64> = particles.home.iter().map(|home| state.v[*home as usize][axis]).collect();
            write_reals_at(self.memory.get("v"), axis * pitch, &v, self.plan.shape.double_store)?;
        }
        let side = self.control.parity as usize;
        let source: Vec<u32> = self.memory.get("held_source").read(side * pitch, particles.len())?;
        for (source, home) in source.iter().zip(&particles.home) {
            self.sources.mask[*source as usize] = state.mask[*home as usize];
        }
        if let Some(buffer) = self.memory.find("held_mask") {
            let mask: Vec<u32> = source.iter().map(|k| self.sources.mask[*k as usize]).collect();
            buffer.write(side * pitch, &mask)?;
        }
        Ok(())
    }

    pub fn statistics(&self) -> NeighborStatistics {
        let dangerous = self.program.policy.check.then_some(self.control.dangerous);
        let (builds, pairs) = (self.control.builds, self.control.entries / 2);
        NeighborStatistics { builds, dangerous, pairs, redone: self.redone }
    }

    pub fn seconds(&self) -> StageSeconds {
        let stage = |k: u32| (self.control.nanoseconds[k as usize] - self.base[k as usize]) as f64 * 1e-9;
        StageSeconds {
            pair: stage(STAGE_PAIR),
            check: 0.0,
            sort: stage(STAGE_SORT),
            list: stage(STAGE_LIST),
            modify: stage(STAGE_MODIFY),
        }
    }
}

fn shrink(simulation_box: &mut SimulationBox, particles: &Particles) {
    if simulation_box.shrinks() && particles.len() > 0 {
        let (low, high) = particles.bounds();
        simulation_box.shrink_wrap(&[low, high]);
    }
}
