//! Structs that host and device share: written once here, their CUDA C text follows from them.

use crate::dynamics::MOST_PARAMETERS_OF_ALL;

/// A type that both sides know.
pub trait Shared: Copy + Default {
    /// A declaration in CUDA C.
    fn declare(name: &str) -> String;
}

macro_rules! shared {
    ($($rust:ty => $c:literal),*) => {
        $(impl Shared for $rust {
            fn declare(name: &str) -> String {
                format!("{} {name}", $c)
            }
        })*
    };
}
shared!(f64 => "double", f32 => "float", u32 => "unsigned int", i32 => "int", u64 => "unsigned long long", i64 => "long long");

impl<T: Shared, const N: usize> Shared for [T; N]
where
    [T; N]: Default,
{
    fn declare(name: &str) -> String {
        format!("{}[{N}]", T::declare(name))
    }
}

/// A struct in Rust with its text in CUDA C; both compilers lay fields out by the rules of C.
macro_rules! layout {
    ($($(#[$meta:meta])* pub struct $name:ident { $($(#[$about:meta])* pub $field:ident: $kind:ty,)* })*) => {
        $(
            $(#[$meta])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, Default)]
            pub struct $name { $($(#[$about])* pub $field: $kind,)* }

            impl $name {
                /// The struct in CUDA C.
                pub fn text() -> String {
                    let mut text = format!("struct {} {{\n", stringify!($name));
                    $(text += &format!("    {};\n", <$kind as Shared>::declare(stringify!($field)));)*
                    let (name, bytes) = (stringify!($name), size_of::<Self>());
                    text + &format!("}};\nstatic_assert(sizeof({name}) == {bytes}, \"{name} has another size on the host\");\n")
                }
            }
        )*
    };
}

/// Names of numbers that both sides use, as constants in Rust and in CUDA C.
macro_rules! numbers {
    ($($(#[$meta:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$meta])* pub const $name: u32 = $value;)*
        /// The same in CUDA C.
        pub fn numbers_text() -> String {
            let mut text = String::new();
            $(text += &format!("#define {} {}u\n", stringify!($name), $name);)*
            text
        }
    };
}

numbers! {
    /// What comes next.
    BEGIN_MOVE = 0;
    /// Particles have moved on to the next step already.
    BEGIN_MOVED = 1;
    BEGIN_FORCE = 2;
    /// As BEGIN_FORCE, after the host has changed positions.
    BEGIN_PACK = 3;
    BEGIN_BUILD = 4;
    BEGIN_LIST = 5;
    /// Forces of the last step, with energy and virial.
    BEGIN_SUMS = 6;
    BEGIN_END = 7;
    /// Why a launch came back early: bits.
    TROUBLE_POSITION = 1;
    TROUBLE_LOST = 2;
    TROUBLE_GRID = 4;
    TROUBLE_FORCE = 8;
    TROUBLE_CAPACITY = 16;
    TROUBLE_RANGE = 32;
    TROUBLE_BOUNDS = 64;
    TROUBLE_RUNS = 128;
    /// Stages of a step, for their times.
    STAGE_OTHER = 0;
    STAGE_MODIFY = 1;
    STAGE_SORT = 2;
    STAGE_LIST = 3;
    STAGE_PAIR = 4;
    /// Sums over pairs: energy, trace of the virial, virial. A block of the sort leaves bounds in as much room.
    TOTALS = 8;
    /// Those of them that a scalar pressure takes.
    PRESSURE_TOTALS = 2;
    /// Sums of m v v.
    KINETIC = 6;
    /// All sums that an output may want, in this order.
    SUMS = TOTALS + KINETIC;
    /// Steps whose sums one launch records at most: bounds the memory for what blocks leave of them.
    MOST_RECORDS = 256;
    /// What particles came to in a step: moved too far for the list, or for fixed-point coordinates; a force that is no number.
    MARK_FAR = 1;
    MARK_RANGE = 2;
    MARK_FORCE = 4;
    /// Too far for the inner list.
    MARK_PRUNE = 8;
    /// A position that is no number.
    MARK_POSITION = 16;
    /// Steps whose marks are kept: the last one's, this one's, and the next one's to be cleared.
    MARKS = 3;
    /// Threads of a block; of the list build, where a warp has a part of the shared memory of its block, one of half of it.
    BLOCK = 256;
    LIST_BLOCK = 128;
    /// Bits of a digit of the radix sort: a thread of a block for each value.
    DIGIT_BITS = 8;
    /// The largest neighbor cutoff in units of the list build's matrix products: what lies around a group of particles fits well
    /// into numbers of half precision.
    TENSOR_REACH = 8;
    /// Runs of sorted particles that a short entry can name, and bits of the place in one.
    RUNS = 16;
    /// Lost particles of a build that the device takes out; more of them begin it on the host.
    MOST_LOST = 4096;
    PLACE_BITS = 12;
}

layout! {
    /// What kernels are to do beside steps.
    pub struct Order {
        /// The first step whose sums are to be recorded as it passes, and how many steps on the next ones are; none where
        /// that is 0. The last step of all is not recorded.
        pub record_first: i64,
        pub record_stride: i64,
        /// Energy and virial are wanted at the last step.
        pub sums: u32,
        /// The second half of the last step is to be done as well.
        pub finish: u32,
        /// The build is that of a set-up.
        pub set_up: u32,
        /// Steps follow those that are left: the last of them moves the particles on to the next.
        pub goes_on: u32,
    }

    /// What the device writes and the host reads between launches.
    pub struct Control {
        pub step: i64,
        pub next_sort: i64,
        /// Steps since the last build.
        pub ago: u64,
        pub builds: u64,
        pub dangerous: u64,
        /// Steps that are left to do.
        pub left: u64,
        /// Entries of the list, and distances tested for them.
        pub entries: u64,
        pub tests: u64,
        pub nanoseconds: [u64; 5],
        pub n: u32,
        /// Which of the two sides of what is held belongs to the last build.
        pub parity: u32,
        pub half_done: u32,
        /// Shrink-wrapped sides stand where the particles are now.
        pub bounded: u32,
        pub begin: u32,
        pub trouble: u32,
        pub sort_trouble: u32,
        /// Particles that the sort found lost, and holes to fill before it.
        pub lost: u32,
        pub holes: u32,
        /// Longest row that was asked for.
        pub wanted: u32,
        /// Work that warps have taken in the list build, beyond the first of each.
        pub taken: u32,
        pub marks: [u32; MARKS as usize],
        /// Marks of the motion that a launch has left off after.
        pub carried: u32,
        /// Which of the two words of the barrier is next.
        pub turn: u32,
        pub barrier: [u64; 2],
        /// What these stand at between kernels.
        pub met: [u64; 2],
        /// Of the last step that was concluded.
        pub sums: [f64; SUMS as usize],
        /// Steps recorded since the host looked, and the blocks whose sums there are of each.
        pub recorded: u32,
        pub record_blocks: u32,
    }

    /// Constants of a scene between two actions of the host.
    pub struct Scene {
        /// Box, length units.
        pub lo: [f64; 3],
        pub hi: [f64; 3],
        pub lengths: [f64; 3],
        /// LAMMPS's bins for ties.
        pub bins: [f64; 3],
        pub inverse_bin: [f64; 3],
        pub grid_lo: [f64; 3],
        pub inverse_edge: [f64; 3],
        pub last_cell: [f64; 3],
        /// Part of a cell next to a side within which particles look beyond it.
        pub border: [f64; 3],
        /// Fixed-point coordinates are (x - origin) quanta.
        pub origin: [f64; 3],
        pub quanta: [f64; 3],
        pub storage_inverse: [f64; 3],
        pub fix_parameters: [f64; MOST_PARAMETERS_OF_ALL],
        pub dt: f64,
        pub half_kick: f64,
        /// First step of the run and the steps to its end, for what changes with time.
        pub run_first: i64,
        pub run_steps: i64,
        /// Squared displacement that calls for a build, and that fixed-point coordinates stand.
        pub trigger: f64,
        pub range: f64,
        /// Squared displacement that calls for a new inner list.
        pub prune: f64,
        pub tie_band: f64,
        /// Square of a unit of pair differences in the square of the table's length, and the unit of forces.
        pub unit_squared: f64,
        pub force_unit: f64,
        /// What forces are multiplied by for the virial where pairs are in fixed point: a unit of pair differences in the
        /// table's length, to a power of two.
        pub work_unit: f64,
        pub storage_every: i64,
        pub every: u64,
        pub delay: u64,
        /// Entries of a column.
        pub pitch: u64,
        /// Units of an axis's fixed-point differences in those of the coarsest axis.
        pub scale: [f32; 3],
        /// Fixed-point units in those of the list build's matrix products, squares of the coarsest axis's, and there the largest
        /// squared cutoff and half the width of the band in which f32 arithmetic must not decide.
        pub tensor_unit: [f32; 3],
        pub tensor_square: f32,
        pub tensor_limit: f32,
        pub tensor_band: f32,
        pub storage_bins: [u32; 3],
        /// Cells of the table.
        pub table: [u32; 3],
        pub buckets: u32,
        /// Longest row there is room for.
        pub capacity: u32,
        /// Periodic images that are seen, to each side.
        pub images: [i32; 3],
        pub no_image: u32,
    }

    /// Squared neighbor cutoff of a pair of types: certainly inside, certainly outside (in fixed-point units), exact.
    pub struct Limit {
        pub inner: f32,
        pub outer: f32,
        pub squared: f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_stand_in_the_text_in_order() {
        let text = Limit::text();
        assert!(
            text.starts_with("struct Limit {\n    float inner;\n    float outer;\n    double squared;\n};\n"),
            "{text}"
        );
        assert!(text.contains("static_assert(sizeof(Limit) == 16,"), "{text}");
        assert!(Scene::text().contains("double lo[3];"));
        assert!(numbers_text().contains("#define BEGIN_LIST 5u"));
    }
}
