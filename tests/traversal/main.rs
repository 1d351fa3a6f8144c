//! Every walk against brute force, bit for bit.

mod levels;
mod scenes;
mod tree;

use levels::{levels, ways};
use octray::internal::bvh::ray::NO_HIT;
use octray::internal::bvh::{
    BuildOptions, Bvh, HitQueue, RayKind, RayPacket, RayQueue, Scratch, Segments, WalkCounters,
};
use octray::internal::lanes::{F32x8, Mask8, Vec3x8};
use scenes::{Hit, Random, Ray, Scene, corridor, cube, heightfield, hit_triangle, rays, room, slivers, soup, sphere};
use std::time::{Duration, Instant};

fn queue(rays: &[Ray]) -> RayQueue {
    let mut queue = RayQueue::with_len(rays.len());
    for (i, ray) in rays.iter().enumerate() {
        ([queue.ox[i], queue.oy[i], queue.oz[i]], [queue.dx[i], queue.dy[i], queue.dz[i]]) = (ray.o, ray.d);
        (queue.tmin[i], queue.tmax[i]) = (ray.tmin, ray.tmax);
    }
    queue
}

fn row(hits: &HitQueue, i: usize) -> Hit {
    (hits.t[i], hits.triangle[i], hits.u[i], hits.v[i])
}

fn bits(hit: Hit) -> (u32, u32, u32, u32) {
    (hit.0.to_bits(), hit.1, hit.2.to_bits(), hit.3.to_bits())
}

/// Every walk, queue and stream call, closest and any hit, must say what `expected` says.
fn check_walks(name: &str, bvh: &Bvh, rays: &[Ray], expected: &[Hit]) {
    let queue = queue(rays);
    let mut counters = WalkCounters::default();
    let mut answers: Vec<(String, HitQueue, Vec<u8>)> = vec![];
    for level in levels() {
        let mut scratch = Scratch::at(level);
        for walk in bvh.walks() {
            let (mut hits, mut blocked) = (HitQueue::with_len(rays.len()), vec![]);
            bvh.intersect_by(walk, &queue, 0..rays.len(), &mut hits, &mut scratch, &mut counters);
            bvh.occluded_by(walk, &queue, 0..rays.len(), &mut blocked, &mut scratch, &mut counters);
            answers.push((format!("{walk:?}, {level}"), hits, blocked));
        }
        for kind in [RayKind::Camera, RayKind::Shadow, RayKind::Bounce] {
            let (mut hits, mut blocked) = (HitQueue::with_len(rays.len()), vec![]);
            bvh.intersect_queue(kind, &queue, 0..rays.len(), &mut hits, &mut scratch, &mut counters);
            bvh.occluded_queue(kind, &queue, 0..rays.len(), &mut blocked, &mut scratch, &mut counters);
            answers.push((format!("{kind:?}, {level}"), hits, blocked));
        }
    }
    let (mut hits, mut blocked) = (HitQueue::default(), vec![]);
    bvh.intersect_stream(&queue, rays.len(), &mut hits);
    bvh.occluded_stream(&queue, rays.len(), &mut blocked);
    answers.push(("stream call".into(), hits, blocked));
    for (walk, hits, blocked) in &answers {
        let mut wrong = 0;
        for (i, &hit) in expected.iter().enumerate() {
            if bits(row(hits, i)) != bits(hit) || (blocked[i / 8] >> (i % 8) & 1 == 1) != (hit.1 != NO_HIT) {
                wrong += 1;
                if wrong <= 3 {
                    let blocked = blocked[i / 8] >> (i % 8) & 1;
                    let Ray { o, d, tmin, tmax } = rays[i];
                    eprintln!("{name}, {walk}: ray {i} {o:?} {d:?} {tmin} {tmax}");
                    eprintln!("  says {:?}, blocked {blocked}; truth {hit:?}", row(hits, i));
                }
            }
        }
        assert_eq!(wrong, 0, "{name}, {walk}: wrong rays of {}", rays.len());
    }
}

fn check(scene: &Scene, count: usize) {
    let bvh = scene.bvh();
    let rays = rays(scene, count, 77);
    let expected: Vec<Hit> = rays.iter().map(|ray| scene.brute_force(&bvh, ray)).collect();
    check_walks(&scene.name, &bvh, &rays, &expected);
}

#[test]
fn small_scenes_of_every_size() {
    for count in 0..=20 {
        check(&soup(count, 0.5, count as u64), 400);
    }
    for count in [31, 32, 33, 63, 64, 65, 100, 127, 128, 129, 200, 255, 256, 257] {
        check(&soup(count, 0.3, count as u64), 800);
    }
    check(&room(), 20_000);
}

#[test]
fn soups() {
    check(&soup(2_000, 0.1, 1), 6_000);
    check(&soup(300, 2.0, 2), 6_000);
    check(&soup(5_000, 0.02, 3), 3_000);
}

#[test]
fn grids_and_closed_meshes() {
    check(&cube(1), 20_000);
    check(&cube(4), 20_000);
    check(&cube(12), 8_000);
    check(&heightfield(40), 6_000);
    check(&sphere(30, 40), 8_000);
}

/// Whether and where a ray hits a triangle is a matter of the two alone, however thin the triangle is.
#[test]
fn slivers_and_corridors() {
    for most in [2, 4, 8] {
        for count in [3, 40, 700, 3000] {
            check(&slivers(count, most, 5), if count > 1000 { 1_000 } else { 8_000 });
        }
    }
    for length in [1e2, 1e3, 1e4, 1e6] {
        for angle in [0.0, 0.3] {
            check(&corridor([1.0, 1.0, length], angle), 20_000);
            check(&corridor([length, 1.0, 1.0], angle), 20_000);
        }
    }
    check(&corridor([1.0, 1e-6, 1.0], 0.0), 20_000);
}

/// A ray that ends where it hits the triangle it aims at is blocked by what comes before that in the order of closest hits,
/// and by nothing else.
#[test]
fn aimed_rays_are_blocked_by_what_comes_first() {
    for scene in [soup(40, 1.0, 3), cube(2), room(), slivers(300, 6, 2), corridor([1.0, 1.0, 1e4], 0.3)] {
        let bvh = scene.bvh();
        let mut list = vec![];
        let (mut before, mut expected) = (vec![], vec![]);
        for ray in rays(&scene, 3_000, 5) {
            let ray = Ray { tmax: f32::INFINITY, ..ray };
            let hits: Vec<(f32, u32)> = (0..scene.triangles.len() as u32)
                .filter_map(|id| Some((hit_triangle(&ray, scene.corners(id as usize), bvh.class(id))?.0, id)))
                .collect();
            // Aimed at the closest, at the farthest, and at one that is missed but for the end of the ray.
            let order = |a: &&(f32, u32), b: &&(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
            for &(t, id) in hits.iter().min_by(order).into_iter().chain(hits.iter().max_by(order)) {
                for id in [id, id + 1] {
                    list.push(Ray { tmax: t, ..ray });
                    before.push(id);
                    expected.push(hits.iter().any(|&(other, o)| other < t || (other == t && o < id)));
                }
            }
        }
        let queue = queue(&list);
        before.resize(queue.len() + 8, 0);
        let mut counters = WalkCounters::default();
        for (walk, mut scratch) in ways(&bvh) {
            let (mut blocked, aimed) = (vec![], Segments::aimed(&queue, &before));
            bvh.occluded_by(walk, aimed, 0..list.len(), &mut blocked, &mut scratch, &mut counters);
            let wrong = (0..list.len()).filter(|&i| (blocked[i / 8] >> (i % 8) & 1 == 1) != expected[i]).count();
            assert_eq!(wrong, 0, "{}, {walk:?}: wrong rays of {}", scene.name, list.len());
        }
        assert!(expected.iter().filter(|&&blocked| blocked).count() > 100, "{}", scene.name);
        assert!(expected.iter().filter(|&&blocked| !blocked).count() > 100, "{}", scene.name);
    }
}

#[test]
fn huge_tiny_and_far_scenes() {
    for scene in [room(), sphere(16, 20), soup(500, 0.1, 4)] {
        for scale in [1e6f32, 1e-6, 3.7e4, 1e-3] {
            check(&scene.transformed(&format!("{} x {scale}", scene.name), |p| p.map(|x| x * scale)), 4_000);
        }
        for far in [1e2f32, 2e3, 1e5] {
            let name = format!("{} at {far}", scene.name);
            check(&scene.transformed(&name, |p| [p[0] + far, p[1] - 0.5 * far, p[2] + 0.1 * far]), 4_000);
        }
    }
}

#[test]
fn degenerate_trees() {
    let mut copies = soup(1, 0.5, 5);
    copies.triangles = vec![copies.triangles[0]; 300];
    copies.name = "300 copies".into();
    check(&copies, 2_000);
    // All in a line, along an axis and not; the second one thinner and thinner.
    for direction in [[1.0f32, 0.0, 0.0], [0.3, 0.5, -0.8]] {
        let mut line = Scene::new("line", vec![], vec![]);
        for i in 0..500u32 {
            let at = |s: f32| direction.map(|x| x * s);
            let s = i as f32 * 0.01;
            // Not all in one plane: see the limit in `src/bvh/walks/triangle.rs`.
            let turn = [(i as f32).sin(), (i as f32).cos(), (2.0 * i as f32).sin()];
            line.positions.extend([at(s), at(s + 0.01), [0, 1, 2].map(|k| at(s)[k] + 0.05 * turn[k])]);
            line.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        check(&line, 2_000);
    }
    // Sizes growing from 2^-8 to 2^8: splits peel off a few triangles at a time.
    let mut spiral = Scene::new("spiral", vec![], vec![]);
    for i in 0..100u32 {
        let s = 2f32.powf(i as f32 * 0.16 - 8.0);
        spiral.positions.extend([[s, 0.0, 0.0], [0.0, s, 0.0], [s, s, s]]);
        spiral.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    check(&spiral, 2_000);
    // No triangle has an area.
    let mut flat = soup(50, 0.5, 6);
    for triangle in &mut flat.triangles {
        triangle[2] = triangle[1];
    }
    flat.name = "no area".into();
    check(&flat, 500);
}

#[test]
fn coincident_triangles_build_fast_and_shallow() {
    let mut scene = soup(1, 0.5, 5);
    scene.triangles = vec![scene.triangles[0]; 100_000];
    let start = Instant::now();
    let bvh = Bvh::build(&scene.positions, &scene.triangles, |_| true);
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    bvh.validate().unwrap();
    assert!(bvh.depth() < 30, "depth {}", bvh.depth());
    let c = scene.corners(0);
    let centre = [0, 1, 2].map(|k| (c[0][k] + c[1][k] + c[2][k]) / 3.0);
    let ray = Ray { o: [centre[0], centre[1], 5.0], d: [0.0, 0.0, -1.0], tmin: 0.0, tmax: f32::INFINITY };
    let (t, u, v) = hit_triangle(&ray, c, 0).unwrap();
    check_walks("1e5 copies", &bvh, &[ray], &[(t, 0, u, v)]);
}

#[test]
fn triangles_left_out_are_never_hit_and_ids_stay() {
    let scene = soup(600, 0.3, 8);
    let include = |id: u32| !id.is_multiple_of(3);
    let bvh = Bvh::build(&scene.positions, &scene.triangles, include);
    bvh.validate().unwrap();
    assert_eq!(bvh.triangle_count(), 400);
    let mut without = soup(600, 0.3, 8);
    for id in (0..600).step_by(3) {
        // A triangle at one point is never hit.
        without.triangles[id] = [0; 3];
    }
    let rays = rays(&scene, 4_000, 3);
    let expected: Vec<Hit> = rays.iter().map(|ray| without.brute_force(&bvh, ray)).collect();
    check_walks("left out", &bvh, &rays, &expected);
}

#[test]
fn every_leaf_size_gives_the_same_bits() {
    let scene = sphere(12, 16);
    let rays = rays(&scene, 2_000, 4);
    let expected: Vec<Hit> = rays.iter().map(|ray| scene.brute_force(&scene.bvh(), ray)).collect();
    for leaf_size in 1..=8 {
        let bvh = Bvh::build_with(&scene.positions, &scene.triangles, |_| true, BuildOptions { leaf_size, threads: 1 });
        bvh.validate().unwrap();
        check_walks(&format!("leaves of {leaf_size}"), &bvh, &rays, &expected);
    }
}

#[test]
fn nothing_leaks_out_of_closed_meshes() {
    for scene in [sphere(60, 80), cube(20)] {
        let bvh = scene.bvh();
        let mut random = Random(11);
        let mut list = vec![];
        for _ in 0..40_000 {
            let p = random.point();
            let o = p.map(|x| x * 0.3);
            let c = scene.corners(random.below(scene.triangles.len()));
            let s = [0.0, 0.5, 1.0 / 3.0, random.unit()][random.below(4)];
            let target = [0, 1, 2].map(|k| c[0][k] + s * (c[1][k] - c[0][k]));
            list.push(Ray { o, d: [0, 1, 2].map(|k| target[k] - o[k]), tmin: 0.0, tmax: f32::INFINITY });
        }
        let queue = queue(&list);
        let mut first: Option<HitQueue> = None;
        for (walk, mut scratch) in ways(&bvh) {
            let (mut hits, mut blocked) = (HitQueue::with_len(list.len()), vec![]);
            let mut counters = WalkCounters::default();
            bvh.intersect_by(walk, &queue, 0..list.len(), &mut hits, &mut scratch, &mut counters);
            bvh.occluded_by(walk, &queue, 0..list.len(), &mut blocked, &mut scratch, &mut counters);
            for i in 0..list.len() {
                assert_ne!(hits.triangle[i], NO_HIT, "{}: {walk:?} leaks {:?} {:?}", scene.name, list[i].o, list[i].d);
                assert_eq!(blocked[i / 8] >> (i % 8) & 1, 1, "{}: {walk:?} leaks", scene.name);
                if let Some(first) = &first {
                    assert_eq!(bits(row(&hits, i)), bits(row(first, i)), "{}: {walk:?}, ray {i}", scene.name);
                }
            }
            first = Some(hits);
        }
    }
}

fn packet(rays: &[Ray]) -> RayPacket {
    RayPacket::load(&queue(rays), 0)
}

#[test]
fn all_masks_with_poisoned_idle_lanes() {
    for scene in [room(), soup(500, 0.2, 12)] {
        let bvh = scene.bvh();
        let list = rays(&scene, 8 * 256, 13);
        for (mask, eight) in list.chunks(8).enumerate() {
            let active = Mask8::from_bits(mask as u8);
            let whole = packet(eight);
            let expected: Vec<Hit> = eight.iter().map(|ray| scene.brute_force(&bvh, ray)).collect();
            for poison in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, 1e38] {
                let dirty = |v: F32x8| active.select(v, F32x8::splat(poison));
                let dirty3 = |v: Vec3x8| Vec3x8::new(dirty(v.x), dirty(v.y), dirty(v.z));
                let rays = RayPacket {
                    origin: dirty3(whole.origin),
                    direction: dirty3(whole.direction),
                    tmin: dirty(whole.tmin),
                    tmax: dirty(whole.tmax),
                };
                let hits = bvh.intersect(&rays, active);
                let blocked = bvh.occluded(&rays, active).bits();
                let (t, id, u, v) = (hits.t.to_array(), hits.triangle.to_array(), hits.u.to_array(), hits.v.to_array());
                for lane in 0..8 {
                    let got = (t[lane], id[lane], u[lane], v[lane]);
                    if mask >> lane & 1 == 1 {
                        assert_eq!(bits(got), bits(expected[lane]), "{} mask {mask:08b} lane {lane}", scene.name);
                        assert_eq!(blocked >> lane & 1 == 1, got.1 != NO_HIT);
                    } else {
                        assert_eq!((id[lane], u[lane], v[lane]), (NO_HIT, 0.0, 0.0), "mask {mask:08b} lane {lane}");
                        assert_eq!(t[lane].to_bits(), poison.to_bits());
                        assert_eq!(blocked >> lane & 1, 0);
                    }
                }
            }
        }
    }
}

#[test]
fn rays_of_nonsense_end_and_spoil_no_neighbour() {
    let values = [0.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-45];
    let mut random = Random(14);
    for scene in [room(), soup(3_000, 0.1, 15), soup(0, 1.0, 0)] {
        let bvh = scene.bvh();
        let mut list = rays(&scene, 4_000, 18);
        let good: Vec<bool> = list.iter().map(|_| random.below(2) == 0).collect();
        for (ray, _) in list.iter_mut().zip(&good).filter(|(_, good)| !**good) {
            let mut pick = || if random.below(2) == 0 { values[random.below(8)] } else { random.unit() };
            *ray = Ray { o: [pick(), pick(), pick()], d: [pick(), pick(), pick()], tmin: pick(), tmax: pick() };
        }
        let queue = queue(&list);
        let expected: Vec<Hit> = list.iter().map(|ray| scene.brute_force(&bvh, ray)).collect();
        for (walk, mut scratch) in ways(&bvh) {
            let (mut hits, mut blocked) = (HitQueue::with_len(list.len()), vec![]);
            let mut counters = WalkCounters::default();
            bvh.intersect_by(walk, &queue, 0..list.len(), &mut hits, &mut scratch, &mut counters);
            bvh.occluded_by(walk, &queue, 0..list.len(), &mut blocked, &mut scratch, &mut counters);
            for (i, ray) in list.iter().enumerate() {
                let numbers = ray.o.iter().chain(&ray.d).all(|x| x.is_finite())
                    && ![ray.tmin, ray.tmax].iter().any(|x| x.is_nan());
                if good[i] {
                    assert_eq!(bits(row(&hits, i)), bits(expected[i]), "{} {walk:?} ray {i}", scene.name);
                } else if !numbers {
                    assert_eq!((hits.triangle[i], hits.t[i].to_bits()), (NO_HIT, ray.tmax.to_bits()), "{walk:?}");
                    assert_eq!(blocked[i / 8] >> (i % 8) & 1, 0, "{walk:?}");
                }
            }
        }
    }
}

#[test]
fn real_meshes() {
    for file in ["cornell/CornellBox-Original.obj", "meshes/suzanne.obj", "meshes/teapot.obj"] {
        let path = std::path::Path::new("../shared/scenes/obj").join(file);
        let Ok(text) = std::fs::read_to_string(&path) else {
            eprintln!("skipped: {} is not there", path.display());
            continue;
        };
        let mut scene = Scene::new(file, vec![], vec![]);
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            if words.first() == Some(&"v") {
                scene.positions.push([1, 2, 3].map(|k| words[k].parse().unwrap()));
            } else if words.first() == Some(&"f") {
                let count = scene.positions.len() as i64;
                let index = |word: &&str| {
                    let i: i64 = word.split('/').next().unwrap().parse().unwrap();
                    if i < 0 { (count + i) as u32 } else { i as u32 - 1 }
                };
                let corners: Vec<u32> = words[1..].iter().map(index).collect();
                scene.triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
            }
        }
        check(&scene, if scene.triangles.len() < 100 { 20_000 } else { 4_000 });
    }
}

#[test]
fn ranges_of_queues_touch_only_their_rows() {
    let scene = soup(800, 0.2, 16);
    let bvh = scene.bvh();
    let list = rays(&scene, 1_000, 17);
    let queue = queue(&list);
    let mut counters = WalkCounters::default();
    for (walk, mut scratch) in ways(&bvh) {
        let mut whole = HitQueue::with_len(list.len());
        let mut blocked = vec![];
        bvh.intersect_by(walk, &queue, 0..list.len(), &mut whole, &mut scratch, &mut counters);
        bvh.occluded_by(walk, &queue, 0..list.len(), &mut blocked, &mut scratch, &mut counters);
        for range in [0..0, 0..1, 8..9, 16..31, 64..64 + 257, 504..1_000] {
            let mut hits = HitQueue::with_len(list.len());
            hits.t.fill(-7.0);
            let mut some = vec![0xa5; 126];
            bvh.intersect_by(walk, &queue, range.clone(), &mut hits, &mut scratch, &mut counters);
            bvh.occluded_by(walk, &queue, range.clone(), &mut some, &mut scratch, &mut counters);
            for i in 0..list.len() {
                if range.contains(&i) {
                    assert_eq!(bits(row(&hits, i)), bits(row(&whole, i)), "{walk:?}, {range:?}");
                    assert_eq!(some[i / 8] >> (i % 8) & 1, blocked[i / 8] >> (i % 8) & 1, "{walk:?}, {range:?}");
                } else if i < range.start || i >= range.end.next_multiple_of(8) {
                    assert_eq!(hits.t[i], -7.0, "{walk:?}, {range:?} wrote row {i}");
                    assert_eq!(some[i / 8], 0xa5, "{walk:?}, {range:?} wrote byte {}", i / 8);
                }
            }
        }
    }
}
