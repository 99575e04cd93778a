//! Table 1: neighbors of a particle at step 0.

use std::f64::consts::PI;

use super::experiment::{Experiment, Row, number};
use super::measure::Lab;
use super::scenes;
use crate::bench::{Halt, Spread};

/// A column of the paper's Table 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    pub particles: usize,
    /// Neighbors of a particle, as printed.
    pub neighbors: u32,
    /// Edge of the cube, in influence radii R, that was chosen for `inputs/paper/`; the paper does not tell one.
    pub edge: f64,
}

/// The paper's eight sizes.
pub const TABLE_1: [Published; 8] = [
    Published { particles: 1000, neighbors: 10, edge: 7.082 },
    Published { particles: 2000, neighbors: 13, edge: 8.241 },
    Published { particles: 5000, neighbors: 17, edge: 10.329 },
    Published { particles: 10_000, neighbors: 21, edge: 12.199 },
    Published { particles: 20_000, neighbors: 30, edge: 13.695 },
    Published { particles: 50_000, neighbors: 41, edge: 16.838 },
    Published { particles: 100_000, neighbors: 50, edge: 19.927 },
    Published { particles: 200_000, neighbors: 62, edge: 23.436 },
];

/// Mean number of others within R of one of `particles` points that are even at random in a cube with an edge of so many R: the
/// cube cuts the spheres of those near its sides (the distribution of distances in a cube, integrated).
pub fn expected_neighbors(particles: usize, edge: f64) -> f64 {
    let s = 1.0 / edge;
    let part = 4.0 * PI * s.powi(3) / 3.0 - 3.0 * PI * s.powi(4) / 2.0 + 8.0 * s.powi(5) / 5.0 - s.powi(6) / 6.0;
    (particles.max(1) - 1) as f64 * part
}

pub static EXPERIMENT: Experiment = Experiment {
    name: "table1",
    title: "Table 1: neighbors of a particle at step 0, median over seeds",
    shown: &["particles", "edge", "neighbors", "neighbors_least", "neighbors_most", "expected", "paper"],
};

/// Counts for every size, with as many seeds as there are rounds, the first being that of `inputs/paper/`.
pub fn run(lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    for Published { particles, neighbors, edge } in TABLE_1 {
        let mut means = Vec::new();
        for round in 0..lab.rounds {
            let scene = scenes::uniform(particles, edge, round, &lab.settings)?;
            let backend = scene.set_up(lab.settings.search, &lab.settings)?;
            let counts = backend.neighbor_counts()?;
            means.push(counts.iter().map(|n| f64::from(*n)).sum::<f64>() / particles as f64);
            lab.check_interrupt()?;
        }
        let Spread { median, least, most } = Spread::of(&means);
        let mut row = vec![
            ("particles", particles.to_string()),
            ("edge", number(edge)),
            ("seeds", lab.rounds.to_string()),
            ("neighbors", number(median)),
            ("neighbors_least", number(least)),
            ("neighbors_most", number(most)),
            ("expected", number(expected_neighbors(particles, edge))),
            ("paper", neighbors.to_string()),
        ];
        row.extend(lab.cells());
        found(row);
    }
    Ok(())
}
