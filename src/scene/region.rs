//! Regions of space (LAMMPS doc page `region`).

use super::lattice::Lattice;
use crate::script::command::region::{FIRST_ARGUMENT, Limit, RegionAction, RegionCommand, RegionShape};
use crate::script::{Complaint, Name};
use crate::system::{SimulationBox, Vec3};

/// Where an infinite side lies, as LAMMPS has it.
const INFINITE: f64 = 1.0e20;

/// A part of space: a shape or all but the shape. Lengths in length units.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    shape: Shape,
    inside: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Block { lo: Vec3, hi: Vec3 },
    Sphere { center: Vec3, radius: f64 },
    Cylinder { axis: usize, center: [f64; 2], radius: f64, lo: f64, hi: f64 },
    Union(Vec<Region>),
    Intersect(Vec<Region>),
}

/// The two axes across a cylinder's, in the order x, y, z.
fn across(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

impl Region {
    /// Builds a region that needs no other; `union` and `intersect` go through [`Regions::apply`].
    /// Without a lattice, lattice units are length units; `INF` and `EDGE` need a box.
    pub fn new(
        command: &RegionCommand,
        lattice: Option<&Lattice>,
        simulation_box: Option<&SimulationBox>,
    ) -> Result<Self, Complaint> {
        Self::with_parts(command, lattice, simulation_box, &Regions::default())
    }

    fn with_parts(
        command: &RegionCommand,
        lattice: Option<&Lattice>,
        simulation_box: Option<&SimulationBox>,
        regions: &Regions,
    ) -> Result<Self, Complaint> {
        let RegionAction::Define { shape, inside, lattice_units } = &command.action else {
            return Err(Complaint::new(2, "expected a region style, got 'delete'"));
        };
        let unit = match lattice {
            Some(lattice) if *lattice_units => lattice.spacing(),
            _ => Vec3::repeat(1.0),
        };
        let place = |limit: Limit, axis: usize, side: usize, word: usize| match (limit, simulation_box) {
            (Limit::At(value), _) => Ok(unit[axis] * value),
            (_, None) => Err(Complaint::new(word, "INF and EDGE need a simulation box, which does not exist yet")),
            (Limit::Infinite, _) => Ok(if side == 0 { -INFINITE } else { INFINITE }),
            (Limit::Edge, Some(b)) => Ok(if side == 0 { b.lo[axis] } else { b.hi[axis] }),
        };
        let parts = |names: &[Name]| names.iter().map(|n| regions.find(n).cloned()).collect::<Result<Vec<_>, _>>();
        let shape = match shape {
            RegionShape::Block { limits } => {
                let (mut lo, mut hi) = (Vec3::zeros(), Vec3::zeros());
                for axis in 0..3 {
                    let word = FIRST_ARGUMENT + 2 * axis;
                    lo[axis] = place(limits[axis][0], axis, 0, word)?;
                    hi[axis] = place(limits[axis][1], axis, 1, word + 1)?;
                    if lo[axis] > hi[axis] {
                        let message = format!("the low limit {} lies above the high limit {}", lo[axis], hi[axis]);
                        return Err(Complaint::new(word, message));
                    }
                }
                Shape::Block { lo, hi }
            }
            RegionShape::Sphere { center, radius } => {
                Shape::Sphere { center: Vec3::from(*center).component_mul(&unit), radius: unit.x * radius }
            }
            RegionShape::Cylinder { axis, center, radius, limits } => {
                let [first, second] = across(*axis);
                Shape::Cylinder {
                    axis: *axis,
                    center: [unit[first] * center[0], unit[second] * center[1]],
                    radius: unit[first] * radius,
                    lo: place(limits[0], *axis, 0, FIRST_ARGUMENT + 4)?,
                    hi: place(limits[1], *axis, 1, FIRST_ARGUMENT + 5)?,
                }
            }
            RegionShape::Union(names) => Shape::Union(parts(names)?),
            RegionShape::Intersect(names) => Shape::Intersect(parts(names)?),
        };
        Ok(Self { shape, inside: *inside })
    }

    /// Whether a point belongs to the region; the surface belongs to the shape.
    pub fn contains(&self, x: &Vec3) -> bool {
        let in_shape = match &self.shape {
            Shape::Block { lo, hi } => (0..3).all(|a| x[a] >= lo[a] && x[a] <= hi[a]),
            Shape::Sphere { center, radius } => {
                let d = x - center;
                (d.x * d.x + d.y * d.y + d.z * d.z).sqrt() <= *radius
            }
            Shape::Cylinder { axis, center, radius, lo, hi } => {
                let [first, second] = across(*axis);
                let (d1, d2) = (x[first] - center[0], x[second] - center[1]);
                (d1 * d1 + d2 * d2).sqrt() <= *radius && x[*axis] >= *lo && x[*axis] <= *hi
            }
            Shape::Union(parts) => parts.iter().any(|r| r.contains(x)),
            Shape::Intersect(parts) => parts.iter().all(|r| r.contains(x)),
        };
        in_shape == self.inside
    }

    /// Corners of the box around the region, if it has one: not where it lies outside of its shape.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        if !self.inside {
            return None;
        }
        match &self.shape {
            Shape::Block { lo, hi } => Some([*lo, *hi]),
            Shape::Sphere { center, radius } => Some([center - Vec3::repeat(*radius), center + Vec3::repeat(*radius)]),
            Shape::Cylinder { axis, center, radius, lo, hi } => {
                let (mut low, mut high) = (Vec3::repeat(*lo), Vec3::repeat(*hi));
                for (a, c) in across(*axis).into_iter().zip(center) {
                    low[a] = c - radius;
                    high[a] = c + radius;
                }
                Some([low, high])
            }
            // A union has bounds when all its parts have; an intersection those of the parts that have any.
            Shape::Union(parts) => {
                let bounds: Option<Vec<_>> = parts.iter().map(Self::bounds).collect();
                bounds?.into_iter().reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])])
            }
            Shape::Intersect(parts) => {
                parts.iter().filter_map(Self::bounds).reduce(|a, b| [a[0].sup(&b[0]), a[1].inf(&b[1])])
            }
        }
    }
}

/// All regions of a script, by ID.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Regions {
    list: Vec<(String, Region)>,
}

impl Regions {
    /// Carries out a `region` command. Errors: an ID in use, an unknown part, what [`Region::new`] says.
    pub fn apply(
        &mut self,
        command: &RegionCommand,
        lattice: Option<&Lattice>,
        simulation_box: Option<&SimulationBox>,
    ) -> Result<(), Complaint> {
        if command.action == RegionAction::Delete {
            self.find(&command.name)?;
            self.list.retain(|(id, _)| *id != command.name.text);
            return Ok(());
        }
        if self.get(&command.name.text).is_some() {
            return Err(Complaint::new(command.name.word, format!("region '{}' exists already", command.name.text)));
        }
        let region = Region::with_parts(command, lattice, simulation_box, self)?;
        self.list.push((command.name.text.clone(), region));
        Ok(())
    }

    /// A region by its ID.
    pub fn get(&self, id: &str) -> Option<&Region> {
        self.list.iter().find(|(known, _)| known == id).map(|(_, region)| region)
    }

    /// A region that a command names.
    pub fn find(&self, name: &Name) -> Result<&Region, Complaint> {
        self.get(&name.text).ok_or_else(|| {
            let known: Vec<&str> = self.list.iter().map(|(id, _)| id.as_str()).collect();
            let known =
                if known.is_empty() { "none is defined".into() } else { format!("defined: {}", known.join(", ")) };
            Complaint::new(name.word, format!("expected a region ID, got '{}' ({known})", name.text))
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::test_support::Scene;

    const SCENE: &str = "lattice fcc 0.8442\nregion b block 0 2 0 2 0 2\ncreate_box 2 b\ncreate_atoms 1 box\n";

    #[test]
    fn regions_hold_as_many_atoms_as_in_lammps() {
        // Counts of LAMMPS 22Jul2025.
        let regions = [
            ("sphere 1 1 1 0.5", 1),
            ("sphere 1 1 1 0.5 side out", 31),
            ("cylinder y 1 1 0.5 EDGE 1", 6),
            ("block INF 1 0.5 EDGE 0 1.5", 18),
        ];
        for (region, count) in regions {
            let mut scene = Scene::new(SCENE);
            scene.run(&format!("region r {region}")).unwrap();
            scene.run("group r region r").unwrap();
            assert_eq!(scene.count("r"), count, "{region}");
        }
    }

    #[test]
    fn bounds_are_those_of_the_shape() {
        let bounds = |region: &str| {
            let mut scene = Scene::new("region p sphere 1 2 3 1\nregion q block 0 3 0 3 0 3\n");
            scene.run(&format!("region r {region}")).unwrap();
            scene.regions.get("r").unwrap().bounds().map(|[lo, hi]| [lo.x, lo.y, lo.z, hi.x, hi.y, hi.z])
        };
        assert_eq!(bounds("union 2 p q"), Some([0.0, 0.0, 0.0, 3.0, 3.0, 4.0]));
        assert_eq!(bounds("intersect 2 p q"), Some([0.0, 1.0, 2.0, 2.0, 3.0, 3.0]));
        assert_eq!(bounds("cylinder x 1 2 0.5 -1 4"), Some([-1.0, 0.5, 1.5, 4.0, 1.5, 2.5]));
        assert_eq!(bounds("sphere 1 1 1 1 side out"), None);
    }

    #[test]
    fn complaints_point_at_the_word() {
        let complaint = |line: &str| Scene::new("region a sphere 0 0 0 1").complaint(line);
        assert_eq!(complaint("region r block 0 1 0 EDGE 0 1").0, 6);
        assert_eq!(complaint("region r block 0 1 3 1 0 1"), (5, "the low limit 3 lies above the high limit 1".into()));
        assert_eq!(complaint("region r union 2 a c"), (5, "expected a region ID, got 'c' (defined: a)".into()));
        assert_eq!(complaint("region a sphere 0 0 0 1"), (1, "region 'a' exists already".into()));
        assert!(complaint("region r sphere 0 0 0 1 move v_a NULL NULL").1.contains("'move' is not part of octant"));
        assert!(complaint("region r sphere v_a 0 0 1").1.contains("not part of octant"));
        assert_eq!(complaint("region r cone z").0, 2);
    }
}
