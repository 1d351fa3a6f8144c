//! Polygons into triangles: always n - 2 of them, in a fixed order, so that triangle ids depend on the file alone.
//!
//! A polygon that its first corner sees as a whole (every convex one) becomes the fan about that corner. Any other is
//! projected along its normal (Newell's sum of edge products) and cut ear by ear (Meisters 1975: a simple polygon
//! always has an ear). A polygon that crosses itself or has no area has no right answer; it gets a fan, and the caller
//! is told.

use glam::{DVec2, DVec3};

/// How a polygon was cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// A fan about its first corner, or ears: the triangles tile the polygon.
    Tiled,
    /// It crosses itself: the triangles cover it only roughly.
    Crossing,
}

/// Point tests one polygon may cost before it is given up as crossing itself: real polygons need a few thousand, and a
/// hostile one of 100,000 corners must not take minutes.
const TEST_BUDGET: usize = 50_000_000;

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

/// Twice the signed area of a triangle.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Cuts ears off a counter-clockwise polygon until a triangle is left.
fn clip_ears(points: &[DVec2], triangles: &mut Vec<[u32; 3]>) -> Cut {
    let mut ring: Vec<u32> = (0..points.len() as u32).collect();
    let mut budget = TEST_BUDGET;
    // Corners in line with their neighbours go last: cut early, they would leave a T-junction on a long edge.
    let mut cut_flat = false;
    let (mut at, mut since_last_ear) = (0, 0);
    while ring.len() > 3 {
        let n = ring.len();
        if since_last_ear == n && !cut_flat {
            (cut_flat, since_last_ear) = (true, 0);
        }
        if since_last_ear == n || budget == 0 {
            fan(&ring, triangles);
            return Cut::Crossing;
        }
        budget = budget.saturating_sub(1);
        let (before, here, after) = ((at + n - 1) % n, at % n, (at + 1) % n);
        if is_ear(points, &ring, [before, here, after], cut_flat, &mut budget) {
            triangles.push([ring[before], ring[here], ring[after]]);
            ring.remove(here);
            (cut_flat, since_last_ear) = (false, 0);
            // Go on behind the next corner: ears all around one corner would be needles.
            at = if here + 1 == n { 1 } else { here + 1 };
        } else {
            since_last_ear += 1;
            at = after;
        }
    }
    fan(&ring, triangles);
    Cut::Tiled
}

/// Whether the corner at the middle of `corner` (places in `ring`) can be cut off: it turns outwards and no other
/// vertex lies in its triangle. Vertices at the place of a corner do not count: polygons with a bridge to a hole visit
/// such places twice.
fn is_ear(points: &[DVec2], ring: &[u32], corner: [usize; 3], cut_flat: bool, budget: &mut usize) -> bool {
    let [a, b, c] = corner.map(|place| points[ring[place] as usize]);
    let area = turn(a, b, c);
    if area <= 0.0 {
        return area == 0.0 && cut_flat;
    }
    *budget = budget.saturating_sub(ring.len());
    ring.iter().enumerate().all(|(place, &vertex)| {
        let p = points[vertex as usize];
        let outside = || turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0;
        corner.contains(&place) || p == a || p == b || p == c || outside()
    })
}
