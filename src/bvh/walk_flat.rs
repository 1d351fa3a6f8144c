//! Eight rays at a time through a list of leaves, no tree: for the smallest scenes.
//!
//! Eight rays after a bounce visit most leaves of a scene of a few dozen triangles anyway. What counts then is that a visit
//! is cheap whatever the directions:
//! - coordinates and bounds lie in one vector each; a permutation gives every lane the coordinate of its own dominant axis
//!   and the bound on its own near side. The tree's packets go through a leaf once for every dominant axis;
//! - a corner is sheared once for all triangles of its leaf: a box of 12 triangles has 8 of them, not 36;
//! - triangles come by descending id, so that on equal `t` the later one is right;
//! - whether a triangle is hit is not asked by a branch, which would be mispredicted half the time (17 to 25 %).

use crate::bvh::boxes::{ROUNDING, WIDENING, safe_inverse8};
use crate::bvh::precise::PreciseRay;
use crate::bvh::ray::{ANY_ID, HitPacket, NO_HIT, RayPacket, WalkCounters};
use crate::bvh::triangle::{Best, blocked_edge_on, dominant_axis8, edges, least_det, reach8, sheared, size_of};
use crate::lanes::{F32x8, LANES, Mask8, U32x8};

/// The most corners in a leaf.
pub(super) const CORNERS: usize = 32;
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
/// What a visit of a leaf, a corner and a triangle take, roughly in cycles.
const LEAF_COST: f32 = 12.0;
const CORNER_COST: f32 = 4.0;
const TRIANGLE_COST: f32 = 11.0;
/// Beyond this a stream through the tree is faster: in a room of 96 cubes, 1,164 triangles, the list still is.
const MOST_COST: f32 = 6000.0;

/// A leaf: its box, and where its corners and triangles are in the list.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct Leaf {
    /// min x, max x, min y, max y, min z, max z.
    pub(super) bounds: [f32; LANES],
    pub(super) corners: std::ops::Range<u32>,
    triangles: std::ops::Range<u32>,
    /// The largest of its triangles' least determinants.
    pub(super) least_det: f32,
}

/// A triangle: which corners of its leaf it has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) id: u32,
    pub(super) corners: [u8; 3],
}

/// The triangles of a small scene, in leaves.
#[derive(Clone, Debug, Default)]
pub(super) struct Flat {
    pub(super) leaves: Vec<Leaf>,
    /// x, y, z in the first three lanes.
    pub(super) corners: Vec<[f32; LANES]>,
    triangles: Vec<Triangle>,
    /// By id, [`crate::bvh::triangle::least_det`].
    pub(super) least_det: Vec<f32>,
}

type Vertices = [[f32; 3]; 3];

/// A leaf in the making.
#[derive(Clone, Debug, Default)]
struct Group {
    corners: Vec<[f32; 3]>,
    triangles: Vec<Triangle>,
}

impl Group {
    /// Adds a triangle unless it has too many new corners.
    fn add(&mut self, id: u32, vertices: Vertices) -> bool {
        let before = self.corners.len();
        let corners = vertices.map(|vertex| {
            let known = self.corners.iter().position(|corner| corner.map(f32::to_bits) == vertex.map(f32::to_bits));
            known.unwrap_or_else(|| {
                self.corners.push(vertex);
                self.corners.len() - 1
            })
        });
        if self.corners.len() > CORNERS {
            self.corners.truncate(before);
            return false;
        }
        self.triangles.push(Triangle { id, corners: corners.map(|corner| corner as u8) });
        true
    }

    fn bounds(&self) -> [[f32; 2]; 3] {
        std::array::from_fn(|axis| {
            let along =
                |fold: fn(f32, f32) -> f32, from| self.corners.iter().map(|corner| corner[axis]).fold(from, fold);
            [along(f32::min, f32::INFINITY), along(f32::max, f32::NEG_INFINITY)]
        })
    }

    /// Ids, and [`Flat::least_det`] of them, in a scene that reaches to `extent`.
    fn least_det(&self, extent: f32) -> impl Iterator<Item = (u32, f32)> {
        let leaf = size_of(self.corners.iter().copied());
        self.triangles.iter().map(move |triangle| {
            let corners = triangle.corners.map(|corner| self.corners[corner as usize]);
            (triangle.id, least_det(size_of(corners), leaf, extent))
        })
    }

    /// What eight unrelated rays spend on it in a scene of half surface `scene`.
    fn cost(&self, scene: f32) -> f32 {
        let miss = 1.0 - (half_area(self.bounds()) / scene).min(1.0);
        let inside = self.corners.len() as f32 * CORNER_COST + self.triangles.len() as f32 * TRIANGLE_COST;
        LEAF_COST + (1.0 - miss.powi(LANES as i32)) * inside
    }
}

fn half_area(bounds: [[f32; 2]; 3]) -> f32 {
    let [x, y, z] = bounds.map(|[min, max]| max - min);
    x * y + y * z + z * x
}

impl Flat {
    /// The list of `triangles`, ids descending, if eight unrelated rays get through it in less than [`MOST_COST`]. Leaves are runs of ids, files being written object by object; where one
    /// ends and the next begins is chosen by dynamic programming.
    pub(super) fn new(triangles: &[(u32, Vertices)], extent: f32) -> Option<Self> {
        let mut all = Group::default();
        all.corners.extend(triangles.iter().flat_map(|triangle| triangle.1));
        let scene = half_area(all.bounds()).max(f32::MIN_POSITIVE);
        // `best[i]`: the least cost of triangles from i on, and the end of the first leaf.
        let mut best = vec![(0.0, 0); triangles.len() + 1];
        for first in (0..triangles.len()).rev() {
            let mut group = Group::default();
            best[first] = (f32::INFINITY, first + 1);
            for (end, &(id, vertices)) in (first + 1..).zip(&triangles[first..]) {
                if !group.add(id, vertices) {
                    break;
                }
                let cost = group.cost(scene) + best[end].0;
                if cost < best[first].0 {
                    best[first] = (cost, end);
                }
            }
        }
        if best[0].0 > MOST_COST {
            return None;
        }
        let ids = triangles.iter().map(|triangle| triangle.0 as usize + 1).max().unwrap_or(1);
        let mut flat = Self { least_det: vec![0.0; ids], ..Self::default() };
        let mut first = 0;
        while first < triangles.len() {
            let mut group = Group::default();
            for &(id, vertices) in &triangles[first..best[first].1] {
                group.add(id, vertices);
            }
            first = best[first].1;
            let mut most: f32 = 0.0;
            for (id, least_det) in group.least_det(extent) {
                flat.least_det[id as usize] = least_det;
                most = most.max(least_det);
            }
            let [[x0, x1], [y0, y1], [z0, z1]] = group.bounds();
            let (corners, triangles) = (flat.corners.len() as u32, flat.triangles.len() as u32);
            flat.corners.extend(group.corners.iter().map(|&[x, y, z]| [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0]));
            flat.triangles.extend(group.triangles);
            flat.leaves.push(Leaf {
                bounds: [x0, x1, y0, y1, z0, z1, 0.0, 0.0],
                corners: corners..flat.corners.len() as u32,
                triangles: triangles..flat.triangles.len() as u32,
                least_det: most,
            });
        }
        Some(flat)
    }

    /// Bytes of the list.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.least_det[..])
    }

    /// The corners of triangle `id`, scene units.
    pub(super) fn vertices(&self, id: u32) -> Option<Vertices> {
        self.leaves.iter().find_map(|leaf| {
            let triangle = leaf.triangles(self).iter().find(|triangle| triangle.id == id)?;
            Some(triangle.vertices(self, leaf))
        })
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

    /// Shears the corners of a leaf.
    #[inline(always)]
    fn shear_corners(&self, flat: &Flat, leaf: &Leaf, sheared_corners: &mut Corners) {
        let corners = &flat.corners[leaf.corners.start as usize..leaf.corners.end as usize];
        for (to, corner) in sheared_corners.0.iter_mut().zip(corners) {
            let corner = F32x8::from_array(*corner);
            *to = sheared(std::array::from_fn(|k| corner.permute(self.axes[k]) - self.origin[k]), self.shear);
        }
    }
}

impl Leaf {
    #[inline(always)]
    pub(super) fn triangles<'a>(&self, flat: &'a Flat) -> &'a [Triangle] {
        &flat.triangles[self.triangles.start as usize..self.triangles.end as usize]
    }
}

impl Triangle {
    /// Its corners, scene units.
    pub(super) fn vertices(&self, flat: &Flat, leaf: &Leaf) -> Vertices {
        self.corners.map(|corner| {
            let [x, y, z, ..] = flat.corners[leaf.corners.start as usize + corner as usize];
            [x, y, z]
        })
    }

    #[inline(always)]
    fn corners(&self, sheared_corners: &Corners) -> [[F32x8; 3]; 3] {
        // Not `map`, which is a call here.
        let [a, b, c] = self.corners;
        let corner = |corner: u8| sheared_corners.0[corner as usize % CORNERS];
        [corner(a), corner(b), corner(c)]
    }
}

/// Which `live` rays are blocked by a leaf whose triangles some may see edge-on.
#[cold]
#[inline(never)]
fn blocked_carefully(flat: &Flat, leaf: &Leaf, corners: &Corners, packet: &RayPacket, live: Mask8) -> Mask8 {
    let (mut blocked, anything) = (Mask8::NONE, U32x8::splat(ANY_ID));
    for triangle in leaf.triangles(flat) {
        let edges = edges(triangle.corners(corners));
        let edge_on = edges.inside & live & edges.edge_on();
        blocked = blocked | (edges.blocked(packet, anything, triangle.id) & live.and_not(edge_on));
        if edge_on.any() {
            let vertices = triangle.vertices(flat, leaf);
            blocked = blocked | blocked_edge_on(packet, anything, vertices, (&edges, triangle.id), edge_on);
        }
    }
    blocked
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
                let edges = edges(triangle.corners(corners));
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
    let (t, triangle, tmin) = (best.t.to_array(), best.triangle.to_array(), packet.tmin.to_array());
    let [ox, oy, oz] = [packet.origin.x, packet.origin.y, packet.origin.z].map(F32x8::to_array);
    let [dx, dy, dz] = [packet.direction.x, packet.direction.y, packet.direction.z].map(F32x8::to_array);
    (0..LANES).filter(|lane| lanes.bits() >> lane & 1 == 1).all(|i| {
        let ray = PreciseRay::new([ox[i], oy[i], oz[i]], [dx[i], dy[i], dz[i]]);
        flat.vertices(triangle[i]).and_then(|vertices| ray.edge_on(vertices, t[i], tmin[i])) == Some(t[i])
    })
}

/// [`closest`], every hit of which is looked at whether it is seen edge-on.
#[cold]
#[inline(never)]
fn closest_carefully(flat: &Flat, packet: &RayPacket, rays: &Rays, active: Mask8, corners: &mut Corners) -> Best {
    let mut best = Best::none(packet.tmax);
    for leaf in &flat.leaves {
        let live = rays.enter(leaf, best.t * F32x8::splat(WIDENING)) & active;
        if live.any() {
            rays.shear_corners(flat, leaf, corners);
            for triangle in leaf.triangles(flat) {
                let edges = edges(triangle.corners(corners));
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
                let edges = edges(triangle.corners(corners));
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
