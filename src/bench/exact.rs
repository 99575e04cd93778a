//! Forces and neighbors by definition: some atoms against all others, nearest image, in double precision.

use rayon::prelude::*;

use crate::pair::PairTable;
use crate::system::{RanPark, SimulationBox, State, Vec3};

/// Seed of the sample.
const SEED: u32 = 20250722;
/// Up to this many atoms each is in the sample.
const ALL_UP_TO: usize = 32_000;
/// Atoms of a sample, as far as the work allows; fewest.
const SAMPLE: usize = 1_000;
const SMALLEST_SAMPLE: usize = 100;
/// Distances that a comparison works out at most, so that 64 million atoms take seconds.
const MOST_DISTANCES: usize = 20_000_000_000;
/// Distances worked out at a time.
const BLOCK: usize = 1 << 10;

/// Ids of the atoms that are compared, ascending.
pub fn sample(state: &State) -> Vec<u32> {
    let n = state.len();
    if n <= ALL_UP_TO {
        let mut all = state.id.clone();
        all.sort_unstable();
        return all;
    }
    let count = (MOST_DISTANCES / n).clamp(SMALLEST_SAMPLE, SAMPLE);
    let mut random = RanPark::new(SEED);
    let mut chosen = std::collections::BTreeSet::new();
    while chosen.len() < count {
        // Two numbers of the stream: one alone has 31 bits, whose last ones would be missing in large scenes.
        let place = (random.uniform() + random.uniform() / 65_536.0).fract() * n as f64;
        chosen.insert(state.id[(place as usize).min(n - 1)]);
    }
    chosen.into_iter().collect()
}

/// What is exact about one atom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Atom {
    /// Force units.
    pub force: Vec3,
    /// Ids of atoms within the neighbor cutoff, ascending.
    pub neighbors: Vec<u32>,
    /// Those so near to it that rounding decides, ascending.
    pub undecided: Vec<u32>,
}

/// The sampled atoms of a state in order of their ids. `band` is the distance to a neighbor cutoff within which rounding decides,
/// length units. Every edge of the periodic box must have twice the largest neighbor cutoff.
pub fn look_up(
    pair: &PairTable,
    skin: f64,
    state: &State,
    simulation_box: &SimulationBox,
    ids: &[u32],
    band: f64,
) -> Vec<Atom> {
    let axes: [Vec<f64>; 3] = std::array::from_fn(|a| state.x.iter().map(|x| x[a]).collect());
    let radii = pair.neighbor_cutoffs(skin);
    let reach = radii.iter().copied().fold(0.0, f64::max) + band;
    let edges = simulation_box.lengths();
    let one = |place: usize| {
        let mut atom = Atom::default();
        let x = state.x[place];
        let mut squared = [0.0; BLOCK];
        for first in (0..state.len()).step_by(BLOCK) {
            let end = (first + BLOCK).min(state.len());
            squared.fill(0.0);
            for a in 0..3 {
                for (sum, other) in squared.iter_mut().zip(&axes[a][first..end]) {
                    let d = nearest(x[a] - other, edges[a]);
                    *sum += d * d;
                }
            }
            for other in first..end {
                if squared[other - first] > reach * reach || other == place {
                    continue;
                }
                let d = Vec3::from_fn(|a, _| nearest(x[a] - state.x[other][a], edges[a]));
                let (i, j) = (state.kind[place] as usize - 1, state.kind[other] as usize - 1);
                let (r, radius) = (d.norm(), radii[i * pair.types + j]);
                if let Some(value) = pair.evaluate(i, j, r) {
                    atom.force += d * value.force_over_r;
                }
                if (r - radius).abs() <= band {
                    atom.undecided.push(state.id[other]);
                } else if r < radius {
                    atom.neighbors.push(state.id[other]);
                }
            }
        }
        atom.neighbors.sort_unstable();
        atom.undecided.sort_unstable();
        atom
    };
    places(state, ids).into_par_iter().map(one).collect()
}

/// Where the sampled atoms stand in a state, in order of their ids.
fn places(state: &State, ids: &[u32]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..state.len()).filter(|k| ids.binary_search(&state.id[*k]).is_ok()).collect();
    places.sort_unstable_by_key(|k| state.id[*k]);
    places
}

/// A separation along an axis, of positions less than one and a half edges apart, to the nearest image.
fn nearest(d: f64, edge: f64) -> f64 {
    let half = 0.5 * edge;
    let shift = f64::from(u8::from(d > half)) - f64::from(u8::from(d < -half));
    d - edge * shift
}

/// RMS error of the forces of a state on the sampled atoms and that of the worst atom, over the RMS force.
pub fn force_errors(ids: &[u32], atoms: &[Atom], state: &State) -> (f64, f64) {
    let mean = |terms: &mut dyn Iterator<Item = f64>| terms.sum::<f64>() / atoms.len().max(1) as f64;
    let force = mean(&mut atoms.iter().map(|atom| atom.force.norm_squared()));
    let given = places(state, ids);
    let off: Vec<f64> = atoms.iter().zip(given).map(|(atom, k)| (atom.force - state.f[k]).norm_squared()).collect();
    let worst = off.iter().copied().fold(0.0, f64::max);
    ((mean(&mut off.into_iter()) / force).sqrt(), (worst / force).sqrt())
}

/// Pairs that a list lacks, and pairs that it has too much: `listed` has the ids of both atoms of a pair, sorted, for the
/// atoms of the sample.
pub fn missing_and_extra(ids: &[u32], atoms: &[Atom], listed: &[(u32, u32)]) -> (usize, usize) {
    let (mut missing, mut extra) = (0, 0);
    for (id, atom) in ids.iter().zip(atoms) {
        let begin = listed.partition_point(|(i, _)| i < id);
        let end = listed.partition_point(|(i, _)| i <= id);
        let row: Vec<u32> = listed[begin..end].iter().map(|(_, j)| *j).collect();
        missing += atom.neighbors.iter().filter(|j| row.binary_search(j).is_err()).count();
        let right = |j: &u32| atom.neighbors.binary_search(j).is_ok() || atom.undecided.binary_search(j).is_ok();
        extra += row.iter().filter(|j| !right(j)).count();
        // A pair that stands there twice is one too many.
        extra += row.windows(2).filter(|two| two[0] == two[1]).count();
    }
    (missing, extra)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::PairCoefficients;
    use crate::system::Side;

    fn pair_of(distance: f64) -> (PairTable, State, SimulationBox) {
        let mut pair = PairCoefficients::new("lj/cut", 2.5, 1).unwrap();
        pair.set((1, 1), (1, 1), &["1.0", "1.0"]).unwrap();
        let mut state = State::default();
        // Across a periodic side.
        state.push(7, 1, Vec3::new(0.25, 5.0, 5.0));
        state.push(3, 1, Vec3::new(10.25 - distance, 5.0, 5.0));
        state.push(9, 1, Vec3::new(5.0, 0.0, 0.0));
        let space = SimulationBox::new(Vec3::zeros(), Vec3::repeat(10.0), [[Side::Periodic; 2]; 3]);
        (pair.complete().unwrap().0, state, space)
    }

    #[test]
    fn two_atoms_across_a_side() {
        let (pair, state, space) = pair_of(1.5);
        let ids = sample(&state);
        assert_eq!(ids, [3, 7, 9]);
        let atoms = look_up(&pair, 0.3, &state, &space, &ids, 1e-9);
        // 24 (2 r^-13 - r^-7)
        let force = 24.0 * (2.0 * 1.5f64.powi(-13) - 1.5f64.powi(-7));
        assert!((atoms[1].force.x - force).abs() < 1e-12 && (atoms[0].force.x + force).abs() < 1e-12);
        assert_eq!(atoms.iter().map(|a| a.neighbors.clone()).collect::<Vec<_>>(), [vec![7], vec![3], vec![]]);
        assert_eq!(missing_and_extra(&ids, &atoms, &[(3, 7), (7, 3)]), (0, 0));
        assert_eq!(missing_and_extra(&ids, &atoms, &[(3, 7)]), (1, 0));
        assert_eq!(missing_and_extra(&ids, &atoms, &[(3, 7), (7, 3), (7, 3), (9, 3)]), (0, 2));
        // Nothing was given: the error is the force itself.
        let (rms, worst) = force_errors(&ids, &atoms, &state);
        assert!((rms - 1.0).abs() < 1e-12 && (worst - 1.5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn at_the_cutoff_rounding_decides() {
        let (pair, state, space) = pair_of(2.8);
        let ids = sample(&state);
        let atoms = look_up(&pair, 0.3, &state, &space, &ids, 1e-9);
        assert_eq!((atoms[0].neighbors.len(), &atoms[0].undecided[..]), (0, &[7][..]));
        assert_eq!(missing_and_extra(&ids, &atoms, &[(3, 7)]), (0, 0));
    }

    #[test]
    fn a_sample_of_many_is_spread_and_the_same_again() {
        let mut state = State::default();
        (1..=40_000).for_each(|id| state.push(id, 1, Vec3::zeros()));
        let ids = sample(&state);
        assert_eq!((ids.len(), &ids), (SAMPLE, &sample(&state)));
        assert!(ids.is_sorted() && ids[0] < 1_000 && ids[SAMPLE - 1] > 39_000);
    }
}
