//! Kernels of scenes compiled by NVRTC, for several architectures, without a GPU; and what they hold and leave out.
#![cfg(feature = "cuda")]

mod common;

use common::{Noise, melt, program, program_of_style};
use std::sync::atomic::{AtomicUsize, Ordering};

use octant::engine::Precision;
use octant::engine::cuda::inspect::{compiler, double_instructions, inspect, pair_loops, source_of};
use octant::engine::{Program, StorageSort};
use octant::neighbor::Search;
use octant::system::{Side, SimulationBox, State, Vec3};

const ARCHITECTURES: [&str; 4] = ["sm_75", "sm_80", "sm_90", "sm_120"];

/// Whether there is a compiler; without one these tests cannot tell anything, and say so.
fn is_there() -> bool {
    match compiler() {
        Ok(_) => true,
        Err(reason) => {
            eprintln!("skipped: {reason}");
            false
        }
    }
}

fn gas(n: usize, edge: f64, side: Side) -> (State, SimulationBox) {
    let mut noise = Noise(7);
    let mut state = State::default();
    for k in 0..n {
        let x = 0.5 * edge * (Vec3::repeat(1.0) + noise.vector());
        state.push(k as u32 + 1, 1 + k as u32 % 2, x);
    }
    (state, SimulationBox::new(Vec3::zeros(), Vec3::repeat(edge), [[side; 2]; 3]))
}

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
    add("large".into(), program(&[2.5], 0.3, Search::Trimmed), gas(200_000, 60.0, Side::Periodic));
    add("middling".into(), program(&[2.5], 0.3, Search::Trimmed), gas(60_000, 40.0, Side::Periodic));
    add("small box".into(), program(&[2.5, 2.0], 0.3, Search::Trimmed), gas(10, 4.0, Side::Periodic));
    add("free".into(), program(&[2.5], 0.3, Search::Trimmed), gas(500, 20.0, Side::Fixed));
    add("shrinking".into(), program(&[2.5], 0.3, Search::Trimmed), gas(500, 20.0, Side::Shrink));
    add("mostly empty".into(), program(&[2.5], 0.3, Search::Trimmed), gas(50, 1e5, Side::Periodic));
    let mut sorted = program(&[2.5, 2.0], 0.3, Search::Trimmed);
    sorted.storage_sort = Some(StorageSort { every: 1000, bin: 0.0 });
    sorted.fixes[0].group = 4;
    sorted.policy.check = false;
    add("storage sort, group".into(), sorted, gas(5000, 30.0, Side::Periodic));
    all
}

#[test]
fn every_kind_of_kernel_compiles_for_every_architecture() {
    if !is_there() {
        return;
    }
    let scenes = scenes();
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(scene) = scenes.get(next.fetch_add(1, Ordering::Relaxed)) {
            check(scene);
        }
    };
    // Compilations share nothing: as many side by side as there are cores.
    std::thread::scope(|scope| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        for thread in threads {
            thread.join().unwrap();
        }
    });
}

fn check((name, program, state, space): &Scene) {
    for precision in Precision::ALL {
        let source = source_of(program, state, space, precision);
        for architecture in ARCHITECTURES {
            let found = inspect(source.clone(), architecture);
            let found = found.unwrap_or_else(|e| panic!("{name}, {precision:?}, {architecture}: {e}"));
            assert!(!found.cubin.is_empty());
            let loops = pair_loops(&found.ptx);
            assert!(loops.len() >= 2, "{name}: the pair loops are not marked");
            let doubles: Vec<usize> = loops.iter().map(|text| double_instructions(text)).collect();
            let (least, most) = (doubles.iter().min().unwrap(), doubles.iter().max().unwrap());
            if source.contains("#define FIXED") {
                // The loop with energy and virial may be followed by the sums of a row: seven conversions and additions.
                let fine = *least == 0 && *most <= 14;
                assert!(fine, "{name}, {precision:?}, {architecture}: f64 in the pair loop: {doubles:?}");
            } else {
                assert!(*least > 10, "{name}: pairs in double precision have f64");
            }
        }
    }
}

#[test]
fn what_a_scene_lacks_is_not_in_its_kernels() {
    let source = |program: &Program, (state, space): &(State, SimulationBox), precision| {
        source_of(program, state, space, precision)
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
    ] {
        assert!(!text.contains(absent), "{absent}");
    }
    assert!(
        text.contains("#define PERIODIC 7\n") && text.contains("#define CHECK\n") && text.contains("#define TYPES 1\n")
    );
    // One step of velocity Verlet: three kicks and three drifts, and no drift in the second half.
    let last = text.split("void fixes_last").nth(1).and_then(|t| t.split("\n}\n").next()).unwrap();
    assert!(last.contains("v[0] =") && !last.contains("x[0] ="), "{last}");
    let free = source(&plain, &gas(500, 20.0, Side::Fixed), Precision::Double);
    assert!(free.contains("#define PERIODIC 0\n") && !free.contains("void tied_squared_distance"));
    let mut other = plain.clone();
    other.policy.once = true;
    other.fixes[0].group = 4;
    let text = source(&other, &melt(2), Precision::Mixed);
    assert!(!text.contains("#define CHECK\n") && !text.contains("#define REBUILDS\n"));
    assert!(text.contains("if (mask & 4u)") && text.contains("u32* held_mask;") && text.contains("#define IMAGES\n"));
}
