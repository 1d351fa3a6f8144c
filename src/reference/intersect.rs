//! One ray at a time through the tree: plain loops, early returns.

use super::precise::{edge_on, hit_precisely};
use super::{Real, Vec3, vec3};
use crate::bvh::Bvh;
use crate::bvh::node::{Child, LeafBlock, Node};
use crate::bvh::precise::PRECISE;
use crate::bvh::ray::{LONGEST_DIRECTION, SHORTEST_DIRECTION};
use crate::fault::{Fault, lost_digits, planted};

/// A ray; a hit counts if `tmin < t <= tmax`.
#[derive(Clone, Copy)]
pub struct Ray {
    /// Origin, scene units.
    pub origin: Vec3,
    /// Direction, any length but 0.
    pub direction: Vec3,
    /// Where the ray begins (exclusive).
    pub tmin: Real,
    /// Where the ray ends (inclusive).
    pub tmax: Real,
}

impl Ray {
    /// Whether the direction is neither too short nor too long ([`crate::bvh::RayPacket`]): such rays hit nothing.
    fn is_in_range(&self) -> bool {
        let longest = self.direction.abs().max_element();
        longest >= SHORTEST_DIRECTION as Real && longest <= LONGEST_DIRECTION as Real
    }
}

/// The closest hit: `P = (1-u-v) v0 + u v1 + v v2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: Real,
    /// Triangle id.
    pub triangle: u32,
    /// Weight of the second vertex.
    pub u: Real,
    /// Weight of the third vertex.
    pub v: Real,
}

/// The hit of `ray` on one triangle of class `class` ([`crate::bvh::precise`]), at any `t`.
pub fn hit_triangle(ray: &Ray, vertices: [[f32; 3]; 3], triangle: u32, class: u8) -> Option<Hit> {
    ShearedRay::new(ray).hit_of_class(vertices, triangle, class)
}

/// What is left to visit, with the distance at which the ray enters it. Kept by the caller, so that it is made once a path.
pub type Stack = Vec<(Real, Child)>;

/// A stack for `bvh` that never has to grow.
pub fn stack(bvh: &Bvh) -> Stack {
    Vec::with_capacity(bvh.stack_bound() + 1)
}

/// The closest hit, the lowest id on equal `t`.
pub fn intersect(bvh: &Bvh, ray: &Ray, stack: &mut Stack) -> Option<Hit> {
    intersect_where(bvh, ray, stack, |_| true)
}

/// The closest of the hits that are `there`, the lowest id on equal `t`.
pub fn intersect_where(bvh: &Bvh, ray: &Ray, stack: &mut Stack, there: impl Fn(&Hit) -> bool) -> Option<Hit> {
    if !ray.is_in_range() {
        return None;
    }
    let (slabs, sheared) = (SlabRay::new(ray, bvh.extent()), ShearedRay::new(ray));
    let mut best: Option<Hit> = None;
    let mut tmax = ray.tmax;
    stack.clear();
    stack.push((ray.tmin, Child::Inner(0)));
    while let Some((near, child)) = stack.pop() {
        if near > tmax * WIDENING {
            continue;
        }
        match child {
            Child::Inner(node) => slabs.push_children(&bvh.nodes()[node], tmax, stack),
            Child::Leaf(block, count) => {
                for hit in sheared.hits(bvh, &bvh.leaves()[block], count) {
                    let counts = hit.t > ray.tmin && hit.t <= tmax;
                    let closer = best.is_none_or(|b| hit.t < b.t || (hit.t == b.t && hit.triangle < b.triangle));
                    if counts && closer && there(&hit) {
                        tmax = hit.t;
                        best = Some(hit);
                    }
                }
            }
            Child::Empty => {}
        }
    }
    best
}

/// Whether the ray hits anything.
pub fn occluded(bvh: &Bvh, ray: &Ray, stack: &mut Stack) -> bool {
    occluded_where(bvh, ray, stack, |hit| hit.t <= ray.tmax)
}

/// Whether any of the ray's hits counts. (All are asked about that lie in front of the ray's start and in a box that it
/// enters before its end.)
pub fn occluded_where(bvh: &Bvh, ray: &Ray, stack: &mut Stack, counts: impl Fn(&Hit) -> bool) -> bool {
    if !ray.is_in_range() {
        return false;
    }
    let (slabs, sheared) = (SlabRay::new(ray, bvh.extent()), ShearedRay::new(ray));
    stack.clear();
    stack.push((ray.tmin, Child::Inner(0)));
    while let Some((_, child)) = stack.pop() {
        match child {
            Child::Inner(node) => slabs.push_children(&bvh.nodes()[node], ray.tmax, stack),
            Child::Leaf(block, count) => {
                if sheared.hits(bvh, &bvh.leaves()[block], count).any(|hit| hit.t > ray.tmin && counts(&hit)) {
                    return true;
                }
            }
            Child::Empty => {}
        }
    }
    false
}

/// Far sides of boxes, and the closest hit they are compared with, are widened by this factor.
const WIDENING: Real = 1.0 + 1.0 / 2_097_152.0;

/// A ray ready for boxes: the robust slab test (Ize 2013, "Robust BVH Ray Traversal"), which may enter a box in vain but
/// never misses one. Besides the relative widening every slab is widened by 2^-22 (|o| + extent) / |d|: a relative one is
/// worth nothing for a ray that lies in a box's face.
struct SlabRay {
    origin: [Real; 3],
    inverse: [Real; 3],
    margin: [Real; 3],
    tmin: Real,
}

impl SlabRay {
    fn new(ray: &Ray, extent: f32) -> SlabRay {
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        // Components of 0 become a tiny number of the same sign, so that no 0 x infinity arises.
        let tiny = 1.0 / (1u128 << 80) as Real;
        let inverse = direction.map(|d| 1.0 / if d.abs() > tiny { d } else { tiny.copysign(d) });
        let margin = std::array::from_fn(|k| (origin[k].abs() + extent as Real) * inverse[k].abs() / 4_194_304.0);
        SlabRay { origin, inverse, margin, tmin: ray.tmin }
    }

    /// Where the ray enters child `slot`, if it does before `tmax`.
    fn enters(&self, node: &Node, slot: usize, tmax: Real) -> Option<Real> {
        let (mut near, mut far) = (self.tmin, tmax);
        for k in 0..3 {
            let low = (node.bounds[k][0][slot] as Real - self.origin[k]) * self.inverse[k];
            let high = (node.bounds[k][1][slot] as Real - self.origin[k]) * self.inverse[k];
            let (enter, leave) = if self.inverse[k] < 0.0 { (high, low) } else { (low, high) };
            near = near.max(enter - self.margin[k]);
            far = far.min(leave + self.margin[k]);
        }
        (near <= far * WIDENING).then_some(near)
    }

    /// Pushes the children that the ray enters, the nearest last.
    fn push_children(&self, node: &Node, tmax: Real, stack: &mut Stack) {
        let first = stack.len();
        for slot in 0..node.count() {
            if let Some(near) = self.enters(node, slot, tmax) {
                let mut place = stack.len();
                stack.push((near, node.child(slot)));
                while place > first && stack[place - 1].0 < near {
                    stack.swap(place - 1, place);
                    place -= 1;
                }
            }
        }
    }
}

/// A projected triangle of less than this part of its corners' largest squared coordinate is seen edge-on.
const EDGE_ON: Real = 1.0 / 64.0;

/// A ray ready for triangles: the watertight test of Woop, Benthin and Wald (2013). The ray becomes the z axis of a
/// sheared space in which a triangle is hit if the origin lies on the same side of its three edges.
struct ShearedRay {
    ray: Ray,
    origin: [Real; 3],
    /// Axes in the order x, y, z of the sheared space; z is where the direction is largest.
    axes: [usize; 3],
    shear: [Real; 3],
}

impl ShearedRay {
    fn new(ray: &Ray) -> ShearedRay {
        let d = ray.direction.to_array();
        let size = d.map(|c| c.abs());
        let z = if size[0] >= size[1] && size[0] >= size[2] {
            0
        } else if size[1] >= size[2] {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let wrong = if planted(Fault::WrongShear) { 1.001 } else { 1.0 };
        let shear = [d[axes[0]] / d[z], d[axes[1]] / d[z], wrong / d[z]];
        ShearedRay { ray: *ray, origin: ray.origin.to_array(), axes, shear }
    }

    fn sheared(&self, vertex: [f32; 3]) -> Vec3 {
        let v = vec3(vertex).to_array();
        let [x, y, z] = self.axes.map(|axis| v[axis] - self.origin[axis]);
        Vec3::new(x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z)
    }

    /// The hit on one triangle, at any `t`. Seen nearly edge-on it must be there in f64 as well.
    fn hit(&self, vertices: [[f32; 3]; 3], triangle: u32) -> Option<Hit> {
        let [a, b, c] = vertices.map(|vertex| self.sheared(vertex));
        // An edge function of exactly 0 counts as inside, from both sides of the edge: no leak.
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let det = u + v + w;
        let small = planted(Fault::SmallTriangles) && Real::EPSILON > 1e-10;
        if small && (u / det < 0.05 || v / det < 0.05 || w / det < 0.05) {
            return None;
        }
        if !inside || planted(Fault::ClosedEdges) && u * v * w == 0.0 {
            return None;
        }
        let size = [a, b, c].map(|v| if v.x.abs() > v.y.abs() { v.x.abs() } else { v.y.abs() });
        let size = size.into_iter().fold(0.0, |most, one| if one > most { one } else { most });
        if det == 0.0 {
            return None;
        }
        let mut t = (u * a.z + v * b.z + w * c.z) / det;
        if det.abs() < size * size * EDGE_ON {
            if t <= self.ray.tmin {
                return None;
            }
            let first = edge_on((self.ray.origin, self.ray.direction), vertices, self.ray.tmin)? as Real;
            t = if t < first { first } else { t };
        }
        let off = lost_digits(Real::EPSILON as f64) as Real;
        Some(Hit { t: t * off, triangle, u: v / det * off, v: w / det })
    }

    /// The hit in f64, at any `t`.
    fn precise_hit(&self, vertices: [[f32; 3]; 3], triangle: u32, class: u8) -> Option<Hit> {
        let hit = hit_precisely((self.ray.origin, self.ray.direction), vertices, class)?;
        Some(Hit { t: hit.t as Real, triangle, u: hit.u as Real, v: hit.v as Real })
    }

    /// [`ShearedRay::hit`] on a triangle of class `class`.
    fn hit_of_class(&self, vertices: [[f32; 3]; 3], triangle: u32, class: u8) -> Option<Hit> {
        if class & PRECISE != 0 {
            return self.precise_hit(vertices, triangle, class);
        }
        self.hit(vertices, triangle)
    }

    /// The hits in a leaf block of `count` triangles, at any `t`.
    fn hits(&self, bvh: &Bvh, block: &LeafBlock, count: usize) -> impl Iterator<Item = Hit> {
        (0..count).filter_map(move |lane| {
            let id = block.ids[lane];
            self.hit_of_class(block.corners(lane), id, bvh.class(id))
        })
    }
}
