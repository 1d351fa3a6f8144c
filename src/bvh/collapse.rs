//! From a binary tree to nodes of eight children, by dynamic programming (Ylitie, Karras and Laine 2017, "Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3): for every binary node the least cost of
//! standing for it by one to seven wide subtrees. It fills 7.1 of 8 slots where a greedy collapse fills 4.1, halves the
//! nodes and gave 5 to 10 % on big scenes, up to 35 % on a box of 36 triangles. The cost constants hardly matter.

use crate::bvh::node::{LeafBlock, Node, leaf_word};
use crate::bvh::sah::Area;
use crate::lanes::LANES;
use glam::Vec3;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};

/// Cost of visiting a node, per chance of being hit.
const NODE_COST: f32 = 1.0;

/// Cost of visiting a leaf: one-ray walks pay for the block, packets for each triangle.
fn leaf_cost(triangles: u8) -> f32 {
    0.5 + 0.0625 * triangles as f32
}

/// What is decided for a binary node.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// `cost[i]`: by at most `i + 1` wide subtrees.
    cost: [f32; LANES - 1],
    /// `left[i]`: how many of `i + 1` subtrees the left child gets; 0: one fewer subtree is no worse. The last entry is for
    /// the eight children of a wide node in this place.
    left: [u8; LANES],
    /// As one subtree it is a leaf.
    leaf: bool,
    /// Triangles below, counted up to one more than fit into a leaf.
    triangles: u8,
}

/// The wide tree as lists.
pub(super) struct Wide {
    pub(super) nodes: Vec<Node>,
    pub(super) leaves: Vec<LeafBlock>,
    /// Levels of nodes.
    pub(super) depth: usize,
}

/// Collapses `tree`, whose parents must come before their children and whose leaves hold up to `leaf_size` triangles.
/// `vertices` gives a triangle's corners, `precise` says which are tested in f64.
pub(super) fn collapse(
    tree: &Bvh2,
    leaf_size: usize,
    vertices: impl Fn(u32) -> [[f32; 3]; 3],
    precise: impl Fn(u32) -> bool,
) -> Wide {
    let mut wide = Wide { nodes: vec![Node::EMPTY], leaves: vec![], depth: 1 };
    if tree.nodes.is_empty() {
        wide.leaves.push(LeafBlock::EMPTY);
        return wide;
    }
    let plans = plan(tree, leaf_size);
    let mut children = Vec::with_capacity(LANES);
    let mut ids = Vec::with_capacity(LANES);
    let mut pending = vec![(0usize, 0usize, 1usize)];
    while let Some((source, target, depth)) = pending.pop() {
        wide.depth = wide.depth.max(depth);
        choose_children(tree, &plans, source, &mut children);
        children.sort_by(|&a, &b| {
            let area = |node: usize| half_area(&tree.nodes[node]);
            area(b).total_cmp(&area(a)).then(a.cmp(&b))
        });
        let mut node = Node::EMPTY;
        node.count = children.len() as u32;
        let first_inner = wide.nodes.len();
        let mut inner = 0;
        for (slot, &child) in children.iter().enumerate() {
            let (min, max) = (tree.nodes[child].min.to_array(), tree.nodes[child].max.to_array());
            for axis in 0..3 {
                node.bounds[axis][0][slot] = min[axis];
                node.bounds[axis][1][slot] = max[axis];
            }
            if plans[child].leaf {
                triangles_below(tree, child, &mut ids);
                node.children[slot] = leaf_word(wide.leaves.len(), ids.len(), ids.iter().any(|&id| precise(id)));
                wide.leaves.push(leaf_block(&ids, &vertices));
            } else {
                node.children[slot] = (first_inner + inner) as u32;
                inner += 1;
            }
        }
        wide.nodes[target] = node;
        wide.nodes.resize(first_inner + inner, Node::EMPTY);
        // The last one in is the next one out: the first child's subtree follows its siblings at once.
        let inner_children = children.iter().filter(|&&child| !plans[child].leaf);
        let at = pending.len();
        pending.extend(inner_children.zip(first_inner..).map(|(&child, index)| (child, index, depth + 1)));
        pending[at..].reverse();
    }
    wide
}

fn half_area(node: &Bvh2Node) -> f32 {
    let Vec3 { x, y, z } = node.max - node.min;
    x * y + y * z + z * x
}

/// The best plan of every binary node, children before parents.
fn plan(tree: &Bvh2, leaf_size: usize) -> Vec<Plan> {
    assert!(tree.children_are_ordered_after_parents);
    let area = Area::of_scene(tree.nodes[0].max - tree.nodes[0].min);
    let mut plans = vec![Plan::default(); tree.nodes.len()];
    for index in (0..tree.nodes.len()).rev() {
        let node = &tree.nodes[index];
        let area = area.half(node.max - node.min);
        if node.is_leaf() {
            assert!(node.prim_count as usize <= leaf_size, "a leaf of {} triangles", node.prim_count);
            plans[index] = Plan {
                cost: [area * leaf_cost(node.prim_count as u8); LANES - 1],
                left: [0; LANES],
                leaf: true,
                triangles: node.prim_count as u8,
            };
            continue;
        }
        let (left, right) = (plans[node.first_index as usize], plans[node.first_index as usize + 1]);
        let best_split = |subtrees: usize| {
            (1..subtrees)
                .filter(|&k| k < LANES && subtrees - k < LANES)
                .map(|k| (left.cost[k - 1] + right.cost[subtrees - k - 1], k as u8))
                .fold((f32::INFINITY, 1), |best, one| if one.0 < best.0 { one } else { best })
        };
        let mut plan = Plan { triangles: (left.triangles + right.triangles).min(LANES as u8 + 1), ..Plan::default() };
        let (spread, k) = best_split(LANES);
        plan.left[LANES - 1] = k;
        plan.cost[0] = spread + area * NODE_COST;
        let as_leaf = area * leaf_cost(plan.triangles);
        if plan.triangles as usize <= leaf_size && as_leaf <= plan.cost[0] {
            (plan.cost[0], plan.leaf) = (as_leaf, true);
        }
        for subtrees in 2..LANES {
            let (cost, k) = best_split(subtrees);
            let better = cost < plan.cost[subtrees - 2];
            plan.cost[subtrees - 1] = if better { cost } else { plan.cost[subtrees - 2] };
            plan.left[subtrees - 1] = if better { k } else { 0 };
        }
        plans[index] = plan;
    }
    plans
}

/// The binary nodes that become the children of the wide node at `source`.
fn choose_children(tree: &Bvh2, plans: &[Plan], source: usize, children: &mut Vec<usize>) {
    children.clear();
    if plans[source].leaf {
        // Only the root: a tree of one leaf.
        children.push(source);
        return;
    }
    let mut open = [(0usize, 0usize); LANES];
    let mut top = 0;
    let mut descend = |node: usize, subtrees: usize, open: &mut [(usize, usize); LANES]| {
        let left = plans[node].left[subtrees - 1] as usize;
        let first = tree.nodes[node].first_index as usize;
        open[top] = (first + 1, subtrees - left);
        top += 1;
        let mut next = (first, left);
        loop {
            let (node, mut subtrees) = next;
            while subtrees > 1 && plans[node].left[subtrees - 1] == 0 {
                subtrees -= 1;
            }
            if subtrees > 1 {
                let left = plans[node].left[subtrees - 1] as usize;
                let first = tree.nodes[node].first_index as usize;
                open[top] = (first + 1, subtrees - left);
                top += 1;
                next = (first, left);
            } else {
                children.push(node);
                if top == 0 {
                    return;
                }
                top -= 1;
                next = open[top];
            }
        }
    };
    descend(source, LANES, &mut open);
}

/// The ids of all triangles below a binary node, ascending.
fn triangles_below(tree: &Bvh2, root: usize, ids: &mut Vec<u32>) {
    ids.clear();
    let mut pending = vec![root];
    while let Some(index) = pending.pop() {
        let node = &tree.nodes[index];
        let first = node.first_index as usize;
        if node.is_leaf() {
            ids.extend_from_slice(&tree.primitive_indices[first..first + node.prim_count as usize]);
        } else {
            pending.extend([first, first + 1]);
        }
    }
    ids.sort_unstable();
}

fn leaf_block(ids: &[u32], vertices: impl Fn(u32) -> [[f32; 3]; 3]) -> LeafBlock {
    let mut block = LeafBlock::EMPTY;
    for (lane, &id) in ids.iter().enumerate() {
        block.ids[lane] = id;
        for (vertex, position) in vertices(id).into_iter().enumerate() {
            for (axis, coordinate) in position.into_iter().enumerate() {
                block.vertices[vertex][axis][lane] = coordinate;
            }
        }
    }
    block
}
