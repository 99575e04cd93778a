//! What the paper decides without a number: cells row after row against a Z-order curve, which it turns down, and a radix sort, which
//! it takes, against counting.

use super::experiment::{Experiment, Row, number};
use super::measure::Lab;
use super::scenes::{self, Scene};
use super::searches::compare;
use crate::bench::Halt;
use crate::neighbor::{CellOrder, SearchPlan};

/// Each search with both orders and both sorts, and with rows where these are not usual. The trimmed search has particles along a curve
/// inside each octant, the others not.
pub const SEARCHES: [&str; 20] = [
    "standard",
    "standard+rows",
    "standard+zorder",
    "standard+radix",
    "standard+zorder+radix",
    "standard:2",
    "standard:2+rows",
    "standard:2+zorder",
    "standard:2+radix",
    "standard:2+zorder+radix",
    "octant",
    "octant+rows",
    "octant+zorder",
    "octant+radix",
    "octant+zorder+radix",
    "trimmed",
    "trimmed+rows",
    "trimmed+zorder",
    "trimmed+radix",
    "trimmed+zorder+radix",
];

/// Particles whose neighbors' places are looked at, about.
const SAMPLE: usize = 20_000;

/// Particles between neighbors that lie far from each other: four coordinates in f32 of so many fill 64 KiB, a share of a cache.
const FAR: u32 = 4_096;

/// Most particles: what is larger shows nothing new here.
const MOST: usize = 2_000_000;

pub static EXPERIMENT: Experiment = Experiment {
    name: "orders",
    title: "Order of cells and sort: list builds, microseconds a build",
    shown: &[
        "particles",
        "search",
        "apart",
        "far_percent",
        "sort_us",
        "list_us",
        "build_us",
        "build_us_least",
        "build_us_most",
        "build_ns_per_neighbor",
    ],
};

/// The even distribution of each size; without rows by name where they are usual.
pub fn run(sizes: &[usize], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    let has = |plan: SearchPlan| lab.on_gpu() || plan.order() != CellOrder::Rows;
    let searches: Vec<&str> = SEARCHES.into_iter().filter(|name| name.parse().is_ok_and(has)).collect();
    let sizes: Vec<usize> = sizes.iter().copied().filter(|n| *n <= MOST).collect();
    for scene in scenes::by_size(&sizes, &lab.settings) {
        let scene = scene?;
        let pairs = pairs(&scene, lab)?;
        let apart = searches.iter().map(|search| apart(&scene, search.parse().expect("a search"), &pairs, lab));
        let mut apart = apart.collect::<Result<Vec<_>, _>>()?.into_iter();
        compare(&scene, &searches, lab, &mut |mut row| {
            let [middle, far] = apart.next().expect("one for each search");
            row.extend([("apart", number(middle)), ("far_percent", number(far))]);
            found(row);
        })?;
    }
    Ok(())
}

/// Neighbors of some particles that are spread evenly over the ids, as places in the state.
fn pairs(scene: &Scene, lab: &Lab) -> Result<Vec<(usize, usize)>, Halt> {
    let backend = scene.set_up(SearchPlan::default(), &lab.settings)?;
    let every = scene.state.len().div_ceil(SAMPLE) as u32;
    let pairs = backend.pairs_where(&|id| id.is_multiple_of(every))?;
    // The script numbers particles from 1 in the order in which it makes them.
    Ok(pairs.into_iter().map(|(i, j, _)| (i as usize - 1, j as usize - 1)).collect())
}

/// How dispersed neighbors lie in memory: the middle of the numbers of particles from one to the other, and the percentage of
/// pairs that have more than [`FAR`] between them.
fn apart(scene: &Scene, plan: SearchPlan, pairs: &[(usize, usize)], lab: &Lab) -> Result<[f64; 2], Halt> {
    let mut place = vec![0; scene.state.len()];
    for (to, id) in (0u32..).zip(scene.set_up(plan, &lab.settings)?.order()?) {
        place[id as usize - 1] = to;
    }
    let mut between: Vec<u32> = pairs.iter().map(|(i, j)| u32::abs_diff(place[*i], place[*j])).collect();
    let (count, far) = (between.len().max(1), between.iter().filter(|n| **n > FAR).count());
    let middle = between.len() / 2;
    let median = if between.is_empty() { 0 } else { *between.select_nth_unstable(middle).1 };
    Ok([f64::from(median), 100.0 * far as f64 / count as f64])
}
