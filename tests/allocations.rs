//! No step asks for memory: what a run needs, it has after its first list builds.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use common::{arc, cpu_variants, melt, program};
use octant::dynamics::Fix;
use octant::engine::Needs;
use octant::neighbor::Search;
use octant::system::GROUP_ALL;

/// The system's allocator, counting.
struct Counting;

static CALLS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: hands everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        CALLS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn steps_ask_for_no_memory() {
    let (state, space) = melt(8);
    let (steps, stop) = (200, AtomicBool::new(false));
    let plain = program(&[2.5], 0.3, Search::Trimmed);
    let mut walled = program(&[2.5], 0.3, Search::Midplane);
    let fix = |style, choice, parameters| Fix { style, group: GROUP_ALL, choice, parameters, ..Fix::default() };
    walled.fixes.push(fix("gravity", 0, vec![0.0, 0.0, -0.1]));
    walled.fixes.push(fix("wall/reflect", 0b110000, [space.lo, space.hi].map(|side| side.z).repeat(3)));
    let mut bathed = program(&[2.5], 0.3, Search::Trimmed);
    bathed.fixes = vec![fix("nvt", 3 | 1 << 8, vec![1.44, 1.44, 2.0, 0.0, 1.0, 1.0])];
    bathed.fixes.push(fix("langevin", 0, vec![1.44, 1.44, 0.1, 1.5, 4711.0]));
    let programs = [&plain, &walled, &bathed];
    for (variant, program) in cpu_variants().iter().flat_map(|variant| programs.map(|program| (variant, program))) {
        let mut backend = variant.backend(2);
        backend.load(arc(program.clone()), &state, &space, 0).unwrap();
        backend.set_up(Needs::default()).unwrap();
        backend.advance(600, Needs::default(), &stop).unwrap();
        let (builds, calls) = (backend.statistics().builds, CALLS.load(Ordering::Relaxed));
        backend.advance(steps, Needs::default(), &stop).unwrap();
        let builds = backend.statistics().builds - builds;
        let calls = CALLS.load(Ordering::Relaxed) - calls;
        assert!(builds > 10, "{}: {builds} builds", variant.name);
        // Now and then a list outgrows its room, or the queue of the thread pool takes another page.
        assert!(calls < 12, "{}: {calls} allocations in {steps} steps with {builds} builds", variant.name);
    }
}
