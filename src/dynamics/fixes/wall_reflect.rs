//! `fix wall/reflect`: a particle that has moved beyond a wall by some distance is put back inside by the same distance, and
//! that component of its velocity changes sign (LAMMPS doc page `fix_wall_reflect`; S. D. Bond and B. J. Leimkuhler 2007,
//! doi:10.1137/060675052, on the order of the method that this makes of velocity Verlet).

use crate::dynamics::{no_variable, Balance, FixArguments, FixScene, FixStyle, Given, Motion, Phase, Step};
use crate::real::Real;
use crate::script::{Args, Complaint};
use crate::system::Side;

/// Up to six walls, at faces in the order of [`FACES`].
pub struct Style;

const FACES: [&str; 6] = ["xlo", "xhi", "ylo", "yhi", "zlo", "zhi"];

impl FixStyle for Style {
    const NAME: &'static str = "wall/reflect";
    const SYNTAX: &'static str = "fix ID GROUP wall/reflect FACE EDGE|COORDINATE ... [units lattice|box]";
    const PHASES: &'static [Phase] = &[Phase::Moved];
    const BALANCE: Balance = Balance::Conserves;

    /// Choice: a bit for each face that has a wall. Parameters: where the walls are, a coordinate for each face.
    fn parse(args: &mut Args<'_>, scene: &FixScene<'_>) -> Result<FixArguments, Complaint> {
        let space = scene.simulation_box;
        let mut given = FixArguments { choice: 0, parameters: vec![0.0; FACES.len()] };
        // Faces whose coordinate is in the units that follow.
        let mut scaled = 0u32;
        let mut lattice_units = true;
        while args.left() > 0 {
            if args.peek() == Some("units") {
                args.text("units")?;
                lattice_units = args.choice("units of the walls", &["lattice", "box"])? == 0;
                continue;
            }
            let word = args.position();
            let face = args.choice("a face or 'units'", &FACES)?;
            let (axis, side) = (face / 2, face % 2);
            if given.choice & 1 << face != 0 {
                return Err(Complaint::new(word, format!("there are two walls for '{}'", FACES[face])));
            }
            if space.periodic(axis) {
                return Err(Complaint::new(word, format!("'{}' is a periodic side", FACES[face])));
            }
            given.choice |= 1 << face;
            given.parameters[face] = if args.peek() == Some("EDGE") {
                let at = args.position();
                args.text("EDGE")?;
                if space.sides[axis][side] == Side::Shrink {
                    let message =
                        format!("EDGE of '{}' is not part of octant: that side is shrink-wrapped", FACES[face]);
                    return Err(Complaint::new(at, message).with_help("give the wall a coordinate"));
                }
                [space.lo, space.hi][side][axis]
            } else {
                no_variable(args, "a wall")?;
                scaled |= 1 << face;
                args.number("EDGE or a coordinate")?
            };
        }
        if given.choice == 0 {
            return Err(Complaint::new(args.position() - 1, format!("expected a face, one of {}", FACES.join(", "))));
        }
        for (face, at) in given.parameters.iter_mut().enumerate() {
            if lattice_units && scaled & 1 << face != 0 {
                *at *= scene.lattice_unit[face / 2];
            }
        }
        Ok(given)
    }

    fn coordinate(parameter: usize) -> Option<usize> {
        Some(parameter / 2)
    }

    #[inline(always)]
    fn moved<R: Real>(motion: &mut Motion<R>, _: &Step<R>, given: &Given<'_, R>) {
        for face in 0..FACES.len() {
            if given.choice & 1 << face == 0 {
                continue;
            }
            let (axis, wall) = (face / 2, given.parameters[face]);
            let (x, v) = (motion.x[axis], motion.v[axis]);
            let beyond = if face % 2 == 0 { x.less(wall) } else { wall.less(x) };
            motion.x[axis] = R::select(beyond, wall + (wall - x), x);
            motion.v[axis] = R::select(beyond, -v, v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_beyond_comes_back_by_as_much() {
        let walls = [-1.0, 1.0, -2.0, 2.0, -3.0, 3.0];
        let bounced = |choice, x: [f64; 3]| {
            let mut motion = Motion { x, v: [1.0, 2.0, 3.0], f: [0.0; 3] };
            Style::moved(&mut motion, &Step { dt: 0.1, half_kick: 0.0 }, &Given::new(choice, &walls));
            (motion.x, motion.v)
        };
        assert_eq!(bounced(63, [-1.25, 2.5, 3.0]), ([-0.75, 1.5, 3.0], [-1.0, -2.0, 3.0]));
        assert_eq!(bounced(63, [1.25, -2.5, -3.5]), ([0.75, -1.5, -2.5], [-1.0, -2.0, -3.0]));
        assert_eq!(bounced(0b100001, [-1.25, 2.5, 3.5]), ([-0.75, 2.5, 2.5], [-1.0, 2.0, -3.0]));
    }
}
