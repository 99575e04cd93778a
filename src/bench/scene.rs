//! What is measured: LAMMPS's `bench/in.lj`, and variants of it that show what a feature costs.

use super::sizes::Cells;
use crate::system::{RanPark, State};

/// Number density, 1 / sigma^3.
const DENSITY: f64 = 0.8442;
/// Temperature of the crystal, epsilon.
const TEMPERATURE: f64 = 1.44;
/// Seed of the velocities.
const SEED: u32 = 87287;
/// Seed of the types.
const TYPE_SEED: u32 = 12345;
/// Timestep, tau.
pub const TIMESTEP: f64 = 0.005;
/// Distance at which pair forces end, sigma.
pub const CUTOFF: f64 = 2.5;
/// What the cutoffs between atoms of the first type, and of the second, have less and more. With as many atoms of either, a list
/// then has about as many pairs as with one cutoff.
const CUTOFF_STEP: f64 = 0.1;

/// A scene of the benchmark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scene {
    /// The Lennard-Jones liquid.
    #[default]
    Lj,
    /// The same with a Morse potential that has the depth, place and curvature of the Lennard-Jones minimum.
    Morse,
    /// The same with two types dealt out at random, and cutoffs that differ by type.
    TwoTypes,
    /// The same with a thermo row, hence energy and virial, at every step.
    Sums,
}

impl Scene {
    pub const ALL: [Scene; 4] = [Scene::Lj, Scene::Morse, Scene::TwoTypes, Scene::Sums];

    pub fn name(self) -> &'static str {
        ["lj", "morse", "two-types", "sums"][self as usize]
    }

    /// The script up to its first run.
    pub fn script(self, cells: Cells, skin: f64) -> String {
        let [x, y, z] = cells.0;
        let types = if self == Scene::TwoTypes { 2 } else { 1 };
        let pair = match self {
            Scene::Lj | Scene::Sums => format!("pair_style lj/cut {CUTOFF}\npair_coeff 1 1 1.0 1.0 {CUTOFF}"),
            Scene::Morse => {
                // U'' of 4 (r^-12 - r^-6) at its minimum r0 is 72 / r0^2, that of the Morse potential 2 alpha^2.
                let r0 = 2.0f64.powf(1.0 / 6.0);
                let alpha = 6.0 / r0;
                format!("pair_style morse {CUTOFF}\npair_coeff 1 1 1.0 {alpha} {r0} {CUTOFF}")
            }
            Scene::TwoTypes => {
                let (low, high) = (CUTOFF - CUTOFF_STEP, CUTOFF + CUTOFF_STEP);
                format!(
                    "pair_style lj/cut {CUTOFF}\npair_coeff 1 1 1.0 1.0 {low}\npair_coeff 1 2 1.0 1.0 {CUTOFF}\n\
                     pair_coeff 2 2 1.0 1.0 {high}"
                )
            }
        };
        format!(
            "units lj\natom_style atomic\nlattice fcc {DENSITY}\nregion box block 0 {x} 0 {y} 0 {z}\n\
             create_box {types} box\ncreate_atoms 1 box\nmass * 1.0\n\
             velocity all create {TEMPERATURE} {SEED} loop geom\n{pair}\nneighbor {skin} bin\n\
             neigh_modify delay 0 every 1 check yes\nfix 1 all nve\ntimestep {TIMESTEP}\n"
        )
    }

    /// What no command does: deals types out.
    pub fn finish(self, state: &mut State) {
        if self == Scene::TwoTypes {
            let mut random = RanPark::new(TYPE_SEED);
            state.kind.iter_mut().for_each(|kind| *kind = if random.uniform() < 0.5 { 1 } else { 2 });
        }
    }

    /// Steps between thermo rows of a timed leg; 0 for none but the first and last.
    pub fn thermo(self) -> u32 {
        u32::from(self == Scene::Sums)
    }

    /// The largest distance at which atoms of the scene feel each other, sigma.
    pub fn largest_cutoff(self) -> f64 {
        if self == Scene::TwoTypes { CUTOFF + CUTOFF_STEP } else { CUTOFF }
    }

    /// Edge of a cell, sigma.
    pub fn cell_edge() -> f64 {
        (4.0 / DENSITY).cbrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{Driven, Prepared, Settings};

    #[test]
    fn every_scene_is_the_same_liquid() {
        for scene in Scene::ALL {
            let (cells, settings) = (Cells::nearest(500), Settings::default());
            let mut prepared = Prepared::new(scene.name(), &scene.script(cells, 0.4), &settings).unwrap();
            scene.finish(prepared.state_mut());
            let program = prepared.program(&settings).unwrap();
            assert_eq!(program.pair.largest_cutoff(), scene.largest_cutoff());
            assert_eq!((program.policy.skin, program.timestep), (0.4, TIMESTEP));
            assert_eq!((program.policy.every, program.policy.delay, program.policy.check), (1, 0, true));
            let edges = prepared.simulation_box().unwrap().lengths();
            assert!((edges.x - 5.0 * Scene::cell_edge()).abs() < 1e-12);
            assert!((prepared.state().len() as f64 / edges.product() - DENSITY).abs() < 1e-12);
            // As many neighbors as with one cutoff, but for the corners of the shells.
            let mean = program.pair.neighbor_cutoffs(0.4).iter().map(|r| r.powi(3)).sum::<f64>()
                / program.pair.pairs.len() as f64;
            assert!((mean / (CUTOFF + 0.4).powi(3) - 1.0).abs() < 0.005, "{}: {mean}", scene.name());
        }
    }

    #[test]
    fn sums_are_asked_for_at_every_step_of_one_scene() {
        for scene in Scene::ALL {
            let settings = Settings::default();
            let prepared = Prepared::new(scene.name(), &scene.script(Cells::nearest(500), 0.4), &settings).unwrap();
            let mut driven = Driven::new(prepared, &settings).unwrap();
            driven.carry_out(&format!("thermo {}\nrun 5", scene.thermo())).unwrap();
            assert_eq!(driven.take_thermo().len(), if scene == Scene::Sums { 6 } else { 2 }, "{}", scene.name());
        }
    }

    #[test]
    fn the_morse_potential_has_the_minimum_of_lennard_jones() {
        let of = |scene: Scene| {
            let script = scene.script(Cells::nearest(500), 0.3);
            Prepared::new("scene", &script, &Settings::default()).unwrap().program(&Settings::default()).unwrap().pair
        };
        let (lj, morse) = (of(Scene::Lj), of(Scene::Morse));
        let r0 = 2.0f64.powf(1.0 / 6.0);
        for (r, tolerance) in [(r0, 1e-12), (r0 + 1e-3, 1e-6), (r0 - 1e-3, 1e-6)] {
            let (a, b) = (lj.evaluate(0, 0, r).unwrap(), morse.evaluate(0, 0, r).unwrap());
            assert!((a.energy - b.energy).abs() < tolerance, "{} {}", a.energy, b.energy);
        }
    }
}
