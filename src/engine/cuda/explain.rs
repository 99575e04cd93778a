//! `--explain`: what the kernels of a run hold, and what was left out of them.

use super::arrays::{Count, arrays};
use super::compiled::Launch;
use super::engine::Engine;
use super::ptx::{StepContent, step_content};

/// Line by line.
pub fn explain(engine: &Engine) -> Vec<String> {
    let (plan, compiled) = (&engine.plan, &engine.compiled);
    let shape = &plan.shape;
    let lanes = match shape.lanes {
        1 => "a thread a particle".to_string(),
        n => format!("{n} threads a particle"),
    };
    let pairs = if shape.double_pairs { "f64" } else { "f32 on fixed-point coordinates" };
    let mut lines = vec![format!("Pair loop: {lanes}, {} entries at a time; arithmetic in {pairs}", shape.chunk())];
    for (name, Launch { kernel, blocks, .. }) in compiled.launches() {
        lines.push(format!(
            "Kernel {name}: {} registers and {} bytes of local memory a thread, {} bytes of shared memory a block; {blocks} \
             blocks, {} on a multiprocessor",
            kernel.registers, kernel.local_bytes, kernel.shared_bytes, kernel.resident
        ));
    }
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
        (!shape.inner, "inner list (the skin is narrow)"),
        (!shape.storage_sort, "sort of storage order"),
        (!shape.loses, "atoms that are lost (none may be)"),
        (!shape.double_pairs, "f64 in the pair loop"),
    ] {
        if left_out {
            out.push(what);
        }
    }
    lines.push(format!("Left out here: {}", out.join("; ")));
    let columns = |count: Count| if let Count::Columns(n) = count { n } else { 0 };
    let each: usize = arrays(shape).iter().map(|a| columns(a.count) * a.entry.1).sum();
    let atoms = f64::from(engine.control.n.max(1));
    let (entries, tests) = (engine.control.entries as f64 / atoms, engine.control.tests as f64 / atoms);
    let lists = 1 + usize::from(shape.inner);
    let list = f64::from(plan.scene.capacity) * (lists * shape.entry()) as f64;
    lines.push(format!(
        "An atom: {each} bytes of arrays and {list:.0} of list; {entries:.1} list entries out of {tests:.0} distances tested"
    ));
    // Before its row an atom's slot and the length of the row are read, after it the force is written.
    let beside = shape.slot().1 + size_of::<u32>() + 3 * shape.real().1;
    lines.extend(step_lines(&step_content(&compiled.ptx), entries, beside));
    lines
}

/// What an atom with so many entries in its row costs in a step; `beside` are the bytes of the pair stage that are not moved
/// in its loop.
fn step_lines(step: &StepContent, entries: f64, beside: usize) -> [String; 2] {
    let an_entry = |loop_content: usize| loop_content as f64 / step.entries.max(1) as f64;
    let StepContent { moving, force, sums, .. } = step;
    let (doubles, bytes) = (an_entry(force.doubles), an_entry(force.bytes));
    [
        format!(
            "f64 instructions an atom and step, in one pass of the straight-line code: {} as it moves, {:.0} in the pair loop \
             ({doubles:.1} an entry; {:.1} with energy and virial)",
            moving.doubles,
            doubles * entries,
            an_entry(sums.doubles)
        ),
        format!(
            "Bytes an atom and step, counted alike: {} as it moves, {:.0} in the pair loop ({bytes:.1} an entry), {beside} beside it",
            moving.bytes,
            bytes * entries
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::ptx::Content;
    use super::*;

    #[test]
    fn costs_are_of_an_atom_and_step() {
        let content = |doubles, bytes| Content { instructions: 100, doubles, bytes };
        let step = StepContent { entries: 4, moving: content(30, 148), force: content(4, 80), sums: content(18, 80) };
        let [doubles, bytes] = step_lines(&step, 50.0, 32);
        assert!(doubles.ends_with(": 30 as it moves, 50 in the pair loop (1.0 an entry; 4.5 with energy and virial)"));
        assert!(bytes.ends_with(": 148 as it moves, 1000 in the pair loop (20.0 an entry), 32 beside it"), "{bytes}");
    }
}
