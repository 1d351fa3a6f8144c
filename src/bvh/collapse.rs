//! From a binary tree to nodes of eight children, as [`crate::bvh::plan`] has it. How many nodes and blocks a subtree takes is known
//! before it is made: tables have their final size from the start, and threads fill disjoint slices of them.

use crate::bvh::huge::Table;
use crate::bvh::node::{LeafBlock, Node, leaf_word};
use crate::bvh::plan::{Decision, choose_children, place, plan};
use crate::bvh::rounding::{least_det, size_of};
use crate::bvh::threads;
use crate::lanes::LANES;
use glam::Vec3;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};

/// Wide nodes that a thread makes at a time, at most.
const PART: usize = 1 << 12;

/// The wide tree as tables.
pub(super) struct Wide {
    pub(super) nodes: Table<Node>,
    pub(super) leaves: Table<LeafBlock>,
    /// Per leaf block, the largest [`least_det`] of its triangles.
    pub(super) least_det: Vec<f32>,
    /// Per leaf block, the lanes whose triangles are tested in f64; empty unless [`Shape::any_precise`].
    pub(super) precise: Vec<u8>,
    /// Levels of nodes.
    pub(super) depth: usize,
}

/// What leaf blocks are filled with.
pub(super) struct Shape<V, P> {
    /// A triangle's corners.
    pub(super) vertices: V,
    /// Whether a triangle is tested in f64.
    pub(super) precise: P,
    /// Whether any is.
    pub(super) any_precise: bool,
    /// The largest |coordinate|.
    pub(super) extent: f32,
}

/// A wide node to be made, and where everything below it goes: tables' rows, and the number of the first of them.
struct Job<'a> {
    /// The binary node in its place.
    source: usize,
    depth: usize,
    node: &'a mut Node,
    below: Rows<'a>,
}

struct Rows<'a> {
    nodes: &'a mut [Node],
    first_node: usize,
    leaves: &'a mut [LeafBlock],
    least_det: &'a mut [f32],
    /// Empty if no triangle is precise.
    precise: &'a mut [u8],
    first_leaf: usize,
}

impl<'a> Rows<'a> {
    /// So many of them, and those behind.
    fn split(self, nodes: usize, leaves: usize) -> (Rows<'a>, Rows<'a>) {
        let (own_nodes, other_nodes) = self.nodes.split_at_mut(nodes);
        let (own_leaves, other_leaves) = self.leaves.split_at_mut(leaves);
        let (own_least, other_least) = self.least_det.split_at_mut(leaves);
        let of_precise = leaves.min(self.precise.len());
        let (own_precise, other_precise) = self.precise.split_at_mut(of_precise);
        let own = Rows {
            nodes: own_nodes,
            first_node: self.first_node,
            leaves: own_leaves,
            least_det: own_least,
            precise: own_precise,
            first_leaf: self.first_leaf,
        };
        let others = Rows {
            nodes: other_nodes,
            first_node: self.first_node + nodes,
            leaves: other_leaves,
            least_det: other_least,
            precise: other_precise,
            first_leaf: self.first_leaf + leaves,
        };
        (own, others)
    }
}

/// Collapses `tree`, which must be laid out depth first and whose leaves hold up to `leaf_size` triangles.
pub(super) fn collapse<V, P>(tree: &Bvh2, leaf_size: usize, shape: &Shape<V, P>, threads: usize) -> Wide
where
    V: Fn(u32) -> [[f32; 3]; 3] + Sync,
    P: Fn(u32) -> bool + Sync,
{
    let decisions = match tree.nodes.is_empty() {
        true => Vec::new(),
        false => plan(tree, leaf_size, threads),
    };
    let collapser = Collapser { tree, decisions: &decisions, shape };
    let taken = tree.nodes.first().map_or((0, 1), |root| collapser.taken(root));
    let (nodes, leaves) = (taken.0.max(1), taken.1);
    let mut wide = Wide {
        nodes: Table::zeroed(nodes),
        leaves: Table::zeroed(leaves),
        least_det: vec![0.0; leaves],
        precise: vec![0; if shape.any_precise { leaves } else { 0 }],
        depth: 1,
    };
    let (root, nodes) = wide.nodes.rows_mut().split_at_mut(1);
    let below = Rows {
        nodes,
        first_node: 1,
        leaves: wide.leaves.rows_mut(),
        least_det: &mut wide.least_det,
        precise: &mut wide.precise,
        first_leaf: 0,
    };
    if tree.nodes.is_empty() {
        (root[0], below.leaves[0]) = (Node::EMPTY, LeafBlock::EMPTY);
        return wide;
    }
    let (mut ready, mut pending) = (vec![], vec![Job { source: 0, depth: 1, node: &mut root[0], below }]);
    while let Some(job) = pending.pop() {
        if job.below.nodes.len() < PART || threads == 1 {
            ready.push(job);
        } else {
            wide.depth = wide.depth.max(job.depth);
            pending.extend(collapser.step(job));
        }
    }
    // Large ones first.
    ready.sort_by_key(|job| std::cmp::Reverse(job.below.nodes.len()));
    let deepest = threads::map(threads, ready, |job| collapser.build(job)).into_iter().max();
    wide.depth = wide.depth.max(deepest.unwrap_or(0));
    wide
}

struct Collapser<'a, V, P> {
    tree: &'a Bvh2,
    decisions: &'a [Decision],
    shape: &'a Shape<V, P>,
}

/// Children that are inner nodes: the binary nodes in their places, and the nodes and leaf blocks each takes, itself among them.
type Inner = ([(usize, usize, usize); LANES], usize);

impl<V: Fn(u32) -> [[f32; 3]; 3], P: Fn(u32) -> bool> Collapser<'_, V, P> {
    /// The wide nodes and leaf blocks that a binary node takes.
    fn taken(&self, node: &Bvh2Node) -> (usize, usize) {
        match node.is_leaf() {
            true => (0, 1),
            false => {
                let decision = &self.decisions[place(node)];
                (decision.nodes as usize, decision.leaves as usize)
            }
        }
    }
    fn becomes_leaf(&self, node: &Bvh2Node) -> bool {
        node.is_leaf() || self.decisions[place(node)].is_leaf()
    }

    /// Makes the node and its leaf blocks; the jobs below it.
    fn step<'a>(&self, job: Job<'a>) -> Vec<Job<'a>> {
        let mut rows = job.below;
        let (inner, leaves) = self.fill(job.source, job.node, &mut rows, 0, 0);
        let (own, mut rest) = rows.split(inner.1, leaves);
        let mut jobs = Vec::with_capacity(inner.1);
        for (node, &(source, nodes, leaves)) in own.nodes.iter_mut().zip(&inner.0) {
            let (below, others) = rest.split(nodes - 1, leaves);
            rest = others;
            jobs.push(Job { source, depth: job.depth + 1, node, below });
        }
        jobs
    }

    /// Makes the node and everything below it; the greatest depth.
    fn build(&self, job: Job) -> usize {
        /// A binary node, the row of its wide node, and the first rows of what is below it.
        struct Pending {
            source: usize,
            node: usize,
            first_node: usize,
            first_leaf: usize,
            depth: usize,
        }
        let mut rows = job.below;
        let mut deepest = job.depth;
        let mut pending = Vec::with_capacity(64);
        let extend = |pending: &mut Vec<Pending>, inner: Inner, node: usize, leaf: usize, depth: usize| {
            let (mut first_node, mut first_leaf) = (node + inner.1, leaf);
            let at = pending.len();
            for (i, &(source, nodes, leaves)) in inner.0[..inner.1].iter().enumerate() {
                pending.push(Pending { source, node: node + i, first_node, first_leaf, depth });
                (first_node, first_leaf) = (first_node + nodes - 1, first_leaf + leaves);
            }
            pending[at..].reverse();
        };
        let (inner, leaves) = self.fill(job.source, job.node, &mut rows, 0, 0);
        extend(&mut pending, inner, 0, leaves, job.depth + 1);
        while let Some(Pending { source, node, first_node, first_leaf, depth }) = pending.pop() {
            deepest = deepest.max(depth);
            let mut made = Node::EMPTY;
            let (inner, leaves) = self.fill(source, &mut made, &mut rows, first_node, first_leaf);
            rows.nodes[node] = made;
            extend(&mut pending, inner, first_node, first_leaf + leaves, depth + 1);
        }
        deepest
    }

    /// Makes the wide node of `source` and its leaf blocks, which begin at row `leaf`; its children that are nodes begin at row
    /// `node`. What these are, and how many leaf blocks were made.
    fn fill(&self, source: usize, wide: &mut Node, rows: &mut Rows, node: usize, leaf: usize) -> (Inner, usize) {
        let nodes = &self.tree.nodes;
        let mut children = [0; LANES];
        // A root that is a leaf is its own only child.
        let count = match self.becomes_leaf(&nodes[source]) {
            true => 1,
            false => choose_children(nodes, self.decisions, source, &mut children),
        };
        // The largest first; areas are not negative, so that their bits are in their order.
        let mut order = [0u64; LANES];
        for (key, &child) in order.iter_mut().zip(&children[..count]) {
            *key = u64::from(!half_area(&nodes[child as usize]).to_bits()) << 32 | u64::from(child);
        }
        order[..count].sort_unstable();
        *wide = Node::EMPTY;
        wide.count = count as u32;
        let (mut inner, mut leaves): (Inner, usize) = (([(0, 0, 0); LANES], 0), 0);
        for (slot, &key) in order[..count].iter().enumerate() {
            let child = key as u32 as usize;
            let from = &nodes[child];
            let (min, max) = (from.min.to_array(), from.max.to_array());
            for axis in 0..3 {
                wide.bounds[axis][0][slot] = min[axis];
                wide.bounds[axis][1][slot] = max[axis];
            }
            if self.becomes_leaf(from) {
                wide.children[slot] = self.leaf(child, rows, leaf + leaves);
                leaves += 1;
            } else {
                wide.children[slot] = (rows.first_node + node + inner.1) as u32;
                let (nodes, leaves) = self.taken(from);
                inner.0[inner.1] = (child, nodes, leaves);
                inner.1 += 1;
            }
        }
        (inner, leaves)
    }

    /// Fills the leaf block of everything below a binary node; the word that leads to it.
    fn leaf(&self, source: usize, rows: &mut Rows, row: usize) -> u32 {
        let (ids, count) = self.triangles_below(source);
        let mut block = LeafBlock::EMPTY;
        let (mut largest, mut precise) = (0.0f32, 0);
        let mut corners = [[[0.0; 3]; 3]; LANES];
        for (lane, &id) in ids[..count].iter().enumerate() {
            block.ids[lane] = id;
            let vertices = (self.shape.vertices)(id);
            for (vertex, position) in vertices.into_iter().enumerate() {
                for (axis, coordinate) in position.into_iter().enumerate() {
                    block.vertices[vertex][axis][lane] = coordinate;
                }
            }
            corners[lane] = vertices;
            largest = largest.max(size_of(vertices));
            precise |= u8::from(self.shape.any_precise && (self.shape.precise)(id)) << lane;
        }
        rows.leaves[row] = block;
        // It grows with the triangle.
        let whole = size_of(corners[..count].iter().copied().flatten());
        rows.least_det[row] = least_det(largest, whole, self.shape.extent);
        if let Some(lanes) = rows.precise.get_mut(row) {
            *lanes = precise;
        }
        leaf_word(rows.first_leaf + row, count, precise != 0)
    }

    /// The ids of all triangles below a binary node, ascending.
    fn triangles_below(&self, root: usize) -> ([u32; LANES], usize) {
        let (mut ids, mut count) = ([0; LANES], 0);
        let (mut open, mut top) = ([root as u32; LANES + 1], 1);
        while top > 0 {
            top -= 1;
            let node = &self.tree.nodes[open[top] as usize];
            let first = node.first_index;
            if node.is_leaf() {
                let own = &self.tree.primitive_indices[first as usize..][..node.prim_count as usize];
                ids[count..count + own.len()].copy_from_slice(own);
                count += own.len();
            } else {
                (open[top], open[top + 1]) = (first, first + 1);
                top += 2;
            }
        }
        ids[..count].sort_unstable();
        (ids, count)
    }
}

fn half_area(node: &Bvh2Node) -> f32 {
    let Vec3 { x, y, z } = node.max - node.min;
    x * y + y * z + z * x
}
