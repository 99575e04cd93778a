//! The full Verlet list: for each particle all neighbors within R.
//!
//! Membership is exact and LAMMPS's: distance at the build at most R, in f64, from the positions of the build. Distances are
//! tested in lanes of f32 on fixed-point coordinates; pairs so near to R that rounding could decide are decided in f64.

use super::block::{Block, Part, SPAN, TileRun, Unit, cut, particle_of};
use super::mode::Shift;
use super::particles::Particles;
use super::scratch::Pool;
use super::ties::Ties;
use crate::neighbor::estimate::ListBytes;
use crate::neighbor::axis::Axis;
use crate::neighbor::{Cells, Grid, Run};
use crate::real::Isa;
use crate::real::lanes::{FixedSlot, Lanes, SearchLanes, Simd, SimdVisitor, Work, with_simd};
use crate::system::parallel;
use crate::system::{SimulationBox, Vec3};

/// For estimates of a list's size: an entry, and a row in one periodic image. Rows are filled up to whole registers.
pub const LIST_BYTES: ListBytes = ListBytes { entry: size_of::<u16>(), stretch: size_of::<u32>() };

/// Rounding of a squared distance in f32 arithmetic, relative.
const ROUNDING: f64 = 8.0 / (1u64 << 24) as f64;

/// Squared neighbor cutoffs by pair of types, and what exactness needs to know of the box.
#[derive(Clone, Debug, Default)]
pub struct Membership {
    types: usize,
    squared: Vec<f64>,
    lengths: [f64; 3],
    pub ties: Ties,
    /// Squared distances, in quanta, below which a pair certainly is in the list and above which it certainly is not.
    /// Rows of as many entries as there are types, filled up to a register.
    inner: Vec<f32>,
    outer: Vec<f32>,
    stride: usize,
    /// Largest of `outer`.
    reach: f32,
    quanta: f64,
}

impl Membership {
    /// `cutoffs` are the neighbor cutoffs R of each pair of types.
    pub fn new(types: usize, cutoffs: &[f64], simulation_box: &SimulationBox, quanta: f64, isa: Isa) -> Self {
        let stride = if types == 1 { 1 } else { types.max(lanes_of(isa)) };
        let coordinate = simulation_box.lo.amax().max(simulation_box.hi.amax());
        // A coordinate is off by half a quantum and by its own rounding, a distance by at most four of these.
        let error = 4.0 / quanta + 16.0 * f64::EPSILON * coordinate;
        let band = |r: f64| ROUNDING + 2.0 * error / r;
        let inner = |r: &f64| if *r > 0.0 { ((r * quanta).powi(2) * (1.0 - band(*r))) as f32 } else { -1.0 };
        // A pair that is switched off is listed where particles coincide, as in LAMMPS.
        let outer = |r: &f64| if *r > 0.0 { ((r * quanta).powi(2) * (1.0 + band(*r))) as f32 } else { 4.0 };
        let rows = |limit: &dyn Fn(&f64) -> f32| -> Vec<f32> {
            let mut all = vec![0.0; types * stride];
            for (row, cutoffs) in all.chunks_exact_mut(stride).zip(cutoffs.chunks_exact(types)) {
                row.iter_mut().zip(cutoffs).for_each(|(to, r)| *to = limit(r));
            }
            all
        };
        let (inner, outer) = (rows(&inner), rows(&outer));
        Self {
            types,
            stride,
            squared: cutoffs.iter().map(|r| r * r).collect(),
            lengths: simulation_box.lengths().into(),
            ties: Ties::new(cutoffs, simulation_box),
            inner,
            reach: outer.iter().copied().fold(0.0, f32::max),
            outer,
            quanta,
        }
    }

    /// Whether j, seen in an image, is a neighbor of i.
    #[cold]
    fn holds(&self, particles: &Particles, i: usize, j: usize, image: [i32; 3]) -> bool {
        let (a, b) = (&particles.x[i], &particles.x[j]);
        let limit = self.squared[particles.kind[i] as usize * self.types + particles.kind[j] as usize];
        let shift = Vec3::from_fn(|axis, _| f64::from(image[axis]) * self.lengths[axis]);
        let d = a - (b + shift);
        let r2 = d.x * d.x + d.y * d.y + d.z * d.z;
        if image != [0; 3] && (r2 - limit).abs() <= self.ties.band * limit {
            return limit > 0.0 && self.ties.squared_distance(a, b, image) <= limit;
        }
        r2 <= limit
    }
}

/// Lanes that distances are tested in.
fn lanes_of(isa: Isa) -> usize {
    struct Count;
    impl SimdVisitor for Count {
        type Output = usize;
        fn visit<I: Simd>(self, _: I) -> usize {
            I::F32::COUNT
        }
    }
    with_simd(isa, Count)
}

/// All rows.
#[derive(Debug, Default)]
pub struct List {
    blocks: Vec<Block>,
    count: usize,
    /// How ties at a cutoff were decided at the build.
    pub ties: Ties,
    /// Rows are filled up to a multiple of this.
    pub lanes: usize,
    /// Distances tested at the last build.
    pub tests: u64,
}

/// What a build starts from.
#[derive(Clone, Copy)]
pub struct Sorted<'a> {
    pub particles: &'a Particles,
    pub fixed: &'a [FixedSlot],
    pub grid: &'a Grid,
    pub cells: &'a Cells,
}

impl List {
    /// Blocks in use.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks[..self.count]
    }

    /// Quanta in a length unit such that the tile of any block fits into 32 bits.
    pub fn quanta(grid: &Grid) -> f64 {
        let extent = |axis: &Axis| {
            let cells = axis.cells.min(SPAN) as f64;
            cells * axis.edge + axis.reach_length()
        };
        let most = grid.axes.iter().map(extent).fold(0.0, f64::max);
        // An eighth stays for rounding and for particles a little outside of their cells.
        0.875 * (1u64 << 31) as f64 / most
    }

    /// Builds all rows, each filled up to a multiple of `lanes`.
    pub fn build(&mut self, sorted: Sorted<'_>, membership: &Membership, isa: Isa, lanes: usize, pool: &Pool) {
        self.count = cut(&mut self.blocks, sorted.grid, sorted.cells);
        self.ties.clone_from(&membership.ties);
        self.lanes = lanes;
        let fill = |_: usize, blocks: &mut [Block]| {
            let mut tests = 0;
            for block in blocks {
                let mut scratch = pool.build();
                block.lay_out(sorted.grid, sorted.cells, &mut scratch.runs);
                tests += with_simd(isa, Fill { block, sorted, membership, lanes, scratch: &mut scratch });
            }
            tests
        };
        self.tests = parallel::each(&mut self.blocks[..self.count], 1, &fill, &|a, b| a + b);
    }

    /// Entries of the full list.
    pub fn pairs(&self) -> u64 {
        let parts = self.blocks().iter().flat_map(|b| b.parts());
        parts.flat_map(|p| &p.lengths).map(|length| u64::from(*length)).sum()
    }

    /// Calls `look` with each row: place of the particle, the part it stands in, slots of its neighbors.
    pub fn for_each_row(&self, mut look: impl FnMut(usize, &Part, &[u16])) {
        for block in self.blocks() {
            for part in block.parts() {
                part.for_each_row(self.lanes, |k, row| look(block.first + k, part, row));
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.blocks.iter().map(Block::bytes).sum()
    }
}

/// Rows of one block.
struct Fill<'a> {
    block: &'a mut Block,
    sorted: Sorted<'a>,
    membership: &'a Membership,
    lanes: usize,
    scratch: &'a mut BuildScratch,
}

impl SimdVisitor for Fill<'_> {
    type Output = u64;
    fn visit<I: Simd>(self, simd: I) -> u64 {
        struct On<'a, I>(Fill<'a>, std::marker::PhantomData<I>);
        impl<I: Simd> Work for On<'_, I> {
            type Output = u64;
            #[inline(always)]
            fn run(self) -> u64 {
                self.0.fill::<I>()
            }
        }
        simd.vectorize(On(self, std::marker::PhantomData::<I>))
    }
}

/// Slots that are tested against a particle together, whatever the number of lanes.
const GROUP: usize = 16;

/// Coordinates in quanta from the block's first particle, one array an axis, and types.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    x: [[i32; GROUP]; 3],
    kinds: [u32; GROUP],
}

/// Bounds of as many groups as are looked at together: low and high, an array an axis.
#[derive(Clone, Copy, Debug, Default)]
struct Bounds {
    low: [[i32; GROUP]; 3],
    high: [[i32; GROUP]; 3],
}

/// A tile while rows are searched.
#[derive(Debug, Default)]
pub struct BuildScratch {
    pub runs: Vec<Run>,
    groups: Vec<Group>,
    /// Low and high corner of each group.
    corners: Vec<[[i32; 3]; 2]>,
    /// The lanes of each group that a unit looks into.
    wanted: Vec<u16>,
    /// Groups with such lanes, and the lanes; filled up to whole bounds.
    near: Vec<(u16, u16)>,
    bounds: Vec<Bounds>,
}

impl BuildScratch {
    pub fn bytes(&self) -> usize {
        self.runs.capacity() * size_of::<Run>()
            + self.groups.capacity() * size_of::<Group>()
            + self.corners.capacity() * size_of::<[[i32; 3]; 2]>()
            + self.wanted.capacity() * 2
            + self.near.capacity() * size_of::<(u16, u16)>()
            + self.bounds.capacity() * size_of::<Bounds>()
    }

    /// Copies a tile, and bounds its groups.
    #[inline(always)]
    fn load(&mut self, part: &Part, first: &FixedSlot, sorted: &Sorted<'_>, membership: &Membership) {
        let count = (part.slots as usize).div_ceil(GROUP);
        self.groups.resize(count, Group::default());
        self.corners.clear();
        self.corners.resize(count, [[i32::MAX; 3], [i32::MIN; 3]]);
        for TileRun { run, slot } in &part.runs {
            let shift = Shift::new(run.image, &membership.lengths, membership.quanta).fixed;
            let offset: [i32; 3] = std::array::from_fn(|a| shift[a].wrapping_sub(first[a]));
            let mut at = *slot as usize;
            for from in &sorted.fixed[run.start as usize..run.end as usize] {
                let (group, corners) = (&mut self.groups[at / GROUP], &mut self.corners[at / GROUP]);
                for a in 0..3 {
                    let x = from[a].wrapping_add(offset[a]);
                    group.x[a][at % GROUP] = x;
                    corners[0][a] = corners[0][a].min(x);
                    corners[1][a] = corners[1][a].max(x);
                }
                group.kinds[at % GROUP] = from[3] as u32;
                at += 1;
            }
        }
    }

    /// Lists the groups within reach of any of the particles `own` (their bounds, quanta from the block's first), all lanes.
    #[inline(always)]
    fn choose_near(&mut self, part: &Part, own: [[i32; 3]; 2], reach: f32) {
        self.near.clear();
        self.bounds.clear();
        for group in 0..self.corners.len() {
            let [low, high] = self.corners[group];
            let mut squared = 0.0;
            for a in 0..3 {
                let gap = low[a].wrapping_sub(own[1][a]).max(own[0][a].wrapping_sub(high[a])).max(0) as f32;
                squared += gap * gap;
            }
            if squared <= reach {
                let taken = (part.slots as usize - group * GROUP).min(GROUP);
                self.push(group, u16::MAX >> (GROUP - taken));
            }
        }
        self.near.resize(self.bounds.len() * GROUP, (0, 0));
    }

    /// Lists the groups that hold slots of `runs`, with their lanes.
    #[inline(always)]
    fn choose(&mut self, part: &Part) {
        self.wanted.clear();
        self.wanted.resize(self.groups.len(), 0);
        for run in &self.runs {
            part.slots_of(run, |start, end| {
                let (start, end) = (start as usize, end as usize);
                for group in start / GROUP..=(end - 1) / GROUP {
                    let from = start.saturating_sub(group * GROUP);
                    let to = (end - group * GROUP).min(GROUP);
                    self.wanted[group] |= (u16::MAX << from) & (u16::MAX >> (GROUP - to));
                }
            });
        }
        self.near.clear();
        self.bounds.clear();
        for group in 0..self.wanted.len() {
            if self.wanted[group] != 0 {
                self.push(group, self.wanted[group]);
            }
        }
        self.near.resize(self.bounds.len() * GROUP, (0, 0));
    }

    #[inline(always)]
    fn push(&mut self, group: usize, lanes: u16) {
        let place = self.near.len() % GROUP;
        if place == 0 {
            self.bounds.push(Bounds::default());
        }
        if let Some(bounds) = self.bounds.last_mut() {
            for a in 0..3 {
                bounds.low[a][place] = self.corners[group][0][a];
                bounds.high[a][place] = self.corners[group][1][a];
            }
        }
        self.near.push((group as u16, lanes));
    }
}

impl Fill<'_> {
    /// Returns how many distances were tested.
    #[inline(always)]
    fn fill<I: Simd>(self) -> u64 {
        let Fill { block, sorted, membership, lanes, scratch } = self;
        let first = sorted.fixed[block.first];
        let mut tests = 0;
        let (parts, units) = block.parts_mut();
        for part in parts {
            scratch.load(part, &first, &sorted, membership);
            for unit in units {
                if sorted.grid.compact {
                    let own = bounds_of(&sorted.fixed[unit.first as usize..unit.end as usize], &first);
                    scratch.choose_near(part, own, membership.reach);
                } else {
                    let cell = sorted.grid.unhash(sorted.cells.hash(unit.cell));
                    scratch.runs.clear();
                    sorted.grid.runs(sorted.cells, cell, unit.octant, &mut scratch.runs);
                    scratch.choose(part);
                }
                let rows = Rows { part, unit, sorted, membership, lanes, first, scratch };
                tests += if sorted.grid.compact { rows.fill::<I::F32, true>() } else { rows.fill::<I::F32, false>() };
            }
        }
        tests
    }
}

/// Low and high corner of some particles, in quanta from `first`.
fn bounds_of(particles: &[FixedSlot], first: &FixedSlot) -> [[i32; 3]; 2] {
    let mut corners = [[i32::MAX; 3], [i32::MIN; 3]];
    for x in particles {
        for a in 0..3 {
            let x = x[a].wrapping_sub(first[a]);
            corners[0][a] = corners[0][a].min(x);
            corners[1][a] = corners[1][a].max(x);
        }
    }
    corners
}

/// Rows of one unit in one part.
struct Rows<'a> {
    part: &'a mut Part,
    unit: &'a Unit,
    sorted: Sorted<'a>,
    membership: &'a Membership,
    lanes: usize,
    first: FixedSlot,
    scratch: &'a BuildScratch,
}

impl Rows<'_> {
    #[inline(always)]
    fn fill<L: SearchLanes, const COMPACT: bool>(self) -> u64 {
        let Rows { part, unit, sorted, membership, lanes, first, scratch } = self;
        let mut tests = 0;
        // The slot of particle `unit.first` and those that follow it, as far as this part holds them.
        let mut own_slots = (0, 0, 0);
        part.slots_of(&Run { start: unit.first, end: unit.end, image: [0; 3] }, |start, end| {
            own_slots = (part.particle(start as u16).0, start as usize, end as usize);
        });
        for i in unit.first as usize..unit.end as usize {
            // All that may be near, and a row's filling.
            let room = part.used + scratch.near.len() * GROUP + lanes;
            if part.entries.len() < room {
                part.entries.resize(room.max(part.used + part.used / 2), 0);
            }
            let own_slot = own_slots.1 + i.wrapping_sub(own_slots.0);
            let own_slot = if i >= own_slots.0 && own_slot < own_slots.2 { own_slot } else { usize::MAX };
            let own = std::array::from_fn(|a| sorted.fixed[i][a].wrapping_sub(first[a]));
            let search = Search::<L>::new(membership, sorted.particles.kind[i] as usize, own);
            let (_, row) = part.entries.split_at_mut(part.used);
            let mut length = 0;
            for (near, bounds) in scratch.near.as_chunks::<GROUP>().0.iter().zip(&scratch.bounds) {
                // One bit a group within reach.
                let mut reached = if COMPACT { search.groups_in_reach(bounds) } else { u16::MAX };
                while reached != 0 {
                    let (group, wanted) = near[reached.trailing_zeros() as usize];
                    reached &= reached - 1;
                    let base = group as usize * GROUP;
                    tests += u64::from(wanted.count_ones());
                    let (mut inside, outside) = search.bits(&scratch.groups[group as usize]);
                    let own_bit = if own_slot.wrapping_sub(base) < GROUP { 1 << (own_slot - base) } else { 0 };
                    let wanted = wanted & !own_bit;
                    inside &= wanted;
                    let mut doubt = wanted & !inside & !outside;
                    while doubt != 0 {
                        let lane = doubt.trailing_zeros();
                        doubt &= doubt - 1;
                        inside |= u16::from(decide(&part.runs, membership, sorted.particles, i, base + lane as usize))
                            << lane;
                    }
                    for at in (0..GROUP).step_by(L::COUNT) {
                        let bits = u32::from(inside) >> at & (u32::MAX >> (32 - L::COUNT));
                        L::compress((base + at) as u16, bits, &mut row[length..]);
                        length += bits.count_ones() as usize;
                    }
                }
            }
            let filled = length.next_multiple_of(lanes);
            row[length..filled].fill(part.slots as u16);
            part.lengths.push(length as u32);
            part.used += filled;
        }
        tests
    }
}

/// Whether the particle in a slot is a neighbor of i, where rounding could decide.
#[cold]
#[inline(never)]
fn decide(runs: &[TileRun], membership: &Membership, particles: &Particles, i: usize, slot: usize) -> bool {
    let (j, image) = particle_of(runs, slot as u16);
    membership.holds(particles, i, j, image)
}

/// One particle looking for neighbors.
struct Search<'a, L> {
    own: [i32; 3],
    inner: &'a [f32],
    outer: &'a [f32],
    reach: L,
}

impl<'a, L: SearchLanes> Search<'a, L> {
    #[inline(always)]
    fn new(membership: &'a Membership, kind: usize, own: [i32; 3]) -> Self {
        let row = kind * membership.stride..(kind + 1) * membership.stride;
        let (inner, outer) = (&membership.inner[row.clone()], &membership.outer[row]);
        Self { own, inner, outer, reach: L::splat(membership.reach) }
    }

    /// Lanes that certainly are neighbors, and lanes that certainly are none.
    #[inline(always)]
    fn bits(&self, group: &Group) -> (u16, u16) {
        let (mut inside, mut outside) = (0, 0);
        for at in (0..GROUP).step_by(L::COUNT) {
            let mut r2 = L::constant(0.0);
            for a in 0..3 {
                let d = L::fixed_differences(self.own[a], &group.x[a][at..]);
                r2 = d.mul_add(d, r2);
            }
            let inner = limit::<L>(self.inner, &group.kinds[at..]);
            let outer = limit::<L>(self.outer, &group.kinds[at..]);
            inside |= L::bits(r2.less(inner)) << at;
            outside |= L::bits(outer.less(r2)) << at;
        }
        (inside as u16, outside as u16)
    }

    /// Which groups come within the largest cutoff.
    #[inline(always)]
    fn groups_in_reach(&self, bounds: &Bounds) -> u16 {
        let mut out = 0;
        for at in (0..GROUP).step_by(L::COUNT) {
            let mut squared = L::constant(0.0);
            for a in 0..3 {
                let below = -L::fixed_differences(self.own[a], &bounds.low[a][at..]);
                let above = L::fixed_differences(self.own[a], &bounds.high[a][at..]);
                let distance = below.max(above).max(L::constant(0.0));
                squared = distance.mul_add(distance, squared);
            }
            out |= L::bits(self.reach.less(squared)) << at;
        }
        !(out as u16)
    }
}

/// The limits of a type with the others, for their types.
#[inline(always)]
fn limit<L: SearchLanes>(column: &[f32], kinds: &[u32]) -> L {
    match column {
        [one] => L::splat(*one),
        many => L::lookup(many, kinds),
    }
}
