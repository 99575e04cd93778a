//! The search that fills a block's rows: sixteen candidates of the tile at a time, distances in lanes of f32 on fixed-point
//! coordinates, groups out of reach passed over.

use super::block::{Block, Part, TileRun, Unit, particle_of};
use super::list::Sorted;
use super::membership::Membership;
use super::mode::Shift;
use crate::engine::particles::Particles;
use crate::neighbor::Run;
use crate::real::lanes::{FixedSlot, SearchLanes, Simd, SimdVisitor, Work};

/// Rows of one block.
pub struct Fill<'a> {
    pub block: &'a mut Block,
    pub sorted: Sorted<'a>,
    pub membership: &'a Membership,
    /// Rows are filled up to a multiple of this.
    pub lanes: usize,
    pub scratch: &'a mut BuildScratch,
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
    /// First slot of each group; one more entry closes the last. A group's slots are of one octant where groups are bounded.
    firsts: Vec<u32>,
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
            + self.firsts.capacity() * 4
            + self.corners.capacity() * size_of::<[[i32; 3]; 2]>()
            + self.wanted.capacity() * 2
            + self.near.capacity() * size_of::<(u16, u16)>()
            + self.bounds.capacity() * size_of::<Bounds>()
    }

    /// Cuts a tile into groups of even size. `runs` holds its octants if it is all of them.
    fn divide(&mut self, part: &Part) {
        self.firsts.clear();
        let mut slot = 0;
        let whole = self.runs.iter().map(|run| run.end - run.start).sum::<u32>() == part.slots;
        for run in self.runs.iter().filter(|_| whole) {
            let (length, pieces) = (run.end - run.start, (run.end - run.start).div_ceil(GROUP as u32));
            self.firsts.extend((0..pieces).map(|piece| slot + length * piece / pieces));
            slot += length;
        }
        while slot < part.slots {
            self.firsts.push(slot);
            slot += (GROUP as u32).min(part.slots - slot);
        }
        self.firsts.push(slot);
    }

    /// Copies a tile, and bounds its groups.
    #[inline(always)]
    fn load(&mut self, part: &Part, first: &FixedSlot, sorted: &Sorted<'_>, membership: &Membership) {
        let count = self.firsts.len() - 1;
        self.groups.resize(count, Group::default());
        self.corners.clear();
        self.corners.resize(count, [[i32::MAX; 3], [i32::MIN; 3]]);
        let mut at = 0;
        for TileRun { run, slot } in &part.runs {
            let shift = Shift::new(run.image, &membership.lengths, membership.quanta).fixed;
            let offset: [i32; 3] = std::array::from_fn(|a| shift[a].wrapping_sub(first[a]));
            let mut particles = &sorted.fixed[run.start as usize..run.end as usize];
            let mut slot = *slot;
            while !particles.is_empty() {
                at += usize::from(slot >= self.firsts[at + 1]);
                let taken = ((self.firsts[at + 1] - slot) as usize).min(particles.len());
                let lane = (slot - self.firsts[at]) as usize;
                let (now, later) = particles.split_at(taken);
                let (group, [low, high]) = (&mut self.groups[at], &mut self.corners[at]);
                for a in 0..3 {
                    for (to, from) in group.x[a][lane..][..taken].iter_mut().zip(now) {
                        *to = from[a].wrapping_add(offset[a]);
                        low[a] = low[a].min(*to);
                        high[a] = high[a].max(*to);
                    }
                }
                for (to, from) in group.kinds[lane..][..taken].iter_mut().zip(now) {
                    *to = from[3] as u32;
                }
                slot += taken as u32;
                particles = later;
            }
        }
    }

    /// Lists the groups within reach of any of the particles `own` (their bounds, quanta from the block's first), all lanes.
    #[inline(always)]
    fn choose_near(&mut self, own: [[i32; 3]; 2], reach: f32) {
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
                let taken = self.firsts[group + 1] - self.firsts[group];
                self.push(group, u16::MAX >> (GROUP as u32 - taken));
            }
        }
        self.near.resize(self.bounds.len() * GROUP, (0, 0));
    }

    /// Lists the groups (aligned ones of full size) that hold slots of `runs`, with their lanes.
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
            if !sorted.grid.compact {
                scratch.runs.clear();
            }
            scratch.divide(part);
            scratch.load(part, &first, &sorted, membership);
            for unit in units {
                if sorted.grid.compact {
                    let own = bounds_of(&sorted.fixed[unit.first as usize..unit.end as usize], &first);
                    scratch.choose_near(own, membership.reach);
                } else {
                    let cell = sorted.grid.unhash(sorted.cells.hash(unit.cell));
                    scratch.runs.clear();
                    sorted.grid.runs(sorted.cells, cell, unit.octant, unit.middle, &mut scratch.runs);
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
                    let base = scratch.firsts[group as usize] as usize;
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
