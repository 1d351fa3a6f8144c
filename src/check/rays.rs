//! Rays put to every walk through a tree, and to the reference in f32 and f64.

use crate::bvh::ray::{HitQueue, NO_HIT, RayQueue, WalkCounters};
use crate::bvh::{Scratch, Walk};
use crate::reference::{double, single};
use crate::tables::PreparedScene;
use glam::{DVec3, Vec3};

/// Rays of a check.
#[derive(Default)]
pub struct Rays {
    queue: RayQueue,
    count: usize,
}

/// A closest hit in f64.
pub type Truth = Option<double::intersect::Hit>;

impl Rays {
    /// One more ray, without end.
    pub fn push(&mut self, origin: Vec3, direction: Vec3) {
        let row = self.count;
        self.count += 1;
        self.queue.resize(self.count);
        (self.queue.ox[row], self.queue.oy[row], self.queue.oz[row]) = origin.into();
        (self.queue.dx[row], self.queue.dy[row], self.queue.dz[row]) = direction.into();
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Origin and direction of one.
    pub fn ray(&self, row: usize) -> (Vec3, Vec3) {
        let queue = &self.queue;
        let origin = Vec3::new(queue.ox[row], queue.oy[row], queue.oz[row]);
        (origin, Vec3::new(queue.dx[row], queue.dy[row], queue.dz[row]))
    }

    /// The closest hits by one walk.
    pub fn hits(&self, scene: &PreparedScene, walk: Walk) -> HitQueue {
        let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
        let mut hits = HitQueue::with_len(self.count);
        scene.bvh.intersect_by(walk, &self.queue, 0..self.count, &mut hits, &mut scratch, &mut counters);
        hits
    }

    /// Which of them hit anything, by one walk.
    pub fn blocked(&self, scene: &PreparedScene, walk: Walk) -> Vec<bool> {
        let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
        let mut blocked = Vec::new();
        scene.bvh.occluded_by(walk, &self.queue, 0..self.count, &mut blocked, &mut scratch, &mut counters);
        (0..self.count).map(|row| blocked[row / 8] >> (row % 8) & 1 == 1).collect()
    }

    /// The closest hits by the reference.
    pub fn reference(&self, scene: &PreparedScene) -> Vec<Option<single::intersect::Hit>> {
        let mut stack = single::intersect::stack(&scene.bvh);
        let of = |row| {
            let (origin, direction) = self.ray(row);
            let ray = single::intersect::Ray { origin, direction, tmin: 0.0, tmax: f32::INFINITY };
            single::intersect::intersect(&scene.bvh, &ray, &mut stack)
        };
        (0..self.count).map(of).collect()
    }

    /// The closest hits by the reference in f64, from the same f32 rays and vertices.
    pub fn truth(&self, scene: &PreparedScene) -> Vec<Truth> {
        let mut stack = double::intersect::stack(&scene.bvh);
        let of = |row| {
            let (origin, direction) = self.ray(row);
            let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
            let ray = double::intersect::Ray { origin, direction, tmin: 0.0, tmax: f64::INFINITY };
            double::intersect::intersect(&scene.bvh, &ray, &mut stack)
        };
        (0..self.count).map(of).collect()
    }

    /// How many rays have other bits in some walk than in `reference`, and the first of them in words.
    pub fn differing(&self, scene: &PreparedScene, reference: &[Option<single::intersect::Hit>]) -> (u64, String) {
        let mut differs = vec![false; self.count];
        let mut first = String::new();
        for walk in scene.bvh.walks() {
            let hits = self.hits(scene, walk);
            for (row, wanted) in reference.iter().enumerate() {
                let got = (hits.triangle[row], hits.t[row].to_bits(), hits.u[row].to_bits(), hits.v[row].to_bits());
                let same = match wanted {
                    Some(hit) => got == (hit.triangle, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()),
                    None => got.0 == NO_HIT,
                };
                if !same && first.is_empty() {
                    let (origin, direction) = self.ray(row);
                    first = format!(
                        "{walk:?} finds triangle {} at {:e}, the reference {:?} for {origin:?} towards {direction:?}",
                        hits.triangle[row],
                        hits.t[row],
                        wanted.map(|hit| (hit.triangle, hit.t))
                    );
                }
                differs[row] |= !same;
            }
        }
        (differs.iter().filter(|differs| **differs).count() as u64, first)
    }
}

/// A point in f32.
pub fn narrow(v: DVec3) -> Vec3 {
    v.as_vec3()
}
