//! Times of list builds, search beside search.

use std::sync::atomic::AtomicBool;

use super::experiment::{Row, number};
use super::scenes::Scene;
use crate::Error;
use crate::bench::{Halt, Machine, Spread};
use crate::engine::{Backend, Needs, Precision, StageSeconds, Work};
use crate::neighbor::SearchPlan;
use crate::session::{Settings, is_interrupted};

/// Particles of all engines that are held at once, about a KiB each: these take turns, so that what else the machine does meets all of
/// them; where there are more, some follow the others.
const HELD: usize = 3_000_000;

/// Most builds of a round.
const MOST_BUILDS: f64 = 1_000.0;

/// Where, and how long, is measured.
pub struct Lab {
    pub settings: Settings,
    pub machine: Machine,
    pub rounds: usize,
    /// Seconds of a round, about; a build at least.
    pub round_seconds: f64,
    /// The shortest timestep is the paper's, halved so many times.
    pub halvings: u32,
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
        if is_interrupted() { Err(Halt::Interrupted) } else { Ok(()) }
    }
}

/// Builds with one search.
#[derive(Clone, Debug)]
pub struct Timed {
    pub search: SearchPlan,
    /// Entries of the full list.
    pub listed: u64,
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
        let mut row = vec![
            ("neighbors", number(self.listed as f64 / particles as f64)),
            ("listed", self.listed.to_string()),
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
        let each = |us: f64| if self.listed > 0 { number(us * 1e3 / self.listed as f64) } else { String::new() };
        row.push(("list_ns_per_neighbor", each(self.list.median)));
        row.push(("build_ns_per_neighbor", each(self.build.median)));
        row.extend(lab.cells());
        row
    }
}

/// One search on one scene.
struct Contestant {
    search: SearchPlan,
    backend: Box<dyn Backend>,
    listed: u64,
    work: Work,
    builds: u64,
    /// Seconds of sort and list a build, by round.
    rounds: Vec<(f64, f64)>,
}

impl Contestant {
    fn begin(scene: &Scene, search: SearchPlan, lab: &Lab) -> Result<Self, Halt> {
        let backend = scene.set_up(search, lab)?;
        // Of the particles as they were handed over: later lists are of positions that a precision may have rounded.
        let listed = backend.neighbor_counts()?.into_iter().map(u64::from).sum();
        let work = backend.work();
        let mut contestant = Self { search, backend, listed, work, builds: 1, rounds: Vec::new() };
        // Warms up, too.
        let (sort, list) = contestant.build()?;
        contestant.builds = (lab.round_seconds / (sort + list).max(1e-9)).clamp(1.0, MOST_BUILDS) as u64;
        Ok(contestant)
    }

    /// Seconds of sort and list a build.
    fn build(&mut self) -> Result<(f64, f64), Halt> {
        let (builds, before) = (self.backend.statistics().builds, self.backend.seconds());
        let advanced = self.backend.advance(self.builds, Needs::default(), &AtomicBool::new(false));
        advanced.map_err(|stop| Error::Fault(stop.to_string()))?;
        let StageSeconds { sort, list, .. } = self.backend.seconds();
        let built = (self.backend.statistics().builds - builds).max(1) as f64;
        Ok(((sort - before.sort) / built, (list - before.list) / built))
    }

    fn timed(&self) -> Timed {
        let spread = |of: &dyn Fn(&(f64, f64)) -> f64| Spread::of(&self.rounds.iter().map(of).collect::<Vec<_>>());
        Timed {
            search: self.search,
            listed: self.listed,
            work: self.work,
            bytes: self.backend.bytes(),
            builds: self.builds,
            sort: spread(&|(sort, _)| sort * 1e6),
            list: spread(&|(_, list)| list * 1e6),
            build: spread(&|(sort, list)| (sort + list) * 1e6),
        }
    }
}

/// Times list builds of scenes, each with a search; `found` gets the results in their order, with the scene.
pub fn time(cases: &[(&Scene, SearchPlan)], lab: &Lab, found: &mut dyn FnMut(&Scene, &Timed)) -> Result<(), Halt> {
    let largest = cases.iter().map(|(scene, _)| scene.state.len()).max().unwrap_or(0);
    for cases in cases.chunks((HELD / largest.max(1)).max(1)) {
        let mut contestants = Vec::new();
        for (scene, search) in cases {
            contestants.push(Contestant::begin(scene, *search, lab)?);
            lab.check_interrupt()?;
        }
        for _ in 0..lab.rounds {
            for contestant in &mut contestants {
                let seconds = contestant.build()?;
                contestant.rounds.push(seconds);
                lab.check_interrupt()?;
            }
        }
        cases.iter().zip(&contestants).for_each(|((scene, _), contestant)| found(scene, &contestant.timed()));
    }
    Ok(())
}
