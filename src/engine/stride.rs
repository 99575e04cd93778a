//! How far a particle goes in a step, and the timestep in which it could be followed.

use super::fault::{GoodState, nearest};
use super::program::Program;
use super::stiff_pair::StiffPair;
use crate::dynamics::{Balance, Phase};
use crate::system::{SimulationBox, State};

/// Part of the skin that the fastest particle may cross in a step of the timestep that is proposed: half of what calls for a
/// list build, so that no two steps in a row do and particles may become twice as fast.
const PART_OF_SKIN: f64 = 0.25;

/// Angular frequency of the hardest collision times the timestep that is proposed. Velocity Verlet lets the energy of a spring
/// go up and down by (omega dt)^2 / 4 of it, here 1.6 percent; Lennard-Jones liquids are usually run at 0.3 to 0.5.
pub(super) const FINE: f64 = 0.25;

/// The same, from which on a timestep is called too large: half of what velocity Verlet is stable below (omega dt = 2).
pub(super) const COARSE: f64 = 1.0;

/// Part of a cutoff within which particles are not reckoned to come, whatever their speed.
const CLOSEST: f64 = 0.1;

/// Ratio of two distances at which a potential is looked at, one after the other.
const NEARER: f64 = 0.995;

/// A particle on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride {
    /// Place in the state.
    place: usize,
    /// Atom id.
    pub id: u32,
    /// Length / time units.
    speed: f64,
    /// What it goes in a timestep, length units.
    pub distance: f64,
}

impl Stride {
    /// That of the fastest particle among those that a fix moves; `None` where all stand still, or a speed is no number.
    pub fn fastest(program: &Program, state: &State) -> Option<Self> {
        let movers = program.fixes.iter().filter(|fix| fix.acts(Phase::Initial)).fold(0, |mask, fix| mask | fix.group);
        let moving = (0..state.len()).filter(|k| state.mask[*k] & movers != 0);
        let squared = |k: &usize| state.v[*k].norm_squared();
        let fastest = moving.max_by(|a, b| squared(a).total_cmp(&squared(b)))?;
        Self::of(program, state, fastest).filter(|stride| stride.distance > 0.0)
    }

    /// That of the particle at a place of the state; `None` where its speed is no number.
    pub fn of(program: &Program, state: &State, place: usize) -> Option<Self> {
        let speed = state.v[place].norm();
        if !speed.is_finite() {
            return None;
        }
        Some(Self { place, id: state.id[place], speed, distance: speed * program.timestep })
    }

    /// Largest angular frequency that a head-on collision at its speed has with any type of particle at rest, times the
    /// timestep: where the potential is steepest, that of a spring as stiff.
    pub fn omega_dt(&self, program: &Program, state: &State) -> f64 {
        program.timestep * self.omega(program, state)
    }

    fn omega(&self, program: &Program, state: &State) -> f64 {
        let (own, speed) = (state.kind[self.place] as usize - 1, self.speed);
        let omega = |other| hardest(program, (own, other), speed, f64::INFINITY);
        (0..program.pair.types).map(omega).fold(0.0, f64::max)
    }

    /// Whether it goes farther than half the skin.
    pub fn leaves_skin(&self, program: &Program) -> bool {
        program.policy.skin > 0.0 && self.distance > 0.5 * program.policy.skin
    }

    /// What [`Stride::omega_dt`] is, where that is too much for the timestep. Where fixes limit steps or the method is another
    /// than velocity Verlet, nothing is known.
    pub fn coarse(&self, program: &Program, state: &State) -> Option<f64> {
        let known = program.fixes.iter().all(|fix| fix.balance() != Balance::Open);
        known.then(|| self.omega_dt(program, state)).filter(|omega_dt| *omega_dt > COARSE)
    }

    /// The timestep that would do for it and its nearest neighbor, which may overlap; two digits, rounded down. `None` where it
    /// is no shorter than that of the run.
    pub fn timestep(&self, program: &Program, state: &State, nearest: Option<(u32, f64)>) -> Option<f64> {
        let dt = program.timestep;
        let mut omega = self.omega(program, state);
        let other = nearest.and_then(|(id, distance)| Some((state.id.iter().position(|k| *k == id)?, distance)));
        if let Some((other, distance)) = other {
            let kinds = [self.place, other].map(|k| state.kind[k] as usize - 1);
            omega = omega.max(hardest(program, kinds.into(), self.speed, distance));
        }
        let by_skin = match program.policy.skin {
            skin if skin > 0.0 => PART_OF_SKIN * skin / self.speed,
            _ => f64::INFINITY,
        };
        let by_collision = if omega > 0.0 { FINE / omega } else { f64::INFINITY };
        let wanted = two_digits(by_skin.min(by_collision));
        (wanted < dt && wanted > 0.0).then_some(wanted)
    }

    /// Its nearest neighbor and the distance to it.
    pub fn nearest(&self, state: &State, simulation_box: &SimulationBox) -> Option<(u32, f64)> {
        nearest(state, simulation_box, self.id, &state.x[self.place])
    }
}

/// Largest angular frequency on the way of a particle that flies at `speed` straight at another, `distance` away and at rest:
/// sqrt(U'' / mu) down to where it turns around.
pub(super) fn hardest(program: &Program, (i, j): (usize, usize), speed: f64, distance: f64) -> f64 {
    let (pair, units) = (&program.pair, &program.units);
    let cutoff = pair.pairs[i * pair.types + j].cutoff;
    let value = |r: f64| pair.evaluate(i, j, r).map_or((0.0, 0.0), |v| (v.energy, v.force_over_r * r));
    let mass = program.masses[i] * program.masses[j] / (program.masses[i] + program.masses[j]);
    // A hair below the cutoff the force is still that of the potential, on both sides.
    let start = distance.min(NEARER * cutoff);
    let energy = value(start).0 + 0.5 * units.mvv2e * mass * speed * speed;
    let (mut r, mut steepest) = (start, 0.0f64);
    while r > 0.0 {
        let slope = stiffness(program, (i, j), r);
        if slope.is_finite() {
            steepest = steepest.max(slope);
        }
        r *= NEARER;
        // An energy that is no number is none to get to.
        let gets_there = value(r).0 <= energy;
        if r < CLOSEST * cutoff || !gets_there {
            break;
        }
    }
    (steepest * units.ftm2v / mass).sqrt()
}

/// U'' of a pair of types (from 0) at a distance; no number where the force has none.
pub(super) fn stiffness(program: &Program, (i, j): (usize, usize), r: f64) -> f64 {
    let (h, force) = (1e-4 * r, |r: f64| program.pair.evaluate(i, j, r).map_or(0.0, |v| v.force_over_r * r));
    (force(r - h) - force(r + h)) / (2.0 * h)
}

/// A timestep, shorter than that of the run, in which particles could be followed from a state on: the fastest, the stiffest pair,
/// and the particle with this id.
pub fn shorter_timestep(program: &Program, good: &GoodState, id: Option<u32>) -> Option<f64> {
    let (state, simulation_box) = (&good.state, &good.simulation_box);
    let place = id.and_then(|id| state.id.iter().position(|other| *other == id));
    let strides = [Stride::fastest(program, state), place.and_then(|place| Stride::of(program, state, place))];
    let followed = |stride: Stride| stride.timestep(program, state, stride.nearest(state, simulation_box));
    let stiff = StiffPair::of(program, state, simulation_box).and_then(|pair| pair.timestep(program, state));
    strides.into_iter().flatten().filter_map(followed).chain(stiff).reduce(f64::min)
}

/// Rounded down to two digits.
pub(super) fn two_digits(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return x;
    }
    let exponent = x.log10().floor() as i32 - 1;
    // Through text, so that the number is the one that is printed.
    let digits = (x / 10f64.powi(exponent) * (1.0 + 1e-12)).floor();
    format!("{digits}e{exponent}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_are_rounded_down() {
        for (x, expected) in [(0.00499, 0.0049), (0.005, 0.005), (1.0e-8, 1.0e-8), (123.0, 120.0), (9.99e-7, 9.9e-7)] {
            assert_eq!(two_digits(x), expected);
        }
        assert_eq!(two_digits(f64::INFINITY), f64::INFINITY);
    }
}
