//! `fix nve`: velocity Verlet at constant energy (LAMMPS doc page `fix_nve`; Swope et al. 1982, doi:10.1063/1.442716).

use crate::dynamics::{FixStyle, Motion, Step};
use crate::real::Real;
use crate::script::{Args, Complaint};

/// Half kick and drift, force, half kick.
pub struct Style;

impl FixStyle for Style {
    const NAME: &'static str = "nve";
    const SYNTAX: &'static str = "fix ID GROUP nve";

    fn parse(_: &mut Args<'_>) -> Result<Vec<f64>, Complaint> {
        Ok(Vec::new())
    }

    #[inline(always)]
    fn initial<R: Real>(motion: &mut Motion<R>, step: &Step<R>, _: &[R]) {
        for axis in 0..3 {
            motion.v[axis] = motion.v[axis] + step.half_kick * motion.f[axis];
            motion.x[axis] = motion.x[axis] + step.dt * motion.v[axis];
        }
    }

    #[inline(always)]
    fn last<R: Real>(motion: &mut Motion<R>, step: &Step<R>, _: &[R]) {
        for axis in 0..3 {
            motion.v[axis] = motion.v[axis] + step.half_kick * motion.f[axis];
        }
    }
}
