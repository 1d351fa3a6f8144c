//! What the walks of sixteen need for a while.

/// Sixteen numbers, a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Row(pub(super) [f32; 16]);

impl Row {
    pub(super) const ZERO: Self = Self([0.0; 16]);
}

/// The most corners in a leaf of the list.
pub(super) const CORNERS: usize = crate::bvh::flat::CORNERS;

/// The stack, and the sheared corners of the leaf that is visited. Keep one per thread.
#[derive(Clone, Debug)]
pub struct Memory {
    pub(super) words: Vec<u32>,
    /// Distances to the boxes, NaN where a ray misses its own.
    pub(super) near: Vec<Row>,
    /// Rays that hit the boxes.
    pub(super) masks: Vec<u16>,
    pub(super) corners: Box<[[Row; 3]; CORNERS]>,
}

impl Default for Memory {
    fn default() -> Self {
        Self { words: Vec::new(), near: Vec::new(), masks: Vec::new(), corners: Box::new([[Row::ZERO; 3]; CORNERS]) }
    }
}

impl Memory {
    /// Room for `entries` of the stack, and for the one that is written before it is known whether it is kept.
    pub fn reserve(&mut self, entries: usize) {
        let entries = entries + 1;
        if self.words.len() < entries {
            self.words.resize(entries, 0);
            self.near.resize(entries, Row::ZERO);
            self.masks.resize(entries, 0);
        }
    }
}
