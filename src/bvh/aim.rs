//! Where rays hit the very triangles they aim at.
//!
//! A shadow ray is free if nothing lies before its target in the order of closest hits. So where its target lies is asked with
//! the test that every walk uses, not taken to be where the ray was sent: on slivers and along planes the two differ.

use crate::bvh::precise::{PRECISE, PreciseRay, SHARED_EDGES};
use crate::bvh::triangle::{dominant_axis8, edges, sheared};
use crate::lanes::{F32x8, LANES, Mask8, Vec3x8};

/// Which of eight rays hit their triangles (a triangle a lane; `class` tells its class) in front of their origins, and where.
/// Only lanes of `active` are asked for.
#[inline(always)]
pub fn aim(
    origin: Vec3x8,
    direction: Vec3x8,
    vertices: &[Vec3x8; 3],
    active: Mask8,
    class: impl Fn(usize) -> u8,
) -> (Mask8, F32x8) {
    let (is_x, is_y) = dominant_axis8(direction);
    let pick = |x: F32x8, y: F32x8, z: F32x8| is_x.select(x, is_y.select(y, z));
    let permuted = |v: Vec3x8| [pick(v.y, v.z, v.x), pick(v.z, v.x, v.y), pick(v.x, v.y, v.z)];
    let [dx, dy, dz] = permuted(direction);
    let shear = [dx / dz, dy / dz, F32x8::ONE / dz];
    let edges = edges(vertices.map(|vertex| sheared(permuted(vertex - origin), shear)));
    let mut t = edges.t_scaled / edges.det;
    let mut hit = edges.inside & t.gt(F32x8::ZERO);
    let classes: [u8; LANES] = std::array::from_fn(class);
    let precise = (0..LANES).fold(0, |bits, lane| bits | ((classes[lane] & PRECISE != 0) as u8) << lane);
    let coarse = active & (Mask8::from_bits(precise) | (edges.inside & edges.edge_on()));
    if coarse.any() {
        precisely(origin, direction, vertices, coarse, &classes, &mut hit, &mut t);
    }
    (hit, t)
}

/// The lanes of `coarse`, in f64.
#[cold]
#[inline(never)]
fn precisely(
    origin: Vec3x8,
    direction: Vec3x8,
    vertices: &[Vec3x8; 3],
    coarse: Mask8,
    classes: &[u8; LANES],
    hit: &mut Mask8,
    t: &mut F32x8,
) {
    let columns = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
    let (origin, direction, vertices) = (columns(origin), columns(direction), vertices.map(columns));
    let (mut bits, mut ts) = (hit.bits() & !coarse.bits(), t.to_array());
    for lane in (0..LANES).filter(|lane| coarse.bits() >> lane & 1 == 1) {
        let at = |column: [[f32; LANES]; 3]| column.map(|axis| axis[lane]);
        let class = if classes[lane] & PRECISE != 0 { classes[lane] } else { SHARED_EDGES };
        if let Some(found) = PreciseRay::new(at(origin), at(direction)).hit(vertices.map(at), class)
            && found.t > 0.0
        {
            bits |= 1 << lane;
            ts[lane] = found.t;
        }
    }
    (*hit, *t) = (Mask8::from_bits(bits), F32x8::from_array(ts));
}
