//! The vertices of a polygon in a tree of boxes: whether any lies in a triangle is asked of a few of them.

use glam::DVec2;

/// Vertices in a leaf, at most.
const LEAF: usize = 8;

/// Twice the signed area of a triangle.
pub fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// What lies below a place of the tree.
#[derive(Clone, Copy, Debug)]
struct Node {
    low: DVec2,
    high: DVec2,
    /// Vertices that have not been removed.
    left: u32,
}

/// Nothing.
const EMPTY: Node = Node { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, left: 0 };

impl Node {
    /// The node with one vertex more, at `p`.
    fn and(self, p: DVec2) -> Node {
        Node { low: self.low.min(p), high: self.high.max(p), left: self.left + 1 }
    }
}

/// A complete binary tree of vertices, each half of the other along the longer side of its box.
pub struct PointTree<'a> {
    points: &'a [DVec2],
    /// The vertices, leaf after leaf.
    order: Vec<u32>,
    /// Whether a vertex has been removed.
    removed: Vec<bool>,
    /// The leaf of each vertex, by its place in `nodes`.
    leaf_of: Vec<u32>,
    /// By leaf, the first of its vertices in `order`, and the first of the next leaf's.
    ranges: Vec<[u32; 2]>,
    /// The root is number 1; below number `i` are `2 i` and `2 i + 1`.
    nodes: Vec<Node>,
}

impl<'a> PointTree<'a> {
    /// The tree of all `points`.
    pub fn new(points: &'a [DVec2]) -> PointTree<'a> {
        let leaves = points.len().div_ceil(LEAF).next_power_of_two();
        let mut tree = PointTree {
            points,
            order: (0..points.len() as u32).collect(),
            removed: vec![false; points.len()],
            leaf_of: vec![0; points.len()],
            ranges: Vec::with_capacity(leaves),
            nodes: vec![EMPTY; 2 * leaves],
        };
        let mut order = std::mem::take(&mut tree.order);
        tree.build(1, &mut order);
        tree.order = order;
        tree
    }

    fn build(&mut self, number: usize, order: &mut [u32]) {
        let node = order.iter().fold(EMPTY, |node, &vertex| node.and(self.points[vertex as usize]));
        self.nodes[number] = node;
        if 2 * number >= self.nodes.len() {
            order.iter().for_each(|&vertex| self.leaf_of[vertex as usize] = number as u32);
            let start = self.ranges.last().map_or(0, |last| last[1]);
            self.ranges.push([start, start + order.len() as u32]);
            return;
        }
        let size = node.high - node.low;
        let (points, axis) = (self.points, usize::from(size.y > size.x));
        let along = |vertex: &u32| points[*vertex as usize][axis];
        let middle = order.len() / 2;
        if middle > 0 {
            order.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
        }
        let (first, second) = order.split_at_mut(middle);
        self.build(2 * number, first);
        self.build(2 * number + 1, second);
    }

    /// Takes a vertex out. Boxes shrink to what is left: those of vertices that are gone would lie in the way of searches.
    pub fn remove(&mut self, vertex: u32) {
        self.removed[vertex as usize] = true;
        let mut number = self.leaf_of[vertex as usize] as usize;
        let left = self.leaf(number).iter().filter(|&&vertex| !self.removed[vertex as usize]);
        self.nodes[number] = left.fold(EMPTY, |node, &vertex| node.and(self.points[vertex as usize]));
        while number > 1 {
            number /= 2;
            let [first, second] = [self.nodes[2 * number], self.nodes[2 * number + 1]];
            let (low, high) = (first.low.min(second.low), first.high.max(second.high));
            self.nodes[number] = Node { low, high, left: first.left + second.left };
        }
    }

    /// Whether a vertex has been taken out.
    pub fn is_removed(&self, vertex: u32) -> bool {
        self.removed[vertex as usize]
    }

    /// A vertex of the tree in the triangle of three others, which turns counter-clockwise, or on its edge. Vertices at the
    /// place of a corner do not count. `budget` loses what the search has cost; where it is used up, there is none.
    pub fn any_in(&self, corners: [u32; 3], budget: &mut usize) -> Option<u32> {
        self.search(1, &Triangle::new(corners, self.points), budget)
    }

    /// The same of the place `number`.
    fn search(&self, number: usize, triangle: &Triangle, budget: &mut usize) -> Option<u32> {
        let node = &self.nodes[number];
        // Many vertices at one place, a corner's, must not be looked at one by one.
        let at_corner = || node.low == node.high && triangle.places.contains(&node.low);
        if *budget == 0 || node.left == 0 || triangle.is_outside(node) || at_corner() {
            return None;
        }
        *budget -= 1;
        if 2 * number < self.nodes.len() {
            return (2 * number..2 * number + 2).find_map(|below| self.search(below, triangle, budget));
        }
        let holds =
            |&vertex: &u32| !self.removed[vertex as usize] && triangle.holds(vertex, self.points[vertex as usize]);
        self.leaf(number).iter().copied().find(holds)
    }

    /// The vertices of a leaf, those that have been removed among them.
    fn leaf(&self, number: usize) -> &[u32] {
        let [start, end] = self.ranges[number - self.nodes.len() / 2];
        &self.order[start as usize..end as usize]
    }
}

/// Three vertices, where they are, and the edges between them.
struct Triangle {
    corners: [u32; 3],
    places: [DVec2; 3],
    edges: [DVec2; 3],
}

impl Triangle {
    fn new(corners: [u32; 3], points: &[DVec2]) -> Triangle {
        let places = corners.map(|vertex| points[vertex as usize]);
        Triangle { corners, places, edges: std::array::from_fn(|i| places[(i + 1) % 3] - places[i]) }
    }

    /// Whether no vertex below `node` can be in it: `turn` never falls where its last point goes a certain way, rounded as it
    /// is, so that one corner of the box speaks for all of it.
    fn is_outside(&self, node: &Node) -> bool {
        self.places.iter().zip(&self.edges).any(|(&from, &edge)| {
            let x = if edge.y > 0.0 { node.low.x } else { node.high.x };
            let y = if edge.x > 0.0 { node.high.y } else { node.low.y };
            edge.perp_dot(DVec2::new(x, y) - from) < 0.0
        })
    }

    /// Whether another vertex, at `p`, is in it and not at a corner.
    fn holds(&self, vertex: u32, p: DVec2) -> bool {
        let outside = self.places.iter().zip(&self.edges).any(|(&from, edge)| edge.perp_dot(p - from) < 0.0);
        !outside && !self.corners.contains(&vertex) && !self.places.contains(&p)
    }
}
