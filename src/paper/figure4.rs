//! Figure 4: time of the search against the number of adjacent cells that it looks into, one direction at a time.
//!
//! Particles stand still in a periodic box of cells of edge R with the same load in each. The engine's standard search with these
//! cells in rows, as the paper has them, is told to look to some sides alone: what it finds is no neighbor list then.

use super::experiment::{Experiment, Row};
use super::measure::{Lab, time};
use super::scenes::{self, Scene};
use crate::bench::Halt;
use crate::neighbor::{CellOrder, Search, SearchPlan};
use crate::session::Settings;
use crate::system::random::RanPark;
use crate::system::{Side, SimulationBox, State, Vec3};

/// Cells looked into along each axis (two: the own and the upper one): the own cell; one direction alone, X, Y, Z; then X, Y and Z
/// in turn, each beside what is full.
const BLOCKS: [[usize; 3]; 11] = [
    [1, 1, 1],
    [2, 1, 1],
    [3, 1, 1],
    [1, 2, 1],
    [1, 3, 1],
    [1, 1, 2],
    [1, 1, 3],
    [3, 2, 1],
    [3, 3, 1],
    [3, 3, 2],
    [3, 3, 3],
];

/// Particles of a cell: a warp of a GPU, and enough that tests weigh beside the cells that are looked up.
const LOAD: usize = 32;

/// Relative widening of the cells, so that the search cuts the box into these very cells: it asks for a little more than R itself.
const WIDER: f64 = 1e-5;

/// Fewest cells along an axis: with fewer, one could be looked into in two of its images.
const FEWEST: usize = 3;

/// Most particles.
const MOST: usize = 250_000;

const SEED: u32 = 4;

pub static EXPERIMENT: Experiment = Experiment {
    name: "figure4",
    title: "Figure 4: search against adjacent cells that are looked into, one direction at a time, microseconds a list (without the sort)",
    shown: &[
        "direction",
        "block",
        "adjacent_cells",
        "particles",
        "neighbors",
        "tests_per_particle",
        "list_us",
        "list_us_least",
        "list_us_most",
    ],
};

/// Every direction, with about as many particles as the largest size.
pub fn run(sizes: &[usize], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    let scene = scene(cells_for(scenes::largest(sizes, MOST)), &lab.settings)?;
    let cases: Vec<_> = BLOCKS.iter().map(|block| (&scene, looking(*block))).collect();
    let mut blocks = BLOCKS.iter();
    time(&cases, lab, &mut |scene, timed| {
        let block = blocks.next().expect("a search for each");
        found(row(*block, scene, timed.cells(scene.state.len(), lab)));
    })
}

/// The search that looks into so many cells along each axis.
fn looking(block: [usize; 3]) -> SearchPlan {
    Search::Standard.plan().with_order(CellOrder::Rows).looking(block.map(|cells| [cells > 2, cells > 1]))
}

/// Cells along an axis of a cube that holds about so many particles.
fn cells_for(particles: usize) -> usize {
    ((particles as f64 / LOAD as f64).cbrt().round() as usize).max(FEWEST)
}

fn row(block: [usize; 3], scene: &Scene, rest: Row) -> Row {
    let direction: String = "XYZ".chars().zip(block).filter(|(_, n)| *n > 1).map(|(axis, _)| axis).collect();
    let [x, y, z] = block;
    let mut row: Row = vec![
        ("direction", if direction.is_empty() { "own".into() } else { direction }),
        ("block", format!("{x}x{y}x{z}")),
        ("adjacent_cells", (x * y * z - 1).to_string()),
        ("load", LOAD.to_string()),
        ("particles", scene.state.len().to_string()),
    ];
    row.extend(rest);
    row
}

/// A cube of cells, so many along each axis.
fn scene(cells: usize, settings: &Settings) -> Result<Scene, Halt> {
    let forces = scenes::uniform(2, 2.0, 0, settings)?;
    let edge = forces.radius() * (1.0 + WIDER);
    let lengths = Vec3::repeat(edge * cells as f64);
    let simulation_box = SimulationBox::new(Vec3::zeros(), lengths, [[Side::Periodic; 2]; 3]);
    let mut random = RanPark::new(SEED);
    let mut state = State::default();
    for cell in 0..cells.pow(3) {
        let corner = [cell % cells, cell / cells % cells, cell / cells.pow(2)];
        for _ in 0..LOAD {
            let x = Vec3::from_fn(|axis, _| edge * (corner[axis] as f64 + random.uniform()));
            state.push(state.len() as u32 + 1, 1, x);
        }
    }
    Ok(forces.with("loaded", state, simulation_box))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_the_searches_own_and_equally_full() {
        for particles in [0, 6_000, 60_000, MOST] {
            let cells = cells_for(particles);
            assert!(cells == FEWEST || (cells.pow(3) * LOAD) as f64 / particles as f64 - 1.0 < 0.2, "{cells}");
        }
        let settings = Settings { threads: 1, ..Settings::default() };
        let scene = scene(4, &settings).ok().expect("the scene is set up");
        for block in BLOCKS {
            let tested = scene.set_up(looking(block), &settings).expect("an engine").work().distance_tests_per_atom;
            assert_eq!(tested, (block.iter().product::<usize>() * LOAD) as f64, "{block:?}");
        }
    }
}
