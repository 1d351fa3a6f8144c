//! Triangles that single precision is too coarse for, and their test in double precision.
//!
//! The common test (`triangle.rs`) sees a triangle as if its corners had moved by a few half-ulps of their
//! distances from the ray's origin. That is nothing to most triangles. It is much to the width of a sliver, and to whatever
//! stands on a triangle a thousand times its size. These two kinds are *precise*: whether and where a ray hits them is
//! worked out in f64. So is, for any triangle, whether it is hit at all by a ray that sees it so nearly edge-on that rounding
//! could carry the hit off it; and what covers a lamp or is covered by it in one plane: which of the two a ray meets first is then
//! not a matter of rounding, and the same to rays that find the lamp by chance and to those that aim at it.
//!
//! What both tests say of an edge must leave no gap where a precise triangle meets a common one. There, and only there, the
//! precise test takes the edge to lie as far out as the common test may see it.

use crate::bvh::edges::{Edges, edge_of, place};
use crate::bvh::ray::{PERMUTATION, dominant_axis};
use crate::bvh::threads;
use glam::DVec3;
use obvhs::bvh2::Bvh2;

/// The triangle is tested in f64.
pub const PRECISE: u8 = 1 << 3;
/// Something far smaller lies on the triangle: points on it are where rays find them, not where barycentric weights say.
pub const HUGE: u8 = 1 << 4;
/// The edges that a precise triangle shares with a common one, a bit each: those opposite the first, second, third corner.
pub const SHARED_EDGES: u8 = 0b111;

/// Triangles are slivers beyond this aspect (longest edge over height). Up to it the common test errs, along the normal, by
/// less than 1e-4 of the height.
const SLIVER_ASPECT: f64 = 64.0;
/// A triangle is huge if an object (triangles that share corners) so many times smaller lies on it: barycentric weights would
/// place points where the object meets it by 1e-4 of the object, enough to put some behind its walls.
const HUGE_RATIO: f32 = 512.0;
/// It is precise as well if a lamp so many times smaller lies on it: where a lamp of ten heights stands over a floor 528 times
/// its size, rays that started as common ones do lost 1.4e-4 of its light ..
const PRECISE_LAMP_RATIO: f32 = 256.0;
/// .. or any object so many times smaller: 1e-3 of it too high. So is what shares an edge with a sliver so many times
/// narrower: rays would start beyond the far side of a thin box.
const PRECISE_RATIO: f32 = 4096.0;
/// What lies within this part of its longest edge from its box lies on a triangle.
const ON_IT: f32 = 1.0 / 64.0;
/// What is nearer to a lamp than this part of the scene's extent may lie between it and the ends of shadow rays to common
/// lamps, which leave out 2^-17 of the way ([`crate::tables::lights::targets`]).
const AT_A_LAMP: f32 = 1.0 / (1 << 16) as f32;
/// Unless it rises over the lamp's plane by more than so many times that: then it is so close to no more than 1e-3 of it.
const STEEP: f64 = 1024.0;
/// Parts of the coordinates by which what lies in one plane may lie off it: 8 half-ulps.
const SAME_PLANE: f32 = 1.0 / (1 << 21) as f32;
/// Neighbours that all lamps together are asked about, for every triangle of the scene, and in any case.
const MOST_NEIGHBOURS: usize = 64;
const LEAST_NEIGHBOURS: usize = 1 << 22;
/// Half-ulps of the corners' sheared coordinates, before they cancel, by which the common test may move an edge: 4. The worst of
/// all roundings is half as much again; they hardly ever add up.
const MOVED: f64 = 1.0 / (1 << 22) as f64;
/// Half-ulps of coordinates by which a triangle's box is widened: 2, half of what walks widen theirs by.
const WIDENED: f64 = 1.0 / (1 << 23) as f64;
/// Where the projected area is this small a part of the corners' squared distances, f64 is too coarse as well.
const LEAST_AREA: f64 = 1.0 / (1u64 << 36) as f64;

/// The class of every triangle: 0, or [`PRECISE`], [`HUGE`] and its [`SHARED_EDGES`]. Empty if all are common. `tree` holds
/// those that are to be looked at; `emits`: they are lamps.
pub(super) fn classify(
    tree: &Bvh2,
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    emits: impl Fn(u32) -> bool,
    threads: usize,
) -> Vec<u8> {
    let ids = &tree.primitive_indices;
    let vertices = |id: u32| triangles[id as usize].map(|vertex| positions[vertex as usize]);
    let mut classes = Vec::new();
    let (longest, slivers) = shapes(ids, vertices, threads);
    slivers.into_iter().for_each(|id| mark(&mut classes, id, PRECISE));
    if !classes.is_empty() {
        classes.resize(triangles.len(), 0);
        mark_thin_boxes(&mut classes, tree, &vertices);
    }
    let (least, most) = longest.iter().fold((f32::INFINITY, 0.0f32), |(a, b), &size| (a.min(size), b.max(size)));
    if most > PRECISE_LAMP_RATIO * least {
        let objects = object_sizes(ids, positions, triangles);
        let of_lamp = |(&id, &size): (&u32, &f32)| if emits(id) { size } else { f32::INFINITY };
        let lamps: Vec<f32> = ids.iter().zip(&objects).map(of_lamp).collect();
        let [objects, lamps] =
            [objects, lamps].map(|sizes| Sizes::new(tree, sizes, most / HUGE_RATIO.min(PRECISE_LAMP_RATIO)));
        for (&id, &size) in ids.iter().zip(&longest) {
            // Of most triangles nothing is small enough.
            if objects.least() >= size / HUGE_RATIO && lamps.least() >= size / PRECISE_LAMP_RATIO {
                continue;
            }
            let place = bounds(vertices(id), size * ON_IT);
            let carries = |sizes: &Sizes, ratio: f32| sizes.any_on(tree, vertices, place, size / ratio);
            if carries(&objects, PRECISE_RATIO) || carries(&lamps, PRECISE_LAMP_RATIO) {
                mark(&mut classes, id, PRECISE | HUGE);
            } else if carries(&objects, HUGE_RATIO) {
                mark(&mut classes, id, HUGE);
            }
        }
    }
    let extent = tree.nodes.first().map_or(0.0, |root| root.min.abs().max(root.max.abs()).max_element());
    // Lamps by the thousand in one place are nobody's scene: each is precise then, and not asked about all the others.
    let mut left = MOST_NEIGHBOURS.saturating_mul(ids.len()).max(LEAST_NEIGHBOURS);
    for &id in ids.iter().filter(|&&id| emits(id)) {
        let place = bounds(vertices(id), extent * AT_A_LAMP);
        for_each_in(tree, &vertices, place, |other| {
            if left == 0 {
                mark(&mut classes, id, PRECISE);
                return false;
            }
            left -= 1;
            let known = [id, other].iter().all(|&id| class_of(&classes, id) & PRECISE != 0);
            if other != id && !known && covers(vertices(id), vertices(other), extent) {
                mark(&mut classes, id, PRECISE);
                mark(&mut classes, other, PRECISE);
            }
            true
        });
    }
    if !classes.is_empty() {
        classes.resize(triangles.len(), 0);
    }
    mark_shared_edges(&mut classes, tree, &vertices);
    classes
}

/// The class of a triangle.
fn class_of(classes: &[u8], triangle: u32) -> u8 {
    classes.get(triangle as usize).copied().unwrap_or(0)
}

/// Adds to the class of a triangle.
fn mark(classes: &mut Vec<u8>, triangle: u32, class: u8) {
    let index = triangle as usize;
    if classes.len() <= index {
        classes.resize(index + 1, 0);
    }
    classes[index] |= class;
}

/// Whether two triangles, one of them a lamp, lie in one plane and share more of it than an edge; or, without a common corner,
/// so close that shadow rays to common lamps would end between them. `extent`: of the scene.
fn covers(a: [[f32; 3]; 3], b: [[f32; 3]; 3], extent: f32) -> bool {
    let meet = a.iter().any(|&corner| b.iter().any(|&other| place(corner) == place(other)));
    let (large, small) = if longest_edge(a) >= longest_edge(b) { (a, b) } else { (b, a) };
    let [large, small] = [large, small].map(|triangle| triangle.map(|v| DVec3::from(v.map(f64::from))));
    let normal = (large[1] - large[0]).cross(large[2] - large[0]).normalize();
    let size = large.into_iter().chain(small).map(|v| v.abs().max_element()).fold(0.0, f64::max);
    let heights = small.map(|corner| normal.dot(corner - large[0]));
    let (low, high) = (heights[0].min(heights[1]).min(heights[2]), heights[0].max(heights[1]).max(heights[2]));
    let near = f64::from(AT_A_LAMP * extent);
    let close = match meet {
        true => low.abs().max(high.abs()) <= f64::from(SAME_PLANE) * size,
        // What crosses the lamp steeply is so close to next to nothing of it.
        false => low.max(-high) <= near && high - low <= STEEP * near,
    };
    if !close {
        return false;
    }
    // Convex figures that share area overlap seen along every edge (Gottschalk, Lin and Manocha 1996, in the plane).
    let least = f64::from(SAME_PLANE) * size;
    [large, small].into_iter().all(|triangle| {
        (0..3).all(|i| {
            let across = (triangle[(i + 1) % 3] - triangle[i]).cross(normal).normalize();
            let extent = |figure: [DVec3; 3]| {
                let at = figure.map(|corner| across.dot(corner));
                (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]))
            };
            let (p, q) = (extent(large), extent(small));
            p.1.min(q.1) - p.0.max(q.0) > least
        })
    })
}

/// Triangles that a thread looks at, at a time.
const CHUNK: usize = 1 << 14;

/// The [`longest_edge`] of every triangle of `ids`, and the slivers among them.
fn shapes(ids: &[u32], vertices: impl Fn(u32) -> [[f32; 3]; 3] + Sync, threads: usize) -> (Vec<f32>, Vec<u32>) {
    /// Below the square of this aspect, in f64, a triangle is no sliver, however roots and quotients are rounded.
    const SURELY_NONE: f64 = (SLIVER_ASPECT - 1.0) * (SLIVER_ASPECT - 1.0);
    let chunk = |ids: &[u32]| {
        let (mut longest, mut slivers) = (Vec::with_capacity(ids.len()), Vec::new());
        for &id in ids {
            let [a, b, c] = vertices(id).map(|v| DVec3::from(v.map(f64::from)));
            let square = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            let is_common = square * square < SURELY_NONE * (b - a).cross(c - a).length_squared();
            if !is_common && aspect(vertices(id)) > SLIVER_ASPECT {
                slivers.push(id);
            }
            // The root of the largest square is the largest root: roots keep the order, rounded or not.
            longest.push(square.sqrt() as f32);
        }
        (longest, slivers)
    };
    let parts = threads::map(threads, ids.chunks(CHUNK).collect(), chunk);
    let (longest, slivers): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
    (longest.concat(), slivers.concat())
}

/// Per triangle of `ids`, the size of the object it belongs to: the longest side of the box about all triangles that hang
/// together by common corners.
fn object_sizes(ids: &[u32], positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f32> {
    let mut parent: Vec<u32> = (0..positions.len() as u32).collect();
    fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
        while parent[vertex as usize] != vertex {
            parent[vertex as usize] = parent[parent[vertex as usize] as usize];
            vertex = parent[vertex as usize];
        }
        vertex
    }
    // As the triangles come in the file: their corners are next to each other there.
    let mut looked_at = vec![false; triangles.len()];
    ids.iter().for_each(|&id| looked_at[id as usize] = true);
    for (corners, _) in triangles.iter().zip(&looked_at).filter(|(_, looked_at)| **looked_at) {
        let [a, b, c] = corners.map(|vertex| root(&mut parent, vertex));
        let least = a.min(b).min(c);
        [a, b, c].into_iter().for_each(|vertex| parent[vertex as usize] = least);
    }
    // Parents come before their children, so that those of the ones before are roots already.
    let mut boxes = vec![[[f32::INFINITY, f32::NEG_INFINITY]; 3]; positions.len()];
    for (vertex, position) in positions.iter().enumerate() {
        parent[vertex] = parent[parent[vertex] as usize];
        let own = &mut boxes[parent[vertex] as usize];
        for axis in 0..3 {
            own[axis] = [own[axis][0].min(position[axis]), own[axis][1].max(position[axis])];
        }
    }
    let size = |[x, y, z]: [[f32; 2]; 3]| (x[1] - x[0]).max(y[1] - y[0]).max(z[1] - z[0]);
    let sizes: Vec<f32> = boxes.into_iter().map(size).collect();
    ids.iter().map(|&id| sizes[parent[triangles[id as usize][0] as usize] as usize]).collect()
}

/// Scene units.
pub fn longest_edge([a, b, c]: [[f32; 3]; 3]) -> f32 {
    let edge = |p: [f32; 3], q: [f32; 3]| DVec3::from(p.map(f64::from)).distance(DVec3::from(q.map(f64::from)));
    edge(a, b).max(edge(b, c)).max(edge(c, a)) as f32
}

/// Longest edge over height.
pub fn aspect(vertices: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = vertices.map(|v| DVec3::from(v.map(f64::from)));
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    longest * longest / (b - a).cross(c - a).length()
}

fn bounds(vertices: [[f32; 3]; 3], margin: f32) -> [[f32; 2]; 3] {
    std::array::from_fn(|axis| {
        let [a, b, c] = vertices.map(|vertex| vertex[axis]);
        [a.min(b).min(c) - margin, a.max(b).max(c) + margin]
    })
}

/// Whether a box meets `bounds`.
fn meets(min: [f32; 3], max: [f32; 3], bounds: [[f32; 2]; 3]) -> bool {
    (0..3).all(|axis| min[axis] <= bounds[axis][1] && max[axis] >= bounds[axis][0])
}

/// Whether the box of a triangle meets `bounds`. Asked of each triangle of a leaf: then the answer does not depend on what else is
/// in the leaf.
fn triangle_meets(vertices: [[f32; 3]; 3], bounds: [[f32; 2]; 3]) -> bool {
    let [x, y, z] = self::bounds(vertices, 0.0);
    meets([x[0], y[0], z[0]], [x[1], y[1], z[1]], bounds)
}

/// Sizes of the primitives of a tree.
struct Sizes {
    /// In the order of the leaves.
    each: Vec<f32>,
    /// Per node, the least below it; empty if no size is below what was to be asked for.
    below: Vec<f32>,
}

impl Sizes {
    /// Nobody will ask for sizes of `most` or more.
    fn new(tree: &Bvh2, each: Vec<f32>, most: f32) -> Sizes {
        let least = |sizes: &[f32]| sizes.iter().copied().fold(f32::INFINITY, f32::min);
        if least(&each) >= most {
            return Sizes { each, below: Vec::new() };
        }
        let mut below = vec![f32::INFINITY; tree.nodes.len()];
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            let first = node.first_index as usize;
            below[index] = match node.is_leaf() {
                true => least(&each[first..first + node.prim_count as usize]),
                false => below[first].min(below[first + 1]),
            };
        }
        Sizes { each, below }
    }

    /// Infinite if none is small enough.
    fn least(&self) -> f32 {
        self.below.first().copied().unwrap_or(f32::INFINITY)
    }

    /// Whether something smaller than `size` has a box that meets `bounds`.
    fn any_on(&self, tree: &Bvh2, vertices: impl Fn(u32) -> [[f32; 3]; 3], bounds: [[f32; 2]; 3], size: f32) -> bool {
        let mut pending = if self.least() < size { vec![0] } else { vec![] };
        while let Some(index) = pending.pop() {
            let node = &tree.nodes[index];
            let first = node.first_index as usize;
            if self.below[index] >= size || !meets(node.min.to_array(), node.max.to_array(), bounds) {
                continue;
            }
            if !node.is_leaf() {
                pending.extend([first, first + 1]);
            } else if (first..first + node.prim_count as usize)
                .any(|at| self.each[at] < size && triangle_meets(vertices(tree.primitive_indices[at]), bounds))
            {
                return true;
            }
        }
        false
    }
}

/// Tells of the triangles whose boxes meet `bounds`, until `tell` returns false.
fn for_each_in(
    tree: &Bvh2,
    vertices: &impl Fn(u32) -> [[f32; 3]; 3],
    bounds: [[f32; 2]; 3],
    mut tell: impl FnMut(u32) -> bool,
) {
    let mut pending = vec![0];
    while let Some(index) = pending.pop() {
        let Some(node) = tree.nodes.get(index) else { return };
        let first = node.first_index as usize;
        if !meets(node.min.to_array(), node.max.to_array(), bounds) {
        } else if node.is_leaf() {
            let ids = &tree.primitive_indices[first..first + node.prim_count as usize];
            if !ids.iter().filter(|&&id| triangle_meets(vertices(id), bounds)).all(|&id| tell(id)) {
                return;
            }
        } else {
            pending.extend([first, first + 1]);
        }
    }
}

/// Finds the triangles that share an edge with a sliver far narrower than they are long. At this time all precise triangles are
/// slivers.
fn mark_thin_boxes(classes: &mut [u8], tree: &Bvh2, vertices: &impl Fn(u32) -> [[f32; 3]; 3]) {
    let ids = &tree.primitive_indices;
    let is_precise = |classes: &[u8], id: u32| class_of(classes, id) & PRECISE != 0;
    // The least width of a sliver at each edge.
    let mut edges = Edges::new(ids.iter().filter(|&&id| is_precise(classes, id)).count());
    for &id in ids.iter().filter(|&&id| is_precise(classes, id)) {
        let width = f64::from(longest_edge(vertices(id))) / aspect(vertices(id));
        for opposite in 0..3 {
            let least = edges.entry(edge_of(vertices(id), opposite), width);
            *least = least.min(width);
        }
    }
    let mut found = Vec::new();
    for &id in ids.iter().filter(|&&id| !is_precise(classes, id)) {
        let mut least = f64::INFINITY;
        edges.known(vertices(id), |width| least = least.min(*width));
        if least * f64::from(PRECISE_RATIO) < f64::from(longest_edge(vertices(id))) {
            found.push(id);
        }
    }
    found.into_iter().for_each(|id| classes[id as usize] |= PRECISE);
}

/// Finds the edges that precise triangles share with common ones.
fn mark_shared_edges(classes: &mut [u8], tree: &Bvh2, vertices: &impl Fn(u32) -> [[f32; 3]; 3]) {
    let ids = &tree.primitive_indices;
    let is_precise = |classes: &[u8], id: u32| class_of(classes, id) & PRECISE != 0;
    let count = ids.iter().filter(|&&id| is_precise(classes, id)).count();
    if count == 0 {
        return;
    }
    // Whether a common triangle has it, too.
    let mut edges = Edges::new(count);
    for &id in ids.iter().filter(|&&id| is_precise(classes, id)) {
        for opposite in 0..3 {
            edges.entry(edge_of(vertices(id), opposite), false);
        }
    }
    for &id in ids.iter().filter(|&&id| !is_precise(classes, id)) {
        edges.known(vertices(id), |shared| *shared = true);
    }
    for &id in ids {
        if !is_precise(classes, id) {
            continue;
        }
        for opposite in 0..3 {
            if *edges.entry(edge_of(vertices(id), opposite), false) {
                classes[id as usize] |= 1 << opposite;
            }
        }
    }
}

/// What the test in f64 finds, rounded once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreciseHit {
    /// Ray parameter.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
}

/// A ray, ready for the test in f64.
pub(crate) struct PreciseRay {
    origin: DVec3,
    direction: DVec3,
    axes: [usize; 3],
}

impl PreciseRay {
    pub(crate) fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let axes = PERMUTATION[dominant_axis(direction[0], direction[1], direction[2])];
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        Self { origin: wide(origin), direction: wide(direction), axes }
    }

    /// The hit on a triangle of class `class`, at any `t`: as [`crate::bvh::walks::triangle`] has it, in f64, edges that are shared
    /// moved out by what that test may move them, and `t` from the triangle's plane, which is exact for planes along axes: a ray
    /// may leave a floor at y = 0 from y = 0. A hit is in the triangle's box, a little widened, and so is its `t`, whatever
    /// rounding makes of a plane seen edge-on: then no walk culls the box that it is in.
    pub(crate) fn hit(&self, vertices: [[f32; 3]; 3], class: u8) -> Option<PreciseHit> {
        let [kx, ky, kz] = self.axes;
        // Not `map`, which is a call here.
        let wide = |v: [f32; 3]| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
        let (p, q, r) = (wide(vertices[0]), wide(vertices[1]), wide(vertices[2]));
        let (from_p, from_q, from_r) = (p - self.origin, q - self.origin, r - self.origin);
        let depth = self.direction[kz];
        let shear = [self.direction[kx] / depth, self.direction[ky] / depth];
        let sheared = |v: DVec3| (v[kx] - shear[0] * v[kz], v[ky] - shear[1] * v[kz]);
        let ((ax, ay), (bx, by), (cx, cy)) = (sheared(from_p), sheared(from_q), sheared(from_r));
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let sign = if (u + v) + w < 0.0 { -1.0 } else { 1.0 };
        let (u, v, w) = (u * sign, v * sign, w * sign);
        let (mut room_u, mut room_v, mut room_w) = (0.0, 0.0, 0.0);
        if class & SHARED_EDGES != 0 {
            let moved = |v: DVec3| {
                let moved = |axis: usize, shear: f64| MOVED * (v[axis].abs() + (shear * v[kz]).abs());
                (moved(kx, shear[0]), moved(ky, shear[1]))
            };
            let (a, b, c) = (moved(from_p), moved(from_q), moved(from_r));
            let room = |bit: u8, (px, py): (f64, f64), p: (f64, f64), (qx, qy): (f64, f64), q: (f64, f64)| {
                let room = (p.0 * qy.abs() + p.1 * qx.abs()) + (q.0 * py.abs() + q.1 * px.abs());
                if class & bit != 0 { room } else { 0.0 }
            };
            room_u = room(1, (bx, by), b, (cx, cy), c);
            room_v = room(2, (cx, cy), c, (ax, ay), a);
            room_w = room(4, (ax, ay), a, (bx, by), b);
        }
        if u < -room_u || v < -room_v || w < -room_w {
            return None;
        }
        let inner = |edge: f64| if edge > 0.0 { edge } else { 0.0 };
        let (u, v, w) = (inner(u), inner(v), inner(w));
        let det = (u + v) + w;
        let size = (ax.abs() + ay.abs()).max(bx.abs() + by.abs()).max(cx.abs() + cy.abs());
        if det <= LEAST_AREA * (size * size) {
            return None;
        }
        let (first, last) = self.within_box([p, q, r])?;
        let normal = (q - p).cross(r - p);
        // From the corner next to the ray's origin: its difference has lost the least.
        let [p_off, q_off, r_off] = [from_p, from_q, from_r].map(|v| v.dot(v));
        let from_corner = if p_off <= q_off && p_off <= r_off {
            from_p
        } else if q_off <= r_off {
            from_q
        } else {
            from_r
        };
        let t = normal.dot(from_corner) / normal.dot(self.direction);
        let t = (if t < first {
            first
        } else if t > last {
            last
        } else {
            t
        }) as f32;
        t.is_finite().then_some(PreciseHit { t, u: (v / det) as f32, v: (w / det) as f32 })
    }

    /// The `t` of a hit that the common test has at `t`, on a triangle that the ray, which begins at `tmin`, sees edge-on: there
    /// is none before `tmin`, none if the ray passes the triangle by or begins behind its box, and it does not lie before the ray
    /// enters the box.
    pub(crate) fn edge_on(&self, vertices: [[f32; 3]; 3], t: f32, tmin: f32) -> Option<f32> {
        if t <= tmin {
            return None;
        }
        self.hit(vertices, SHARED_EDGES)?;
        let (first, last) = self.within_box(vertices.map(|v| DVec3::from(v.map(f64::from))))?;
        if last < f64::from(tmin) {
            return None;
        }
        Some(if t < first as f32 { first as f32 } else { t })
    }

    /// The part of the ray, forwards and backwards, that is in the box of `corners`, widened.
    fn within_box(&self, corners: [DVec3; 3]) -> Option<(f64, f64)> {
        let [p, q, r] = corners;
        let (low, high) = (p.min(q).min(r), p.max(q).max(r));
        let widened = (self.origin.abs() + low.abs().max(high.abs())) * WIDENED;
        let (low, high) = (low - widened - self.origin, high + widened - self.origin);
        let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            // Infinite where the direction is 0; NaN, which bounds nothing, if it runs along a side besides.
            let (a, b) = (low[axis] / self.direction[axis], high[axis] / self.direction[axis]);
            let (near, far) = if a > b { (b, a) } else { (a, b) };
            first = if near > first { near } else { first };
            last = if far < last { far } else { last };
        }
        (first <= last).then_some((first, last))
    }
}
