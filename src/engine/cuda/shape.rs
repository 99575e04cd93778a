//! What a scene's kernels are compiled for. Numbers are no part of it: they are parameters.

use crate::dynamics::{Fix, Phase};
use crate::engine::{Precision, Program};
use crate::neighbor::{CellOrder, OCTANTS, Search, Sort};
use crate::system::{GROUP_ALL, LostAtoms, SimulationBox};

/// Everything that decides the text of the kernels.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Positions and velocities in f64; otherwise velocities in f32 and f32 displacements since the last build.
    pub double_store: bool,
    /// Pair arithmetic in f64; otherwise in f32 on fixed-point coordinates.
    pub double_pairs: bool,
    pub types: usize,
    /// Bit by axis.
    pub periodic: u32,
    /// Entries carry a periodic image; otherwise fixed-point coordinates go around with the box, or nothing is periodic.
    pub images: bool,
    /// Edges that an image may lie away, by axis.
    pub most_images: [u32; 3],
    pub index_bits: u32,
    pub wide_entries: bool,
    /// Entries of 16 bits: the number of a run of sorted particles, and the place in it.
    pub short_entries: bool,
    /// Between builds forces are of an inner list, of those pairs that can come within the cutoff in a few steps.
    pub inner: bool,
    /// What neighbors read of particles is kept in the second-level cache before all else.
    pub lasting: bool,
    /// Fixed-point units differ between axes.
    pub scaled: bool,
    /// Cells far apart share a place in the table.
    pub folded: bool,
    /// Cells follow each other along a Z-order curve.
    pub curve: bool,
    /// Cells along the edge of a brick, in whose order they follow each other elsewhere.
    pub brick: u32,
    /// Particles are sorted by radix.
    pub radix: bool,
    pub compact: bool,
    /// Particles of an octant differ in the cells they look into.
    pub midplane: bool,
    /// Bits of the axes whose cells are divided into halves.
    pub octants: u32,
    /// Neighbor cutoffs differ between pairs of types.
    pub cutoffs: bool,
    pub rebuilds: bool,
    pub check: bool,
    pub storage_sort: bool,
    /// Particles that leave the box are lost, and the run goes on.
    pub loses: bool,
    pub shrinks: bool,
    /// Types differ in mass.
    pub masses: bool,
    /// Some fix acts on a part of the particles.
    pub groups: bool,
    /// Some fix has coordinates, and positions are relative.
    pub coordinates: bool,
    /// Some fix acts on forces.
    pub forces: bool,
    /// Some fix has random numbers, or wants to know velocities for the force.
    pub noise: bool,
    /// Fixes that scale velocities by what the kinetic energy of their group is.
    pub thermostats: usize,
    pub lanes: u32,
    /// Particles of an octant that a warp lists together, and warps that share an octant.
    pub group: u32,
    pub slices: u32,
    /// Blocks that fit on a multiprocessor at least: bounds the registers of a thread.
    pub blocks_at_least: u32,
    /// Chunks of a row that are on their way to the second-level cache before they are read.
    pub ahead: u32,
}

/// Cells along the edge of a brick where no other order is asked for: what the whole device works on at a time then has few
/// neighbors beyond itself.
const USUAL_BRICK: u32 = 2;

impl Shape {
    /// What a program and its box decide; the rest (images, table, lanes) follows from the particles.
    pub fn new(program: &Program, simulation_box: &SimulationBox, precision: Precision) -> Self {
        let policy = &program.policy;
        let periodic = (0..3).map(|axis| u32::from(simulation_box.periodic(axis)) << axis).sum();
        let double_pairs = precision == Precision::Double;
        Self {
            double_store: precision != Precision::Single,
            double_pairs,
            types: program.pair.types,
            periodic,
            images: false,
            most_images: [0; 3],
            index_bits: 32,
            wide_entries: false,
            short_entries: false,
            inner: false,
            lasting: false,
            scaled: false,
            folded: false,
            curve: program.search.order() == CellOrder::Curve,
            brick: if program.search.order() == CellOrder::Usual { USUAL_BRICK } else { 1 },
            radix: program.search.sort() == Sort::Radix,
            compact: program.search.is_compact(),
            midplane: program.search.search() == Search::Midplane,
            octants: OCTANTS as u32 - 1,
            cutoffs: false,
            rebuilds: !policy.once,
            check: policy.check && !policy.once,
            storage_sort: program.storage_sort.is_some_and(|sort| sort.every > 0),
            loses: program.lost != LostAtoms::Error && periodic != 7,
            shrinks: simulation_box.shrinks(),
            masses: program.masses.windows(2).any(|pair| pair[0] != pair[1]),
            groups: program.fixes.iter().any(|fix| fix.group != GROUP_ALL),
            coordinates: precision == Precision::Single && program.fixes.iter().any(has_coordinates),
            forces: program.fixes.iter().any(|fix| fix.acts(Phase::Force)),
            thermostats: program.fixes.iter().filter(|fix| fix.acts(Phase::Measured)).count(),
            noise: program.fixes.iter().any(Fix::has_noise),
            lanes: 1,
            group: 32,
            slices: 1,
            blocks_at_least: 1,
            ahead: 0,
        }
    }

    /// Storage order changes.
    pub fn homes(&self) -> bool {
        self.storage_sort || self.loses
    }

    /// CUDA C type of positions and velocities, and its bytes.
    pub fn store(&self) -> (&'static str, usize) {
        if self.double_store { ("double", 8) } else { ("float", 4) }
    }

    /// CUDA C type of pair arithmetic, and its bytes.
    pub fn real(&self) -> (&'static str, usize) {
        if self.double_pairs { ("double", 8) } else { ("float", 4) }
    }

    /// Bytes of a list entry.
    pub fn entry(&self) -> usize {
        match (self.short_entries, self.wide_entries) {
            (true, _) => 2,
            (false, false) => 4,
            (false, true) => 8,
        }
    }

    /// Entries that are read at once.
    pub fn chunk(&self) -> u32 {
        if self.short_entries { 8 } else { 4 }
    }

    /// CUDA C type of what pair arithmetic reads of a particle, and its bytes.
    pub fn slot(&self) -> (&'static str, usize) {
        ("Slot", if self.double_pairs { 32 } else { 16 })
    }

    /// Periodic images that an entry can name.
    pub fn codes(&self) -> u32 {
        self.most_images.iter().map(|most| 2 * most + 1).product()
    }
}

fn has_coordinates(fix: &Fix) -> bool {
    (0..fix.parameters.len()).any(|k| fix.coordinate(k).is_some())
}
