//! How long a neighbor list will be, before it is built.

use std::f64::consts::PI;

use crate::system::SimulationBox;
use crate::system::{State, Vec3};

/// Length and size of a full list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Entries of the full list, twice the pairs.
    pub entries: f64,
    pub bytes: f64,
}

/// What an engine's list takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListBytes {
    /// An entry of the full list.
    pub entry: usize,
    /// A stretch of one particle's entries that are seen in one periodic image.
    pub stretch: usize,
}

/// Expects the particles to be spread evenly over their extent and counts those within `radius`, periodic images included.
/// An estimate: unevenly spread particles have more neighbors.
pub fn estimate(state: &State, simulation_box: &SimulationBox, radius: f64, list: ListBytes) -> Estimate {
    let atoms = state.len() as f64;
    let (low, high) = state.bounds();
    let lengths = simulation_box.lengths();
    let mut images = 1.0;
    let mut open = 0;
    // Part of the particles within reach along each axis; on an axis whose images are seen it may be many times all of them.
    let parts = Vec3::from_fn(|axis, _| {
        let extent = high[axis] - low[axis];
        if simulation_box.periodic(axis) && lengths[axis] - extent < radius {
            open += 1;
            images *= (2.0 * radius / lengths[axis]).max(1.0);
            2.0 * radius / lengths[axis]
        } else if extent > 2.0 * radius {
            open += 1;
            2.0 * radius / extent
        } else {
            1.0
        }
    });
    // A ball fills this much of the cube around it; where the extent cuts the cube, less of it is left out.
    let ball = [1.0, 1.0, PI / 4.0, PI / 6.0][open];
    let each = atoms * parts.product() * ball;
    Estimate {
        entries: atoms * each,
        bytes: atoms * (list.entry as f64 * each + list.stretch as f64 * images.min(each)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::Side;

    const BYTES: ListBytes = ListBytes { entry: 4, stretch: 32 };

    fn crystal(n: usize, edge: f64) -> State {
        let mut state = State::default();
        for k in 0..n * n * n {
            let cell = Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
            state.push(k as u32 + 1, 1, edge * cell);
        }
        state
    }

    fn space(edge: f64, side: Side) -> SimulationBox {
        SimulationBox::new(Vec3::zeros(), Vec3::repeat(edge), [[side; 2]; 3])
    }

    #[test]
    fn an_even_density_is_counted_with_its_images() {
        let state = crystal(10, 1.0);
        for radius in [2.5, 25.0] {
            let each = estimate(&state, &space(10.0, Side::Periodic), radius, BYTES).entries / 1000.0;
            assert!((each / (4.0 / 3.0 * PI * radius.powi(3)) - 1.0).abs() < 1e-12, "{each}");
        }
    }

    #[test]
    fn a_free_cluster_has_no_more_than_all_pairs() {
        let state = crystal(10, 1.0);
        assert_eq!(estimate(&state, &space(10.0, Side::Fixed), 1e9, BYTES).entries, 1e6);
        assert_eq!(estimate(&state, &space(1e6, Side::Periodic), 100.0, BYTES).entries, 1e6);
    }
}
