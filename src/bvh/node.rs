//! The tree's tables: nodes of eight children, leaf blocks of up to eight triangles, both one array a field.
//!
//! Plain `f32` bounds: nodes of 128 B with bounds of 8 bits cost 10 to 29 % of all speed, decoding them takes longer than
//! the cache lines they save. One block per leaf: `t`, ids and vertices of a leaf are five cache lines in a row.

use crate::lanes::LANES;
use bytemuck::{Pod, Zeroable};

/// The id in lanes of a leaf block that hold no triangle.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Set in the word of a child that is a leaf.
pub(crate) const LEAF_BIT: u32 = 1 << 31;
const BLOCK_BITS: u32 = 28;
/// Set in the word of a leaf of which some triangle is precise.
const PRECISE_BIT: u32 = 1 << 27;

/// Eight child boxes and where the children are. Children fill the slots from 0 on, the largest box first; slots beyond
/// hold boxes that no ray hits (`min = +inf`, `max = -inf`).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Node {
    /// `[axis][0 for min, 1 for max][child]`, scene units.
    pub bounds: [[[f32; LANES]; 2]; 3],
    /// A child in a word: a node's index, or `LEAF_BIT | (triangles - 1) << 28 | PRECISE_BIT | block`. In empty slots the word of a leaf
    /// that exists, so that a walk led there by a ray of NaNs only wastes its time.
    pub(crate) children: [u32; LANES],
    /// How many slots are filled.
    pub(crate) count: u32,
    padding: [u32; 7],
}

/// Where a child slot leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// A node, by its index.
    Inner(usize),
    /// A leaf block, by its index, and how many of its lanes, from 0 on, hold triangles.
    Leaf(usize, usize),
    /// Nothing.
    Empty,
}

/// Up to eight triangles, ids ascending; lanes without one hold NaN vertices and the id [`NO_TRIANGLE`].
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct LeafBlock {
    /// `[vertex][axis][lane]`, scene units.
    pub vertices: [[[f32; LANES]; 3]; 3],
    /// Triangle ids.
    pub ids: [u32; LANES],
}

impl Node {
    /// A node without children.
    pub(crate) const EMPTY: Self = Self {
        bounds: [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3],
        children: [LEAF_BIT; LANES],
        count: 0,
        padding: [0; 7],
    };

    /// How many children there are; they fill the slots from 0 on.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count as usize
    }

    /// Where slot `slot` leads.
    #[inline(always)]
    pub fn child(&self, slot: usize) -> Child {
        if slot >= self.count() {
            Child::Empty
        } else if is_leaf(self.children[slot]) {
            Child::Leaf(block_of(self.children[slot]), triangles_in(self.children[slot]))
        } else {
            Child::Inner(self.children[slot] as usize)
        }
    }
}

impl LeafBlock {
    /// The corners of the triangle in a lane.
    #[inline]
    pub fn corners(&self, lane: usize) -> [[f32; 3]; 3] {
        self.vertices.map(|axes| axes.map(|values| values[lane]))
    }
    /// A block without triangles.
    pub(crate) const EMPTY: Self = Self { vertices: [[[f32::NAN; LANES]; 3]; 3], ids: [NO_TRIANGLE; LANES] };
}

/// Whether a child's word leads to a leaf.
#[inline(always)]
pub(crate) fn is_leaf(word: u32) -> bool {
    word & LEAF_BIT != 0
}

/// The leaf block a child's word leads to.
#[inline(always)]
pub(crate) fn block_of(word: u32) -> usize {
    (word & (PRECISE_BIT - 1)) as usize
}

/// Whether the leaf of a child's word holds a triangle that is tested in f64.
#[inline(always)]
pub(crate) fn holds_precise(word: u32) -> bool {
    word & PRECISE_BIT != 0
}

/// How many triangles the leaf of a child's word holds.
#[inline(always)]
pub(crate) fn triangles_in(word: u32) -> usize {
    (word >> BLOCK_BITS & 7) as usize + 1
}

/// The word of a leaf child; `precise`: it holds a triangle that is tested in f64.
pub(crate) fn leaf_word(block: usize, triangles: usize, precise: bool) -> u32 {
    assert!(block < PRECISE_BIT as usize, "leaf block {block}");
    assert!((1..=LANES).contains(&triangles), "a leaf of {triangles} triangles");
    let precise = if precise { PRECISE_BIT } else { 0 };
    LEAF_BIT | (triangles as u32 - 1) << BLOCK_BITS | precise | block as u32
}

const _: () = assert!(size_of::<Node>() == 256 && size_of::<LeafBlock>() == 320);

/// The tables a walk reads.
#[derive(Clone, Copy)]
pub(crate) struct Tables<'a> {
    pub(crate) nodes: &'a [Node],
    pub(crate) leaves: &'a [LeafBlock],
    /// Classes of triangles ([`crate::bvh::precise`]); empty if all are common.
    pub(crate) classes: &'a [u8],
    /// Per leaf block, its lanes that hold precise triangles; empty if all are common.
    pub(crate) precise: &'a [u8],
    /// Per leaf block, the largest [`crate::bvh::rounding::least_det`] of its triangles.
    pub(crate) least_det: &'a [f32],
    /// The largest |coordinate|.
    pub(crate) extent: f32,
}
