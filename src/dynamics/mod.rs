//! Fixes: what moves the particles and acts on them. One file each in `fixes/` with a type `Style: FixStyle`;
//! `build.rs` registers it. The rules are formulas over [`Real`] for one particle, so that every backend runs the same.

pub mod noise;
pub mod thermostat;

use crate::real::Real;
use crate::script::{Args, Complaint};
use crate::system::{SimulationBox, Units, Vec3};
use thermostat::{Group, Moment};

include!(concat!(env!("OUT_DIR"), "/fixes.rs"));

/// Numbers that a fix may have, and all fixes of a scene together: backends keep room for them.
pub const MOST_PARAMETERS: usize = 8;
pub const MOST_PARAMETERS_OF_ALL: usize = 32;

/// Where positions are relative to a point and kept in f32, coordinates among a fix's parameters come this factor nearer to that
/// point, which lies in the box: rounding then never leaves a particle beyond a wall.
pub const INWARD: f64 = 1.0 - 1.0 / (1u64 << 23) as f64;

/// When in a step a fix acts. In each phase all fixes act in the order of the script, before the next phase begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Before the force: velocities and positions (LAMMPS: initial_integrate).
    Initial,
    /// On the new positions, before lists and forces (LAMMPS: post_integrate).
    Moved,
    /// On the force, when the pairs have added theirs (LAMMPS: post_force).
    Force,
    /// After the force: velocities (LAMMPS: final_integrate).
    Last,
    /// On velocities, when all have been kicked and the kinetic energy of the fix's group is known (LAMMPS: the end of
    /// final_integrate).
    Measured,
}

impl Phase {
    /// In the order of a step.
    pub const ALL: [Phase; 5] = [Phase::Initial, Phase::Moved, Phase::Force, Phase::Last, Phase::Measured];
}

/// What a fix does to the sum of pair and kinetic energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Balance {
    /// Keeps it, but for the error of the timestep.
    Conserves,
    /// Brings particles to a temperature: the numbers of the parameters that are those at the start and the end of a run.
    Bath([usize; 2]),
    /// Anything else: work is done, energy taken out, or the method itself adds to it.
    Open,
}

/// One particle as a rule sees it.
#[derive(Clone, Copy, Debug)]
pub struct Motion<R> {
    /// Position, length units; maybe relative to a point of the backend's choice.
    pub x: [R; 3],
    /// Velocity, length / time units.
    pub v: [R; 3],
    /// Force, force units.
    pub f: [R; 3],
}

/// Constants of a step for one particle.
#[derive(Clone, Copy, Debug)]
pub struct Step<R> {
    /// Timestep, time units.
    pub dt: R,
    /// dt / 2 / mass, in velocity per force.
    pub half_kick: R,
}

/// One particle as a rule for forces sees it.
#[derive(Clone, Copy, Debug)]
pub struct Push<R> {
    /// Force, force units.
    pub f: [R; 3],
    /// Velocity, half a step before the force but at a set-up; length / time units.
    pub v: [R; 3],
    /// Mass units.
    pub mass: R,
    /// Timestep, time units.
    pub dt: R,
    /// Random numbers of the particle at this step, evenly from -1/2 to 1/2; zeros unless the style has [`FixStyle::NOISE`].
    pub noise: [R; 3],
}

/// What the script said of a fix, as its rules see it: the same for all particles.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a, R> {
    /// [`Fix::choice`].
    pub choice: u32,
    /// [`Fix::parameters`]; coordinates ([`FixStyle::coordinate`]) are relative to the same point as positions.
    pub parameters: &'a [R],
    /// The part of the run that lies behind, from 0 to 1.
    pub progress: R,
    /// What [`FixStyle::thermostat`] last came to; 1 for fixes that are none.
    pub scale: R,
}

impl<'a, R: Real> Given<'a, R> {
    /// At the start of a run.
    pub fn new(choice: u32, parameters: &'a [R]) -> Self {
        Self { choice, parameters, progress: R::constant(0.0), scale: R::constant(1.0) }
    }
}

/// What a fix may ask of the scene when it is defined.
#[derive(Clone, Copy, Debug)]
pub struct FixScene<'a> {
    pub simulation_box: &'a SimulationBox,
    /// Length of a lattice unit along each axis.
    pub lattice_unit: Vec3,
    pub units: &'a Units,
}

/// What a fix's arguments come to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FixArguments {
    /// See [`Fix::choice`].
    pub choice: u32,
    pub parameters: Vec<f64>,
}

/// A fix: its rules, one for each phase in which it acts.
pub trait FixStyle: Send + Sync + 'static {
    /// Name in the `fix` command.
    const NAME: &'static str;
    /// For messages and `octant info`.
    const SYNTAX: &'static str;
    /// The phases it has rules for; those of the others do nothing.
    const PHASES: &'static [Phase];
    /// Which parameter seeds its random numbers (a whole number below 2^32), if it has any.
    const NOISE: Option<usize> = None;
    /// What it does to the energy.
    const BALANCE: Balance = Balance::Open;

    /// Reads the arguments after the style's name; at most [`MOST_PARAMETERS`] numbers come of them.
    fn parse(args: &mut Args<'_>, scene: &FixScene<'_>) -> Result<FixArguments, Complaint>;
    /// The axis along which a parameter is a coordinate.
    fn coordinate(_parameter: usize) -> Option<usize> {
        None
    }

    /// How many numbers a thermostat keeps from step to step; 0 for fixes that are none.
    fn memory_size(_choice: u32) -> usize {
        0
    }
    /// What is to be done for a group as a whole: goes on with the numbers kept, and gives the factor on velocities that its
    /// rules find in [`Given::scale`]: that of the step's end in [`Phase::Measured`], that of its start in [`Phase::Initial`].
    #[inline(always)]
    fn thermostat<R: Real>(_: Moment, _memory: &mut [R], _: &Group<R>, _: &Given<'_, R>) -> R {
        R::constant(1.0)
    }
    /// Energy that particles have given to the bath, energy units.
    #[inline(always)]
    fn bath_energy<R: Real>(_memory: &[R], _: &Group<R>, _: &Given<'_, R>) -> R {
        R::constant(0.0)
    }

    /// [`Phase::Initial`]: kick and drift.
    #[inline(always)]
    fn initial<R: Real>(_motion: &mut Motion<R>, _step: &Step<R>, _given: &Given<'_, R>) {}
    /// [`Phase::Moved`]: positions and velocities; the force belongs to the old position.
    #[inline(always)]
    fn moved<R: Real>(_motion: &mut Motion<R>, _step: &Step<R>, _given: &Given<'_, R>) {}
    /// [`Phase::Force`]: what is added to the force.
    #[inline(always)]
    fn force<R: Real>(_push: &mut Push<R>, _given: &Given<'_, R>) {}
    /// [`Phase::Last`]: kick.
    #[inline(always)]
    fn last<R: Real>(_motion: &mut Motion<R>, _step: &Step<R>, _given: &Given<'_, R>) {}
    /// [`Phase::Measured`]: velocities.
    #[inline(always)]
    fn measured<R: Real>(_motion: &mut Motion<R>, _given: &Given<'_, R>) {}
}

/// Something to be done for one fix style, whose type is chosen by its name.
pub trait FixVisitor {
    type Output;
    fn visit<F: FixStyle>(self) -> Self::Output;
}

/// Calls the visitor with the fix style of that name; `None` where there is none.
pub fn with_fix<V: FixVisitor>(name: &str, visitor: V) -> Option<V::Output> {
    macro_rules! try_fix {
        ($style:ty) => {
            if name == <$style as FixStyle>::NAME {
                return Some(visitor.visit::<$style>());
            }
        };
    }
    for_each!(try_fix);
    None
}

/// Name and syntax of every registered fix.
pub fn fixes() -> Vec<(&'static str, &'static str)> {
    let mut all = Vec::new();
    macro_rules! describe {
        ($style:ty) => {
            all.push((<$style as FixStyle>::NAME, <$style as FixStyle>::SYNTAX))
        };
    }
    for_each!(describe);
    all
}

/// A fix of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fix {
    /// The user's name for it.
    pub id: String,
    /// Registered style.
    pub style: &'static str,
    /// Bits of [`crate::system::State::mask`] it acts on.
    pub group: u32,
    /// Which of the style's rules are there (the faces that have a wall); kernels are compiled for it.
    pub choice: u32,
    pub parameters: Vec<f64>,
    /// What a thermostat has kept from the last run; empty before the first.
    pub memory: Vec<f64>,
}

impl Fix {
    /// Whether it does anything in a phase.
    pub fn acts(&self, phase: Phase) -> bool {
        struct Phases;
        impl FixVisitor for Phases {
            type Output = &'static [Phase];
            fn visit<F: FixStyle>(self) -> Self::Output {
                F::PHASES
            }
        }
        with_fix(self.style, Phases).is_some_and(|phases| phases.contains(&phase))
    }

    /// Whether it wants random numbers.
    pub fn has_noise(&self) -> bool {
        struct Noise;
        impl FixVisitor for Noise {
            type Output = bool;
            fn visit<F: FixStyle>(self) -> bool {
                F::NOISE.is_some()
            }
        }
        with_fix(self.style, Noise).unwrap_or(false)
    }

    /// What it does to the energy of the scene.
    pub fn balance(&self) -> Balance {
        struct Of;
        impl FixVisitor for Of {
            type Output = Balance;
            fn visit<F: FixStyle>(self) -> Balance {
                F::BALANCE
            }
        }
        with_fix(self.style, Of).unwrap_or(Balance::Open)
    }

    /// The axis along which a parameter is a coordinate.
    pub fn coordinate(&self, parameter: usize) -> Option<usize> {
        struct Coordinate(usize);
        impl FixVisitor for Coordinate {
            type Output = Option<usize>;
            fn visit<F: FixStyle>(self) -> Self::Output {
                F::coordinate(self.0)
            }
        }
        with_fix(self.style, Coordinate(parameter)).flatten()
    }
}

/// Reads the arguments after the style's name; `None` where there is no such style.
pub fn parse_fix(
    style: &str,
    args: &mut Args<'_>,
    scene: &FixScene<'_>,
) -> Option<Result<(&'static str, FixArguments), Complaint>> {
    struct Parse<'a, 'b>(&'a mut Args<'b>, &'a FixScene<'a>);
    impl FixVisitor for Parse<'_, '_> {
        type Output = Result<(&'static str, FixArguments), Complaint>;
        fn visit<F: FixStyle>(self) -> Self::Output {
            let arguments = F::parse(self.0, self.1)?;
            self.0.done()?;
            Ok((F::NAME, arguments))
        }
    }
    with_fix(style, Parse(args, scene))
}

/// Refuses `v_NAME` where LAMMPS would take a variable that changes from step to step.
fn no_variable(args: &Args<'_>, what: &str) -> Result<(), Complaint> {
    match args.peek() {
        Some(text) if text.starts_with("v_") => {
            let message = format!("a variable for {what} is not part of octant, got '{text}'");
            Err(Complaint::new(args.position(), message).with_help("${NAME} or $(v_NAME) gives its value now"))
        }
        _ => Ok(()),
    }
}

/// Temperatures at the start and at the end of a run, for thermostats.
fn temperatures(args: &mut Args<'_>) -> Result<(f64, f64), Complaint> {
    let mut next = |what: &str| {
        no_variable(args, what)?;
        args.number_where(what, "of at least 0", |t| t >= 0.0)
    };
    Ok((next("the temperature at the start")?, next("the temperature at the end")?))
}

/// The temperature that a thermostat aims at when part of the run is over.
#[inline(always)]
fn target_temperature<R: Real>(start: R, stop: R, progress: R) -> R {
    start + progress * (stop - start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::{Expr, Recording};

    /// Runs every rule of a style on numbers that record; whether each phase changes anything.
    struct Changes(u32);
    impl FixVisitor for Changes {
        type Output = (&'static [Phase], Vec<bool>);
        fn visit<F: FixStyle>(self) -> Self::Output {
            let changes = |phase: Phase| {
                let tape = Recording::start();
                let three = |name: &str| std::array::from_fn(|a| tape.input(format!("{name}{a}")));
                let before = Motion { x: three("x"), v: three("v"), f: three("f") };
                let step = Step { dt: tape.input("dt"), half_kick: tape.input("half_kick") };
                let parameters: Vec<Expr> = (0..MOST_PARAMETERS).map(|k| tape.input(format!("p{k}"))).collect();
                let (progress, scale) = (tape.input("progress"), tape.input("scale"));
                let given = Given { choice: self.0, parameters: &parameters, progress, scale };
                let mut after = before;
                let (mass, dt) = (tape.input("mass"), tape.input("dt"));
                let mut push = Push { f: before.f, v: before.v, mass, dt, noise: three("noise") };
                match phase {
                    Phase::Initial => F::initial(&mut after, &step, &given),
                    Phase::Moved => F::moved(&mut after, &step, &given),
                    Phase::Force => {
                        F::force(&mut push, &given);
                        after.f = push.f;
                    }
                    Phase::Last => F::last(&mut after, &step, &given),
                    Phase::Measured => F::measured(&mut after, &given),
                }
                (before.x, before.v, before.f) != (after.x, after.v, after.f)
            };
            (F::PHASES, Phase::ALL.map(changes).to_vec())
        }
    }

    #[test]
    fn fixes_act_in_the_phases_they_name_and_in_no_other() {
        for (name, syntax) in fixes() {
            assert!(syntax.starts_with(&format!("fix ID GROUP {name}")), "{syntax}");
            let (phases, changes) = with_fix(name, Changes(u32::MAX)).unwrap();
            for (phase, changes) in Phase::ALL.into_iter().zip(changes) {
                assert_eq!(phases.contains(&phase), changes, "{name} {phase:?}");
            }
        }
    }

    #[test]
    fn what_is_not_chosen_is_not_worked_out() {
        let (_, changes) = with_fix("wall/reflect", Changes(0)).unwrap();
        assert!(changes.iter().all(|changes| !changes));
    }
}
