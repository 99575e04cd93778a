//! `fix nve/euler2`: second-order Euler, x += v dt + a dt^2 / 2, v += a dt, both with the acceleration a = f / m at the old
//! position. The integrator of Morillo et al. 2015 (doi:10.2312/vriphys.20151339, section 6); LAMMPS has none like it.
//!
//! It is there to show what that choice does, not to be used: where velocity Verlet kicks with the mean of the old and the new
//! force, this kicks with the old one alone. For a spring of angular frequency w the eigenvalues of a step have the product
//! 1 + (w dt)^2 / 2, so amplitudes grow by its square root each step however short the step is.

use crate::dynamics::{FixArguments, FixScene, FixStyle, Given, Motion, Phase, Step};
use crate::real::Real;
use crate::script::{Args, Complaint};

/// Drift with half a kick, then the whole kick.
pub struct Style;

impl FixStyle for Style {
    const NAME: &'static str = "nve/euler2";
    const SYNTAX: &'static str = "fix ID GROUP nve/euler2";
    const PHASES: &'static [Phase] = &[Phase::Initial];

    fn parse(_: &mut Args<'_>, _: &FixScene<'_>) -> Result<FixArguments, Complaint> {
        Ok(FixArguments::default())
    }

    #[inline(always)]
    fn initial<R: Real>(motion: &mut Motion<R>, step: &Step<R>, _: &Given<'_, R>) {
        for axis in 0..3 {
            let half = step.half_kick * motion.f[axis];
            motion.x[axis] = motion.x[axis] + step.dt * (motion.v[axis] + half);
            motion.v[axis] = motion.v[axis] + (half + half);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_grows_by_the_rate_of_its_eigenvalues() {
        // Mass 1, stiffness 1: half_kick = dt / 2. The determinant of a step is 1 + (w dt)^2 / 2.
        for dt in [0.01, 0.1, 0.69] {
            let step = Step { dt, half_kick: 0.5 * dt };
            let moved = |x: f64, v: f64| {
                let mut motion = Motion { x: [x; 3], v: [v; 3], f: [-x; 3] };
                Style::initial(&mut motion, &step, &Given::new(0, &[]));
                (motion.x[1], motion.v[1])
            };
            let ((a, c), (b, d)) = (moved(1.0, 0.0), moved(0.0, 1.0));
            assert!((a - (1.0 - 0.5 * dt * dt)).abs() < 1e-15 && (b - dt).abs() < 1e-15);
            assert!((a * d - b * c - (1.0 + 0.5 * dt * dt)).abs() < 1e-15, "{dt}");
        }
    }

    #[test]
    fn a_constant_force_is_followed_exactly() {
        let (dt, half_kick) = (0.25, 0.125 / 2.0); // mass 2
        let mut motion = Motion { x: [0.0, 1.0, 2.0], v: [3.0, 0.0, -1.0], f: [0.0, 0.0, -8.0] };
        for _ in 0..4 {
            Style::initial(&mut motion, &Step { dt, half_kick }, &Given::new(0, &[]));
        }
        // After t = 1 with acceleration -4.
        assert_eq!((motion.x, motion.v), ([3.0, 1.0, -1.0], [3.0, 0.0, -5.0]));
    }
}
