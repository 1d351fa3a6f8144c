//! The program's allocator: the system's, which ends in good order where memory ends.
//!
//! Tables whose size a file or a flag decides are claimed before they are made ([`crate::files::memory`]). Everything else grows
//! as it grows; where the system or the limit refuses it more, the standard library can only abort, which a shell shows as a
//! crash. So large blocks are counted here, and a refusal ends the program with a message and the status of an input that cannot
//! be used. Measured: a render of 16384 x 16384 pixels under `ulimit -v 4000000` ended with status 134 before, with 2 now.
#![allow(unsafe_code)]

use crate::files::memory::{known_limit, refusal_is_handled};
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::sync::atomic::{AtomicU64, Ordering};

/// Blocks from this size on are counted, bytes: smaller ones are many, and come to little beside the limit's share.
const LARGE: usize = 1 << 20;

/// Bytes in large blocks.
static TAKEN: AtomicU64 = AtomicU64::new(0);

/// The system's allocator under the limit of [`crate::files::memory`].
pub struct Guarded;

/// `size` bytes more are taken; false if that is beyond the limit: they are then not.
fn take(size: usize) -> bool {
    if size < LARGE {
        return true;
    }
    let before = TAKEN.fetch_add(size as u64, Ordering::Relaxed);
    let fits = before.saturating_add(size as u64) <= known_limit();
    if !fits {
        give_back(size);
    }
    fits
}

fn give_back(size: usize) {
    if size >= LARGE {
        TAKEN.fetch_sub(size as u64, Ordering::Relaxed);
    }
}

/// A block as it was found, or the end of the program.
fn checked(block: *mut u8, size: usize) -> *mut u8 {
    if block.is_null() && !refusal_is_handled() {
        refuse(size);
    }
    block
}

/// A block of `layout` that the system gives where it fits.
#[inline]
fn block_of(layout: Layout, system: impl FnOnce() -> *mut u8) -> *mut u8 {
    if !take(layout.size()) {
        return checked(std::ptr::null_mut(), layout.size());
    }
    let block = system();
    if block.is_null() {
        give_back(layout.size());
    }
    checked(block, layout.size())
}

#[cold]
fn refuse(size: usize) -> ! {
    // Nothing here takes memory.
    let _ = writeln!(
        std::io::stderr(),
        "error: out of memory: {} MB more are beyond what this process may take or the system gives; see --max-memory",
        size.div_ceil(1_000_000)
    );
    std::process::exit(2)
}

// SAFETY: every block comes from `System` and goes back to it with the layout it was asked for with; a null pointer, which the
// trait allows, is all that is ever returned in a block's place.
unsafe impl GlobalAlloc for Guarded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise about `layout` is the one that `System` asks for.
        block_of(layout, || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as in `alloc`.
        block_of(layout, || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        give_back(layout.size());
        // SAFETY: the block came from `System` with this layout.
        unsafe { System.dealloc(block, layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Both are held for a moment where the block moves; one that grows in place needs its growth alone.
        let more = size.saturating_sub(layout.size());
        if !take(size) {
            return checked(std::ptr::null_mut(), more);
        }
        // SAFETY: the block came from `System` with this layout, and the caller promises that `size` fits its alignment.
        let moved = unsafe { System.realloc(block, layout, size) };
        give_back(if moved.is_null() { size } else { layout.size() });
        checked(moved, more)
    }
}
