//! Eight rays at a time through the tree: one stack, a node is entered by all lanes whose rays hit its box.

use super::here;
use crate::bvh::node::{LeafBlock, Tables, block_of, holds_precise, is_leaf, triangles_in};
use crate::bvh::precise::PRECISE;
use crate::bvh::ray::WalkCounters;
use crate::bvh::rounding::{WIDENING, most_moved};
use here::lanes::{F32x8, LANES, Mask8, U32x8};
use here::walks::boxes::{EightRaysBoxes, Interval};
use here::walks::packets::{HitPacket, RayPacket};
use here::walks::triangle::{Best, EightRays, blocked_edge_on, blocked_precisely, reach8};

/// Nodes and leaves still to be visited, with every lane's distance: NaN where its ray misses the box, so that it is below
/// nothing, not even below the infinite `t` of a ray that has hit nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct PacketStack {
    words: Vec<u32>,
    near: Vec<[f32; LANES]>,
    /// Of walks to any hit, which lanes enter, in place of distances.
    entered: Vec<u8>,
}

impl PacketStack {
    /// Room for `entries`.
    pub(super) fn reserve(&mut self, entries: usize) {
        if self.words.len() < entries {
            self.words.resize(entries, 0);
            self.near.resize(entries, [0.0; LANES]);
            self.entered.resize(entries, 0);
        }
    }
    #[inline(always)]
    fn push(&mut self, top: &mut usize, word: u32, near: F32x8) {
        self.words[*top] = word;
        self.near[*top] = near.to_array();
        *top += 1;
    }
    #[inline(always)]
    fn push_entered(&mut self, top: &mut usize, word: u32, entered: Mask8) {
        self.words[*top] = word;
        self.entered[*top] = entered.bits();
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
/// gained 3 to 5 %. Leaves that few rays enter are not tested ray by ray against eight triangles at once, either: where that
/// is done for half as many rays as triangles or fewer, shadow rays gain 2 to 4 % and camera rays lose 2 to 5 %. This walk and
/// [`any`] as one with a const parameter took 8 and 15 % more instructions.
pub(super) fn closest(
    tables: Tables,
    given: &RayPacket,
    active: Mask8,
    stack: &mut PacketStack,
    counters: &mut WalkCounters,
) -> HitPacket {
    here::run(
        #[inline(always)]
        || {
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
                    let (leaf, precise) = (block_of(next), holds_precise(next));
                    let block = &tables.leaves[leaf];
                    let before = best.t;
                    for kz in 0..3 {
                        let own = live & triangles.lanes_by_axis[kz];
                        if own.any() {
                            for lane in 0..triangles_in(next) {
                                let id = block.ids[lane];
                                if precise && is_precise(tables, id) {
                                    best = updated_precisely(best, &triangles, (block, lane), kz, (&rays, tables), own);
                                    continue;
                                }
                                let edges = triangles.edges(block, lane, kz);
                                let inside = edges.inside & own;
                                if inside.any() {
                                    let least_det =
                                        reach8(rays.origin, tables.extent) * F32x8::splat(tables.least_det[leaf]);
                                    if (inside & edges.det.abs().lt(least_det)).any() {
                                        best = updated_carefully(best, &triangles, (block, lane), kz, &rays, own);
                                    } else {
                                        best.update(&edges, id, own, rays.tmin);
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
        },
    )
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

/// The hits of the rays of `own` after triangle `lane` of a block, which is precise.
#[inline(never)]
fn updated_precisely(
    best: Best,
    triangles: &EightRays,
    (block, lane): (&LeafBlock, usize),
    kz: usize,
    (rays, tables): (&RayPacket, Tables),
    own: Mask8,
) -> Best {
    here::run(
        #[inline(always)]
        || {
            let near = own & triangles.edges(block, lane, kz).near(most_moved8(rays, tables.extent));
            if !near.any() {
                return best;
            }
            let id = block.ids[lane];
            best.updated_precisely(rays, block.corners(lane), (id, tables.classes[id as usize]), near)
        },
    )
}

/// Which rays of `own` are blocked by triangle `lane` of a block, which is precise.
#[inline(never)]
fn blocked_by_precise(
    triangles: &EightRays,
    (block, lane): (&LeafBlock, usize),
    kz: usize,
    (rays, before, tables): (&RayPacket, U32x8, Tables),
    own: Mask8,
) -> Mask8 {
    here::run(
        #[inline(always)]
        || {
            let near = own & triangles.edges(block, lane, kz).near(most_moved8(rays, tables.extent));
            if !near.any() {
                return Mask8::NONE;
            }
            let id = block.ids[lane];
            blocked_precisely(rays, before, block.corners(lane), (id, tables.classes[id as usize]), near)
        },
    )
}

/// The hits of the rays of `own` after triangle `lane` of a block that some see edge-on. (All is worked out anew: what is kept
/// for the sake of a path hardly ever taken would cost the other one its registers.)
#[cold]
#[inline(never)]
fn updated_carefully(
    mut best: Best,
    triangles: &EightRays,
    (block, lane): (&LeafBlock, usize),
    kz: usize,
    rays: &RayPacket,
    own: Mask8,
) -> Best {
    here::run(
        #[inline(always)]
        || {
            let (edges, id) = (triangles.edges(block, lane, kz), block.ids[lane]);
            let edge_on = edges.inside & own & edges.edge_on();
            best.update(&edges, id, own.and_not(edge_on), rays.tmin);
            best.updated_edge_on(rays, block.corners(lane), (&edges, id), edge_on)
        },
    )
}

/// Which rays of `own` are blocked by triangle `lane` of a block that some see edge-on.
#[cold]
#[inline(never)]
fn blocked_carefully(
    triangles: &EightRays,
    (block, lane): (&LeafBlock, usize),
    kz: usize,
    (rays, before): (&RayPacket, U32x8),
    own: Mask8,
) -> Mask8 {
    here::run(
        #[inline(always)]
        || {
            let (edges, id) = (triangles.edges(block, lane, kz), block.ids[lane]);
            let edge_on = edges.inside & own & edges.edge_on();
            let blocked = edges.blocked(rays, before, id) & own.and_not(edge_on);
            blocked | blocked_edge_on(rays, before, block.corners(lane), (&edges, id), edge_on)
        },
    )
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
    here::run(
        #[inline(always)]
        || {
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
                    let (leaf, precise) = (block_of(next), holds_precise(next));
                    let block = &tables.leaves[leaf];
                    for kz in 0..3 {
                        let own = live & triangles.lanes_by_axis[kz];
                        if own.any() {
                            for lane in 0..triangles_in(next) {
                                let id = block.ids[lane];
                                if precise && is_precise(tables, id) {
                                    let packet = (&rays, before, tables);
                                    open = open.and_not(blocked_by_precise(&triangles, (block, lane), kz, packet, own));
                                    continue;
                                }
                                let edges = triangles.edges(block, lane, kz);
                                let inside = edges.inside & own;
                                if inside.any() {
                                    let least_det =
                                        reach8(rays.origin, tables.extent) * F32x8::splat(tables.least_det[leaf]);
                                    let blocked = if (inside & edges.det.abs().lt(least_det)).any() {
                                        blocked_carefully(&triangles, (block, lane), kz, (&rays, before), own)
                                    } else {
                                        edges.blocked(&rays, before, id) & own
                                    };
                                    open = open.and_not(blocked);
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
                                stack.push_entered(&mut top, word, entered);
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
                (next, entered) = (stack.words[top], Mask8::from_bits(stack.entered[top]));
            }
            active.and_not(open)
        },
    )
}
