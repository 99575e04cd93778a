//! Fixes: what moves the particles and acts on them. One file each in `fixes/` with a type `Style: FixStyle`;
//! `build.rs` registers it. The rules are formulas over [`Real`] for one particle, so that every backend runs the same.

use crate::real::Real;
use crate::script::{Args, Complaint};

include!(concat!(env!("OUT_DIR"), "/fixes.rs"));

/// One particle as a rule sees it.
#[derive(Clone, Copy, Debug)]
pub struct Motion<R> {
    /// Position, length units.
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

/// A fix: what it does to one particle before and after the force is computed.
pub trait FixStyle: Send + Sync + 'static {
    /// Name in the `fix` command.
    const NAME: &'static str;
    /// For messages and `octant info`.
    const SYNTAX: &'static str;

    /// Reads the arguments after the style's name into parameters.
    fn parse(args: &mut Args<'_>) -> Result<Vec<f64>, Complaint>;
    /// Before the force: kick and drift.
    fn initial<R: Real>(motion: &mut Motion<R>, step: &Step<R>, parameters: &[R]);
    /// After the force: kick.
    fn last<R: Real>(motion: &mut Motion<R>, step: &Step<R>, parameters: &[R]);
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
#[derive(Clone, Debug, PartialEq)]
pub struct Fix {
    /// The user's name for it.
    pub id: String,
    /// Registered style.
    pub style: &'static str,
    /// Bits of [`crate::system::State::mask`] it acts on.
    pub group: u32,
    pub parameters: Vec<f64>,
}

/// Reads the arguments after the style's name; `None` where there is no such style.
pub fn parse_fix(style: &str, args: &mut Args<'_>) -> Option<Result<(&'static str, Vec<f64>), Complaint>> {
    struct Parse<'a, 'b>(&'a mut Args<'b>);
    impl FixVisitor for Parse<'_, '_> {
        type Output = Result<(&'static str, Vec<f64>), Complaint>;
        fn visit<F: FixStyle>(self) -> Self::Output {
            let parameters = F::parse(self.0)?;
            self.0.done()?;
            Ok((F::NAME, parameters))
        }
    }
    with_fix(style, Parse(args))
}
