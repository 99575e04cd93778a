//! The dynamics went wrong: when, which particle, where, next to whom; and the last good state.

use std::fmt;

use super::precision::Precision;
use super::program::Program;
use crate::system::{SimulationBox, State, Vec3};

/// What went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// A force is infinite or not a number.
    Force,
    /// A position or velocity is infinite or not a number.
    Position,
    /// A particle left through a fixed side, or moved further than the box is long between builds.
    Lost,
}

/// A stop of the dynamics.
#[derive(Clone, Debug)]
pub struct Fault {
    pub kind: FaultKind,
    pub step: i64,
    /// Atom id, the lowest where several are at fault.
    pub id: u32,
    /// Its position, length units.
    pub position: Vec3,
    /// How many particles are at fault.
    pub count: usize,
    /// Where the particle was when it last had neighbors, if it has none now: it was thrown out of the box or has no position.
    pub before: Option<(i64, Vec3)>,
    /// Id of the nearest particle and its distance, now or then.
    pub nearest: Option<(u32, f64)>,
    /// The state at the last list build, if there was one.
    pub last_good: Option<Box<GoodState>>,
}

/// A state from before things went wrong.
#[derive(Clone, Debug)]
pub struct GoodState {
    pub step: i64,
    pub state: State,
    pub simulation_box: SimulationBox,
}

impl Fault {
    /// What helps, for a run in this precision; `None` where nothing is known to. `limited`: as [`Fault::is_limited`] has it.
    pub fn advice(&self, precision: Precision, limited: bool) -> Option<String> {
        let (_, distance) = self.nearest?;
        match self.kind {
            FaultKind::Force if self.is_same_point(distance) => {
                Some("atoms in one point have no direction in which to part: move or remove all but one of them".into())
            }
            FaultKind::Force if precision != Precision::Double => Some(format!(
                "pairs this close have forces beyond the range of f32, in which {} precision computes them: --precision double \
                 holds these{}; those that met on the way met in too large a timestep",
                precision.name(),
                if limited { "" } else { ", and `fix nve/limit` takes overlapping atoms apart" }
            )),
            FaultKind::Force => {
                Some("pairs this close have forces beyond any number: move or remove all but one of these atoms".into())
            }
            // Thrown out by a neighbor, or by itself.
            FaultKind::Position | FaultKind::Lost if self.before.is_some() => Some(
                if limited {
                    "it went farther than any list can follow: a smaller limit (fix nve/limit) holds it back"
                } else {
                    "it went farther than any list can follow: `fix nve/limit` takes overlapping atoms apart, a smaller timestep \
                     follows fast ones"
                }
                .into(),
            ),
            FaultKind::Position | FaultKind::Lost => None,
        }
    }
}

impl Fault {
    /// Whether a shorter timestep may have been all it took: particles met, or one was thrown out.
    pub fn has_come_too_far(&self) -> bool {
        let met =
            self.kind == FaultKind::Force && self.nearest.is_some_and(|(_, distance)| !self.is_same_point(distance));
        met || self.before.is_some()
    }

    /// Whether the particle is one of those whose steps `fix nve/limit` limits already.
    pub fn is_limited(&self, program: &Program) -> bool {
        let Some(good) = &self.last_good else { return false };
        let mask = good.state.id.iter().position(|id| *id == self.id).map_or(0, |place| good.state.mask[place]);
        program.fixes.iter().any(|fix| fix.style == "nve/limit" && fix.group & mask != 0)
    }

    /// Nearer than their coordinates can tell, to a few roundings.
    fn is_same_point(&self, distance: f64) -> bool {
        distance <= 4.0 * f64::EPSILON * self.position.amax()
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            FaultKind::Force => "non-finite force on",
            FaultKind::Position => "non-finite position or velocity of",
            FaultKind::Lost => "lost",
        };
        let point = |p: &Vec3| format!("({}, {}, {})", Short(p.x), Short(p.y), Short(p.z));
        write!(f, "step {}: {what} atom {} at {}", self.step, self.id, point(&self.position))?;
        if let Some((step, x)) = &self.before {
            write!(f, "; at step {step} it was at {}", point(x))?;
        }
        let is = if self.before.is_some() { "was" } else { "is" };
        match self.nearest {
            Some((id, distance)) => write!(f, "; nearest {is} atom {id} at distance {}", Short(distance))?,
            None => write!(f, "; there {is} no other atom with a position")?,
        }
        match self.count {
            0 | 1 => Ok(()),
            n => write!(f, "; {n} atoms are at fault"),
        }
    }
}

impl std::error::Error for Fault {}

/// A number in full, but never with hundreds of zeros.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.abs() {
            0.0 | 1e-5..1e15 => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

/// Nearest other particle to `position` among those with finite positions, by minimum image.
pub fn nearest(state: &State, simulation_box: &SimulationBox, id: u32, position: &Vec3) -> Option<(u32, f64)> {
    let lengths = simulation_box.lengths();
    let distance = |x: &Vec3| {
        let mut d = x - position;
        for axis in 0..3 {
            if simulation_box.periodic(axis) && lengths[axis] > 0.0 {
                d[axis] -= lengths[axis] * (d[axis] / lengths[axis]).round();
            }
        }
        d.norm()
    };
    let others = state.id.iter().zip(&state.x).filter(|(other, _)| **other != id);
    others.map(|(other, x)| (*other, distance(x))).filter(|(_, d)| d.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
}
