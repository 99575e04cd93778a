//! The CPU engine: double precision, all cores, the same bits for any number of threads.

mod force;
mod list;
mod motion;
mod particles;
mod ties;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::backend::{Backend, Reached, StageSeconds};
use super::fault::{Fault, FaultKind, GoodState, nearest};
use super::observer::{Needs, NeighborStatistics, Sums};
use super::program::{Program, StorageSort};
use crate::Error;
use crate::neighbor::{Cells, Decision, LAMMPS_BIN, Policy};
use crate::system::{LostAtoms, SimulationBox, State};
use force::{PairKernel, PairSums, pair_kernel};
pub use list::LIST_BYTES;
use list::{List, Membership, image_of};
use motion::{FixKernel, Kicks, fix_kernel, kinetic_sums, moved};
use particles::{Lost, Particles};

/// Runs programs on the host's cores.
pub struct CpuBackend {
    pool: rayon::ThreadPool,
    threads: usize,
    loaded: Option<Loaded>,
}

impl CpuBackend {
    /// `threads` of 0 takes all cores.
    pub fn new(threads: usize) -> Result<Self, Error> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Error::Unavailable(format!("cannot start {threads} threads: {e}")))?;
        let threads = pool.current_num_threads();
        Ok(Self { pool, threads, loaded: None })
    }

    fn on_pool<T: Send>(&mut self, work: impl FnOnce(&mut Loaded) -> T + Send) -> T {
        let loaded = self.loaded.as_mut().expect("a program is loaded before it is run");
        self.pool.install(|| work(loaded))
    }

    /// All pairs of the full list of the last build, as ids and the periodic image in which the second is seen; sorted.
    pub fn pairs(&self) -> Vec<(u32, u32, [i32; 3])> {
        let loaded = self.loaded();
        let (id, lengths) = (&loaded.held.id, loaded.held_box.lengths());
        let mut pairs = Vec::new();
        for block in loaded.list.blocks() {
            block.for_each_row(|i, stretches, start| {
                let mut begin = start;
                for stretch in stretches {
                    let image = image_of(&stretch.shift, &lengths);
                    pairs.extend(block.entries[begin..stretch.end].iter().map(|j| (id[i], id[*j as usize], image)));
                    begin = stretch.end;
                }
            });
        }
        pairs.sort_unstable();
        pairs
    }

    fn loaded(&self) -> &Loaded {
        self.loaded.as_ref().expect("a program is loaded before it is asked about")
    }
}

/// A program with its particles.
struct Loaded {
    program: Arc<Program>,
    simulation_box: SimulationBox,
    step: i64,
    /// Steps since the last build.
    ago: u64,
    particles: Particles,
    spare: Particles,
    /// Particles as they were right after the last build.
    held: Particles,
    held_box: SimulationBox,
    held_step: i64,
    /// Storage order is sorted at the first build from this step on.
    next_sort: i64,
    cells: Cells,
    list: List,
    kernel: Box<dyn PairKernel>,
    fixes: Vec<Box<dyn FixKernel>>,
    half_kicks: Vec<f64>,
    neighbor_cutoffs: Vec<f64>,
    partial: Vec<PairSums>,
    pair_sums: PairSums,
    statistics: NeighborStatistics,
    seconds: StageSeconds,
    lost: usize,
}

impl Loaded {
    fn new(program: Arc<Program>, state: &State, simulation_box: &SimulationBox, step: i64) -> Self {
        Self {
            simulation_box: simulation_box.clone(),
            step,
            ago: 0,
            particles: Particles::load(state),
            spare: Particles::default(),
            held: Particles::default(),
            held_box: simulation_box.clone(),
            held_step: step,
            next_sort: step,
            cells: Cells::default(),
            list: List::default(),
            kernel: pair_kernel(&program.pair).expect("the scene names a registered pair style"),
            fixes: program.fixes.iter().filter_map(fix_kernel).collect(),
            half_kicks: program.half_kicks(),
            neighbor_cutoffs: program.pair.neighbor_cutoffs(program.policy.skin),
            partial: Vec::new(),
            pair_sums: PairSums::default(),
            statistics: NeighborStatistics::default(),
            seconds: StageSeconds::default(),
            lost: 0,
            program,
        }
    }

    fn reset_statistics(&mut self) {
        self.statistics.builds = 0;
        self.statistics.dangerous = self.program.policy.check.then_some(0);
        self.seconds = StageSeconds::default();
    }

    /// Takes over what a script may change without a set-up.
    fn go_on(&mut self, program: &Program, step: i64) {
        let policy = Policy { skin: self.program.policy.skin, ..program.policy };
        let (timestep, masses, lost) = (program.timestep, program.masses.clone(), program.lost);
        self.program = Arc::new(Program { policy, timestep, masses, lost, ..Program::clone(&self.program) });
        self.half_kicks = self.program.half_kicks();
        self.statistics.dangerous = policy.check.then(|| self.statistics.dangerous.unwrap_or(0));
        self.seconds = StageSeconds::default();
        self.step = step;
    }

    /// Wraps, sorts, lists.
    fn build(&mut self, set_up: bool) -> Result<(), Fault> {
        let broken = self.particles.broken();
        if !broken.is_empty() {
            return Err(self.fault(FaultKind::Position, &broken));
        }
        if self.simulation_box.shrinks() {
            let (low, high) = self.particles.bounds();
            if self.particles.len() > 0 {
                self.simulation_box.shrink_wrap(&[low, high]);
            }
        }
        let lost = self.particles.wrap(&self.simulation_box);
        if !lost.is_empty() {
            if self.program.lost == LostAtoms::Error {
                return Err(self.lost_fault(&lost));
            }
            self.lost += lost.len();
            self.particles.remove(&lost, &self.simulation_box);
        }
        let radius = self.neighbor_cutoffs.iter().copied().fold(0.0, f64::max);
        self.sort_storage(set_up, radius);
        let grid = self.particles.grid(self.program.search, &self.simulation_box, radius);
        let site = &self.particles.site;
        self.cells.build(site.len(), grid.cells(), |k| grid.key(&site[k].position()), &self.particles.id);
        self.particles.reorder(&self.cells, &mut self.spare);
        let membership = Membership::new(self.program.pair.types, &self.neighbor_cutoffs, &self.simulation_box);
        self.list.build(&self.particles, &grid, &self.cells, &membership);
        self.statistics.pairs = self.list.pairs() / 2;
        self.held.clone_from(&self.particles);
        self.held_box.clone_from(&self.simulation_box);
        self.held_step = self.step;
        self.ago = 0;
        Ok(())
    }

    fn sort_storage(&mut self, set_up: bool, radius: f64) {
        let Some(StorageSort { every, bin }) = self.program.storage_sort else { return };
        let bin = if bin > 0.0 { bin } else { LAMMPS_BIN * radius };
        if every > 0 && bin > 0.0 && (set_up || self.step >= self.next_sort) {
            self.particles.sort_storage(&self.simulation_box, bin);
            self.next_sort = (self.step / every + 1) * every;
        }
    }

    fn forces(&mut self, needs: Needs) -> Result<(), Fault> {
        let sums = needs.energy || needs.virial;
        self.kernel.forces(&self.list, &self.particles.site, &mut self.particles.f, sums, &mut self.partial);
        self.pair_sums = PairSums::default();
        for part in &self.partial {
            self.pair_sums.add(part);
        }
        if self.pair_sums.broken {
            let finite = |k: &usize| self.particles.f[*k].iter().all(|c| c.is_finite());
            let broken: Vec<usize> = (0..self.particles.len()).filter(|k| !finite(k)).collect();
            if !broken.is_empty() {
                return Err(self.fault(FaultKind::Force, &broken));
            }
        }
        Ok(())
    }

    /// The stop for particles at `places`.
    fn fault(&self, kind: FaultKind, places: &[usize]) -> Fault {
        let worst = places.iter().copied().min_by_key(|k| self.particles.id[*k]).unwrap_or(0);
        let mut state = State::default();
        self.particles.store(&mut state);
        let (id, position) = (self.particles.id[worst], self.particles.site[worst].position());
        let last_good = (self.held.len() > 0).then(|| {
            let mut state = State::default();
            self.held.store(&mut state);
            Box::new(GoodState { step: self.held_step, state, simulation_box: self.held_box.clone() })
        });
        let nearest = nearest(&state, &self.simulation_box, id, &position);
        let mut fault =
            Fault { kind, step: self.step, id, position, count: places.len(), before: None, nearest, last_good };
        if kind == FaultKind::Position {
            self.look_back(&mut fault);
        }
        fault
    }

    /// The stop for particles that are no longer in the box.
    fn lost_fault(&self, lost: &[Lost]) -> Fault {
        let places: Vec<usize> = lost.iter().map(|one| one.place).collect();
        let mut fault = self.fault(FaultKind::Lost, &places);
        if let Some(worst) = lost.iter().find(|one| self.particles.id[one.place] == fault.id) {
            fault.position = worst.position;
            if worst.far {
                self.look_back(&mut fault);
            }
        }
        fault
    }

    /// A particle far from everything was close to the one that threw it there: names that one.
    fn look_back(&self, fault: &mut Fault) {
        let Some(good) = &fault.last_good else { return };
        let Some(k) = good.state.id.iter().position(|id| *id == fault.id) else { return };
        let x = good.state.x[k];
        fault.before = Some((good.step, x));
        fault.nearest = nearest(&good.state, &good.simulation_box, fault.id, &x);
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
        let kicks = Kicks { dt: self.program.timestep, half: &self.half_kicks };
        for fix in &self.fixes {
            fix.initial(&mut self.particles, &kicks);
        }
        self.seconds.modify += lap();
        let build = match self.program.policy.decide(self.ago) {
            Decision::Keep => false,
            Decision::Build => true,
            Decision::Check { first_chance } => {
                let far = moved(&self.particles.site, &self.held.site, self.program.policy.trigger());
                if far && first_chance {
                    self.statistics.dangerous = self.statistics.dangerous.map(|n| n + 1);
                }
                far
            }
        };
        if build {
            self.build(false)?;
            self.statistics.builds += 1;
        }
        self.seconds.neighbor += lap();
        self.forces(needs)?;
        self.seconds.pair += lap();
        let kicks = Kicks { dt: self.program.timestep, half: &self.half_kicks };
        for fix in &self.fixes {
            fix.last(&mut self.particles, &kicks);
        }
        self.seconds.modify += lap();
        Ok(())
    }
}

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        format!("cpu, {} thread{}, double precision", self.threads, if self.threads == 1 { "" } else { "s" })
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn load(&mut self, program: Arc<Program>, state: &State, simulation_box: &SimulationBox, step: i64) {
        self.loaded = Some(Loaded::new(program, state, simulation_box, step));
    }

    fn set_up(&mut self, needs: Needs) -> Result<(), Fault> {
        self.on_pool(|loaded| {
            loaded.reset_statistics();
            loaded.build(true)?;
            loaded.forces(needs)
        })
    }

    fn continue_run(&mut self, program: &Program, state: &State, step: i64) {
        if let Some(loaded) = &mut self.loaded {
            loaded.go_on(program, step);
            loaded.particles.take_over_motion(state);
        }
    }

    fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Fault> {
        self.on_pool(|loaded| {
            for k in 1..=steps {
                loaded.one_step(if k == steps { needs } else { Needs::default() })?;
                if stop.load(Ordering::Relaxed) {
                    if !(k == steps && needs.energy && needs.virial) {
                        // Whoever looks at the last step may want its sums.
                        loaded.forces(Needs { energy: true, virial: true, ..Needs::default() })?;
                    }
                    return Ok(Reached::Interrupted);
                }
            }
            Ok(Reached::End)
        })
    }

    fn step(&self) -> i64 {
        self.loaded().step
    }

    fn fetch(&self, state: &mut State) {
        self.loaded().particles.store(state);
    }

    fn sums(&mut self) -> Sums {
        self.on_pool(|loaded| Sums {
            kinetic: kinetic_sums(&loaded.particles.site, &loaded.particles.v, &loaded.program.masses),
            potential: loaded.pair_sums.energy,
            virial: loaded.pair_sums.virial,
        })
    }

    fn simulation_box(&self) -> &SimulationBox {
        &self.loaded().simulation_box
    }

    fn statistics(&self) -> NeighborStatistics {
        self.loaded().statistics
    }

    fn seconds(&self) -> StageSeconds {
        self.loaded().seconds
    }

    fn neighbor_counts(&self) -> Vec<u32> {
        let loaded = self.loaded();
        let mut counts = vec![0; loaded.particles.len()];
        for (site, count) in loaded.held.site.iter().zip(loaded.list.counts()) {
            counts[site.home as usize] = count;
        }
        counts
    }

    fn bytes(&self) -> usize {
        let loaded = self.loaded();
        // The particles, their copy from the last build, and room to sort them.
        3 * loaded.particles.len() * Particles::BYTES + loaded.cells.bytes() + loaded.list.bytes()
    }

    fn lost(&self) -> usize {
        self.loaded().lost
    }
}
