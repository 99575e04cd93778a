//! Figure 4: time of the search against the number of adjacent cells that hold particles, one direction at a time.
//!
//! The engine's standard search with cells of edge R/2 looks two cells far. Particles fill blocks of up to 3 x 3 x 3 cells, with the
//! same load in each cell and two empty cells between blocks: so a particle of a block of n cells finds particles in its own cell and
//! in exactly n - 1 others. Each looks up the same 125 cells, empty or not, which is part of the time at no adjacent cell.

use super::experiment::{Experiment, Row};
use super::measure::{Lab, time};
use super::scenes::{self, Scene};
use crate::bench::Halt;
use crate::neighbor::Search;
use crate::system::random::RanPark;
use crate::system::{Side, SimulationBox, State, Vec3};

/// Cells of a block along each axis: the own cell; one direction alone, X, Y, Z; then X, Y and Z in turn, each beside what is full.
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

/// Cells that the search looks far, and so the empty ones between blocks.
const REACH: usize = 2;

/// Particles of a cell: a warp of a GPU, and enough that tests weigh beside the cells that are looked up.
const LOAD: usize = 32;

/// Relative widening of the cells, so that the search cuts the box into these very cells: it asks for a little more than R/2 itself.
const WIDER: f64 = 1e-5;

/// Cells with particles are a multiple of this, which all blocks divide: 27 times the cube of an even number.
const LARGEST_BLOCK: usize = 27;

/// Most particles.
const MOST: usize = 250_000;

const SEED: u32 = 4;

pub static EXPERIMENT: Experiment = Experiment {
    name: "figure4",
    title: "Figure 4: search against adjacent cells with particles, one direction at a time, microseconds a list (without the sort)",
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

/// Every block, with about as many particles as the largest size.
pub fn run(sizes: &[usize], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    let cells = cells_for(scenes::largest(sizes, MOST));
    let scenes = BLOCKS.iter().map(|block| scene(*block, cells, lab)).collect::<Result<Vec<_>, _>>()?;
    let search = Search::Standard.with_edge(1.0 / REACH as f64).expect("an edge that the search has");
    let cases: Vec<_> = scenes.iter().map(|scene| (scene, search)).collect();
    let mut blocks = BLOCKS.iter();
    time(&cases, lab, &mut |scene, timed| {
        let block = blocks.next().expect("a scene for each block");
        found(row(*block, scene, timed.cells(scene.state.len(), lab)));
    })
}

/// Cells that hold about so many particles.
fn cells_for(particles: usize) -> usize {
    let half = ((particles as f64 / (LOAD * LARGEST_BLOCK) as f64).cbrt() / 2.0).round() as usize;
    LARGEST_BLOCK * (2 * half.max(1)).pow(3)
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

/// `cells` cells with particles, in blocks.
fn scene(block: [usize; 3], cells: usize, lab: &Lab) -> Result<Scene, Halt> {
    let counts = near_cube(cells / block.iter().product::<usize>());
    let forces = scenes::uniform(2, 2.0, 0, &lab.settings)?;
    let edge = forces.radius() / REACH as f64 * (1.0 + WIDER);
    let period: [usize; 3] = block.map(|n| n + REACH);
    let lengths = Vec3::from_fn(|axis, _| edge * (counts[axis] * period[axis]) as f64);
    let simulation_box = SimulationBox::new(Vec3::zeros(), lengths, [[Side::Periodic; 2]; 3]);
    let mut random = RanPark::new(SEED);
    let mut state = State::default();
    for number in 0..counts.iter().product() {
        let corner = unfold(number, counts);
        for within in 0..block.iter().product() {
            let within = unfold(within, block);
            for _ in 0..LOAD {
                let at = |axis: usize| (corner[axis] * period[axis] + within[axis]) as f64;
                let x = Vec3::from_fn(|axis, _| edge * (at(axis) + random.uniform()));
                state.push(state.len() as u32 + 1, 1, x);
            }
        }
    }
    Ok(forces.with("blocks", state, simulation_box))
}

/// Places along the axes of number `k` of a block, X fastest.
fn unfold(k: usize, [x, y, _]: [usize; 3]) -> [usize; 3] {
    [k % x, k / x % y, k / x / y]
}

/// Three factors of a number, as near to each other as there are.
fn near_cube(number: usize) -> [usize; 3] {
    let divisors = |n: usize| (1..=n).filter(move |d| n.is_multiple_of(*d));
    let all = divisors(number).flat_map(|x| divisors(number / x).map(move |y| [x, y, number / x / y]));
    all.filter(|[x, y, z]| x <= y && y <= z).min_by_key(|[x, _, z]| z - x).expect("1, 1 and itself")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_blocks_fill_as_many_cells() {
        for particles in [0, 6_000, 60_000, 186_624, 250_000] {
            let cells = cells_for(particles);
            assert!(BLOCKS.iter().all(|block| cells.is_multiple_of(block.iter().product())), "{cells}");
        }
        assert_eq!(cells_for(186_624) * LOAD, 186_624);
        assert_eq!((near_cube(216), near_cube(12), near_cube(7)), ([6, 6, 6], [2, 2, 3], [1, 1, 7]));
        // A box narrower than the search looks would have particles find images of their own block.
        for block in BLOCKS {
            let counts = near_cube(cells_for(0) / block.iter().product::<usize>());
            assert!(counts.iter().zip(block).all(|(count, n)| count * (n + REACH) > 2 * REACH));
        }
    }
}
