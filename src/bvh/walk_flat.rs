//! Eight rays at a time through a list of leaves, no tree: for the smallest scenes.
//!
//! Eight rays after a bounce visit most leaves of a scene of a few dozen triangles anyway. Then what counts is that a visit
//! is cheap whatever the directions: corners and bounds lie in one vector each, and a permutation gives every lane the
//! coordinate of its own dominant axis and the bound on its own near side, where the tree's packets go through a leaf once
//! for every dominant axis.

use super::WalkCounters;
use super::boxes::{ROUNDING, WIDENING, safe_inverse8};
use super::node::{Child, LeafBlock, Node};
use super::ray::{HitPacket, RayPacket};
use super::triangle::{Best, Edges, dominant_axis8, edges};
use super::walk_packet::without_garbage;
use crate::lanes::{F32x8, LANES, Mask8, U32x8};

/// A leaf: its box and its triangles in the list.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct Leaf {
    /// min x, max x, min y, max y, min z, max z.
    bounds: [f32; LANES],
    first: u32,
    count: u32,
}

/// A triangle: a vector a corner, of which the first three lanes are x, y, z.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct Triangle {
    corners: [[f32; LANES]; 3],
    id: u32,
}

/// The leaves of a small tree.
#[derive(Clone, Debug, Default)]
pub(super) struct Flat {
    leaves: Vec<Leaf>,
    triangles: Vec<Triangle>,
}

impl Flat {
    /// The leaves of a tree, the largest box first.
    pub(super) fn new(nodes: &[Node], blocks: &[LeafBlock]) -> Self {
        let mut found = vec![];
        for node in nodes {
            for slot in 0..node.count() {
                if let Child::Leaf(block, count) = node.child(slot) {
                    let b = node.bounds.map(|axis| axis.map(|side| side[slot]));
                    let size = b.map(|[min, max]| max - min);
                    let area = size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
                    found.push((area, [b[0][0], b[0][1], b[1][0], b[1][1], b[2][0], b[2][1], 0.0, 0.0], block, count));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut flat = Self::default();
        for (_, bounds, block, count) in found {
            flat.leaves.push(Leaf { bounds, first: flat.triangles.len() as u32, count: count as u32 });
            for lane in 0..count {
                let corners = blocks[block].vertices.map(|v| [v[0][lane], v[1][lane], v[2][lane], 0., 0., 0., 0., 0.]);
                flat.triangles.push(Triangle { corners, id: blocks[block].ids[lane] });
            }
        }
        flat
    }

    /// Bytes of the list.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..]) + size_of_val(&self.triangles[..])
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
        let inverse = d3.map(safe_inverse8);
        let widening: [F32x8; 3] =
            std::array::from_fn(|k| F32x8::splat(ROUNDING) * ((o[k].abs() + F32x8::splat(extent)) * inverse[k].abs()));
        Self {
            origin: [pick(o[1], o[2], o[0]), pick(o[2], o[0], o[1]), pick(o[0], o[1], o[2])],
            shear: [pick(d.y, d.z, d.x) / dz, pick(d.z, d.x, d.y) / dz, F32x8::ONE / dz],
            axes: [index(1, 2, 0), index(2, 0, 1), index(0, 1, 2)],
            inverse,
            near_offset: std::array::from_fn(|k| o[k] * inverse[k] + widening[k]),
            far_offset: std::array::from_fn(|k| o[k] * inverse[k] - widening[k]),
            near_side: std::array::from_fn(|k| U32x8::splat(2 * k as u32) + (inverse[k].to_bits() >> 31)),
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

    #[inline(always)]
    fn edges(&self, triangle: &Triangle) -> Edges {
        let corner = |vertex: usize| -> [F32x8; 3] {
            let corner = F32x8::from_array(triangle.corners[vertex]);
            std::array::from_fn(|k| corner.permute(self.axes[k]) - self.origin[k])
        };
        edges(corner(0), corner(1), corner(2), self.shear)
    }
}

/// Closest hits of eight rays.
#[inline(always)]
pub(super) fn closest(
    flat: &Flat,
    extent: f32,
    given: &RayPacket,
    active: Mask8,
    counters: &mut WalkCounters,
) -> HitPacket {
    let mut best = Best::none(given.tmax);
    if !active.any() {
        return best.hits();
    }
    let packet = without_garbage(given, active);
    let rays = Rays::new(&packet, extent);
    best.t = packet.tmax;
    for leaf in &flat.leaves {
        let live = rays.enter(leaf, best.t * F32x8::splat(WIDENING));
        counters.lanes_used += live.count() as u64;
        counters.lanes_possible += LANES as u64;
        if live.any() {
            for triangle in &flat.triangles[leaf.first as usize..][..leaf.count as usize] {
                let edges = rays.edges(triangle);
                let inside = edges.inside & live;
                if inside.any() {
                    best.update(&edges, triangle.id, live, rays.tmin);
                }
            }
        }
    }
    best.t = active.select(best.t, given.tmax);
    best.hits()
}

/// Which of eight rays hit anything.
#[inline(always)]
pub(super) fn any(flat: &Flat, extent: f32, given: &RayPacket, active: Mask8, counters: &mut WalkCounters) -> Mask8 {
    if !active.any() {
        return Mask8::NONE;
    }
    let packet = without_garbage(given, active);
    let rays = Rays::new(&packet, extent);
    let best_wide = packet.tmax * F32x8::splat(WIDENING);
    let mut open = active;
    for leaf in &flat.leaves {
        let live = rays.enter(leaf, best_wide) & open;
        counters.lanes_used += live.count() as u64;
        counters.lanes_possible += LANES as u64;
        if live.any() {
            for triangle in &flat.triangles[leaf.first as usize..][..leaf.count as usize] {
                let edges = rays.edges(triangle);
                if (edges.inside & live).any() {
                    let t = edges.t_scaled / edges.det;
                    open = open.and_not(edges.inside & live & t.gt(packet.tmin) & t.le(packet.tmax));
                }
            }
            if !open.any() {
                break;
            }
        }
    }
    active.and_not(open)
}
