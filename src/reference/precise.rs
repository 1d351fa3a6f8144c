//! Triangles that single precision is too coarse for, in double precision, whatever `Real` is.

use super::{Real, Vec3, vec3};
use crate::bvh::precise::{PreciseHit, SHARED_EDGES};
use glam::DVec3;

/// Half-ulps (2^-24) of the corners' sheared coordinates by which the test in single precision may move an edge: 4.
const MOVED: f64 = 4.0 / 16_777_216.0;

/// Half-ulps of coordinates by which a triangle's box is widened: 2.
const WIDENED: f64 = 2.0 / 16_777_216.0;

/// What the projected area must exceed in parts of the squared size, for double precision to be good enough.
const LEAST_AREA: f64 = 1.0 / 68_719_476_736.0;

/// The hit of a ray (its origin and direction) on a triangle of class `class`, at any `t`, rounded once to f32. The test of Woop, Benthin and Wald
/// (2013) in f64. Edges that precise triangles share with common ones lie as far out as the test in f32 may see them: the two
/// tests then leave no gap between the two triangles.
pub fn hit_precisely(ray: (Vec3, Vec3), vertices: [[f32; 3]; 3], class: u8) -> Option<PreciseHit> {
    let (origin, direction) = (wide(ray.0), wide(ray.1));
    // The direction's dominant axis becomes z.
    let d = direction.to_array();
    let z = if d[0].abs() >= d[1].abs() && d[0].abs() >= d[2].abs() {
        0
    } else if d[1].abs() >= d[2].abs() {
        1
    } else {
        2
    };
    let axes = [(z + 1) % 3, (z + 2) % 3, z];
    let seen = vertices.map(|v| {
        let from_origin = axes.map(|axis| v[axis] as f64 - origin[axis]);
        DVec3::from(from_origin)
    });
    let (shear_x, shear_y) = (d[axes[0]] / d[z], d[axes[1]] / d[z]);
    let [a, b, c] = seen.map(|v| DVec3::new(v.x - shear_x * v.z, v.y - shear_y * v.z, v.z));

    // Edge functions, positive inside.
    let mut edges = [c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x];
    if edges[0] + edges[1] + edges[2] < 0.0 {
        edges = edges.map(|edge| -edge);
    }
    // By how much the test in f32 may see the corners moved, and so an edge: to first order.
    let moved = seen.map(|v| {
        let uncertain = |x: f64, shear: f64| MOVED * (x.abs() + (shear * v.z).abs());
        [uncertain(v.x, shear_x), uncertain(v.y, shear_y)]
    });
    let corners = [a, b, c];
    for (i, &edge) in edges.iter().enumerate() {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let room = (moved[j][0] * corners[k].y.abs() + moved[j][1] * corners[k].x.abs())
            + (moved[k][0] * corners[j].y.abs() + moved[k][1] * corners[j].x.abs());
        let shared = class & (1 << i) != 0;
        if edge < if shared { -room } else { 0.0 } {
            return None;
        }
    }
    let [u, v, w] = edges.map(|edge| if edge > 0.0 { edge } else { 0.0 });
    let det = u + v + w;
    let size = corners.into_iter().map(|v| v.x.abs() + v.y.abs()).fold(0.0, f64::max);
    if det <= LEAST_AREA * (size * size) {
        return None;
    }
    // Of the plane, but in the triangle's box.
    let [p, q, r] = vertices.map(|v| DVec3::from(v.map(f64::from)));
    let (first, last) = part_in_box(origin, direction, [p, q, r])?;
    let normal = (q - p).cross(r - p);
    let [p, q, r] = [p, q, r].map(|corner| corner - origin);
    // The corner next to the origin tells best how far off the plane is.
    let next = if q.dot(q) < p.dot(p) { q } else { p };
    let next = if r.dot(r) < next.dot(next) { r } else { next };
    let t = normal.dot(next) / normal.dot(direction);
    let t = (if t < first {
        first
    } else if t > last {
        last
    } else {
        t
    }) as f32;
    t.is_finite().then_some(PreciseHit { t, u: (v / det) as f32, v: (w / det) as f32 })
}

/// Where a ray that begins at `tmin` and sees a common triangle edge-on enters its box; `None` if it passes the triangle by or
/// begins behind the box.
pub fn edge_on(ray: (Vec3, Vec3), vertices: [[f32; 3]; 3], tmin: Real) -> Option<f32> {
    hit_precisely(ray, vertices, SHARED_EDGES)?;
    let corners = vertices.map(|v| DVec3::from(v.map(f64::from)));
    let (first, last) = part_in_box(wide(ray.0), wide(ray.1), corners)?;
    (last >= tmin as f64).then_some(first as f32)
}

/// Where a line enters and leaves the widened box of three points (the slab method, Kay and Kajiya 1986).
fn part_in_box(origin: DVec3, direction: DVec3, points: [DVec3; 3]) -> Option<(f64, f64)> {
    let [p, q, r] = points;
    let mut part = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let low = p[axis].min(q[axis]).min(r[axis]);
        let high = p[axis].max(q[axis]).max(r[axis]);
        let widened = (origin[axis].abs() + low.abs().max(high.abs())) * WIDENED;
        let at = [low - widened, high + widened].map(|side| (side - origin[axis]) / direction[axis]);
        let (near, far) = if at[0] > at[1] { (at[1], at[0]) } else { (at[0], at[1]) };
        // Comparisons with NaN are false: a line along a side is not bounded by it.
        if near > part.0 {
            part.0 = near;
        }
        if far < part.1 {
            part.1 = far;
        }
    }
    (part.0 <= part.1).then_some(part)
}

/// The point of a triangle next to `p`, rounded once to f32.
///
/// What is known best of a point on a triangle far larger than what lies on it is where the ray has found it: the barycentric
/// weights, exact to 2^-24, place it no better than 2^-24 of the triangle. So `p` moves onto the plane, and off each edge by 32
/// half-ulps of its own coordinates across that edge (or a sixteenth of the height, where that is less): rounding then does not
/// put it behind the wall that meets the triangle there.
pub fn nearest_on_triangle(vertices: [[f32; 3]; 3], p: Vec3) -> Vec3 {
    let v = vertices.map(|v| DVec3::from(v.map(f64::from)));
    let n = (v[1] - v[0]).cross(v[2] - v[0]);
    let p = wide(p);
    let mut p = p - n * (n.dot(p - v[0]) / n.dot(n));
    // The longest edge first: it is where a quad was cut in two, and in a sharp tip the last one wins.
    let squared = |i: usize| (v[(i + 2) % 3] - v[(i + 1) % 3]).length_squared();
    let mut first = 0;
    for i in 1..3 {
        if squared(i) > squared(first) {
            first = i;
        }
    }
    for i in (first..first + 3).map(|i| i % 3) {
        let (from, to) = (v[(i + 1) % 3], v[(i + 2) % 3]);
        let edge = to - from;
        let across = n.cross(edge);
        let length = across.dot(across).sqrt();
        let across = across * (1.0 / length);
        let wanted = 32.0 / 16_777_216.0 * across.abs().dot(p.abs());
        let height = length / edge.dot(edge);
        let wanted = if wanted < height * (1.0 / 16.0) { wanted } else { height * (1.0 / 16.0) };
        let distance = across.dot(p - from);
        if wanted - distance > 0.0 {
            p += across * (wanted - distance);
        }
    }
    vec3(p.to_array().map(|x| x as f32))
}

fn wide(v: Vec3) -> DVec3 {
    DVec3::new(v.x as f64, v.y as f64, v.z as f64)
}
