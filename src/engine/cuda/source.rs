//! The CUDA C of a scene: generated types, constants and formulas, then the stages from `kernels/`.

use super::arrays;
use super::fixes::{bath_numbers, fix_formulas};
use super::layout::{Control, Limit, Order, Scene, numbers_text};
use super::shape::Shape;
use crate::engine::Program;
use crate::neighbor::OCTANTS;
use crate::neighbor::axis::{in_cells, locate, middle};
use crate::neighbor::search::{APART, CELL_BITS, PART_BITS, SPREAD, row_major};
use crate::neighbor::ties::{TieBox, hold, is_tied, tied_squared_distance};
use crate::pair::truncation::{Cut, Shifted, Truncation};
use crate::pair::{PairStyle, PairTable, StyleVisitor, with_style};
use crate::real::{Arithmetic, Expr, Recording};
use crate::system::simulation_box::wrap_once;

/// A file of `kernels/`: its name and its text.
type Stage = (&'static str, &'static str);

const GRID: Stage = ("kernels/grid.cuh", include_str!("../../../kernels/grid.cuh"));
const THERMOSTATS: Stage = ("kernels/thermostats.cuh", include_str!("../../../kernels/thermostats.cuh"));
const SUMS: Stage = ("kernels/sums.cuh", include_str!("../../../kernels/sums.cuh"));
const MOTION: Stage = ("kernels/motion.cuh", include_str!("../../../kernels/motion.cuh"));
const CELLS: Stage = ("kernels/cells.cuh", include_str!("../../../kernels/cells.cuh"));
const SCAN: Stage = ("kernels/scan.cuh", include_str!("../../../kernels/scan.cuh"));
const RADIX: Stage = ("kernels/radix.cuh", include_str!("../../../kernels/radix.cuh"));
const LOSSES: Stage = ("kernels/losses.cuh", include_str!("../../../kernels/losses.cuh"));
const SORT: Stage = ("kernels/sort.cuh", include_str!("../../../kernels/sort.cuh"));
const PRODUCTS: Stage = ("kernels/products.cuh", include_str!("../../../kernels/products.cuh"));
const SEARCH: Stage = ("kernels/search.cuh", include_str!("../../../kernels/search.cuh"));
const ROWS: Stage = ("kernels/rows.cuh", include_str!("../../../kernels/rows.cuh"));
const FORCE: Stage = ("kernels/force.cuh", include_str!("../../../kernels/force.cuh"));
const SORT_KERNEL: Stage = ("kernels/sort.cu", include_str!("../../../kernels/sort.cu"));
const LIST_KERNEL: Stage = ("kernels/list.cu", include_str!("../../../kernels/list.cu"));
const ADVANCE: Stage = ("kernels/advance.cu", include_str!("../../../kernels/advance.cu"));
const CONCLUDE: Stage = ("kernels/conclude.cu", include_str!("../../../kernels/conclude.cu"));
const RECORDS: Stage = ("kernels/records.cu", include_str!("../../../kernels/records.cu"));

/// Kernels that are compiled together.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Unit {
    /// Names of the kernels.
    pub kernels: &'static [&'static str],
    /// CUDA C.
    pub text: String,
}

/// 1 / x to a unit in the last place. In double precision in a quarter of the instructions of a division: an estimate of 20 bits,
/// made exact by two steps of Newton's method. In single precision without care for numbers below 1e-38.
const RECIPROCAL: &str = "__device__ __forceinline__ double reciprocal(double x) {
    double y;
    asm(\"rcp.approx.ftz.f64 %0, %1;\" : \"=d\"(y) : \"d\"(x));
    y = fma(fma(-x, y, 1.0), y, y);
    return fma(fma(-x, y, 1.0), y, y);
}
__device__ __forceinline__ float reciprocal(float x) {
    float y;
    asm(\"rcp.approx.ftz.f32 %0, %1;\" : \"=f\"(y) : \"f\"(x));
    return y;
}
";

/// Numbers of a pair of types, in the order of the generated formula: squared cutoff, the style's, the truncation's.
pub fn pair_numbers(table: &PairTable, cutoff_squared: f64, pair: usize) -> Vec<f64> {
    struct Numbers<'a>(&'a PairTable, f64, usize);
    impl StyleVisitor for Numbers<'_> {
        type Output = Vec<f64>;
        fn visit<S: PairStyle>(self) -> Vec<f64> {
            let Numbers(table, cutoff_squared, pair) = self;
            let pair = &table.pairs[pair];
            let mut numbers = vec![cutoff_squared];
            let mut add = |x: f64| {
                numbers.push(x);
                x
            };
            S::map(&S::params(&pair.coefficients, &table.settings, pair.cutoff), &mut add);
            if table.shift {
                Shifted::map(&Shifted::params(pair.energy_at_cutoff), &mut add);
            }
            numbers
        }
    }
    with_style(table.style, Numbers(table, cutoff_squared, pair)).expect("the scene names a registered pair style")
}

/// The kernels of a scene, in parts that are compiled side by side.
pub fn units(program: &Program, shape: &Shape) -> Vec<Unit> {
    let common = common(program, shape);
    let with_pairs = format!("{common}{}", pair_formulas(&program.pair, shape));
    vec![
        // Builds know nothing of the potential: scenes that differ in it alone share them.
        unit(&["sort"], &common, &[CELLS, SCAN, RADIX, LOSSES, SORT, SORT_KERNEL]),
        unit(&["list"], &common, &[CELLS, PRODUCTS, SEARCH, LIST_KERNEL]),
        unit(&["conclude"], &with_pairs, &[ROWS, FORCE, CONCLUDE]),
        unit(&["advance"], &with_pairs, &[ROWS, FORCE, ADVANCE]),
    ]
}

/// The kernels that record sums of steps as they pass, for scenes whose outputs are close to each other; of the virial its trace
/// alone, or all of it.
pub fn recording_unit(program: &Program, shape: &Shape, tensor: bool) -> Unit {
    let switches = if tensor { "#define RECORDS\n#define TENSOR\n" } else { "#define RECORDS\n" };
    let common = common(program, shape) + &pair_formulas(&program.pair, shape) + switches;
    unit(&["advance_recording", "sum_records"], &common, &[ROWS, FORCE, ADVANCE, RECORDS])
}

fn unit(kernels: &'static [&'static str], common: &str, stages: &[Stage]) -> Unit {
    let stages = [GRID, SUMS, THERMOSTATS, MOTION].into_iter().chain(stages.iter().copied());
    let stages: String = stages.map(|(name, stage)| format!("#line 1 \"{name}\"\n{stage}")).collect();
    Unit { kernels, text: format!("{common}{stages}") }
}

/// What all units begin with.
fn common(program: &Program, shape: &Shape) -> String {
    let mut text = defines(program, shape);
    text += &numbers_text();
    text += &format!("typedef {} store;\ntypedef {} real;\n", shape.store().0, shape.real().0);
    text += if shape.wide_entries { "typedef unsigned long long Entry;\n" } else { "typedef unsigned int Entry;\n" };
    text += "typedef unsigned int u32;\ntypedef unsigned long long u64;\ntypedef long long i64;\n";
    text += if shape.short_entries { "typedef unsigned short Stored;\n" } else { "typedef Entry Stored;\n" };
    text += "struct __align__(16) Chunk { Stored entry[CHUNK]; };\n";
    if shape.double_pairs {
        text += "struct __align__(16) Slot { double x, y, z, w; };\n";
    } else {
        text += "typedef int4 Slot;\n";
    }
    text += RECIPROCAL;
    for layout in [Control::text(), Order::text(), Scene::text(), Limit::text(), arrays::text(shape)] {
        text += &layout;
    }
    text += &fix_formulas(&program.fixes, shape);
    text += &rules(shape);
    text
}

fn defines(program: &Program, shape: &Shape) -> String {
    let values = [
        ("TYPES", shape.types),
        ("PERIODIC", shape.periodic as usize),
        ("INDEX_BITS", shape.index_bits as usize),
        ("LANES", shape.lanes as usize),
        ("OCTANTS", OCTANTS),
        ("DIVIDED", shape.octants as usize),
        ("PART_BITS", PART_BITS as usize),
        ("CELL_BITS", CELL_BITS as usize),
        ("BRICK", shape.brick as usize),
        ("GROUP", shape.group as usize),
        ("SLICES", shape.slices as usize),
        ("BLOCKS_AT_LEAST", shape.blocks_at_least as usize),
        ("CHUNK", shape.chunk() as usize),
        ("AHEAD", shape.ahead as usize),
    ];
    let switches = [
        ("FIXED", !shape.double_pairs),
        ("DISPLACEMENTS", !shape.double_store),
        ("IMAGES", shape.images),
        ("SCALED", shape.scaled),
        ("FOLDED", shape.folded),
        ("CURVE", shape.curve),
        ("RADIX", shape.radix),
        ("SHORT", shape.short_entries),
        ("INNER", shape.inner),
        ("LASTING", shape.lasting),
        ("COMPACT", shape.compact),
        ("MIDPLANE", shape.midplane),
        ("CUTOFFS", shape.cutoffs),
        ("REBUILDS", shape.rebuilds),
        ("CHECK", shape.check),
        ("STORAGE_SORT", shape.storage_sort),
        ("HOMES", shape.homes()),
        ("LOSES", shape.loses),
        ("SHRINKS", shape.shrinks),
        ("MASSES", shape.masses),
        ("GROUPS", shape.groups),
        ("COORDINATES", shape.coordinates),
        ("FORCES", shape.forces),
        ("NOISE", shape.noise),
    ];
    let mut text: String = values.iter().map(|(name, value)| format!("#define {name} {value}\n")).collect();
    if shape.thermostats > 0 {
        text += &format!("#define THERMOSTATS {}\n#define BATHS {}\n", shape.thermostats, bath_numbers(&program.fixes));
    }
    text += &switches.iter().filter(|s| s.1).map(|(name, _)| format!("#define {name}\n")).collect::<String>();
    text
}

/// How many numbers a pair of types has; `pair_force` and `pair_both`: the style's formula with its truncation.
fn pair_formulas(table: &PairTable, shape: &Shape) -> String {
    struct Trace<'a>(&'a PairTable, Arithmetic);
    impl StyleVisitor for Trace<'_> {
        type Output = String;
        fn visit<S: PairStyle>(self) -> String {
            if self.0.shift { trace::<S, Shifted>(self.0, self.1) } else { trace::<S, Cut>(self.0, self.1) }
        }
    }
    fn trace<S: PairStyle, T: Truncation>(table: &PairTable, arithmetic: Arithmetic) -> String {
        let tape = Recording::start();
        let pair = &table.pairs[0];
        let mut next = 0;
        let mut input = |_: f64| {
            next += 1;
            tape.input(format!("p[{next}]"))
        };
        let style = S::map(&S::params(&pair.coefficients, &table.settings, pair.cutoff), &mut input);
        let truncation = T::map(&T::params(pair.energy_at_cutoff), &mut input);
        let value = T::apply(S::eval(tape.input("r2"), &style), &truncation);
        let (force, energy) = (("*force", value.force_over_r), ("*energy", value.energy));
        format!(
            "// {}: force over distance, energy.\n\
             __device__ __forceinline__ void pair_force(real r2, const real* p, real* force) {{\n{}}}\n\
             __device__ __forceinline__ void pair_both(real r2, const real* p, real* force, real* energy) {{\n{}}}\n",
            S::FORMULA,
            tape.print(&[force], arithmetic, "t"),
            tape.print(&[force, energy], arithmetic, "t"),
        )
    }
    let arithmetic = if shape.double_pairs { Arithmetic::F64 } else { Arithmetic::F32 };
    let numbers = pair_numbers(table, 0.0, 0).len() + usize::from(shape.inner);
    let formulas = with_style(table.style, Trace(table, arithmetic)).expect("the scene names a registered pair style");
    format!("#define NUMBERS {numbers}\n{formulas}")
}

/// Rules of cells and distances that host and device must round alike.
fn rules(shape: &Shape) -> String {
    let three = |tape: &Recording, name: &str| std::array::from_fn(|a| tape.input(format!("{name}[{a}]")));
    let tape = Recording::start();
    let [x, lo, inverse_edge, last] = ["x", "lo", "inverse_edge", "last"].map(|name| tape.input(name));
    let place = in_cells(x, lo, inverse_edge);
    let (cell, eighth) = locate(x, lo, inverse_edge, last);
    let arguments =
        "double x, double lo, double inverse_edge, double last, double* place, double* cell, double* eighth";
    let mut text = rule("void locate", arguments, &tape, &[("*place", place), ("*cell", cell), ("*eighth", eighth)]);
    text += &format!("__constant__ const u32 SPREAD[8] = {{{}}};\n", SPREAD.map(|bits| bits.to_string()).join(", "));
    if shape.midplane {
        let tape = Recording::start();
        let [place, cell, border] = ["place", "cell", "border"].map(|name| tape.input(name));
        let arguments = "double place, double cell, double border, double* middle";
        text += &rule("void is_middle", arguments, &tape, &[("*middle", middle(place, cell, border))]);
    }
    let tape = Recording::start();
    let number = row_major(three(&tape, "cell"), three(&tape, "cells"));
    text += &rule(
        "void row_major",
        "const double cell[3], const double cells[3], double* number",
        &tape,
        &[("*number", number)],
    );
    if shape.curve {
        let steps: String =
            APART.iter().map(|(by, mask)| format!("    x = (x | x << {by}) & {mask:#x}ull;\n")).collect();
        text += &format!("__device__ __forceinline__ u64 apart(u64 x) {{\n{steps}    return x;\n}}\n");
    }
    let tape = Recording::start();
    let (wrapped, images) = wrap_once(tape.input("x"), tape.input("lo"), tape.input("hi"));
    let arguments = "double x, double lo, double hi, double* wrapped, double* images";
    text += &rule("void wrap_once", arguments, &tape, &[("*wrapped", wrapped), ("*images", images)]);

    let sides = |tape: &Recording| TieBox {
        lo: three(tape, "s.lo"),
        hi: three(tape, "s.hi"),
        lengths: three(tape, "s.lengths"),
        bins: three(tape, "s.bins"),
        inverse_bin: three(tape, "s.inverse_bin"),
    };
    let most = shape.most_images;
    let pair = "const double i[3], const double j[3], const double image[3], const Scene& s";
    let tape = Recording::start();
    let limit = (tape.input("limit"), tape.input("s.tie_band"));
    let held = hold(&sides(&tape), three(&tape, "i"), three(&tape, "j"), three(&tape, "image"), limit, most);
    let arguments = format!("{pair}, double limit, double* held");
    text += &rule("void hold", &arguments, &tape, &[("*held", held)]);
    if shape.double_pairs && shape.periodic != 0 {
        let tape = Recording::start();
        let tied = is_tied(tape.input("squared"), tape.input("limit"), tape.input("band"));
        text +=
            &rule("void is_tied", "double squared, double limit, double band, double* tied", &tape, &[("*tied", tied)]);
        let tape = Recording::start();
        let (i, j, image) = (three(&tape, "i"), three(&tape, "j"), three(&tape, "image"));
        let squared = tied_squared_distance(&sides(&tape), i, j, image, most);
        let arguments = format!("{pair}, double* squared");
        // Rarely called: its registers are not those of the loop.
        text += &rule("void tied_squared_distance", &arguments, &tape, &[("*squared", squared)])
            .replace("__forceinline__", "__noinline__");
    }
    text
}

/// A function whose body a recording holds, with the rounding of the host.
fn rule(name: &str, arguments: &str, tape: &Recording, outputs: &[(&str, Expr)]) -> String {
    let body = tape.print(outputs, Arithmetic::F64Exact, "t");
    format!("__device__ __forceinline__ {name}({arguments}) {{\n{body}}}\n")
}
