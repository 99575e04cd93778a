//! Time: `timestep`, `reset_timestep`.

use crate::script::statement::{Args, Complaint};

/// `timestep DT` (doc page `timestep`).
#[derive(Clone, Debug, PartialEq)]
pub struct TimestepCommand {
    /// Time units.
    pub timestep: f64,
}

impl TimestepCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        Ok(Self { timestep: args.number("the length of a timestep")? })
    }
}

/// `reset_timestep N [time T]` (doc page `reset_timestep`).
#[derive(Clone, Debug, PartialEq)]
pub struct ResetTimestepCommand {
    pub step: i64,
    /// Simulated time at that step, time units.
    pub time: Option<f64>,
}

impl ResetTimestepCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let step = args.integer("a step", 0)?;
        let time = if args.left() > 0 {
            args.choice("a keyword", &["time"])?;
            Some(args.number("the simulated time")?)
        } else {
            None
        };
        Ok(Self { step, time })
    }
}
