//! Ways to find hits, side by side on the same rays: the engine's choice, one ray at a time, the scalar reference, and as a
//! yardstick obvhs's own traversal of the binary tree from which ours is made.

use crate::bvh::ray::{HitQueue, NO_HIT, RayQueue};
use crate::bvh::{Bvh, RayKind, Scratch, Walk, WalkCounters};
use crate::cli::bench::rays::{RaySet, RayTile};
use crate::clock::thread_cpu_seconds;
use crate::lanes::LANES;
use crate::reference::single::intersect::{Ray, Stack, intersect, occluded, stack};
use crate::reference::single::vec3;
use crate::scene::validate::is_degenerate;
use crate::tables::PreparedScene;
use obvhs::bvh2::Bvh2;
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;

/// What is asked of a ray.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// The closest hit.
    Closest,
    /// Whether there is any.
    Any,
}

impl Question {
    /// Both.
    pub const ALL: [Question; 2] = [Question::Closest, Question::Any];

    /// The word used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Question::Closest => "closest",
            Question::Any => "any",
        }
    }
}

/// obvhs's binary tree and its triangles in the order of the leaves.
pub struct Yardstick {
    tree: Bvh2,
    triangles: Vec<RtTriangle>,
}

impl Yardstick {
    /// The tree of `scene`.
    pub fn new(scene: &PreparedScene) -> Yardstick {
        let records = &scene.triangles;
        let positions: Vec<[f32; 3]> = records.iter().flat_map(|record| record.vertices).collect();
        let corners: Vec<[u32; 3]> = (0..records.len() as u32).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let tree = Bvh::source_tree(&positions, &corners, |id| !is_degenerate(records[id as usize].vertices));
        let triangle = |&id: &u32| {
            let [v0, v1, v2] = records[id as usize].vertices.map(glam::Vec3A::from);
            RtTriangle::new(v0, v1, v2)
        };
        let triangles = tree.primitive_indices.iter().map(triangle).collect();
        Yardstick { tree, triangles }
    }
}

/// A way to find hits.
pub enum Finder<'a> {
    /// The engine's: the walk that suits the kind of rays.
    Engine(&'a Bvh, Scratch),
    /// The engine's tree, one ray after the other.
    OneRay(&'a Bvh, Scratch),
    /// The scalar reference.
    Scalar(&'a Bvh, Stack),
    /// obvhs.
    Obvhs(&'a Yardstick),
}

/// All answers to one question about one set of rays.
pub struct Answers {
    /// Closest hits, tile by tile (empty for any-hit).
    hits: Vec<HitQueue>,
    /// Blocked rays, a bit each, tile by tile (empty for closest hits).
    blocked: Vec<Vec<u8>>,
}

impl<'a> Finder<'a> {
    /// All of them, the engine's choice first.
    pub fn all(bvh: &'a Bvh, yardstick: &'a Yardstick) -> [Finder<'a>; 4] {
        [
            Finder::Engine(bvh, Scratch::default()),
            Finder::OneRay(bvh, Scratch::default()),
            Finder::Scalar(bvh, stack(bvh)),
            Finder::Obvhs(yardstick),
        ]
    }

    /// The name in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Finder::Engine(..) => "packet",
            Finder::OneRay(..) => "one ray",
            Finder::Scalar(..) => "scalar",
            Finder::Obvhs(_) => "obvhs",
        }
    }

    /// Whether answers must be those of the other finders to the last bit. obvhs tests triangles by another formula, which
    /// leaks at edges.
    pub fn is_exact(&self) -> bool {
        !matches!(self, Finder::Obvhs(_))
    }

    /// How the tree is walked, where there is a choice: the first one, and what rays that part soon are left to.
    pub fn walk(&self, set: &RaySet) -> Option<String> {
        let Finder::Engine(bvh, _) = self else { return None };
        let word = |kind: RayKind| match bvh.first_choice(kind) {
            Walk::Single => "one ray",
            Walk::Packet => "packet",
            Walk::Stream => "stream",
            Walk::Flat => "list",
        };
        let (first, scattered) = (word(set.kind), word(RayKind::Bounce));
        Some(if first == scattered { first.to_owned() } else { format!("{first}, else {scattered}") })
    }

    /// Answers `question` about every ray of `set`; CPU seconds of this thread and what packet walks counted.
    pub fn run(&mut self, set: &RaySet, question: Question, answers: &mut Answers) -> (f64, WalkCounters) {
        let mut counters = WalkCounters::default();
        let start = thread_cpu_seconds();
        for (index, tile) in set.tiles.iter().enumerate() {
            match question {
                Question::Closest => self.closest(set, tile, &mut answers.hits[index], &mut counters),
                Question::Any => self.any(set, tile, &mut answers.blocked[index], &mut counters),
            }
        }
        (thread_cpu_seconds() - start, counters)
    }

    fn closest(&mut self, set: &RaySet, tile: &RayTile, hits: &mut HitQueue, counters: &mut WalkCounters) {
        let (rays, range) = (&tile.rays, 0..tile.count);
        match self {
            Finder::Engine(bvh, scratch) => bvh.intersect_queue(set.kind, rays, range, hits, scratch, counters),
            Finder::OneRay(bvh, scratch) => bvh.intersect_by(Walk::Single, rays, range, hits, scratch, counters),
            Finder::Scalar(bvh, stack) => {
                for row in range {
                    let ray = scalar_ray(rays, row);
                    let hit = intersect(bvh, &ray, stack);
                    let (t, id, u, v) = hit.map_or((ray.tmax, NO_HIT, 0.0, 0.0), |h| (h.t, h.triangle, h.u, h.v));
                    (hits.t[row], hits.triangle[row], hits.u[row], hits.v[row]) = (t, id, u, v);
                }
            }
            Finder::Obvhs(Yardstick { tree, triangles }) => {
                for row in range {
                    let mut hit = RayHit::none();
                    tree.ray_traverse(obvhs_ray(rays, row), &mut hit, |ray, at| triangles[at].intersect(ray));
                    let id = tree.primitive_indices.get(hit.primitive_id as usize).copied();
                    (hits.t[row], hits.triangle[row]) = (hit.t, id.unwrap_or(NO_HIT));
                }
            }
        }
    }

    fn any(&mut self, set: &RaySet, tile: &RayTile, blocked: &mut Vec<u8>, counters: &mut WalkCounters) {
        let (rays, range) = (&tile.rays, 0..tile.count);
        let mut each = |is_blocked: &mut dyn FnMut(usize) -> bool| {
            for (block, bits) in blocked.iter_mut().enumerate() {
                let rows = block * LANES..((block + 1) * LANES).min(tile.count);
                *bits = rows.enumerate().fold(0, |bits, (lane, row)| bits | (is_blocked(row) as u8) << lane);
            }
        };
        match self {
            Finder::Engine(bvh, scratch) => bvh.occluded_queue(set.kind, rays, range, blocked, scratch, counters),
            Finder::OneRay(bvh, scratch) => bvh.occluded_by(Walk::Single, rays, range, blocked, scratch, counters),
            Finder::Scalar(bvh, stack) => each(&mut |row| occluded(bvh, &scalar_ray(rays, row), stack)),
            Finder::Obvhs(Yardstick { tree, triangles }) => {
                each(&mut |row| !tree.ray_traverse_miss(obvhs_ray(rays, row), |ray, at| triangles[at].intersect(ray)));
            }
        }
    }
}

fn scalar_ray(rays: &RayQueue, row: usize) -> Ray {
    Ray {
        origin: vec3([rays.ox[row], rays.oy[row], rays.oz[row]]),
        direction: vec3([rays.dx[row], rays.dy[row], rays.dz[row]]),
        tmin: rays.tmin[row],
        tmax: rays.tmax[row],
    }
}

fn obvhs_ray(rays: &RayQueue, row: usize) -> obvhs::ray::Ray {
    let origin = glam::Vec3A::new(rays.ox[row], rays.oy[row], rays.oz[row]);
    let direction = glam::Vec3A::new(rays.dx[row], rays.dy[row], rays.dz[row]);
    obvhs::ray::Ray::new(origin, direction, rays.tmin[row], rays.tmax[row])
}

impl Answers {
    /// Room for the answers to `question` about `set`.
    pub fn new(set: &RaySet, question: Question) -> Answers {
        let (mut hits, mut blocked) = (Vec::new(), Vec::new());
        match question {
            Question::Closest => hits = set.tiles.iter().map(|tile| HitQueue::with_len(tile.count)).collect(),
            Question::Any => blocked = set.tiles.iter().map(|tile| vec![0; tile.count.div_ceil(LANES)]).collect(),
        }
        Answers { hits, blocked }
    }

    /// Per ray of `set`, in order: whether it hits, and the bits of the hit.
    fn rows<'b>(&'b self, set: &'b RaySet) -> impl Iterator<Item = (bool, [u32; 4])> + 'b {
        let closest = self.hits.iter().zip(&set.tiles).flat_map(|(hits, tile)| {
            (0..tile.count).map(|row| {
                let [t, u, v] = [&hits.t, &hits.u, &hits.v].map(|column| column[row].to_bits());
                (hits.triangle[row] != NO_HIT, [hits.triangle[row], t, u, v])
            })
        });
        let any = self.blocked.iter().zip(&set.tiles).flat_map(|(blocked, tile)| {
            (0..tile.count).map(|row| (blocked[row / LANES] >> (row % LANES) & 1 == 1, [0; 4]))
        });
        closest.chain(any)
    }

    /// How many rays hit.
    pub fn hits(&self, set: &RaySet) -> usize {
        self.rows(set).filter(|row| row.0).count()
    }

    /// Sums of the ids of the triangles hit and of the distances, where closest hits were asked for.
    pub fn sums(&self, set: &RaySet) -> Option<(u64, f64)> {
        let [_, ..] = self.hits[..] else { return None };
        let hits = self.rows(set).filter(|row| row.0).map(|row| row.1);
        Some(hits.fold((0, 0.0), |(ids, ts), [id, t, ..]| (ids + u64::from(id), ts + f64::from(f32::from_bits(t)))))
    }

    /// How many rays are answered otherwise by `other`: with `exact`, to the last bit, else hit or not.
    pub fn differences(&self, other: &Answers, set: &RaySet, exact: bool) -> usize {
        let pairs = self.rows(set).zip(other.rows(set));
        pairs.filter(|(a, b)| a.0 != b.0 || exact && a.1 != b.1).count()
    }
}
