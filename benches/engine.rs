//! Set-up (wrap, sort, list, forces) by search, and steps by precision and threads, of a Lennard-Jones liquid.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;
use std::sync::atomic::AtomicBool;

use common::{arc, melt, program};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use octant::engine::cpu::{CpuBackend, CpuOptions};
use octant::engine::{Backend, Needs, Precision};
use octant::neighbor::Search;
use octant::system::State;

/// Steps that turn the crystal into a liquid, on which everything is measured.
const MELTING: u64 = 300;

fn backend(threads: usize, precision: Precision) -> CpuBackend {
    CpuBackend::new(CpuOptions { threads, precision, isa: None }).expect("threads start")
}

/// A liquid of 4 n^3 particles.
fn liquid(n: usize) -> (State, octant::system::SimulationBox) {
    let (mut state, simulation_box) = melt(n);
    let mut backend = backend(0, Precision::Mixed);
    backend.load(arc(program(&[2.5], 0.3, Search::Trimmed)), &state, &simulation_box, 0).unwrap();
    backend.set_up(Needs::default()).expect("a crystal is a good start");
    backend.advance(MELTING, Needs::default(), &AtomicBool::new(false)).expect("a melt runs");
    backend.fetch(&mut state).unwrap();
    (state, simulation_box)
}

fn engine(c: &mut Criterion) {
    for n in [10, 20] {
        let (state, simulation_box) = liquid(n);
        let mut group = c.benchmark_group("set-up");
        group.throughput(Throughput::Elements(state.len() as u64)).sample_size(10);
        for search in [Search::Trimmed, Search::Octant, Search::Standard] {
            let mut backend = backend(1, Precision::Mixed);
            backend.load(arc(program(&[2.5], 0.3, search)), &state, &simulation_box, 0).unwrap();
            group.bench_function(BenchmarkId::new(search.name(), state.len()), |b| {
                b.iter(|| black_box(&mut backend).set_up(Needs::default()).expect("a liquid has finite forces"));
            });
        }
        group.finish();
        let mut group = c.benchmark_group("20 steps");
        group.throughput(Throughput::Elements(20 * state.len() as u64)).sample_size(10);
        for (threads, precision) in [1, 2].into_iter().flat_map(|n| Precision::ALL.map(|p| (n, p))) {
            let mut backend = backend(threads, precision);
            backend.load(arc(program(&[2.5], 0.3, Search::Trimmed)), &state, &simulation_box, 0).unwrap();
            backend.set_up(Needs::default()).expect("a liquid has finite forces");
            let stop = AtomicBool::new(false);
            group.bench_function(
                BenchmarkId::new(format!("{}, {threads} threads", precision.name()), state.len()),
                |b| {
                    b.iter(|| backend.advance(20, Needs::default(), &stop).expect("a liquid runs"));
                },
            );
        }
        group.finish();
    }
}

criterion_group!(benches, engine);
criterion_main!(benches);
