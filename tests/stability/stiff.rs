//! Springs at all timesteps up to the limit of stability, and beyond: velocity Verlet's own solution is known, so that positions
//! are compared with it, not with a bound.

use octant::engine::Program;
use octant::system::{SimulationBox, State, Vec3};

use crate::common::{Noise, Variant, free_or_periodic};
use crate::rows::{Case, rounding};
use crate::{advanced, by_definition, each, energy, energy_error, fetched, force_error, program_of, smooth, started};

const SECTION: &str = "stiff";

/// How velocity Verlet moves an oscillator that starts at rest: u_n / u_0 = cos(n theta), cos(theta) = 1 - (omega dt)^2 / 2, which
/// is sin(theta / 2) = omega dt / 2, as theta = omega' dt has it; beyond omega dt = 2, (-1)^n cosh(n phi).
struct Shadow {
    omega_dt: f64,
}

impl Shadow {
    fn cosine(&self) -> f64 {
        1.0 - 0.5 * self.omega_dt.powi(2)
    }

    fn is_stable(&self) -> bool {
        self.omega_dt < 2.0
    }

    fn at(&self, n: u64) -> f64 {
        let (cosine, n) = (self.cosine(), n as f64);
        if self.is_stable() {
            (n * cosine.acos()).cos()
        } else {
            (std::f64::consts::PI * n).cos() * (n * (-cosine).acosh()).cosh()
        }
    }

    /// How much of an error of 1 in each of `n` steps there can be at the end, the worst case; beyond the limit over the growth
    /// of the motion itself.
    fn gain(&self, n: u64) -> f64 {
        n as f64 / (1.0 - self.cosine().powi(2)).abs().sqrt()
    }
}

/// Two particles along x, `apart` at rest, whose distance is `amplitude` more at the start, their middle at rest.
fn pair(apart: f64, amplitude: f64, masses: [f64; 2], edges: [f64; 3]) -> (State, SimulationBox) {
    let mut state = State::default();
    let whole = masses[0] + masses[1];
    state.push(1, 1, Vec3::new(0.25 + apart + amplitude * masses[1] / whole, 2.0, 2.0));
    state.push(2, 2, Vec3::new(0.25 - amplitude * masses[0] / whole, 2.0, 2.0));
    (state, free_or_periodic([-0.25, 0.0, 0.0], edges, [true; 3]))
}

/// What a step of motion errs by, length units: positions of size 1, pair arithmetic as a displacement.
fn step_error(variant: &Variant, omega_dt: f64) -> f64 {
    let (position, force) = rounding(variant.precision);
    // Rounding of the distance and of the force of two springs; fixed point has 2^-30 of a cell of edge 4 or less.
    let pairs = if force > 1e-10 { 4.0 * force + 4.0 * 2f64.powi(-30) } else { 4.0 * force };
    4.0 * position + omega_dt.powi(2) * pairs
}

const ERROR_REASON: &str = "rounding of each step, all of one sign, as the oscillator carries it on";

/// Largest distance from the shadow's motion within some steps, over the bound by rounding, as a check. `other` is what else a
/// relative position may be off by.
fn follow(
    case: Case,
    variant: &Variant,
    program: &Program,
    scene: &(State, SimulationBox),
    shadow: &Shadow,
    n: u64,
    other: f64,
) {
    let mut backend = started(variant, program, &scene.0, &scene.1);
    let at = |state: &State| {
        let place = |k: usize| scene.1.unwrap(&state.x[k], &state.image[k]).x;
        place(0) - place(1)
    };
    let start = fetched(&*backend);
    let rest = at(&scene.0) - amplitude(&scene.0, program, scene);
    let u0 = at(&start) - rest;
    let (mut worst, mut done, mut step) = (0.0f64, 0, 1);
    let error = step_error(variant, shadow.omega_dt);
    while done < n {
        let some = step.min(n - done);
        let now = advanced(variant, &mut *backend, some);
        done += some;
        step += step / 2 + 1;
        let expected = u0 * shadow.at(done);
        let growth = if shadow.is_stable() { 1.0 } else { shadow.at(done).abs() };
        let off = (at(&now) - rest - expected).abs();
        worst = worst.max(off / (error * shadow.gain(done) * growth + other));
        let finite = now.x.iter().all(|x| x.iter().all(|c| c.is_finite()));
        case.holds(variant, "positions are finite", finite);
    }
    let measured = format!("omega dt {:.3}: distance from the shadow's motion over its bound", shadow.omega_dt);
    case.check(variant, &measured, worst, 1.0, ERROR_REASON);
}

/// By how much the pair is farther apart than at rest: half the cell for springs, the well for others.
fn amplitude(state: &State, program: &Program, scene: &(State, SimulationBox)) -> f64 {
    let apart = state.x[0].x - state.x[1].x;
    let rest = match program.pair.style {
        "harmonic/cut" => 0.5 * scene.1.lengths().x,
        _ => Well::of(&program.pair.pairs[0].coefficients).place,
    };
    apart - rest
}

/// A light particle between a heavy one and its periodic image, on springs from both sides: a harmonic oscillator of
/// omega^2 = 4 K (1/m + 1/M) while all stay in reach.
fn springs(omega_dt: f64, stiffness: f64, masses: [f64; 2], amplitude: f64) -> (Program, (State, SimulationBox)) {
    let omega = (4.0 * stiffness * (1.0 / masses[0] + 1.0 / masses[1])).sqrt();
    let program = program_of("harmonic/cut", &[stiffness, 1.5], &masses, 0.3, omega_dt / omega);
    (program, pair(1.0, amplitude, masses, [2.0, 4.0, 4.0]))
}

#[test]
fn the_papers_spring_at_its_own_timestep() {
    let case = Case::new(SECTION, "the spring of Morillo et al. 2015 at its own timestep");
    // K, mass and timestep of inputs/paper.
    let (stiffness, mass, timestep): (f64, f64, f64) = (1800.0, 3e-4, 2e-4);
    let shadow = Shadow { omega_dt: (8.0 * stiffness / mass).sqrt() * timestep };
    let (program, scene) = springs(shadow.omega_dt, stiffness, [mass; 2], 0.05);
    assert!((program.timestep / timestep - 1.0).abs() < 1e-12);
    each(|variant| follow(case, variant, &program, &scene, &shadow, 1000, 0.0));
}

#[test]
fn a_light_particle_between_two_heavy_ones() {
    let case = Case::new(SECTION, "a light particle between two that are 1e6 times heavier");
    for omega_dt in [0.1, 0.3, 0.5, 1.0, 1.5, 1.9, 1.99] {
        let shadow = Shadow { omega_dt };
        let (program, scene) = springs(omega_dt, 50.0, [1.0, 1e6], 0.1);
        each(|variant| follow(case, variant, &program, &scene, &shadow, 1000, 0.0));
    }
    let case = Case::new(SECTION, "the same beyond omega dt = 2: it grows as it must");
    for omega_dt in [2.01, 2.1] {
        let shadow = Shadow { omega_dt };
        let (program, scene) = springs(omega_dt, 50.0, [1.0, 1e6], 1e-3);
        each(|variant| follow(case, variant, &program, &scene, &shadow, 9, 0.0));
    }
}

/// The minimum of a Mie potential, from its formula's derivatives there.
struct Well {
    place: f64,
    /// U'', and U''' and U'''' over it, without their signs.
    stiffness: f64,
    third: f64,
    fourth: f64,
}

impl Well {
    fn of(coefficients: &[f64]) -> Self {
        let [depth, sigma, m, n] = [0, 1, 2, 3].map(|k| coefficients[k]);
        let place = sigma * (m / n).powf(1.0 / (m - n));
        let stiffness = depth * m * n / place.powi(2);
        let fourth = (m * m + m * n + n * n + 6.0 * (m + n) + 11.0) / place.powi(2);
        Self { place, stiffness, third: (m + n + 3.0) / place, fourth }
    }

    /// How much the frequency of an oscillation of this amplitude is off that of a small one, relatively (L. D. Landau and
    /// E. M. Lifshitz, Mechanics, section 28).
    fn shift(&self, amplitude: f64) -> f64 {
        (self.fourth / 16.0 - 5.0 * self.third.powi(2) / 48.0).abs() * amplitude.powi(2)
    }
}

/// epsilon, sigma, exponents, cutoff.
const CORE: [f64; 5] = [1.0, 1.0, 36.0, 6.0, 2.5];

#[test]
fn a_core_of_r_to_the_minus_36() {
    let case = Case::new(SECTION, "a core of r^-36 (mie/cut 36-6), omega at the well's minimum");
    let well = Well::of(&CORE);
    let omega = (2.0 * well.stiffness).sqrt();
    for omega_dt in [0.1, 0.5, 1.0, 1.5, 1.9] {
        let shadow = Shadow { omega_dt };
        let program = program_of("mie/cut", &CORE, &[1.0, 1.0], 0.3, omega_dt / omega);
        let (size, n) = (2e-4, 100);
        let scene = pair(well.place, size, [1.0; 2], [9.0; 3]);
        // The well is not quite harmonic: the middle moves by a quarter of U''' / U'' u^2, with as much again of twice the
        // frequency, and the frequency shifts, twice that as the timestep magnifies it.
        let turned = 2.0 * n as f64 * omega_dt * shadow.gain(1).max(1.0) * well.shift(size);
        let other = well.third * size * size + turned * size;
        each(|variant| follow(case, variant, &program, &scene, &shadow, n, other));
    }
    let case = Case::new(SECTION, "energy in that well, omega dt = 0.1, 10 000 steps");
    let (omega_dt, size) = (0.1, 0.01);
    let program = program_of("mie/cut", &CORE, &[1.0, 1.0], 0.3, omega_dt / omega);
    let scene = pair(well.place, size, [1.0; 2], [9.0; 3]);
    each(|variant| {
        let mut backend = started(variant, &program, &scene.0, &scene.1);
        let start = energy(&backend.sums().unwrap());
        let mut worst = 0.0f64;
        for _ in 0..100 {
            advanced(variant, &mut *backend, 100);
            worst = worst.max((energy(&backend.sums().unwrap()) - start).abs());
        }
        // A harmonic oscillator's energy swings by (omega dt)^2 / 4 of what is above the minimum, 1 for this well of depth -1;
        // twice for what is not harmonic. Rounding as a random walk: of positions of size 4 and of the distance, as the stiffness
        // makes a force of it, times the amplitude; and of the energy itself.
        let above = start + 1.0;
        let (position, force) = rounding(variant.precision);
        let walk = 100.0 * (4.0 * position + force) * well.place * well.stiffness * size;
        let bound = 2.0 * omega_dt.powi(2) / 4.0 * above + walk + 4.0 * force;
        case.check(
            variant,
            "largest change of the energy",
            worst,
            bound,
            "shadow Hamiltonian of the well, and rounding",
        );
    });
}

#[test]
fn very_high_density() {
    let case = Case::new(SECTION, "density 4: a compressed crystal");
    let (cells, timestep): (usize, f64) = (4, 1e-4);
    let program = smooth(timestep);
    let space = free_or_periodic([0.0; 3], [cells as f64; 3], [true; 3]);
    let (mut state, mut perfect, mut noise) = (State::default(), State::default(), Noise(41));
    for k in 0..cells.pow(3) {
        let corner = Vec3::new((k % cells) as f64, (k / cells % cells) as f64, (k / cells / cells) as f64);
        for b in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]] {
            let id = state.len() as u32 + 1;
            perfect.push(id, 1, corner + Vec3::from(b));
            state.push(id, 1, corner + Vec3::from(b) + 0.02 * noise.vector());
            state.v[id as usize - 1] = 3.0 * noise.vector();
        }
    }
    let exact = by_definition(&program.pair, &state, &space);
    let least = by_definition(&program.pair, &perfect, &space).energy;
    let n = state.len() as f64;
    each(|variant| {
        let mut backend = started(variant, &program, &state, &space);
        let now = fetched(&*backend);
        let measured = "force error, worst atom over RMS of pair forces";
        case.check(variant, measured, exact.worst(&now.f), force_error(variant), "rounding of pair arithmetic");
        let start = energy(&backend.sums().unwrap());
        let mut most = 0.0f64;
        for _ in 0..20 {
            advanced(variant, &mut *backend, 50);
            most = most.max((energy(&backend.sums().unwrap()) - start).abs());
        }
        // U'' of the nearest pairs at 0.707; no mode of the crystal is faster than omega^2 = 8 U'' / m.
        let r: f64 = 0.5f64.sqrt();
        let omega2 = 8.0 * 4.0 * (156.0 * r.powi(-14) - 42.0 * r.powi(-8));
        let bound = omega2 * timestep.powi(2) / 4.0 * (start - least) / n + energy_error(variant) * exact.energy / n;
        case.check(
            variant,
            "largest change of the energy, per atom",
            most / n,
            bound,
            "shadow Hamiltonian, and rounding of U",
        );
    });
}
