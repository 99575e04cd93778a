//! `create_atoms` (LAMMPS doc page `create_atoms`): positions, their order and their ids are LAMMPS's on one processor.

use super::lattice::Lattice;
use super::region::{Region, Regions};
use crate::script::Complaint;
use crate::script::command::create_atoms::{CreateAtomsCommand, CreateAtomsStyle, STYLE_WORD, TYPE_WORD};
use crate::system::{RanPark, SimulationBox, State, Vec3, memory};

/// What there is before atoms are created.
#[derive(Clone, Copy, Debug)]
pub struct CreateContext<'a> {
    pub lattice: Option<&'a Lattice>,
    pub regions: &'a Regions,
    pub simulation_box: &'a SimulationBox,
    /// Number of atom types.
    pub types: usize,
}

/// Part of a periodic edge by which lattice points may lie below the low side, and twice which they must keep from the high side.
const EDGE_TOLERANCE: f64 = 1.0e-6;
/// Numbers of a stream thrown away before random positions are drawn.
const WARMUP: usize = 30;
/// Tries at a random position before an atom is given up.
const MAX_TRIES: usize = 1000;
/// Lattice points we are willing to look at.
const MAX_POINTS: f64 = 1.0e10;

/// Creates atoms and returns how many; their ids follow the largest there is.
/// With `random` and a region, fewer than asked for may fit; the caller can compare.
/// Errors: a type or basis atom that does not exist, an undefined region, a lattice without points, ids running out.
pub fn create_atoms(
    command: &CreateAtomsCommand,
    context: &CreateContext<'_>,
    state: &mut State,
) -> Result<usize, Complaint> {
    check_type(command.kind, context.types, TYPE_WORD)?;
    let site_types = site_types(command, context)?;
    let start = state.len();
    let mut ids = Ids::new(state);
    match &command.style {
        CreateAtomsStyle::Box => on_lattice(context, None, &site_types, &mut ids, state)?,
        CreateAtomsStyle::Region(name) => {
            on_lattice(context, Some(context.regions.find(name)?), &site_types, &mut ids, state)?;
        }
        CreateAtomsStyle::Single(point) => {
            let unit = match context.lattice {
                Some(lattice) if command.lattice_units => lattice.spacing(),
                _ => Vec3::repeat(1.0),
            };
            let x = Vec3::from(*point).component_mul(&unit);
            if within(&x, &context.simulation_box.lo, &context.simulation_box.hi) {
                state.push(ids.take()?, command.kind, x);
            }
        }
        CreateAtomsStyle::Random { count, seed, region } => {
            let region = region.as_ref().map(|name| context.regions.find(name)).transpose()?;
            at_random(*count, *seed, region, command.kind, context, &mut ids, state)?;
        }
    }
    Ok(state.len() - start)
}

/// Ids given out one after another; LAMMPS's are positive 32-bit numbers.
struct Ids {
    next: u32,
    /// Atoms that memory has room for.
    room: u64,
}

impl Ids {
    fn new(state: &State) -> Self {
        Self { next: state.max_id(), room: memory::available() / memory::BYTES_PER_ATOM }
    }

    fn take(&mut self) -> Result<u32, Complaint> {
        let Some(room) = self.room.checked_sub(1) else {
            return Err(too_many("more atoms than fit in memory are needed".into()));
        };
        self.room = room;
        if self.next >= i32::MAX as u32 {
            return Err(too_many(format!("more than {} atom ids are needed", i32::MAX)));
        }
        self.next += 1;
        Ok(self.next)
    }
}

fn too_many(message: String) -> Complaint {
    Complaint::new(STYLE_WORD, message)
}

fn check_type(kind: u32, types: usize, word: usize) -> Result<(), Complaint> {
    if (1..=types).contains(&(kind as usize)) {
        return Ok(());
    }
    Err(Complaint::new(word, format!("expected an atom type from 1 to {types}, got {kind}")))
}

/// The atom type on each basis site.
fn site_types(command: &CreateAtomsCommand, context: &CreateContext<'_>) -> Result<Vec<u32>, Complaint> {
    let sites = context.lattice.map_or(0, Lattice::basis_len);
    let mut types = vec![command.kind; sites];
    for basis in &command.basis {
        let Some(kind) = basis.site.checked_sub(1).and_then(|k| types.get_mut(k)) else {
            return Err(Complaint::new(
                basis.word,
                format!("expected a basis atom of the lattice, which has {sites}, got {}", basis.site),
            ));
        };
        check_type(basis.kind, context.types, basis.word + 1)?;
        *kind = basis.kind;
    }
    Ok(types)
}

fn within(x: &Vec3, lo: &Vec3, hi: &Vec3) -> bool {
    (0..3).all(|a| x[a] >= lo[a] && x[a] < hi[a])
}

fn on_lattice(
    context: &CreateContext<'_>,
    region: Option<&Region>,
    site_types: &[u32],
    ids: &mut Ids,
    state: &mut State,
) -> Result<(), Complaint> {
    let Some(lattice) = context.lattice.filter(|l| l.basis_len() > 0) else {
        return Err(Complaint::new(STYLE_WORD, "a lattice with points is needed; the lattice command defines one"));
    };
    let (mut lo, mut hi) = (context.simulation_box.lo, context.simulation_box.hi);
    let edge = context.simulation_box.lengths();
    for axis in (0..3).filter(|a| context.simulation_box.periodic(*a)) {
        // A point on one side of a periodic box must not have a twin on the other.
        let tolerance = edge[axis] * EDGE_TOLERANCE;
        lo[axis] -= tolerance;
        hi[axis] -= 2.0 * tolerance;
    }
    let (mut from, mut to) = (lo, hi);
    if let Some([low, high]) = region.and_then(Region::bounds) {
        (from, to) = (from.sup(&low), to.inf(&high));
        if (0..3).any(|a| from[a] > to[a]) {
            return Ok(());
        }
    }
    let [x, y, z] = lattice.cells_covering(&from, &to);
    let points = [x, y, z].iter().map(|r| r[1] - r[0] + 1.0).product::<f64>() * lattice.basis_len() as f64;
    if !(points <= MAX_POINTS && [x, y, z].as_flattened().iter().all(|c| c.abs() < 1.0e15)) {
        return Err(Complaint::new(STYLE_WORD, format!("about {points:.0e} lattice points lie in the box, too many")));
    }
    let range = |r: [f64; 2]| r[0] as i64..=r[1] as i64;
    for k in range(z) {
        for j in range(y) {
            for i in range(x) {
                for (site, &kind) in site_types.iter().enumerate() {
                    let point = lattice.point(i, j, k, site);
                    if within(&point, &lo, &hi) && region.is_none_or(|r| r.contains(&point)) {
                        state.push(ids.take()?, kind, point);
                    }
                }
            }
        }
    }
    Ok(())
}

fn at_random(
    count: usize,
    seed: u32,
    region: Option<&Region>,
    kind: u32,
    context: &CreateContext<'_>,
    ids: &mut Ids,
    state: &mut State,
) -> Result<(), Complaint> {
    let (box_lo, box_hi) = (context.simulation_box.lo, context.simulation_box.hi);
    let (mut lo, mut hi) = (box_lo, box_hi);
    if let Some([low, high]) = region.and_then(Region::bounds) {
        (lo, hi) = (lo.sup(&low), hi.inf(&high));
    }
    if (0..3).any(|a| lo[a] > hi[a]) {
        return Err(Complaint::new(STYLE_WORD, "the region does not overlap the box"));
    }
    if count as u64 + u64::from(ids.next) > i32::MAX as u64 {
        return Err(too_many(format!("more than {} atom ids are needed", i32::MAX)));
    }
    if count as u64 > ids.room {
        return Err(too_many(format!("{count} atoms do not fit in memory")));
    }
    let mut random = RanPark::new(seed);
    random.skip(WARMUP);
    for _ in 0..count {
        for _ in 0..MAX_TRIES {
            let mut x = Vec3::zeros();
            for axis in 0..3 {
                x[axis] = lo[axis] + random.uniform() * (hi[axis] - lo[axis]);
            }
            if region.is_none_or(|r| r.contains(&x)) && within(&x, &box_lo, &box_hi) {
                state.push(ids.take()?, kind, x);
                break;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::test_support::Scene;

    #[test]
    fn positions_on_a_turned_lattice_are_those_of_lammps() {
        // Values of LAMMPS 22Jul2025.
        let scene = Scene::new(
            "lattice bcc 0.9 orient x 1 1 1 orient y 1 -1 0 orient z 1 1 -2 origin 0.1 0.2 0.3
             region b block 0 2 0 3 0 1.5
             create_box 2 b
             create_atoms 1 box basis 2 2",
        );
        let state = &scene.state;
        assert_eq!(state.len(), 72);
        assert_eq!(state.kind[..4], [2, 1, 2, 2]);
        assert_eq!(state.id[71], 72);
        assert_eq!(state.x[0], Vec3::new(0.6027333030588266, 4.060069869560154, 1.7047872233594503));
        assert_eq!(state.x[1], Vec3::new(0.22602498864706003, 4.982813021732917, 2.2375332306592783));
        assert_eq!(state.x[71], Vec3::new(3.993108132764725, 1.2918404130418675, 0.1065492014599656));
    }

    #[test]
    fn random_positions_are_those_of_lammps() {
        // Values of LAMMPS 22Jul2025.
        let scene = Scene::new(
            "region b block 0 2 0 3 0 1.5\ncreate_box 2 b\nregion s sphere 1 1 1 0.5\ncreate_atoms 1 random 3 4242 s",
        );
        let x = [
            Vec3::new(1.08096293713011, 0.7440843457561379, 0.8255991234097626),
            Vec3::new(0.84446714787952, 0.9593544110932175, 0.8695872437067271),
            Vec3::new(1.0254200899626222, 1.235452001791192, 1.241794104567633),
        ];
        assert_eq!(scene.state.x, x);
    }

    #[test]
    fn a_single_atom_outside_is_not_made() {
        let mut scene = Scene::new("lattice sc 0.125\nregion b block 0 4 0 4 0 4\ncreate_box 1 b");
        scene.run("create_atoms 1 single 4 1 1").unwrap();
        scene.run("create_atoms 1 single 1 2 3").unwrap();
        scene.run("create_atoms 1 single 1 2 3 units box").unwrap();
        assert_eq!(scene.state.x, [Vec3::new(2.0, 4.0, 6.0), Vec3::new(1.0, 2.0, 3.0)]);
        assert_eq!(scene.state.id, [1, 2]);
    }

    #[test]
    fn complaints_point_at_the_word() {
        let mut scene = Scene::new("region b block 0 4 0 4 0 4\ncreate_box 1 b");
        assert_eq!(scene.complaint("create_atoms 1 box").0, 2);
        scene.run("lattice bcc 1").unwrap();
        assert_eq!(scene.complaint("create_atoms 2 box"), (1, "expected an atom type from 1 to 1, got 2".into()));
        assert_eq!(scene.complaint("create_atoms 1 box basis 3 1").0, 4);
        assert_eq!(scene.complaint("create_atoms 1 box basis 2 2").0, 5);
        assert_eq!(scene.complaint("create_atoms 1 region r").0, 3);
        assert_eq!(scene.complaint("create_atoms 1 random 5 0 NULL").0, 4);
        assert!(scene.complaint("create_atoms 1 box subset 3 5").1.contains("'subset' is not part of octant"));
        assert!(scene.state.is_empty());
    }

    #[test]
    fn an_absurd_number_of_points_is_refused() {
        let mut scene = Scene::new("region b block 0 1e9 0 1e9 0 1e9\ncreate_box 1 b\nlattice sc 1");
        assert!(scene.complaint("create_atoms 1 box").1.contains("too many"));
        scene.run("region r sphere 5e8 5e8 5e8 2").unwrap();
        scene.run("create_atoms 1 region r").unwrap();
        assert_eq!(scene.state.len(), 33);
    }
}
