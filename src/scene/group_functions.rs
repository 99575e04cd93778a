//! Group functions of equal-style formulas: `count(g)`, `xcm(g,x)`, ... (LAMMPS doc page `variable`).

use super::group::Groups;
use super::group_motion::{Members, angular_velocity};
use super::mass::all_masses;
use super::region::Regions;
use crate::system::{SimulationBox, State, Units, Vec3};

/// What group functions look at.
#[derive(Clone, Copy, Debug)]
pub struct GroupContext<'a> {
    pub state: &'a State,
    /// Indexed by type - 1.
    pub masses: &'a [Option<f64>],
    pub groups: &'a Groups,
    pub regions: &'a Regions,
    pub simulation_box: &'a SimulationBox,
    pub units: &'a Units,
}

/// The functions: their names and whether an axis (or a direction) follows the group.
const FUNCTIONS: [(&str, bool); 12] = [
    ("count", false),
    ("mass", false),
    ("xcm", true),
    ("vcm", true),
    ("fcm", true),
    ("bound", true),
    ("gyration", false),
    ("ke", false),
    ("angmom", true),
    ("torque", true),
    ("inertia", true),
    ("omega", true),
];

/// Whether there is a group function of that name.
pub fn is_group_function(function: &str) -> bool {
    FUNCTIONS.iter().any(|(name, _)| *name == function)
}

/// Value of a group function, `Ok(None)` where there is no such function. The last argument may be a region, to which the group
/// is then confined. Errors, in plain words: wrong arguments, undefined groups or regions, masses that are not set.
pub fn group_function(function: &str, args: &[&str], context: &GroupContext<'_>) -> Result<Option<f64>, String> {
    let Some(&(_, has_axis)) = FUNCTIONS.iter().find(|(name, _)| *name == function) else {
        return match function {
            "charge" => Err("charge() needs charges, which are not part of octant".into()),
            _ => Ok(None),
        };
    };
    let wanted = 1 + usize::from(has_axis);
    if args.len() < wanted || args.len() > wanted + 1 {
        let form = if has_axis { "a group and a direction" } else { "a group" };
        return Err(format!("{function}() takes {form} and perhaps a region, got {} arguments", args.len()));
    }
    let bit = context.groups.get(args[0]).ok_or_else(|| format!("{function}(): there is no group '{}'", args[0]))?;
    let Some(region) = args.get(wanted) else {
        return evaluate(function, args, context, context.state, bit).map(Some);
    };
    let region = context.regions.get(region).ok_or_else(|| format!("{function}(): there is no region '{region}'"))?;
    let mut confined = context.state.clone();
    for (mask, x) in confined.mask.iter_mut().zip(&confined.x) {
        if !region.contains(x) {
            *mask = 0;
        }
    }
    evaluate(function, args, context, &confined, bit).map(Some)
}

fn evaluate(
    function: &str,
    args: &[&str],
    context: &GroupContext<'_>,
    state: &State,
    mask: u32,
) -> Result<f64, String> {
    let needs_mass = !matches!(function, "count" | "bound" | "fcm");
    let masses = if needs_mass { all_masses(context.masses)? } else { Vec::new() };
    let members = Members { state, masses: &masses, mask, simulation_box: context.simulation_box };
    let axis = |vector: Vec3| match args[1] {
        "x" => Ok(vector.x),
        "y" => Ok(vector.y),
        "z" => Ok(vector.z),
        other => Err(format!("{function}() takes x, y or z, got '{other}'")),
    };
    match function {
        "count" => Ok(members.count() as f64),
        "mass" => Ok(members.mass()),
        "xcm" => axis(members.center()),
        "vcm" => axis(members.velocity()),
        "fcm" => axis(members.force()),
        "ke" => Ok(members.sum_mass_velocity_squared() * (0.5 * context.units.mvv2e)),
        "gyration" => Ok(members.gyration()),
        "angmom" => axis(members.angular_momentum(&members.center())),
        "torque" => axis(members.torque(&members.center())),
        "omega" => {
            let center = members.center();
            axis(angular_velocity(&members.angular_momentum(&center), &members.inertia(&center)))
        }
        "inertia" => {
            let tensor = members.inertia(&members.center());
            let index = ["xx", "yy", "zz", "xy", "yz", "xz"].iter().position(|d| *d == args[1]);
            let place = index.map(|k| [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)][k]);
            place
                .map(|p| tensor[p])
                .ok_or_else(|| format!("inertia() takes xx, yy, zz, xy, yz or xz, got '{}'", args[1]))
        }
        _ => {
            let [lo, hi] = members.bounds();
            let index = ["xmin", "ymin", "zmin", "xmax", "ymax", "zmax"].iter().position(|d| *d == args[1]);
            let value = index.map(|k| if k < 3 { lo[k] } else { hi[k - 3] });
            value.ok_or_else(|| format!("bound() takes xmin, xmax, ymin, ymax, zmin or zmax, got '{}'", args[1]))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::test_support::{Scene, TWO_TYPES};

    #[test]
    fn values_are_those_of_lammps() {
        let scene = Scene::new(&format!(
            "{TWO_TYPES}
             velocity all create 1.44 87287 loop geom mom no
             region r sphere 1 1 1 0.5"
        ));
        let context = GroupContext {
            state: &scene.state,
            masses: &scene.masses,
            groups: &scene.groups,
            regions: &scene.regions,
            simulation_box: scene.simulation_box.as_ref().unwrap(),
            units: scene.units,
        };
        let value = |function: &str, args: &[&str]| group_function(function, args, &context);
        // Values of LAMMPS 22Jul2025.
        assert_eq!(value("mass", &["odd"]), Ok(Some(16.0)));
        assert_eq!(value("xcm", &["odd", "x"]), Ok(Some(1.0497476196140672)));
        assert_eq!(value("vcm", &["all", "z"]), Ok(Some(0.3114643769122895)));
        assert_eq!(value("ke", &["odd"]), Ok(Some(29.133426236344334)));
        assert_eq!(value("gyration", &["odd"]), Ok(Some(1.5428076160534288)));
        assert_eq!(value("bound", &["odd", "ymax"]), Ok(Some(1.6795961913825073)));
        assert_eq!(value("angmom", &["odd", "z"]), Ok(Some(-10.053013696174128)));
        assert_eq!(value("omega", &["odd", "x"]), Ok(Some(-0.29701407402705227)));
        assert_eq!(value("count", &["odd", "r"]), Ok(Some(1.0)));
        assert_eq!(value("sqrt", &["2"]), Ok(None));
        assert!(value("count", &[]).is_err());
        assert!(value("count", &["none"]).is_err());
        assert!(value("xcm", &["all", "w"]).is_err());
        assert!(value("charge", &["all"]).is_err());
    }
}
