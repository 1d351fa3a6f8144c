//! Tables on huge pages.
//!
//! A walk touches nodes in no order, so on big trees nearly every visit misses the TLB with 4 KiB pages: huge pages gave
//! 20 to 25 % at the third bounce. Tables smaller than one huge page live on the heap, where `align(64)` rows suffice.

use bytemuck::Pod;
use memmap2::MmapMut;
use std::marker::PhantomData;

const HUGE_PAGE: usize = 2 << 20;

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
