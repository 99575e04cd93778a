//! `velocity` (LAMMPS doc page `velocity`): random numbers, sums and scalings are LAMMPS's on one processor, bit for bit.

use super::group::Groups;
use super::group_motion::{Members, angular_velocity};
use super::lattice::Lattice;
use super::mass::all_masses;
use crate::script::Complaint;
use crate::script::command::velocity::{Distribution, GROUP_WORD, Loop, STYLE_WORD, VelocityCommand, VelocityStyle};
use crate::system::temperature::{degrees_of_freedom, temperature};
use crate::system::{RanPark, SimulationBox, State, Units, Vec3};

/// Numbers of a `loop local` stream thrown away before velocities are drawn.
const WARMUP: usize = 100;

/// What velocities depend on.
#[derive(Clone, Copy, Debug)]
pub struct VelocityContext<'a> {
    pub groups: &'a Groups,
    /// Indexed by type - 1.
    pub masses: &'a [Option<f64>],
    pub lattice: Option<&'a Lattice>,
    pub simulation_box: &'a SimulationBox,
    pub units: &'a Units,
}

/// Carries out a `velocity` command. Errors: no atoms, an undefined group, masses not set, scaling of atoms at rest,
/// `loop all` with gaps between the ids, momentum of an empty group.
pub fn velocity(command: &VelocityCommand, context: &VelocityContext<'_>, state: &mut State) -> Result<(), Complaint> {
    if state.is_empty() {
        return Err(Complaint::new(0, "there are no atoms yet"));
    }
    let mask = context.groups.find(&command.group)?;
    let masses = all_masses(context.masses).map_err(|message| Complaint::new(0, message))?;
    let target = Target { mask, masses: &masses, simulation_box: context.simulation_box, units: context.units };
    let unit = match context.lattice {
        Some(lattice) if command.lattice_units => lattice.spacing(),
        _ => Vec3::repeat(1.0),
    };
    match &command.style {
        VelocityStyle::Create { temperature, seed } => create(command, *temperature, *seed, &target, state),
        VelocityStyle::Scale { temperature } => target.rescale(*temperature, state),
        VelocityStyle::ZeroLinear => target.zero_momentum(state),
        VelocityStyle::ZeroAngular => target.zero_rotation(state),
        VelocityStyle::Set(values) => {
            for axis in 0..3 {
                if let Some(value) = values[axis].map(|v| v * unit[axis]) {
                    target.each(state, |v, _| v[axis] = if command.sum { v[axis] + value } else { value });
                }
            }
            Ok(())
        }
        VelocityStyle::Ramp { velocity_axis, velocity, position_axis, position } => {
            let [v_lo, v_hi] = velocity.map(|v| v * unit[*velocity_axis]);
            let [lo, hi] = position.map(|x| x * unit[*position_axis]);
            target.each(state, |v, x| {
                let fraction = ((x[*position_axis] - lo) / (hi - lo)).clamp(0.0, 1.0);
                let value = v_lo + fraction * (v_hi - v_lo);
                v[*velocity_axis] = if command.sum { v[*velocity_axis] + value } else { value };
            });
            Ok(())
        }
    }
}

fn create(
    command: &VelocityCommand,
    wanted: f64,
    seed: u32,
    target: &Target<'_>,
    state: &mut State,
) -> Result<(), Complaint> {
    let before = command.sum.then(|| state.v.clone());
    draw(command, seed, target, state)?;
    if command.zero_momentum {
        target.zero_momentum(state)?;
    }
    if command.zero_rotation {
        target.zero_rotation(state)?;
    }
    target.rescale(wanted, state)?;
    if let Some(before) = before {
        for ((v, old), mask) in state.v.iter_mut().zip(before).zip(&state.mask) {
            if mask & target.mask != 0 {
                *v += old;
            }
        }
    }
    Ok(())
}

/// Draws velocities of the right distribution, not yet of the right temperature.
fn draw(command: &VelocityCommand, seed: u32, target: &Target<'_>, state: &mut State) -> Result<(), Complaint> {
    let mut random = RanPark::new(seed);
    let sample = |random: &mut RanPark| match command.distribution {
        Distribution::Uniform => Vec3::new(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5),
        Distribution::Gaussian => Vec3::new(random.gaussian(), random.gaussian(), random.gaussian()),
    };
    let factors: Vec<f64> = target.masses.iter().map(|m| 1.0 / m.sqrt()).collect();
    let factor = |kind: u32| factors[kind as usize - 1];
    match command.order {
        Loop::All => {
            let order = state.order_by_id();
            if order.iter().enumerate().any(|(k, &index)| state.id[index] as usize != k + 1) {
                return Err(Complaint::new(
                    STYLE_WORD,
                    format!("loop all needs atom ids from 1 to {} without gaps", state.len()),
                )
                .with_help("`loop geom` works with any ids"));
            }
            // Numbers are drawn for atoms outside the group too.
            for k in order {
                let v = sample(&mut random);
                if state.mask[k] & target.mask != 0 {
                    state.v[k] = v * factor(state.kind[k]);
                }
            }
        }
        Loop::Local | Loop::Geom => {
            let geometric = command.order == Loop::Geom;
            if !geometric {
                random.skip(WARMUP);
            }
            for k in 0..state.len() {
                if state.mask[k] & target.mask != 0 {
                    if geometric {
                        random.reset_at(seed, &state.x[k]);
                    }
                    state.v[k] = sample(&mut random) * factor(state.kind[k]);
                }
            }
        }
    }
    Ok(())
}

/// The atoms whose velocities change.
struct Target<'a> {
    mask: u32,
    masses: &'a [f64],
    simulation_box: &'a SimulationBox,
    units: &'a Units,
}

impl Target<'_> {
    fn members<'s>(&'s self, state: &'s State) -> Members<'s> {
        Members { state, masses: self.masses, mask: self.mask, simulation_box: self.simulation_box }
    }

    /// Changes velocities, given positions.
    fn each(&self, state: &mut State, change: impl Fn(&mut Vec3, &Vec3)) {
        for ((v, x), mask) in state.v.iter_mut().zip(&state.x).zip(&state.mask) {
            if mask & self.mask != 0 {
                change(v, x);
            }
        }
    }

    fn zero_momentum(&self, state: &mut State) -> Result<(), Complaint> {
        let members = self.members(state);
        if members.count() == 0 {
            return Err(Complaint::new(GROUP_WORD, "the group has no atoms whose momentum could be zeroed"));
        }
        let drift = members.velocity();
        self.each(state, |v, _| *v -= drift);
        Ok(())
    }

    fn zero_rotation(&self, state: &mut State) -> Result<(), Complaint> {
        let members = self.members(state);
        if members.count() == 0 {
            return Err(Complaint::new(GROUP_WORD, "the group has no atoms whose rotation could be zeroed"));
        }
        let center = members.center();
        let omega = angular_velocity(&members.angular_momentum(&center), &members.inertia(&center));
        for k in 0..state.len() {
            if state.mask[k] & self.mask != 0 {
                let d = self.simulation_box.unwrap(&state.x[k], &state.image[k]) - center;
                state.v[k] -= omega.cross(&d);
            }
        }
        Ok(())
    }

    /// Scales all velocities to a temperature of 3 N - 3 degrees of freedom.
    fn rescale(&self, wanted: f64, state: &mut State) -> Result<(), Complaint> {
        let members = self.members(state);
        let sum = members.sum_mass_velocity_squared();
        let now = temperature(sum, degrees_of_freedom(members.count()), self.units);
        if now == 0.0 {
            return Err(Complaint::new(GROUP_WORD, "the temperature is 0 and cannot be scaled")
                .with_help("atoms at rest, a single atom and an empty group have no temperature"));
        }
        let factor = (wanted / now).sqrt();
        self.each(state, |v, _| *v *= factor);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::test_support::{Scene, TWO_TYPES};

    #[test]
    fn created_velocities_are_those_of_lammps() {
        // Values of LAMMPS 22Jul2025: atoms 1 and 3.
        let cases = [
            (
                "all create 1.44 87287",
                [0.8335315960865538, 0.3275443141758666, 0.06541913742836339],
                [-0.44602454940622244, -2.308025485739541, 1.405369785749323],
            ),
            (
                "all create 1.44 87287 loop local dist gaussian",
                [-0.7302871769969219, 0.24726494062946555, 0.4325052402929508],
                [2.2065755676352, 0.1107949157800671, -2.3193837744024988],
            ),
            (
                "odd create 1.44 87287 loop geom rot yes mom no",
                [0.42906784392634184, -0.7893948723019747, -2.3240249171720633],
                [-1.6030027158835176, -1.1086067854813368, 1.4565695772376823],
            ),
        ];
        for (command, first, third) in cases {
            let mut scene = Scene::new(&format!("{TWO_TYPES}\ngroup none empty"));
            scene.run(&format!("velocity {command}")).unwrap();
            assert_eq!(scene.state.v[0], Vec3::from(first), "{command}");
            assert_eq!(scene.state.v[2], Vec3::from(third), "{command}");
        }
    }

    #[test]
    fn set_and_ramp_take_lattice_units() {
        let mut scene = Scene::new(&format!("{TWO_TYPES}\ngroup none empty"));
        let unit = scene.lattice.as_ref().unwrap().spacing().x;
        scene.run("velocity all set 1.5 NULL 2 units box").unwrap();
        scene.run("velocity odd set NULL 3 NULL").unwrap();
        scene.run("velocity odd set 1 NULL NULL sum yes").unwrap();
        assert_eq!(scene.state.v[0], Vec3::new(1.5 + unit, 3.0 * unit, 2.0));
        assert_eq!(scene.state.v[1], Vec3::new(1.5, 0.0, 2.0));
        // Atom 2 sits at half a lattice unit along y.
        scene.run("velocity all ramp vz 0 4 y 0 2").unwrap();
        assert_eq!(scene.state.v[1].z, unit);
    }

    #[test]
    fn complaints_point_at_the_word() {
        let mut scene = Scene::new(&format!("{TWO_TYPES}\ngroup none empty"));
        assert_eq!(scene.complaint("velocity all scale 1"), (1, "the temperature is 0 and cannot be scaled".into()));
        assert_eq!(scene.complaint("velocity none create 1 5").0, 1);
        assert_eq!(scene.complaint("velocity all create -1 5").0, 3);
        assert_eq!(scene.complaint("velocity all create 1 0").0, 4);
        assert_eq!(scene.complaint("velocity all set v_a 0 0").0, 3);
        assert_eq!(scene.complaint("velocity all create 1 5 temp t").0, 5);
        scene.state.id[3] = 99;
        assert!(scene.complaint("velocity all create 1 5").1.contains("without gaps"));
        scene.masses[1] = None;
        assert!(scene.complaint("velocity all create 1 5").1.contains("mass of atom type 2"));
    }
}
