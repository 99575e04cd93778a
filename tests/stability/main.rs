//! Scenes that are stiff, of extreme shape, at the end of a number's range, or long: physics that must hold, by number, on every
//! backend and in every precision. Each check is a row of `validation/stability.md` where `make stability` asks for them (`rows`).

#[path = "../common/cli.rs"]
mod cli;
#[path = "../common/mod.rs"]
mod common;

mod collisions;
mod conservation;
mod forces;
mod geometry;
mod overflow;
mod rows;
mod stiff;
mod symmetry;
mod truth;

use common::{ALL, Variant, advanced, fetched, variants};
use octant::engine::{Backend, Precision, Program, Sums};
use octant::neighbor::Search;
use octant::pair::{PairCoefficients, PairTable};
use octant::system::{SimulationBox, State, Vec3};

/// Every backend, instruction set and precision.
fn each(mut check: impl FnMut(&Variant)) {
    variants().iter().for_each(&mut check);
}

/// Particles of as many types as there are masses under `fix nve`; `words` are the coefficients of all pairs, the cutoff last.
fn program_of(style: &str, words: &[f64], masses: &[f64], skin: f64, timestep: f64) -> Program {
    let words: Vec<String> = words.iter().map(f64::to_string).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let mut pair = PairCoefficients::new(style, 1.0, masses.len()).unwrap();
    pair.set((1, masses.len()), (1, masses.len()), &words).unwrap();
    let mut program = common::program(&vec![1.0; masses.len()], skin, Search::Trimmed);
    (program.pair, program.masses, program.timestep) = (pair.complete().unwrap().0, masses.to_vec(), timestep);
    program
}

/// Lennard-Jones particles whose force ends at 2.5 without a step.
fn smooth(timestep: f64) -> Program {
    program_of("lj/smooth/linear", &[1.0, 1.0, 2.5], &[1.0], 0.3, timestep)
}

/// What a force may be off by on any particle, over the RMS of pair forces. In double precision r^-14 makes 14 roundings of that of
/// r^2 (1.1e-16 each), arithmetic adds some 8 more, and the nearest pairs of a liquid have up to 15 times the RMS: 4e-14, of which
/// there may be several to a particle.
fn force_error(variant: &Variant) -> f64 {
    if variant.precision == Precision::Double { 1.5e-13 } else { variant.tolerance.force }
}

/// The same in words, for the table.
const FORCE_ERROR: &str = "some 22 roundings of each pair force, of which the nearest pairs have 15 times the RMS: of f64, of f32 in \
    mixed and single precision, where fixed-point coordinates add a rounding of 1e-8 cells";

/// Relative error of the energy of a scene. In double precision the same 22 roundings of each pair, where attraction and repulsion
/// leave a hundredth of either: 2.4e-13, all of one sign at worst, and as much for sums of up to 1e5 terms.
fn energy_error(variant: &Variant) -> f64 {
    if variant.precision == Precision::Double { 1e-12 } else { variant.tolerance.energy }
}

fn started(variant: &Variant, program: &Program, state: &State, space: &SimulationBox) -> Box<dyn Backend> {
    common::started(variant, 1, program, state, space)
}

/// Potential and kinetic energy.
fn energy(sums: &Sums) -> f64 {
    sums.potential + 0.5 * sums.kinetic[..3].iter().sum::<f64>()
}

fn momentum(program: &Program, state: &State) -> Vec3 {
    state.v.iter().zip(&state.kind).map(|(v, kind)| v * program.masses[*kind as usize - 1]).sum()
}

/// Root of the mean square of vectors.
fn rms(vectors: &[Vec3]) -> f64 {
    (vectors.iter().map(Vec3::norm_squared).sum::<f64>() / vectors.len().max(1) as f64).sqrt()
}

/// Forces, energy, and the size of what forces are sums of: the RMS over particles of the root of the sum of squares of a
/// particle's pair forces, which is the RMS force of a liquid and no zero in a crystal.
struct Exact {
    f: Vec<Vec3>,
    energy: f64,
    size: f64,
}

impl Exact {
    /// Error of the worst atom, over the size.
    fn worst(&self, f: &[Vec3]) -> f64 {
        f.iter().zip(&self.f).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / self.size.max(f64::MIN_POSITIVE)
    }
}

/// By definition: in f64 from all pairs within the cutoff, over all periodic images, a particle's own among them.
fn by_definition(pair: &PairTable, state: &State, space: &SimulationBox) -> Exact {
    let (most, lengths) = (pair.largest_cutoff(), space.lengths());
    let further = [0, 1, 2].map(|axis| match most / lengths[axis] {
        _ if !space.periodic(axis) => 0,
        within if within <= 0.5 => 0,
        within => (within + 0.5).ceil() as i32,
    });
    let (mut f, mut energy, mut squares) = (vec![Vec3::zeros(); state.len()], 0.0, 0.0);
    for (i, total) in f.iter_mut().enumerate() {
        for j in 0..state.len() {
            let mut d = state.x[i] - state.x[j];
            for axis in (0..3).filter(|axis| space.periodic(*axis)) {
                d[axis] -= lengths[axis] * (d[axis] / lengths[axis]).round();
            }
            for image in images(further).filter(|image| i != j || *image != [0; 3]) {
                let d = d + Vec3::from(image.map(f64::from)).component_mul(&lengths);
                if d.norm_squared() < most * most {
                    let kinds = [i, j].map(|k| state.kind[k] as usize - 1);
                    let value = pair.evaluate(kinds[0], kinds[1], d.norm()).unwrap();
                    *total += d * value.force_over_r;
                    energy += 0.5 * value.energy;
                    squares += (d * value.force_over_r).norm_squared();
                }
            }
        }
    }
    Exact { f, energy, size: (squares / state.len().max(1) as f64).sqrt() }
}

fn images(further: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    let along = move |axis: usize| -further[axis]..=further[axis];
    along(2).flat_map(move |z| along(1).flat_map(move |y| along(0).map(move |x| [x, y, z])))
}
