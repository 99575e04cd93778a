//! The stop of a run: which particle, where, next to whom, and the last good state.

use super::particles::{Lost, Particles};
use crate::engine::fault::{Fault, FaultKind, GoodState, nearest};
use crate::system::{SimulationBox, State};

/// What a fault is told from.
pub struct Scene<'a> {
    pub step: i64,
    /// Particles as they are now.
    pub now: &'a Particles,
    pub now_box: &'a SimulationBox,
    /// Particles right after the last build; empty before the first.
    pub held: &'a Particles,
    pub held_box: &'a SimulationBox,
    pub held_step: i64,
}

impl Scene<'_> {
    /// The stop for particles at `places`.
    pub fn fault(&self, kind: FaultKind, places: &[usize]) -> Fault {
        let worst = places.iter().copied().min_by_key(|k| self.now.id[*k]).unwrap_or(0);
        let mut state = State::default();
        self.now.store(&mut state);
        let (id, position) = (self.now.id[worst], self.now.x[worst]);
        let last_good = self.last_build().map(Box::new);
        let nearest = nearest(&state, self.now_box, id, &position);
        let count = places.len();
        let mut fault = Fault { kind, step: self.step, id, position, count, before: None, nearest, last_good };
        if kind == FaultKind::Position {
            look_back(&mut fault);
        }
        fault
    }

    /// The state right after the last build, if there was one.
    pub fn last_build(&self) -> Option<GoodState> {
        (self.held.len() > 0).then(|| {
            let mut state = State::default();
            self.held.store(&mut state);
            GoodState { step: self.held_step, state, simulation_box: self.held_box.clone() }
        })
    }

    /// The stop for particles that are no longer in the box.
    pub fn lost(&self, lost: &[Lost]) -> Fault {
        let places: Vec<usize> = lost.iter().map(|one| one.place).collect();
        let mut fault = self.fault(FaultKind::Lost, &places);
        if let Some(worst) = lost.iter().find(|one| self.now.id[one.place] == fault.id) {
            fault.position = worst.position;
            if worst.far {
                look_back(&mut fault);
            }
        }
        fault
    }
}

/// A particle far from everything was close to the one that threw it there: names that one.
fn look_back(fault: &mut Fault) {
    let Some(good) = &fault.last_good else { return };
    let Some(k) = good.state.id.iter().position(|id| *id == fault.id) else { return };
    let x = good.state.x[k];
    fault.before = Some((good.step, x));
    fault.nearest = nearest(&good.state, &good.simulation_box, fault.id, &x);
}
