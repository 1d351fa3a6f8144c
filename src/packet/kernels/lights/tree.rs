//! Walking the light tree from eight points at once.
//!
//! Where all eight stand at the same node (always at the root), a cluster is rated for eight points by one vector
//! operation. Where they have parted, a node's eight clusters are rated for one point, and the eight results are turned
//! about; either way column by column, lanes being points, so that sums have the scalar twin's order.

use super::here;
use crate::tables::lights::learned::{LEVELS, LearnedLights};
use crate::tables::lights::tree::{LEAF, LEAST_COSINE, LEAST_SHARE, LightNode, LightTree, PAIR, WIDTH};
use here::kernels::lights::factors::factors;
use here::lanes::{Each, F32x8, LANES, Mask8, U32x8, Vec3x8};
use here::numbers::unit_x8;

/// Eight places where a light is wanted, with the normals of the surfaces there.
#[derive(Clone, Copy)]
pub struct Receivers {
    /// Where rays leave the surfaces.
    pub origin: Vec3x8,
    /// Unit normals.
    pub normal: Vec3x8,
    /// Rows of what was learned ([`LearnedLights::rows`]); read only where something was.
    pub row: U32x8,
}

/// The lights that eight selection words choose, and the probabilities with which they do. Lanes not `active` hold
/// anything.
#[inline(never)]
pub fn choose_lights(
    tree: &LightTree,
    learned: Option<&LearnedLights>,
    receivers: &Receivers,
    active: Mask8,
    word: U32x8,
) -> (U32x8, F32x8) {
    here::run(
        #[inline(always)]
        || {
            let mut u = unit_x8(word);
            let mut rest = (word & U32x8::splat(0xff)).to_f32() * F32x8::splat(1.0 / 4_294_967_296.0);
            let mut bits = word;
            let mut walk = Walk::new(active, learned);
            let mut light = U32x8::ZERO;
            while walk.active.any() {
                let shares = walk.shares(tree, receivers);
                let total = sum(&shares);
                let x = u * total;
                let (mut low, mut high) = (F32x8::ZERO, F32x8::ZERO);
                let (mut share, mut column) = (shares[WIDTH - 1], U32x8::splat(WIDTH as u32 - 1));
                let mut open = Mask8::ALL;
                for (number, next) in shares.into_iter().enumerate().take(WIDTH - 1) {
                    low = open.select(high, low);
                    high = high + next;
                    let here = open & x.lt(high);
                    share = here.select(next, share);
                    column = here.select_u32(U32x8::splat(number as u32), column);
                    open = open.and_not(here);
                }
                low = open.select(high, low);
                let along = ((u - low / total) + rest) / (share / total);
                u = along.max(F32x8::ZERO).min(F32x8::splat(ONE_BELOW));
                bits = bits * U32x8::splat(1_664_525) + U32x8::splat(1_013_904_223);
                rest = (bits >> 8).to_f32() * F32x8::splat(1.0 / 281_474_976_710_656.0);
                let child = walk.descend(tree, column, share, total);
                let leaf = walk.finish(child);
                let second = is_pair(child) & u.ge(F32x8::splat(0.5));
                let chosen = (child & U32x8::splat(!(LEAF | PAIR))) + second.select_u32(U32x8::splat(1), U32x8::ZERO);
                light = leaf.select_u32(chosen, light);
            }
            (light, walk.probability)
        },
    )
}

/// The probabilities with which [`choose_lights`] chooses the lights `light` for eight receivers.
#[inline(never)]
pub fn light_probabilities(
    tree: &LightTree,
    learned: Option<&LearnedLights>,
    receivers: &Receivers,
    active: Mask8,
    light: U32x8,
) -> F32x8 {
    here::run(
        #[inline(always)]
        || {
            let mut path = light.to_array().map(|light| tree.paths[light as usize]);
            let mut walk = Walk::new(active, learned);
            while walk.active.any() {
                let shares = walk.shares(tree, receivers);
                let total = sum(&shares);
                let column = U32x8::from_array(path.map(|path| path as u32 & 7));
                path = path.map(|path| path >> 3);
                let mut share = shares[0];
                for (number, next) in shares.into_iter().enumerate().skip(1) {
                    share = column.eq(U32x8::splat(number as u32)).select(next, share);
                }
                let child = walk.descend(tree, column, share, total);
                walk.finish(child);
            }
            walk.probability
        },
    )
}

/// How many eighths of the light samples for eight receivers go to the environment; see the scalar twin.
#[inline(never)]
pub fn environment_eighths(tree: &LightTree, receivers: &Receivers) -> U32x8 {
    here::run(
        #[inline(always)]
        || {
            let environment = F32x8::splat(tree.environment);
            let share = environment / (environment + sum(&for_eight_points(&tree.nodes[0], receivers)));
            let eighths = U32x8::from_f32(share * F32x8::splat(8.0) + F32x8::splat(0.5));
            eighths.max_signed(U32x8::splat(1)).min_signed(U32x8::splat(7))
        },
    )
}

/// The largest f32 below 1.
const ONE_BELOW: f32 = 1.0 - 1.0 / 16_777_216.0;

/// Eight ways down the tree.
struct Walk<'a> {
    /// Lanes still on their way.
    active: Mask8,
    node: U32x8,
    probability: F32x8,
    /// What was learned, as long as lanes stand at nodes that may have words.
    learned: Option<&'a LearnedLights>,
    level: usize,
}

impl<'a> Walk<'a> {
    #[inline(always)]
    fn new(active: Mask8, learned: Option<&'a LearnedLights>) -> Walk<'a> {
        Walk { active, node: U32x8::ZERO, probability: active.select(F32x8::ONE, F32x8::ZERO), learned, level: 0 }
    }

    /// What the columns of the lanes' nodes are chosen in proportion to.
    #[inline(always)]
    fn shares(&self, tree: &LightTree, receivers: &Receivers) -> [F32x8; WIDTH] {
        let node = self.node.to_array();
        let mut importances = if node.iter().all(|&other| other == node[0]) {
            for_eight_points(&tree.nodes[node[0] as usize], receivers)
        } else {
            self.for_eight_clusters(tree, receivers)
        };
        if let Some(learned) = self.learned {
            let factors = factors(learned, &receivers.row.to_array(), &node);
            for (importance, factor) in importances.iter_mut().zip(factors) {
                *importance = *importance * factor;
            }
        }
        shares(&importances)
    }

    #[inline(always)]
    fn for_eight_clusters(&self, tree: &LightTree, receivers: &Receivers) -> [F32x8; WIDTH] {
        let (node, bits) = (self.node.to_array(), self.active.bits());
        let columns = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
        let (origin, normal) = (columns(receivers.origin), columns(receivers.normal));
        let mut rows = [F32x8::ZERO; LANES];
        let mut lanes = bits;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let splat = |v: &[[f32; LANES]; 3]| Vec3x8::splat([v[0][lane], v[1][lane], v[2][lane]]);
            rows[lane] = cluster_importances(&tree.nodes[node[lane] as usize], splat(&origin), splat(&normal));
        }
        F32x8::transpose(rows)
    }

    /// Multiplies the probabilities by that of the chosen columns; the children there.
    #[inline(always)]
    fn descend(&mut self, tree: &LightTree, column: U32x8, share: F32x8, total: F32x8) -> U32x8 {
        self.probability = self.active.select(self.probability * (share / total), self.probability);
        let (node, column) = (self.node.to_array(), column.to_array());
        U32x8::from_array(std::array::from_fn(|lane| tree.nodes[node[lane] as usize].child[column[lane] as usize]))
    }

    /// Ends the lanes whose `child` is a leaf (they are returned) and moves the others on.
    #[inline(always)]
    fn finish(&mut self, child: U32x8) -> Mask8 {
        let leaf = self.active & (child & U32x8::splat(LEAF)).eq(U32x8::splat(LEAF));
        let half = (leaf & is_pair(child)).select(F32x8::splat(0.5), F32x8::ONE);
        self.probability = self.probability * half;
        self.active = self.active.and_not(leaf);
        self.node = self.active.select_u32(child, U32x8::ZERO);
        self.level += 1;
        if self.level == LEVELS {
            self.learned = None;
        }
        leaf
    }
}

/// What columns of these importances are chosen in proportion to: none is far below the sum unless it is 0; the first if all
/// are.
#[inline(always)]
pub fn shares(importances: &[F32x8; WIDTH]) -> [F32x8; WIDTH] {
    let total = sum(importances);
    let least = total * F32x8::splat(LEAST_SHARE);
    let mut shares = importances.each(
        #[inline(always)]
        |importance| {
            let raised = importance.gt(least).select(importance, least);
            importance.gt(F32x8::ZERO).select(raised, F32x8::ZERO)
        },
    );
    shares[0] = total.gt(F32x8::ZERO).select(shares[0], F32x8::ONE);
    shares
}

#[inline(always)]
fn is_pair(child: U32x8) -> Mask8 {
    (child & U32x8::splat(PAIR)).eq(U32x8::splat(PAIR))
}

#[inline(always)]
pub(super) fn sum(columns: &[F32x8; WIDTH]) -> F32x8 {
    let mut sum = F32x8::ZERO;
    for &column in columns {
        sum = sum + column;
    }
    sum
}

/// The importances of one node's clusters: `[column]` lane `i` is that for receiver `i`.
#[inline(always)]
fn for_eight_points(node: &LightNode, receivers: &Receivers) -> [F32x8; WIDTH] {
    let mut importances = [F32x8::ZERO; WIDTH];
    for (column, importance) in importances.iter_mut().enumerate().take_while(|(column, _)| node.power[*column] > 0.0) {
        let clusters = Clusters::of(node, |columns| F32x8::splat(columns[column]));
        *importance = clusters.importance(receivers.origin, receivers.normal);
    }
    importances
}

/// The importances of a node's eight clusters for one receiver, eight times given.
#[inline(always)]
pub fn cluster_importances(node: &LightNode, origin: Vec3x8, normal: Vec3x8) -> F32x8 {
    Clusters::of(node, |column| F32x8::from_array(*column)).importance(origin, normal)
}

/// Eight clusters.
struct Clusters {
    center: Vec3x8,
    half: Vec3x8,
    axis: Vec3x8,
    spread: F32x8,
    depth: F32x8,
    blur: F32x8,
    power: F32x8,
}

impl Clusters {
    /// Those of a node, or one of them eight times: as `lanes` takes them from the columns.
    #[inline(always)]
    fn of(node: &LightNode, lanes: impl Fn(&[f32; WIDTH]) -> F32x8) -> Clusters {
        let vector = |v: &[[f32; WIDTH]; 3]| Vec3x8::new(lanes(&v[0]), lanes(&v[1]), lanes(&v[2]));
        Clusters {
            center: vector(&node.center),
            half: vector(&node.half),
            axis: vector(&node.axis),
            spread: lanes(&node.spread),
            depth: lanes(&node.depth),
            blur: lanes(&node.blur),
            power: lanes(&node.power),
        }
    }

    /// Roughly what they can send to eight receivers: see the scalar twin.
    #[inline(always)]
    fn importance(&self, origin: Vec3x8, normal: Vec3x8) -> F32x8 {
        let zero = F32x8::ZERO;
        let to_center = self.center - origin;
        let distance_squared = to_center.dot(to_center);
        let outside = to_center.abs() - self.half;
        let nearest = Vec3x8::new(outside.x.max(zero), outside.y.max(zero), outside.z.max(zero));
        let nearest = nearest.dot(nearest).sqrt();
        let rise = mean_above(normal.dot(to_center), normal.abs().dot(self.half));
        let front = mean_above(-self.axis.dot(to_center), self.depth + self.spread * distance_squared.sqrt());
        let cosines = cosine(rise, nearest) * cosine(front, nearest);
        self.power * cosines / (distance_squared + self.blur)
    }
}

/// The means of max(0, x) for x spread evenly over `mean - width .. mean + width`.
#[inline(always)]
fn mean_above(mean: F32x8, width: F32x8) -> F32x8 {
    let top = mean + width;
    let partly = top * top / (F32x8::splat(4.0) * width);
    let mean = mean.lt(width).select(partly, mean);
    top.gt(F32x8::ZERO).select(mean, F32x8::ZERO)
}

/// Cosines, at most 1, of directions that rise by `height` over `length`; never quite 0 where they rise at all.
#[inline(always)]
fn cosine(height: F32x8, length: F32x8) -> F32x8 {
    let cosine = height.lt(length).select(height / length, F32x8::ONE).max(F32x8::splat(LEAST_COSINE));
    height.gt(F32x8::ZERO).select(cosine, F32x8::ZERO)
}
