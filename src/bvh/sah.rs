//! A binary tree from the top down, an obvhs [`Bvh2`]: at every node the best split by the surface area heuristic
//! ([`crate::bvh::split`]), down to leaves of one or two triangles.
//!
//! Against obvhs's own bottom-up builder (PLOC) the finished trees trace 3 to 15 % faster on a scene of 1.2 M triangles and far
//! faster on a box of 36. Leaves of two triangles save nodes, and the time of whatever looks at nodes after this;
//! leaves of four cost 12 to 18 % of speed in rooms, where walls end up in them with what stands before them.
//!
//! A subtree of n triangles takes at most 2n - 2 nodes below its root, so every subtree has its place before it is built: threads
//! fill disjoint slices, and leave gaps that [`crate::bvh::reinsert`] closes. Where the gaps are depends on the number of threads; the
//! order of the nodes does not: a pair of siblings, everything below the first, everything below the second.

use crate::bvh::prims::{Area, Known, PrimBox, aabb};
use crate::bvh::split::{halve, split, split_shared};
use crate::bvh::{huge, threads};
use obvhs::bvh2::{Bvh2, node::Bvh2Node};

/// Sets of fewer triangles are split by one thread, the threads share larger ones.
const SHARED: usize = 1 << 17;
/// The least triangles of a subtree that one thread builds.
const PART: usize = 1 << 12;
/// Subtrees for each thread: they are not of one size.
const PARTS_PER_THREAD: usize = 8;

/// Nodes whose subtree is still to be built: its triangles, and where its nodes go.
struct Range<'a> {
    /// The triangles.
    from: &'a mut [PrimBox],
    /// Room for as many.
    to: &'a mut [PrimBox],
    known: Known,
    /// The triangles' places among all.
    first: usize,
    /// Their ids, once they are in the order of the leaves.
    ids: &'a mut [u32],
    /// Room for the nodes below, the first of them `first_node` in the whole tree, and for the numbers of their parents.
    nodes: &'a mut [Bvh2Node],
    parents: &'a mut [u32],
    first_node: usize,
    node: usize,
    depth: usize,
}

/// How the tree is built.
#[derive(Clone, Copy)]
struct Rules {
    leaf_size: usize,
    area: Area,
    /// A split by bins may peel off one triangle at a time; beyond this depth halves are cut instead.
    depth_of_halving: usize,
}

/// The node of a set of triangles, whose subtree, if it has one, begins at `first_node`.
#[inline(always)]
fn node_of(known: &Known, count: usize, leaf_size: usize, first: usize, first_node: usize) -> Bvh2Node {
    match count <= leaf_size {
        true => Bvh2Node::new(aabb(known.bounds), count as u32, first as u32),
        false => Bvh2Node::new(aabb(known.bounds), 0, first_node as u32),
    }
}

/// The tree of `prims`, which are `known` and come back in no order, with leaves of up to `leaf_size` triangles. Between its nodes
/// are gaps of zeros; its parents are known, and its depth.
pub(super) fn build(prims: &mut [PrimBox], known: Known, leaf_size: usize, threads: usize) -> Bvh2 {
    if prims.is_empty() {
        return Bvh2::default();
    }
    let count = prims.len();
    let mut tree = Bvh2::zeroed(count);
    huge::advise(&mut tree.nodes);
    tree.parents = huge::zeroed_list(tree.nodes.len());
    let bounds = aabb(known.bounds);
    let rules = Rules {
        leaf_size,
        area: Area::of_scene((bounds.max - bounds.min).into()),
        depth_of_halving: 32 + 2 * count.ilog2() as usize,
    };
    let part = (count / (PARTS_PER_THREAD * threads)).max(PART);
    let mut other = huge::Table::zeroed(count);
    let (root, nodes) = tree.nodes.split_at_mut(1);
    root[0] = node_of(&known, count, leaf_size, 0, 1);
    let whole = Range {
        from: prims,
        to: other.rows_mut(),
        known,
        first: 0,
        ids: &mut tree.primitive_indices,
        nodes,
        parents: &mut tree.parents[1..],
        first_node: 1,
        node: 0,
        depth: 1,
    };
    let (mut ready, mut pending) = (vec![], vec![whole]);
    while let Some(range) = pending.pop() {
        if range.from.len() <= part || threads == 1 {
            ready.push(range);
        } else {
            pending.extend(range.step(rules, threads));
        }
    }
    // Large ones first: then no thread is left alone with one at the end.
    ready.sort_by_key(|range| std::cmp::Reverse(range.from.len()));
    let depth = threads::map(threads, ready, |range| range.build(rules)).into_iter().max();
    tree.max_depth = depth.unwrap_or(0) + 1;
    tree
}

impl<'a> Range<'a> {
    /// One split; both sides.
    fn step(self, rules: Rules, threads: usize) -> [Range<'a>; 2] {
        let Range { from, to, known, first, ids, nodes, parents, first_node, node, depth } = self;
        let (left, [known_left, known_right]) = match (depth < rules.depth_of_halving, from.len() < SHARED) {
            (false, _) => halve(from, to),
            (true, true) => split(from, to, &known, rules.area),
            (true, false) => split_shared(from, to, &known, rules.area, threads),
        };
        let right = from.len() - left;
        let (pair, nodes) = nodes.split_at_mut(2);
        let (own_parents, parents) = parents.split_at_mut(2);
        let (nodes_left, nodes_right) = nodes.split_at_mut(2 * left - 2);
        let (parents_left, parents_right) = parents.split_at_mut(2 * left - 2);
        let (first_left, first_right) = (first_node + 2, first_node + 2 * left);
        pair[0] = node_of(&known_left, left, rules.leaf_size, first, first_left);
        pair[1] = node_of(&known_right, right, rules.leaf_size, first + left, first_right);
        own_parents.fill(node as u32);
        // The buffers change places.
        let (from_left, from_right) = to.split_at_mut(left);
        let (to_left, to_right) = from.split_at_mut(left);
        let (ids_left, ids_right) = ids.split_at_mut(left);
        let depth = depth + 1;
        [
            Range {
                from: from_left,
                to: to_left,
                known: known_left,
                first,
                ids: ids_left,
                nodes: nodes_left,
                parents: parents_left,
                first_node: first_left,
                node: first_node,
                depth,
            },
            Range {
                from: from_right,
                to: to_right,
                known: known_right,
                first: first + left,
                ids: ids_right,
                nodes: nodes_right,
                parents: parents_right,
                first_node: first_right,
                node: first_node + 1,
                depth,
            },
        ]
    }

    /// Everything below, its nodes without gaps; the greatest depth.
    fn build(self, rules: Rules) -> usize {
        /// `count` triangles from `start` on, in `to` if `moved`, under a node.
        struct Pending {
            start: usize,
            count: usize,
            node: usize,
            depth: usize,
            moved: bool,
            known: Known,
        }
        let Range { from: own, to: other, known, first, ids, nodes, parents, first_node, node, depth } = self;
        let count = own.len();
        if count <= rules.leaf_size {
            ids.iter_mut().zip(own.iter()).for_each(|(id, prim)| *id = prim.id());
            return depth;
        }
        let mut used = 0;
        let mut deepest = depth;
        let mut pending = Vec::with_capacity(64);
        pending.push(Pending { start: 0, count, node, depth, moved: false, known });
        while let Some(Pending { start, count, node, depth, moved, known }) = pending.pop() {
            let range = start..start + count;
            let (from, to) = if moved { (&mut *other, &mut *own) } else { (&mut *own, &mut *other) };
            let (from, to) = (&from[range.clone()], &mut to[range]);
            let (left, [known_left, known_right]) = match depth < rules.depth_of_halving {
                true => split(from, to, &known, rules.area),
                false => halve(from, to),
            };
            deepest = deepest.max(depth + 1);
            let pair = used;
            used += 2;
            // The root's first children follow it at once, and this node's whatever has been written until then.
            if pair > 0 {
                nodes[node - first_node].first_index = (first_node + pair) as u32;
            }
            parents[pair..pair + 2].fill(node as u32);
            // From right to left: the last one in is the next one out.
            for (offset, count, side, known) in [(left, count - left, 1, known_right), (0, left, 0, known_left)] {
                let start = start + offset;
                nodes[pair + side] = node_of(&known, count, rules.leaf_size, first + start, 0);
                if count <= rules.leaf_size {
                    let leaf = ids[start..start + count].iter_mut().zip(&to[offset..]);
                    leaf.for_each(|(id, prim)| *id = prim.id());
                } else {
                    let node = first_node + pair + side;
                    pending.push(Pending { start, count, node, depth: depth + 1, moved: !moved, known });
                }
            }
        }
        deepest
    }
}
