//! How Table 1 goes on: neighbors of a particle after steps of the paper's own run, which spreads them.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::experiment::{Experiment, Row, number};
use super::measure::Lab;
use super::scenes;
use super::table1::TABLE_1;
use crate::Error;
use crate::bench::Halt;
use crate::engine::{Needs, Stop};
use crate::session::FirstRun;

/// Steps after which neighbors are counted.
const STEPS: [u64; 8] = [0, 1, 2, 5, 10, 20, 50, 100];

pub static EXPERIMENT: Experiment = Experiment {
    name: "later",
    title: "Table 1 later: neighbors of a particle, and particles left, as the paper's run goes on (walls, gravity, second-order Euler)",
    shown: &["force", "particles", "step", "left_percent", "neighbors", "neighbors_over_first"],
};

/// The sizes of Table 1 up to the largest that is asked for, the first at least, with either reading of the force.
pub fn run(sizes: &[usize], lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    let most = sizes.iter().copied().fold(TABLE_1[0].particles, usize::max);
    for force in ["inverse", "spring"] {
        for of in TABLE_1.iter().filter(|of| of.particles <= most) {
            let start = scenes::start(of.particles, of.edge, 0, &[("force", force)], &lab.settings)?;
            let FirstRun { program, state, simulation_box, .. } = start;
            let (mut backend, _) = lab.settings.engine()?;
            backend.load(Arc::new(program), &state, &simulation_box, 0)?;
            let halt = |stop: Stop| Error::Fault(format!("{force}, {} particles: {stop}", of.particles));
            backend.set_up(Needs::default()).map_err(halt)?;
            let (mut done, mut first) = (0, 0.0);
            for step in STEPS {
                backend.advance(step - done, Needs::default(), &AtomicBool::new(false)).map_err(halt)?;
                done = step;
                // Lists are built at every step: these are the neighbors at this one.
                let counts = backend.neighbor_counts()?;
                let neighbors = counts.iter().map(|n| f64::from(*n)).sum::<f64>() / counts.len().max(1) as f64;
                if step == 0 {
                    first = neighbors;
                }
                let mut row: Row = vec![
                    ("force", force.into()),
                    ("particles", of.particles.to_string()),
                    ("step", step.to_string()),
                    ("left", counts.len().to_string()),
                    ("left_percent", number(100.0 * counts.len() as f64 / of.particles as f64)),
                    ("neighbors", number(neighbors)),
                    ("neighbors_over_first", number(neighbors / first)),
                    ("paper", of.neighbors.to_string()),
                ];
                row.extend(lab.cells());
                found(row);
                lab.check_interrupt()?;
            }
        }
    }
    Ok(())
}
