//! `fix gravity`: the same acceleration for all particles of a group (LAMMPS doc page `fix_gravity`). As there, the force that
//! is printed and dumped holds it; potential energy and pressure do not.

use crate::dynamics::{no_variable, FixArguments, FixScene, FixStyle, Given, Phase, Push};
use crate::real::Real;
use crate::script::{Args, Complaint};
use crate::system::Vec3;

/// f += m g.
pub struct Style;

impl FixStyle for Style {
    const NAME: &'static str = "gravity";
    const SYNTAX: &'static str = "fix ID GROUP gravity MAGNITUDE chute ANGLE | spherical PHI THETA | vector X Y Z";
    const PHASES: &'static [Phase] = &[Phase::Force];

    /// Parameters: acceleration along x, y, z, in force / mass units.
    fn parse(args: &mut Args<'_>, _: &FixScene<'_>) -> Result<FixArguments, Complaint> {
        let number = |args: &mut Args<'_>, what: &str| no_variable(args, what).and_then(|()| args.number(what));
        let magnitude = number(args, "the magnitude of the acceleration")?;
        let word = args.position();
        let direction = match args.choice("a style of direction", &["chute", "spherical", "vector"])? {
            0 => {
                let angle = number(args, "an angle from -z towards +x, in degrees")?.to_radians();
                Vec3::new(angle.sin(), 0.0, -angle.cos())
            }
            1 => {
                let phi = number(args, "an azimuth from +x, in degrees")?.to_radians();
                let theta = number(args, "an angle from +z, in degrees")?.to_radians();
                Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
            }
            _ => {
                let mut component = || number(args, "a component of the direction");
                let direction = Vec3::new(component()?, component()?, component()?);
                let length = direction.norm();
                if !(length > 0.0 && length.is_finite()) {
                    return Err(Complaint::new(word, "expected a direction, got a vector without length"));
                }
                direction / length
            }
        };
        Ok(FixArguments { choice: 0, parameters: (magnitude * direction).iter().copied().collect() })
    }

    #[inline(always)]
    fn force<R: Real>(push: &mut Push<R>, given: &Given<'_, R>) {
        for (f, acceleration) in push.f.iter_mut().zip(given.parameters) {
            *f = push.mass.mul_add(*acceleration, *f);
        }
    }
}
