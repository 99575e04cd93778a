//! What the paper decides without a number: cells row after row against a Z-order curve, which it turns down, and a radix sort, which
//! it takes, against counting.

use super::experiment::{Experiment, Row};
use super::measure::Lab;
use super::scenes;
use super::searches::{SHOWN, compare};
use crate::bench::Halt;
use crate::neighbor::{SearchPlan, Sort};

/// Each search with both orders and both sorts. The trimmed search has particles along a curve inside each octant, the others not.
pub const SEARCHES: [&str; 16] = [
    "standard",
    "standard+zorder",
    "standard+radix",
    "standard+zorder+radix",
    "standard:2",
    "standard:2+zorder",
    "standard:2+radix",
    "standard:2+zorder+radix",
    "octant",
    "octant+zorder",
    "octant+radix",
    "octant+zorder+radix",
    "trimmed",
    "trimmed+zorder",
    "trimmed+radix",
    "trimmed+zorder+radix",
];

/// Most particles: what is larger shows nothing new here.
const MOST: usize = 2_000_000;

pub static EXPERIMENT: Experiment =
    Experiment { name: "orders", title: "Order of cells and sort: list builds, microseconds a build", shown: &SHOWN };

/// The even distribution of each size; on an engine that has no radix sort, without it.
pub fn run(sizes: &[usize], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    let by_radix = |name: &&str| name.parse::<SearchPlan>().is_ok_and(|plan| plan.sort() == Sort::Radix);
    let searches: Vec<&str> =
        SEARCHES.into_iter().filter(|name| lab.machine.backend == "cpu" || !by_radix(name)).collect();
    for particles in sizes.iter().filter(|n| **n <= MOST) {
        let scene = scenes::uniform(*particles, scenes::edge(*particles), 0, &lab.settings)?;
        compare(&scene, &searches, lab, found)?;
    }
    Ok(())
}
