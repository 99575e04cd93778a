//! Every search gives the pairs of an all-pairs loop, whatever the box, the sides, the density.

mod common;

use common::{Variant, arc, free_or_periodic, melt, program, variants};
use octant::engine::{Needs, Precision};
use octant::neighbor::Search;
use octant::system::{SimulationBox, State, Vec3};
use proptest::prelude::*;

type Pairs = Vec<(u32, u32, [i32; 3])>;

/// All pairs within R of each other over all periodic images, straight from the definition; second, the pairs so near to R
/// that the rounding of a periodic shift decides.
fn oracle(state: &State, simulation_box: &SimulationBox, radius: impl Fn(u32, u32) -> f64) -> (Pairs, Pairs) {
    let mut wrapped = state.x.clone();
    for x in &mut wrapped {
        simulation_box.wrap(x, &mut [0; 3]);
    }
    let lengths = simulation_box.lengths();
    let most = (1..=3).flat_map(|i| (1..=3).map(move |j| (i, j))).map(|(i, j)| radius(i, j)).fold(0.0, f64::max);
    let reach = |axis: usize| if simulation_box.periodic(axis) { (most / lengths[axis]).ceil() as i32 } else { 0 };
    let (mut pairs, mut ties) = (Vec::new(), Vec::new());
    for i in 0..state.len() {
        for j in 0..state.len() {
            let r = radius(state.kind[i], state.kind[j]);
            for kz in -reach(2)..=reach(2) {
                for ky in -reach(1)..=reach(1) {
                    for kx in -reach(0)..=reach(0) {
                        let image = [kx, ky, kz];
                        let shift = Vec3::from(image.map(f64::from)).component_mul(&lengths);
                        let d = wrapped[i] - (wrapped[j] + shift);
                        let pair = (state.id[i], state.id[j], image);
                        if i == j && image == [0; 3] {
                            continue;
                        } else if image != [0; 3] && (d.norm() - r).abs() < 1e-12 {
                            ties.push(pair);
                        } else if d.norm_squared() <= r * r {
                            pairs.push(pair);
                        }
                    }
                }
            }
        }
    }
    pairs.sort_unstable();
    (pairs, ties)
}

fn searched(
    variant: &Variant,
    search: Search,
    cutoffs: &[f64],
    state: &State,
    simulation_box: &SimulationBox,
) -> (Pairs, Vec<u32>, State) {
    let mut backend = variant.backend(1);
    backend.load(arc(program(cutoffs, 0.3, search)), state, simulation_box, 0).unwrap();
    // Forces of overlapping particles may overflow; the list stands by then.
    let _ = backend.set_up(Needs::default());
    let mut listed = State::default();
    backend.fetch(&mut listed).unwrap();
    (backend.pairs().unwrap(), backend.neighbor_counts().unwrap(), listed)
}

/// A number of box heights that puts particles on faces, edges, corners and mid-planes often.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.0..1.0f64, 1 => prop::sample::select(vec![0.0, 0.25, 0.5, 0.75, 1.0 - 1e-16, 1e-17])]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 320, ..ProptestConfig::default() })]
    #[test]
    fn all_searches_give_the_same_pairs(
        edges in prop::array::uniform3(prop_oneof![0.7..3.0f64, 3.0..14.0f64, Just(5.6), Just(2.8), Just(11.2)]),
        lo in prop::array::uniform3(prop_oneof![Just(0.0), -5.0..5.0f64]),
        periodic in prop::array::uniform3(any::<bool>()),
        points in prop::collection::vec((prop::array::uniform3(coordinate()), 1u32..=2), 0..60),
        squeeze in prop_oneof![3 => Just(1.0), 1 => Just(1e-3)],
        variant in prop::sample::select(variants()),
    ) {
        let simulation_box = free_or_periodic(lo, edges, periodic);
        let mut state = State::default();
        for (k, (p, kind)) in points.iter().enumerate() {
            let x = Vec3::from(*p).component_mul(&Vec3::from(edges)) * squeeze + Vec3::from(lo);
            // At the upper face a particle would be lost through a free side; one place below it is the extreme.
            let x = x.zip_map(&simulation_box.hi, |x, hi| x.min(hi.next_down()));
            // Ids out of storage order.
            state.push(((k * 37) % 61 + 1) as u32, *kind, x);
        }
        let cutoffs = [2.5, 1.2];
        let radius = |a: u32, b: u32| (cutoffs[a.min(2) as usize - 1] + cutoffs[b.min(2) as usize - 1]) / 2.0 + 0.3;
        let (reference, _, listed) = searched(&variant, Search::Brute, &cutoffs, &state, &simulation_box);
        for (i, j, image) in &reference {
            prop_assert!(reference.binary_search(&(*j, *i, image.map(|k| -k))).is_ok(), "{} {} one way only", i, j);
        }
        let (mut expected, mut ties) = oracle(&listed, &simulation_box, radius);
        for search in Search::ALL {
            let (pairs, counts, listed) = searched(&variant, search, &cutoffs, &state, &simulation_box);
            if variant.precision == Precision::Single {
                // Positions are rounded to what cells can tell, and cells depend on the search.
                (expected, ties) = oracle(&listed, &simulation_box, radius);
            } else {
                prop_assert_eq!(&pairs, &reference, "{} {}", variant.name, search.name());
            }
            for (k, id) in state.id.iter().enumerate() {
                prop_assert_eq!(counts[k] as usize, pairs.iter().filter(|p| p.0 == *id).count());
            }
            let clear: Pairs = pairs.into_iter().filter(|p| !ties.contains(p)).collect();
            prop_assert_eq!(&clear, &expected, "{} {}", variant.name, search.name());
        }
    }
}

#[test]
fn a_distance_of_exactly_r_counts_across_a_side_too() {
    // R = 2.8; 5.6 = 2R: every particle sees both neighbors of its own image and nothing else.
    let simulation_box = free_or_periodic([0.0; 3], [2.8, 50.0, 50.0], [true, true, true]);
    let mut state = State::default();
    state.push(1, 1, Vec3::new(0.3, 1.0, 1.0));
    for variant in variants() {
        for search in Search::ALL {
            let (pairs, ..) = searched(&variant, search, &[2.5], &state, &simulation_box);
            assert_eq!(pairs, vec![(1, 1, [-1, 0, 0]), (1, 1, [1, 0, 0])], "{} {}", variant.name, search.name());
        }
    }
}

#[test]
fn memory_follows_particles_not_volume() {
    let bytes = |variant: &Variant, edge: f64| {
        let simulation_box = free_or_periodic([0.0; 3], [edge; 3], [true; 3]);
        let mut state = State::default();
        for k in 0..1000u32 {
            let x = Vec3::new((k % 10) as f64, (k / 10 % 10) as f64, (k / 100) as f64) * 1.2;
            state.push(k + 1, 1, x.add_scalar(20.0));
        }
        let mut backend = variant.backend(1);
        backend.load(arc(program(&[2.5], 0.3, Search::Trimmed)), &state, &simulation_box, 0).unwrap();
        backend.set_up(Needs::default()).unwrap();
        backend.bytes()
    };
    for variant in variants() {
        assert!(bytes(&variant, 1e6) < 2 * bytes(&variant, 60.0), "{}", variant.name);
    }
}

#[test]
fn rows_that_are_wanted_are_those_of_the_whole_list() {
    let (state, simulation_box) = melt(5);
    for variant in variants() {
        let mut backend = variant.backend(1);
        backend.load(arc(program(&[2.5], 0.3, Search::Trimmed)), &state, &simulation_box, 0).unwrap();
        backend.set_up(Needs::default()).unwrap();
        let all = backend.pairs().unwrap();
        // Few rows and many: a GPU hands them over in different ways.
        for every in [101, 3] {
            let wanted = |id: u32| id.is_multiple_of(every);
            let some: Pairs = all.iter().copied().filter(|p| wanted(p.0)).collect();
            assert!(!some.is_empty() && some.len() < all.len());
            assert_eq!(backend.pairs_where(&wanted).unwrap(), some, "{}", variant.name);
        }
    }
}
