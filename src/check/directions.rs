//! Directions: zeros, denormals, grazing, starts on edges and lights.

use crate::bvh::ray::NO_HIT;
use crate::check::item::{Check, Effort};
use crate::check::numbers::{Numbers, worse};
use crate::check::rays::Rays;
use crate::check::row::Outcome;
use crate::check::trial::{SIGMAS, Trial, Worst, small};
use crate::error::Result;
use crate::reference::single::intersect::{Ray, intersect, stack};
use crate::reference::single::surface::surface_point;
use crate::reference::single::warp;
use crate::settings::Settings;
use crate::strategy::Strategy;
use glam::{DVec3, Vec3};

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "directions", what: "zero_components", run: zero_components },
    Check { group: "directions", what: "denormal_components", run: denormal_components },
    Check { group: "directions", what: "any_length", run: any_length },
    Check { group: "directions", what: "no_numbers_hit_nothing", run: no_numbers_hit_nothing },
    Check { group: "directions", what: "aimed_at_edges", run: aimed_at_edges },
    Check { group: "directions", what: "grazing_starts", run: grazing_starts },
    Check { group: "directions", what: "starts_on_edges", run: starts_on_edges },
    Check { group: "directions", what: "starts_on_lights", run: starts_on_lights },
    Check { group: "directions", what: "frames", run: frames },
    Check { group: "directions", what: "ends_of_the_hemisphere", run: ends_of_the_hemisphere },
];

/// Rays at once.
const BATCH: u64 = 4096;

/// The low and high corner of the room of the scene `furnace`.
const LOW: DVec3 = DVec3::new(-1.0, -1.0, -1.0);
const HIGH: DVec3 = DVec3::new(1.0, 1.5, 2.0);

/// A point in the room; every fourth on a plane of symmetry, where rays run along edges and diagonals.
fn inside(numbers: &mut Numbers) -> Vec3 {
    let mut point = LOW + (HIGH - LOW) * DVec3::new(numbers.fine(), numbers.fine(), numbers.fine()) * 0.999;
    if numbers.below(4) == 0 {
        point[numbers.below(3) as usize] = 0.0;
    }
    point.as_vec3()
}

/// How far the ray is from the walls of the room, in f64, and its speed towards that wall.
fn to_the_wall(origin: Vec3, direction: Vec3) -> (f64, f64) {
    let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
    let along = |k: usize| match d[k] {
        d if d > 0.0 => (HIGH[k] - o[k]) / d,
        d if d < 0.0 => (LOW[k] - o[k]) / d,
        _ => f64::INFINITY,
    };
    let nearest = (0..3).min_by(|&a, &b| along(a).total_cmp(&along(b))).unwrap_or(0);
    (along(nearest), d[nearest].abs())
}

/// Rays of the room against its walls: those that have other bits in some walk, and how far the hits are off the walls,
/// relative to the room (infinite where a ray has left).
fn in_the_room(
    effort: &Effort,
    seed: u32,
    usual: u64,
    bound: f64,
    direct: impl Fn(&mut Numbers) -> Vec3,
) -> Result<Outcome> {
    let trial = Trial::new("furnace", &[0.5, 0.5])?;
    let cases = effort.cases(usual);
    let mut numbers = Numbers::new(seed);
    let (mut worst, mut differ, mut note): (f64, u64, String) = (0.0, 0, String::new());
    for _ in 0..cases.div_ceil(BATCH) {
        let mut rays = Rays::default();
        for _ in 0..BATCH {
            let origin = inside(&mut numbers);
            rays.push(origin, direct(&mut numbers));
        }
        let reference = rays.reference(&trial.prepared);
        let (count, first) = rays.differing(&trial.prepared, &reference);
        differ += count;
        if note.is_empty() {
            note = first;
        }
        for (row, hit) in reference.iter().enumerate() {
            let (origin, direction) = rays.ray(row);
            let (wanted, speed) = to_the_wall(origin, direction);
            let off = |t: f32| (f64::from(t) - wanted).abs() * speed / (HIGH - LOW).max_element();
            let error = hit.map_or(f64::INFINITY, |hit| off(hit.t));
            if worse(error, worst) {
                worst = error;
                if error > bound && differ == 0 {
                    note = format!("t = {:?} for {wanted:e}: {origin:?} towards {direction:?}", hit.map(|hit| hit.t));
                }
            }
        }
    }
    Ok(Outcome::at_most(worst, bound)
        .tried(cases, "rays in a box by every walk, distance of hits from the walls over its size")
        .note(note)
        .and(differ == 0, format!("{differ} rays have other bits than in the reference")))
}

/// Directions of which one or two components are 0 or -0.
fn zero_components(effort: &Effort) -> Result<Outcome> {
    in_the_room(effort, 1, 65_536, 1e-6, |numbers| {
        let mut direction = numbers.direction().as_vec3();
        let kept = numbers.below(3) as usize;
        let both = numbers.below(2) == 0;
        for k in (0..3).filter(|&k| k != kept && (both || k == (kept + 1) % 3)) {
            direction[k] = if numbers.below(2) == 0 { 0.0 } else { -0.0 };
        }
        direction
    })
}

/// Directions whose smaller components lie between 1e-45 and 1e-30.
fn denormal_components(effort: &Effort) -> Result<Outcome> {
    in_the_room(effort, 2, 65_536, 1e-6, |numbers| {
        let mut direction = numbers.direction().as_vec3();
        let kept = numbers.below(3) as usize;
        let both = numbers.below(2) == 0;
        for k in (0..3).filter(|&k| k != kept && (both || k == (kept + 1) % 3)) {
            direction[k] = (numbers.magnitude(-45.0, -30.0) * (numbers.fine() - 0.5).signum()) as f32;
        }
        direction
    })
}

/// Directions of any length from 1e-16 to 1e16: t in units of it. Longer and shorter ones hit nothing, by any walk.
fn any_length(effort: &Effort) -> Result<Outcome> {
    let within = in_the_room(effort, 3, 65_536, 1e-6, |numbers| {
        let direction = numbers.direction();
        (direction * numbers.magnitude(-16.0, 16.0)).as_vec3()
    })?;
    let trial = Trial::new("furnace", &[0.5, 0.5])?;
    let (mut rays, mut numbers) = (Rays::default(), Numbers::new(10));
    for _ in 0..effort.cases(BATCH) {
        let length = numbers.magnitude(17.3, 38.0);
        let length = if numbers.below(2) == 0 { length } else { 1.0 / length };
        let origin = inside(&mut numbers);
        rays.push(origin, (numbers.direction() * length).as_vec3());
    }
    let reference = rays.reference(&trial.prepared);
    let (differ, first) = rays.differing(&trial.prepared, &reference);
    let hit = reference.iter().filter(|hit| hit.is_some()).count();
    let beyond = format!("{differ} rays beyond have other bits than in the reference, {hit} hit something: {first}");
    Ok(within.and(differ == 0 && hit == 0, beyond))
}

/// Rays that are not made of numbers hit nothing, by any walk.
fn no_numbers_hit_nothing(effort: &Effort) -> Result<Outcome> {
    let trial = Trial::new("furnace", &[0.5, 0.5])?;
    let cases = effort.cases(16_384);
    let mut numbers = Numbers::new(4);
    let mut wrong = 0;
    for _ in 0..cases.div_ceil(BATCH) {
        let mut rays = Rays::default();
        for _ in 0..BATCH {
            let (mut origin, mut direction) = (inside(&mut numbers), numbers.direction().as_vec3());
            let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][numbers.below(3) as usize];
            match numbers.below(2) {
                0 => origin[numbers.below(3) as usize] = bad,
                _ => direction[numbers.below(3) as usize] = bad,
            }
            rays.push(origin, direction);
        }
        for walk in trial.prepared.bvh.walks() {
            let hits = rays.hits(&trial.prepared, walk);
            let blocked = rays.blocked(&trial.prepared, walk);
            wrong += (0..rays.len()).filter(|&row| hits.triangle[row] != NO_HIT || blocked[row]).count();
        }
    }
    Ok(Outcome::at_most(wrong as f64, 0.0).tried(cases, "rays with NaN or infinity by every walk, those that hit"))
}

/// Rays from inside a closed ball towards its vertices and edges do not pass between its triangles.
fn aimed_at_edges(effort: &Effort) -> Result<Outcome> {
    let trial = Trial::new("globe", &[24.0])?;
    let scene = &trial.prepared;
    let cases = effort.cases(65_536);
    let mut numbers = Numbers::new(5);
    let (mut lost, mut differ, mut note) = (0, 0, String::new());
    for _ in 0..cases.div_ceil(BATCH) {
        let mut rays = Rays::default();
        for _ in 0..BATCH {
            let origin = (numbers.direction() * 0.9 * numbers.fine()).as_vec3();
            let [a, b, _] =
                scene.triangles[numbers.below(scene.triangles.len() as u32) as usize].vertices.map(Vec3::from);
            let along = [0.0, 0.5, numbers.unit()][numbers.below(3) as usize];
            rays.push(origin, a + (b - a) * along - origin);
        }
        let reference = rays.reference(scene);
        lost += reference.iter().filter(|hit| hit.is_none()).count();
        let (count, first) = rays.differing(scene, &reference);
        differ += count;
        note = if note.is_empty() { first } else { note };
    }
    Ok(Outcome::at_most(lost as f64, 0.0)
        .tried(cases, "rays at edges and vertices of a closed ball from inside, those that left")
        .note(note)
        .and(differ == 0, format!("{differ} rays have other bits than in the reference")))
}

/// A ray that leaves a hit of the room, by the reference's own start.
fn leave(scene: &Trial, triangle: usize, [u, v]: [f32; 2], direction: Vec3) -> Option<(bool, f32)> {
    let record = &scene.prepared.triangles[triangle];
    let inward = Vec3::from(record.normal);
    let point = surface_point(record, None, u, v, -inward);
    let ray = Ray { origin: point.origin, direction, tmin: 0.0, tmax: f32::INFINITY };
    let hit = intersect(&scene.prepared.bvh, &ray, &mut stack(&scene.prepared.bvh))?;
    Some((hit.triangle as usize == triangle, hit.t))
}

/// A direction that rises from a plane of this normal with this cosine.
fn rising(numbers: &mut Numbers, normal: DVec3, cosine: f64) -> Vec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (sine, other) = (numbers.fine() * std::f64::consts::TAU).sin_cos();
    ((tangent * other + bitangent * sine) * (1.0 - cosine * cosine).sqrt() + normal * cosine).as_vec3()
}

/// Rays that leave a wall at cosines down to 1e-7 stay in the room and do not hit the wall they left.
fn grazing_starts(effort: &Effort) -> Result<Outcome> {
    let trial = Trial::new("furnace", &[0.5, 0.5])?;
    let cases = effort.cases(200_000);
    let mut numbers = Numbers::new(6);
    let mut wrong = 0;
    for _ in 0..cases {
        let triangle = numbers.below(trial.prepared.triangles.len() as u32) as usize;
        let normal = DVec3::from(trial.prepared.triangles[triangle].normal.map(f64::from));
        let weights = warp::sample_uniform_triangle([numbers.unit(), numbers.unit()]);
        let cosine = numbers.magnitude(-7.0, 0.0);
        let direction = rising(&mut numbers, normal, cosine);
        wrong += u64::from(leave(&trial, triangle, [weights[1], weights[2]], direction).is_none_or(|(same, _)| same));
    }
    Ok(Outcome::at_most(wrong as f64, 0.0)
        .tried(cases, "rays that leave a wall at cosines from 1e-7, those lost or back on it"))
}

/// Rays that leave edges and corners of the room, or points as near to them as 1e-8, stay in it.
fn starts_on_edges(effort: &Effort) -> Result<Outcome> {
    let trial = Trial::new("furnace", &[0.5, 0.5])?;
    let cases = effort.cases(200_000);
    let mut numbers = Numbers::new(7);
    let mut wrong = 0;
    for _ in 0..cases {
        let triangle = numbers.below(trial.prepared.triangles.len() as u32) as usize;
        let normal = DVec3::from(trial.prepared.triangles[triangle].normal.map(f64::from));
        let near = if numbers.below(2) == 0 { 0.0 } else { numbers.magnitude(-8.0, 0.0) * 0.5 };
        let along = numbers.fine() * (1.0 - near);
        let [u, v] = match numbers.below(4) {
            0 => [near, along],
            1 => [along, near],
            2 => [along, 1.0 - near - along],
            _ => [near, near],
        };
        let cosine = numbers.magnitude(-4.0, 0.0);
        let direction = rising(&mut numbers, normal, cosine);
        wrong += u64::from(leave(&trial, triangle, [u as f32, v as f32], direction).is_none_or(|(same, _)| same));
    }
    Ok(Outcome::at_most(wrong as f64, 0.0)
        .tried(cases, "rays that leave edges and corners of a room, those lost or back on their wall"))
}

/// In a room of light every point lies on a light and beside others: the radiance is that of the geometric sum.
fn starts_on_lights(effort: &Effort) -> Result<Outcome> {
    let (spp, mut worst) = (effort.samples(128, 32), Worst::default());
    let trial = Trial::new("furnace", &[0.5, 0.5])?;
    let strategies = [Strategy::Bsdf, Strategy::MisBalance, Strategy::MisPower, Strategy::MisOneSample];
    for strategy in strategies {
        let settings = Settings { strategy, max_depth: Some(3), rr_depth: None, ..small(16, spp) };
        worst.add(strategy.name(), trial.mean(&settings, 1.0 - 0.5f64.powi(4)), 1e-6);
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(u64::from(spp) * 1024, "samples in a room of light, 4 strategies, in standard errors")
        .and(worst.nonfinite == 0, "samples are not finite")
        .and(worst.noise < 0.02, "too noisy to prove anything")
        .note(worst.what)
        .trace(worst.trace))
}

/// The frame about a normal is orthonormal, next to the poles too.
fn frames(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(500_000);
    let mut numbers = Numbers::new(8);
    let (mut worst, mut at) = (0.0, Vec3::Z);
    for _ in 0..cases {
        let mut n = numbers.direction();
        if numbers.below(2) == 0 {
            let tilt = numbers.magnitude(-20.0, 0.0);
            n = DVec3::new(n.x * tilt, n.y * tilt, n.z.signum()).normalize();
        }
        let n = n.as_vec3();
        let (tangent, bitangent) = warp::frame(n);
        let [t, b, n] = [tangent, bitangent, n].map(Vec3::as_dvec3);
        let n = n.normalize();
        let off = [t.dot(b), t.dot(n), b.dot(n), t.length() - 1.0, b.length() - 1.0, t.cross(b).dot(n) - 1.0];
        let error = off.into_iter().fold(0.0, |worst: f64, off| worst.max(off.abs()));
        if worse(error, worst) {
            (worst, at) = (error, n.as_vec3());
        }
    }
    Ok(Outcome::at_most(worst, 5e-7)
        .tried(cases, "frames about normals, distance from orthonormal")
        .note(format!("worst about {at:?}")))
}

/// Directions drawn at the ends of [0, 1) are unit, rise, and have a density above 0.
fn ends_of_the_hemisphere(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(500_000);
    let mut numbers = Numbers::new(9);
    let end = |numbers: &mut Numbers| match numbers.below(4) {
        0 => 0.0,
        1 => 1.0 - 1.0 / 16_777_216.0,
        2 => numbers.magnitude(-7.0, 0.0) as f32 * 0.999,
        _ => numbers.unit(),
    };
    let mut worst: f64 = 0.0;
    for _ in 0..cases {
        let u = [end(&mut numbers), end(&mut numbers)];
        let direction = warp::sample_cosine_hemisphere(u);
        let error = match warp::cosine_hemisphere_pdf_dir(direction.z) > 0.0 && direction.z > 0.0 {
            true => (direction.as_dvec3().length() - 1.0).abs(),
            false => f64::INFINITY,
        };
        worst = if worse(error, worst) { error } else { worst };
    }
    Ok(Outcome::at_most(worst, 5e-7)
        .tried(cases, "directions of a cosine hemisphere, distance of their lengths from 1"))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (WrongShear, &["directions/zero_components", "directions/denormal_components", "directions/any_length"]),
        (ClosedEdges, &["directions/aimed_at_edges"]),
        (MissesHit, &["directions/no_numbers_hit_nothing"]),
        (WrongOffset, &["directions/grazing_starts", "directions/starts_on_edges"]),
        (DensityTwice, &["directions/starts_on_lights"]),
        (SkewedFrame, &["directions/frames"]),
        (LongDirection, &["directions/ends_of_the_hemisphere"]),
    ]
};
