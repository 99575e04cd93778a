//! Kernels of scenes compiled by NVRTC, for several architectures, without a GPU; and what they hold and leave out.
#![cfg(feature = "cuda")]

mod common;

use common::{Noise, melt, program, program_of_style};
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

/// Every kind of kernel that scenes can ask for.
fn scenes() -> Vec<(String, Program, State, SimulationBox)> {
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
    for (name, program, state, space) in scenes() {
        for precision in Precision::ALL {
            let source = source_of(&program, &state, &space, precision);
            for architecture in ARCHITECTURES {
                let found = inspect(source.clone(), architecture);
                let found = found.unwrap_or_else(|e| panic!("{name}, {precision:?}, {architecture}: {e}"));
                assert!(!found.cubin.is_empty());
                let loops = pair_loops(&found.ptx);
                assert!(loops.len() >= 2, "{name}: the pair loops are not marked");
                let doubles: usize = loops.iter().map(|text| double_instructions(text)).sum();
                if source.contains("#define FIXED") {
                    assert_eq!(doubles, 0, "{name}, {precision:?}, {architecture}: f64 in the pair loop");
                } else {
                    assert!(doubles > 0, "{name}: pairs in double precision have f64");
                }
            }
        }
    }
}
