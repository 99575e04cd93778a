//! What is measured, in which order, and about how long each piece takes.

use super::lammps::{self, Lammps};
use super::measure::{self, Span};
use super::pace::Pace;
use super::point::{Integrator, Point, Potential, is_safe};
use super::price;
use super::store::Table;
use super::study::Study;
use super::{Halt, Options};
use crate::engine::Precision;
use crate::neighbor::Policy;

/// Time steps over the script's, in full and quick.
const STEPS: [f64; 7] = [0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 4.0];
const QUICK_STEPS: [f64; 3] = [0.5, 1.0, 2.0];
/// Skins over the largest cutoff, beside the script's.
const SKINS: [f64; 5] = [0.06, 0.12, 0.2, 0.28, 0.36];
const QUICK_SKINS: [f64; 2] = [0.12, 0.24];
/// The reference trajectory has the smallest step over this.
const FINER: f64 = 8.0;

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Atoms whose forces are compared.
    pub force_atoms: usize,
    pub rounds: usize,
    /// Seconds of a timed leg.
    pub leg: f64,
    /// Of the scene's own time over which trajectories are compared.
    pub span: f64,
    /// Time for energies over that of trajectories.
    pub energy_spans: f64,
    pub samples: u64,
    pub looks: u64,
    pub look_atoms: usize,
    pub price_rounds: usize,
}

pub const FULL: Scale = Scale {
    force_atoms: 32_000,
    rounds: 5,
    leg: 0.1,
    span: 1.0,
    energy_spans: 25.0,
    samples: 400,
    looks: 20,
    look_atoms: 4_000,
    price_rounds: 5,
};
pub const QUICK: Scale = Scale {
    force_atoms: 2_000,
    rounds: 2,
    leg: 0.04,
    span: 0.5,
    energy_spans: 2.0,
    samples: 60,
    looks: 7,
    look_atoms: 500,
    price_rounds: 2,
};

/// Policies (every, delay, check) that are in use and may lack pairs.
const CARELESS: [(u64, u64, bool); 3] = [(10, 10, false), (20, 0, false), (5, 10, true)];

/// One measurement.
#[derive(Clone, Debug)]
pub enum Work {
    Forces(Potential, Precision),
    Trajectory(Point),
    Energies(Point),
    Averages(Precision),
    Missing(Point),
    Speed(Point),
    Price(usize),
    Lammps(f64),
}

/// One measurement, where its row goes, and about how many steps it takes.
#[derive(Clone, Debug)]
pub struct Job {
    pub table: &'static Table,
    pub key: Vec<String>,
    pub steps: f64,
    pub work: Work,
}

/// All that is measured of a study.
pub struct Plan {
    pub scale: Scale,
    pub span: Span,
    /// The scene's fastest time, time units.
    pub fastest: Option<f64>,
    /// Where that comes from.
    pub pace: &'static str,
    pub precisions: Vec<Precision>,
    /// Time units, ascending.
    pub dts: Vec<f64>,
    /// The precision of what is not measured in all of them: mixed, or the first asked for.
    pub usual: Precision,
    pub jobs: Vec<Job>,
}

impl Plan {
    pub fn new(study: &Study, options: &Options, lammps: Option<&Lammps>) -> Result<Self, Halt> {
        let scale = if options.quick { QUICK } else { FULL };
        let Pace { span, fastest, how } = study.pace()?;
        let own = study.program.timestep;
        let grid = || if options.quick { QUICK_STEPS.to_vec() } else { STEPS.to_vec() };
        let mut dts = options.dts.clone().unwrap_or_else(|| grid().iter().map(|factor| factor * own).collect());
        dts.push(own);
        dts.sort_unstable_by(f64::total_cmp);
        dts.dedup();
        let precisions = options.precisions.clone();
        let usual = if precisions.contains(&Precision::Mixed) { Precision::Mixed } else { precisions[0] };
        // A whole number of the script's steps, so that its own is no other in the comparison of trajectories.
        let time = (span * scale.span / own).round().max(4.0) * own;
        let span = Span { time, reference_dt: dts[0] / FINER };
        let mut plan = Self { scale, span, fastest, pace: how, precisions, dts, usual, jobs: Vec::new() };
        plan.forces(study);
        let lists = Lists::new(study, options);
        plan.errors(study, &lists);
        plan.averages(study);
        plan.lists(study, &lists);
        plan.prices(study);
        if let Some(lammps) = lammps {
            let lengths = plan.span.time + plan.energy_time();
            let dts = if options.quick { vec![own] } else { plan.dts.clone() };
            for dt in dts {
                let steps = 4.0 * lengths / dt;
                plan.jobs.push(Job {
                    table: &lammps::LAMMPS,
                    key: vec![lammps.version().to_string(), dt.to_string()],
                    steps,
                    work: Work::Lammps(dt),
                });
            }
        }
        Ok(plan)
    }

    /// Time over which energies are looked at, time units.
    pub fn energy_time(&self) -> f64 {
        self.span.time * self.scale.energy_spans
    }

    /// Time over which averages are taken of a scene with its thermostats, time units.
    pub fn averages_time(&self) -> f64 {
        2.0 * self.energy_time()
    }

    pub fn potentials(study: &Study) -> Vec<Potential> {
        let shifted = study.has_force_shifted().then_some(Potential::ForceShifted);
        [Potential::Own].into_iter().chain(shifted).collect()
    }

    fn forces(&mut self, study: &Study) {
        for potential in Self::potentials(study) {
            for precision in self.precisions.clone() {
                let key = vec![potential.name().into(), precision.name().into()];
                self.add(&measure::FORCES, key, 20.0, Work::Forces(potential, precision));
            }
        }
    }

    /// Points whose errors are measured: with the policy that lacks no pair in every precision and by every integrator, with the
    /// script's policy where that is another, and at the script's timestep with those that are careless.
    fn accuracy_points(&self, study: &Study, lists: &Lists) -> Vec<Point> {
        let mut points = Vec::new();
        for potential in Self::potentials(study) {
            for dt in &self.dts {
                let of = |precision| Point { potential, dt: *dt, policy: study.safe(), ..study.own(precision) };
                points.extend(self.precisions.iter().map(|precision| of(*precision)));
                if potential == Potential::Own {
                    let own = Point { policy: study.program.policy, ..of(self.usual) };
                    points.extend(Some(own).filter(|_| !is_safe(&own.policy)));
                    let euler2 = |precision| Point { integrator: Integrator::Euler2, ..of(precision) };
                    points.extend(self.euler2_precisions(study, lists).into_iter().map(euler2));
                }
            }
        }
        let careless = lists.careless.iter().filter(|_| lists.whole_grid);
        points.extend(careless.map(|policy| Point { policy: *policy, ..study.own(self.usual) }));
        points
    }

    /// Precisions that the other integrator is measured in, where it can take the script's place.
    fn euler2_precisions(&self, study: &Study, lists: &Lists) -> Vec<Precision> {
        match (study.is_plain(), lists.whole_grid) {
            (false, _) => Vec::new(),
            (true, false) => vec![self.usual],
            (true, true) => self.precisions.clone(),
        }
    }

    fn errors(&mut self, study: &Study, lists: &Lists) {
        let points = self.accuracy_points(study, lists);
        for point in &points {
            let steps = self.span.time / point.dt;
            self.add(&measure::TRAJECTORIES, point.cells(), steps, Work::Trajectory(*point));
        }
        for point in &points {
            let runs = if point.potential == Potential::Own && study.jumps() { 2.0 } else { 1.0 };
            let steps = runs * self.energy_time() / point.dt;
            self.add(&measure::ENERGIES, point.cells(), steps, Work::Energies(*point));
        }
    }

    fn averages(&mut self, study: &Study) {
        if !study.thermostats.is_empty() {
            let dt = study.program.timestep;
            let key = vec![self.usual.name().into(), dt.to_string()];
            self.add(&measure::AVERAGES, key, self.averages_time() / dt, Work::Averages(self.usual));
        }
    }

    /// What depends on the list: pairs that it lacks, and time.
    fn lists(&mut self, study: &Study, lists: &Lists) {
        let of = |precision, dt, policy| Point { dt, policy, ..study.own(precision) };
        let looks = self.scale.looks;
        let look = |plan: &mut Self, point: Point| {
            let steps = looks as f64 * 12.0;
            plan.add(&measure::MISSING, point.cells(), steps, Work::Missing(point));
        };
        for dt in self.dts.clone() {
            lists.policies.iter().for_each(|policy| look(self, of(self.usual, dt, *policy)));
        }
        for policy in &lists.careless {
            look(self, of(self.usual, study.program.timestep, *policy));
        }
        let mut points = Vec::new();
        for precision in self.precisions.clone() {
            let euler2 = self.euler2_precisions(study, lists).contains(&precision);
            for dt in &self.dts {
                let all: Vec<Point> = lists.policies.iter().map(|policy| of(precision, *dt, *policy)).collect();
                let safe = of(precision, *dt, study.safe());
                let others = if lists.whole_grid { &all[..] } else { std::slice::from_ref(&safe) };
                let others = others.iter().map(|point| Point { integrator: Integrator::Euler2, ..*point });
                points.extend(others.filter(|_| euler2));
                points.extend(&all);
                if study.has_force_shifted() {
                    points.push(Point { potential: Potential::ForceShifted, ..safe });
                }
            }
        }
        let careless = lists.careless.iter().filter(|_| lists.whole_grid);
        points.extend(careless.map(|policy| of(self.usual, study.program.timestep, *policy)));
        for round in 1..=self.scale.rounds {
            for point in &points {
                let key = [round.to_string()].into_iter().chain(point.cells()).collect();
                self.add(&measure::SPEEDS, key, self.leg_steps(study), Work::Speed(*point));
            }
        }
    }

    /// Steps that a timed leg has, about: of a core's usual speed.
    fn leg_steps(&self, study: &Study) -> f64 {
        (self.scale.leg / (5e-8 * study.atoms() as f64)).clamp(60.0, 1e5)
    }

    fn prices(&mut self, study: &Study) {
        for round in 1..=self.scale.price_rounds {
            for (k, option) in price::options(study).iter().enumerate() {
                let key = vec![round.to_string(), option.name.clone()];
                self.add(&price::PRICES, key, self.leg_steps(study), Work::Price(k));
            }
        }
    }

    fn add(&mut self, table: &'static Table, key: Vec<String>, steps: f64, work: Work) {
        // Skins and policies may say the same twice.
        if !self.jobs.iter().any(|job| job.table.name == table.name && job.key == key) {
            self.jobs.push(Job { table, key, steps, work });
        }
    }
}

/// Skins and rebuild policies that are measured.
struct Lists {
    /// The policy that lacks no pair, with every skin, and the script's where that is another.
    policies: Vec<Policy>,
    /// Policies that may lack pairs, with every skin.
    careless: Vec<Policy>,
    /// Times and errors are measured of all of them, and of the other integrator in every precision.
    whole_grid: bool,
}

impl Lists {
    fn new(study: &Study, options: &Options) -> Self {
        let (policy, cutoff) = (study.program.policy, study.program.pair.largest_cutoff());
        let parts = if options.quick { &QUICK_SKINS[..] } else { &SKINS[..] };
        // Two digits do.
        let round = |x: f64| format!("{x:.1e}").parse().unwrap_or(x);
        let mut skins =
            options.skins.clone().unwrap_or_else(|| parts.iter().map(|part| round(part * cutoff)).collect());
        skins.push(policy.skin);
        skins.sort_unstable_by(f64::total_cmp);
        skins.dedup();
        let mut policies: Vec<Policy> = skins.iter().map(|skin| Policy { skin: *skin, ..study.safe() }).collect();
        if !is_safe(&policy) {
            policies.push(policy);
        }
        let each = |(every, delay, check)| {
            skins.iter().map(move |skin| Policy { every, delay, check, once: false, skin: *skin })
        };
        let careless = CARELESS.into_iter().flat_map(each).filter(|careless| *careless != policy).collect();
        Self { policies, careless, whole_grid: !options.quick }
    }
}
