//! Tables on huge pages.
//!
//! A walk touches nodes in no order, so on big trees nearly every visit misses the TLB with 4 KiB pages: huge pages gave
//! 20 to 25 % at the third bounce. Tables smaller than one huge page live on the heap, where `align(64)` rows suffice.

use bytemuck::Pod;
use memmap2::MmapMut;
use std::marker::PhantomData;

const HUGE_PAGE: usize = 2 << 20;

/// Asks for huge pages under rows that are on the heap and about to be touched for the first time: 4 KiB pages take 0.55 ms a
/// MB to come and to go, huge ones 0.18. Advice may be refused, and small memory is not worth it.
pub(crate) fn advise<T>(rows: &mut [T]) {
    #[cfg(target_os = "linux")]
    if size_of_val(rows) >= 2 * HUGE_PAGE {
        let start = rows.as_mut_ptr().cast::<u8>();
        let skipped = start.align_offset(HUGE_PAGE);
        if skipped < HUGE_PAGE {
            let bytes = (size_of_val(rows) - skipped) / HUGE_PAGE * HUGE_PAGE;
            advise_pages(start.wrapping_add(skipped), bytes);
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = rows;
}

#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
fn advise_pages(start: *mut u8, bytes: usize) {
    // SAFETY: the pages lie within rows that the caller borrows mutably, and this advice changes neither what they hold nor who may
    // touch them, only how the kernel backs them. `memmap2` offers it for its own maps alone, and a `Vec` is what obvhs wants:
    // measured above.
    let _ = unsafe { rustix::mm::madvise(start.cast(), bytes, rustix::mm::Advice::LinuxHugepage) };
}

/// An empty list with room for `rows` rows on huge pages.
pub(crate) fn list<T>(rows: usize) -> Vec<T> {
    let mut list = Vec::with_capacity(rows);
    advise(list.spare_capacity_mut());
    list
}

/// A list of zeroed rows, on huge pages.
pub(crate) fn zeroed_list<T: bytemuck::Zeroable>(rows: usize) -> Vec<T> {
    let mut list = bytemuck::zeroed_vec(rows);
    advise(&mut list);
    list
}

/// A fixed number of rows of plain data, zeroed at first.
pub(super) struct Table<T> {
    memory: Memory<T>,
    rows: usize,
}

enum Memory<T> {
    Heap(Vec<T>),
    /// Rows start at byte `first`, the first multiple of the huge page size in the map.
    Map {
        map: MmapMut,
        first: usize,
        row: PhantomData<T>,
    },
}

impl<T: Pod> Table<T> {
    /// A table of `rows` zeroed rows.
    pub(super) fn zeroed(rows: usize) -> Self {
        let bytes = rows * size_of::<T>();
        let map = if bytes >= HUGE_PAGE { MmapMut::map_anon(bytes + HUGE_PAGE).ok() } else { None };
        let memory = match map {
            Some(map) => {
                // Advice may be refused (no such kernel, switched off): then these are ordinary pages.
                #[cfg(target_os = "linux")]
                let _ = map.advise(memmap2::Advice::HugePage);
                let first = map.as_ptr().align_offset(HUGE_PAGE);
                Memory::Map { map, first: if first < HUGE_PAGE { first } else { 0 }, row: PhantomData }
            }
            None => Memory::Heap(vec![T::zeroed(); rows]),
        };
        Self { memory, rows }
    }

    /// All rows.
    #[inline]
    pub(super) fn rows(&self) -> &[T] {
        match &self.memory {
            Memory::Heap(rows) => rows,
            Memory::Map { map, first, .. } => bytemuck::cast_slice(&map[*first..*first + self.rows * size_of::<T>()]),
        }
    }

    /// All rows.
    pub(super) fn rows_mut(&mut self) -> &mut [T] {
        match &mut self.memory {
            Memory::Heap(rows) => rows,
            Memory::Map { map, first, .. } => {
                bytemuck::cast_slice_mut(&mut map[*first..*first + self.rows * size_of::<T>()])
            }
        }
    }

    /// Bytes the rows take.
    pub(super) fn bytes(&self) -> usize {
        self.rows * size_of::<T>()
    }
}

impl<T> std::fmt::Debug for Table<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Table of {} rows", self.rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn big_tables_start_on_a_huge_page_and_hold_what_is_written() {
        let mut table = Table::<[u64; 8]>::zeroed(100_000);
        assert_eq!(table.rows().as_ptr() as usize % HUGE_PAGE, 0);
        assert_eq!((table.rows().len(), table.bytes()), (100_000, 6_400_000));
        table.rows_mut()[99_999] = [7; 8];
        assert_eq!((table.rows()[99_999], table.rows()[99_998]), ([7; 8], [0; 8]));
        assert_eq!(Table::<u32>::zeroed(3).rows(), [0; 3]);
    }
}
