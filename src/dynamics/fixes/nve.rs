//! `fix nve`: velocity Verlet at constant energy (LAMMPS doc page `fix_nve`; Swope et al. 1982, doi:10.1063/1.442716).

use crate::dynamics::{Balance, FixArguments, FixScene, FixStyle, Given, Motion, Phase, Step};
use crate::real::Real;
use crate::script::{Args, Complaint};

/// Half kick and drift, force, half kick.
pub struct Style;

impl FixStyle for Style {
    const NAME: &'static str = "nve";
    const SYNTAX: &'static str = "fix ID GROUP nve";
    const PHASES: &'static [Phase] = &[Phase::Initial, Phase::Last];
    const BALANCE: Balance = Balance::Conserves;

    fn parse(_: &mut Args<'_>, _: &FixScene<'_>) -> Result<FixArguments, Complaint> {
        Ok(FixArguments::default())
    }

    #[inline(always)]
    fn initial<R: Real>(motion: &mut Motion<R>, step: &Step<R>, _: &Given<'_, R>) {
        for axis in 0..3 {
            motion.v[axis] = motion.v[axis] + step.half_kick * motion.f[axis];
            motion.x[axis] = motion.x[axis] + step.dt * motion.v[axis];
        }
    }

    #[inline(always)]
    fn last<R: Real>(motion: &mut Motion<R>, step: &Step<R>, _: &Given<'_, R>) {
        for axis in 0..3 {
            motion.v[axis] = motion.v[axis] + step.half_kick * motion.f[axis];
        }
    }
}
