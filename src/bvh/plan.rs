//! What every binary node is to become in a tree of eight children a node, by dynamic programming (Ylitie, Karras and Laine 2017,
//! "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3): for every binary node the least cost of
//! standing for it by one to seven wide subtrees. It fills 7.1 of 8 slots where a greedy collapse fills 4.1, halves the nodes and
//! gave 5 to 10 % on big scenes, up to 35 % on a box of 36 triangles. The cost constants hardly matter.
//!
//! Costs live on a stack, for as long as the parent has not been planned; what stays of a node is a [`Decision`]. In a tree laid out
//! depth first a subtree is a range of pairs of siblings, so that threads plan disjoint slices.

use crate::bvh::prims::Area;
use crate::bvh::{huge, threads};
use crate::lanes::LANES;
use bytemuck::{Pod, Zeroable};
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use std::ops::Range;

/// Cost of visiting a node, per chance of being hit.
const NODE_COST: f32 = 1.0;
/// Pairs of siblings that a thread plans at a time, at most.
const PART: usize = 1 << 14;

/// Cost of visiting a leaf: one-ray walks pay for the block, packets for each triangle.
fn leaf_cost(triangles: u32) -> f32 {
    0.5 + 0.0625 * triangles as f32
}

/// What is decided for an inner node; its place is that of the pair of its children.
#[derive(Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Decision {
    /// `left[i]`: how many of `i + 1` subtrees the left child gets; 0: one fewer subtree is no worse. The last entry is for the eight
    /// children of a wide node in this place, the first says that as one subtree it is a leaf.
    left: [u8; LANES],
    /// Wide nodes and leaf blocks it takes as one subtree.
    pub(super) nodes: u32,
    pub(super) leaves: u32,
}

impl Decision {
    /// Whether it is a leaf as one subtree.
    #[inline(always)]
    pub(super) fn is_leaf(&self) -> bool {
        self.left[0] != 0
    }
    /// How many of `subtrees`, 2 at least, the children get; nothing if there are to be fewer subtrees.
    #[inline(always)]
    fn shares(&self, subtrees: usize) -> Option<[usize; 2]> {
        let left = self.left[subtrees - 1] as usize;
        (left > 0).then(|| [left, subtrees - left])
    }
}

/// What standing for a node by `i + 1` wide subtrees takes, at most.
#[derive(Clone, Copy, Default)]
struct Costs {
    cost: [f32; LANES - 1],
    nodes: [u32; LANES - 1],
    leaves: [u32; LANES - 1],
    /// Triangles below, counted up to one more than fit into a leaf.
    triangles: u32,
}

/// The place of an inner node's decision.
#[inline(always)]
pub(super) fn place(node: &Bvh2Node) -> usize {
    (node.first_index as usize - 1) / 2
}

struct Planner<'a> {
    nodes: &'a [Bvh2Node],
    area: Area,
    leaf_size: usize,
}

/// The best plan of every inner node of `tree`, which must be laid out depth first and whose leaves hold up to `leaf_size` triangles.
pub(super) fn plan(tree: &Bvh2, leaf_size: usize, threads: usize) -> Vec<Decision> {
    assert!(tree.children_are_ordered_after_parents);
    let root = &tree.nodes[0];
    let planner = Planner { nodes: &tree.nodes, area: Area::of_scene(root.max - root.min), leaf_size };
    let pairs = tree.nodes.len() / 2;
    let mut decisions = huge::zeroed_list::<Decision>(pairs);
    if pairs == 0 {
        return decisions;
    }
    // Subtrees that one thread plans, from left to right.
    let (mut parts, mut pending) = (vec![], Vec::from([Range { start: 0, end: pairs }]));
    while let Some(range) = pending.pop() {
        match range.len() <= PART || threads == 1 {
            true => parts.push(range),
            false => pending.extend(planner.below(range).into_iter().rev().flatten()),
        }
    }
    let rows = cut_at(&mut decisions, &parts);
    let work = parts.iter().cloned().zip(rows).collect();
    let costs = threads::map(threads, work, |(range, rows): (Range<usize>, &mut [Decision])| {
        let mut stack = Vec::with_capacity(64);
        for pair in range.clone().rev() {
            rows[pair - range.start] = planner.pair(pair, &mut stack);
        }
        stack.pop().expect("a subtree")
    });
    // What is above them.
    let (mut stack, mut next) = (vec![], pairs);
    for (range, costs) in parts.iter().zip(costs).rev() {
        for pair in (range.end..next).rev() {
            decisions[pair] = planner.pair(pair, &mut stack);
        }
        stack.push(costs);
        next = range.start;
    }
    for pair in (0..next).rev() {
        decisions[pair] = planner.pair(pair, &mut stack);
    }
    decisions
}

/// The slices of `rows` that `parts`, ascending, name.
fn cut_at<'a, T>(rows: &'a mut [T], parts: &[Range<usize>]) -> Vec<&'a mut [T]> {
    let mut end = 0;
    let lengths = parts.iter().flat_map(|part| [part.start - std::mem::replace(&mut end, part.end), part.len()]);
    threads::cut(rows, lengths).into_iter().skip(1).step_by(2).collect()
}

impl Planner<'_> {
    /// The subtrees below the first pair of one.
    fn below(&self, range: Range<usize>) -> [Option<Range<usize>>; 2] {
        let [a, b] = [2 * range.start + 1, 2 * range.start + 2].map(|index| &self.nodes[index]);
        let middle = if b.is_leaf() { range.end } else { place(b) };
        [(!a.is_leaf()).then(|| place(a)..middle), (!b.is_leaf()).then_some(middle..range.end)]
    }

    /// Plans the parent of a pair. The costs of the pair's subtrees are on top of `stack`, those of the first one on top; they make way
    /// for the parent's.
    #[inline(always)]
    fn pair(&self, pair: usize, stack: &mut Vec<Costs>) -> Decision {
        let nodes = [&self.nodes[2 * pair + 1], &self.nodes[2 * pair + 2]];
        let [left, right] = nodes.map(|node| match node.is_leaf() {
            true => self.leaf(node),
            false => stack.pop().expect("children before parents"),
        });
        let size = nodes[0].max.max(nodes[1].max) - nodes[0].min.min(nodes[1].min);
        let (costs, decision) = self.decide(self.area.half(size), &left, &right);
        stack.push(costs);
        decision
    }

    fn leaf(&self, node: &Bvh2Node) -> Costs {
        assert!(node.prim_count as usize <= self.leaf_size, "a leaf of {} triangles", node.prim_count);
        Costs {
            cost: [self.area.half(node.max - node.min) * leaf_cost(node.prim_count); LANES - 1],
            nodes: [0; LANES - 1],
            leaves: [1; LANES - 1],
            triangles: node.prim_count,
        }
    }

    #[inline(always)]
    fn decide(&self, area: f32, left: &Costs, right: &Costs) -> (Costs, Decision) {
        // The least cost of so many subtrees, and how many of them are on the left.
        let best = |subtrees: usize| {
            let (mut least, mut best) = (f32::INFINITY, 1);
            for k in (subtrees + 1).saturating_sub(LANES).max(1)..subtrees.min(LANES) {
                let cost = left.cost[k - 1] + right.cost[subtrees - k - 1];
                (least, best) = if cost < least { (cost, k) } else { (least, best) };
            }
            (least, best)
        };
        let taken = |of: fn(&Costs) -> &[u32; LANES - 1], k: usize, subtrees: usize| {
            of(left)[k - 1] + of(right)[subtrees - k - 1]
        };
        let mut costs =
            Costs { triangles: (left.triangles + right.triangles).min(LANES as u32 + 1), ..Costs::default() };
        let mut decision = Decision::default();
        let (spread, k) = best(LANES);
        decision.left[LANES - 1] = k as u8;
        costs.cost[0] = spread + area * NODE_COST;
        costs.nodes[0] = 1 + taken(|costs| &costs.nodes, k, LANES);
        costs.leaves[0] = taken(|costs| &costs.leaves, k, LANES);
        let as_leaf = area * leaf_cost(costs.triangles);
        if costs.triangles as usize <= self.leaf_size && as_leaf <= costs.cost[0] {
            (costs.cost[0], costs.nodes[0], costs.leaves[0], decision.left[0]) = (as_leaf, 0, 1, 1);
        }
        for subtrees in 2..LANES {
            let (cost, k) = best(subtrees);
            let (own, before) = (subtrees - 1, subtrees - 2);
            if cost < costs.cost[before] {
                costs.cost[own] = cost;
                costs.nodes[own] = taken(|costs| &costs.nodes, k, subtrees);
                costs.leaves[own] = taken(|costs| &costs.leaves, k, subtrees);
                decision.left[own] = k as u8;
            } else {
                costs.cost[own] = costs.cost[before];
                costs.nodes[own] = costs.nodes[before];
                costs.leaves[own] = costs.leaves[before];
            }
        }
        (decision.nodes, decision.leaves) = (costs.nodes[0], costs.leaves[0]);
        (costs, decision)
    }
}

/// The binary nodes that become the children of the wide node at `source`, an inner node; how many they are.
pub(super) fn choose_children(
    nodes: &[Bvh2Node],
    decisions: &[Decision],
    source: usize,
    children: &mut [u32; LANES],
) -> usize {
    let (mut open, mut top, mut count) = ([(0, 0); LANES + 1], 1, 0);
    open[0] = (source as u32, LANES);
    while top > 0 {
        top -= 1;
        let (index, mut subtrees) = open[top];
        let node = &nodes[index as usize];
        let shares = match subtrees > 1 && !node.is_leaf() {
            true => {
                let decision = &decisions[place(node)];
                loop {
                    match decision.shares(subtrees) {
                        None if subtrees > 2 => subtrees -= 1,
                        shares => break shares,
                    }
                }
            }
            false => None,
        };
        match shares {
            Some([left, right]) => {
                open[top] = (node.first_index + 1, right);
                open[top + 1] = (node.first_index, left);
                top += 2;
            }
            None => {
                children[count] = index;
                count += 1;
            }
        }
    }
    count
}
