//! Simulated time.

/// A simulated time and the step it belongs to. Timestep and step may be changed between runs, so time is no product of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clock {
    /// Time units.
    pub time: f64,
    pub step: i64,
}

impl Clock {
    /// Time at a step, `timestep` having been in force since the clock's own; time units.
    pub fn at(&self, step: i64, timestep: f64) -> f64 {
        self.time + (step - self.step) as f64 * timestep
    }
}
