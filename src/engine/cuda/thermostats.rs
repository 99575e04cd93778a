//! What thermostats keep, on the host: begun at a set-up, written to the device, and read back where a launch ends.

use super::engine::Engine;
use crate::dynamics::thermostat::{Moment, Thermostat};
use crate::engine::particles::Particles;
use crate::system::temperature::degrees_of_freedom;

impl Engine {
    /// Thermostats begin a run.
    pub(super) fn set_up_thermostats(&mut self, particles: &Particles) {
        let Self { thermostats, program, control, .. } = self;
        for thermostat in thermostats {
            let members = (0..particles.len()).filter(|k| particles.mask[*k] & thermostat.group != 0);
            let kinetic =
                members.clone().map(|k| program.masses[particles.kind[k] as usize] * particles.v[k].norm_squared());
            thermostat.freedom = degrees_of_freedom(members.count());
            let (fix, progress) = (&program.fixes[thermostat.place], program.progress(control.step));
            thermostat.act(fix, Moment::SetUp, kinetic.sum(), program.timestep, progress);
        }
    }

    /// Both sides of what is kept on the device, of which steps take turns.
    pub(super) fn write_baths(&self) -> Result<(), String> {
        let Some(buffer) = self.memory.find("baths") else { return Ok(()) };
        let numbers = |thermostat: &Thermostat| [&[thermostat.freedom], &thermostat.memory[..]].concat();
        let side: Vec<f64> = self.thermostats.iter().flat_map(numbers).collect();
        buffer.write(0, &[&side[..], &side[..]].concat())
    }

    /// What the current step has left on the device.
    pub(super) fn read_baths(&mut self) -> Result<(), String> {
        let Some(buffer) = self.memory.find("baths") else { return Ok(()) };
        let count = self.thermostats.iter().map(|thermostat| 1 + thermostat.memory.len()).sum();
        let side: Vec<f64> = buffer.read((self.control.step & 1) as usize * count, count)?;
        let mut rest = &side[..];
        for thermostat in &mut self.thermostats {
            let (numbers, others) = rest.split_at(1 + thermostat.memory.len());
            thermostat.memory.copy_from_slice(&numbers[1..]);
            rest = others;
        }
        Ok(())
    }

    /// Energy that thermostats have taken, energy units.
    pub(super) fn bath(&self) -> f64 {
        let Self { program, control, .. } = self;
        let energy = |thermostat: &Thermostat| {
            let fix = &program.fixes[thermostat.place];
            thermostat.energy(fix, program.timestep, program.progress(control.step))
        };
        // A sum over nothing would be -0.
        self.thermostats.iter().map(energy).fold(0.0, |all, one| all + one)
    }

    /// What each fix keeps from step to step.
    pub fn memories(&self) -> Vec<Vec<f64>> {
        let mut memories = vec![Vec::new(); self.program.fixes.len()];
        for thermostat in &self.thermostats {
            memories[thermostat.place].clone_from(&thermostat.memory);
        }
        memories
    }
}
