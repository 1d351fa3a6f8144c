//! The light tree: which lights matter at a point, found without looking at all of them.
//!
//! Emissive triangles are clustered by position, orientation and power (Conty Estevez and Kulla, "Importance Sampling of
//! Many Lights with Adaptive Tree Splitting", HPG 2018; the split cost is their surface area orientation heuristic, as in
//! pbrt-v4 section 12.6.3). A node holds up to eight clusters as columns, so that one vector operation rates all eight
//! for one point, or one cluster for eight points; a tree over thousands of lights is four levels deep.
//!
//! **Leaves** are single triangles, or two that make a parallelogram of one radiance: these share a leaf, and either is
//! as likely; or delta lights ([`DeltaLights::bounds`]). A scene with one leaf needs no tree ([`LightTree::new`] gives none).
//!
//! **Bounds are conservative**: what they say cannot see each other cannot (spheres and cones are rounded outwards), so a
//! light that can contribute at a point has a positive probability there.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::tables::lights::deltas::DeltaLights;
use crate::tables::lights::emitters::Emitter;
use crate::tables::triangles::TriangleRecord;

/// Clusters a node can hold.
pub const WIDTH: usize = 8;

/// Of [`LightNode::child`]: a leaf; the other bits are the index of its (first) light.
pub const LEAF: u32 = 1 << 31;
/// Of [`LightNode::child`] of a leaf: it holds the next light too.
pub const PAIR: u32 = 1 << 30;

/// Levels a tree may have: a path is written in a u64, three bits a level.
const MAX_LEVELS: u32 = 21;

/// Every cluster has at least this share of the largest importance sum at its node if it can contribute at all, so that
/// a light is found though those beside it look stronger but are hidden.
pub const LEAST_SHARE: f32 = 1.0 / 128.0;

/// The least cosine factor of what may be visible.
pub const LEAST_COSINE: f32 = 1e-3;

/// Of a cluster of lights, what is added to squared distances, in squared radii: above the middle of an even disk its
/// distance to the lights then has about the right mean.
pub const CLUSTER_BLUR: f64 = 0.5;
/// The same of a single light. More than its mean asks for: light that comes from a large solid angle is found by BSDF
/// samples, so light samples do better elsewhere. (Measured on a room with a small lamp under a wide ceiling light:
/// error 4.7e-3 at 0.5, 4.2e-3 at 2, 4.1e-3 at 4 and 8.)
pub const LEAF_BLUR: f64 = 4.0;

/// Up to eight clusters of lights, one column a quantity.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct LightNode {
    /// Centres of bounding boxes, scene units.
    pub center: [[f32; WIDTH]; 3],
    /// Half extents of the boxes, rounded up.
    pub half: [[f32; WIDTH]; 3],
    /// Axes of the cones that hold all normals, times the cosine of the half angle (not below 0).
    pub axis: [[f32; WIDTH]; 3],
    /// Sines of the cones' half angles; 1 for those of a quarter turn and more.
    pub spread: [f32; WIDTH],
    /// How far lights reach to either side of the centre along any normal in the cone, rounded up.
    pub depth: [f32; WIDTH],
    /// What is added to squared distances: [`CLUSTER_BLUR`] or [`LEAF_BLUR`] times the squared radius of the sphere about
    /// the centre that holds the lights.
    pub blur: [f32; WIDTH],
    /// Emitted power, the whole scene's strongest light being 1; 0 in columns not used.
    pub power: [f32; WIDTH],
    /// A node's index, or [`LEAF`] with a light's.
    pub child: [u32; WIDTH],
}

/// A tree over the lights of a scene but for its environment.
#[derive(Clone, Debug)]
pub struct LightTree {
    /// Nodes, the root first.
    pub nodes: Vec<LightNode>,
    /// Per light, the way to it: three bits a level, the root's lowest.
    pub paths: Vec<u64>,
    /// There is something to choose from.
    pub choice: bool,
    /// Importance of the environment, in the unit of the lights': the same everywhere; 0 if there is none.
    pub environment: f32,
    /// Power of the strongest light, summed over the channels, in [`crate::tables::PreparedScene::radiance_unit`]: what powers
    /// of nodes are relative to.
    pub strongest: f32,
}

/// What a cluster covers.
#[derive(Clone, Copy)]
struct Bounds {
    low: DVec3,
    high: DVec3,
    /// Sum of the unit normals of one-sided lights.
    normals: DVec3,
    /// How many sides shine: one or two a primitive.
    sides: f64,
    power: f64,
}

/// A leaf to be.
#[derive(Clone, Copy)]
struct Primitive {
    bounds: Bounds,
    corners: [DVec3; 4],
    child: u32,
}

impl LightTree {
    /// The tree over `emitters` with the given powers (area times radiance times sides, summed over the channels) and `deltas`,
    /// beside an environment of the given mean radiance (summed likewise; 0: none). `None` if nothing is to be chosen: no light
    /// but the environment, or nothing but one triangle, one parallelogram or one delta light, unless that is to have its tree
    /// `always`.
    pub fn new(
        (emitters, triangles): (&[Emitter], &[TriangleRecord]),
        powers: &[f64],
        deltas: &DeltaLights,
        environment: f64,
        always: bool,
    ) -> Option<LightTree> {
        let mut primitives = primitives(emitters, triangles, powers);
        let reach = primitives
            .iter()
            .flat_map(|primitive| primitive.corners)
            .fold(deltas.reach(), |reach: f64, corner| reach.max(corner.abs().max_element()));
        primitives.extend(delta_primitives(deltas, emitters.len()));
        let choice = primitives.len() > 1 || environment > 0.0;
        if primitives.is_empty() || !(choice || always) {
            return None;
        }
        let strongest = primitives.iter().map(|p| p.bounds.power).fold(0.0, f64::max);
        for primitive in &mut primitives {
            // Never so weak that its importance could vanish in f32.
            let relative = if strongest > 0.0 { primitive.bounds.power / strongest } else { 1.0 };
            primitive.bounds.power = relative.max(1e-9);
        }
        // Half of what a hemisphere of it sends, for the reason of `LEAF_BLUR`; within the range of f32.
        let share = if strongest > 0.0 { std::f64::consts::FRAC_PI_2 * environment / strongest } else { 1.0 };
        let environment = if environment > 0.0 { share.clamp(1e-30, 1e30) as f32 } else { 0.0 };
        let mut tree = LightTree {
            nodes: Vec::new(),
            paths: vec![0; emitters.len() + deltas.records.len()],
            choice,
            environment,
            strongest: strongest as f32,
        };
        Builder { tree: &mut tree, slack: reach * 4e-6 }.node(&mut primitives, 0, 0);
        Some(tree)
    }

    /// Bytes of both tables.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.paths[..])
    }
}

/// One primitive a triangle, or a parallelogram of two.
fn primitives(emitters: &[Emitter], triangles: &[TriangleRecord], powers: &[f64]) -> Vec<Primitive> {
    let corners = |i: usize| {
        let vertices = triangles[emitters[i].triangle as usize].vertices;
        vertices.map(|v| DVec3::from_array(v.map(f64::from)))
    };
    let mut list = Vec::with_capacity(emitters.len());
    let mut i = 0;
    while i < emitters.len() {
        let normal = DVec3::from_array(triangles[emitters[i].triangle as usize].normal.map(f64::from));
        let [a, b, c] = corners(i);
        let fourth = (i + 1 < emitters.len() && alike(&emitters[i], &emitters[i + 1]))
            .then(|| parallelogram([a, b, c], corners(i + 1)))
            .flatten();
        let (count, power) = if fourth.is_some() { (2, powers[i] + powers[i + 1]) } else { (1, powers[i]) };
        let corners = [a, b, c, fourth.unwrap_or(a)];
        let bounds = Bounds {
            low: corners.into_iter().reduce(DVec3::min).expect("four corners"),
            high: corners.into_iter().reduce(DVec3::max).expect("four corners"),
            normals: if emitters[i].two_sided { DVec3::ZERO } else { normal },
            sides: if emitters[i].two_sided { 2.0 } else { 1.0 },
            power,
        };
        list.push(Primitive { bounds, corners, child: LEAF | i as u32 | if count == 2 { PAIR } else { 0 } });
        i += count;
    }
    list
}

/// One primitive a delta light; `first` is the number of the first.
fn delta_primitives(deltas: &DeltaLights, first: usize) -> impl Iterator<Item = Primitive> {
    deltas.bounds().enumerate().map(move |(i, light)| {
        let (low, high, normals) = (light.low, light.high, light.normal);
        let sides = if normals == DVec3::ZERO { 2.0 } else { 1.0 };
        let bounds = Bounds { low, high, normals, sides, power: light.power };
        let corners = [low, high, DVec3::new(low.x, high.y, low.z), DVec3::new(high.x, low.y, high.z)];
        Primitive { bounds, corners, child: LEAF | (first + i) as u32 }
    })
}

/// Whether two lights send out the same from every point of them.
fn alike(a: &Emitter, b: &Emitter) -> bool {
    a.radiance == b.radiance && a.two_sided == b.two_sided && a.texture.is_none() && b.texture.is_none()
}

/// The fourth corner if two triangles share an edge and make a parallelogram.
fn parallelogram(first: [DVec3; 3], second: [DVec3; 3]) -> Option<DVec3> {
    let lonely = |of: [DVec3; 3], other: [DVec3; 3]| {
        let mut alone = of.into_iter().filter(|corner| !other.contains(corner));
        alone.next().filter(|_| alone.next().is_none())
    };
    let (a, d) = (lonely(first, second)?, lonely(second, first)?);
    let shared: DVec3 = first.into_iter().filter(|&corner| corner != a).sum();
    let size = (first[0] - first[1]).length() + (first[1] - first[2]).length();
    ((a + d - shared).length() <= 1e-5 * size).then_some(d)
}

impl Bounds {
    fn union(self, other: Bounds) -> Bounds {
        Bounds {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            normals: self.normals + other.normals,
            sides: self.sides + other.sides,
            power: self.power + other.power,
        }
    }

    fn center(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// Power times the surface area orientation measure; `stretch` (longest extent over that of the split axis) keeps
    /// boxes from growing thin. The squared diagonal is for lights in a row, whose box has no area.
    fn cost(&self, stretch: f64) -> f64 {
        let size = self.high - self.low;
        let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x) + 0.1 * size.length_squared();
        // Conty Estevez and Kulla's measure of a cone of normals is pi for one direction, 4 pi for all of them and nearly
        // linear in the angle between. Normals spread over a cone of angle a have a mean of length (1 + cos a) / 2.
        let mean = self.normals.length() / self.sides;
        self.power * stretch * (1.0 + 3.0 * (1.0 - mean).max(0.0).sqrt()) * area
    }
}

struct Builder<'a> {
    tree: &'a mut LightTree,
    /// What radii grow by, so that rounding cannot push a light out of its sphere.
    slack: f64,
}

impl Builder<'_> {
    /// The node over `primitives`, which lies at the end of `path` below `level` others; its index.
    fn node(&mut self, primitives: &mut [Primitive], path: u64, level: u32) -> u32 {
        let index = self.tree.nodes.len();
        // Columns not used lie at the world's origin: seen from there they must weigh 0, not 0 / 0.
        self.tree.nodes.push(LightNode { blur: [1.0; WIDTH], ..LightNode::zeroed() });
        let room = MAX_LEVELS - 1 - level;
        let clusters = clusters(primitives, 8usize.saturating_pow(room));
        let mut rest = primitives;
        for (column, len) in clusters.into_iter().enumerate() {
            let (cluster, others) = rest.split_at_mut(len);
            rest = others;
            let path = path | (column as u64) << (3 * level);
            let child = if let [primitive] = cluster {
                let first = (primitive.child & !(LEAF | PAIR)) as usize;
                let count = 1 + (primitive.child & PAIR != 0) as usize;
                self.tree.paths[first..first + count].fill(path);
                primitive.child
            } else {
                self.node(cluster, path, level + 1)
            };
            self.tree.nodes[index].set(column, cluster, child, self.slack);
        }
        index as u32
    }
}

impl LightNode {
    fn set(&mut self, column: usize, cluster: &[Primitive], child: u32, slack: f64) {
        let bounds = union_of(cluster);
        let center = bounds.center();
        let corners = || cluster.iter().flat_map(|primitive| primitive.corners).map(|corner| corner - center);
        let radius = corners().fold(0.0, |radius: f64, corner| radius.max(corner.length())) + slack;
        let (axis, cos_cone) = cone_of_normals(cluster, bounds.normals);
        let spread = if cos_cone > 0.0 { (1.0 - cos_cone * cos_cone).sqrt() } else { 1.0 };
        let along = corners().fold(0.0, |depth: f64, corner| depth.max(corner.dot(axis).abs())) + slack;
        let half = 0.5 * (bounds.high - bounds.low) + slack;
        for i in 0..3 {
            self.center[i][column] = center[i] as f32;
            self.half[i][column] = half[i] as f32;
            self.axis[i][column] = (axis[i] * cos_cone.max(0.0)) as f32;
        }
        self.spread[column] = spread as f32;
        self.depth[column] = (along + radius * spread) as f32;
        let blur = if cluster.len() == 1 { LEAF_BLUR } else { CLUSTER_BLUR };
        self.blur[column] = (blur * radius * radius) as f32;
        self.power[column] = bounds.power as f32;
        self.child[column] = child;
    }
}

/// A cone about all normals of a cluster, whose sum is `normals`: unit axis, cosine of the half angle (-1: all directions).
fn cone_of_normals(cluster: &[Primitive], normals: DVec3) -> (DVec3, f64) {
    let one_sided = cluster.iter().all(|primitive| primitive.bounds.sides == 1.0);
    let Some(axis) = normals.try_normalize().filter(|_| one_sided) else { return (DVec3::Z, -1.0) };
    let least = cluster.iter().map(|primitive| primitive.bounds.normals.dot(axis)).fold(1.0, f64::min);
    // Rounding must not leave a normal outside.
    (axis, (least - 1e-5).max(-1.0))
}

fn union_of(cluster: &[Primitive]) -> Bounds {
    cluster.iter().map(|primitive| primitive.bounds).reduce(Bounds::union).expect("clusters are not empty")
}

/// Sorts `primitives` into up to eight clusters of at most `most`, one after the other; their lengths. The cluster that
/// costs most is split until there are eight or all are single.
fn clusters(primitives: &mut [Primitive], most: usize) -> Vec<usize> {
    let mut ends = vec![(0, primitives.len(), f64::INFINITY)];
    while ends.len() < WIDTH {
        let splittable = |cluster: &&(usize, usize, f64)| cluster.1 - cluster.0 > 1;
        let Some(worst) = ends.iter().filter(splittable).max_by(|a, b| a.2.total_cmp(&b.2)).copied() else { break };
        let at = ends.iter().position(|cluster| cluster.0 == worst.0).expect("it is in the list");
        let (first, last, _) = worst;
        let middle = first + split(&mut primitives[first..last]);
        let cost = |first: usize, last: usize| (first, last, union_of(&primitives[first..last]).cost(1.0));
        let halves = [cost(first, middle), cost(middle, last)];
        ends.splice(at..at + 1, halves);
    }
    if ends.iter().any(|&(first, last, _)| last - first > most) {
        // Too uneven for the levels that are left: equal shares always fit.
        let share = primitives.len().div_ceil(WIDTH);
        return primitives.chunks(share).map(<[Primitive]>::len).collect();
    }
    ends.into_iter().map(|(first, last, _)| last - first).collect()
}

const BUCKETS: usize = 12;

/// Sorts a cluster of two or more into two at the cheapest of eleven planes an axis; the length of the first.
fn split(cluster: &mut [Primitive]) -> usize {
    let all = union_of(cluster);
    let size = all.high - all.low;
    let centers = || cluster.iter().map(|primitive| primitive.bounds.center());
    let (low, high) = (centers().reduce(DVec3::min), centers().reduce(DVec3::max));
    let (low, extent) = (low.expect("not empty"), high.expect("not empty") - low.expect("not empty"));
    let bucket = |primitive: &Primitive, axis: usize| {
        (((primitive.bounds.center()[axis] - low[axis]) / extent[axis] * BUCKETS as f64) as usize).min(BUCKETS - 1)
    };
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let mut buckets: [Option<Bounds>; BUCKETS] = [None; BUCKETS];
        let join = |a: Option<Bounds>, b: Option<Bounds>| match (a, b) {
            (Some(a), Some(b)) => Some(a.union(b)),
            (a, b) => a.or(b),
        };
        for primitive in cluster.iter() {
            let slot = &mut buckets[bucket(primitive, axis)];
            *slot = join(*slot, Some(primitive.bounds));
        }
        let stretch = size.max_element() / size[axis].max(1e-3 * size.max_element());
        let mut above = [None; BUCKETS];
        for i in (1..BUCKETS).rev() {
            above[i - 1] = join(above[i], buckets[i]);
        }
        let mut below = None;
        for i in 0..BUCKETS - 1 {
            below = join(below, buckets[i]);
            let (Some(below), Some(above)) = (below, above[i]) else { continue };
            let cost = below.cost(stretch) + above.cost(stretch);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, i));
            }
        }
    }
    let Some((_, axis, last)) = best else { return cluster.len() / 2 };
    // A stable partition keeps the file's order, so that trees do not depend on how sorting breaks ties.
    let (first, second): (Vec<Primitive>, Vec<Primitive>) = cluster.iter().partition(|p| bucket(p, axis) <= last);
    let middle = first.len();
    cluster[..middle].copy_from_slice(&first);
    cluster[middle..].copy_from_slice(&second);
    middle
}
