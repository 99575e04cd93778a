//! Thermostats between two passes over the particles: what they are told, and what they make of it.

use std::ops::Range;

use super::engine::Engine;
use super::mode::Mode;
use super::sums::group_kinetic;
use crate::dynamics::thermostat::{Moment, Thermostat};
use crate::system::temperature::degrees_of_freedom;

impl<M: Mode> Engine<M> {
    /// Thermostats begin a run.
    pub(super) fn set_up_thermostats(&mut self) {
        let Self { thermostats, moving, .. } = self;
        for thermostat in thermostats {
            let members = moving.mask[..moving.len()].iter().filter(|mask| *mask & thermostat.group != 0).count();
            thermostat.freedom = degrees_of_freedom(members);
        }
        self.take_turns();
        self.ask_thermostats(0..self.thermostats.len(), Moment::SetUp, self.step);
    }

    /// Finds out whether fixes have to end a step in turn, which depends on who is in which group.
    pub(super) fn take_turns(&mut self) {
        self.in_turn = self.program.thermostat_precedes(&self.moving.mask[..self.moving.len()]);
    }

    /// Asks some of the thermostats.
    pub(super) fn ask_thermostats(&mut self, which: Range<usize>, moment: Moment, step: i64) {
        let Self { thermostats, program, scales, moving, isa, .. } = self;
        for thermostat in &mut thermostats[which] {
            let kinetic = match moment {
                Moment::StartOfStep => 0.0,
                _ => group_kinetic(moving, &program.masses, thermostat.group, *isa),
            };
            let (fix, dt, progress) = (&program.fixes[thermostat.place], program.timestep, program.progress(step));
            let scale = thermostat.act(fix, moment, kinetic, dt, progress);
            scales[thermostat.place][usize::from(moment == Moment::StartOfStep)] = scale;
        }
    }

    /// Energy that thermostats have taken.
    pub(super) fn bath(&self) -> f64 {
        let Self { program, step, .. } = self;
        let energy = |thermostat: &Thermostat| {
            let fix = &program.fixes[thermostat.place];
            thermostat.energy(fix, program.timestep, program.progress(*step))
        };
        // A sum over nothing would be -0.
        self.thermostats.iter().map(energy).fold(0.0, |all, one| all + one)
    }
}
