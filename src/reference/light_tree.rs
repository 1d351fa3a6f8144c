//! Walking the light tree from a point: which light to sample, and with which probability.
//!
//! The importance of a cluster is an upper estimate of the light it can send to a surface (Conty Estevez and Kulla 2018,
//! section 4.1; pbrt-v4 section 12.6.3): power times the best cosines that its bounds allow, over the squared distance.

use super::{Real, Vec3};
use crate::scene::light_tree::{COSINE_MARGIN, LEAF, LEAST_COSINE, LEAST_SHARE, LightNode, LightTree, PAIR, WIDTH};
use crate::sampler::unit;

/// Where a light is wanted: a place and the normal of the surface there, towards the side that light reaches.
#[derive(Clone, Copy)]
pub struct Receiver {
    /// Where rays leave the surface.
    pub origin: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}

/// The light that a selection word chooses for `receiver`, and the probability with which it does; `None` if no light
/// can contribute there.
pub fn choose_light(tree: &LightTree, receiver: &Receiver, word: u32) -> Option<(u32, Real)> {
    let mut u = unit(word) as Real;
    // What the 24 bits of `u` leave of the word; the first choice makes room for it.
    let mut rest = (word & 0xff) as Real * (1.0 / 4_294_967_296.0);
    let mut probability = 1.0;
    let mut node = &tree.nodes[0];
    loop {
        let shares = shares(node, receiver)?;
        let total = shares.iter().fold(0.0, |sum, share| sum + share);
        let x = u * total;
        let (mut low, mut column) = (0.0, 0);
        while column + 1 < WIDTH && !(x < low + shares[column]) {
            low += shares[column];
            column += 1;
        }
        probability *= shares[column] / total;
        u = below_one(((x - low) + rest * total) / shares[column]);
        rest = 0.0;
        let child = node.child[column];
        if child & LEAF != 0 {
            let light = child & !(LEAF | PAIR);
            return Some(match child & PAIR != 0 {
                true => (light + (u >= 0.5) as u32, probability * 0.5),
                false => (light, probability),
            });
        }
        node = &tree.nodes[child as usize];
    }
}

/// The probability with which [`choose_light`] chooses `light` for `receiver`.
pub fn light_probability(tree: &LightTree, receiver: &Receiver, light: u32) -> Real {
    let mut path = tree.paths[light as usize];
    let mut probability = 1.0;
    let mut node = &tree.nodes[0];
    loop {
        let Some(shares) = shares(node, receiver) else { return 0.0 };
        let total = shares.iter().fold(0.0, |sum, share| sum + share);
        let column = (path & 7) as usize;
        path >>= 3;
        probability *= shares[column] / total;
        let child = node.child[column];
        if child & LEAF != 0 {
            return if child & PAIR != 0 { probability * 0.5 } else { probability };
        }
        node = &tree.nodes[child as usize];
    }
}

/// What the columns of a node are chosen in proportion to: their importances, none of which is far below the sum unless it
/// is 0. `None` if all are.
fn shares(node: &LightNode, receiver: &Receiver) -> Option<[Real; WIDTH]> {
    let importances: [Real; WIDTH] = std::array::from_fn(|column| importance(node, column, receiver));
    let total = importances.iter().fold(0.0, |sum, importance| sum + importance);
    let least = total * LEAST_SHARE as Real;
    let share = |importance: Real| match importance > 0.0 {
        true if importance > least => importance,
        true => least,
        false => 0.0,
    };
    (total > 0.0).then(|| importances.map(share))
}

/// The importance of the cluster in a column.
fn importance(node: &LightNode, column: usize, receiver: &Receiver) -> Real {
    let at = |columns: &[[f32; WIDTH]; 3]| super::vec3([columns[0][column], columns[1][column], columns[2][column]]);
    let to_center = at(&node.center) - receiver.origin;
    let distance_squared = to_center.dot(to_center);
    let radius_squared = node.radius_squared[column] as Real;
    let power = node.power[column] as Real;
    let inside = distance_squared <= radius_squared;
    if inside {
        return power / radius_squared;
    }
    let direction = to_center * (1.0 / distance_squared.sqrt());
    // The sphere fills a cone of this half angle.
    let sin_sphere_squared = radius_squared / distance_squared;
    let (sin_sphere, cos_sphere) = (sin_sphere_squared.sqrt(), (1.0 - sin_sphere_squared).sqrt());
    // At the receiver: the angle between the normal and the nearest direction into the sphere.
    let (sin_i, cos_i) = sin_cos_of(receiver.normal.dot(direction));
    let (_, cos_receiver) = sin_cos_of_difference((sin_i, cos_i), (sin_sphere, cos_sphere));
    // At the light: the angle between the nearest normal in the cone and the nearest direction to the receiver.
    let normal_angle = sin_cos_of(-at(&node.axis).dot(direction));
    let cone = (node.sin_cone[column] as Real, node.cos_cone[column] as Real);
    let (_, cos_light) = sin_cos_of_difference(sin_cos_of_difference(normal_angle, cone), (sin_sphere, cos_sphere));
    power * visible(cos_receiver) * visible(cos_light) / distance_squared
}

/// Sine and cosine of an angle between 0 and pi, from its cosine.
fn sin_cos_of(cosine: Real) -> (Real, Real) {
    let squared = 1.0 - cosine * cosine;
    (if squared > 0.0 { squared.sqrt() } else { 0.0 }, cosine)
}

/// Sine and cosine of max(0, a - b), from those of `a` and `b` (both between 0 and pi).
fn sin_cos_of_difference(a: (Real, Real), b: (Real, Real)) -> (Real, Real) {
    if a.1 > b.1 {
        return (0.0, 1.0);
    }
    (a.0 * b.1 - a.1 * b.0, a.1 * b.1 + a.0 * b.0)
}

/// A cosine as it counts: 0 only well below the horizon.
fn visible(cosine: Real) -> Real {
    if cosine > LEAST_COSINE as Real {
        cosine
    } else if cosine > COSINE_MARGIN as Real {
        LEAST_COSINE as Real
    } else {
        0.0
    }
}

fn below_one(u: Real) -> Real {
    if u < ONE_BELOW as Real { u } else { ONE_BELOW as Real }
}

/// The largest f32 below 1.
const ONE_BELOW: f32 = 1.0 - 1.0 / 16_777_216.0;
