//! What the threads of a render share and change, and how often each of them does.
//!
//! **Law:** but for the wish to stop, which is a plain store, worker threads lock and change nothing that is not of a type of
//! this file, and no method of these types takes a lock or does an atomic read-modify-write without the [`Operations`] that
//! counts it. So the figure of a render's statistics is counted where it happens, not estimated; a test reads the sources.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// How often one thread has locked something or changed an atomic in place. A lock counts once, with its release; a plain load
/// or store makes no thread wait for another and does not count.
#[derive(Debug, Default)]
pub(super) struct Operations(u64);

impl Operations {
    /// So many so far.
    pub(super) fn count(&self) -> u64 {
        self.0
    }

    /// Adds those of another count of the same thread.
    pub(super) fn add(&mut self, other: &Operations) {
        self.0 += other.0;
    }
}

/// A number that threads add to.
pub(super) struct SharedSum(AtomicU64);

impl SharedSum {
    pub(super) fn new(value: u64) -> SharedSum {
        SharedSum(AtomicU64::new(value))
    }

    /// Adds `more`; the sum before.
    pub(super) fn add(&self, more: u64, operations: &mut Operations) -> u64 {
        operations.0 += 1;
        self.0.fetch_add(more, Ordering::Relaxed)
    }

    /// The sum as it is now.
    pub(super) fn value(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// A value that one thread at a time works on.
pub(super) struct Locked<T>(Mutex<T>);

// A poisoned lock means that another thread has panicked while it held it; that panic is told by the scope of the threads.
impl<T> Locked<T> {
    pub(super) fn new(value: T) -> Locked<T> {
        Locked(Mutex::new(value))
    }

    /// The value, for as long as the guard lives.
    pub(super) fn lock(&self, operations: &mut Operations) -> MutexGuard<'_, T> {
        operations.0 += 1;
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// The value, while no other thread sees it: takes no lock.
    pub(super) fn get_mut(&mut self) -> &mut T {
        self.0.get_mut().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// The value itself.
    pub(super) fn into_inner(self) -> T {
        self.0.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// A value that all threads read during a pass, and one changes between passes.
pub(super) struct Between<T>(RwLock<T>);

impl<T> Between<T> {
    pub(super) fn new(value: T) -> Between<T> {
        Between(RwLock::new(value))
    }

    /// The value, for a pass.
    pub(super) fn read(&self, operations: &mut Operations) -> RwLockReadGuard<'_, T> {
        operations.0 += 1;
        self.0.read().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// The value, between passes.
    pub(super) fn write(&self, operations: &mut Operations) -> RwLockWriteGuard<'_, T> {
        operations.0 += 1;
        self.0.write().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// The value itself.
    pub(super) fn into_inner(self) -> T {
        self.0.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// Where helpers wait for the next pass, and whoever leads them for its end.
#[derive(Default)]
pub(super) struct Gate {
    state: Mutex<GateState>,
    changed: Condvar,
}

#[derive(Default)]
struct GateState {
    /// Passes begun.
    passes: u64,
    /// To how many samples a pixel the last of them goes.
    end: u32,
    /// Helpers that have not finished it.
    working: usize,
    /// There will be no other.
    over: bool,
    /// A helper has panicked.
    broken: bool,
}

impl Gate {
    fn lock(&self, operations: &mut Operations) -> MutexGuard<'_, GateState> {
        operations.0 += 1;
        self.state.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Lets `helpers` begin a pass to `end` samples a pixel.
    pub(super) fn begin(&self, helpers: usize, end: u32, operations: &mut Operations) {
        let mut state = self.lock(operations);
        (state.passes, state.end, state.working) = (state.passes + 1, end, helpers);
        self.changed.notify_all();
    }

    /// Waits until all helpers have finished the pass; false if one of them has panicked and will not.
    pub(super) fn finished(&self, operations: &mut Operations) -> bool {
        let mut state = self.lock(operations);
        while state.working > 0 {
            state = self.changed.wait(state).unwrap_or_else(|poisoned| poisoned.into_inner());
        }
        !state.broken
    }

    /// Sends the helpers home.
    pub(super) fn close(&self, operations: &mut Operations) {
        self.lock(operations).over = true;
        self.changed.notify_all();
    }

    /// What a helper does: calls `work` for each pass, with where it goes to, until there will be no other.
    pub(super) fn help(&self, operations: &mut Operations, mut work: impl FnMut(u32, &mut Operations)) {
        let mut seen = 0;
        loop {
            let mut state = self.lock(operations);
            while state.passes == seen && !state.over {
                state = self.changed.wait(state).unwrap_or_else(|poisoned| poisoned.into_inner());
            }
            if state.passes == seen {
                return;
            }
            seen = state.passes;
            let end = state.end;
            drop(state);
            // Said even if `work` panics: who waits would else wait for ever. Its lock is counted here.
            operations.0 += 1;
            let _finished = Finished(self);
            work(end, operations);
        }
    }
}

/// Tells the gate that a helper has finished a pass, when it is dropped.
struct Finished<'g>(&'g Gate);

impl Drop for Finished<'_> {
    fn drop(&mut self) {
        let mut state = self.0.lock(&mut Operations::default());
        state.working -= 1;
        state.broken |= std::thread::panicking();
        self.0.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::Scene;
    use crate::render::{Stats, render};
    use crate::settings::{Engine, Settings};

    #[test]
    fn what_is_done_is_counted_and_reading_alone_is_not() {
        let (sum, mut value, mut operations) = (SharedSum::new(5), Locked::new(1), Operations::default());
        assert_eq!((sum.add(2, &mut operations), sum.add(1, &mut operations), sum.value()), (5, 7, 8));
        *value.lock(&mut operations) += 1;
        assert_eq!((*value.get_mut(), value.into_inner(), operations.count()), (2, 2, 3));
    }

    /// Three a tile: it is taken, it is locked, its samples are added to those of the render. One a worker and pass: there is
    /// no tile left. Helpers do three more in a pass (they are called, they look at what is to be done, they say that it is) and
    /// one at the end; who leads them opens the gate, looks, waits, and looks at the outcome, and at the end closes it.
    #[test]
    fn a_render_of_known_tiles_has_a_known_number_of_operations() {
        let scene = Scene::load("builtin:rooms:1").unwrap().prepare().unwrap();
        let counts = |settings: Settings| {
            let Stats { threads, tiles, shared_operations, .. } = render(&scene, &settings).stats;
            (threads, tiles, shared_operations)
        };
        let film = |width, height, spp, threads| Settings {
            width: Some(width),
            height: Some(height),
            spp,
            threads,
            ..Settings::plain()
        };
        let with_helpers = |helpers: u64, passes: u64| (3 * helpers + 4) * passes + helpers + 1;
        // Eight and more samples a pixel: tiles of 16 x 16 pixels, the last ones in part.
        assert_eq!(counts(film(64, 32, 8, 1)), (1, 8, 3 * 8 + 1));
        assert_eq!(counts(film(65, 33, 8, 3)), (3, 15, 3 * 15 + 3 + with_helpers(2, 1)));
        assert_eq!(
            counts(Settings { engine: Engine::Scalar, ..film(64, 32, 8, 2) }),
            (2, 8, 3 * 8 + 2 + with_helpers(1, 1))
        );
        // One: of 64 x 32; there are no more workers than tiles.
        assert_eq!(counts(film(128, 64, 1, 9)), (4, 4, 3 * 4 + 4 + with_helpers(3, 1)));
        // A pass takes 64 samples a pixel at most.
        assert_eq!(counts(film(8, 8, 65, 1)), (1, 2, 3 * 2 + 2));
        // What is learned before is not among them.
        assert_eq!(
            counts(Settings { width: Some(64), height: Some(32), spp: 8, threads: 2, ..Settings::default() }).2,
            26 + with_helpers(1, 1)
        );
    }
}
