//! The vertices of a polygon in a tree of boxes: whether any lies in a triangle is asked of a few of them.

use glam::DVec2;
use std::ops::Range;

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

/// A complete binary tree of vertices, each half of the other along the longer side of its box.
pub struct PointTree<'a> {
    points: &'a [DVec2],
    /// The vertices, leaf after leaf.
    order: Vec<u32>,
    /// Whether a vertex has been removed.
    removed: Vec<bool>,
    /// The leaf of each vertex, by its place in `nodes`.
    leaf_of: Vec<u32>,
    /// The root is number 1; below number `i` are `2 i` and `2 i + 1`.
    nodes: Vec<Node>,
}

impl<'a> PointTree<'a> {
    /// The tree of all `points`.
    pub fn new(points: &'a [DVec2]) -> PointTree<'a> {
        let leaves = points.len().div_ceil(LEAF).next_power_of_two();
        let empty = Node { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, left: 0 };
        let mut tree = PointTree {
            points,
            order: (0..points.len() as u32).collect(),
            removed: vec![false; points.len()],
            leaf_of: vec![0; points.len()],
            nodes: vec![empty; 2 * leaves],
        };
        let mut order = std::mem::take(&mut tree.order);
        tree.build(1, &mut order);
        tree.order = order;
        tree
    }

    fn build(&mut self, number: usize, order: &mut [u32]) {
        let mut node = Node { left: order.len() as u32, ..self.nodes[number] };
        for &vertex in order.iter() {
            let p = self.points[vertex as usize];
            (node.low, node.high) = (node.low.min(p), node.high.max(p));
        }
        self.nodes[number] = node;
        if 2 * number >= self.nodes.len() {
            order.iter().for_each(|&vertex| self.leaf_of[vertex as usize] = number as u32);
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

    /// Takes a vertex out.
    pub fn remove(&mut self, vertex: u32) {
        self.removed[vertex as usize] = true;
        let mut number = self.leaf_of[vertex as usize] as usize;
        while number > 0 {
            self.nodes[number].left -= 1;
            number /= 2;
        }
    }

    /// Whether a vertex has been taken out.
    pub fn is_removed(&self, vertex: u32) -> bool {
        self.removed[vertex as usize]
    }

    /// A vertex of the tree in the triangle of three others, which turns counter-clockwise, or on its edge. Vertices at the
    /// place of a corner do not count. `budget` loses what the search has cost; where it is used up, there is none.
    pub fn any_in(&self, corners: [u32; 3], budget: &mut usize) -> Option<u32> {
        let triangle = Triangle { corners, places: corners.map(|vertex| self.points[vertex as usize]) };
        self.search(1, 0..self.order.len(), &triangle, budget)
    }

    /// The same of the place `number`, whose vertices stand in `range`.
    fn search(&self, number: usize, range: Range<usize>, triangle: &Triangle, budget: &mut usize) -> Option<u32> {
        let node = &self.nodes[number];
        // Many vertices at one place, a corner's, must not be looked at one by one.
        let at_corner = node.low == node.high && triangle.places.contains(&node.low);
        if *budget == 0 || node.left == 0 || at_corner || triangle.is_outside(node) {
            return None;
        }
        *budget -= 1;
        if 2 * number >= self.nodes.len() {
            let counts =
                |vertex: u32| !self.removed[vertex as usize] && triangle.holds(vertex, self.points[vertex as usize]);
            return self.order[range].iter().copied().find(|&vertex| counts(vertex));
        }
        let middle = range.start + range.len() / 2;
        let first = self.search(2 * number, range.start..middle, triangle, budget);
        first.or_else(|| self.search(2 * number + 1, middle..range.end, triangle, budget))
    }
}

/// Three vertices and where they are.
struct Triangle {
    corners: [u32; 3],
    places: [DVec2; 3],
}

impl Triangle {
    fn edges(&self) -> [[DVec2; 2]; 3] {
        let [a, b, c] = self.places;
        [[a, b], [b, c], [c, a]]
    }

    /// Whether no vertex below `node` can be in it: `turn` never falls where its last point goes a certain way, rounded as it
    /// is, so that one corner of the box speaks for all of it.
    fn is_outside(&self, node: &Node) -> bool {
        self.edges().iter().any(|&[from, to]| {
            let edge = to - from;
            let x = if edge.y > 0.0 { node.low.x } else { node.high.x };
            let y = if edge.x > 0.0 { node.high.y } else { node.low.y };
            turn(from, to, DVec2::new(x, y)) < 0.0
        })
    }

    /// Whether another vertex, at `p`, is in it and not at a corner.
    fn holds(&self, vertex: u32, p: DVec2) -> bool {
        let outside = || self.edges().iter().any(|&[from, to]| turn(from, to, p) < 0.0);
        !(self.corners.contains(&vertex) || self.places.contains(&p) || outside())
    }
}
