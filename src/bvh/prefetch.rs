//! The one place that asks the CPU to fetch memory ahead: without it a visit in a big tree waits for main memory. It was
//! worth 7 to 60 % to one-ray walks after a bounce in the prototype of these walks.
#![allow(unsafe_code)]

/// Starts to fetch the cache lines of `row`.
#[inline(always)]
pub(crate) fn prefetch<T>(row: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = std::ptr::from_ref(row).cast::<i8>();
        for line in 0..size_of::<T>().div_ceil(64) {
            // SAFETY: prefetching is a hint and never faults; the address is inside `row`, so computing it is in bounds.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(first.add(line * 64)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = row;
}
