//! Mrays/s of every walk by kind of ray, one thread, with obvhs's own one-ray traversal of the same binary tree beside it.
//!
//! `cargo bench --bench traversal` times a room of 36 triangles and one of 1.2 million. A name of a benchmark is
//! `scene/rays/closest or any/walk`, "as chosen" being what the engine calls; throughput is in rays. obvhs tests triangles after Moeller and Trumbore with another
//! rule on edges, so its hits differ in the last bits: it is a yardstick of speed alone.

mod rays;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3A;
use obvhs::bvh2::Bvh2;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use octray::internal::bvh::{Bvh, HitQueue, RayKind, Scratch, Walk, WalkCounters};
use rays::{Mesh, RaySet, ray_sets, room, spheres};
use std::hint::black_box;
use std::time::Duration;

/// Rays that are asked about at once, as many as a tile of the engine has.
const QUEUE: usize = 4096;

/// obvhs's binary tree and its triangles in the order of the leaves.
struct Yardstick {
    tree: Bvh2,
    triangles: Vec<Triangle>,
}

impl Yardstick {
    fn new(mesh: &Mesh) -> Self {
        let tree = Bvh::source_tree(&mesh.positions, &mesh.triangles, |_| true);
        let triangle = |&id: &u32| {
            let [v0, v1, v2] = mesh.triangles[id as usize].map(|v| Vec3A::from(mesh.positions[v as usize]));
            Triangle { v0, v1, v2 }
        };
        let triangles = tree.primitive_indices.iter().map(triangle).collect();
        Self { tree, triangles }
    }

    fn ray(set: &RaySet, row: usize) -> Ray {
        let rays = &set.rays;
        let origin = Vec3A::new(rays.ox[row], rays.oy[row], rays.oz[row]);
        let direction = Vec3A::new(rays.dx[row], rays.dy[row], rays.dz[row]);
        Ray::new(origin, direction, 0.0, rays.tmax[row])
    }

    fn closest(&self, set: &RaySet) -> f32 {
        let mut sum = 0.0;
        for row in 0..set.count {
            let mut hit = RayHit::none();
            self.tree.ray_traverse(Self::ray(set, row), &mut hit, |ray, id| self.triangles[id].intersect(ray));
            sum += hit.t;
        }
        sum
    }

    fn any(&self, set: &RaySet) -> usize {
        let misses = |&row: &usize| {
            self.tree.ray_traverse_miss(Self::ray(set, row), |ray, id| self.triangles[id].intersect(ray))
        };
        (0..set.count).filter(misses).count()
    }
}

fn kind(set: &RaySet) -> RayKind {
    match set.name {
        "camera" => RayKind::Camera,
        "shadow" => RayKind::Shadow,
        _ => RayKind::Bounce,
    }
}

fn ranges(set: &RaySet) -> impl Iterator<Item = std::ops::Range<usize>> {
    let count = set.count;
    (0..count).step_by(QUEUE).map(move |first| first..(first + QUEUE).min(count))
}

fn scene(criterion: &mut Criterion, name: &str, mesh: &Mesh, size: usize) {
    let bvh = Bvh::build(&mesh.positions, &mesh.triangles, |_| true);
    let yardstick = Yardstick::new(mesh);
    let (mut scratch, mut counters) = (Scratch::default(), WalkCounters::default());
    for set in ray_sets(mesh, &bvh, size) {
        let (mut hits, mut blocked) = (HitQueue::with_len(set.count), vec![0; set.count / 8 + 1]);
        let walks = [Walk::Single, Walk::Packet, Walk::Stream, Walk::Flat];
        let walks = walks.into_iter().filter(|walk| bvh.walks().contains(walk));

        let mut group = criterion.benchmark_group(format!("{name}/{}/closest", set.name));
        group.throughput(Throughput::Elements(set.count as u64));
        group.bench_function("obvhs", |b| b.iter(|| black_box(yardstick.closest(&set))));
        group.bench_function("as chosen", |b| {
            b.iter(|| {
                for range in ranges(&set) {
                    bvh.intersect_queue(kind(&set), &set.rays, range, &mut hits, &mut scratch, &mut counters);
                }
                black_box(&hits);
            })
        });
        for walk in walks.clone() {
            group.bench_function(format!("{walk:?}"), |b| {
                b.iter(|| {
                    for range in ranges(&set) {
                        bvh.intersect_by(walk, &set.rays, range, &mut hits, &mut scratch, &mut counters);
                    }
                    black_box(&hits);
                })
            });
        }
        group.finish();

        let mut group = criterion.benchmark_group(format!("{name}/{}/any", set.name));
        group.throughput(Throughput::Elements(set.count as u64));
        group.bench_function("obvhs", |b| b.iter(|| black_box(yardstick.any(&set))));
        group.bench_function("as chosen", |b| {
            b.iter(|| {
                for range in ranges(&set) {
                    bvh.occluded_queue(kind(&set), &set.rays, range, &mut blocked, &mut scratch, &mut counters);
                }
                black_box(&blocked);
            })
        });
        for walk in walks {
            group.bench_function(format!("{walk:?}"), |b| {
                b.iter(|| {
                    for range in ranges(&set) {
                        bvh.occluded_by(walk, &set.rays, range, &mut blocked, &mut scratch, &mut counters);
                    }
                    black_box(&blocked);
                })
            });
        }
        group.finish();
    }
}

fn traversal(criterion: &mut Criterion) {
    scene(criterion, "room of 36", &room(), 128);
    scene(criterion, "spheres of 1.2 M", &spheres(60), 256);
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(400));
    targets = traversal
}
criterion_main!(benches);
