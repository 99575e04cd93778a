//! What a list build is made of, by search, edge of its cells, their order and the sort, on points that are even at random (`inputs/paper/`, 20000
//! particles): sorting into cells, and the list, on the CPU and on the GPU where there is one.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use common::{Noise, arc, free_or_periodic, program};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use octant::engine::cpu::{CpuBackend, CpuOptions};
#[cfg(feature = "cuda")]
use octant::engine::cuda::{CudaBackend, CudaOptions, Tuning};
use octant::engine::{Backend, Needs, Precision, StageSeconds};
use octant::neighbor::{CellOrder, Cells, Grid, SearchPlan};
use octant::pair::PairCoefficients;
use octant::paper::{ORDERED, SEARCHES};
use octant::system::{SimulationBox, State, Vec3};

/// Particles, and the edge of their box in cutoffs.
const COUNT: u32 = 20_000;
const EDGE: f64 = 13.695;

/// There are close to a hundred of them: with criterion's 3 s and 5 s they would take a quarter of an hour.
const WARM_UP: Duration = Duration::from_millis(500);
const MEASURED: Duration = Duration::from_secs(2);

fn points() -> (State, SimulationBox) {
    let mut noise = Noise(2015);
    let mut state = State::default();
    for k in 0..COUNT {
        state.push(k + 1, 1, 0.5 * EDGE * (Vec3::repeat(1.0) + noise.vector()));
    }
    (state, free_or_periodic([0.0; 3], [EDGE; 3], [false; 3]))
}

fn plans() -> Vec<SearchPlan> {
    // Those of usual order and sort are among the first.
    let special = ORDERED.iter().filter(|plan| plan.contains('+'));
    SEARCHES.iter().chain(special).map(|plan| plan.parse().expect("a search")).collect()
}

fn search(c: &mut Criterion) {
    // Rows are the usual order here.
    let by_name = |plan: &SearchPlan| plan.order() != CellOrder::Rows;
    let ((state, space), plans): (_, Vec<SearchPlan>) = (points(), plans().into_iter().filter(by_name).collect());
    let mut group = c.benchmark_group("cells");
    group.throughput(Throughput::Elements(COUNT.into())).sample_size(20);
    group.warm_up_time(WARM_UP).measurement_time(MEASURED);
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

    staged(c, "list", &plans, |stages| stages.list, &|| {
        let options = CpuOptions { threads: 1, precision: Precision::Mixed, isa: None };
        Box::new(CpuBackend::new(options).expect("threads start"))
    });
}

/// A stage of list builds by the engine's own clock: the points stand still, and every step builds the list.
fn staged(
    c: &mut Criterion,
    name: &str,
    plans: &[SearchPlan],
    stage: fn(&StageSeconds) -> f64,
    engine: &dyn Fn() -> Box<dyn Backend>,
) {
    let (state, space) = points();
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(COUNT.into())).sample_size(10);
    group.warm_up_time(WARM_UP).measurement_time(MEASURED);
    let mut spring = PairCoefficients::new("harmonic/cut", 0.0, 1).expect("a registered style");
    spring.set((1, 1), (1, 1), &["1800.0", "1.0"]).expect("its coefficients");
    for plan in plans {
        let mut program = program(&[1.0], 0.0, *plan);
        program.pair = spring.complete().expect("one type").0;
        program.fixes.clear();
        program.policy.check = false;
        let mut backend = engine();
        backend.load(arc(program), &state, &space, 0).unwrap();
        backend.set_up(Needs::default()).expect("no two points are one");
        group.bench_function(BenchmarkId::from_parameter(plan), |b| {
            b.iter_custom(|steps| {
                let (builds, before) = (backend.statistics().builds, stage(&backend.seconds()));
                backend.advance(steps, Needs::default(), &AtomicBool::new(false)).expect("nothing moves");
                let built = backend.statistics().builds - builds;
                assert_eq!(built, steps, "a build a step");
                Duration::from_secs_f64(stage(&backend.seconds()) - before)
            });
        });
    }
    group.finish();
}

/// The same on the GPU, sort and list.
#[cfg(feature = "cuda")]
fn search_on_gpu(c: &mut Criterion) {
    if let Err(reason) = octant::engine::cuda::devices() {
        println!("no search is measured on a GPU: {reason}");
        return;
    }
    let engine = || -> Box<dyn Backend> {
        let options = CudaOptions { device: 0, precision: Precision::Mixed, tuning: Tuning::default() };
        Box::new(CudaBackend::new(options).expect("there is a device"))
    };
    let plans = plans();
    staged(c, "cells, cuda", &plans, |stages| stages.sort, &engine);
    staged(c, "list, cuda", &plans, |stages| stages.list, &engine);
}

#[cfg(not(feature = "cuda"))]
fn search_on_gpu(_: &mut Criterion) {}

criterion_group!(benches, search, search_on_gpu);
criterion_main!(benches);
