//! The pair whose vibration the timestep has to follow most closely.

use super::program::Program;
use super::stride::{COARSE, FINE, hardest, stiffness, two_digits};
use crate::dynamics::Phase;
use crate::system::{SimulationBox, State, Vec3};

/// Most cells along an axis: three numbers of them fit into one of 64 bits.
const MOST_CELLS: f64 = 1e6;

/// The pair of a state with the largest sqrt(U'' / mu), mu being its reduced mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffPair {
    /// Places in the state, the lower id first.
    places: [usize; 2],
    pub ids: [u32; 2],
    /// By minimum image, length units.
    pub distance: f64,
    /// Per time unit.
    omega: f64,
}

impl StiffPair {
    /// Angular frequency times the timestep from which on a timestep is called too large.
    pub const COARSE: f64 = COARSE;

    /// That of a state; `None` where no two particles, of which a fix moves one, attract or repel each other more the farther
    /// they are off some distance.
    pub fn of(program: &Program, state: &State, simulation_box: &SimulationBox) -> Option<Self> {
        let movers = program.fixes.iter().filter(|fix| fix.acts(Phase::Initial)).fold(0, |mask, fix| mask | fix.group);
        let mut stiffest: Option<Self> = None;
        for_each_near(state, simulation_box, program.pair.largest_cutoff(), |i, j, distance| {
            if (state.mask[i] | state.mask[j]) & movers == 0 {
                return;
            }
            let kinds = [i, j].map(|k| state.kind[k] as usize - 1);
            if distance >= program.pair.pairs[kinds[0] * program.pair.types + kinds[1]].cutoff {
                return;
            }
            let squared =
                stiffness(program, kinds.into(), distance) * program.units.ftm2v / reduced_mass(program, kinds);
            if !(squared > 0.0 && squared.is_finite()) {
                return;
            }
            let places = if state.id[i] < state.id[j] { [i, j] } else { [j, i] };
            let pair = Self { places, ids: places.map(|k| state.id[k]), distance, omega: squared.sqrt() };
            let order = |pair: &Self| (pair.omega, std::cmp::Reverse(pair.ids));
            if stiffest.is_none_or(|other| order(&pair) > order(&other)) {
                stiffest = Some(pair);
            }
        });
        stiffest
    }

    /// Its angular frequency times the timestep of the run.
    pub fn omega_dt(&self, program: &Program) -> f64 {
        self.omega * program.timestep
    }

    /// The timestep in which it could be followed on its way, two digits, rounded down; `None` where that is no shorter than that
    /// of the run.
    pub fn timestep(&self, program: &Program, state: &State) -> Option<f64> {
        let [i, j] = self.places;
        let speed = (state.v[i] - state.v[j]).norm();
        let kinds = self.places.map(|k| state.kind[k] as usize - 1);
        let omega = self.omega.max(hardest(program, kinds.into(), speed, self.distance));
        let wanted = two_digits(FINE / omega);
        (wanted < program.timestep && wanted > 0.0).then_some(wanted)
    }
}

fn reduced_mass(program: &Program, [i, j]: [usize; 2]) -> f64 {
    let (a, b) = (program.masses[i], program.masses[j]);
    a * b / (a + b)
}

/// Visits every two particles within `reach` of each other once, with their distance by minimum image.
fn for_each_near(state: &State, simulation_box: &SimulationBox, reach: f64, mut visit: impl FnMut(usize, usize, f64)) {
    if state.is_empty() || reach <= 0.0 {
        return;
    }
    let lengths = simulation_box.lengths();
    let (low, high) = state.bounds();
    let wraps: [bool; 3] = std::array::from_fn(|a| simulation_box.periodic(a));
    let lo = Vec3::from_fn(|a, _| if wraps[a] { simulation_box.lo[a] } else { low[a] });
    let edges = Vec3::from_fn(|a, _| if wraps[a] { lengths[a] } else { high[a] - low[a] });
    let counts: [u64; 3] = std::array::from_fn(|a| {
        let count = (edges[a] / reach).floor().clamp(1.0, MOST_CELLS);
        // Three in a ring are each next to both others; fewer would be met twice.
        if wraps[a] && count < 3.0 { 1 } else { count as u64 }
    });
    let cell = |x: &Vec3| -> [u64; 3] {
        std::array::from_fn(|a| {
            let part = (x[a] - lo[a]) / edges[a];
            let part = if wraps[a] { part - part.floor() } else { part };
            // What is no number, in a box without extent, is in the first cell.
            ((part * counts[a] as f64) as u64).min(counts[a] - 1)
        })
    };
    let key = |cell: [u64; 3]| (cell[0] * counts[1] + cell[1]) * counts[2] + cell[2];
    let mut sorted: Vec<(u64, usize)> = state.x.iter().enumerate().map(|(k, x)| (key(cell(x)), k)).collect();
    sorted.sort_unstable();
    let distance = |i: usize, j: usize| {
        let mut d = state.x[i] - state.x[j];
        for a in 0..3 {
            if wraps[a] {
                d[a] -= lengths[a] * (d[a] / lengths[a]).round();
            }
        }
        d.norm()
    };
    // The cells beside one along an axis, itself among them.
    let beside = |at: u64, a: usize| -> Vec<u64> {
        let count = counts[a];
        match (count, wraps[a]) {
            (1, _) => vec![0],
            (_, true) => vec![(at + count - 1) % count, at, (at + 1) % count],
            (_, false) => (at.saturating_sub(1)..=(at + 1).min(count - 1)).collect(),
        }
    };
    for own in sorted.chunk_by(|a, b| a.0 == b.0) {
        let at = cell(&state.x[own[0].1]);
        for x in beside(at[0], 0) {
            for y in beside(at[1], 1) {
                for z in beside(at[2], 2) {
                    let other = key([x, y, z]);
                    let start = sorted.partition_point(|(key, _)| *key < other);
                    let there = sorted[start..].iter().take_while(|(key, _)| *key == other);
                    for (_, j) in there {
                        for (_, i) in own.iter().filter(|(_, i)| i < j) {
                            let r = distance(*i, *j);
                            if r < reach {
                                visit(*i, *j, r);
                            }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::Side::{Fixed, Periodic};

    #[test]
    fn every_two_near_particles_are_met_once() {
        let mut state = State::default();
        let mut seed = 1u64;
        let mut next = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        // Some lie beyond periodic sides, as they do between list builds.
        for id in 1..=300 {
            state.push(id, 1, Vec3::new(14.0 * next() - 1.0, 5.0 * next(), 9.0 * next()));
        }
        let sides = [[Periodic; 2], [Periodic; 2], [Fixed; 2]];
        let simulation_box = SimulationBox::new(Vec3::zeros(), Vec3::new(12.0, 5.0, 9.0), sides);
        for reach in [0.7, 2.0, 4.0] {
            let mut met = Vec::new();
            for_each_near(&state, &simulation_box, reach, |i, j, _| met.push((i, j)));
            met.sort_unstable();
            let mut expected = Vec::new();
            for i in 0..300 {
                for j in i + 1..300 {
                    let mut d = state.x[i] - state.x[j];
                    d.x -= 12.0 * (d.x / 12.0).round();
                    d.y -= 5.0 * (d.y / 5.0).round();
                    if d.norm() < reach {
                        expected.push((i, j));
                    }
                }
            }
            assert!(expected.len() > 100 && met == expected, "{reach}");
        }
    }
}
