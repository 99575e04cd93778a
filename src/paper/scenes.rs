//! Particles that lists are built of: the paper's system, and distributions that it did not try.

use std::sync::Arc;

use super::table1::{Published, TABLE_1};
use crate::Error;
use crate::bench::{self, Halt};
use crate::engine::{Backend, Needs, Program};
use crate::neighbor::{Policy, SearchPlan};
use crate::session::{FirstRun, Settings, first_run};
use crate::system::random::RanPark;
use crate::system::{SimulationBox, State, Vec3};

/// The paper's system. Scripts of other sizes differ from it in numbers that are variables.
const SCRIPT: &str = include_str!("../../inputs/paper/1000.in");

/// Seed of `inputs/paper/`; other rounds take those that follow.
const SEED: u32 = 2015;

/// Particles of a cluster, and the standard deviation of their distances from its middle along an axis, R. A particle has about 85
/// neighbors of its own cluster.
const CLUSTER: usize = 200;
const CLUSTER_WIDTH: f64 = 0.5;
/// Edge of the box with clusters, in edges of that with as many particles spread evenly: most cells are empty.
const CLUSTERED_EDGE: f64 = 2.0;
/// Density of the dense distribution over that of the even one.
const DENSER: f64 = 8.0;
/// Skin of the liquid, sigma.
const LIQUID_SKIN: f64 = 0.3;

/// Particles at rest, and the program that lists and forces follow from.
pub struct Scene {
    /// What it is called in the tables.
    pub name: &'static str,
    program: Program,
    pub state: State,
    simulation_box: SimulationBox,
}

impl Scene {
    /// Nothing moves, so every step builds the list of the same particles.
    fn new(name: &'static str, program: Program, state: State, simulation_box: SimulationBox) -> Self {
        let policy = Policy { every: 1, delay: 0, check: false, once: false, ..program.policy };
        let program = Program { fixes: Vec::new(), storage_sort: None, policy, ..program };
        Self { name, program, state, simulation_box }
    }

    /// Other particles and another box with the same forces.
    pub fn with(self, name: &'static str, state: State, simulation_box: SimulationBox) -> Self {
        Self { name, state, simulation_box, program: self.program }
    }

    /// Neighbor cutoff R, length units.
    pub fn radius(&self) -> f64 {
        self.program.pair.largest_cutoff() + self.program.policy.skin
    }

    pub fn simulation_box(&self) -> &SimulationBox {
        &self.simulation_box
    }

    /// An engine that holds the particles and has built the first list with this search.
    pub fn set_up(&self, search: SearchPlan, settings: &Settings) -> Result<Box<dyn Backend>, Error> {
        let (mut backend, _) = settings.engine()?;
        let program = Arc::new(Program { search, ..self.program.clone() });
        backend.load(program, &self.state, &self.simulation_box, 0)?;
        backend.set_up(Needs::default()).map_err(|stop| Error::Fault(stop.to_string()))?;
        Ok(backend)
    }
}

/// The largest of the sizes, `most` at most; 0 where there is none.
pub fn largest(sizes: &[usize], most: usize) -> usize {
    sizes.iter().copied().max().unwrap_or(0).min(most)
}

/// Even distributions with each of these numbers of particles, in boxes of their [`edge`], each made when its turn comes.
pub fn by_size(sizes: &[usize], settings: &Settings) -> impl Iterator<Item = Result<Scene, Error>> {
    sizes.iter().map(|particles| uniform(*particles, edge(*particles), 0, settings))
}

/// Edge of the box of so many particles, R: those of the paper's sizes as published here, others as dense as the nearest of them.
pub fn edge(particles: usize) -> f64 {
    let off = |of: &Published| (of.particles as f64 / particles.max(1) as f64).ln().abs();
    let nearest = TABLE_1.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("there are eight");
    nearest.edge * (particles as f64 / nearest.particles as f64).cbrt()
}

/// The paper's run of points that are even at random in a cube with an edge of so many R, with variables of the script set; `round` 0
/// has the seed of `inputs/paper/`.
pub fn start(
    particles: usize,
    edge: f64,
    round: usize,
    variables: &[(&str, &str)],
    settings: &Settings,
) -> Result<FirstRun, Error> {
    let set = |name: &str, value: &str| (name.to_string(), value.to_string());
    let numbers =
        [("n", particles.to_string()), ("edge", edge.to_string()), ("seed", (SEED + round as u32).to_string())];
    let numbers = numbers.iter().map(|(name, value)| set(name, value));
    let variables = numbers.chain(variables.iter().map(|(name, value)| set(name, value))).collect();
    first_run("inputs/paper", SCRIPT, &Settings { variables, ..settings.clone() })
}

/// The same points at rest.
pub fn uniform(particles: usize, edge: f64, round: usize, settings: &Settings) -> Result<Scene, Error> {
    let FirstRun { program, state, simulation_box, .. } = start(particles, edge, round, &[], settings)?;
    Ok(Scene::new("uniform", program, state, simulation_box))
}

/// All distributions of about so many particles.
pub fn distributions(particles: usize, settings: &Settings) -> Result<Vec<Scene>, Halt> {
    let edge = edge(particles);
    let even = uniform(particles, edge, 0, settings)?;
    let dense = Scene { name: "dense", ..uniform(particles, edge / DENSER.cbrt(), 0, settings)? };
    Ok(vec![even, liquid(particles, settings)?, clustered(particles, edge * CLUSTERED_EDGE, settings)?, dense])
}

/// The Lennard-Jones liquid of `octant bench`, periodic; R is cutoff and skin.
fn liquid(particles: usize, settings: &Settings) -> Result<Scene, Halt> {
    let melted = bench::liquid(particles, LIQUID_SKIN, settings)?;
    let simulation_box = melted.simulation_box().expect("the script makes a box").clone();
    Ok(Scene::new("liquid", melted.program(settings)?, melted.state().clone(), simulation_box))
}

/// Normal clusters around points that are even at random.
fn clustered(particles: usize, edge: f64, settings: &Settings) -> Result<Scene, Error> {
    let mut scene = Scene { name: "clustered", ..uniform(particles, edge, 0, settings)? };
    let mut random = RanPark::new(SEED);
    let mut middle = Vec3::zeros();
    for (k, x) in scene.state.x.iter_mut().enumerate() {
        if k % CLUSTER == 0 {
            middle = Vec3::from_fn(|_, _| edge * random.uniform());
        }
        // Those that would lie beyond a side are drawn again.
        *x = loop {
            let at = middle + Vec3::from_fn(|_, _| CLUSTER_WIDTH * random.gaussian());
            if scene.simulation_box.outside(&at).is_none() {
                break at;
            }
        };
    }
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_the_papers_and_between_its_sizes_as_dense_as_the_nearest() {
        for of in TABLE_1 {
            assert_eq!(edge(of.particles), of.edge);
        }
        let density = |n: usize| n as f64 / edge(n).powi(3);
        assert!((density(10_000_000) / density(200_000) - 1.0).abs() < 1e-12);
        assert!((density(1_100) / density(1_000) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn distributions_differ_in_density() {
        let settings = Settings { threads: 1, ..Settings::default() };
        let scenes = distributions(1_000, &settings).ok().expect("the scenes are set up");
        let of = |name: &str| scenes.iter().find(|scene| scene.name == name).expect("it is there");
        let volume = |name: &str| of(name).simulation_box.volume() / of(name).state.len() as f64;
        assert!((volume("uniform") / volume("dense") - DENSER).abs() < 1e-9);
        assert!((volume("clustered") / volume("uniform") - CLUSTERED_EDGE.powi(3)).abs() < 1e-9);
        assert_eq!((of("liquid").radius(), of("clustered").radius()), (2.8, 1.0));
        // Particles of a cluster are near each other.
        let [first, second] = [0, CLUSTER].map(|from| &of("clustered").state.x[from..from + CLUSTER]);
        let mean = |x: &[Vec3]| x.iter().sum::<Vec3>() / x.len() as f64;
        let spread = first.iter().map(|x| (x - mean(first)).norm_squared()).sum::<f64>() / CLUSTER as f64;
        assert!((0.5..1.0).contains(&spread) && (mean(first) - mean(second)).norm() > 1.0, "{spread}");
    }
}
