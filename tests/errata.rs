//! What is printed in Morillo et al. 2015 (doi:10.2312/vriphys.20151339) and does not hold as it stands: each rule as the paper
//! has it, a counter-example to it, and what octant does there. `validation/paper-errata.md` tells the same in words.

mod common;

use common::{Noise, arc, free_or_periodic, program, variants};
use octant::engine::{Needs, Precision};
use octant::neighbor::{Grid, Search, SearchPlan};
use octant::system::{SimulationBox, State, Vec3};

/// The influence radius.
const R: f64 = 1.0;

/// Cells that are looked into along one axis, relative to the own one: alpha and beta of section 5.2.
type Rule = fn(within: f64, edge: f64) -> [i64; 2];

/// As printed.
fn printed(within: f64, edge: f64) -> [i64; 2] {
    if within < edge / 2.0 { [0, 1] } else { [-1, 0] }
}

/// The two cases exchanged.
fn exchanged(within: f64, edge: f64) -> [i64; 2] {
    let [alpha, beta] = printed(within, edge);
    [-beta, -alpha]
}

/// The same with figure 3's further cases: on a secant plane the own cell alone, "the intersection of the ones associated to
/// adjacent octants".
fn with_secants(within: f64, edge: f64) -> [i64; 2] {
    if within == edge / 2.0 { [0, 0] } else { exchanged(within, edge) }
}

/// Algorithm 1 on a free cube of whole cells: for each particle the ids of those found, itself among them where it is.
fn algorithm_1(state: &State, edge: f64, rule: Rule) -> Vec<Vec<u32>> {
    let cell = |x: f64| (x / edge).floor() as i64;
    let looks = |x: f64, y: f64| {
        let [low, high] = rule(x - edge * cell(x) as f64, edge);
        (cell(x) + low..=cell(x) + high).contains(&cell(y))
    };
    let all = 0..state.len();
    let found = |a: usize| {
        let near = |b: &usize| {
            (0..3).all(|axis| looks(state.x[a][axis], state.x[*b][axis])) && (state.x[a] - state.x[*b]).norm() <= R
        };
        all.clone().filter(near).map(|b| state.id[b]).collect()
    };
    all.clone().map(found).collect()
}

/// Neighbors by definition, the particle itself left out.
fn by_definition(state: &State) -> Vec<Vec<u32>> {
    let all = 0..state.len();
    let near = |a: usize, b: usize| a != b && (state.x[a] - state.x[b]).norm() <= R;
    all.clone().map(|a| all.clone().filter(|b| near(a, *b)).map(|b| state.id[b]).collect()).collect()
}

/// What octant lists, on every backend in double precision, which must be one and the same.
fn by_octant(state: &State, space: &SimulationBox, search: SearchPlan) -> Vec<Vec<u32>> {
    let mut first = None;
    for variant in variants().into_iter().filter(|variant| variant.precision == Precision::Double) {
        let mut backend = variant.backend(1);
        backend.load(arc(program(&[R], 0.0, search)), state, space, 0).unwrap();
        let _ = backend.set_up(Needs::default());
        let mut found = vec![Vec::new(); state.len()];
        for (i, j, _) in backend.pairs().unwrap() {
            found[i as usize - 1].push(j);
        }
        assert!(first.as_ref().is_none_or(|first| *first == found), "{} {search}", variant.name);
        first = Some(found);
    }
    first.unwrap()
}

fn state_of(points: &[[f64; 3]]) -> State {
    let mut state = State::default();
    for (k, x) in points.iter().enumerate() {
        state.push(k as u32 + 1, 1, Vec3::from(*x));
    }
    state
}

/// Random points in a cube of `cells` cells of an edge.
fn cloud(cells: f64, edge: f64) -> (State, SimulationBox) {
    let mut noise = Noise(77);
    let points: Vec<[f64; 3]> =
        (0..400).map(|_| (0.5 * cells * edge * (Vec3::repeat(1.0) + noise.vector())).into()).collect();
    (state_of(&points), free_or_periodic([0.0; 3], [cells * edge; 3], [false; 3]))
}

#[test]
fn alpha_and_beta_are_exchanged() {
    // A particle in the lower half of its cell, a neighbor just below that cell: printed, the search goes up.
    let edge = 2.0 * R;
    let state = state_of(&[[2.1, 1.0, 1.0], [1.9, 1.0, 1.0]]);
    assert_eq!(algorithm_1(&state, edge, printed), [vec![1], vec![2]]);
    assert_eq!(algorithm_1(&state, edge, exchanged), [vec![1, 2], vec![1, 2]]);
    // It is no matter of one pair.
    let (state, _) = cloud(4.0, edge);
    let lost = |rule| {
        let (found, all) = (algorithm_1(&state, edge, rule), by_definition(&state));
        let missing = |(found, all): (&Vec<u32>, &Vec<u32>)| all.iter().filter(|id| !found.contains(id)).count();
        found.iter().zip(&all).map(missing).sum::<usize>()
    };
    assert!(lost(printed) > 400);
    assert_eq!(lost(exchanged), 0);
}

#[test]
fn algorithm_1_finds_the_particle_itself() {
    let edge = 2.52 * R;
    let (state, space) = cloud(4.0, edge);
    let found = algorithm_1(&state, edge, exchanged);
    let others = by_definition(&state);
    for (k, (found, others)) in found.iter().zip(&others).enumerate() {
        // At distance 0 <= R. Table 1 must have been counted without.
        assert!(found.contains(&(k as u32 + 1)) && found.len() == others.len() + 1);
    }
    for edge in [2.0, 2.52, 4.0] {
        for search in [Search::Octant, Search::Trimmed, Search::Midplane] {
            assert_eq!(by_octant(&state, &space, search.with_edge(edge).unwrap()), others, "{search:?} {edge}");
        }
    }
}

#[test]
fn on_a_secant_plane_a_neighbor_at_distance_r_is_lost() {
    // Edge 2R: from the middle of the cell R reaches exactly to its side, where the next cell begins.
    let edge = 2.0 * R;
    let state = state_of(&[[1.0, 0.5, 0.5], [2.0, 0.5, 0.5]]);
    assert_eq!(algorithm_1(&state, edge, exchanged), [vec![1, 2], vec![1, 2]]);
    // One way only, since the neighbor looks back: not even a pair any more.
    assert_eq!(algorithm_1(&state, edge, with_secants), [vec![1], vec![1, 2]]);
    let space = free_or_periodic([0.0; 3], [8.0; 3], [false; 3]);
    for search in [Search::Octant, Search::Trimmed, Search::Midplane] {
        assert_eq!(by_octant(&state, &space, search.plan()), [[2], [1]], "{search:?}");
        assert_eq!(by_octant(&state, &space, search.with_edge(2.0).unwrap()), [[2], [1]], "{search:?}");
    }
    // For larger cells the rule holds, on the plane and nearer to it than edge / 2 - R: the mid-plane search.
    let edge = 4.0 * R;
    let state = state_of(&[[2.0, 0.5, 0.5], [3.0, 0.5, 0.5], [4.0, 0.5, 0.5], [1.0, 0.5, 0.5]]);
    let found = algorithm_1(&state, edge, with_secants);
    assert_eq!(found[0], [1, 2, 4]);
    let others = by_definition(&state);
    assert_eq!(by_octant(&state, &space, Search::Midplane.with_edge(4.0).unwrap()), others);
}

/// Equation 2: the number of a cell along an axis of `cells`.
fn equation_2(x: f64, cells: i64) -> i64 {
    (x / R).floor() as i64 & (cells - 1)
}

#[test]
fn equation_2_needs_cells_of_edge_r() {
    // With edge 2R and 8 cells: two particles of one cell get different numbers, and two cells far apart the same.
    let (edge, cells) = (2.0 * R, 8);
    assert_eq!((0.5 / edge).floor(), (1.5 / edge).floor());
    assert_ne!(equation_2(0.5, cells), equation_2(1.5, cells));
    assert_ne!((0.5 / edge).floor(), (8.5 / edge).floor());
    assert_eq!(equation_2(0.5, cells), equation_2(8.5, cells));
    // With edge R it is the number of the cell.
    for k in 0..80 {
        let x = 0.1 * f64::from(k) + 0.05;
        assert_eq!(equation_2(x, cells), (x / R).floor() as i64);
    }
}

#[test]
fn equation_2_needs_powers_of_two() {
    // Six cells of edge R: `& 5` leaves out the bit of 2, so that cells share numbers.
    let numbers: Vec<i64> = (0..6).map(|k| equation_2(f64::from(k) + 0.5, 6)).collect();
    assert_eq!(numbers, [0, 1, 0, 1, 4, 5]);
    let powers: Vec<i64> = (0..8).map(|k| equation_2(f64::from(k) + 0.5, 8)).collect();
    assert_eq!(powers, [0, 1, 2, 3, 4, 5, 6, 7]);
    // Here every cell has a number of its own, whatever the counts.
    let space = free_or_periodic([0.0; 3], [6.0, 10.0, 14.0], [true; 3]);
    let grid = Grid::new(Search::Octant.plan(), &space, &space.lo, &space.hi, 0.999 * R);
    assert_eq!(grid.axes.map(|axis| axis.cells), [3, 5, 7]);
    let mut hashes: Vec<u64> = (0..105).map(|k| grid.hash([k % 3, k / 3 % 5, k / 15])).collect();
    hashes.sort_unstable();
    assert!(hashes.into_iter().eq(0..105));
}

#[test]
fn strides_are_those_of_cubic_grids_and_cells_of_edge_1() {
    // Section 5.2: one cell further along axis j is R^delta(j-1) epsilon_j^(j-1) further in the list of hashes. With a Kronecker
    // delta (Dirac's is infinite at 0, and nowhere else anything) that is R, epsilon_y, epsilon_z^2.
    let printed = |radius: f64, cells: [f64; 3]| [radius, cells[1], cells[2].powi(2)];
    // Equation 1 says 1, epsilon_x, epsilon_x epsilon_y.
    let of_grid = |edges: [f64; 3]| {
        let space = free_or_periodic([0.0; 3], edges, [true; 3]);
        let grid = Grid::new(Search::Octant.plan(), &space, &space.lo, &space.hi, 0.999 * R);
        let own = grid.hash([1, 1, 1]);
        let further = [grid.hash([2, 1, 1]), grid.hash([1, 2, 1]), grid.hash([1, 1, 2])];
        (grid.axes.map(|axis| axis.cells as f64), further.map(|hash| (hash - own) as f64))
    };
    let (cells, strides) = of_grid([8.0, 8.0, 8.0]);
    assert_eq!((cells, strides, printed(1.0, cells)), ([4.0; 3], [1.0, 4.0, 16.0], [1.0, 4.0, 16.0]));
    // A length is no number of places: another unit, another cell.
    assert_ne!(printed(0.5, cells), strides);
    let (cells, strides) = of_grid([8.0, 6.0, 10.0]);
    assert_eq!((cells, strides), ([4.0, 3.0, 5.0], [1.0, 4.0, 12.0]));
    assert_eq!(printed(1.0, cells), [1.0, 3.0, 25.0]);
    // The Dirac delta as a factor's exponent: R^infinity for the first axis.
    assert!(2.0f64.powf(f64::INFINITY).is_infinite());
}

#[test]
fn the_upper_octant_is_closed_on_both_sides() {
    // x_min + e/2 <= x <= x_min + e: a particle on the side between two cells is in the upper half of one and the lower half of
    // the other.
    let edge = 2.0 * R;
    let halves = |x: f64, cell: f64| {
        let within = x - cell * edge;
        [(0.0..edge / 2.0).contains(&within), (edge / 2.0..=edge).contains(&within)]
    };
    let memberships = |x: f64| [0.0, 1.0].map(|cell| halves(x, cell)).as_flattened().iter().filter(|is| **is).count();
    assert_eq!([0.0, 0.5, 1.0, 1.9, 2.0, 2.1, 3.0].map(memberships), [1, 1, 1, 1, 2, 1, 1]);
    // Here each is in one: cells begin with their lower side and end before their upper one.
    let space = free_or_periodic([0.0; 3], [8.0; 3], [true; 3]);
    let grid = Grid::new(Search::Octant.plan(), &space, &space.lo, &space.hi, 0.999 * R);
    let place = |x: f64| grid.axes[0].locate(x);
    assert_eq!((place(2.0), place(2.0f64.next_down())), ((1.0, 0.0), (0.0, 7.0)));
    assert_eq!((place(1.0), place(1.0f64.next_down())), ((0.0, 4.0), (0.0, 3.0)));
}
