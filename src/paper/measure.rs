//! Times of list builds, search beside search.

use std::cell::Cell;
use std::sync::atomic::AtomicBool;

use super::experiment::{Row, number};
use super::scenes::Scene;
use crate::Error;
use crate::bench::{Halt, Machine, Spread};
use crate::engine::tuned::{Choices, Table};
use crate::engine::{Backend, Needs, Precision, StageSeconds, Work};
use crate::neighbor::{CellOrder, SearchPlan};
use crate::session::{Settings, is_interrupted};

/// Particles of all engines that are held at once, about a KiB each: these take turns, so that what else the machine does meets all of
/// them; where there are more, some follow the others.
const HELD: usize = 3_000_000;

/// Most builds of a round, and builds by which the shape of kernels is judged.
const MOST_BUILDS: f64 = 1_000.0;
const TRIAL_BUILDS: u64 = 20;

/// Particles a group and warps an octant that are tried for each search on a GPU: what is best for one search of few particles is
/// not for another.
const SHAPES: [(u32, u32); 4] = [(32, 1), (16, 2), (8, 8), (4, 32)];

/// Of more particles all searches have octants enough for a warp each.
const MOST_TRIED: usize = 250_000;

/// Where, and how long, is measured.
pub struct Lab {
    pub settings: Settings,
    pub machine: Machine,
    pub rounds: usize,
    /// Seconds of a round, about; a build at least.
    pub round_seconds: f64,
    /// The shortest timestep is the paper's, halved so many times.
    pub halvings: u32,
    /// What came out cannot be kept: nothing more is measured.
    pub broken: Cell<bool>,
}

impl Lab {
    /// Columns that say where it was measured.
    pub fn cells(&self) -> Row {
        self.cells_in(self.settings.precision)
    }

    /// The same where the precision is not the one that was asked for.
    pub fn cells_in(&self, precision: Precision) -> Row {
        vec![
            ("precision", precision.name().into()),
            ("backend", self.machine.backend.clone()),
            ("device", self.machine.device.clone()),
            ("driver", self.machine.driver.clone()),
            ("version", env!("CARGO_PKG_VERSION").into()),
        ]
    }

    /// Ends the experiments where the user has asked for it.
    pub fn check_interrupt(&self) -> Result<(), Halt> {
        if is_interrupted() || self.broken.get() { Err(Halt::Interrupted) } else { Ok(()) }
    }

    /// Name of an order of cells: each engine has its own usual one.
    pub fn order_name(&self, order: CellOrder) -> &'static str {
        match order {
            CellOrder::Usual if self.on_gpu() => "bricks",
            CellOrder::Usual => CellOrder::Rows.name(),
            _ => order.name(),
        }
    }

    pub fn on_gpu(&self) -> bool {
        self.machine.architecture.starts_with("sm_")
    }

    /// Shapes of the list kernel that are tried with so many particles; one where there is nothing to choose.
    fn shapes(&self, particles: usize) -> Vec<Option<Choices>> {
        if !self.on_gpu() {
            return vec![None];
        }
        // The same for all sizes but for the shape, so that kernels are compiled once.
        let most = Table::built_in().choices(&self.machine.architecture, self.settings.precision, usize::MAX);
        let tried = if particles > MOST_TRIED { &SHAPES[..1] } else { &SHAPES };
        tried.iter().map(|(group, slices)| Some(Choices { group: *group, slices: *slices, ..most })).collect()
    }
}

/// Builds with one search.
#[derive(Clone, Debug)]
pub struct Timed {
    pub search: SearchPlan,
    /// Of the kernels, on a GPU.
    pub choices: Option<Choices>,
    /// Neighbors of each particle.
    pub counts: Vec<u32>,
    pub work: Work,
    /// Held for particles and list.
    pub bytes: usize,
    /// Builds of a round.
    pub builds: u64,
    /// Microseconds a build: wrapping and sorting, the list alone, both.
    pub sort: Spread,
    pub list: Spread,
    pub build: Spread,
}

impl Timed {
    /// Columns of a row about so many particles.
    pub fn cells(&self, particles: usize, lab: &Lab) -> Row {
        let Work { distance_tests_per_atom: tested, list_entries_per_atom: listed } = self.work;
        let all = self.counts.iter().copied().map(u64::from).sum::<u64>();
        let mut row = vec![
            ("neighbors", number(all as f64 / particles as f64)),
            ("listed", all.to_string()),
            ("tests_per_particle", number(tested)),
            ("hit_ratio", if tested > 0.0 { number(listed / tested) } else { String::new() }),
            ("bytes_per_particle", number(self.bytes as f64 / particles as f64)),
            ("rounds", lab.rounds.to_string()),
            ("builds", self.builds.to_string()),
        ];
        let names = [
            ("sort_us", "sort_us_least", "sort_us_most"),
            ("list_us", "list_us_least", "list_us_most"),
            ("build_us", "build_us_least", "build_us_most"),
        ];
        for ((median, least, most), of) in names.into_iter().zip([self.sort, self.list, self.build]) {
            row.extend([(median, number(of.median)), (least, number(of.least)), (most, number(of.most))]);
        }
        let each = |us: f64| if all > 0 { number(us * 1e3 / all as f64) } else { String::new() };
        row.push(("list_ns_per_neighbor", each(self.list.median)));
        row.push(("build_ns_per_neighbor", each(self.build.median)));
        if let Some(Choices { group, slices, .. }) = self.choices {
            row.extend([("group", group.to_string()), ("slices", slices.to_string())]);
        }
        row.extend(lab.cells());
        row
    }
}

/// One search on one scene.
struct Contestant {
    search: SearchPlan,
    settings: Settings,
    /// None only while another takes its place.
    backend: Option<Box<dyn Backend>>,
    counts: Vec<u32>,
    work: Work,
    bytes: usize,
    builds: u64,
    /// Seconds of sort and list a build, by round.
    rounds: Vec<(f64, f64)>,
}

impl Contestant {
    /// Set up with the shape of kernels that builds the fastest.
    fn begin(scene: &Scene, search: SearchPlan, lab: &Lab) -> Result<Self, Halt> {
        let shapes = lab.shapes(scene.state.len());
        let mut best: Option<(f64, Self)> = None;
        for choices in &shapes {
            let mut contestant = Self::set_up(scene, search, Settings { choices: *choices, ..lab.settings.clone() })?;
            // Warms up, too.
            let (sort, list) = contestant.build()?;
            let mut seconds = sort + list;
            contestant.builds = (lab.round_seconds / seconds.max(1e-9)).clamp(1.0, MOST_BUILDS) as u64;
            if shapes.len() > 1 {
                let builds = std::mem::replace(&mut contestant.builds, TRIAL_BUILDS);
                let (sort, list) = contestant.build()?;
                (seconds, contestant.builds) = (sort + list, builds);
            }
            if best.as_ref().is_none_or(|(least, _)| seconds < *least) {
                best = Some((seconds, contestant));
            }
        }
        Ok(best.expect("there is a shape").1)
    }

    fn set_up(scene: &Scene, search: SearchPlan, settings: Settings) -> Result<Self, Halt> {
        let backend = scene.set_up(search, &settings)?;
        // Of the particles as they were handed over: later lists are of positions that a precision may have rounded.
        let (counts, work, bytes) = (backend.neighbor_counts()?, backend.work(), backend.bytes());
        Ok(Self { search, settings, backend: Some(backend), counts, work, bytes, builds: 1, rounds: Vec::new() })
    }

    /// Another engine in the place of this one: where memory happens to lie is not the same in all rounds.
    fn renew(&mut self, scene: &Scene) -> Result<(), Halt> {
        drop(self.backend.take());
        self.backend = Some(scene.set_up(self.search, &self.settings)?);
        let builds = std::mem::replace(&mut self.builds, 1);
        self.build()?;
        self.builds = builds;
        Ok(())
    }

    /// Seconds of sort and list a build.
    fn build(&mut self) -> Result<(f64, f64), Halt> {
        let backend = self.backend.as_mut().expect("it was set up");
        let (builds, before) = (backend.statistics().builds, backend.seconds());
        let advanced = backend.advance(self.builds, Needs::default(), &AtomicBool::new(false));
        advanced.map_err(|stop| Error::Fault(stop.to_string()))?;
        let StageSeconds { sort, list, .. } = backend.seconds();
        let built = (backend.statistics().builds - builds).max(1) as f64;
        Ok(((sort - before.sort) / built, (list - before.list) / built))
    }

    fn timed(self) -> Timed {
        let spread = |of: &dyn Fn(&(f64, f64)) -> f64| Spread::of(&self.rounds.iter().map(of).collect::<Vec<_>>());
        Timed {
            search: self.search,
            choices: self.settings.choices,
            work: self.work,
            bytes: self.bytes,
            builds: self.builds,
            sort: spread(&|(sort, _)| sort * 1e6),
            list: spread(&|(_, list)| list * 1e6),
            build: spread(&|(sort, list)| (sort + list) * 1e6),
            counts: self.counts,
        }
    }
}

/// Times list builds of scenes, each with a search; `found` gets the results in their order, with the scene.
pub fn time(cases: &[(&Scene, SearchPlan)], lab: &Lab, found: &mut dyn FnMut(&Scene, Timed)) -> Result<(), Halt> {
    let largest = cases.iter().map(|(scene, _)| scene.state.len()).max().unwrap_or(0);
    for cases in cases.chunks((HELD / largest.max(1)).max(1)) {
        let mut contestants = Vec::new();
        for (scene, search) in cases {
            contestants.push(Contestant::begin(scene, *search, lab)?);
            lab.check_interrupt()?;
        }
        for round in 0..lab.rounds {
            for ((scene, _), contestant) in cases.iter().zip(&mut contestants) {
                if round > 0 {
                    contestant.renew(scene)?;
                }
                let seconds = contestant.build()?;
                contestant.rounds.push(seconds);
                lab.check_interrupt()?;
            }
        }
        for ((scene, _), contestant) in cases.iter().zip(contestants) {
            found(scene, contestant.timed());
        }
        lab.check_interrupt()?;
    }
    Ok(())
}
