//! The arrays on the device: which a scene has, how many entries each, and the struct that kernels find them in.

#[cfg(doc)]
use super::layout::RUNS;
use super::layout::{BLOCK, SUMS};
use super::shape::Shape;

/// What an array's length goes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// Columns of one entry a particle.
    Columns(usize),
    /// One entry a bucket and one more.
    Buckets,
    /// Entries for each block of the grid.
    Blocks(usize),
    /// [`RUNS`] entries a bucket.
    Runs,
    /// Entries for each step that a launch may record; for each block of the grid as well.
    Records(usize),
    RecordBlocks(usize),
    /// The list.
    List,
    /// As many as there are values for it.
    Values,
}

/// One array.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    pub name: &'static str,
    /// Type of an entry in CUDA C, and its bytes.
    pub entry: (&'static str, usize),
    pub count: Count,
}

/// The arrays of a scene, in the order of the struct; one that a scene does not use is not there.
pub fn arrays(shape: &Shape) -> Vec<Array> {
    use Count::{Blocks, Buckets, Columns, List, RecordBlocks, Records, Runs, Values};
    let store = shape.store();
    let real = shape.real();
    let slot = shape.slot();
    let (u32, u64, int, int4, double) = (("u32", 4), ("u64", 8), ("int", 4), ("int4", 16), ("double", 8));
    let all = [
        (true, "control", ("Control", 0), Values),
        // As they move.
        (true, "x", store, Columns(3)),
        (true, "v", store, Columns(3)),
        (true, "f", real, Columns(3)),
        (true, "slots", slot, Columns(2)),
        // As the last build left them, and where the next one goes.
        (true, "held_x", double, Columns(6)),
        (true, "held_v", store, Columns(6)),
        (true, "held_image", int, Columns(6)),
        (true, "held_id", u32, Columns(2)),
        (true, "held_source", u32, Columns(2)),
        (shape.homes(), "held_home", u32, Columns(2)),
        (shape.types > 1, "held_kind", u32, Columns(2)),
        (shape.groups, "held_mask", u32, Columns(2)),
        (true, "fixed", int4, Columns(1)),
        // Of the sort.
        (true, "bucket", u32, Columns(1)),
        (true, "tie", u64, Columns(1)),
        (!shape.radix, "arrival", u32, Columns(1)),
        // Before and after a digit is sorted by; how often each has its values, and where these go.
        (shape.radix, "digit_bucket", u32, Columns(2)),
        (shape.radix, "digit_particle", u32, Columns(2)),
        (shape.radix, "digit_counts", u32, Blocks(BLOCK as usize + 1)),
        (shape.radix, "digit_starts", u32, Blocks(BLOCK as usize + 1)),
        (true, "dealt", u32, Columns(1)),
        (true, "dealt_tie", u64, Columns(1)),
        (true, "order", u32, Columns(1)),
        (shape.folded, "cell", u64, Columns(1)),
        (shape.storage_sort, "new_home", u32, Columns(1)),
        // Who is lost, and what fills the holes.
        (shape.loses, "losses", u32, Values),
        (true, "counts", u32, Buckets),
        (true, "starts", u32, Buckets),
        (true, "block_counts", u32, Blocks(1)),
        (true, "block_sums", double, Blocks(SUMS as usize)),
        (true, "record_sums", double, RecordBlocks(SUMS as usize)),
        (true, "records", double, Records(SUMS as usize)),
        // Of thermostats: what they keep, before and after a step in turns; kinetic energies of their groups, twice.
        (shape.thermostats > 0, "baths", double, Values),
        (shape.thermostats > 0, "group_sums", double, Blocks(shape.thermostats)),
        // Constants.
        (true, "visits", int4, Values),
        (true, "visit_starts", u32, Values),
        (true, "limits", ("Limit", 16), Values),
        (true, "coefficients", real, Values),
        (true, "masses", double, Values),
        (true, "half_kicks", store, Values),
        (shape.images, "fixed_shifts", int4, Values),
        (shape.images && shape.double_pairs, "shifts", slot, Values),
        (shape.images && shape.double_pairs, "images", int4, Values),
        // The list.
        (true, "neighbors", u32, Columns(1)),
        // Of short entries: the octant of each particle, and first entries of the runs that its particles see.
        (shape.short_entries, "homes", u32, Columns(1)),
        (shape.short_entries, "runs", u32, Runs),
        (true, "list", ("Chunk", shape.entry()), List),
        // The inner list, entries that each thread of a row has there, and displacements since the build when it was made.
        (shape.inner, "inner", ("Chunk", shape.entry()), List),
        (shape.inner, "kept", u32, Columns(shape.lanes as usize)),
        (shape.inner, "pruned", ("float", 4), Columns(3)),
    ];
    all.into_iter().filter(|(there, ..)| *there).map(|(_, name, entry, count)| Array { name, entry, count }).collect()
}

/// The struct in CUDA C.
pub fn text(shape: &Shape) -> String {
    let fields = arrays(shape).into_iter().map(|a| format!("    {}* {};\n", a.entry.0, a.name));
    format!("struct Arrays {{\n{}}};\n", fields.collect::<String>())
}
