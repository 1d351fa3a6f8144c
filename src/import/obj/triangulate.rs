//! Polygons into triangles: always n - 2 of them, in a fixed order, so that triangle ids depend on the file alone.
//!
//! A polygon that its first corner sees as a whole (every convex one) becomes the fan about that corner. Any other is
//! projected along its normal (Newell's sum of edge products) and cut ear by ear (Meisters 1975: a simple polygon
//! always has an ear), or, where there are too many corners for that, by a sweep. A polygon that crosses itself or has no area has
//! no right answer; it gets a fan, and the caller is told.

use crate::import::obj::index_set::IndexSet;
use crate::import::obj::point_tree::{PointTree, turn};
use crate::import::obj::sweep::sweep;
use glam::{DVec2, DVec3};

/// How a polygon was cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// A fan about its first corner, or ears: the triangles tile the polygon.
    Tiled,
    /// It crosses itself: the triangles cover it only roughly.
    Crossing,
}

/// What the searches of a polygon of `corners` may cost, in boxes looked at, before a sweep takes over: 0.2 to
/// 0.5 s. Of polygons of 100,000 corners a comb or a star needs a tenth of it; a spiral of 160 turns, all of it.
fn search_budget(corners: usize) -> usize {
    10_000_000 + 160 * corners.min(100_000)
}

/// The polygon's normal, twice its area long; zero if it has none.
pub fn newell_normal(corners: &[DVec3]) -> DVec3 {
    // About the first corner, so that polygons far from the origin keep their digits.
    let Some(&origin) = corners.first() else { return DVec3::ZERO };
    corners.windows(2).map(|e| (e[0] - origin).cross(e[1] - origin)).sum()
}

/// Appends the n - 2 triangles of a polygon, as corner numbers 0..n in the polygon's own winding.
pub fn triangulate(corners: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> Cut {
    let n = corners.len();
    if n < 3 {
        return Cut::Tiled;
    }
    if n == 3 {
        triangles.push([0, 1, 2]);
        return Cut::Tiled;
    }
    let normal = newell_normal(corners);
    let fan_turns = |i: usize| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]).dot(normal);
    if (1..n - 1).all(|i| fan_turns(i) >= 0.0) {
        fan(&(0..n as u32).collect::<Vec<_>>(), triangles);
        return Cut::Tiled;
    }
    clip_ears(&project(corners, normal), triangles)
}

/// The fan about the first of `ring`.
fn fan(ring: &[u32], triangles: &mut Vec<[u32; 3]>) {
    triangles.extend(ring.windows(2).skip(1).map(|e| [ring[0], e[0], e[1]]));
}

/// The polygon along the largest axis of its normal, turned so that it runs counter-clockwise.
fn project(corners: &[DVec3], normal: DVec3) -> Vec<DVec2> {
    let size = normal.abs();
    let along = |p: &DVec3| match () {
        _ if size.x >= size.y && size.x >= size.z => (DVec2::new(p.y, p.z), normal.x),
        _ if size.y >= size.z => (DVec2::new(p.z, p.x), normal.y),
        _ => (DVec2::new(p.x, p.y), normal.z),
    };
    let flat = |p: &DVec3| match along(&(*p - corners[0])) {
        (q, direction) if direction < 0.0 => DVec2::new(q.y, q.x),
        (q, _) => q,
    };
    corners.iter().map(flat).collect()
}

/// Cuts ears off a counter-clockwise polygon until a triangle is left.
///
/// The ring is gone through corner by corner. A corner that is no ear stays none until a neighbour or the vertex that lies in
/// its triangle is cut off, and is passed by until then: that leaves about three tests a corner.
fn clip_ears(points: &[DVec2], triangles: &mut Vec<[u32; 3]>) -> Cut {
    let mut ring = Ring::new(points);
    let mut budget = search_budget(points.len());
    let (mut at, first) = (0, triangles.len());
    while ring.len > 3 {
        // Corners in line with their neighbours go last: cut early, they would leave a T-junction on a long edge.
        let Some(ear) = ring.next_ear(at, &mut budget).or_else(|| ring.flat.next(at)).filter(|_| budget > 0) else {
            // Whether a polygon that has used up its searches crosses itself is not known.
            if let Some(swept) = (budget == 0).then(|| sweep(points)).flatten() {
                triangles.truncate(first);
                triangles.extend(swept);
                return Cut::Tiled;
            }
            fan(&ring.left(), triangles);
            return Cut::Crossing;
        };
        let [before, after] = [ring.before[ear], ring.after[ear]];
        triangles.push([before, ear as u32, after]);
        ring.cut(ear);
        // Go on behind the next corner: ears all around one corner would be needles.
        at = ring.after[after as usize] as usize;
    }
    fan(&ring.left(), triangles);
    Cut::Tiled
}

/// No vertex.
const NONE: u32 = u32::MAX;

/// The corners that are left, and what is known of them.
struct Ring<'a> {
    points: &'a [DVec2],
    tree: PointTree<'a>,
    len: usize,
    before: Vec<u32>,
    after: Vec<u32>,
    /// Corners that may be ears.
    open: IndexSet,
    /// Corners in line with their neighbours.
    flat: IndexSet,
    /// By corner, a vertex in its triangle, as far as one was found.
    blocker: Vec<u32>,
    /// By vertex, the first of its entries in `blocked`: all corners that it has ever blocked.
    first_blocked: Vec<u32>,
    /// A corner, and the next entry of the same vertex.
    blocked: Vec<[u32; 2]>,
}

impl<'a> Ring<'a> {
    fn new(points: &'a [DVec2]) -> Ring<'a> {
        let n = points.len() as u32;
        let mut ring = Ring {
            points,
            tree: PointTree::new(points),
            len: points.len(),
            before: (0..n).map(|i| (i + n - 1) % n).collect(),
            after: (0..n).map(|i| (i + 1) % n).collect(),
            open: IndexSet::new(points.len()),
            flat: IndexSet::new(points.len()),
            blocker: vec![NONE; points.len()],
            first_blocked: vec![NONE; points.len()],
            blocked: Vec::new(),
        };
        (0..points.len()).for_each(|corner| ring.judge(corner));
        ring
    }

    /// What a corner can be, by how it turns alone.
    fn judge(&mut self, corner: usize) {
        let [a, b, c] = [self.before[corner] as usize, corner, self.after[corner] as usize].map(|i| self.points[i]);
        let area = turn(a, b, c);
        self.blocker[corner] = NONE;
        self.open.remove(corner);
        self.flat.remove(corner);
        if area == 0.0 {
            self.flat.insert(corner);
        } else if area > 0.0 || area.is_nan() {
            self.open.insert(corner);
        }
    }

    /// The next corner from `at` on that can be cut off: it turns outwards and no other vertex lies in its triangle.
    /// Vertices at the place of a corner do not count: polygons with a bridge to a hole visit such places twice.
    fn next_ear(&mut self, at: usize, budget: &mut usize) -> Option<usize> {
        while let Some(corner) = self.open.next(at) {
            let triangle = [self.before[corner], corner as u32, self.after[corner]];
            match self.tree.any_in(triangle, budget) {
                None => return Some(corner),
                Some(vertex) => {
                    self.open.remove(corner);
                    self.blocker[corner] = vertex;
                    self.blocked.push([corner as u32, self.first_blocked[vertex as usize]]);
                    self.first_blocked[vertex as usize] = self.blocked.len() as u32 - 1;
                }
            }
        }
        None
    }

    /// Cuts a corner off; what it has kept from being known is open again.
    fn cut(&mut self, corner: usize) {
        let [before, after] = [self.before[corner], self.after[corner]];
        (self.after[before as usize], self.before[after as usize]) = (after, before);
        self.len -= 1;
        self.tree.remove(corner as u32);
        self.open.remove(corner);
        self.flat.remove(corner);
        self.blocker[corner] = NONE;
        let mut entry = self.first_blocked[corner];
        while let Some(&[blocked, next]) = self.blocked.get(entry as usize) {
            if self.blocker[blocked as usize] == corner as u32 {
                self.blocker[blocked as usize] = NONE;
                self.open.insert(blocked as usize);
            }
            entry = next;
        }
        self.judge(before as usize);
        self.judge(after as usize);
    }

    /// The corners that are left, the first of the polygon first.
    fn left(&self) -> Vec<u32> {
        (0..self.points.len() as u32).filter(|&vertex| !self.tree.is_removed(vertex)).collect()
    }
}
