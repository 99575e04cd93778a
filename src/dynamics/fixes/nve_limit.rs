//! `fix nve/limit`: velocity Verlet in which no particle moves farther than some distance in a step (LAMMPS doc page
//! `fix_nve_limit`). For particles that overlap at the start: energy is taken out until they are apart.

use crate::dynamics::{FixArguments, FixScene, FixStyle, Given, Motion, Phase, Step};
use crate::real::Real;
use crate::script::{Args, Complaint};

/// As `nve`; each half kick is followed by a cut of the speed to xmax / dt.
pub struct Style;

/// Components are cut to so many times the largest speed first, which turns a velocity where it matters no more but keeps its
/// square a number in f32.
const HUGE: f64 = (1u64 << 40) as f64;

/// Half a kick, then the speed cut, in LAMMPS's order of operations.
#[inline(always)]
fn kick<R: Real>(motion: &mut Motion<R>, step: &Step<R>, given: &Given<'_, R>) {
    let limit = given.parameters[0] / step.dt;
    let (most, huge) = (limit * limit, limit * R::constant(HUGE));
    let mut squared = R::constant(0.0);
    for axis in 0..3 {
        let v = motion.v[axis] + step.half_kick * motion.f[axis];
        let v = R::select(huge.less(v), huge, v);
        motion.v[axis] = R::select(v.less(-huge), -huge, v);
        squared = squared + motion.v[axis] * motion.v[axis];
    }
    let scale = R::select(most.less(squared), (most / squared).sqrt(), R::constant(1.0));
    for v in &mut motion.v {
        *v = *v * scale;
    }
}

impl FixStyle for Style {
    const NAME: &'static str = "nve/limit";
    const SYNTAX: &'static str = "fix ID GROUP nve/limit XMAX";
    const PHASES: &'static [Phase] = &[Phase::Initial, Phase::Last];

    /// Parameter: the largest distance of a step, length units.
    fn parse(args: &mut Args<'_>, _: &FixScene<'_>) -> Result<FixArguments, Complaint> {
        let most = args.number_where("the largest distance of a step", "above 0", |x| x > 0.0)?;
        Ok(FixArguments { choice: 0, parameters: vec![most] })
    }

    #[inline(always)]
    fn initial<R: Real>(motion: &mut Motion<R>, step: &Step<R>, given: &Given<'_, R>) {
        kick(motion, step, given);
        for axis in 0..3 {
            motion.x[axis] = motion.x[axis] + step.dt * motion.v[axis];
        }
    }

    #[inline(always)]
    fn last<R: Real>(motion: &mut Motion<R>, step: &Step<R>, given: &Given<'_, R>) {
        kick(motion, step, given);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fast_keep_their_direction_and_lose_their_speed() {
        let step = Step { dt: 0.01f32, half_kick: 0.005 };
        let given = Given::new(0, &[0.02]);
        let moved = |v: [f32; 3], f: f32| {
            let mut motion = Motion { x: [0.0; 3], v, f: [f, 0.0, 0.0] };
            Style::initial(&mut motion, &step, &given);
            (motion.x, motion.v)
        };
        // Slower than xmax / dt = 2: nothing is changed.
        assert_eq!(moved([1.0, -1.0, 1.0], 0.0).1, [1.0, -1.0, 1.0]);
        let (x, v) = moved([0.0, -3.0, 4.0], 600.0);
        let speed = (9.0f32 + 9.0 + 16.0).sqrt();
        for (axis, part) in [3.0, -3.0, 4.0].into_iter().enumerate() {
            assert!((v[axis] - 2.0 * part / speed).abs() < 1e-6 && (x[axis] - 0.02 * part / speed).abs() < 1e-8);
        }
        // Squares of such velocities are no f32.
        let (x, v) = moved([0.0, 2.0, 0.0], 1e30);
        assert!((v[0] - 2.0).abs() < 1e-6 && (x[0] - 0.02).abs() < 1e-8 && v[1] > 0.0, "{v:?}");
    }
}
