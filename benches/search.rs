//! What a list build is made of, by search, edge of its cells, their order and the sort, on points that are even at random (`inputs/paper/`, 20000
//! particles): sorting into cells, and the whole set-up (sort, list, forces).

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{Noise, arc, free_or_periodic, program};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use octant::engine::cpu::{CpuBackend, CpuOptions};
use octant::engine::{Backend, Needs, Precision};
use octant::neighbor::{Cells, Grid, SearchPlan};
use octant::pair::PairCoefficients;
use octant::paper::{ORDERED, SEARCHES};
use octant::system::{SimulationBox, State, Vec3};

/// Particles, and the edge of their box in cutoffs.
const COUNT: u32 = 20_000;
const EDGE: f64 = 13.695;

fn points() -> (State, SimulationBox) {
    let mut noise = Noise(2015);
    let mut state = State::default();
    for k in 0..COUNT {
        state.push(k + 1, 1, 0.5 * EDGE * (Vec3::repeat(1.0) + noise.vector()));
    }
    (state, free_or_periodic([0.0; 3], [EDGE; 3], [false; 3]))
}

fn search(c: &mut Criterion) {
    let (state, space) = points();
    // Those of usual order and sort are among the first.
    let special = ORDERED.iter().filter(|plan| plan.contains('+'));
    let plans: Vec<SearchPlan> = SEARCHES.iter().chain(special).map(|plan| plan.parse().expect("a search")).collect();

    let mut group = c.benchmark_group("cells");
    group.throughput(Throughput::Elements(COUNT.into())).sample_size(20);
    for plan in &plans {
        let (low, high) = state.bounds();
        let mut cells = Cells::default();
        group.bench_function(BenchmarkId::from_parameter(plan), |b| {
            b.iter(|| {
                let grid = Grid::new(*plan, &space, &low, &high, 1.0);
                cells.build(&grid, plan.sort(), &state.x, &state.id);
                black_box(&cells);
            });
        });
    }
    group.finish();

    let mut group = c.benchmark_group("list");
    group.throughput(Throughput::Elements(COUNT.into())).sample_size(10);
    let mut spring = PairCoefficients::new("harmonic/cut", 0.0, 1).expect("a registered style");
    spring.set((1, 1), (1, 1), &["1800.0", "1.0"]).expect("its coefficients");
    for plan in &plans {
        let mut program = program(&[1.0], 0.0, *plan);
        program.pair = spring.complete().expect("one type").0;
        let options = CpuOptions { threads: 1, precision: Precision::Mixed, isa: None };
        let mut backend = CpuBackend::new(options).expect("threads start");
        backend.load(arc(program), &state, &space, 0).unwrap();
        group.bench_function(BenchmarkId::from_parameter(plan), |b| {
            b.iter(|| black_box(&mut backend).set_up(Needs::default()).expect("no two points are one"));
        });
    }
    group.finish();
}

criterion_group!(benches, search);
criterion_main!(benches);
