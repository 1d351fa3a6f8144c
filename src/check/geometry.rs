//! Geometry at its worst: slivers, duplicates, coplanar faces, crowded vertices, huge beside tiny, closed meshes that leak.

use crate::check::item::{Check, Effort};
use crate::check::lights::Lit;
use crate::check::row::Outcome;
use crate::check::shots::{misses_from_inside, self_hits};
use crate::check::trial::{Trial, small};
use crate::check::twin::Differing;
use crate::error::Result;
use crate::settings::Settings;
use crate::strategy::Strategy;
use crate::tables::PreparedScene;
use glam::DVec3;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "geometry", what: "leaks_of_corridors_to_1e6", run: leaks_of_corridors_to_1e6 },
    Check { group: "geometry", what: "leaks_of_tilted_corridors_to_1e4", run: leaks_of_tilted_corridors_to_1e4 },
    Check { group: "geometry", what: "leaks_of_boxes_to_1e-7_thin", run: leaks_of_thin_boxes },
    Check { group: "geometry", what: "leaks_of_a_cylinder", run: leaks_of_a_cylinder },
    Check { group: "geometry", what: "leaks_of_cubes_anywhere", run: leaks_of_cubes_anywhere },
    Check { group: "geometry", what: "leaks_of_balls_and_wedges", run: leaks_of_balls_and_wedges },
    Check { group: "geometry", what: "leaks_at_a_vertex_of_1e4", run: leaks_at_a_vertex_of_1e4 },
    Check {
        group: "geometry",
        what: "leaks_where_walls_cross_a_huge_ground",
        run: leaks_where_walls_cross_a_huge_ground,
    },
    Check { group: "geometry", what: "aimed_rays_from_inside", run: aimed_rays_from_inside },
    Check { group: "geometry", what: "rays_off_their_triangles", run: rays_off_their_triangles },
    Check { group: "geometry", what: "floor_of_slivers_to_1e8", run: floor_of_slivers_to_1e8 },
    Check { group: "geometry", what: "tilted_floor_of_slivers_to_1e4", run: tilted_floor_of_slivers_to_1e4 },
    Check { group: "geometry", what: "huge_ground_to_1e6", run: huge_ground_to_1e6 },
    Check { group: "geometry", what: "tilted_huge_ground_to_1e4", run: tilted_huge_ground_to_1e4 },
    Check { group: "geometry", what: "duplicates_change_nothing", run: duplicates_change_nothing },
    Check { group: "geometry", what: "coplanar_faces", run: coplanar_faces },
    Check { group: "geometry", what: "floor_about_a_vertex_of_1e4", run: floor_about_a_vertex_of_1e4 },
];

/// Scenes at which the engines are compared.
pub const CASES: &[(&str, &[f64])] = &[
    ("corridor", &[1e2]),
    ("corridor", &[1e3]),
    ("corridor", &[1e4]),
    ("corridor", &[1e6]),
    ("hollow", &[1.0, 1.0, 1e3, 1.0, 1.0, 0.0]),
    ("hollow", &[1.0, 1.0, 1e-7, 0.0, 1.0, 0.0]),
    ("hollow", &[1.0, 1.0, 1.0, 1.0, 1.0, 1e3]),
    ("cylinder", &[60.0, 10.0, 1.0]),
    ("spindle", &[300.0]),
    ("room_on_ground", &[1e6]),
    ("sliver_floor", &[2e-3, 65.0, 1.0]),
    ("sliver_floor", &[2e-7, 65.0, 0.0]),
    ("ground", &[1e6, 0.0]),
    ("ground", &[1e4, 1.0]),
    ("overlapping", &[5.0, 1.0]),
    ("fan", &[1000.0]),
];

/// Rays a check of closed meshes shoots by default. Where hundreds of slivers meet in one vertex a ray asks
/// most of them, each in f64: fewer there.
const RAYS: u64 = 2_000_000;

/// Paths that leave closed meshes of white walls, of so many bounces.
fn leaks(effort: &Effort, rays: u64, meshes: &[(&str, &[f64])], what: &str) -> Result<Outcome> {
    leaks_at_most(0.0, effort, rays, meshes, what)
}

/// [`leaks`], of which a part of `share` may leave.
fn leaks_at_most(share: f64, effort: &Effort, rays: u64, meshes: &[(&str, &[f64])], what: &str) -> Result<Outcome> {
    const DEPTH: u32 = 250;
    let (mut left, mut bounces, mut notes, mut trace) = (0.0, 0, Vec::new(), None);
    for &(name, numbers) in meshes {
        let trial = Trial::new(name, numbers)?;
        let paths = effort.cases(rays) / meshes.len() as u64 / u64::from(DEPTH);
        let side = [16u32, 8, 4].into_iter().find(|&side| u64::from(side * side) <= paths).unwrap_or(4);
        let spp = (paths / u64::from(side * side)).clamp(1, 1 << 24) as u32;
        let settings =
            Settings { strategy: Strategy::Bsdf, max_depth: Some(DEPTH), rr_depth: None, ..small(side, spp) };
        let render = trial.render(&settings);
        // Every path that leaves has found radiance 1.
        let lost = (render.film.mean_radiance()[0] * render.stats.paths as f64).round();
        if lost > 0.0 {
            let pixel = render.film.pixels.iter().position(|pixel| pixel.sum[0] > 0.0).unwrap_or(0) as u32;
            notes.push(format!("{}: {lost} of {:.1e}", trial.prepared.name, render.stats.rays.bounce as f64));
            trace = trace.or(leaking_sample(&trial, &settings, (pixel % side, pixel / side)));
        }
        left += lost + render.stats.nonfinite as f64;
        bounces += render.stats.rays.bounce;
    }
    Ok(Outcome::at_most(left, (share * bounces as f64).floor())
        .tried(bounces, format!("rays in {what}, paths that leave"))
        .note(notes.join(", "))
        .trace(trace))
}

/// The command that shows the first path of `pixel` that finds light.
fn leaking_sample(trial: &Trial, settings: &Settings, pixel: (u32, u32)) -> Option<String> {
    let setup = crate::setup::Setup::new(&trial.prepared, settings);
    let lit = |&sample: &u32| {
        let mut nobody = crate::reference::single::observer::Unobserved;
        crate::reference::single::path::trace_path(&setup, pixel, sample, &mut nobody).radiance.x > 0.0
    };
    let sample = (0..settings.spp.min(1000)).find(lit)?;
    Some(trial.trace(settings, pixel, sample))
}

fn leaks_of_corridors_to_1e6(effort: &Effort) -> Result<Outcome> {
    let lengths = [[1.0], [1e2], [1e3], [1e4], [1e5], [1e6]];
    let meshes: Vec<(&str, &[f64])> = lengths.iter().map(|length| ("corridor", &length[..])).collect();
    leaks(effort, RAYS, &meshes, "corridors 1 wide, 1 to 1e6 long")
}

fn leaks_of_tilted_corridors_to_1e4(effort: &Effort) -> Result<Outcome> {
    let lengths = [1e1, 1e2, 1e3, 1e4].map(|length| [1.0, 1.0, length, 1.0, 1.0, 0.0]);
    let meshes: Vec<(&str, &[f64])> = lengths.iter().map(|numbers| ("hollow", &numbers[..])).collect();
    leaks(effort, RAYS, &meshes, "tilted corridors 1 wide, 10 to 1e4 long")
}

fn leaks_of_thin_boxes(effort: &Effort) -> Result<Outcome> {
    let boxes = [1e-3, 1e-5, 1e-7].map(|thickness| [1.0, 1.0, thickness, 0.0, 1.0, 0.0]);
    let meshes: Vec<(&str, &[f64])> = boxes.iter().map(|numbers| ("hollow", &numbers[..])).collect();
    leaks(effort, RAYS, &meshes, "boxes 1e-3 to 1e-7 thin")
}

fn leaks_of_a_cylinder(effort: &Effort) -> Result<Outcome> {
    let what = "cylinders of 1,000 facets and length 100";
    leaks(effort, RAYS / 10, &[("cylinder", &[1000.0, 100.0, 0.0]), ("cylinder", &[1000.0, 100.0, 1.0])], what)
}

fn leaks_of_cubes_anywhere(effort: &Effort) -> Result<Outcome> {
    let cubes = [
        [1.0, 1.0, 1.0, 0.0, 1.0, 0.0],
        [1.0, 1.0, 1.0, 1.0, 1.0, 0.0],
        [1.0, 1.0, 1.0, 1.0, 1e-9, 0.0],
        [1.0, 1.0, 1.0, 1.0, 1e9, 0.0],
        [1.0, 1.0, 1.0, 1.0, 1.0, 1e1],
        [1.0, 1.0, 1.0, 1.0, 1.0, 1e3],
        [1.0, 1.0, 1.0, 1.0, 1.0, 1e4],
        [1.0, 1.0, 1.0, 0.0, 1.0, 1e5],
    ];
    let meshes: Vec<(&str, &[f64])> = cubes.iter().map(|numbers| ("hollow", &numbers[..])).collect();
    leaks(effort, RAYS, &meshes, "cubes tilted, 1e-9 to 1e9 large, up to 1e5 sizes away")
}

fn leaks_of_balls_and_wedges(effort: &Effort) -> Result<Outcome> {
    let meshes: &[(&str, &[f64])] = &[
        ("hollow_ball", &[3.0, 0.0]),
        ("hollow_ball", &[5.0, 100.0]),
        ("hollow_wedge", &[60.0]),
        ("hollow_wedge", &[30.0]),
    ];
    leaks(effort, RAYS, meshes, "balls and wedges of 30 and 60 degrees")
}

fn leaks_at_a_vertex_of_1e4(effort: &Effort) -> Result<Outcome> {
    leaks(effort, RAYS / 50, &[("spindle", &[10_000.0])], "a double cone of 20,000 triangles")
}

fn leaks_where_walls_cross_a_huge_ground(effort: &Effort) -> Result<Outcome> {
    let grounds = [[1e1], [1e3], [1e5], [1e6]];
    let meshes: Vec<(&str, &[f64])> = grounds.iter().map(|half| ("room_on_ground", &half[..])).collect();
    // Wall and ground share no edge: whoever hits the line where they cross to the last bit may stand on either side.
    leaks_at_most(1e-7, effort, RAYS, &meshes, "a room whose walls cross a ground of 1e1 to 1e6")
}

/// Rays at vertices and edges, by every walk.
fn aimed_rays_from_inside(effort: &Effort) -> Result<Outcome> {
    // Where hundreds of slivers meet in one vertex, fewer.
    let meshes: [(&str, &[f64], u64); 7] = [
        ("corridor", &[1.0], 40_000),
        ("corridor", &[1e3], 40_000),
        ("hollow", &[1.0, 1.0, 1e3, 1.0, 1.0, 0.0], 40_000),
        ("hollow", &[1.0, 1.0, 1e-5, 0.0, 1.0, 0.0], 40_000),
        ("cylinder", &[1000.0, 100.0, 1.0], 2000),
        ("hollow_ball", &[4.0, 10.0], 40_000),
        ("spindle", &[10_000.0], 1000),
    ];
    let (mut misses, mut count, mut notes) = (0, 0, Vec::new());
    for (seed, (name, numbers, usual)) in meshes.into_iter().enumerate() {
        let trial = Trial::new(name, numbers)?;
        let eye = DVec3::from(trial.scene.desc.camera.position);
        let shot = effort.cases(usual);
        let missed = misses_from_inside(&trial.prepared, eye, shot, seed as u32);
        if missed > 0 {
            notes.push(format!("{}: {missed} of {shot}", trial.prepared.name));
        }
        (misses, count) = (misses + missed, count + shot);
    }
    Ok(Outcome::at_most(misses as f64, 0.0)
        .tried(count, "rays in 7 closed meshes, most of them at vertices and edges, misses by any walk")
        .note(notes.join(", ")))
}

fn rays_off_their_triangles(effort: &Effort) -> Result<Outcome> {
    let meshes: [(&str, &[f64]); 8] = [
        ("room", &[1.0, 0.0, 1.0 / 2048.0]),
        ("room", &[1.0, 1e3, 1.0 / 2048.0]),
        ("hollow_ball", &[4.0, 0.0]),
        ("hollow_ball", &[4.0, 1e3]),
        ("hollow_wedge", &[10.0]),
        ("corridor", &[1e4]),
        ("cylinder", &[100.0, 10.0, 1.0]),
        ("room_on_ground", &[1e5]),
    ];
    let (mut hits, mut count, mut notes) = ([0; 2], 0, Vec::new());
    for (seed, (name, numbers)) in meshes.into_iter().enumerate() {
        let trial = Trial::new(name, numbers)?;
        let (hit, shot) = self_hits(&trial.prepared, effort.cases(10_000), seed as u32);
        if hit != [0; 2] {
            notes.push(format!("{}: {} in f32, {} in f64 of {shot}", trial.prepared.name, hit[0], hit[1]));
        }
        (hits, count) = ([hits[0] + hit[0], hits[1] + hit[1]], count + 2 * shot);
    }
    // In f64 offsets are those of f64, and slivers are tested no better than that: a note.
    Ok(Outcome::at_most(hits[0] as f64, 0.0)
        .tried(count, "rays off 8 meshes in f32 and f64, those in f32 that hit again the triangle they leave")
        .note(notes.join(", ")))
}

/// Strips 20 long: of an aspect of 20 over their width.
fn floor_of_slivers_to_1e8(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(16, 8));
    for width in [2e-1, 2e-2, 2e-3, 2e-4, 2e-5, 2e-6, 2e-7] {
        lit.add("sliver_floor", &[width, 65.0, 0.0], &[Strategy::Nee, Strategy::MisPower, Strategy::Bsdf], spp, 1e-4)?;
    }
    Ok(lit.outcome("floors of strips of aspect 1e2 to 1e8"))
}

fn tilted_floor_of_slivers_to_1e4(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(32, 8));
    for width in [2e-1, 2e-2, 2e-3] {
        lit.add("sliver_floor", &[width, 65.0, 1.0], &[Strategy::Nee, Strategy::MisPower, Strategy::Bsdf], spp, 1e-3)?;
    }
    Ok(lit.outcome("tilted floors of strips of aspect 1e2 to 1e4"))
}

fn ground(effort: &Effort, halves: &[f64], tilted: f64, what: &str) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for &half in halves {
        lit.add("ground", &[half, tilted], &[Strategy::Nee, Strategy::MisPower, Strategy::Bsdf], spp, 1e-3)?;
    }
    Ok(lit.outcome(what))
}

fn huge_ground_to_1e6(effort: &Effort) -> Result<Outcome> {
    ground(effort, &[1e1, 1e2, 1e3, 1e4, 1e5, 1e6], 0.0, "a lamp over grounds of 1e1 to 1e6")
}

fn tilted_huge_ground_to_1e4(effort: &Effort) -> Result<Outcome> {
    ground(effort, &[1e1, 1e2, 1e3, 1e4], 1.0, "a lamp over tilted grounds of 1e1 to 1e4")
}

/// A room with all its triangles a second time behind them, as they are, with their corners in another order, and reversed.
fn duplicates_change_nothing(effort: &Effort) -> Result<Outcome> {
    let scene = Trial::new("room", &[1.0, 0.0, 1.0 / 2048.0])?.scene;
    let settings = Settings { max_depth: Some(6), ..small(24, effort.samples(16, 4)) };
    // Nothing that shines: a lamp that is there twice is another row.
    let wanted = |scene: &crate::scene::SceneDesc, copies: &dyn Fn([u32; 3]) -> Option<[u32; 3]>| {
        let mut scene = scene.clone();
        let shines: Vec<bool> = scene.materials.iter().map(|material| material.emission[0] > 0.0).collect();
        let triangles = scene.meshes[0].triangles.clone();
        let dark = triangles.iter().filter(|triangle| !shines[triangle.material as usize]);
        let copy = |triangle: &crate::scene::desc::TriangleDesc| {
            copies(triangle.vertices).map(|vertices| crate::scene::desc::TriangleDesc { vertices, ..*triangle })
        };
        scene.meshes[0].triangles.extend(dark.filter_map(copy));
        PreparedScene::new(&scene)
    };
    let once = wanted(&scene.desc, &|_| None)?;
    let film = crate::render::render(&once, &settings).film;
    let mut differing = Differing::default();
    type Copied = dyn Fn([u32; 3]) -> Option<[u32; 3]>;
    let copies: [(&str, &Copied); 3] = [
        ("as they are", &|corners| Some(corners)),
        ("turned", &|[a, b, c]| Some([b, c, a])),
        ("reversed", &|[a, b, c]| Some([a, c, b])),
    ];
    for (what, copies) in copies {
        let twice = wanted(&scene.desc, copies)?;
        differing.add(what, &twice, &settings, [&crate::render::render(&twice, &settings).film, &film]);
    }
    Ok(Outcome::at_most(differing.pixels as f64, 0.0)
        .tried(differing.samples, "samples of a room doubled in 3 ways, pixels with other bits")
        .note(differing.what))
}

fn coplanar_faces(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for layers in [2.0, 5.0, 20.0] {
        for reversed in [0.0, 1.0] {
            let strategies = &[Strategy::Nee, Strategy::MisPower, Strategy::Bsdf];
            lit.add("overlapping", &[layers, reversed], strategies, spp, 1e-4)?;
        }
    }
    Ok(lit.outcome("2 to 20 floors in one tilted plane"))
}

fn floor_about_a_vertex_of_1e4(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(16, 8));
    for count in [3.0, 100.0, 10_000.0] {
        lit.add("fan", &[count], &[Strategy::Nee, Strategy::MisPower, Strategy::Bsdf], spp, 1e-4)?;
    }
    Ok(lit.outcome("floors about a vertex of 3 to 10,000 triangles"))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (
            LostTriangle,
            &[
                "geometry/leaks_of_corridors_to_1e6",
                "geometry/leaks_of_tilted_corridors_to_1e4",
                "geometry/leaks_of_boxes_to_1e-7_thin",
                "geometry/leaks_of_a_cylinder",
                "geometry/leaks_of_balls_and_wedges",
                "geometry/leaks_at_a_vertex_of_1e4",
                "geometry/leaks_where_walls_cross_a_huge_ground",
                "geometry/aimed_rays_from_inside",
            ],
        ),
        (KeptCopies, &["geometry/duplicates_change_nothing"]),
        (WrongOffset, &["geometry/leaks_of_cubes_anywhere", "geometry/rays_off_their_triangles"]),
        (
            MissingCosine,
            &[
                "geometry/floor_of_slivers_to_1e8",
                "geometry/tilted_floor_of_slivers_to_1e4",
                "geometry/huge_ground_to_1e6",
                "geometry/tilted_huge_ground_to_1e4",
                "geometry/coplanar_faces",
                "geometry/floor_about_a_vertex_of_1e4",
            ],
        ),
    ]
};
