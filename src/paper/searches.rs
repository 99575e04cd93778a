//! Figure 5, time of the list against the number of particles for each search and edge, and the same for other distributions.

use super::experiment::{Experiment, Row};
use super::measure::{Lab, time};
use super::scenes::{self, Scene};
use crate::Error;
use crate::bench::Halt;
use crate::neighbor::SearchPlan;
use crate::system::Vec3;

/// What is compared: the paper's two searches with its three edges, the standard search with the edges that it is usually run with
/// (R, R/2), which the paper leaves out, and octant's own two.
pub const SEARCHES: [&str; 14] = [
    "standard:0.5",
    "standard",
    "standard:2",
    "standard:2.52",
    "standard:4",
    "octant",
    "octant:2.52",
    "octant:4",
    "trimmed",
    "trimmed:2.52",
    "trimmed:4",
    "midplane:2",
    "midplane",
    "midplane:4",
];

/// All pairs, which the paper begins with, up to so many particles.
pub const EXHAUSTIVE: &str = "brute";
const MOST_EXHAUSTIVE: usize = 20_000;

/// Most particles of a distribution: the dense one has eight times the neighbors.
const MOST_DISTRIBUTED: usize = 100_000;

pub static FIGURE_5: Experiment = Experiment {
    name: "figure5",
    title: "Figure 5: list builds by search, edge of the cells and number of particles, microseconds a build",
    shown: &SHOWN,
};

pub static DISTRIBUTIONS: Experiment = Experiment {
    name: "distributions",
    title: "List builds by search and distribution, microseconds a build",
    shown: &SHOWN,
};

const SHOWN: [&str; 12] = [
    "distribution",
    "particles",
    "search",
    "neighbors",
    "tests_per_particle",
    "hit_ratio",
    "sort_us",
    "list_us",
    "build_us",
    "build_us_least",
    "build_us_most",
    "build_ns_per_neighbor",
];

/// Particles and the neighbors that all searches find of each.
pub struct Listed {
    /// Of the distribution.
    pub name: &'static str,
    pub x: Vec<Vec3>,
    pub neighbors: Vec<u32>,
}

/// The even distribution with each of these numbers of particles.
pub fn by_size(sizes: &[usize], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    for scene in scenes::by_size(sizes, &lab.settings) {
        let scene = scene?;
        let exhaustive = (scene.state.len() <= MOST_EXHAUSTIVE).then_some(EXHAUSTIVE);
        compare(&scene, &SEARCHES.into_iter().chain(exhaustive).collect::<Vec<_>>(), lab, found)?;
    }
    Ok(())
}

/// All distributions with about as many particles as the largest size.
pub fn by_distribution(sizes: &[usize], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<Vec<Listed>, Halt> {
    let mut listed = Vec::new();
    for scene in scenes::distributions(scenes::largest(sizes, MOST_DISTRIBUTED), &lab.settings)? {
        let neighbors = compare(&scene, &SEARCHES, lab, found)?;
        listed.push(Listed { name: scene.name, x: scene.state.x, neighbors });
    }
    Ok(listed)
}

/// Searches on a scene; the neighbors of each particle. An error where they find different numbers of them.
pub fn compare(scene: &Scene, searches: &[&str], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<Vec<u32>, Halt> {
    let plan = |search: &&str| search.parse::<SearchPlan>().expect("a search");
    let cases: Vec<_> = searches.iter().map(|search| (scene, plan(search))).collect();
    let particles = scene.state.len();
    let mut first: Option<(SearchPlan, Vec<u32>)> = None;
    let mut wrong = None;
    let [x, y, z] = scene.simulation_box().lengths().into();
    time(&cases, lab, &mut |scene, timed| {
        let mut row: Row = vec![
            ("distribution", scene.name.into()),
            ("particles", particles.to_string()),
            ("search", timed.search.to_string()),
            ("method", timed.search.search().name().into()),
            ("edge", timed.search.edge().to_string()),
            ("order", lab.order_name(timed.search.order()).into()),
            ("sort", timed.search.sort().name().into()),
            ("radius", scene.radius().to_string()),
            ("box", format!("{x} {y} {z}")),
        ];
        row.extend(timed.cells(particles, lab));
        found(row);
        match &first {
            None => first = Some((timed.search, timed.counts)),
            Some((search, counts)) => {
                wrong = wrong.take().or_else(|| disagreement((search, counts), (&timed.search, &timed.counts)));
            }
        }
    })?;
    match wrong {
        None => Ok(first.map_or(Vec::new(), |(_, counts)| counts)),
        Some(found) => Err(Error::Fault(format!("{}, {particles} particles: {found}", scene.name)).into()),
    }
}

/// The first particle of which two searches find different numbers of neighbors, in words.
fn disagreement(one: (&SearchPlan, &[u32]), other: (&SearchPlan, &[u32])) -> Option<String> {
    let place = one.1.iter().zip(other.1).position(|(m, n)| m != n)?;
    let (m, n) = (one.1[place], other.1[place]);
    Some(format!("'{}' lists {m} neighbors of particle {}, '{}' {n}", one.0, place + 1, other.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_that_disagree_are_named() {
        let [octant, trimmed] = ["octant:4", "trimmed"].map(|search| search.parse().expect("a search"));
        assert_eq!(disagreement((&octant, &[5, 2]), (&trimmed, &[5, 2])), None);
        // As many in all, but not of each.
        let found = disagreement((&octant, &[5, 4, 3]), (&trimmed, &[5, 3, 4])).expect("two differ");
        assert_eq!(found, "'octant:4' lists 4 neighbors of particle 2, 'trimmed' 3");
    }
}
