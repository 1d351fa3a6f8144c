//! Every SIMD level against the lowest, bit for bit, also on rays that nobody means to ask about.

use crate::scenes::{Random, Ray, Scene, corridor, cube, heightfield, rays, room, slivers, soup, sphere};
use crate::{bits, queue, row};
use octray::SimdLevel;
use octray::internal::bvh::{Bvh, HitQueue, RayQueue, Scratch, Segments, Walk, WalkCounters};
use std::ops::Range;

/// The levels that this CPU has, from the lowest; says so if the highest is missing.
pub fn levels() -> Vec<SimdLevel> {
    let levels = SimdLevel::available();
    if !levels.contains(&SimdLevel::Avx512) {
        eprintln!("skipped: walks of sixteen rays, since this CPU has no AVX-512");
    }
    levels
}

/// Every walk that a tree has, at every level.
pub fn ways(bvh: &Bvh) -> Vec<(Walk, Scratch)> {
    let at = |level| bvh.walks().into_iter().map(move |walk| (walk, Scratch::at(level)));
    levels().into_iter().flat_map(at).collect()
}

/// Numbers that break what was not written for them.
const NASTY: [f32; 14] = [
    0.0,
    -0.0,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN_POSITIVE,
    1e-45,
    1e30,
    -1e30,
    1e-30,
    -1e-30,
    1.0 / (1u64 << 56) as f32,
    (1u64 << 56) as f32,
];

/// Rays in runs of 40: every second run is scattered, the others nearly copies of one ray, so that packets stay together.
fn fuzzed(scene: &Scene, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let mut list = rays(scene, count, seed);
    for i in 0..count {
        if i / 40 % 2 == 1 {
            let first = list[i - i % 40];
            let mut near = |x: f32, by: f32| x + by * (random.unit() - 0.5);
            list[i] = Ray { o: first.o.map(|x| near(x, 0.05)), d: first.d.map(|x| near(x, 0.1)), ..list[i] };
        }
        let ray = &mut list[i];
        let nasty = NASTY[random.below(NASTY.len())];
        let axis = random.below(3);
        match random.below(24) {
            0 => ray.o[axis] = nasty,
            1 => ray.d[axis] = nasty,
            2 => ray.tmin = if nasty < 0.0 { 0.0 } else { nasty },
            3 => ray.tmax = nasty,
            4 | 5 => {
                let length = 10f32.powi(random.below(61) as i32 - 30);
                ray.d = ray.d.map(|x| x * length);
            }
            6 => {
                let vertex = scene.positions.get(random.below(scene.positions.len().max(1)));
                ray.o[axis] = vertex.map_or(0.0, |vertex| vertex[axis]);
                ray.d[(axis + 1) % 3] = if random.below(2) == 0 { 0.0 } else { -0.0 };
            }
            _ => {}
        }
        // Boxes bend rays of the shortest directions allowed, and those that start far off by more than boxes are widened: what
        // walks say of them may differ. (Still shorter ones hit nothing.)
        let longest = ray.d.into_iter().fold(0.0, |m: f32, x| m.max(x.abs()));
        if longest < 1e-12 && longest > 1e-17 {
            ray.d = ray.d.map(|x| x * 1e12);
        }
    }
    list
}

/// What a walk at a level says: closest hits, any hits, and any hits of rays that aim at something.
struct Answers {
    way: String,
    hits: HitQueue,
    blocked: Vec<u8>,
    blocked_before: Vec<u8>,
}

/// What a level says of rays `range`, walk by walk.
fn answers(level: SimdLevel, bvh: &Bvh, rays: &RayQueue, aimed: Segments, range: &Range<usize>) -> Vec<Answers> {
    let (mut scratch, mut counters) = (Scratch::at(level), WalkCounters::default());
    let mut answers = vec![];
    for walk in bvh.walks() {
        let mut hits = HitQueue::with_len(range.end);
        let [mut blocked, mut blocked_before] = [vec![], vec![]];
        bvh.intersect_by(walk, rays, range.clone(), &mut hits, &mut scratch, &mut counters);
        bvh.occluded_by(walk, rays, range.clone(), &mut blocked, &mut scratch, &mut counters);
        bvh.occluded_by(walk, aimed, range.clone(), &mut blocked_before, &mut scratch, &mut counters);
        answers.push(Answers { way: format!("{walk:?}, {level}"), hits, blocked, blocked_before });
    }
    assert!(counters.lanes_used <= counters.lanes_possible, "{counters:?}");
    answers
}

/// How many rays of `range` any walk at any level answers otherwise than the first walk at the lowest.
fn differences(bvh: &Bvh, list: &[Ray], range: Range<usize>) -> usize {
    let rays = queue(list);
    // Aimed at what they hit, or at what comes after it by id.
    let mut aimed = rays.clone();
    let mut before = vec![0; rays.tmax.len()];
    let mut hits = HitQueue::with_len(list.len());
    let (mut scratch, mut counters) = (Scratch::at(SimdLevel::available()[0]), WalkCounters::default());
    bvh.intersect_by(bvh.walks()[0], &rays, 0..list.len(), &mut hits, &mut scratch, &mut counters);
    for (i, before) in before.iter_mut().enumerate().take(list.len()) {
        *before = hits.triangle[i].min(i32::MAX as u32 - 1) + (i % 2) as u32;
        aimed.tmax[i] = hits.t[i];
    }
    let all =
        levels().into_iter().flat_map(|level| answers(level, bvh, &rays, Segments::aimed(&aimed, &before), &range));
    let all: Vec<Answers> = all.collect();
    let bit = |bytes: &[u8], i: usize| bytes[i / 8] >> (i % 8) & 1;
    let said = |of: &Answers, i: usize| (bits(row(&of.hits, i)), bit(&of.blocked, i), bit(&of.blocked_before, i));
    let mut wrong = 0;
    for i in range {
        if let Some(other) = all.iter().find(|other| said(other, i) != said(&all[0], i)) {
            wrong += 1;
            if wrong <= 3 {
                let (Ray { o, d, tmin, tmax }, (one, two)) = (list[i], (&all[0], other));
                eprintln!("ray {i} {o:?} {d:?} {tmin} {tmax}");
                eprintln!("  {}: {:x?}, {}: {:x?}", one.way, said(one, i), two.way, said(two, i));
            }
        }
    }
    wrong
}

#[test]
fn fuzzed_rays_are_answered_alike_by_all_levels() {
    let scenes = [
        cube(1),
        cube(12),
        room(),
        sphere(30, 40),
        heightfield(40),
        soup(7, 0.8, 1),
        soup(3_000, 0.1, 2),
        soup(400, 1.5, 3),
        slivers(400, 8, 4),
        corridor([1.0, 1.0, 1e4], 0.3),
        corridor([1.0, 1e-6, 1.0], 0.0),
        room().transformed("tiny room", |p| p.map(|x| x * 1e-6)),
        soup(0, 1.0, 0),
    ];
    let precise = |scene: &Scene, bvh: &Bvh| (0..scene.triangles.len() as u32).any(|id| bvh.class(id) != 0);
    let bvhs: Vec<Bvh> = scenes.iter().map(Scene::bvh).collect();
    assert!(scenes.iter().zip(&bvhs).any(|(scene, bvh)| precise(scene, bvh)), "some triangles are precise");
    let lists = bvhs.iter().filter(|bvh| bvh.walks().len() == 4).count();
    assert!(lists > 2 && lists < bvhs.len(), "some scenes are lists");
    for (seed, (scene, bvh)) in scenes.iter().zip(&bvhs).enumerate() {
        let list = fuzzed(scene, 24_000, seed as u64 + 100);
        assert_eq!(differences(bvh, &list, 0..list.len()), 0, "{}", scene.name);
    }
}

/// Whatever part of a block is asked about, the rest of it disturbs nothing.
#[test]
fn parts_of_blocks_are_answered_alike_by_all_levels() {
    let mut random = Random(3);
    for scene in [room(), sphere(12, 16), slivers(100, 6, 7)] {
        let bvh = scene.bvh();
        let list = fuzzed(&scene, 400, 8);
        for _ in 0..150 {
            let first = 8 * random.below(40);
            let range = first..first + random.below(50);
            assert_eq!(differences(&bvh, &list, range.clone()), 0, "{} {range:?}", scene.name);
        }
    }
}
