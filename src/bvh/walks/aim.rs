//! Where rays hit the very triangles they aim at.
//!
//! A shadow ray is free if nothing lies before its target in the order of closest hits. So where its target lies is asked with
//! the test that every walk uses, not taken to be where the ray was sent: on slivers and along planes the two differ.

use super::here;
use crate::bvh::precise::{PRECISE, PreciseRay};
use here::lanes::{Each, F32x8, LANES, Mask8, Vec3x8, inlined};
use here::walks::triangle::{dominant_axis8, edges, sheared};

/// Which of eight rays hit their triangles (a triangle a lane) in front of their origins, and where. Only lanes of `active` are
/// asked for. `classes` has the triangles' classes if they are not all common.
#[inline(always)]
pub fn aim(
    origin: Vec3x8,
    direction: Vec3x8,
    vertices: &[Vec3x8; 3],
    active: Mask8,
    classes: Option<[u8; LANES]>,
) -> (Mask8, F32x8) {
    let (is_x, is_y) = dominant_axis8(direction);
    let pick = |x: F32x8, y: F32x8, z: F32x8| is_x.select(x, is_y.select(y, z));
    let permuted = inlined(
        #[inline(always)]
        |v: Vec3x8| [pick(v.y, v.z, v.x), pick(v.z, v.x, v.y), pick(v.x, v.y, v.z)],
    );
    let [dx, dy, dz] = permuted(direction);
    let shear = [dx / dz, dy / dz, F32x8::ONE / dz];
    let [a, b, c] = *vertices;
    let corner = inlined(
        #[inline(always)]
        |vertex: Vec3x8| sheared(permuted(vertex - origin), shear),
    );
    let edges = edges([corner(a), corner(b), corner(c)]);
    let t = edges.t_scaled / edges.det;
    let hit = edges.inside & t.gt(F32x8::ZERO);
    let edge_on = edges.inside & edges.edge_on();
    let coarse = active
        & match classes {
            Some(classes) => edge_on | precise_lanes(classes),
            None => edge_on,
        };
    if coarse.any() {
        return precisely((origin, direction), vertices, coarse, &classes.unwrap_or_default(), (hit, t));
    }
    (hit, t)
}

/// The lanes whose triangles are tested in f64.
#[inline(always)]
pub fn precise_lanes(classes: [u8; LANES]) -> Mask8 {
    let bit = |lane: usize| ((classes[lane] & PRECISE != 0) as u8) << lane;
    Mask8::from_bits((0..LANES).fold(0, |bits, lane| bits | bit(lane)))
}

/// `found` with the lanes of `coarse` decided in f64.
#[cold]
#[inline(never)]
fn precisely(
    (origin, direction): (Vec3x8, Vec3x8),
    vertices: &[Vec3x8; 3],
    coarse: Mask8,
    classes: &[u8; LANES],
    found: (Mask8, F32x8),
) -> (Mask8, F32x8) {
    here::run(
        #[inline(always)]
        || {
            let columns = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
            let (origin, direction, vertices) = (
                columns(origin),
                columns(direction),
                (*vertices).each(
                    #[inline(always)]
                    |v| columns(v),
                ),
            );
            let coarse = coarse.bits();
            let (mut bits, mut ts) = (found.0.bits() & !coarse, found.1.to_array());
            for lane in (0..LANES).filter(|lane| coarse >> lane & 1 == 1) {
                let at = |column: [[f32; LANES]; 3]| column.map(|axis| axis[lane]);
                let (ray, corners) = (PreciseRay::new(at(origin), at(direction)), vertices.map(at));
                let t = match classes[lane] & PRECISE != 0 {
                    true => ray.hit(corners, classes[lane]).map(|hit| hit.t),
                    false => ray.edge_on(corners, ts[lane], 0.0),
                };
                if let Some(t) = t.filter(|&t| t > 0.0) {
                    bits |= 1 << lane;
                    ts[lane] = t;
                }
            }
            (Mask8::from_bits(bits), F32x8::from_array(ts))
        },
    )
}
