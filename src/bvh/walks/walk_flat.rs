//! Eight rays at a time through a list of leaves, no tree: for the smallest scenes.
//!
//! Eight rays after a bounce visit most leaves of a scene of a few dozen triangles anyway. What counts then is that a visit
//! is cheap whatever the directions:
//! - coordinates and bounds lie in one vector each; a permutation gives every lane the coordinate of its own dominant axis
//!   and the bound on its own near side. The tree's packets go through a leaf once for every dominant axis;
//! - a corner is sheared once for all triangles of its leaf: a box of 12 triangles has 8 of them, not 36;
//! - triangles come by descending id, so that on equal `t` the later one is right;
//! - whether a triangle is hit is not asked by a branch, which would be mispredicted half the time (17 to 25 %).

use super::here;
use crate::bvh::flat::{CORNERS, Flat, Leaf, Triangle};
use crate::bvh::precise::PreciseRay;
use crate::bvh::ray::{ANY_ID, NO_HIT, WalkCounters};
use crate::bvh::rounding::{ROUNDING, WIDENING};
use here::lanes::{Each, F32x8, LANES, Mask8, U32x8};
use here::walks::boxes::safe_inverse8;
use here::walks::packets::{HitPacket, RayPacket};
use here::walks::triangle::{Best, blocked_edge_on, dominant_axis8, edges, reach8, sheared};

/// Working memory: the sheared corners of the leaf that is visited. It lies in the callers' scratch: clearing 3 KiB for each
/// packet, which the compiler does for an array on the stack wherever it is written, took 10 % of the walk's instructions.
#[derive(Clone)]
pub(super) struct Corners([[F32x8; 3]; CORNERS]);

impl Default for Corners {
    fn default() -> Self {
        Self([[F32x8::ZERO; 3]; CORNERS])
    }
}

impl std::fmt::Debug for Corners {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("sheared corners")
    }
}
/// Eight rays, ready for the list.
struct Rays {
    origin: [F32x8; 3],
    shear: [F32x8; 3],
    axes: [U32x8; 3],
    inverse: [F32x8; 3],
    near_offset: [F32x8; 3],
    far_offset: [F32x8; 3],
    near_side: [U32x8; 3],
    tmin: F32x8,
    entry_min: F32x8,
}

impl Rays {
    #[inline(always)]
    fn new(rays: &RayPacket, extent: f32) -> Self {
        let (o, d) = ([rays.origin.x, rays.origin.y, rays.origin.z], rays.direction);
        let (is_x, is_y) = dominant_axis8(d);
        let pick = |x: F32x8, y: F32x8, z: F32x8| is_x.select(x, is_y.select(y, z));
        let index = |x, y, z| is_x.select_u32(U32x8::splat(x), is_y.select_u32(U32x8::splat(y), U32x8::splat(z)));
        let dz = pick(d.x, d.y, d.z);
        let d3 = [d.x, d.y, d.z];
        let inverse = d3.each(
            #[inline(always)]
            |d| safe_inverse8(d),
        );
        let widening: [F32x8; 3] = [0, 1, 2].each(
            #[inline(always)]
            |k: usize| F32x8::splat(ROUNDING) * ((o[k].abs() + F32x8::splat(extent)) * inverse[k].abs()),
        );
        Self {
            origin: [pick(o[1], o[2], o[0]), pick(o[2], o[0], o[1]), pick(o[0], o[1], o[2])],
            shear: [pick(d.y, d.z, d.x) / dz, pick(d.z, d.x, d.y) / dz, F32x8::ONE / dz],
            axes: [index(1, 2, 0), index(2, 0, 1), index(0, 1, 2)],
            inverse,
            near_offset: [0, 1, 2].each(
                #[inline(always)]
                |k: usize| o[k] * inverse[k] + widening[k],
            ),
            far_offset: [0, 1, 2].each(
                #[inline(always)]
                |k: usize| o[k] * inverse[k] - widening[k],
            ),
            near_side: [0, 1, 2].each(
                #[inline(always)]
                |k: usize| U32x8::splat(2 * k as u32) + (inverse[k].to_bits() >> 31),
            ),
            tmin: rays.tmin,
            entry_min: rays.tmin.max(F32x8::ZERO),
        }
    }

    /// Which rays hit the box of a leaf before `best_wide`.
    #[inline(always)]
    fn enter(&self, leaf: &Leaf, best_wide: F32x8) -> Mask8 {
        let bounds = F32x8::from_array(leaf.bounds);
        let near = |k: usize| bounds.permute(self.near_side[k]).loose_mul_sub(self.inverse[k], self.near_offset[k]);
        let other = |k: usize| self.near_side[k] ^ U32x8::splat(1);
        let far = |k: usize| bounds.permute(other(k)).loose_mul_sub(self.inverse[k], self.far_offset[k]);
        let entry = near(0).max(near(1)).max(near(2).max(self.entry_min));
        let exit = far(0).min(far(1)).min(far(2)) * F32x8::splat(WIDENING);
        entry.le(exit.min(best_wide))
    }

    /// Shears the corners of a leaf.
    #[inline(always)]
    fn shear_corners(&self, flat: &Flat, leaf: &Leaf, sheared_corners: &mut Corners) {
        let corners = &flat.corners[leaf.corners.start as usize..leaf.corners.end as usize];
        for (to, corner) in sheared_corners.0.iter_mut().zip(corners) {
            let corner = F32x8::from_array(*corner);
            *to = sheared(
                [0, 1, 2].each(
                    #[inline(always)]
                    |k: usize| corner.permute(self.axes[k]) - self.origin[k],
                ),
                self.shear,
            );
        }
    }
}

/// The sheared corners of a triangle.
#[inline(always)]
fn corners_of(triangle: &Triangle, sheared_corners: &Corners) -> [[F32x8; 3]; 3] {
    // Not `map`, which is a call here.
    let [a, b, c] = triangle.corners;
    let corner = |corner: u8| sheared_corners.0[corner as usize % CORNERS];
    [corner(a), corner(b), corner(c)]
}

/// Which `live` rays are blocked by a leaf whose triangles some may see edge-on.
#[cold]
#[inline(never)]
fn blocked_carefully(flat: &Flat, leaf: &Leaf, corners: &Corners, packet: &RayPacket, live: Mask8) -> Mask8 {
    here::run(
        #[inline(always)]
        || {
            let (mut blocked, anything) = (Mask8::NONE, U32x8::splat(ANY_ID));
            for triangle in leaf.triangles(flat) {
                let edges = edges(corners_of(triangle, corners));
                let edge_on = edges.inside & live & edges.edge_on();
                blocked = blocked | (edges.blocked(packet, anything, triangle.id) & live.and_not(edge_on));
                if edge_on.any() {
                    let vertices = triangle.vertices(flat, leaf);
                    blocked = blocked | blocked_edge_on(packet, anything, vertices, (&edges, triangle.id), edge_on);
                }
            }
            blocked
        },
    )
}

/// Closest hits of eight rays.
#[inline(always)]
pub(super) fn closest(
    flat: &Flat,
    extent: f32,
    given: &RayPacket,
    active: Mask8,
    corners: &mut Corners,
    counters: &mut WalkCounters,
) -> HitPacket {
    let mut best = Best::none(given.tmax);
    let active = active & given.finite();
    if !active.any() {
        return best.hits();
    }
    let packet = given.without_garbage(active);
    let rays = Rays::new(&packet, extent);
    best.t = packet.tmax;
    for leaf in &flat.leaves {
        let live = rays.enter(leaf, best.t * F32x8::splat(WIDENING));
        counters.lanes_used += live.count() as u64;
        counters.lanes_possible += LANES as u64;
        if live.any() {
            rays.shear_corners(flat, leaf, corners);
            for triangle in leaf.triangles(flat) {
                let edges = edges(corners_of(triangle, corners));
                best.update_descending(&edges, triangle.id, live, rays.tmin);
            }
        }
    }
    // Whether a hit is seen edge-on is asked of the closest alone: what f64 has to say only puts hits off, so others, which lie
    // behind it, are behind it still.
    let hit = active.and_not(best.triangle.eq(U32x8::splat(NO_HIT)));
    let least_det = F32x8::gather(&flat.least_det, hit.select_u32(best.triangle, U32x8::ZERO));
    let edge_on = hit & best.det.abs().lt(least_det * reach8(packet.origin, extent));
    if edge_on.any() && !stand(flat, &packet, &best, edge_on) {
        best = closest_carefully(flat, &packet, &rays, active, corners);
    }
    best.t = active.select(best.t, given.tmax);
    best.hits()
}

/// Whether the hits of all `lanes` are as they are if they are seen edge-on.
#[cold]
#[inline(never)]
fn stand(flat: &Flat, packet: &RayPacket, best: &Best, lanes: Mask8) -> bool {
    here::run(
        #[inline(always)]
        || {
            let (t, triangle, tmin) = (best.t.to_array(), best.triangle.to_array(), packet.tmin.to_array());
            let [ox, oy, oz] = [packet.origin.x, packet.origin.y, packet.origin.z].each(F32x8::to_array);
            let [dx, dy, dz] = [packet.direction.x, packet.direction.y, packet.direction.z].each(F32x8::to_array);
            // An iterator's closures may be compiled as functions of no level: they get no lanes.
            let lanes = lanes.bits();
            (0..LANES).filter(|lane| lanes >> lane & 1 == 1).all(|i| {
                let ray = PreciseRay::new([ox[i], oy[i], oz[i]], [dx[i], dy[i], dz[i]]);
                flat.vertices(triangle[i]).and_then(|vertices| ray.edge_on(vertices, t[i], tmin[i])) == Some(t[i])
            })
        },
    )
}

/// [`closest`], every hit of which is looked at whether it is seen edge-on.
#[cold]
#[inline(never)]
fn closest_carefully(flat: &Flat, packet: &RayPacket, rays: &Rays, active: Mask8, corners: &mut Corners) -> Best {
    here::run(
        #[inline(always)]
        || {
            let mut best = Best::none(packet.tmax);
            for leaf in &flat.leaves {
                let live = rays.enter(leaf, best.t * F32x8::splat(WIDENING)) & active;
                if live.any() {
                    rays.shear_corners(flat, leaf, corners);
                    for triangle in leaf.triangles(flat) {
                        let edges = edges(corners_of(triangle, corners));
                        let edge_on = edges.inside & live & edges.edge_on();
                        best.update_descending(&edges, triangle.id, live.and_not(edge_on), rays.tmin);
                        if edge_on.any() {
                            let vertices = triangle.vertices(flat, leaf);
                            best = best.updated_edge_on(packet, vertices, (&edges, triangle.id), edge_on);
                        }
                    }
                }
            }
            best
        },
    )
}

/// Which of eight rays hit anything up to `tmax`.
#[inline(always)]
pub(super) fn any(
    flat: &Flat,
    extent: f32,
    given: &RayPacket,
    active: Mask8,
    corners: &mut Corners,
    counters: &mut WalkCounters,
) -> Mask8 {
    let active = active & given.finite();
    if !active.any() {
        return Mask8::NONE;
    }
    let packet = given.without_garbage(active);
    let rays = Rays::new(&packet, extent);
    let best_wide = packet.tmax * F32x8::splat(WIDENING);
    let reach = reach8(packet.origin, extent);
    let mut open = active;
    for leaf in &flat.leaves {
        let live = rays.enter(leaf, best_wide) & open;
        counters.lanes_used += live.count() as u64;
        counters.lanes_possible += LANES as u64;
        if live.any() {
            rays.shear_corners(flat, leaf, corners);
            let (mut blocked, mut edge_on) = (Mask8::NONE, Mask8::NONE);
            let least_det = reach * F32x8::splat(leaf.least_det);
            for triangle in leaf.triangles(flat) {
                let edges = edges(corners_of(triangle, corners));
                let t = edges.t_scaled / edges.det;
                let hit = edges.inside & (t.gt(packet.tmin) & t.le(packet.tmax));
                blocked = blocked | hit;
                edge_on = edge_on | (hit & edges.det.abs().lt(least_det));
            }
            blocked = blocked & live;
            if (blocked & edge_on).any() {
                blocked = blocked_carefully(flat, leaf, corners, &packet, live);
            }
            open = open.and_not(blocked);
            if !open.any() {
                break;
            }
        }
    }
    active.and_not(open)
}
