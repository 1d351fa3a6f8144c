//! What applies to a scene of the user's: properties of the input are remarks, never failures.

use crate::check::item::{Effort, SceneCheck, SceneSubject};
use crate::check::lights::worst_sum_of_probabilities;
use crate::check::row::Outcome;
use crate::check::shots::{corners, leaks_inwards, self_hits, walks_that_differ};
use crate::check::trial::{SIGMAS, small, trace_command};
use crate::check::twin::{Differing, larger};
use crate::error::Result;
use crate::film::Film;
use crate::reference::{double, single};
use crate::render::render;
use crate::scene::flatten::Geometry;
use crate::settings::{Lights, Settings, Train};
use crate::setup::Setup;
use crate::strategy::Strategy;
use glam::DVec3;
use std::collections::HashMap;

/// The checks.
pub const CHECKS: &[SceneCheck] = &[
    SceneCheck { group: "scene", what: "engines_agree", run: engines_agree },
    SceneCheck { group: "scene", what: "walks_agree", run: walks_agree },
    SceneCheck { group: "scene", what: "threads_agree", run: threads_agree },
    SceneCheck { group: "scene", what: "samples_are_finite", run: samples_are_finite },
    SceneCheck { group: "scene", what: "strategies_agree", run: strategies_agree },
    SceneCheck { group: "scene", what: "rays_off_their_triangles", run: rays_off_their_triangles },
    SceneCheck { group: "scene", what: "closed_mesh_does_not_leak", run: closed_mesh_does_not_leak },
    SceneCheck { group: "scene", what: "light_probabilities_sum_to_one", run: light_probabilities_sum_to_one },
    SceneCheck { group: "scene", what: "f32_paths_as_f64", run: f32_paths_as_f64 },
    SceneCheck { group: "scene", what: "open_edges", run: open_edges },
    SceneCheck { group: "scene", what: "coincident_triangles", run: coincident_triangles },
    SceneCheck { group: "scene", what: "slivers", run: slivers },
    SceneCheck { group: "scene", what: "distance_from_the_origin", run: distance_from_the_origin },
];

/// Paths are followed so far at most, where a scene asks for more.
const DEPTH: u32 = 12;
/// Paths of the training render, so that the engines are compared with all that is learned, too.
const TRAINING: u32 = 4096;

/// The settings of a small picture, `side` pixels long.
fn settings(subject: &SceneSubject, side: u32, spp: u32) -> Settings {
    let (width, height) = subject.prepared.film;
    let part = f64::from(side) / f64::from(width.max(height));
    let pixels = |n: u32| Some(((f64::from(n) * part).round() as u32).max(1));
    let max_depth = Some(subject.settings.max_depth.unwrap_or(DEPTH).min(DEPTH));
    let small = small(side, spp);
    Settings {
        width: pixels(width),
        height: pixels(height),
        max_depth,
        sampler: small.sampler,
        train: Train::Paths(TRAINING),
        spp,
        threads: 1,
        ..subject.settings.clone()
    }
}

fn engines_agree(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    let mut differing = Differing::default();
    for strategy in [subject.settings.strategy, Strategy::Bsdf] {
        let settings = Settings { strategy, ..settings(subject, 32, effort.samples(2, 1)) };
        differing.engines(strategy.name(), subject.prepared, &settings);
    }
    Ok(Outcome::at_most(differing.pixels as f64, 0.0)
        .tried(differing.samples, "samples by both engines, pixels whose bits differ")
        .note(differing.what)
        .trace(differing.trace))
}

fn walks_agree(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    let count = effort.cases(20_000);
    Ok(Outcome::at_most(walks_that_differ(subject.prepared, count, 1) as f64, 0.0)
        .tried(count, "rays by every walk, hits whose bits differ"))
}

fn threads_agree(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    let mut differing = Differing::default();
    let one = settings(subject, 64, effort.samples(2, 1));
    let three = Settings { threads: 3, ..one.clone() };
    differing.add(
        "",
        subject.prepared,
        &one,
        [&render(subject.prepared, &one).film, &render(subject.prepared, &three).film],
    );
    Ok(Outcome::at_most(differing.pixels as f64, 0.0)
        .tried(differing.samples, "samples by 1 and 3 threads, pixels whose bits differ"))
}

fn samples_are_finite(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    let (mut count, mut samples, mut trace) = (0, 0, None);
    for &strategy in Strategy::ALL {
        let settings = Settings { strategy, ..settings(subject, 48, effort.samples(2, 1)) };
        let stats = render(subject.prepared, &settings).stats;
        let first = stats.nonfinite_samples.first();
        let path = subject.path;
        trace = trace.or(first.map(|at| trace_command(path, &settings, (at.x, at.y), at.sample)));
        (count, samples) = (count + stats.nonfinite, samples + stats.paths);
    }
    Ok(Outcome::at_most(count as f64, 0.0)
        .tried(samples, "samples of 9 strategies, those that are not finite")
        .trace(trace))
}

/// The difference of two films pixel by pixel: how many standard errors its mean is from 0, and how many pixels make up its
/// square.
fn apart(a: &Film, b: &Film) -> (f64, f64) {
    let n = f64::from(a.spp);
    let differences: Vec<f64> = a.pixels.iter().zip(&b.pixels).map(|(p, q)| (q.sum[1] - p.sum[1]) / n).collect();
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let scale = differences.iter().fold(0.0f64, |most, d| most.max(d.abs()));
    if scale == 0.0 {
        return (0.0, count);
    }
    let moment = |power: i32| differences.iter().map(|d| (d / scale).powi(power)).sum::<f64>();
    let (squares, fourths) = (moment(2), moment(4));
    let error = scale * squares.sqrt() / count;
    (mean.abs() / error, squares * squares / fourths)
}

/// Strategies that sample lights draw the same paths from the same numbers, so what they differ by is light samples and
/// weights alone. Where a few pixels make up all of it nothing can be said: rare bright samples decide, and one strategy may
/// not have met them.
fn strategies_agree(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    const LEAST_PIXELS: f64 = 150.0;
    let spp = effort.samples(16, 4);
    let film = |strategy| {
        let max_depth = Some(subject.settings.max_depth.unwrap_or(3).min(3));
        render(subject.prepared, &Settings { strategy, max_depth, ..settings(subject, 64, spp) }).film
    };
    let base = film(Strategy::MisPower);
    let (mut worst, mut undecided, mut notes) = (0.0, Vec::new(), Vec::new());
    let others = [Strategy::Nee, Strategy::NeeAverage, Strategy::MisOneSample, Strategy::MisBalance];
    for strategy in others {
        let (sigmas, pixels) = apart(&base, &film(strategy));
        if pixels < LEAST_PIXELS {
            undecided.push(strategy.name());
            continue;
        }
        notes.push(format!("{strategy} {sigmas:.1}"));
        worst = larger(worst, sigmas);
    }
    if !undecided.is_empty() {
        notes.push(format!("too few bright samples to judge {}", undecided.join(", ")));
    }
    let samples = u64::from(spp) * base.pixels.len() as u64 * 5;
    Ok(Outcome::at_most(worst, SIGMAS)
        .tried(samples, "samples of 5 strategies, from mis-power in standard errors")
        .note(notes.join(", ")))
}

fn rays_off_their_triangles(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    let (hits, shot) = self_hits(subject.prepared, effort.cases(100_000), 1);
    let share = hits[0] as f64 / shot.max(1) as f64;
    Ok(Outcome::at_most(share, 1e-4)
        .tried(shot, "rays, half of them grazing, the share that hits again the triangle it leaves")
        .note(if hits == [0; 2] { String::new() } else { format!("{} in f32, {} in f64", hits[0], hits[1]) }))
}

/// What the edges of a mesh say of it.
struct Shell {
    /// Edges without exactly one partner of the opposite direction.
    open: u64,
    /// All edges.
    edges: u64,
    /// Per triangle, 1 where the inside of its part of the mesh lies before its front, -1 where behind.
    inwards: Vec<f64>,
}

impl Shell {
    /// That of all triangles of a scene. Vertices are the same where their positions are: files repeat them.
    fn of(geometry: &Geometry<'_>) -> Shell {
        let mut ids: HashMap<[u32; 3], u32> = HashMap::new();
        let mut id = |position: [f32; 3]| {
            let next = ids.len() as u32;
            *ids.entry(position.map(|x| (x + 0.0).to_bits())).or_insert(next)
        };
        let mut sides: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
        let mut volumes = Vec::with_capacity(geometry.triangles.len());
        let origin = geometry.positions.first().map_or(DVec3::ZERO, |p| DVec3::from(p.map(f64::from)));
        for (number, triangle) in geometry.triangles.iter().enumerate() {
            let [p, q, r] = geometry.vertices(number);
            let [p, q, r] = if triangle.flipped { [p, r, q] } else { [p, q, r] };
            let [a, b, c] = [p, q, r].map(&mut id);
            let [p, q, r] = [p, q, r].map(|p| DVec3::from(p.map(f64::from)) - origin);
            volumes.push(p.dot(q.cross(r)));
            for edge in [(a, b), (b, c), (c, a)] {
                sides.entry(edge).or_default().push(number as u32);
            }
        }
        let mut part: Vec<u32> = (0..geometry.triangles.len() as u32).collect();
        let mut open = 0;
        for (&(a, b), triangles) in &sides {
            match (triangles.as_slice(), sides.get(&(b, a)).map(Vec::as_slice)) {
                (&[one], Some(&[other])) => {
                    let (p, q) = (root(&mut part, one), root(&mut part, other));
                    part[p as usize] = q;
                }
                _ => open += triangles.len() as u64,
            }
        }
        let mut volume: HashMap<u32, f64> = HashMap::new();
        for (number, of) in volumes.iter().enumerate() {
            *volume.entry(root(&mut part, number as u32)).or_default() += of;
        }
        // Fronts of a part with a positive volume face outwards.
        let inwards = (0..volumes.len() as u32).map(|number| -volume[&root(&mut part, number)].signum()).collect();
        Shell { open, edges: 3 * volumes.len() as u64, inwards }
    }
}

/// The triangle that stands for the part of the mesh that `of` belongs to.
fn root(part: &mut [u32], mut of: u32) -> u32 {
    while part[of as usize] != of {
        part[of as usize] = part[part[of as usize] as usize];
        of = part[of as usize];
    }
    of
}

fn closed_mesh_does_not_leak(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    let geometry = subject.scene.desc.geometry();
    let shell = Shell::of(&geometry);
    if shell.open > 0 {
        return Ok(Outcome::remark(0.0, "the mesh is not closed").tried(0, "rays inside"));
    }
    let inwards = |triangle: u32| shell.inwards[triangle as usize];
    let (leaks, shot) = leaks_inwards(subject.prepared, &inwards, effort.cases(200_000), 1);
    Ok(Outcome::at_most(leaks as f64 / shot.max(1) as f64, 1e-5)
        .tried(shot, "rays inside, half of them grazing, the share that finds a way out")
        .note(if leaks == 0 { String::new() } else { format!("{leaks} leak") }))
}

fn light_probabilities_sum_to_one(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    let emitters = subject.prepared.emitters.len() as u64;
    let places = (effort.cases(1_000_000) / emitters.max(1)).clamp(1, 1000);
    let (worst, asked) = worst_sum_of_probabilities(subject.prepared, places, 1);
    Ok(Outcome::at_most(worst, 1e-4)
        .tried(asked, format!("places by {} selections, distance of the sum from 1", Lights::ALL.len())))
}

/// The same paths by the reference in f32 and in f64: rounding may send one elsewhere, but not change the picture.
fn f32_paths_as_f64(subject: &SceneSubject, effort: &Effort) -> Result<Outcome> {
    let settings = settings(subject, 32, effort.samples(4, 1));
    let setup = Setup::new(subject.prepared, &settings);
    let (width, height) = setup.frame.film;
    let (mut differences, mut mean, mut elsewhere, mut paths) = (Vec::new(), 0.0, 0u64, 0u64);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let mut difference = 0.0;
        for sample in 0..settings.spp {
            let narrow = single::path::trace_path(&setup, (x, y), sample, &mut single::observer::Unobserved).radiance.y;
            let wide = double::path::trace_path(&setup, (x, y), sample, &mut double::observer::Unobserved).radiance.y;
            let narrow = f64::from(narrow);
            elsewhere += u64::from((narrow - wide).abs() > 1e-3 * narrow.abs().max(wide.abs()));
            difference += narrow - wide;
            mean += wide;
            paths += 1;
        }
        differences.push(difference / f64::from(settings.spp));
    }
    let mean = (mean / paths as f64).abs().max(f64::MIN_POSITIVE);
    let estimate = crate::check::trial::Estimate::of_values(&differences);
    let relative = estimate.mean / mean;
    let certain = (estimate.mean.abs() - SIGMAS * estimate.error).max(0.0) / mean;
    let certain = if estimate.mean.is_nan() { f64::NAN } else { certain };
    let share = elsewhere as f64 / paths as f64;
    Ok(Outcome::at_most(certain, 1e-3)
        .tried(paths, "paths in f32 and f64, what the means certainly differ by")
        .note(format!("{:.2} % of the paths go elsewhere; means {relative:+.1e} apart", 100.0 * share)))
}

fn open_edges(subject: &SceneSubject, _: &Effort) -> Result<Outcome> {
    let shell = Shell::of(&subject.scene.desc.geometry());
    let note = if shell.open == 0 { "the mesh is closed" } else { "" };
    Ok(Outcome::remark(shell.open as f64, note).tried(shell.edges, "edges, those without one partner"))
}

/// Triangles with the same corners as an earlier one.
fn coincident_triangles(subject: &SceneSubject, _: &Effort) -> Result<Outcome> {
    let mut seen: HashMap<[[u32; 3]; 3], u32> = HashMap::new();
    let (mut same, mut first) = (0u64, String::new());
    for (number, triangle) in subject.prepared.triangles.iter().enumerate() {
        let mut key = triangle.vertices.map(|vertex| vertex.map(|x| (x + 0.0).to_bits()));
        key.sort_unstable();
        let earlier = *seen.entry(key).or_insert(number as u32);
        if earlier != number as u32 {
            if same == 0 {
                first = format!("triangle {number} lies in the place of {earlier}: of two, the first is seen");
            }
            same += 1;
        }
    }
    let count = subject.prepared.triangles.len() as u64;
    Ok(Outcome::remark(same as f64, first).tried(count, "triangles, those in the place of an earlier one"))
}

fn slivers(subject: &SceneSubject, _: &Effort) -> Result<Outcome> {
    let (mut worst, mut at, mut thin, mut flat) = (0.0, 0, 0u64, 0u64);
    let count = subject.prepared.triangles.len();
    for triangle in 0..count {
        let [a, b, c] = corners(subject.prepared, triangle);
        let area = (b - a).cross(c - a).length();
        if area == 0.0 {
            flat += 1;
            continue;
        }
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let aspect = longest * longest / area;
        thin += u64::from(aspect > 1000.0);
        if aspect > worst {
            (worst, at) = (aspect, triangle);
        }
    }
    let note = format!("triangle {at} is the thinnest; {thin} beyond 1,000, {flat} without area");
    Ok(Outcome::remark(worst, note).tried(count as u64, "triangles, longest edge over height"))
}

fn distance_from_the_origin(subject: &SceneSubject, _: &Effort) -> Result<Outcome> {
    let all = || subject.prepared.triangles.iter().flat_map(|t| t.vertices).map(|v| DVec3::from(v.map(f64::from)));
    let low = all().fold(DVec3::INFINITY, DVec3::min);
    let high = all().fold(DVec3::NEG_INFINITY, DVec3::max);
    let size = (high - low).max_element();
    let farthest = low.abs().max(high.abs()).max_element();
    let note = if farthest > 1000.0 * size { "far off: f32 coordinates are coarse there" } else { "" };
    Ok(Outcome::remark(farthest / size, note)
        .tried(all().count() as u64, "corners, the farthest in sizes of the scene"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::Scene;
    use crate::check::item::Level;
    use crate::check::scenes;
    use crate::fault::{Fault, tests::with};

    const QUICK: Effort = Effort { level: Level::Quick, threads: 1 };

    fn outcome(name: &str, what: &str) -> Outcome {
        outcome_of(&scenes::load(name).unwrap(), what)
    }

    fn outcome_of(scene: &Scene, what: &str) -> Outcome {
        let prepared = scene.prepare().unwrap();
        let path = scene.desc.name.clone();
        let subject = SceneSubject { scene, path: &path, prepared: &prepared, settings: scene.settings() };
        let check = CHECKS.iter().find(|check| check.what == what).unwrap();
        (check.run)(&subject, &QUICK).unwrap()
    }

    #[test]
    fn sound_scenes_pass() {
        for name in ["room:1:0:0.001", "furnace:0.5:0.5", "lamps:3", "hollow_ball:3:0"] {
            for check in CHECKS {
                let outcome = outcome(name, check.what);
                assert!(
                    outcome.pass,
                    "{name}, {}: {} > {}, {}",
                    check.what, outcome.figure, outcome.bound, outcome.note
                );
            }
        }
    }

    #[test]
    fn planted_faults_fail() {
        let faults = [
            (Fault::MissingCosine, "engines_agree", "room:1:0:0.001"),
            (Fault::TraceOfThreads, "threads_agree", "room:1:0:0.001"),
            (Fault::MissingCosine, "strategies_agree", "lamps:3"),
            (Fault::LopsidedChoice, "light_probabilities_sum_to_one", "lamps:3"),
            (Fault::WrongOffset, "rays_off_their_triangles", "hollow_ball:3:0"),
            (Fault::LostTriangle, "closed_mesh_does_not_leak", "hollow:1:1:1:1:1:0"),
            (Fault::BlindWalk, "walks_agree", "hollow_ball:3:0"),
            (Fault::InfiniteRadiance, "samples_are_finite", "lamps:3"),
            (Fault::ScalarDensity, "f32_paths_as_f64", "lamps:3"),
        ];
        for (fault, what, name) in faults {
            let outcome = with(fault, || outcome(name, what));
            assert!(!outcome.pass, "{what} passes with {fault:?}: {} <= {}", outcome.figure, outcome.bound);
        }
    }

    #[test]
    fn properties_of_the_input_are_remarks() {
        let remarks = [
            ("lamps:3", "open_edges", 40.0),
            ("coincident:1:0", "coincident_triangles", 2.0),
            ("needle:1:1e-3:1:0", "slivers", 1000.0),
            ("hollow:1:1:1:1:1:1e4", "distance_from_the_origin", 3000.0),
        ];
        for (name, what, least) in remarks {
            let outcome = outcome(name, what);
            assert!(outcome.pass && outcome.figure >= least, "{name}, {what}: {}", outcome.figure);
        }
        assert_eq!(outcome("hollow_ball:3:0", "open_edges").figure, 0.0);
        assert!(outcome("lamps:3", "closed_mesh_does_not_leak").note.contains("not closed"));
    }
}
