//! Atoms that leave through open sides: who is left, in which order of storage, is the same on every backend.

mod common;

use approx::assert_relative_eq;
use common::{Noise, Variant, advanced, cpu_variants, free_or_periodic, program, started, variants};
use octant::engine::{Precision, StorageSort};
use octant::neighbor::Search;
use octant::system::{LostAtoms, SimulationBox, State, Vec3};

/// A gas of two types, in groups, that drifts along x; its atoms have room around them at first.
fn gas(space: &SimulationBox, drift: f64, speed: f64) -> State {
    let (mut state, mut noise) = (State::default(), Noise(71));
    let cells = [15u32, 10, 10];
    for k in 0..cells.iter().product() {
        let cell = [k % cells[0], k / cells[0] % cells[1], k / cells[0] / cells[1]];
        let place = Vec3::from_fn(|a, _| f64::from(cell[a]) + 0.5 + 0.2 * noise.number());
        let spacing = space.lengths().zip_map(&Vec3::from(cells.map(f64::from)), |length, cells| length / cells);
        state.push(k + 1, 1 + k % 2, space.lo + place.component_mul(&spacing));
        let last = state.len() - 1;
        state.v[last] = drift * Vec3::x() + speed * noise.vector();
        state.mask[last] = if k % 3 == 0 { 3 } else { 1 };
    }
    state
}

/// With a build after every so many steps.
fn who_is_left(every: u64, drift: f64, speed: f64) {
    // Open along x and y.
    let space = free_or_periodic([-20.0, 0.0, 3.0], [60.0, 40.0, 50.0], [false, false, true]);
    let state = gas(&space, drift, speed);
    let mut program = program(&[2.5, 2.0], 0.3, Search::Trimmed);
    (program.policy.every, program.policy.check, program.lost) = (every, false, LostAtoms::Ignore);
    program.storage_sort = Some(StorageSort { every: 20, bin: 4.0 });
    let run = |variant: &Variant| -> Vec<(State, usize)> {
        let mut backend = started(variant, 1, &program, &state, &space);
        let mut ahead = || (advanced(variant, &mut *backend, 30), backend.lost());
        (0..4).map(|_| ahead()).collect()
    };
    let reference = cpu_variants().into_iter().find(|variant| variant.precision == Precision::Double).unwrap();
    let expected = run(&reference);
    let (left, lost) = expected.last().unwrap();
    assert!(*lost > 100 && left.len() + lost == state.len());
    for variant in variants() {
        let within = if variant.precision == Precision::Double { 1e-9 } else { 2e-3 };
        for ((now, lost), (then, lost_then)) in run(&variant).iter().zip(&expected) {
            assert_eq!(lost, lost_then, "{}", variant.name);
            assert_eq!((&now.id, &now.kind, &now.mask), (&then.id, &then.kind, &then.mask), "{}", variant.name);
            assert_eq!(now.image, then.image, "{}", variant.name);
            for k in 0..now.len() {
                assert_relative_eq!(now.x[k], then.x[k], epsilon = within, max_relative = 0.0);
                assert_relative_eq!(now.v[k], then.v[k], epsilon = within, max_relative = 0.0);
            }
        }
    }
}

#[test]
fn a_few_at_each_build() {
    who_is_left(5, 0.0, 6.0);
}

#[test]
fn many_at_once() {
    who_is_left(60, 20.0, 0.5);
}
