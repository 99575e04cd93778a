//! Figure 5, time of the list against the number of particles for each search and edge, and the same for other distributions.

use super::experiment::{Experiment, Row};
use super::measure::{Lab, time};
use super::scenes::{self, Scene};
use crate::Error;
use crate::bench::Halt;
use crate::neighbor::SearchPlan;

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
pub fn by_distribution(sizes: &[usize], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    for scene in scenes::distributions(scenes::largest(sizes, MOST_DISTRIBUTED), &lab.settings)? {
        compare(&scene, &SEARCHES, lab, found)?;
    }
    Ok(())
}

/// Searches on a scene. An error where they find different numbers of neighbors.
pub fn compare(scene: &Scene, searches: &[&str], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    let plan = |search: &&str| search.parse::<SearchPlan>().expect("a search");
    let cases: Vec<_> = searches.iter().map(|search| (scene, plan(search))).collect();
    let particles = scene.state.len();
    let mut listed = Vec::new();
    time(&cases, lab, &mut |scene, timed| {
        let mut row: Row = vec![
            ("distribution", scene.name.into()),
            ("particles", particles.to_string()),
            ("search", timed.search.to_string()),
            ("method", timed.search.search().name().into()),
            ("edge", timed.search.edge().to_string()),
            ("order", timed.search.order().name().into()),
            ("sort", timed.search.sort().name().into()),
        ];
        row.extend(timed.cells(particles, lab));
        found(row);
        listed.push((timed.search, timed.listed));
    })?;
    match disagreement(&listed) {
        None => Ok(()),
        Some(found) => Err(Error::Fault(format!("{}, {particles} particles: {found}", scene.name)).into()),
    }
}

/// Two searches that find different numbers of neighbors, in words.
fn disagreement(listed: &[(SearchPlan, u64)]) -> Option<String> {
    let pair = listed.windows(2).find(|pair| pair[0].1 != pair[1].1)?;
    let [(first, m), (second, n)] = [pair[0], pair[1]];
    Some(format!("'{first}' lists {m} neighbors, '{second}' {n}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_that_disagree_are_named() {
        let found = |counts: [u64; 3]| {
            let searches = ["octant", "octant:4", "trimmed"].map(|search| search.parse().expect("a search"));
            disagreement(&searches.into_iter().zip(counts).collect::<Vec<_>>())
        };
        assert_eq!(found([5, 5, 5]), None);
        assert_eq!(found([5, 5, 4]).expect("two differ"), "'octant:4' lists 5 neighbors, 'trimmed' 4");
        assert_eq!(found([6, 5, 5]).expect("two differ"), "'octant' lists 6 neighbors, 'octant:4' 5");
    }
}
