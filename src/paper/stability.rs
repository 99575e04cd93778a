//! The paper's own step: how fast the energy grows with second-order Euler and with velocity Verlet, against the timestep.
//!
//! Two systems. A pair in a periodic box of edge 1.5R: each sees the other from both sides, which makes an exact harmonic oscillator of
//! the spring while they stay near the middle, so the growth is known beforehand. And the paper's particles with either
//! reading of the force, without gravity, in a periodic box and between reflecting walls: their energy should stay what it is.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::experiment::{Experiment, Row, number};
use super::measure::Lab;
use super::scenes;
use super::table1::TABLE_1;
use crate::Error;
use crate::bench::{Halt, Spread};
use crate::engine::{Backend, Needs, Precision, Program, Stop};
use crate::session::{FirstRun, Settings, first_run};
use crate::system::{Side, SimulationBox};

const INTEGRATORS: [&str; 2] = ["nve/euler2", "nve"];
const FORCES: [&str; 2] = ["spring", "inverse"];
const BOXES: [&str; 2] = ["periodic", "walls"];

/// Sums are compared over many steps: pair arithmetic in f32 would be seen in them.
const PRECISION: Precision = Precision::Double;

/// Steps of the paper that are gone through; shorter steps go through as long a time.
const STEPS: u64 = 100;

/// Steps of the pair at most, and energies that are looked at.
const MOST_STEPS: f64 = 20_000.0;
const SAMPLES: f64 = 1_000.0;

/// The pair's distances from the middle: at the start, and where the other one is almost out of reach on one side, R.
const SMALL: f64 = 1e-4;
const LARGE: f64 = 0.1;

/// The pair, all but its distance; mass, force constant and R as in `inputs/paper/`.
const PAIR: &str = "
units        lj
boundary     p p p
region       box block 0 1.5 0 4 0 4
create_box   1 box
create_atoms 1 single 0.3 2 2
create_atoms 1 single 1.05 2 2
mass         1 3e-4
pair_style   harmonic/cut
pair_coeff   1 1 1800.0 1.0
neighbor     0.0 bin
neigh_modify every 1 delay 0 check no
fix          motion all ${integrator}
timestep     2e-4
";

pub static EXPERIMENT: Experiment = Experiment {
    name: "stability",
    title: "The paper's step: relative growth of the energy per step, d ln E / d n (double precision)",
    shown: &[
        "system",
        "force",
        "box",
        "integrator",
        "part",
        "omega_dt",
        "rate",
        "expected",
        "uncertainty",
        "ratio",
        "lost_percent",
    ],
};

/// What is run, and how.
#[derive(Clone, Copy)]
struct Case {
    system: &'static str,
    force: &'static str,
    within: &'static str,
    integrator: &'static str,
    /// Of the paper's timestep; of the pair, of the angular frequency times it.
    part: f64,
}

/// What one run has shown.
struct Seen {
    particles: usize,
    /// sqrt(k / m) dt, or the pair's angular frequency times dt.
    omega_dt: f64,
    /// Steps until the last look before a particle was lost.
    steps: u64,
    /// d ln E / d n until then; `None` where there is no such look.
    rate: Option<f64>,
    /// What is known of it beforehand, and how far what is measured can be from that.
    expected: Option<(f64, f64)>,
    /// Energy over that at the start: at the last look before a loss, and after a step of the paper.
    ratio: f64,
    first_ratio: f64,
    /// Part of the particles that is lost at the end.
    lost: f64,
}

/// Both systems, with the paper's timestep and with halves of it.
pub fn run(lab: &Lab, found: &mut dyn FnMut(Row)) -> Result<(), Halt> {
    let parts = |first: i32| (first..=lab.halvings as i32).map(|k| 0.5f64.powi(k));
    let mut measure = |case: Case, rounds: usize, see: &dyn Fn(&Case, usize) -> Result<Seen, Halt>| {
        let seen = (0..rounds).map(|round| see(&case, round)).collect::<Result<Vec<_>, _>>()?;
        found(row(&case, &seen, lab));
        Ok::<(), Halt>(())
    };
    // Twice the paper's step, too, where the growth is known beforehand.
    for part in parts(-1) {
        for integrator in INTEGRATORS {
            let case = Case { system: "pair", force: FORCES[0], within: BOXES[0], integrator, part };
            measure(case, 1, &|case, _| pair(case, lab))?;
        }
    }
    for (force, within) in FORCES.into_iter().flat_map(|force| BOXES.map(|within| (force, within))) {
        for part in parts(0) {
            for integrator in INTEGRATORS {
                let case = Case { system: "gas", force, within, integrator, part };
                measure(case, lab.rounds, &|case, round| gas(case, round, lab))?;
            }
        }
    }
    Ok(())
}

/// sqrt(k / m) times the timestep: for F = k (R - r) an angular frequency, for F = k / r the square root of k dt^2 / (m R^2), R
/// being 1.
pub fn group(program: &Program) -> f64 {
    let middle = program.pair.evaluate(0, 0, 0.5).map_or(0.0, |pair| pair.force_over_r * 0.5);
    let k = if program.pair.style == "inverse" { 0.5 * middle } else { 2.0 * middle };
    (k / program.masses[0]).sqrt() * program.timestep
}

fn halt(stop: Stop) -> Halt {
    Error::Fault(stop.to_string()).into()
}

fn engine(lab: &Lab) -> Result<Box<dyn Backend>, Error> {
    Settings { precision: PRECISION, ..lab.settings.clone() }.engine().map(|(backend, _)| backend)
}

/// Kinetic and potential energy.
fn energy(backend: &mut dyn Backend) -> Result<f64, Halt> {
    let sums = backend.sums()?;
    Ok(0.5 * (sums.kinetic[0] + sums.kinetic[1] + sums.kinetic[2]) + sums.potential)
}

const ENERGY: Needs = Needs { energy: true, virial: false, pressure: false, positions: false, forces: false };

fn pair(case: &Case, lab: &Lab) -> Result<Seen, Halt> {
    let variables = vec![("integrator".to_string(), case.integrator.to_string())];
    let settings = Settings { variables, ..lab.settings.clone() };
    let FirstRun { mut program, mut state, simulation_box, .. } = first_run("pair", PAIR, &settings)?;
    // Two springs hold the distance, and both particles move: the angular frequency is 2 sqrt(k / m).
    let omega_dt = case.part * group(&program);
    program.timestep *= 0.5 * case.part;
    let squared = omega_dt * omega_dt;
    // What grows by one factor at every step is x^2 + v^2 - (omega dt / 2) x v for Euler, (1 - (omega dt)^2 / 4) x^2 + v^2 for Verlet
    // (v over omega): the logarithm of the energy stays within `swing` of that.
    let (expected, swing) = match case.integrator == INTEGRATORS[0] {
        true => ((0.5 * squared).ln_1p(), (0.25 * omega_dt).atanh()),
        false => (0.0, -0.5 * (-0.25 * squared).ln_1p()),
    };
    let steps = (2.0 * (LARGE / SMALL).ln() / expected).min(MOST_STEPS);
    let stride = (steps / SAMPLES).max(1.0) as u64;
    let samples = (steps / stride as f64) as u64;
    let program = Arc::new(program);
    let mut backend = engine(lab)?;
    let mut rest = 0.0;
    for away in [0.0, SMALL] {
        state.x[1].x += away;
        backend.load(program.clone(), &state, &simulation_box, 0)?;
        backend.set_up(ENERGY).map_err(halt)?;
        if away == 0.0 {
            rest = energy(&mut *backend)?;
        }
    }
    let mut energies = vec![energy(&mut *backend)? - rest];
    for _ in 0..samples {
        backend.advance(stride, ENERGY, &AtomicBool::new(false)).map_err(halt)?;
        energies.push(energy(&mut *backend)? - rest);
    }
    lab.check_interrupt()?;
    let rate = slope(&energies.iter().map(|e| e.ln()).collect::<Vec<_>>()) / stride as f64;
    // The steepest line through n values that stay so near to zero: alternately below and above, half of them each.
    let n = energies.len() as f64;
    let uncertainty = swing * 3.0 * n / (n * n - 1.0) / stride as f64;
    let ratio = |k: usize| energies[k] / energies[0];
    Ok(Seen {
        particles: state.len(),
        omega_dt,
        steps: samples * stride,
        rate: Some(rate),
        expected: Some((expected, uncertainty)),
        ratio: ratio(energies.len() - 1),
        first_ratio: ratio(1),
        lost: 0.0,
    })
}

/// Slope of the straight line that is nearest to values at 0, 1, 2 and so on.
fn slope(values: &[f64]) -> f64 {
    let middle = 0.5 * (values.len() - 1) as f64;
    let (mut above, mut below) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        above += (k as f64 - middle) * value;
        below += (k as f64 - middle).powi(2);
    }
    above / below
}

/// The paper's particles for as long as a hundred of its steps take.
fn gas(case: &Case, round: usize, lab: &Lab) -> Result<Seen, Halt> {
    let [first, ..] = TABLE_1;
    let variables = [("force", case.force), ("integrator", case.integrator)];
    let start = scenes::start(first.particles, first.edge, round, &variables, &lab.settings)?;
    let FirstRun { mut program, state, mut simulation_box, .. } = start;
    let walls = case.within == BOXES[1];
    program.fixes.retain(|fix| fix.style == case.integrator || (fix.style == "wall/reflect" && walls));
    if !walls {
        simulation_box = SimulationBox::new(simulation_box.lo, simulation_box.hi, [[Side::Periodic; 2]; 3]);
    }
    let omega_dt = case.part * group(&program);
    program.timestep *= case.part;
    let stride = (1.0 / case.part).round() as u64;
    let mut backend = engine(lab)?;
    backend.load(Arc::new(program), &state, &simulation_box, 0)?;
    backend.set_up(ENERGY).map_err(halt)?;
    let begin = energy(&mut *backend)?;
    let (mut steps, mut ratio, mut first_ratio, mut lost) = (0, 1.0, f64::NAN, 0.0);
    for sample in 1..=STEPS {
        match backend.advance(stride, ENERGY, &AtomicBool::new(false)) {
            Ok(_) => {}
            // A force or position that is no number: nothing is left to look at.
            Err(Stop::Fault(_)) => {
                lost = 1.0;
                break;
            }
            Err(stop) => return Err(halt(stop)),
        }
        let now = energy(&mut *backend)? / begin;
        lost = backend.lost() as f64 / state.len() as f64;
        if sample == 1 {
            first_ratio = now;
        }
        if lost == 0.0 {
            (steps, ratio) = (sample * stride, now);
        }
        lab.check_interrupt()?;
    }
    let rate = (steps > 0).then(|| ratio.ln() / steps as f64);
    Ok(Seen { particles: state.len(), omega_dt, steps, rate, expected: None, ratio, first_ratio, lost })
}

fn row(case: &Case, seen: &[Seen], lab: &Lab) -> Row {
    let of = |value: &dyn Fn(&Seen) -> f64| Spread::of(&seen.iter().map(value).collect::<Vec<_>>());
    // Of those runs that lasted long enough; the column beside it tells how many.
    let rates: Vec<f64> = seen.iter().filter_map(|seen| seen.rate).collect();
    let rate = (!rates.is_empty()).then(|| Spread::of(&rates));
    let cell = |value: Option<f64>| value.map_or(String::new(), number);
    let expected = seen[0].expected;
    let lost = of(&|seen| seen.lost).scaled(100.0);
    let mut row: Row = vec![
        ("system", case.system.into()),
        ("force", case.force.into()),
        ("box", case.within.into()),
        ("integrator", case.integrator.into()),
        ("particles", seen[0].particles.to_string()),
        ("part", number(case.part)),
        ("omega_dt", number(seen[0].omega_dt)),
        ("runs", seen.len().to_string()),
        ("runs_with_rate", rates.len().to_string()),
        ("steps", number(of(&|seen| seen.steps as f64).median)),
        ("rate", cell(rate.map(|rate| rate.median))),
        ("rate_least", cell(rate.map(|rate| rate.least))),
        ("rate_most", cell(rate.map(|rate| rate.most))),
        ("expected", cell(expected.map(|(expected, _)| expected))),
        ("uncertainty", cell(expected.map(|(_, uncertainty)| uncertainty))),
        ("ratio", number(of(&|seen| seen.ratio).median)),
        ("first_ratio", number(of(&|seen| seen.first_ratio).median)),
        ("lost_percent", number(lost.median)),
        ("lost_percent_least", number(lost.least)),
        ("lost_percent_most", number(lost.most)),
    ];
    row.extend(lab.cells_in(PRECISION));
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_groups_are_those_of_the_papers_numbers() {
        for force in FORCES {
            let settings = Settings::default();
            let start = scenes::start(500, 5.0, 0, &[("force", force)], &settings).expect("a scene");
            // k = 3600, m = 3e-4, dt = 2e-4.
            assert!((group(&start.program) - (3600.0 / 3e-4f64).sqrt() * 2e-4).abs() < 1e-12, "{force}");
        }
    }

    #[test]
    fn a_straight_line_has_its_slope() {
        assert!((slope(&[1.0, 3.0, 5.0, 7.0]) - 2.0).abs() < 1e-15);
        assert!((slope(&[1.0, -1.0, -1.0, 1.0])).abs() < 1e-15);
    }
}
