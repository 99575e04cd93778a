//! `velocity group-ID style args keyword value ...` (LAMMPS doc page `velocity`).

use crate::script::{Args, Complaint, Name};

use super::create_atoms::seed;

/// Distribution of created velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    Uniform,
    Gaussian,
}

/// In which order random numbers go to atoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loop {
    /// In order of id.
    All,
    /// In storage order.
    Local,
    /// Each atom's own stream, seeded by its position.
    Geom,
}

/// What a `velocity` command does.
#[derive(Clone, Debug, PartialEq)]
pub enum VelocityStyle {
    /// Random velocities at a temperature (of at least 0).
    Create { temperature: f64, seed: u32 },
    /// Components set to numbers; `NULL` leaves one alone.
    Set([Option<f64>; 3]),
    /// Scales the velocities to a temperature.
    Scale { temperature: f64 },
    /// Component `velocity_axis` ramps between two values over a range of positions along `position_axis`.
    Ramp { velocity_axis: usize, velocity: [f64; 2], position_axis: usize, position: [f64; 2] },
    /// Takes the center-of-mass velocity away.
    ZeroLinear,
    /// Takes the rotation about the center of mass away.
    ZeroAngular,
}

/// A `velocity` command.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityCommand {
    pub group: Name,
    pub style: VelocityStyle,
    pub distribution: Distribution,
    /// Adds to the velocities instead of replacing them.
    pub sum: bool,
    /// Zeroes the linear momentum of created velocities (the default).
    pub zero_momentum: bool,
    /// Zeroes the angular momentum of created velocities.
    pub zero_rotation: bool,
    pub order: Loop,
    /// `units lattice` (the default) against `units box`, for `set` and `ramp`.
    pub lattice_units: bool,
}

/// Words of the group and of the style.
pub const GROUP_WORD: usize = 1;
pub const STYLE_WORD: usize = 2;

const VELOCITIES: [&str; 3] = ["vx", "vy", "vz"];
const AXES: [&str; 3] = ["x", "y", "z"];

impl VelocityCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let group = args.name("a group ID")?;
        let word = args.position();
        let style = match args.text("a velocity style")? {
            "create" => VelocityStyle::Create { temperature: temperature(args)?, seed: seed(args)? },
            "set" => VelocityStyle::Set([component(args)?, component(args)?, component(args)?]),
            "scale" => VelocityStyle::Scale { temperature: temperature(args)? },
            "ramp" => {
                let velocity_axis = args.choice("a velocity component", &VELOCITIES)?;
                let velocity = [args.number("the low velocity")?, args.number("the high velocity")?];
                let position_axis = args.choice("an axis", &AXES)?;
                let word = args.position();
                let position = [args.number("the low position")?, args.number("the high position")?];
                if position[0] == position[1] {
                    return Err(Complaint::new(word, "expected two different positions to ramp between"));
                }
                VelocityStyle::Ramp { velocity_axis, velocity, position_axis, position }
            }
            "zero" => match args.choice("what to zero", &["linear", "angular"])? {
                0 => VelocityStyle::ZeroLinear,
                _ => VelocityStyle::ZeroAngular,
            },
            other => {
                return Err(Complaint::new(
                    word,
                    format!("expected a velocity style, one of create, set, scale, ramp, zero, got '{other}'"),
                ));
            }
        };
        let mut command = Self {
            group,
            style,
            distribution: Distribution::Uniform,
            sum: false,
            zero_momentum: true,
            zero_rotation: false,
            order: Loop::All,
            lattice_units: true,
        };
        while args.left() > 0 {
            command.keyword(args)?;
        }
        Ok(command)
    }

    fn keyword(&mut self, args: &mut Args<'_>) -> Result<(), Complaint> {
        let word = args.position();
        match args.text("a keyword")? {
            "dist" => {
                self.distribution = match args.choice("a distribution", &["uniform", "gaussian"])? {
                    0 => Distribution::Uniform,
                    _ => Distribution::Gaussian,
                }
            }
            "sum" => self.sum = args.yes_no("sum")?,
            "mom" => self.zero_momentum = args.yes_no("mom")?,
            "rot" => self.zero_rotation = args.yes_no("rot")?,
            "loop" => {
                self.order = match args.choice("the loop", &["all", "local", "geom"])? {
                    0 => Loop::All,
                    1 => Loop::Local,
                    _ => Loop::Geom,
                }
            }
            "units" => self.lattice_units = args.choice("units", &["lattice", "box"])? == 0,
            other @ ("temp" | "bias" | "rigid") => {
                return Err(Complaint::new(word, format!("velocity keyword '{other}' is not part of octant")));
            }
            other => {
                return Err(Complaint::new(
                    word,
                    format!("expected a keyword, one of dist, sum, mom, rot, loop, units, got '{other}'"),
                ));
            }
        }
        Ok(())
    }
}

fn temperature(args: &mut Args<'_>) -> Result<f64, Complaint> {
    args.number_where("a temperature", "of at least 0", |t| t >= 0.0)
}

fn component(args: &mut Args<'_>) -> Result<Option<f64>, Complaint> {
    match args.peek() {
        Some("NULL") => args.text("a velocity").map(|_| None),
        Some(text) if text.starts_with("v_") => Err(Complaint::new(
            args.position(),
            format!("velocities from a variable ('{text}') are not part of octant"),
        )),
        _ => args.number("a velocity component or NULL").map(Some),
    }
}
