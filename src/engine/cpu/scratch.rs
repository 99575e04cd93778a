//! Working memory of the threads: one set each, kept from step to step.

use std::sync::{Mutex, MutexGuard};

use super::mode::{Slot, new_tile};
use super::search::BuildScratch;
use crate::real::lanes::{SLOTS, Tile};

/// Tiles of one kind, one a thread.
pub struct Tiles<S>(Vec<Mutex<Option<Box<Tile<S>>>>>);

/// Working memory of list builds, one a thread.
pub struct Pool(Vec<Mutex<BuildScratch>>);

/// The calling thread's entry. Only one thread ever asks for it, so there is no waiting.
fn mine<T>(entries: &[Mutex<T>]) -> MutexGuard<'_, T> {
    let entry = &entries[rayon::current_thread_index().unwrap_or(0) % entries.len()];
    entry.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl Pool {
    pub fn new(threads: usize) -> Self {
        Self((0..threads.max(1)).map(|_| Mutex::default()).collect())
    }

    pub fn build(&self) -> MutexGuard<'_, BuildScratch> {
        mine(&self.0)
    }

    pub fn bytes(&self) -> usize {
        self.0.iter().map(|entry| entry.lock().map_or(0, |scratch| scratch.bytes())).sum()
    }
}

impl<S: Slot> Tiles<S> {
    pub fn new(threads: usize) -> Self {
        Self((0..threads.max(1)).map(|_| Mutex::new(None)).collect())
    }

    /// Calls `work` with the thread's tile.
    pub fn with<T>(&self, work: impl FnOnce(&mut Tile<S>) -> T) -> T {
        work(mine(&self.0).get_or_insert_with(new_tile))
    }

    pub fn bytes(&self) -> usize {
        let taken = self.0.iter().filter(|entry| entry.lock().is_ok_and(|tile| tile.is_some())).count();
        taken * SLOTS * size_of::<S>()
    }
}
