//! `--explain`: what the kernels of a run hold, and what was left out of them.

use super::arrays::{Count, arrays};
use super::engine::Engine;
use super::inspect::{double_instructions, pair_loops};
use super::layout::CHUNK;

/// Line by line.
pub fn explain(engine: &Engine) -> Vec<String> {
    let (plan, compiled) = (&engine.plan, &engine.compiled);
    let shape = &plan.shape;
    let lanes = match shape.lanes {
        1 => "a thread a particle".to_string(),
        n => format!("{n} threads a particle"),
    };
    let pairs = if shape.double_pairs { "f64" } else { "f32 on fixed-point coordinates" };
    let kernel = &compiled.advance.kernel;
    let mut lines = vec![
        format!("Pair loop: {lanes}, {CHUNK} entries at a time; arithmetic in {pairs}"),
        format!(
            "Kernel: {} registers, {} bytes of shared memory, {} bytes of local memory a thread; {} blocks, {} on a multiprocessor",
            kernel.registers, kernel.shared_bytes, kernel.local_bytes, compiled.advance.blocks, kernel.resident
        ),
    ];
    let mut out = Vec::new();
    for (left_out, what) in [
        (shape.types == 1, "look-up of coefficients by type (one type)"),
        (!shape.masses, "look-up of masses (one mass)"),
        (!shape.groups, "look-up of groups (all fixes act on all atoms)"),
        (
            !shape.images,
            "periodic images in the pair loop (coordinates go around with the box, or nothing is periodic)",
        ),
        (shape.periodic == 0, "wrapping (no periodic side)"),
        (!shape.folded, "sharing of table places (the grid is small)"),
        (!shape.storage_sort, "sort of storage order"),
        (!shape.double_pairs, "f64 in the pair loop"),
    ] {
        if left_out {
            out.push(what);
        }
    }
    lines.push(format!("Left out here: {}", out.join("; ")));
    let doubles: Vec<usize> = pair_loops(&compiled.ptx).iter().map(|text| double_instructions(text)).collect();
    let all = double_instructions(&compiled.ptx);
    lines.push(format!(
        "f64 instructions in the code: {all}, of them in the pair loop {}, with energy and virial {}",
        doubles.iter().min().unwrap_or(&0),
        doubles.iter().max().unwrap_or(&0)
    ));
    let columns = |count: Count| if let Count::Columns(n) = count { n } else { 0 };
    let each: usize = arrays(shape).iter().map(|a| columns(a.count) * a.entry.1).sum();
    let atoms = f64::from(engine.control.n.max(1));
    let (entries, tests) = (engine.control.entries as f64 / atoms, engine.control.tests as f64 / atoms);
    let list = f64::from(plan.scene.capacity) * shape.entry() as f64;
    // x and v are read and written, f and what is held read, slots written; then slots and list are read, f written.
    let (store, real, slot) = (shape.store().1 as f64, shape.real().1 as f64, shape.slot().1 as f64);
    let step = 12.0 * store + 6.0 * real + 2.0 * slot + 24.0 + 4.0 + entries * shape.entry() as f64;
    lines.push(format!(
        "An atom: {each} bytes of arrays and {list:.0} of list; {step:.0} bytes a step without what neighbors are read again; \
         {entries:.1} list entries out of {tests:.0} distances tested"
    ));
    lines
}
