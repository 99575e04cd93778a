//! Forces and neighbors by definition: some atoms against all others and their images, in double precision.

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
    let most = if n <= ALL_UP_TO { n } else { (MOST_DISTANCES / n).clamp(SMALLEST_SAMPLE, SAMPLE) };
    sample_of(state, most)
}

/// Ids of at most so many atoms, drawn at random, always the same; ascending.
pub fn sample_of(state: &State, count: usize) -> Vec<u32> {
    let n = state.len();
    if n <= count {
        let mut all = state.id.clone();
        all.sort_unstable();
        return all;
    }
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

/// All that is around an atom: every other atom in every periodic image that is in reach.
struct Surroundings<'a> {
    state: &'a State,
    /// Positions, one array an axis; within less than an edge and a half of each other along periodic axes.
    axes: [Vec<f64>; 3],
    /// Edges of periodic axes, 0 for others.
    edges: Vec3,
    /// From the nearest image to those in reach; the nearest alone where the box has twice the reach.
    images: Vec<Vec3>,
    reach: f64,
}

impl<'a> Surroundings<'a> {
    fn new(state: &'a State, space: &SimulationBox, reach: f64) -> Self {
        let edges = Vec3::from_fn(|a, _| if space.periodic(a) { space.lengths()[a] } else { 0.0 });
        let counts = [0, 1, 2].map(|a| match edges[a] {
            edge if edge > 0.0 && edge < 2.0 * reach => (reach / edge + 0.5) as i32,
            _ => 0,
        });
        let axis = |a: usize| {
            let small = counts[a] > 0;
            // Wrapping rounds, so what the nearest image can cope with stays as it is.
            let near = |x: f64| !small && (x - space.lo[a]).clamp(-0.25 * edges[a], 1.25 * edges[a]) == x - space.lo[a];
            let wrap = |x: f64| match edges[a] {
                edge if edge == 0.0 || near(x) => x,
                edge => x - edge * ((x - space.lo[a]) / edge).floor(),
            };
            state.x.iter().map(|x| wrap(x[a])).collect()
        };
        let range = |a: usize| (-counts[a]..=counts[a]).map(f64::from);
        let all = range(0).flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| Vec3::new(x, y, z))));
        let images = all.map(|image| image.component_mul(&edges)).collect();
        Self { state, axes: [0, 1, 2].map(axis), edges, images, reach }
    }

    /// Calls `see` with each atom in reach and the vector from it.
    fn each(&self, place: usize, mut see: impl FnMut(usize, Vec3)) {
        let x: [f64; 3] = std::array::from_fn(|a| self.axes[a][place]);
        let mut squared = [0.0; BLOCK];
        for image in &self.images {
            let apart = |a: usize, other: f64| nearest(x[a] - other, self.edges[a]) + image[a];
            for first in (0..self.state.len()).step_by(BLOCK) {
                let end = (first + BLOCK).min(self.state.len());
                squared.fill(0.0);
                for a in 0..3 {
                    for (sum, other) in squared.iter_mut().zip(&self.axes[a][first..end]) {
                        let d = apart(a, *other);
                        *sum += d * d;
                    }
                }
                for other in first..end {
                    let itself = other == place && *image == Vec3::zeros();
                    if squared[other - first] <= self.reach * self.reach && !itself {
                        see(other, Vec3::from_fn(|a, _| apart(a, self.axes[a][other])));
                    }
                }
            }
        }
    }
}

/// The sampled atoms of a state in order of their ids. `band` is the distance to a neighbor cutoff within which rounding decides,
/// length units.
pub fn look_up(
    pair: &PairTable,
    skin: f64,
    state: &State,
    simulation_box: &SimulationBox,
    ids: &[u32],
    band: f64,
) -> Vec<Atom> {
    let radii = pair.neighbor_cutoffs(skin);
    let reach = radii.iter().copied().fold(0.0, f64::max) + band;
    let around = Surroundings::new(state, simulation_box, reach);
    let one = |place: usize| {
        let mut atom = Atom::default();
        around.each(place, |other, d| {
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
        });
        atom.neighbors.sort_unstable();
        atom.undecided.sort_unstable();
        atom
    };
    places(state, ids).into_par_iter().map(one).collect()
}

/// Pairs of a length unit of distance at their force cutoff, of each pair of types (row-major, both orders apart), in the whole scene as
/// the sampled atoms have them: those within `half_width` of it, counted.
pub fn pairs_at_cutoff(
    pair: &PairTable,
    state: &State,
    simulation_box: &SimulationBox,
    ids: &[u32],
    half_width: f64,
) -> Vec<f64> {
    let around = Surroundings::new(state, simulation_box, pair.largest_cutoff() + half_width);
    let counted = places(state, ids).into_par_iter().map(|place| {
        let mut counts = vec![0.0; pair.pairs.len()];
        around.each(place, |other, d| {
            let k = (state.kind[place] as usize - 1) * pair.types + state.kind[other] as usize - 1;
            let cutoff = pair.pairs[k].cutoff;
            counts[k] += f64::from(u8::from(cutoff > 0.0 && (d.norm() - cutoff).abs() < half_width));
        });
        counts
    });
    let add = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).map(|(x, y)| x + y).collect();
    let counts = counted.reduce(|| vec![0.0; pair.pairs.len()], add);
    // Every pair is seen from both its atoms.
    let scale = state.len() as f64 / ids.len().max(1) as f64 / (2.0 * half_width) / 2.0;
    counts.into_iter().map(|count| count * scale).collect()
}

/// What the energy of the scene curves by, for each sampled atom: the sum of its second derivatives along the axes, U'' + 2 U' / r over all in
/// reach, energy over length squared. The step of a force at the cutoff is no part of it.
pub fn curvatures(pair: &PairTable, state: &State, simulation_box: &SimulationBox, ids: &[u32]) -> Vec<f64> {
    // Of r: forces are exact to 1e-16, so a difference over it is to some 1e-9.
    const STEP: f64 = 1e-6;
    let around = Surroundings::new(state, simulation_box, pair.largest_cutoff());
    let one = |place: usize| {
        let mut sum = 0.0;
        around.each(place, |other, d| {
            let (i, j, r) = (state.kind[place] as usize - 1, state.kind[other] as usize - 1, d.norm());
            let inside = r < pair.pairs[i * pair.types + j].cutoff;
            let force = |r: f64| pair.evaluate(i, j, r).map_or(0.0, |value| value.force_over_r * r);
            if inside && r > 0.0 {
                sum -= (force(r) - force(r * (1.0 - STEP))) / (r * STEP) + 2.0 * force(r) / r;
            }
        });
        sum
    };
    places(state, ids).into_par_iter().map(one).collect()
}

/// Where the sampled atoms stand in a state, in order of their ids.
fn places(state: &State, ids: &[u32]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..state.len()).filter(|k| ids.binary_search(&state.id[*k]).is_ok()).collect();
    places.sort_unstable_by_key(|k| state.id[*k]);
    places
}

/// A separation along an axis, of positions less than one and a half edges apart, to the nearest image; as it is where the edge is 0.
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
/// atoms of the sample; a pair that meets in several images stands there as often.
pub fn missing_and_extra(ids: &[u32], atoms: &[Atom], listed: &[(u32, u32)]) -> (usize, usize) {
    let (mut missing, mut extra) = (0, 0);
    let times = |of: &[u32], id: u32| of.partition_point(|k| *k <= id) - of.partition_point(|k| *k < id);
    for (id, atom) in ids.iter().zip(atoms) {
        let begin = listed.partition_point(|(i, _)| i < id);
        let end = listed.partition_point(|(i, _)| i <= id);
        let row: Vec<u32> = listed[begin..end].iter().map(|(_, j)| *j).collect();
        for same in atom.neighbors.chunk_by(|a, b| a == b) {
            missing += same.len().saturating_sub(times(&row, same[0]));
        }
        for same in row.chunk_by(|a, b| a == b) {
            let right = times(&atom.neighbors, same[0]) + times(&atom.undecided, same[0]);
            extra += same.len().saturating_sub(right);
        }
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
    fn curvatures_are_second_derivatives() {
        let (pair, state, space) = pair_of(1.2);
        let curved = curvatures(&pair, &state, &space, &sample(&state));
        // 4 (156 r^-14 - 42 r^-8) + 2 / r 4 (-12 r^-13 + 6 r^-7)
        let r = 1.2f64;
        let expected = 4.0 * (132.0 * r.powi(-14) - 30.0 * r.powi(-8));
        assert!(
            (curved[0] / expected - 1.0).abs() < 1e-4 && curved[0] == curved[1] && curved[2] == 0.0,
            "{curved:?} {expected}"
        );
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
    fn a_small_box_has_images_and_a_free_side_none() {
        let (pair, mut state, _) = pair_of(1.5);
        state.x[2] = Vec3::new(0.0, 2.0, -7.0);
        let space = SimulationBox::new(
            Vec3::zeros(),
            Vec3::new(10.0, 4.0, 2.0),
            [[Side::Fixed; 2], [Side::Periodic; 2], [Side::Periodic; 2]],
        );
        let ids = sample(&state);
        let atoms = look_up(&pair, 0.0, &state, &space, &ids, 1e-9);
        // Along z an image at 2 on either side; 7 lies at (0.25, 1, 1), 9 at (0, 2, 1), and 3 on the far side of a free axis.
        assert_eq!(atoms[0].neighbors, [3, 3]);
        assert_eq!(atoms[1].neighbors, [7, 7, 9, 9, 9]);
        let own = atoms[2].neighbors.iter().filter(|id| **id == 9).count();
        assert_eq!((own, atoms[2].neighbors.len()), (2, 5));
        let once: Vec<(u32, u32)> = vec![(3, 3), (7, 7), (7, 7), (7, 9), (7, 9), (7, 9), (7, 9), (9, 7)];
        assert_eq!(missing_and_extra(&ids, &atoms, &once), (1 + 2 + 2, 1));
        let shell = pairs_at_cutoff(&pair, &state, &space, &ids, 0.3);
        // Between 2.2 and 2.8 apart are 7 and 9 alone, in two images.
        assert!((shell[0] - 2.0 / 0.6).abs() < 1e-12, "{shell:?}");
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
