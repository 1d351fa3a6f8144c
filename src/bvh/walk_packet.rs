//! Eight rays at a time through the tree: one stack, a node is entered by all lanes whose rays hit its box.

use crate::bvh::boxes::{EightRaysBoxes, Interval, WIDENING};
use crate::bvh::node::{Tables, block_of, is_leaf, triangles_in};
use crate::bvh::ray::{HitPacket, RayPacket, WalkCounters};
use crate::bvh::triangle::{Best, EightRays};
use crate::lanes::{F32x8, LANES, Mask8};

/// A node or leaf to be visited, and by which rays: walks to any hit read `rays`, walks to the closest `near`.
#[derive(Clone, Copy)]
struct Entry {
    word: u32,
    /// The rays that enter its box.
    rays: Mask8,
    /// Their distances to it, infinite for the others.
    near: F32x8,
}

/// Nodes and leaves still to be visited. Of their rays there are the distances or, on the way to any hit, ones and zeros.
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
    fn push<const ANY: bool>(&mut self, top: &mut usize, entry: Entry) {
        let near = if ANY { entry.rays.select(F32x8::ONE, F32x8::ZERO) } else { entry.near };
        self.words[*top] = entry.word;
        self.near[*top] = near.to_array();
        *top += 1;
    }
    #[inline(always)]
    fn pop<const ANY: bool>(&mut self, top: &mut usize) -> Entry {
        *top -= 1;
        let near = F32x8::from_array(self.near[*top]);
        let rays = if ANY { near.gt(F32x8::ZERO) } else { Mask8::ALL };
        Entry { word: self.words[*top], rays, near }
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
pub(super) fn closest(
    tables: Tables,
    given: &RayPacket,
    active: Mask8,
    stack: &mut PacketStack,
    counters: &mut WalkCounters,
) -> HitPacket {
    let active = active & given.finite();
    if !active.any() {
        return Best::none(given.tmax).hits();
    }
    let mut eight = Eight::new(tables, given, active);
    eight.walk::<false>(stack, counters);
    eight.best.t = active.select(eight.best.t, given.tmax);
    eight.best.hits()
}

/// Which of eight rays hit anything.
pub(super) fn any(
    tables: Tables,
    given: &RayPacket,
    active: Mask8,
    stack: &mut PacketStack,
    counters: &mut WalkCounters,
) -> Mask8 {
    let active = active & given.finite();
    if !active.any() {
        return Mask8::NONE;
    }
    let mut eight = Eight::new(tables, given, active);
    eight.walk::<true>(stack, counters);
    active.and_not(eight.open)
}

/// Eight rays on their way through the tree.
struct Eight<'a> {
    tables: Tables<'a>,
    rays: RayPacket,
    boxes: EightRaysBoxes,
    triangles: EightRays,
    interval: Option<Interval>,
    /// The rays that still look for a hit.
    open: Mask8,
    best: Best,
    /// The largest of `best.t`, widened.
    farthest: F32x8,
}

impl<'a> Eight<'a> {
    #[inline(always)]
    fn new(tables: Tables<'a>, given: &RayPacket, active: Mask8) -> Self {
        let rays = given.without_garbage(active);
        Self {
            tables,
            boxes: EightRaysBoxes::new(rays.origin, rays.direction, rays.tmin, tables.extent),
            triangles: EightRays::new(rays.origin, rays.direction),
            interval: interval(tables, &rays),
            open: active,
            best: Best::none(rays.tmax),
            farthest: farthest_of(rays.tmax),
            rays,
        }
    }

    /// The walk to the closest hits or, if `ANY`, to the first that are found: `open` keeps the rays without one.
    ///
    /// Nodes that few rays enter are not handed to the one-ray walk. In the prototype that did so below three rays, the
    /// Cornell box took 60, 65 and 13 million camera, shadow and bounced rays a second; without, 61, 70 and 17. Shadow rays
    /// in big trees gained 3 to 5 %.
    #[inline(always)]
    fn walk<const ANY: bool>(&mut self, stack: &mut PacketStack, counters: &mut WalkCounters) {
        let mut top = 0;
        let mut next =
            Entry { word: 0, rays: self.open, near: self.open.select(F32x8::ZERO, F32x8::splat(f32::INFINITY)) };
        loop {
            let entered = if ANY { next.rays } else { next.near.le(self.best.t * F32x8::splat(WIDENING)) };
            let live = entered & self.open;
            let count = live.count();
            counters.lanes_possible += LANES as u64;
            counters.lanes_used += count as u64;
            if count == 0 {
            } else if is_leaf(next.word) {
                self.visit_leaf::<ANY>(next.word, live);
                if ANY && !self.open.any() {
                    return;
                }
            } else if let Some(chosen) = self.visit_node::<ANY>(next.word, live, stack, &mut top) {
                next = chosen;
                continue;
            }
            if top == 0 {
                return;
            }
            next = stack.pop::<ANY>(&mut top);
        }
    }

    /// Tests the triangles of a leaf, once for every dominant axis among the `live` rays.
    #[inline(always)]
    fn visit_leaf<const ANY: bool>(&mut self, leaf: u32, live: Mask8) {
        let block = &self.tables.leaves[block_of(leaf)];
        let before = self.best.t;
        for kz in 0..3 {
            let own = live & self.triangles.lanes_by_axis[kz];
            if own.any() {
                for lane in 0..triangles_in(leaf) {
                    let edges = self.triangles.edges(block, lane, kz);
                    if (edges.inside & own).any() {
                        if ANY {
                            let t = edges.t_scaled / edges.det;
                            let hit = edges.inside & own & t.gt(self.rays.tmin) & t.le(self.rays.tmax);
                            self.open = self.open.and_not(hit);
                        } else {
                            self.best.update(&edges, block.ids[lane], own, self.rays.tmin);
                        }
                    }
                }
            }
        }
        if !ANY && self.best.t.lt(before).any() {
            self.farthest = farthest_of(self.best.t);
        }
    }

    /// Pushes the children that any `live` ray enters, but for one, which is visited next. To the closest hit that is one
    /// which some ray enters before the others; to any hit the first child, the largest.
    #[inline(always)]
    fn visit_node<const ANY: bool>(
        &self,
        node: u32,
        live: Mask8,
        stack: &mut PacketStack,
        top: &mut usize,
    ) -> Option<Entry> {
        let node = &self.tables.nodes[node as usize];
        let best_wide = self.best.t * F32x8::splat(WIDENING);
        let mut chosen: Option<Entry> = None;
        let mut children = match &self.interval {
            Some(interval) => interval.test(&node.bounds, self.farthest).bits() as u32,
            None => (1 << node.count()) - 1,
        };
        while children != 0 {
            let child = if ANY { children.ilog2() } else { children.trailing_zeros() } as usize & 7;
            children &= !(1 << child);
            let (entry, hit) = match &self.interval {
                Some(interval) => self.boxes.test_octant(interval, &node.bounds, child, best_wide),
                None => self.boxes.test(&node.bounds, child, best_wide),
            };
            let hit = hit & live;
            if hit.any() {
                let near = hit.select(entry, F32x8::splat(f32::INFINITY));
                let this = Entry { word: node.children[child], rays: hit, near };
                chosen = match chosen {
                    Some(other) if ANY || near.lt(other.near).any() => {
                        stack.push::<ANY>(top, other);
                        Some(this)
                    }
                    Some(other) => {
                        stack.push::<ANY>(top, this);
                        Some(other)
                    }
                    None => Some(this),
                };
            }
        }
        chosen
    }
}
