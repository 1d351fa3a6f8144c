//! Eight rays at a time through the tree: one stack, a node is entered by all lanes whose rays hit its box.

use crate::bvh::boxes::{EightRaysBoxes, Interval, WIDENING};
use crate::bvh::node::{LeafBlock, Tables, block_of, holds_precise, is_leaf, triangles_in};
use crate::bvh::precise::{PRECISE, PreciseHit, PreciseRay, SHARED_EDGES};
use crate::bvh::ray::{HitPacket, RayPacket, WalkCounters};
use crate::bvh::triangle::{Best, EightRays, most_moved};
use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};

/// Nodes and leaves still to be visited, with every lane's distance: NaN where its ray misses the box, so that it is below
/// nothing, not even below the infinite `t` of a ray that has hit nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct PacketStack {
    words: Vec<u32>,
    near: Vec<[f32; LANES]>,
}

impl PacketStack {
    /// Room for `entries`.
    pub(super) fn reserve(&mut self, entries: usize) {
        if self.words.len() < entries {
            self.words.resize(entries, 0);
            self.near.resize(entries, [0.0; LANES]);
        }
    }
    #[inline(always)]
    fn push(&mut self, top: &mut usize, word: u32, near: F32x8) {
        self.words[*top] = word;
        self.near[*top] = near.to_array();
        *top += 1;
    }
}

/// For culling eight boxes at once: it gains 10 to 15 % on big trees, and in the smallest it is not worth its making.
#[inline(always)]
fn interval(tables: Tables, rays: &RayPacket) -> Option<Interval> {
    if tables.nodes.len() < 32 {
        return None;
    }
    Interval::new(rays.origin, rays.direction, rays.tmin, tables.extent)
}

/// The largest of eight distances, widened, in every lane.
#[inline(always)]
fn farthest_of(t: F32x8) -> F32x8 {
    F32x8::splat(-(-t).min_of_lanes() * WIDENING)
}

/// Closest hits of eight rays.
///
/// Nodes that few rays enter are not handed to the one-ray walk. In the prototype that did so below three rays, the Cornell
/// box took 60, 65 and 13 million camera, shadow and bounced rays a second; without, 61, 70 and 17. Shadow rays in big trees
/// gained 3 to 5 %. This walk and [`any`] as one with a const parameter took 8 and 15 % more instructions.
pub(super) fn closest(
    tables: Tables,
    given: &RayPacket,
    active: Mask8,
    stack: &mut PacketStack,
    counters: &mut WalkCounters,
) -> HitPacket {
    let mut best = Best::none(given.tmax);
    let active = active & given.finite();
    if !active.any() {
        return best.hits();
    }
    let rays = given.without_garbage(active);
    let boxes = EightRaysBoxes::new(rays.origin, rays.direction, rays.tmin, tables.extent);
    let triangles = EightRays::new(rays.origin, rays.direction);
    let interval = interval(tables, &rays);
    best.t = rays.tmax;
    let mut farthest = farthest_of(best.t);
    let missed = F32x8::splat(f32::NAN);
    let widening = F32x8::splat(WIDENING);
    let mut top = 0;
    let (mut next, mut near) = (0u32, active.select(F32x8::ZERO, missed));
    loop {
        let live = near.le(best.t * widening) & active;
        let count = live.count();
        counters.lanes_possible += LANES as u64;
        counters.lanes_used += count as u64;
        if count == 0 {
        } else if is_leaf(next) {
            let (block, precise) = (&tables.leaves[block_of(next)], holds_precise(next));
            let before = best.t;
            for kz in 0..3 {
                let own = live & triangles.lanes_by_axis[kz];
                if own.any() {
                    for lane in 0..triangles_in(next) {
                        let edges = triangles.edges(block, lane, kz);
                        if precise && is_precise(tables, block.ids[lane]) {
                            let near = own & edges.near(most_moved8(&rays, tables.extent));
                            precise_hits(
                                &rays,
                                block,
                                lane,
                                near,
                                tables.classes[block.ids[lane] as usize],
                                |at, hit| {
                                    best.update_lane(at, hit, block.ids[lane], rays.tmin.to_array()[at]);
                                },
                            );
                            continue;
                        }
                        let inside = edges.inside & own;
                        if inside.any() {
                            let edge_on = inside & edges.edge_on();
                            best.update(&edges, block.ids[lane], own.and_not(edge_on), rays.tmin);
                            if edge_on.any() {
                                precise_hits(&rays, block, lane, edge_on, SHARED_EDGES, |at, hit| {
                                    best.update_lane(at, hit, block.ids[lane], rays.tmin.to_array()[at]);
                                });
                            }
                        }
                    }
                }
            }
            if best.t.lt(before).any() {
                farthest = farthest_of(best.t);
            }
        } else {
            let node = &tables.nodes[next as usize];
            let best_wide = best.t * widening;
            let mut chosen: Option<(u32, F32x8)> = None;
            let mut children = match &interval {
                Some(interval) => interval.test(&node.bounds, farthest).bits() as u32,
                None => (1 << node.count()) - 1,
            };
            while children != 0 {
                let child = children.trailing_zeros() as usize & 7;
                children &= children - 1;
                let (entry, hit) = match &interval {
                    Some(interval) => boxes.test_octant(interval, &node.bounds, child, best_wide),
                    None => boxes.test(&node.bounds, child, best_wide),
                };
                let hit = hit & live;
                if hit.any() {
                    let entry = hit.select(entry, missed);
                    let word = node.children[child];
                    chosen = match chosen {
                        None => Some((word, entry)),
                        // The child that any ray enters first goes first.
                        Some(other) if entry.lt(other.1).any() => {
                            stack.push(&mut top, other.0, other.1);
                            Some((word, entry))
                        }
                        Some(other) => {
                            stack.push(&mut top, word, entry);
                            Some(other)
                        }
                    };
                }
            }
            if let Some(chosen) = chosen {
                (next, near) = chosen;
                continue;
            }
        }
        if top == 0 {
            break;
        }
        top -= 1;
        (next, near) = (stack.words[top], F32x8::from_array(stack.near[top]));
    }
    best.t = active.select(best.t, given.tmax);
    best.hits()
}

/// Whether a triangle is tested in f64, if there are any such.
#[inline(always)]
fn is_precise(tables: Tables, id: u32) -> bool {
    tables.classes[id as usize] & PRECISE != 0
}

#[inline(always)]
fn most_moved8(rays: &RayPacket, extent: f32) -> F32x8 {
    let [x, y, z] = [rays.origin.x.to_array(), rays.origin.y.to_array(), rays.origin.z.to_array()];
    F32x8::from_array(std::array::from_fn(|lane| most_moved([x[lane], y[lane], z[lane]], extent)))
}

/// Tells of the hits in f64 that the rays of `lanes` have on triangle `lane` of a block, at any `t`.
#[inline(never)]
fn precise_hits(
    rays: &RayPacket,
    block: &LeafBlock,
    lane: usize,
    lanes: Mask8,
    class: u8,
    mut take: impl FnMut(usize, PreciseHit),
) {
    let columns = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
    let (origin, direction) = (columns(rays.origin), columns(rays.direction));
    let mut bits = lanes.bits();
    while bits != 0 {
        let at = bits.trailing_zeros() as usize & 7;
        bits &= bits - 1;
        let ray = PreciseRay::new(origin.map(|axis| axis[at]), direction.map(|axis| axis[at]));
        if let Some(hit) = ray.hit(block.corners(lane), class) {
            take(at, hit);
        }
    }
}

/// Which of eight rays hit anything before `tmax`, or at `tmax` itself a triangle of an id below that of `before`.
pub(super) fn any(
    tables: Tables,
    given: &RayPacket,
    before: U32x8,
    active: Mask8,
    stack: &mut PacketStack,
    counters: &mut WalkCounters,
) -> Mask8 {
    let active = active & given.finite();
    if !active.any() {
        return Mask8::NONE;
    }
    let rays = given.without_garbage(active);
    let boxes = EightRaysBoxes::new(rays.origin, rays.direction, rays.tmin, tables.extent);
    let triangles = EightRays::new(rays.origin, rays.direction);
    let interval = interval(tables, &rays);
    let best_wide = rays.tmax * F32x8::splat(WIDENING);
    let farthest = farthest_of(rays.tmax);
    let mut open = active;
    let mut top = 0;
    let (mut next, mut entered) = (0u32, active);
    loop {
        let live = entered & open;
        let count = live.count();
        counters.lanes_possible += LANES as u64;
        counters.lanes_used += count as u64;
        if count == 0 {
        } else if is_leaf(next) {
            let (block, precise) = (&tables.leaves[block_of(next)], holds_precise(next));
            for kz in 0..3 {
                let own = live & triangles.lanes_by_axis[kz];
                if own.any() {
                    for lane in 0..triangles_in(next) {
                        let edges = triangles.edges(block, lane, kz);
                        let id = block.ids[lane];
                        let mut blocks = |at: usize, hit: PreciseHit| {
                            let (tmin, tmax) = (rays.tmin.to_array()[at], rays.tmax.to_array()[at]);
                            let ends = hit.t < tmax || (hit.t == tmax && id < before.to_array()[at]);
                            if hit.t > tmin && ends {
                                open = open.and_not(Mask8::from_bits(1 << at));
                            }
                        };
                        if precise && is_precise(tables, id) {
                            let near = own & edges.near(most_moved8(&rays, tables.extent));
                            precise_hits(&rays, block, lane, near, tables.classes[id as usize], blocks);
                            continue;
                        }
                        let inside = edges.inside & own;
                        if inside.any() {
                            let edge_on = inside & edges.edge_on();
                            if edge_on.any() {
                                precise_hits(&rays, block, lane, edge_on, SHARED_EDGES, &mut blocks);
                            }
                            let t = edges.t_scaled / edges.det;
                            let ends = t.lt(rays.tmax) | (t.eq(rays.tmax) & U32x8::splat(id).lt_signed(before));
                            open = open.and_not(inside.and_not(edge_on) & t.gt(rays.tmin) & ends);
                        }
                    }
                }
            }
            if !open.any() {
                break;
            }
        } else {
            let node = &tables.nodes[next as usize];
            let mut chosen: Option<(u32, Mask8)> = None;
            let mut children = match &interval {
                Some(interval) => interval.test(&node.bounds, farthest).bits() as u32,
                None => (1 << node.count()) - 1,
            };
            while children != 0 {
                // The first child, the largest, is pushed last and visited first.
                let child = children.ilog2() as usize & 7;
                children &= !(1 << child);
                let hit = match &interval {
                    Some(interval) => boxes.test_octant(interval, &node.bounds, child, best_wide),
                    None => boxes.test(&node.bounds, child, best_wide),
                };
                let hit = hit.1 & live;
                if hit.any() {
                    if let Some((word, entered)) = chosen {
                        stack.push(&mut top, word, entered.select(F32x8::ONE, F32x8::ZERO));
                    }
                    chosen = Some((node.children[child], hit));
                }
            }
            if let Some(chosen) = chosen {
                (next, entered) = chosen;
                continue;
            }
        }
        if top == 0 {
            break;
        }
        top -= 1;
        (next, entered) = (stack.words[top], F32x8::from_array(stack.near[top]).gt(F32x8::ZERO));
    }
    active.and_not(open)
}
