//! From a program and where its particles are to what kernels are given: shape, constants, tables.

use super::layout::{Limit, RUNS, Scene, TENSOR_REACH};
use super::shape::Shape;
use super::source::pair_numbers;
use crate::dynamics::MOST_PARAMETERS_OF_ALL;
use crate::engine::tuned::{Choices, Table};
use crate::engine::{Precision, Program, particles};
use crate::neighbor::axis::{Axis, Reach};
use crate::neighbor::cells::most_dense_cells;
use crate::neighbor::guard::COARSEST_QUANTUM;
use crate::neighbor::ties::Ties;
use crate::neighbor::{Grid, LAMMPS_BIN, OCTANTS, guard};
use crate::pair::power_of_two;
use crate::system::{SimulationBox, Vec3};

/// Most of LAMMPS's bins a particle that storage order is sorted by.
const BINS_PER_PARTICLE: f64 = 16.0;

/// Most threads a row with short entries: where there are more, scenes are small, and the look-up of runs is one read more in
/// the chain that a step waits for.
const MOST_SHORT_LANES: u32 = 2;

/// From this part of the widest cutoff on a skin is wide enough that an inner list saves more than it costs to make.
const WIDE_SKIN: f64 = 0.2;

/// Bytes of slots that stay in the second-level cache by themselves: half of an H100's.
const CACHED_SLOTS: u64 = 25 << 20;

/// The skin of the inner list as a part of the list's: the fastest of those tried, flat from 0.25 to 0.35.
const INNER_PART: f64 = 0.35;

/// The narrowest skin of an inner list, as a part of the neighbor cutoff: below it rounding would count.
const LEAST_INNER: f64 = 0.01;

/// The part of the inner skin that is left to the rounding of f32.
const INNER_SLACK: f64 = 1e-3;

/// Most warps that share an octant in the list build.
const MOST_SLICES: u64 = 1024;

/// What is done otherwise than the table of choices and the size of the scene suggest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tuning {
    pub choices: Option<Choices>,
    /// Places of a row at the start; rows grow as they have to.
    pub capacity: Option<u32>,
    /// The skin of the inner list as a part of the list's, below 1; 0: no inner list.
    pub inner: Option<f64>,
}

/// What kernels are given.
pub struct Plan {
    /// Particles.
    pub n: usize,
    pub shape: Shape,
    pub scene: Scene,
    /// Runs of octants to look into by octant: the cell relative to the own one, first octant and their number times 8.
    pub visits: Vec<[i32; 4]>,
    pub visit_starts: Vec<u32>,
    pub limits: Vec<Limit>,
    /// Row-major by pair of types.
    pub coefficients: Vec<f64>,
    /// Periodic images by code.
    pub images: Vec<[i32; 4]>,
    /// Their shifts in fixed-point units and in length units.
    pub fixed_shifts: Vec<[i32; 4]>,
    pub shifts: Vec<[f64; 4]>,
    pub half_kicks: Vec<f64>,
    /// Units of energy and of pair differences.
    pub energy: f64,
    pub unit: f64,
    /// Buckets that particles are counted into, by cell or by bin.
    pub most_buckets: u64,
}

/// What a plan starts from.
pub struct Given<'a> {
    pub program: &'a Program,
    pub simulation_box: &'a SimulationBox,
    /// Bounds of the positions, and how many there are.
    pub bounds: (Vec3, Vec3),
    pub n: usize,
    pub precision: Precision,
    /// Pairs are to be worked out in double precision whatever the precision of the rest.
    pub double_pairs: bool,
    /// Runs of particles are longer than short entries can say.
    pub long_runs: bool,
    pub tuning: Tuning,
    /// Of the device, "sm_90".
    pub architecture: &'a str,
}

impl Plan {
    pub fn new(given: &Given<'_>) -> Self {
        let Given { program, simulation_box, bounds: (low, high), n, precision, tuning, architecture, .. } = *given;
        let cutoffs = program.pair.neighbor_cutoffs(program.policy.skin);
        let radius = cutoffs.iter().copied().fold(0.0, f64::max);
        let smallest = cutoffs.iter().copied().filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
        let grid = Grid::new(program.search, simulation_box, &low, &high, radius);
        let lengths = simulation_box.lengths();
        let mut shape = Shape::new(program, simulation_box, precision);
        shape.double_pairs |= given.double_pairs;
        shape.octants = grid.octants();
        for (axis, most) in shape.most_images.iter_mut().enumerate() {
            *most = images_of(&grid.axes[axis]);
        }

        // Fixed-point coordinates: around with the box where that is fine enough, else as fine as candidates allow.
        let most =
            grid.axes.iter().map(|axis| axis.reach_length() + 2.0 * axis.edge).fold(0.0, f64::max) + 4.0 * radius;
        let near = 0.875 * (1u64 << 31) as f64 / most;
        let around = |axis: usize| {
            if simulation_box.periodic(axis) { (1u64 << 32) as f64 / lengths[axis] } else { near }
        };
        let goes_around = |axis: usize| {
            !simulation_box.periodic(axis)
                || (lengths[axis] >= 4.0 * radius
                    && looks_once(&grid.axes[axis])
                    && 1.0 / around(axis) <= COARSEST_QUANTUM * smallest)
        };
        let wraps = !shape.double_pairs && shape.periodic != 0 && (0..3).all(goes_around);
        let quanta: [f64; 3] = std::array::from_fn(|axis| if wraps { around(axis) } else { near });
        let coarsest = quanta.iter().copied().fold(f64::INFINITY, f64::min);
        shape.double_pairs |= 1.0 / coarsest > COARSEST_QUANTUM * smallest;
        shape.images = shape.periodic != 0 && !wraps;
        shape.scaled = quanta.iter().any(|q| *q != coarsest) && !shape.double_pairs;
        if shape.images {
            shape.index_bits = 32 - (32 - (shape.codes() - 1).leading_zeros()).max(1);
            shape.wide_entries = n as u64 > 1 << shape.index_bits;
            if shape.wide_entries {
                shape.index_bits = 32;
            }
        }

        let (table, folded) = fold(&grid, n);
        shape.folded = folded;
        let row = if shape.double_pairs { Precision::Double } else { precision };
        let choices = tuning.choices.unwrap_or_else(|| Table::built_in().choices(architecture, row, n));
        (shape.lanes, shape.group, shape.slices) = (choices.lanes, choices.group, choices.slices);
        (shape.blocks_at_least, shape.ahead) = (choices.blocks, choices.ahead);
        let cells = table.iter().map(|t| u64::from(*t)).product::<u64>();
        let buckets = cells * OCTANTS as u64;
        if tuning.choices.is_none() {
            // Where octants hold many groups (those of large cells; one cell is all that brute force has), as many warps share one.
            let groups = n as u64 / (cells << shape.octants.count_ones()) / u64::from(shape.group);
            shape.slices = shape.slices.max(1 << groups.clamp(1, MOST_SLICES).ilog2());
        }
        let (visits, visit_starts) = visits(&grid);
        // Beyond so many buckets the table of their runs would be larger than what it saves.
        shape.short_entries = choices.lanes <= MOST_SHORT_LANES
            && !given.long_runs
            && !shape.double_pairs
            && !shape.wide_entries
            && !folded
            && !shape.midplane
            && buckets <= n as u64
            && visit_starts.windows(2).all(|pair| pair[1] - pair[0] <= RUNS);
        shape.lasting = n as u64 * shape.slot().1 as u64 > CACHED_SLOTS;
        let storage = storage_bins(given, radius);
        shape.storage_sort &= storage.is_some();
        let storage_bins = storage.unwrap_or([1; 3]);
        let bins: u64 = storage_bins.iter().map(|b| u64::from(*b)).product();

        let (energy, length) = if shape.double_pairs { (1.0, 1.0) } else { program.pair.scales() };
        let unit = if shape.double_pairs { 1.0 } else { 1.0 / coarsest };
        let scaled = program.pair.scaled(energy, length);
        let squared = scaled.squared_cutoffs();
        let widest = squared.iter().copied().fold(0.0, f64::max).sqrt() * length;
        let part = tuning.inner.unwrap_or(if program.policy.skin >= WIDE_SKIN * widest { INNER_PART } else { 0.0 });
        let inner_skin = program.policy.skin * part;
        shape.inner = inner_skin > LEAST_INNER * radius;
        // The last one is the squared cutoff of the inner list.
        let near = |squared: f64| if squared > 0.0 { (squared.sqrt() + inner_skin / length).powi(2) } else { 0.0 };
        let numbers = |k: usize| {
            let mut numbers = pair_numbers(&scaled, squared[k], k);
            numbers.extend(shape.inner.then(|| near(squared[k])));
            numbers
        };
        let coefficients = (0..squared.len()).flat_map(numbers).collect();
        let coordinate =
            [simulation_box.lo, simulation_box.hi, low, high].map(|x| x.amax()).into_iter().fold(0.0, f64::max);
        let span = grid.axes.iter().map(|axis| axis.edge).fold(0.0, f64::max) + radius;
        let limit = |r: &f64| {
            let (inner, outer) = guard::limits(*r, coarsest, coordinate, span);
            Limit { inner, outer, squared: r * r }
        };
        let largest = limit(&radius);
        // Squared lengths in the units of matrix products.
        let tensor =
            |squared: f64| if radius > 0.0 { squared * (f64::from(TENSOR_REACH) / radius).powi(2) } else { 0.0 };
        let (inner, outer) = (f64::from(largest.inner), f64::from(largest.outer));
        shape.cutoffs = cutoffs.iter().any(|r| *r != radius);
        let ties = Ties::new(&cutoffs, simulation_box);
        let images = images(shape.most_images);
        let shift = |image: &[i32; 4], a: usize| f64::from(image[a]) * lengths[a];
        let exact = |image: &[i32; 4]| [shift(image, 0), shift(image, 1), shift(image, 2), 0.0];
        let fixed = |image: &[i32; 4]| {
            let shift = |a: usize| (shift(image, a) * quanta[a]).round() as i64 as i32;
            [shift(0), shift(1), shift(2), 0]
        };
        // f32 rounds the displacement that is compared.
        let slack = if shape.double_store { 1.0 } else { 1.0 - 1e-6 };
        let no_image = images.iter().position(|i| *i == [0; 4]).unwrap_or(0) as u32;
        let mut fix_parameters = [0.0; MOST_PARAMETERS_OF_ALL];
        for (to, from) in fix_parameters.iter_mut().zip(program.fixes.iter().flat_map(|fix| &fix.parameters)) {
            *to = *from;
        }
        let half_kicks = program.half_kicks();
        let scene = Scene {
            lo: simulation_box.lo.into(),
            hi: simulation_box.hi.into(),
            lengths: lengths.into(),
            bins: ties.sides.bins,
            inverse_bin: ties.sides.inverse_bin,
            grid_lo: grid.axes.map(|a| a.lo),
            inverse_edge: grid.axes.map(|a| a.inverse_edge),
            last_cell: grid.axes.map(|a| (a.cells - 1) as f64),
            border: grid.axes.map(|a| a.border),
            origin: simulation_box.lo.into(),
            quanta,
            storage_inverse: std::array::from_fn(|a| f64::from(storage_bins[a]) / lengths[a]),
            fix_parameters,
            dt: program.timestep,
            run_first: program.range.0,
            run_steps: program.range.1 - program.range.0,
            half_kick: half_kicks[0],
            trigger: program.policy.trigger() * slack,
            range: radius * radius,
            prune: (0.5 * inner_skin * (1.0 - INNER_SLACK)).powi(2),
            tie_band: ties.band,
            unit_squared: (unit / length).powi(2),
            force_unit: unit * energy / length.powi(2),
            work_unit: if shape.double_pairs { 1.0 } else { power_of_two(unit / length) },
            storage_every: program.storage_sort.map_or(1, |sort| sort.every.max(1)),
            every: program.policy.every,
            delay: program.policy.delay,
            pitch: 0,
            tensor_unit: quanta.map(|q| tensor(1.0 / q.powi(2)).sqrt() as f32),
            tensor_square: tensor(coarsest.powi(-2)) as f32,
            tensor_limit: tensor(0.5 * (inner + outer) / coarsest.powi(2)) as f32,
            // Without a cutoff everything is looked at exactly.
            tensor_band: if radius > 0.0 { tensor(0.5 * (outer - inner) / coarsest.powi(2)) as f32 } else { f32::MAX },
            scale: quanta.map(|q| (coarsest / q) as f32),
            storage_bins,
            table,
            buckets: buckets as u32,
            capacity: 0,
            images: shape.most_images.map(|m| m as i32),
            no_image,
        };
        Self {
            n,
            limits: cutoffs.iter().map(limit).collect(),
            fixed_shifts: images.iter().map(fixed).collect(),
            shifts: images.iter().map(exact).collect(),
            most_buckets: buckets.max(bins),
            shape,
            scene,
            visits,
            visit_starts,
            coefficients,
            images,
            half_kicks,
            energy,
            unit,
        }
    }
}

/// Whether a particle looks into no cell twice, in two of its images.
fn looks_once(axis: &Axis) -> bool {
    match axis.reach {
        Reach::Octant { .. } => axis.cells >= 2,
        Reach::Cells([below, above]) => axis.cells > below + above,
    }
}

/// How many edges away the images lie that particles on an axis look into.
fn images_of(axis: &Axis) -> u32 {
    let cells = match axis.reach {
        Reach::Octant { .. } => 1,
        Reach::Cells([below, above]) => below.max(above),
    };
    if axis.periodic { (cells as u64).div_ceil(axis.cells as u64).max(1) as u32 } else { 0 }
}

/// All images, the first axis fastest.
fn images(most: [u32; 3]) -> Vec<[i32; 4]> {
    let [x, y, z] = most.map(|m| m as i32);
    let mut all = Vec::new();
    for iz in -z..=z {
        for iy in -y..=y {
            all.extend((-x..=x).map(|ix| [ix, iy, iz, 0]));
        }
    }
    all
}

/// For each octant (and where particles of an octant differ in that, for each set of axes along which the own cell is enough) the
/// cells to look into, relative to the own one, each with the first of some octants one after the other
/// that are wanted of it, and their number times 8: the searches' own rules, asked in the middle of an endless grid.
fn visits(grid: &Grid) -> (Vec<[i32; 4]>, Vec<u32>) {
    const MIDDLE: i64 = 1 << 40;
    let endless = grid.axes.map(|axis| Axis { cells: 2 * MIDDLE, periodic: false, ..axis });
    let (mut all, mut starts) = (Vec::new(), vec![0]);
    let parts = if grid.midplane { OCTANTS as u8 } else { 1 };
    for (octant, middle) in (0..OCTANTS as u8).flat_map(|octant| (0..parts).map(move |middle| (octant, middle))) {
        let half = |axis: usize| octant >> axis & 1;
        let own = |axis: usize| middle >> axis & 1 != 0;
        endless[2].visits(MIDDLE, half(2), own(2), |z| {
            endless[1].visits(MIDDLE, half(1), own(1), |y| {
                endless[0].visits(MIDDLE, half(0), own(0), |x| {
                    let wanted = |o: u8| x.halves >> (o & 1) & y.halves >> (o >> 1 & 1) & z.halves >> (o >> 2) & 1;
                    let [dx, dy, dz] = [x, y, z].map(|v| (v.cell - MIDDLE) as i32);
                    let mut first = 0;
                    while let Some(begin) = (first..OCTANTS as u8).find(|o| wanted(*o) != 0) {
                        let end = (begin..OCTANTS as u8).find(|o| wanted(*o) == 0).unwrap_or(OCTANTS as u8);
                        all.push([dx, dy, dz, i32::from(begin) + i32::from(end - begin) * OCTANTS as i32]);
                        first = end;
                    }
                });
            });
        });
        starts.push(all.len() as u32);
    }
    (all, starts)
}

/// Cells of the table along each axis: those of the grid, or fewer where the grid has far more than there are particles.
fn fold(grid: &Grid, n: usize) -> ([u32; 3], bool) {
    let most = most_dense_cells(n);
    // Edges of a Z-order curve's table stay powers of two, the last axis being halved first: numbers stay below their product.
    let whole = grid.numbered();
    let mut table = whole;
    while table.iter().product::<u64>() > most {
        let largest = table.iter_mut().max().expect("there are three axes");
        *largest = largest.div_ceil(2);
    }
    (table.map(|t| t as u32), table != whole)
}

/// LAMMPS's bins along each axis, if storage order is sorted by them.
fn storage_bins(given: &Given<'_>, radius: f64) -> Option<[u32; 3]> {
    let sort = given.program.storage_sort?;
    let bin = if sort.bin > 0.0 { sort.bin } else { LAMMPS_BIN * radius };
    let bins = particles::storage_bins(given.simulation_box, bin);
    let all = bins.product();
    let wanted = sort.every > 0 && bin > 0.0 && all > 1.0 && all <= BINS_PER_PARTICLE * given.n as f64 + 4096.0;
    wanted.then(|| [bins.x as u32, bins.y as u32, bins.z as u32])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbor::SearchPlan;
    use crate::system::{RanPark, Side};

    /// Whether the table has particles of an octant (and axes along which their own cell is enough) look into an octant of the
    /// cell `away`.
    fn looks(grid: &Grid, table: &(Vec<[i32; 4]>, Vec<u32>), own: (u64, u8), away: [i32; 3], octant: u64) -> bool {
        let parts = if grid.midplane { OCTANTS } else { 1 };
        let place = own.0 as usize * parts + if grid.midplane { usize::from(own.1) } else { 0 };
        let visits = &table.0[table.1[place] as usize..table.1[place + 1] as usize];
        visits.iter().any(|visit| {
            let (first, count) = (visit[3] % OCTANTS as i32, visit[3] / OCTANTS as i32);
            visit[..3] == away && (first..first + count).contains(&(octant as i32))
        })
    }

    #[test]
    fn the_table_of_visits_misses_no_neighbor() {
        let space = SimulationBox::new(Vec3::zeros(), Vec3::repeat(20.5), [[Side::Periodic; 2]; 3]);
        let mut random = RanPark::new(17);
        for name in
            ["trimmed", "octant", "octant:2.52", "midplane:2", "midplane", "midplane:4", "standard:0.5", "standard"]
        {
            let plan: SearchPlan = name.parse().unwrap();
            let grid = Grid::new(plan, &space, &space.lo, &space.hi, 1.0);
            let table = visits(&grid);
            let place = |x: &Vec3| {
                let key = grid.key(x);
                (grid.unhash(key.octant / OCTANTS as u64), key.octant % OCTANTS as u64, key.part)
            };
            let mut spared = 0;
            for _ in 0..20_000 {
                let x = Vec3::from_fn(|_, _| 20.5 * random.uniform());
                let y = x + Vec3::from_fn(|_, _| 2.0 * random.uniform() - 1.0);
                if (y - x).norm() > 1.0 || space.outside(&y).is_some() {
                    continue;
                }
                let ((own, octant, part), (other, wanted, _)) = (place(&x), place(&y));
                let away = [0, 1, 2].map(|axis| (other[axis] - own[axis]) as i32);
                assert!(looks(&grid, &table, (octant, part), away, wanted), "{name}: {x} {y}");
                // A group looks into what any of its particles needs: the axes that all of them may leave out.
                if grid.midplane {
                    spared += u32::from(part != 0);
                    assert!((0..8).all(|others| looks(&grid, &table, (octant, part & others), away, wanted)), "{name}");
                }
            }
            assert!(spared > 1000 || !grid.midplane || plan.edge() == 2.0, "{name}: {spared}");
        }
    }
}
