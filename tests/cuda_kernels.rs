//! Kernels of scenes compiled by NVRTC, for several architectures, without a GPU; and what they hold and leave out.
#![cfg(feature = "cuda")]

mod common;
#[path = "common/kernels.rs"]
mod kernels;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{melt, program, program_of_style};
use kernels::{gas, is_there};

use octant::dynamics::Fix;
use octant::engine::cuda::inspect::{Unit, inspect, recording_unit_of, units_of};
use octant::engine::cuda::ptx::{double_instructions, moves, pair_loops};
use octant::engine::{Precision, Program, StorageSort};
use octant::neighbor::{Search, SearchPlan};
use octant::session::{Settings, first_run};
use octant::system::{GROUP_ALL, LostAtoms, Side, SimulationBox, State};

const ARCHITECTURES: [&str; 4] = ["sm_75", "sm_80", "sm_90", "sm_120"];

/// Name, program, particles, box.
type Scene = (String, Program, State, SimulationBox);

/// Every kind of kernel that scenes can ask for.
fn scenes() -> Vec<Scene> {
    let mut all = Vec::new();
    let mut add = |name: String, program: Program, (state, space): (State, SimulationBox)| {
        all.push((name, program, state, space))
    };
    for style in octant::pair::styles() {
        for shift in [false, true] {
            add(
                format!("{} shift {shift}", style.name),
                program_of_style(&style, shift, 1.0, 1.0),
                gas(2000, 30.0, Side::Periodic),
            );
        }
    }
    for search in Search::ALL {
        add(format!("{search:?}"), program(&[2.5], 0.3, search), melt(4));
    }
    let curve: SearchPlan = "trimmed+zorder".parse().unwrap();
    add("along a curve".into(), program(&[2.5], 0.3, curve), melt(4));
    add("along a curve, folded".into(), program(&[2.5], 0.3, curve), gas(50, 1e4, Side::Periodic));
    for name in ["standard+rows", "octant:2.52+radix", "trimmed+zorder+radix"] {
        let plan: SearchPlan = name.parse().unwrap();
        add(name.into(), program(&[2.5], 0.3, plan), melt(4));
        add(format!("{name}, folded"), program(&[2.5], 0.3, plan), gas(50, 1e4, Side::Periodic));
    }
    add("large".into(), program(&[2.5], 0.3, Search::Trimmed), gas(200_000, 60.0, Side::Periodic));
    add("middling".into(), program(&[2.5], 0.3, Search::Trimmed), gas(60_000, 40.0, Side::Periodic));
    add("wide skin".into(), program(&[2.5], 0.8, Search::Trimmed), gas(60_000, 40.0, Side::Periodic));
    add("wide skin, types, few".into(), program(&[2.5, 2.0], 0.8, Search::Trimmed), gas(2000, 14.0, Side::Periodic));
    add("small box".into(), program(&[2.5, 2.0], 0.3, Search::Trimmed), gas(10, 4.0, Side::Periodic));
    add("free".into(), program(&[2.5], 0.3, Search::Trimmed), gas(500, 20.0, Side::Fixed));
    add("shrinking".into(), program(&[2.5], 0.3, Search::Trimmed), gas(500, 20.0, Side::Shrink));
    add("mostly empty".into(), program(&[2.5], 0.3, Search::Trimmed), gas(50, 1e5, Side::Periodic));
    let mut sorted = program(&[2.5, 2.0], 0.3, Search::Trimmed);
    sorted.storage_sort = Some(StorageSort { every: 1000, bin: 0.0 });
    sorted.fixes[0].group = 4;
    sorted.policy.check = false;
    add("storage sort, group".into(), sorted, gas(5000, 30.0, Side::Periodic));
    for storage_sort in [None, Some(StorageSort { every: 1000, bin: 0.0 })] {
        let (types, side) = if storage_sort.is_some() { (2, Side::Fixed) } else { (1, Side::Shrink) };
        let losing = program(&[2.5, 2.0][..types], 0.3, Search::Trimmed);
        let losing = Program { lost: LostAtoms::Ignore, storage_sort, ..losing };
        add(format!("atoms are lost, {types} types"), losing, gas(5000, 30.0, side));
    }
    let mut limited = program(&[2.5, 2.0], 0.3, Search::Trimmed);
    limited.fixes[0] = Fix { style: "nve/limit", group: 4, parameters: vec![0.1], ..Fix::default() };
    add("limited steps".into(), limited, gas(500, 20.0, Side::Periodic));
    for (group, choice) in [(GROUP_ALL, 0), (4, 1)] {
        let mut noisy = program(&[2.5, 2.0], 0.3, Search::Trimmed);
        let bath =
            Fix { style: "langevin", group, choice, parameters: vec![1.0, 2.0, 1.0, 5.0, 7.0], ..Fix::default() };
        noisy.fixes.push(bath);
        add(format!("random forces, choice {choice}"), noisy, gas(500, 20.0, Side::Periodic));
    }
    // Thermostats, of all atoms and of two groups, with an inner list.
    let nvt = |group, links: u32, parts: u32| {
        let (choice, parameters) = (links | parts << 8, vec![1.0, 2.0, 5.0, 0.0, 1.0, 1.0]);
        Fix { style: "nvt", group, choice, parameters, ..Fix::default() }
    };
    let mut bath = program(&[2.5], 0.3, Search::Trimmed);
    bath.fixes = vec![nvt(GROUP_ALL, 3, 1)];
    add("thermostat".into(), bath, gas(500, 20.0, Side::Periodic));
    let mut baths = program(&[2.5, 2.0], 0.8, Search::Trimmed);
    baths.fixes = vec![nvt(2, 1, 2), nvt(4, 4, 1)];
    add("thermostats, wide skin".into(), baths, gas(60_000, 40.0, Side::Periodic));
    // Walls and gravity for all, and for a group of a scene with two masses.
    for (group, types) in [(GROUP_ALL, 1), (4, 2)] {
        let mut walled = program(&[2.5, 2.0][..types], 0.3, Search::Trimmed);
        let fix = |style, choice, parameters| Fix { style, group, choice, parameters, ..Fix::default() };
        walled.fixes[0].style = ["nve", "nve/euler2"][types - 1];
        walled.fixes.push(fix("wall/reflect", 0b101101, vec![0.0; 6]));
        walled.fixes.push(fix("gravity", 0, vec![0.0, 0.5, -1.0]));
        add(format!("walls, gravity, {types} types"), walled, gas(500, 20.0, Side::Fixed));
    }
    all
}

/// The scenes that come with octant, as their first run starts.
fn inputs() -> Vec<Scene> {
    let entries = std::fs::read_dir("inputs").unwrap().map(|entry| entry.unwrap().path());
    let mut scripts: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "in")).collect();
    let whole = |path: &PathBuf| WHOLE.iter().any(|scene| path.ends_with(scene));
    scripts.sort_by_key(|path| (!whole(path), path.clone()));
    assert!(scripts.len() >= 10, "{scripts:?}");
    scripts.iter().map(|script| input(script)).collect()
}

fn input(script: &Path) -> Scene {
    let text = std::fs::read_to_string(script).unwrap();
    // Kernels know nothing of dumps, whose formats may not be built in.
    let text: String = text.lines().filter(|line| !line.starts_with("dump")).map(|line| format!("{line}\n")).collect();
    let name = script.display().to_string();
    let out = std::env::temp_dir().display().to_string();
    let settings = Settings { variables: vec![("out".into(), out)], ..Settings::default() };
    let run = first_run(&name, &text, &settings).unwrap_or_else(|e| panic!("{e}"));
    (name, run.program, run.state, run.simulation_box)
}

/// Every text of kernels once, with the name of the first scene and precision that has it.
fn all_units() -> Vec<(String, Unit)> {
    let mut known = HashSet::new();
    let mut all = Vec::new();
    // Either kind of scenes is recorded in one of the two ways.
    for (scenes, tensor) in [(inputs(), false), (scenes(), true)] {
        for (name, program, state, space) in &scenes {
            for precision in Precision::ALL {
                let recording = recording_unit_of(program, state, space, precision, tensor);
                for unit in units_of(program, state, space, precision).into_iter().chain([recording]) {
                    if known.insert(unit.clone()) {
                        all.push((format!("{name}, {precision:?}, {}", unit.kernels[0]), unit));
                    }
                }
            }
        }
    }
    all
}

/// What a scene may have or not, of a unit: switches, numbers that code is chosen by, number types, potential, fixes.
fn features(unit: &Unit) -> Vec<String> {
    let generated = unit.text.split("#line").next().unwrap_or_default();
    let is = |line: &&str| {
        let number = |name: &str| line.starts_with(&format!("#define {name} "));
        ["#define ", "typedef "].iter().any(|start| line.starts_with(start)) && !NUMBERS.into_iter().any(number)
            || line.contains("// ")
    };
    generated.lines().filter(is).map(|line| format!("{}: {}", unit.kernels[0], line.trim())).collect()
}

/// Numbers that differ from scene to scene and choose no code.
const NUMBERS: [&str; 3] = ["SLICES", "INDEX_BITS", "BATHS"];

/// Scenes whose kernels are compiled for every architecture in every precision: the main one, that most is measured of, and one of several
/// types with cutoffs of their own.
const WHOLE: [&str; 2] = ["inputs/melt.in", "inputs/mixture.in"];

/// A unit by its place, and an architecture to compile it for.
type Pair = (usize, &'static str);

/// Each unit for one architecture, in turns but for what that has met of the unit's features; then what is left, so that each kernel with
/// each feature is compiled for every architecture.
fn pairs(units: &[(String, Unit)]) -> Vec<Pair> {
    let features: Vec<Vec<String>> = units.iter().map(|(_, unit)| features(unit)).collect();
    let (mut met, mut all) = (HashSet::new(), Vec::new());
    for (k, (name, _)) in units.iter().enumerate() {
        let fresh = |of: &&str| features[k].iter().filter(|feature| !met.contains(&(feature.as_str(), *of))).count();
        let turns = (0..ARCHITECTURES.len()).map(|turn| ARCHITECTURES[(k + turn) % ARCHITECTURES.len()]);
        let next = turns.rev().max_by_key(fresh).expect("there are four");
        let whole = WHOLE.iter().any(|scene| name.starts_with(scene));
        for of in if whole { ARCHITECTURES.to_vec() } else { vec![next] } {
            met.extend(features[k].iter().map(|feature| (feature.as_str(), of)));
            all.push((k, of));
        }
    }
    for (k, features) in features.iter().enumerate() {
        for of in ARCHITECTURES {
            if features.iter().any(|feature| !met.contains(&(feature.as_str(), of))) {
                met.extend(features.iter().map(|feature| (feature.as_str(), of)));
                all.push((k, of));
            }
        }
    }
    all
}

#[test]
fn every_feature_of_a_kernel_meets_every_architecture() {
    let units = all_units();
    let pairs = pairs(&units);
    let mut met: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for (k, of) in &pairs {
        for feature in features(&units[*k].1) {
            met.entry(feature).or_default().insert(of);
        }
    }
    let lacking: Vec<_> = met.iter().filter(|(_, of)| of.len() < ARCHITECTURES.len()).collect();
    assert!(lacking.is_empty(), "{lacking:?}");
    for style in octant::pair::styles() {
        let has = |switch: &str| met.keys().any(|feature| feature.starts_with("advance: ") && feature.contains(switch));
        assert!(has(style.formula), "{}", style.name);
    }
    let compiled: HashSet<usize> = pairs.iter().map(|(k, _)| *k).collect();
    assert_eq!(compiled.len(), units.len());
    // Few more than one each.
    println!("{} units, {} compilations", units.len(), pairs.len());
    assert!(pairs.len() < 2 * units.len(), "{} units, {} compilations", units.len(), pairs.len());
}

#[test]
fn every_kind_of_kernel_compiles_for_every_architecture() {
    if !is_there() {
        return;
    }
    let units = all_units();
    let all = pairs(&units);
    let next = AtomicUsize::new(0);
    let check_some = || {
        while let Some((k, architecture)) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
            let (name, unit) = &units[*k];
            check(&format!("{name}, {architecture}"), unit, architecture);
        }
    };
    // Compilations share nothing: as many side by side as there are cores.
    std::thread::scope(|scope| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(check_some)).collect();
        for thread in threads {
            thread.join().unwrap();
        }
    });
}

fn check(name: &str, unit: &Unit, architecture: &str) {
    let found = inspect(&unit.text, architecture).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(!found.cubin.is_empty());
    let loops = pair_loops(&found.ptx);
    // Energy and virial may be followed in their loop by the sums of a row: eight conversions and additions.
    let allowed = match unit.kernels[0] {
        "advance" => 0,
        "conclude" | "advance_recording" => 16,
        _ => {
            assert!(loops.is_empty(), "{name}: pairs are worked out elsewhere");
            return;
        }
    };
    assert!(!loops.is_empty() && !moves(&found.ptx).is_empty(), "{name}: stages are not marked");
    let doubles = loops.iter().map(|text| double_instructions(text)).max().unwrap_or(0);
    if unit.text.contains("#define FIXED") {
        assert!(doubles <= allowed, "{name}: {doubles} f64 instructions in the pair loop");
    } else {
        assert!(doubles > 10, "{name}: pairs in double precision have f64");
    }
}

#[test]
fn what_a_scene_lacks_is_not_in_its_kernels() {
    let source = |program: &Program, (state, space): &(State, SimulationBox), precision| {
        units_of(program, state, space, precision).into_iter().map(|unit| unit.text).collect::<String>()
    };
    let plain = program(&[2.5], 0.3, Search::Trimmed);
    let text = source(&plain, &melt(10), Precision::Mixed);
    for absent in [
        "held_kind;",
        "held_mask;",
        "held_home;",
        "new_home;",
        "* cell;",
        "* shifts;",
        "* fixed_shifts;",
        "#define GROUPS",
        "#define IMAGES",
        "#define FORCES",
        "#define NOISE",
        "void noise_of",
        "#define THERMOSTATS",
        "* baths;",
        "* group_sums;",
        "#define COORDINATES",
    ] {
        assert!(!text.contains(absent), "{absent}");
    }
    assert!(
        text.contains("#define PERIODIC 7\n") && text.contains("#define CHECK\n") && text.contains("#define TYPES 1\n")
    );
    // One step of velocity Verlet: three kicks and three drifts, and no drift in the second half.
    let last = text.split("void fixes_last").nth(1).and_then(|t| t.split("\n}\n").next()).unwrap();
    assert!(last.contains("v[0] =") && !last.contains("x[0] ="), "{last}");
    // Two walls are two reflections; where positions are displacements, they are looked at from the last build.
    let mut walled = plain.clone();
    let walls = Fix { style: "wall/reflect", group: GROUP_ALL, choice: 0b100001, ..Fix::default() };
    walled.fixes.insert(0, Fix { parameters: vec![0.0; 6], ..walls });
    for precision in Precision::ALL {
        let text = source(&walled, &gas(500, 20.0, Side::Fixed), precision);
        let initial = text.split("void fixes_initial").nth(1).and_then(|t| t.split("\n}\n").next()).unwrap();
        let (motion, walls) = initial.split_once("// fix wall/reflect").expect("walls come after the motion");
        assert!(motion.contains("// fix nve") && !walls.contains("// fix nve"), "{initial}");
        assert_eq!((walls.matches(" < ").count(), walls.matches("fix_parameters").count() > 0), (2, true), "{walls}");
        assert!(walls.contains("x[0] =") && !walls.contains("x[1] =") && walls.contains("v[2] ="), "{walls}");
        assert_eq!(walls.contains("origin[2]"), precision == Precision::Single, "{walls}");
    }
    // Cells are divided where the halves look into different ones, and more finely where octants are.
    for search in Search::ALL {
        let text = source(&program(&[2.5], 0.3, search), &melt(10), Precision::Mixed);
        let octants = matches!(search, Search::Trimmed | Search::Octant | Search::Midplane);
        assert!(text.contains(if octants { "#define DIVIDED 7\n" } else { "#define DIVIDED 0\n" }), "{search:?}");
        assert_eq!(text.contains("void is_middle"), search == Search::Midplane, "{search:?}");
        assert_eq!(text.contains("#define MIDPLANE\n"), search == Search::Midplane, "{search:?}");
        // 4000 atoms in one cell are 125 groups of 32 or more, smaller ones.
        let slices: u32 = text.split("#define SLICES ").nth(1).and_then(|t| t.lines().next()).unwrap().parse().unwrap();
        assert_eq!(slices >= 64, search == Search::Brute, "{search:?}: {slices}");
    }
    let free = source(&plain, &gas(500, 20.0, Side::Fixed), Precision::Double);
    assert!(free.contains("#define PERIODIC 0\n") && !free.contains("void tied_squared_distance"));
    let mut other = plain.clone();
    other.policy.once = true;
    other.fixes[0].group = 4;
    let text = source(&other, &melt(2), Precision::Mixed);
    assert!(!text.contains("#define CHECK\n") && !text.contains("#define REBUILDS\n"));
    assert!(text.contains("if (mask & 4u)") && text.contains("u32* held_mask;") && text.contains("#define IMAGES\n"));
}
