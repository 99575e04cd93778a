//! `fix langevin`: drag and random forces that bring particles to a temperature (LAMMPS doc page `fix_langevin`; T. Schneider
//! and E. Stoll 1978, doi:10.1103/PhysRevB.17.1302). It moves nothing: `fix nve` does. As in LAMMPS random forces are evenly
//! distributed with the variance of the Gaussian ones (B. Dunweg and W. Paul 1991, doi:10.1142/S0129183191001037), and
//! velocities in the drag are those half a step before the force; the random numbers are others.

use crate::dynamics::{
    no_variable, target_temperature, temperatures, Balance, FixArguments, FixScene, FixStyle, Given, Phase, Push,
};
use crate::real::Real;
use crate::script::{Args, Complaint};

/// f += -m v / damp + sqrt(24 k T m / (damp dt)) u, u evenly from -1/2 to 1/2 along each axis.
pub struct Style;

/// [`Given::choice`] where the temperature changes in a run.
const RAMP: u32 = 1;

impl FixStyle for Style {
    const NAME: &'static str = "langevin";
    const SYNTAX: &'static str = "fix ID GROUP langevin TSTART TSTOP DAMP SEED";
    const PHASES: &'static [Phase] = &[Phase::Force];
    const NOISE: Option<usize> = Some(4);
    const BALANCE: Balance = Balance::Bath([0, 1]);

    /// Parameters: temperatures at the start and the end of a run; drag over mass and velocity, force units; random force at
    /// temperature, mass and timestep 1; seed.
    fn parse(args: &mut Args<'_>, scene: &FixScene<'_>) -> Result<FixArguments, Complaint> {
        let (start, stop) = temperatures(args)?;
        no_variable(args, "the damping time")?;
        let damp = args.number_where("a damping time", "above 0", |t| t > 0.0)?;
        let word = args.position();
        let seed = args.integer("a seed", 1)?;
        if seed > i64::from(i32::MAX) {
            return Err(Complaint::new(word, format!("expected a seed of at most {}, got '{seed}'", i32::MAX)));
        }
        while args.left() > 0 {
            let word = args.position();
            let name = args.text("a keyword")?;
            match name {
                // What happens without them.
                "zero" | "tally" | "gjf" if args.peek() == Some("no") => drop(args.yes_no("no")?),
                "zero" | "tally" | "gjf" | "scale" | "omega" | "angmom" => {
                    let complaint = Complaint::new(word, format!("fix langevin {name} is not part of octant"));
                    return Err(match name {
                        "scale" => complaint.with_help("a fix for each type's group has a damping time of its own"),
                        "zero" => complaint.with_help("'velocity all zero linear' between runs takes drift out"),
                        _ => complaint,
                    });
                }
                other => return Err(Complaint::new(word, format!("expected the end of the line, got '{other}'"))),
            }
        }
        let units = scene.units;
        let random = (24.0 * units.boltzmann / damp / units.mvv2e).sqrt() / units.ftm2v;
        let choice = if start == stop { 0 } else { RAMP };
        Ok(FixArguments { choice, parameters: vec![start, stop, 1.0 / damp / units.ftm2v, random, seed as f64] })
    }

    #[inline(always)]
    fn force<R: Real>(push: &mut Push<R>, given: &Given<'_, R>) {
        let [start, stop, drag, random] = [0, 1, 2, 3].map(|k| given.parameters[k]);
        let target = if given.choice & RAMP == 0 { start } else { target_temperature(start, stop, given.progress) };
        let drag = push.mass * drag;
        let random = random * (push.mass / push.dt).sqrt() * target.sqrt();
        for axis in 0..3 {
            push.f[axis] = push.f[axis] + (random * push.noise[axis] - drag * push.v[axis]);
        }
    }
}
