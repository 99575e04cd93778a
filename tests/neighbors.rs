//! Every search gives the pairs of an all-pairs loop, whatever the box, the sides, the density.

mod common;

use common::{Noise, Variant, arc, free_or_periodic, melt, program, variants};
use octant::engine::{Needs, Precision};
use octant::neighbor::{CellOrder, Search, SearchPlan, Sort};
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
    search: impl Into<SearchPlan>,
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

/// Every search with cells of its usual edge, and some with others, in neighbor cutoffs.
fn plans(octant: f64, standard: f64) -> Vec<SearchPlan> {
    let octants = [Search::Trimmed, Search::Octant, Search::Midplane];
    let wide = octants.into_iter().map(|search| search.with_edge(octant));
    let others = [Search::Midplane.with_edge(2.0), Search::Standard.with_edge(standard)];
    let curve = |search: Search| search.plan().with_order(CellOrder::Curve);
    let curves = [Search::Trimmed, Search::Midplane, Search::Standard].map(curve);
    let special = wide.chain(others).map(|plan| plan.unwrap()).chain(curves);
    Search::ALL.into_iter().map(Search::plan).chain(special).collect()
}

/// The searches with particles sorted by radix.
fn by_radix(plans: Vec<SearchPlan>) -> Vec<SearchPlan> {
    plans.into_iter().map(|plan| plan.with_sort(Sort::Radix)).collect()
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
        octant in prop_oneof![Just(2.52), Just(4.0), 2.0..6.0f64],
        standard in prop::sample::select(vec![0.5, 0.77, 2.0, 2.52, 4.0]),
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
        let plans = plans(octant, standard);
        for search in by_radix(plans.clone()).into_iter().chain(plans) {
            let (pairs, counts, listed) = searched(&variant, search, &cutoffs, &state, &simulation_box);
            if variant.precision == Precision::Single {
                // Positions are rounded to what cells can tell, and cells depend on the search.
                (expected, ties) = oracle(&listed, &simulation_box, radius);
            } else {
                prop_assert_eq!(&pairs, &reference, "{} {}", variant.name, search);
            }
            for (k, id) in state.id.iter().enumerate() {
                prop_assert_eq!(counts[k] as usize, pairs.iter().filter(|p| p.0 == *id).count());
            }
            let clear: Pairs = pairs.into_iter().filter(|p| !ties.contains(p)).collect();
            prop_assert_eq!(&clear, &expected, "{} {}", variant.name, search);
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
        for search in plans(2.52, 0.5) {
            let (pairs, ..) = searched(&variant, search, &[2.5], &state, &simulation_box);
            assert_eq!(pairs, vec![(1, 1, [-1, 0, 0]), (1, 1, [1, 0, 0])], "{} {search}", variant.name);
        }
    }
}

#[test]
fn sorts_and_orders_of_cells_give_the_same_rows() {
    // Several pieces of a radix sort, several digits; a slab, which a Z-order curve's cube is far larger than; mostly empty space.
    let scenes =
        [(34_000, [30.0, 30.0, 30.0], 100.0), (3000, [60.0, 4.0, 5.0], 100.0), (300, [400.0, 300.0, 200.0], 2.0)];
    for (count, edges, most) in scenes {
        let space = free_or_periodic([0.0; 3], edges, [true, false, true]);
        let mut state = points(count, 1.0);
        // In 27 parts of the box, of which particles fill no more than a cube of `most`.
        let part = Vec3::from(edges) / 3.0;
        for x in &mut state.x {
            let corner = (3.0 * *x).map(f64::floor);
            let within = (3.0 * *x - corner).component_mul(&part.map(|edge| edge.min(most)));
            *x = corner.component_mul(&part) + within;
        }
        for variant in variants().into_iter().filter(|variant| variant.precision != Precision::Single) {
            for name in ["trimmed", "octant:2.52", "midplane:4", "standard:0.5"] {
                let plan: SearchPlan = name.parse().unwrap();
                let (expected, ..) = searched(&variant, plan, &[0.8], &state, &space);
                let [rows, curve] = [CellOrder::Rows, CellOrder::Curve].map(|order| plan.with_order(order));
                for search in [vec![rows, curve], by_radix(vec![plan, curve])].concat() {
                    let (pairs, ..) = searched(&variant, search, &[0.8], &state, &space);
                    assert!(pairs == expected && pairs.len() > 10, "{} {search} {count}", variant.name);
                }
            }
        }
    }
}

#[test]
fn rows_of_cells_lie_as_the_paper_has_them() {
    // 10 x 8 x 6 cells of edge R: X fastest, then Y, then Z.
    let (radius, counts) = (1.3, [10.0, 8.0, 6.0]);
    let edges = counts.map(|cells| cells * radius * 1.0001);
    let space = free_or_periodic([0.0; 3], edges, [true; 3]);
    let mut state = points(4000, 1.0);
    state.x.iter_mut().for_each(|x| x.component_mul_assign(&Vec3::from(edges)));
    let cell = |id: u32| {
        let at = state.x[id as usize - 1];
        let [x, y, z] = [0, 1, 2].map(|axis| (at[axis] / edges[axis] * counts[axis]) as u64);
        (z * 8 + y) * 10 + x
    };
    for variant in variants() {
        let mut backend = variant.backend(1);
        let plan = Search::Standard.plan().with_order(CellOrder::Rows);
        backend.load(arc(program(&[1.0], 0.3, plan)), &state, &space, 0).unwrap();
        let _ = backend.set_up(Needs::default());
        let order = backend.order().unwrap();
        let cells: Vec<u64> = order.iter().map(|id| cell(*id)).collect();
        assert!(cells.is_sorted() && order.len() == 4000, "{}", variant.name);
    }
}

#[test]
fn a_search_that_looks_to_some_sides_finds_what_lies_there() {
    let (radius, cells) = (1.3, 5.0);
    let edge = cells * radius * 1.0001;
    let space = free_or_periodic([0.0; 3], [edge; 3], [true; 3]);
    let state = points(600, edge);
    let cell = |id: u32| state.x[id as usize - 1].map(|x| (x / edge * cells).floor() as i32);
    for variant in variants() {
        let (all, ..) = searched(&variant, Search::Standard, &[1.0], &state, &space);
        for looks in [[[false; 2]; 3], [[false, true], [true; 2], [false; 2]], [[true, false], [false; 2], [true; 2]]] {
            let plan = Search::Standard.plan().looking(looks);
            let (pairs, ..) = searched(&variant, plan, &[1.0], &state, &space);
            let looked_into = |(i, j, image): &(u32, u32, [i32; 3])| {
                let (own, other) = (cell(*i), cell(*j));
                (0..3).all(|axis| match other[axis] + image[axis] * cells as i32 - own[axis] {
                    0 => true,
                    -1 => looks[axis][0],
                    1 => looks[axis][1],
                    _ => false,
                })
            };
            let expected: Pairs = all.iter().copied().filter(looked_into).collect();
            assert!(pairs == expected && expected.len() > 100, "{} {looks:?}", variant.name);
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

/// Random points in a cube of `edge`, corner at the origin, all of one type.
fn points(count: u32, edge: f64) -> State {
    let mut noise = Noise(5);
    let mut state = State::default();
    for k in 0..count {
        state.push(k + 1, 1, 0.5 * edge * (Vec3::repeat(1.0) + noise.vector()));
    }
    state
}

#[test]
fn crowded_cells_are_searched_by_every_edge_alike() {
    // Fifty particles a cell and more: groups and units of all sizes, with and without periodic sides.
    let state = points(1500, 10.0);
    for periodic in [true, false] {
        let space = free_or_periodic([0.0; 3], [10.0; 3], [periodic; 3]);
        for variant in variants() {
            let (expected, ..) = searched(&variant, Search::Brute, &[1.0], &state, &space);
            for search in plans(3.3, 0.5).into_iter().chain(plans(2.52, 2.0)).chain(plans(4.0, 4.0)) {
                let (pairs, ..) = searched(&variant, search, &[1.0], &state, &space);
                // Single precision rounds positions to what cells can tell.
                if variant.precision != Precision::Single {
                    assert!(pairs == expected, "{} {search}", variant.name);
                }
            }
        }
    }
}

#[test]
fn searches_test_as_many_distances_as_their_cells_hold() {
    // Far from sides: 64, 27, 125 cubes of edge R and so on, times particles in one.
    let (radius, count) = (1.3, 20_000);
    // Whole cells of any of these edges, with a hair's room for their margin.
    let edge = 20.0 * radius * 1.0001;
    let state = points(count, edge);
    let space = free_or_periodic([0.0; 3], [edge; 3], [true; 3]);
    let each = f64::from(count) / 20f64.powi(3);
    for variant in variants().into_iter().filter(|variant| variant.precision == Precision::Mixed) {
        let tests = |search: SearchPlan| {
            let mut backend = variant.backend(2);
            backend.load(arc(program(&[1.0], 0.3, search)), &state, &space, 0).unwrap();
            let _ = backend.set_up(Needs::default());
            backend.work().distance_tests_per_atom / each
        };
        let with = |search: Search, edge: f64| tests(search.with_edge(edge).unwrap());
        for (search, edge, cubes) in [
            (Search::Octant, 2.0, 64.0),
            (Search::Octant, 4.0, 512.0),
            (Search::Standard, 0.5, 125.0 / 8.0),
            (Search::Standard, 1.0, 27.0),
            (Search::Standard, 2.0, 216.0),
            // On half of each axis the own cell alone: 4 (1/2 1 + 1/2 2) cubed.
            (Search::Midplane, 4.0, 216.0),
        ] {
            let found = with(search, edge);
            // Groups of particles share what any of them looks into: on a GPU, all of an octant that has so few.
            let on_gpu = !variant.name.starts_with("cpu");
            let most = if search == Search::Midplane && on_gpu { with(Search::Octant, edge) } else { 1.05 * cubes };
            assert!(found > 0.95 * cubes && found < most, "{} {search:?} {edge}: {found}", variant.name);
        }
        let less = if variant.name.starts_with("cpu") { 0.8 } else { 1.0 };
        assert!(with(Search::Midplane, 2.52) < less * with(Search::Octant, 2.52), "{}", variant.name);
        assert!(tests(Search::Trimmed.plan()) < 27.0 * 1.05, "{}", variant.name);
    }
}

#[test]
fn a_box_smaller_than_r_shows_every_image() {
    let state = points(20, 0.9);
    for periodic in [[true; 3], [false; 3], [true, false, true]] {
        let space = free_or_periodic([0.0; 3], [1.0, 0.9, 1.1], periodic);
        for variant in variants() {
            for search in plans(2.52, 0.5) {
                let (pairs, _, listed) = searched(&variant, search, &[2.5], &state, &space);
                let (expected, ties) = oracle(&listed, &space, |_, _| 2.8);
                let clear: Pairs = pairs.into_iter().filter(|pair| !ties.contains(pair)).collect();
                assert!(clear == expected, "{} {search}", variant.name);
            }
        }
    }
}

#[test]
fn no_particle_has_no_neighbor_and_one_none() {
    let space = free_or_periodic([0.0; 3], [9.0; 3], [false; 3]);
    for variant in variants() {
        for search in plans(2.52, 0.5) {
            for count in [0, 1] {
                let (pairs, counts, _) = searched(&variant, search, &[2.5], &points(count, 9.0), &space);
                assert_eq!((pairs, counts), (vec![], vec![0; count as usize]), "{} {search}", variant.name);
            }
        }
    }
}

#[test]
fn particles_in_one_point_or_one_cell_are_all_neighbors() {
    let count = 700;
    for (what, spread) in [("one point", 0.0), ("one cell", 0.5)] {
        for periodic in [true, false] {
            let space = free_or_periodic([0.0; 3], [60.0; 3], [periodic; 3]);
            let mut state = points(count, spread);
            state.x.iter_mut().for_each(|x| *x += Vec3::new(31.0, 29.9, 0.0));
            for variant in variants() {
                for search in plans(2.52, 0.5) {
                    let (_, counts, _) = searched(&variant, search, &[2.5], &state, &space);
                    assert!(counts.iter().all(|n| *n == count - 1), "{what}: {} {search}", variant.name);
                }
            }
        }
    }
}

#[test]
fn a_crowd_in_one_cell_of_a_large_scene_is_listed() {
    // More particles side by side than a GPU's short entries can name, in a scene large enough that it begins with such.
    const CROWD: usize = 5000;
    let edge = 45.0;
    let mut state = points(12_000, edge);
    let mut noise = Noise(9);
    state.x[..CROWD].iter_mut().for_each(|x| *x = Vec3::repeat(2.75) + 2.7 * noise.vector());
    let space = free_or_periodic([0.0; 3], [edge; 3], [true; 3]);
    let radius: f64 = 2.8;
    let wanted = |id: u32| id.is_multiple_of(40);
    for variant in variants() {
        let mut backend = variant.backend(1);
        backend.load(arc(program(&[2.5], 0.3, Search::Trimmed)), &state, &space, 0).unwrap();
        // Forces of overlapping particles may overflow; the list stands by then.
        let _ = backend.set_up(Needs::default());
        // Single precision rounds positions.
        let mut listed = State::default();
        backend.fetch(&mut listed).unwrap();
        let mut expected = Pairs::new();
        for (i, id) in listed.id.iter().enumerate().filter(|(_, id)| wanted(**id)) {
            for j in (0..listed.len()).filter(|j| *j != i) {
                let d = listed.x[i] - listed.x[j];
                let image = d.map(|d| (d / edge).round());
                if (d - image * edge).norm_squared() <= radius * radius {
                    expected.push((*id, listed.id[j], [0, 1, 2].map(|a| image[a] as i32)));
                }
            }
        }
        expected.sort_unstable();
        assert!(expected.len() > 100_000);
        assert!(backend.pairs_where(&wanted).unwrap() == expected, "{}", variant.name);
    }
}
