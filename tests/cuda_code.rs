//! What is in the intermediate code of CUDA kernels and what is not, and how errors in a source are shown; without a GPU.
#![cfg(feature = "cuda")]

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

mod common;
#[path = "common/kernels.rs"]
mod kernels;

use common::{melt, program, program_of_style};
use kernels::{gas, is_there};

use octant::engine::cuda::inspect::{arguments_of, inspect, recording_unit_of, units_of};
use octant::engine::cuda::ptx::{bytes, double_instructions, entries, moves, opcodes, pair_loops, step_content};
use octant::engine::{Precision, Program};
use octant::neighbor::Search;
use octant::system::{Side, SimulationBox, State};

/// Intermediate code alone, for the second oldest architecture that is tested: the same for all of them but for the header.
const VIRTUAL: &str = "compute_80";

/// Tests and scenes share many texts; each is compiled once.
fn compiled(text: &str) -> String {
    static KNOWN: Mutex<BTreeMap<String, Arc<OnceLock<String>>>> = Mutex::new(BTreeMap::new());
    let cell = KNOWN.lock().unwrap().entry(text.to_string()).or_default().clone();
    cell.get_or_init(|| inspect(text, VIRTUAL).unwrap().ptx).clone()
}

fn ptx_of(program: &Program, (state, space): &(State, SimulationBox), precision: Precision) -> String {
    let units = units_of(program, state, space, precision);
    units.iter().map(|unit| compiled(&unit.text)).collect()
}

fn recording_ptx(program: &Program, scene: &(State, SimulationBox), precision: Precision, tensor: bool) -> String {
    let (state, space) = scene;
    compiled(&recording_unit_of(program, state, space, precision, tensor).text)
}

/// Lennard-Jones particles of so many types; with one type coordinates go around with the box.
fn lennard_jones(types: usize) -> Program {
    program(&[2.5, 2.0][..types], 0.3, Search::Trimmed)
}

/// Opcodes of the shortest pair loop, which is that without energy and virial.
fn force_loop(ptx: &str) -> Vec<String> {
    let loops = pair_loops(ptx);
    let shortest = loops.iter().min_by_key(|text| opcodes(text).count()).expect("pair loops are marked");
    opcodes(shortest).map(String::from).collect()
}

/// Those of the longest one, with energy and virial.
fn sums_loop(ptx: &str) -> Vec<String> {
    let loops = pair_loops(ptx);
    let longest = loops.iter().max_by_key(|text| opcodes(text).count()).expect("pair loops are marked");
    opcodes(longest).map(String::from).collect()
}

/// Operations among opcodes that round their result, sorted.
fn arithmetic(opcodes: Vec<String>) -> Vec<String> {
    let rounds = |opcode: &String| {
        let is_float = opcode.ends_with(".f32") || opcode.ends_with(".f64");
        is_float && ["add.", "sub.", "mul.", "fma.", "rcp."].iter().any(|operation| opcode.starts_with(operation))
    };
    let mut all: Vec<String> = opcodes.into_iter().filter(rounds).collect();
    all.sort();
    all
}

/// How many lines of a text stand above a line.
fn lines_before(text: &str, line: &str) -> usize {
    text.lines().position(|l| l == line).unwrap_or_else(|| panic!("no line {line}"))
}

#[test]
fn errors_show_the_line_of_the_source() {
    if !is_there() {
        return;
    }
    let (state, space) = melt(4);
    let units = units_of(&lennard_jones(1), &state, &space, Precision::Mixed);
    let source = &units.iter().find(|unit| unit.kernels.contains(&"advance")).expect("every scene advances").text;
    // Broken at the end of a stage, and at the end of what is generated.
    let (force, advance) = ("#line 1 \"kernels/force.cuh\"", "#line 1 \"kernels/advance.cu\"");
    let grid = "#line 1 \"kernels/grid.cuh\"";
    let stage = lines_before(source, advance) - lines_before(source, force);
    for (before, file, line) in
        [(advance, "kernels/force.cuh", stage), (grid, "octant.cu", lines_before(source, grid) + 1)]
    {
        let broken = source.replace(before, &format!("int broken = nowhere;\n{before}"));
        let error = inspect(&broken, VIRTUAL).err().expect("the source is broken").to_string();
        assert!(error.contains(&format!("{file}({line}): error")), "{error}");
        assert!(error.contains(&format!("\n{line:>6} | int broken = nowhere;\n")), "{error}");
    }
}

#[test]
fn wide_skins_have_an_inner_list_and_long_rows_short_entries() {
    let defines = |skin: f64, (state, space): &(State, SimulationBox), precision: Precision| {
        let units = units_of(&program(&[2.5], skin, Search::Trimmed), state, space, precision);
        let has = |name: &str| units[0].text.contains(&format!("#define {name}\n"));
        (has("INNER"), has("SHORT"))
    };
    let (few, many) = (melt(10), melt(22));
    for precision in Precision::ALL {
        let short = precision != Precision::Double;
        assert_eq!(defines(0.3, &few, precision), (false, false), "{precision:?}");
        assert_eq!(defines(0.8, &few, precision), (true, false), "{precision:?}");
        assert_eq!(defines(0.3, &many, precision), (false, short), "{precision:?}");
        assert_eq!(defines(0.8, &many, precision), (true, short), "{precision:?}");
        // Fewer particles than octants.
        assert_eq!(defines(0.3, &gas(40_000, 150.0, Side::Periodic), precision), (false, false), "{precision:?}");
    }
}

#[test]
fn entry_points_take_what_the_host_gives() {
    if !is_there() {
        return;
    }
    let mut other = lennard_jones(2);
    other.fixes[0].group = 4;
    for (program, scene) in [(lennard_jones(1), melt(10)), (other, gas(500, 9.0, Side::Periodic))] {
        for precision in Precision::ALL {
            let mut found = entries(&ptx_of(&program, &scene, precision));
            found.extend(entries(&recording_ptx(&program, &scene, precision, true)));
            found.sort();
            let mut wanted: Vec<(String, Vec<usize>)> = arguments_of(&program, &scene.0, &scene.1, precision);
            wanted.sort();
            assert_eq!(found, wanted, "{precision:?}");
        }
    }
}

#[test]
fn few_types_load_the_list_and_slots_alone() {
    if !is_there() {
        return;
    }
    for (precision, slot) in [(Precision::Single, 16), (Precision::Mixed, 16), (Precision::Double, 32)] {
        // Free sides: no image is looked up either.
        let scene = gas(500, 20.0, Side::Fixed);
        let one = step_content(&ptx_of(&lennard_jones(1), &scene, precision));
        let alone = one.entries * (4 + slot);
        assert_eq!((one.force.bytes, one.sums.bytes), (alone, alone), "{precision:?}");
        // The cutoff and two coefficients of each pair of types; of two types registers hold them, but for those in f64.
        let (real, held) = if precision == Precision::Double { (8, 1) } else { (4, 2) };
        for types in [2, 3] {
            let program = program(&[2.5, 2.0, 2.2][..types], 0.3, Search::Trimmed);
            let found = step_content(&ptx_of(&program, &scene, precision));
            let numbers = if types <= held { 0 } else { found.entries * 3 * real };
            let expected = found.entries * (4 + slot) + numbers;
            let right = if types <= held { found.force.bytes == expected } else { found.force.bytes >= expected };
            assert!(right, "{precision:?}, {types} types: {found:?}");
        }
    }
}

#[test]
fn atomics_are_on_integers_and_outside_of_loops_over_pairs() {
    if !is_there() {
        return;
    }
    // What barriers say of their order with other reads and writes.
    const BARRIER: &str = ".relaxed.";
    // Of whole numbers the order does not show in the result. A compiler may say `red` where the old value is not wanted.
    let expected = ["add.u32", "add.u64", "or.b32", "max.u32"];
    let is_atomic = |opcode: &&str| opcode.starts_with("atom.") || opcode.starts_with("red.");
    for precision in Precision::ALL {
        let ptx = ptx_of(&lennard_jones(2), &melt(10), precision);
        let atomics: Vec<&str> = opcodes(&ptx).filter(is_atomic).collect();
        let known = |opcode: &&str| expected.iter().any(|e| opcode.ends_with(&format!(".{e}")));
        assert!(atomics.iter().all(known), "{precision:?}: {atomics:?}");
        // Barriers; particles of an octant; entries and tests, the longest row; displacements and three kinds of trouble.
        let count = |kind: &str| {
            let plain = atomics.iter().filter(|opcode| !opcode.contains(BARRIER));
            plain.filter(|opcode| opcode.ends_with(kind)).count()
        };
        assert_eq!((count("add.u64"), count("max.u32")), (2, 1), "{precision:?}: {atomics:?}");
        for part in [pair_loops(&ptx), moves(&ptx)].concat() {
            assert_eq!(opcodes(&part).find(is_atomic), None, "{precision:?}");
        }
    }
}

#[test]
fn energy_and_virial_are_worked_out_where_they_are_wanted() {
    if !is_there() {
        return;
    }
    for style in octant::pair::styles() {
        let program = program_of_style(&style, true, 1.0, 1.0);
        for precision in Precision::ALL {
            let ptx = ptx_of(&program, &gas(2000, 30.0, Side::Periodic), precision);
            // An entry adds to one energy, six terms of the virial and their trace.
            let more = step_content(&ptx).entries * 8;
            let (force, sums) = (arithmetic(force_loop(&ptx)).len(), arithmetic(sums_loop(&ptx)).len());
            assert!(force > 0 && force + more <= sums, "{}, {precision:?}: {force}, {sums}", style.name);
        }
    }
}

#[test]
fn a_step_is_recorded_beside_those_that_are_not() {
    if !is_there() {
        return;
    }
    let without = |all: &[String], fewer: &[String]| {
        let mut rest = all.to_vec();
        for opcode in fewer {
            rest.remove(rest.iter().position(|o| o == opcode).unwrap_or_else(|| panic!("{opcode} is one too many")));
        }
        rest
    };
    for (precision, real) in [(Precision::Single, "f32"), (Precision::Mixed, "f32"), (Precision::Double, "f64")] {
        let (program, scene) = (lennard_jones(1), melt(10));
        let others = ptx_of(&program, &scene, precision);
        let (plain, kept) = (arithmetic(force_loop(&others)), arithmetic(sums_loop(&others)));
        for tensor in [false, true] {
            let recording = recording_ptx(&program, &scene, precision, tensor);
            // Steps on the way are rounded as in the other kernels, whether they are recorded or not: which of them ran must
            // not show in a bit. Without the tensor there are three products and six sums of them less.
            assert_eq!(arithmetic(force_loop(&recording)), plain, "{precision:?}");
            let less = if tensor { 0 } else { step_content(&others).entries };
            let tensor_alone = without(&kept, &arithmetic(sums_loop(&recording)));
            let (sums, products) = (vec![format!("fma.rn.{real}"); 6 * less], vec![format!("mul.{real}"); 3 * less]);
            assert_eq!(tensor_alone, [sums, products].concat(), "{precision:?}");
            let moves = moves(&recording);
            // Three products with the mass, six that are added.
            let kinetic = |text: &String| double_instructions(text) >= step_content(&others).moving.doubles + 9;
            assert!(moves.iter().any(kinetic) && moves.iter().any(|text| !kinetic(text)), "{precision:?}");
        }
    }
}

#[test]
fn doubles_are_where_the_precision_has_them() {
    if !is_there() {
        return;
    }
    for (types, scene) in [(1, melt(10)), (2, melt(10)), (1, melt(2)), (1, gas(500, 20.0, Side::Fixed))] {
        let of = |precision| {
            let ptx = ptx_of(&lennard_jones(types), &scene, precision);
            let divisions = force_loop(&ptx).into_iter().filter(|opcode| is_slow(opcode)).collect::<Vec<_>>();
            assert!(divisions.is_empty(), "{precision:?}: {divisions:?}");
            step_content(&ptx)
        };
        let (single, mixed, double) = (of(Precision::Single), of(Precision::Mixed), of(Precision::Double));
        assert_eq!((single.force.doubles, mixed.force.doubles), (0, 0));
        // Behind the loop with sums a row's are added up: a few conversions and additions may be drawn into it.
        assert!(single.sums.doubles <= 14 && mixed.sums.doubles <= 14, "{single:?} {mixed:?}");
        // Three differences and their square, two of force, three sums.
        assert!(double.force.doubles >= double.entries * 10, "{double:?}");
        // Two kicks and a drift an axis, each an addition at least; in single precision coordinates are displacements in f32.
        assert_eq!(single.moving.doubles, 0, "{single:?}");
        assert!(mixed.moving.doubles >= 9 && double.moving.doubles >= 9, "{mixed:?} {double:?}");
    }
    // x and v read and written, the last build's x read, a slot written; the force comes from the pair loop.
    let bytes_of = |precision| step_content(&ptx_of(&lennard_jones(1), &melt(10), precision)).moving.bytes;
    assert_eq!(bytes_of(Precision::Mixed), 12 * 8 + 3 * 8 + 16);
    assert_eq!(bytes_of(Precision::Double), 12 * 8 + 3 * 8 + 32);
    // x and v read and written, the last build's slot read, a slot written.
    assert_eq!(bytes_of(Precision::Single), 12 * 4 + 16 + 16);
}

/// Divisions and square roots in f64 with correct rounding: dozens of instructions each, or a call.
fn is_slow(opcode: &str) -> bool {
    opcode.ends_with(".f64") && [".rn", ".rz", ".rm", ".rp"].iter().any(|rounding| opcode.contains(rounding)) && {
        ["div.", "rcp.", "sqrt."].iter().any(|operation| opcode.starts_with(operation))
    }
}

#[test]
fn displacements_are_compared_where_builds_depend_on_them() {
    if !is_there() {
        return;
    }
    let mut unchecked = lennard_jones(1);
    unchecked.policy.check = false;
    for precision in Precision::ALL {
        let compares = |program: &Program| {
            let ptx = ptx_of(program, &melt(10), precision);
            let of_part = |part: &String| {
                opcodes(part).filter(|o| o.starts_with("setp.") && (o.ends_with(".f32") || o.ends_with(".f64"))).count()
            };
            moves(&ptx).iter().map(of_part).max().expect("the move stage is marked")
        };
        // Fixed-point coordinates have a range of their own.
        let range = usize::from(precision != Precision::Double);
        // And what is no number is found whatever the policy.
        assert_eq!((compares(&lennard_jones(1)), compares(&unchecked)), (2 + range, 1 + range), "{precision:?}");
    }
}

#[test]
fn a_free_box_has_no_rules_of_periodic_sides() {
    if !is_there() {
        return;
    }
    let sort = |ptx: &str| ptx.split(".entry sort(").nth(1).unwrap().split(".entry ").next().unwrap().to_string();
    for precision in Precision::ALL {
        let periodic = ptx_of(&lennard_jones(1), &melt(10), precision);
        let free = ptx_of(&lennard_jones(1), &gas(500, 20.0, Side::Fixed), precision);
        // In the pair loop, where differences are not those of fixed-point coordinates.
        let has_ties = |ptx: &str| ptx.contains("tied_squared_distance");
        assert_eq!((has_ties(&periodic), has_ties(&free)), (precision == Precision::Double, false), "{precision:?}");
        // Wrapping compares each coordinate with both sides and moves it.
        let [wrapping, plain] = [&periodic, &free].map(|ptx| double_instructions(&sort(ptx)));
        assert!(plain + 3 * 3 <= wrapping, "{precision:?}: {plain}, {wrapping}");
        // No image is looked up: a pair reads its entry and a slot.
        let slot = if precision == Precision::Double { 32 } else { 16 };
        let of_loop = |ptx: &str| pair_loops(ptx).iter().map(|text| bytes(text)).min().unwrap();
        assert_eq!(of_loop(&free), step_content(&free).entries * (4 + slot), "{precision:?}");
    }
}
