//! Walking the light tree from eight points at once.
//!
//! Where all eight stand at the same node (always at the root), a cluster is rated for eight points by one vector
//! operation. Where they have parted, a node's eight clusters are rated for one point, and the eight results are turned
//! about; either way column by column, lanes being points, so that sums have the scalar twin's order.

use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use crate::sampler::unit_x8;
use crate::scene::light_tree::{COSINE_MARGIN, LEAF, LEAST_COSINE, LEAST_SHARE, LightNode, LightTree, PAIR, WIDTH};

/// Eight places where a light is wanted, with the normals of the surfaces there.
#[derive(Clone, Copy)]
pub struct Receivers {
    /// Where rays leave the surfaces.
    pub origin: Vec3x8,
    /// Unit normals.
    pub normal: Vec3x8,
}

/// The lights that eight selection words choose, and the probabilities with which they do: 0 where no light can
/// contribute (the light is then any). Lanes not `active` hold anything.
#[inline(never)]
pub fn choose_lights(tree: &LightTree, receivers: &Receivers, active: Mask8, word: U32x8) -> (U32x8, F32x8) {
    let mut u = unit_x8(word);
    let mut rest = (word & U32x8::splat(0xff)).to_f32() * F32x8::splat(1.0 / 4_294_967_296.0);
    let mut walk = Walk::new(active);
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
        u = (((x - low) + rest * total) / share).min(F32x8::splat(ONE_BELOW));
        rest = F32x8::ZERO;
        let child = walk.descend(tree, column, share, total);
        let leaf = walk.finish(child);
        let second = is_pair(child) & u.ge(F32x8::splat(0.5));
        let chosen = (child & U32x8::splat(!(LEAF | PAIR))) + second.select_u32(U32x8::splat(1), U32x8::ZERO);
        light = leaf.select_u32(chosen, light);
    }
    (light, walk.probability)
}

/// The probabilities with which [`choose_lights`] chooses the lights `light` for eight receivers.
#[inline(never)]
pub fn light_probabilities(tree: &LightTree, receivers: &Receivers, active: Mask8, light: U32x8) -> F32x8 {
    let mut path = light.to_array().map(|light| tree.paths[light as usize]);
    let mut walk = Walk::new(active);
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
}

/// The largest f32 below 1.
const ONE_BELOW: f32 = 1.0 - 1.0 / 16_777_216.0;

/// Eight ways down the tree.
struct Walk {
    /// Lanes still on their way.
    active: Mask8,
    node: U32x8,
    probability: F32x8,
}

impl Walk {
    fn new(active: Mask8) -> Walk {
        Walk { active, node: U32x8::ZERO, probability: active.select(F32x8::ONE, F32x8::ZERO) }
    }

    /// What the columns of the lanes' nodes are chosen in proportion to: their importances, none of which is far below the
    /// sum unless it is 0.
    #[inline(always)]
    fn shares(&self, tree: &LightTree, receivers: &Receivers) -> [F32x8; WIDTH] {
        let node = self.node.to_array();
        let importances = if node.iter().all(|&other| other == node[0]) {
            for_eight_points(&tree.nodes[node[0] as usize], receivers)
        } else {
            self.for_eight_clusters(tree, receivers)
        };
        let least = sum(&importances) * F32x8::splat(LEAST_SHARE);
        importances.map(|importance| {
            let raised = importance.gt(least).select(importance, least);
            importance.gt(F32x8::ZERO).select(raised, F32x8::ZERO)
        })
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
            let node = &tree.nodes[node[lane] as usize];
            let load = |column: &[f32; WIDTH]| F32x8::from_array(*column);
            let vector = |v: &[[f32; WIDTH]; 3]| Vec3x8::new(load(&v[0]), load(&v[1]), load(&v[2]));
            let clusters = Clusters {
                center: vector(&node.center),
                radius_squared: load(&node.radius_squared),
                axis: vector(&node.axis),
                cone: (load(&node.sin_cone), load(&node.cos_cone)),
                power: load(&node.power),
            };
            rows[lane] = clusters.importance(splat(&origin), splat(&normal));
        }
        F32x8::transpose(rows)
    }

    /// Multiplies the probabilities by that of the chosen columns; the children there.
    #[inline(always)]
    fn descend(&mut self, tree: &LightTree, column: U32x8, share: F32x8, total: F32x8) -> U32x8 {
        let possible = total.gt(F32x8::ZERO);
        let step = possible.select(share / total, F32x8::ZERO);
        self.probability = self.active.select(self.probability * step, self.probability);
        self.active = self.active & possible;
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
        leaf
    }
}

#[inline(always)]
fn is_pair(child: U32x8) -> Mask8 {
    (child & U32x8::splat(PAIR)).eq(U32x8::splat(PAIR))
}

#[inline(always)]
fn sum(columns: &[F32x8; WIDTH]) -> F32x8 {
    columns.iter().fold(F32x8::ZERO, |sum, &column| sum + column)
}

/// The importances of one node's clusters: `[column]` lane `i` is that for receiver `i`.
#[inline(always)]
fn for_eight_points(node: &LightNode, receivers: &Receivers) -> [F32x8; WIDTH] {
    let mut importances = [F32x8::ZERO; WIDTH];
    for (column, importance) in importances.iter_mut().enumerate().take(node.count as usize) {
        let splat = |columns: &[f32; WIDTH]| F32x8::splat(columns[column]);
        let vector = |v: &[[f32; WIDTH]; 3]| Vec3x8::new(splat(&v[0]), splat(&v[1]), splat(&v[2]));
        let clusters = Clusters {
            center: vector(&node.center),
            radius_squared: splat(&node.radius_squared),
            axis: vector(&node.axis),
            cone: (splat(&node.sin_cone), splat(&node.cos_cone)),
            power: splat(&node.power),
        };
        *importance = clusters.importance(receivers.origin, receivers.normal);
    }
    importances
}

/// Eight clusters.
struct Clusters {
    center: Vec3x8,
    radius_squared: F32x8,
    axis: Vec3x8,
    cone: (F32x8, F32x8),
    power: F32x8,
}

impl Clusters {
    /// What they can send to eight receivers at most, roughly: see the scalar twin.
    #[inline(always)]
    fn importance(&self, origin: Vec3x8, normal: Vec3x8) -> F32x8 {
        let one = F32x8::ONE;
        let to_center = self.center - origin;
        let distance_squared = to_center.dot(to_center);
        let outside = distance_squared.gt(self.radius_squared);
        let direction = to_center.scale(one / distance_squared.sqrt());
        let sin_sphere_squared = self.radius_squared / distance_squared;
        let sphere = (sin_sphere_squared.sqrt(), (one - sin_sphere_squared).sqrt());
        let (_, cos_receiver) = sin_cos_of_difference(sin_cos_of(normal.dot(direction)), sphere);
        let normal_angle = sin_cos_of(-self.axis.dot(direction));
        let (_, cos_light) = sin_cos_of_difference(sin_cos_of_difference(normal_angle, self.cone), sphere);
        let far = self.power * visible(cos_receiver) * visible(cos_light) / distance_squared;
        outside.select(far, self.power / self.radius_squared)
    }
}

/// Sines and cosines of angles between 0 and pi, from their cosines.
#[inline(always)]
fn sin_cos_of(cosine: F32x8) -> (F32x8, F32x8) {
    ((F32x8::ONE - cosine * cosine).max(F32x8::ZERO).sqrt(), cosine)
}

/// Sines and cosines of max(0, a - b).
#[inline(always)]
fn sin_cos_of_difference(a: (F32x8, F32x8), b: (F32x8, F32x8)) -> (F32x8, F32x8) {
    let covered = a.1.gt(b.1);
    (covered.select(F32x8::ZERO, a.0 * b.1 - a.1 * b.0), covered.select(F32x8::ONE, a.1 * b.1 + a.0 * b.0))
}

/// Cosines as they count: 0 only well below the horizon.
#[inline(always)]
fn visible(cosine: F32x8) -> F32x8 {
    let seen = cosine.max(F32x8::splat(LEAST_COSINE));
    cosine.gt(F32x8::splat(COSINE_MARGIN)).select(seen, F32x8::ZERO)
}
