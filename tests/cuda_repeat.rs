//! A run on a GPU can be repeated bit by bit.
#![cfg(feature = "cuda")]

mod common;

use std::sync::atomic::AtomicBool;

use common::{Engine, Variant, arc, gpu_variants, melt, program};
use octant::dynamics::Fix;
use octant::engine::{Needs, Program, Record};
use octant::neighbor::Search;
use octant::system::{GROUP_ALL, SimulationBox, State};

/// Bits of positions, velocities, forces, and of energy, virial and kinetic sums, after a run of two parts and one with sums at
/// every step, of which the clock decides how many end a launch.
fn bits(variant: &Variant, program: &Program, (state, space): &(State, SimulationBox)) -> (Vec<u64>, u64) {
    let all = Needs { energy: true, virial: true, pressure: true, positions: true, forces: true };
    let mut backend = variant.backend(1);
    backend.load(arc(program.clone()), state, space, 0).unwrap();
    backend.set_up(all).unwrap();
    let stop = AtomicBool::new(false);
    for steps in [130, 70] {
        backend.advance(steps, all, &stop).unwrap();
    }
    let (mut records, last) = (Vec::new(), backend.step() + 1000);
    while backend.step() < last {
        let left = (last - backend.step()) as u64;
        backend.advance_recording((1, left), all, &stop, &mut records).unwrap();
        records.push(Record { step: backend.step(), sums: backend.sums().unwrap() });
    }
    assert_eq!(records.len(), 1000, "{}", variant.name);
    let mut end = state.clone();
    backend.fetch(&mut end).unwrap();
    let sums = |r: Record| [&[r.sums.potential][..], &r.sums.virial, &r.sums.kinetic, &[r.sums.bath]].concat();
    let vectors = [&end.x, &end.v, &end.f].into_iter().flatten().flat_map(|vector| vector.iter().copied());
    let numbers = vectors.chain(records.into_iter().flat_map(sums));
    let statistics = backend.statistics();
    assert!(statistics.builds > 2, "{}: lists were built {} times", variant.name, statistics.builds);
    (numbers.map(f64::to_bits).collect(), statistics.redone)
}

#[test]
fn a_run_repeats_in_every_bit_with_and_without_an_inner_list() {
    let mut known = std::collections::HashMap::new();
    for variant in gpu_variants() {
        let grows = matches!(variant.engine, Engine::Cuda(Some(_)));
        // A liquid whose list goes around with the box, and a small box that sees images.
        let nve = Fix { style: "nve", group: GROUP_ALL, ..Fix::default() };
        let noise = Fix { style: "langevin", parameters: vec![1.5, 1.5, 2.0, 7.0, 4711.0], ..nve.clone() };
        let chain =
            Fix { style: "nvt", choice: 3 | 1 << 8, parameters: vec![1.5, 1.5, 5.0, 0.0, 1.0, 1.0], ..nve.clone() };
        let motions = [vec![nve.clone()], vec![noise, nve], vec![chain]];
        let scenes = [(&[2.5][..], 8), (&[2.5, 2.0][..], 3)].into_iter();
        for ((cutoffs, n), (way, fixes)) in scenes.flat_map(|scene| motions.iter().enumerate().map(move |m| (scene, m)))
        {
            let mut program = program(cutoffs, 0.3, Search::Trimmed);
            program.fixes.clone_from(fixes);
            let mut scene = melt(n);
            for (k, kind) in scene.0.kind.iter_mut().enumerate() {
                *kind = 1 + (k % cutoffs.len()) as u32;
            }
            let (first, redone) = bits(&variant, &program, &scene);
            assert!(redone > 0 || !grows, "{}: arrays did not grow", variant.name);
            // Those whose arrays grow have an inner list.
            let plain = known.entry((variant.precision.name(), n, way)).or_insert_with(|| first.clone());
            assert!(*plain == first, "{}: an inner list shows in {n} cells, motion {way}", variant.name);
            for _ in 0..3 {
                let (again, _) = bits(&variant, &program, &scene);
                let other = first.iter().zip(&again).filter(|(a, b)| a != b).count();
                assert!(first.len() == again.len() && other == 0, "{}: {other} numbers differ", variant.name);
            }
        }
    }
}
