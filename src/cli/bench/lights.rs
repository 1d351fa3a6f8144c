//! Light samples: choosing a light and a point on it, and points on triangles by area and by solid angle.
//!
//! The points that ask lie anywhere on the scene's triangles, a little off them, as the renderer's rays start.

use crate::cli::bench::measure::{Case, Row, share};
use crate::clock::thread_cpu_seconds;
use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use crate::reference::single::lights::sample::sample_light;
use crate::reference::single::lights::triangle::solid_angle;
use crate::reference::single::surface::{SurfacePoint, surface_point};
use crate::reference::single::{vec3, warp};
use crate::sampler::{index_below, random_words, unit};
use crate::settings::Lights;
use crate::simd::native::kernels::lights::sample::sample_lights;
use crate::simd::native::kernels::lights::triangle::{SolidAngles, solid_angles};
use crate::simd::native::kernels::records::LightColumns;
use crate::simd::native::kernels::surface::{SurfacePoints, surface_points};
use crate::simd::native::kernels::warp::sample_uniform_triangle;
use crate::simd::native::numbers::unit_x8;
use crate::tables::PreparedScene;
use crate::tables::lights::table::{LightRecord, LightTable};
use std::hint::black_box;

/// Samples a round.
const SAMPLES: u32 = 1 << 16;
/// Points that ask, in turn.
const POINTS: u32 = 1 << 12;

/// What asks for light samples, once as the packet engine holds it and once as the scalar one does.
struct Askers {
    lanes: Vec<(SurfacePoints, [U32x8; 4])>,
    scalar: Vec<(SurfacePoint, [u32; 4])>,
}

impl Askers {
    fn new(scene: &PreparedScene) -> Askers {
        let place = |i: u32| {
            let words = random_words(i, 1, 0, 0);
            (index_below(words[0], scene.triangles.len() as u32), unit(words[1]) * 0.5, unit(words[2]) * 0.5)
        };
        // Seen against the normal: from the front.
        let seen = |triangle: u32| scene.triangles[triangle as usize].normal.map(|x| -x);
        let words = |i: u32| random_words(i, 2, 0, 0);
        let block = |first: usize| {
            let places: [_; LANES] = std::array::from_fn(|lane| place((first + lane) as u32));
            let column = |of: fn(&(u32, f32, f32)) -> f32| F32x8::from_array(places.each_ref().map(of));
            let triangle = U32x8::from_array(places.map(|place| place.0));
            let axis = |axis: usize| F32x8::from_array(places.map(|place| seen(place.0)[axis]));
            let direction = Vec3x8::new(axis(0), axis(1), axis(2));
            let tables = (&scene.triangles[..], &scene.corners[..]);
            let points = surface_points::<false>(tables, triangle, column(|p| p.1), column(|p| p.2), direction);
            let word = |k: usize| U32x8::from_array(std::array::from_fn(|lane| words((first + lane) as u32)[k]));
            (points, std::array::from_fn(word))
        };
        let single = |i: u32| {
            let (triangle, u, v) = place(i);
            let point = surface_point(&scene.triangles[triangle as usize], None, u, v, vec3(seen(triangle)));
            (point, words(i))
        };
        Askers {
            lanes: (0..POINTS as usize).step_by(LANES).map(block).collect(),
            scalar: (0..POINTS).map(single).collect(),
        }
    }
}

/// Nanoseconds a sample and the share of lanes whose sample can contribute; `round` draws [`POINTS`] samples and counts
/// those.
fn timed(what: &str, engine: &'static str, lanes: bool, mut round: impl FnMut() -> u32) -> Vec<Row> {
    let start = thread_cpu_seconds();
    let used: u64 = (0..SAMPLES / POINTS).map(|_| u64::from(black_box(round()))).sum();
    let seconds = thread_cpu_seconds() - start;
    vec![Row {
        what: what.to_owned(),
        engine,
        ns_per_item: Some(seconds * 1e9 / f64::from(SAMPLES)),
        clock: "cpu",
        lanes_used: if lanes { share(used, u64::from(SAMPLES)) } else { None },
        items: u64::from(SAMPLES),
        ..Row::default()
    }]
}

/// The cases of a scene's lights; none if it has no emissive triangle.
pub fn cases(scene: &PreparedScene) -> Vec<Case<'_>> {
    let mut cases: Vec<Case> = Vec::new();
    if scene.emitters.is_empty() {
        return cases;
    }
    for &selection in Lights::ALL {
        let what = format!("light sample ({})", selection.name());
        let table = || (LightTable::new(scene, selection, false), Askers::new(scene), what.clone());
        let (lights, askers, name) = table();
        cases.push(Box::new(move || {
            timed(&name, "packet", true, || {
                let sample = |(points, words): &(SurfacePoints, [U32x8; 4])| {
                    sample_lights(&lights, points, U32x8::ZERO, Mask8::ALL, &(*words).into()).valid.count()
                };
                askers.lanes.iter().map(sample).sum()
            })
        }));
        let (lights, askers, name) = table();
        cases.push(Box::new(move || {
            timed(&name, "scalar", false, || {
                let sample = |(point, words): &(SurfacePoint, [u32; 4])| {
                    u32::from(sample_light(&lights, point, 0, &(*words).into()).is_some())
                };
                askers.scalar.iter().map(sample).sum()
            })
        }));
    }
    cases.extend(point_cases(scene));
    cases
}

/// Stands for the density by area, so that solid angles are used wherever they can be told.
const ANY_DISTANCE: f32 = 0.0;

/// Points on triangles in both ways; the lanes used are those that a solid angle is told for.
fn point_cases(scene: &PreparedScene) -> Vec<Case<'_>> {
    let records = || LightTable::new(scene, Lights::Uniform, false).records;
    let chosen = |word: u32, records: &[LightRecord]| index_below(word, records.len() as u32);
    let columns = move |words: &[U32x8; 4], records: &[LightRecord]| {
        LightColumns::gather(records, U32x8::from_array(words[0].to_array().map(|word| chosen(word, records))))
    };
    let numbers = |words: &[U32x8; 4]| [unit_x8(words[1]), unit_x8(words[2])];
    let seen = move |points: &SurfacePoints, words: &[U32x8; 4], records: &[LightRecord]| -> SolidAngles {
        solid_angles(&columns(words, records).vertices, F32x8::splat(ANY_DISTANCE), points.origin)
    };
    let (askers, table) = (Askers::new(scene), records());
    let lanes_by_area = move || {
        timed("point by area", "packet", true, || {
            let draw = |(_, words): &(SurfacePoints, [U32x8; 4])| {
                black_box((columns(words, &table).vertices[0].x, sample_uniform_triangle(numbers(words))));
                LANES as u32
            };
            askers.lanes.iter().map(draw).sum()
        })
    };
    let (askers, table) = (Askers::new(scene), records());
    let lanes_by_solid_angle = move || {
        timed("point by solid angle", "packet", true, || {
            let draw = |(points, words): &(SurfacePoints, [U32x8; 4])| {
                let seen = seen(points, words, &table);
                black_box((seen.sample(numbers(words)), seen.pdf_dir(F32x8::ONE)));
                seen.chosen().count()
            };
            askers.lanes.iter().map(draw).sum()
        })
    };
    let (askers, table) = (Askers::new(scene), records());
    let scalar_by_area = move || {
        timed("point by area", "scalar", false, || {
            for (_, words) in &askers.scalar {
                let record = &table[chosen(words[0], &table) as usize];
                black_box((record.vertices[0], warp::sample_uniform_triangle([unit(words[1]), unit(words[2])])));
            }
            POINTS
        })
    };
    let (askers, table) = (Askers::new(scene), records());
    let scalar_by_solid_angle = move || {
        timed("point by solid angle", "scalar", false, || {
            for (point, words) in &askers.scalar {
                let record = &table[chosen(words[0], &table) as usize];
                let seen = solid_angle(&record.vertices, ANY_DISTANCE, point.origin);
                black_box(seen.map(|seen| (seen.sample([unit(words[1]), unit(words[2])]), seen.pdf_dir(1.0))));
            }
            POINTS
        })
    };
    vec![
        Box::new(lanes_by_area),
        Box::new(scalar_by_area),
        Box::new(lanes_by_solid_angle),
        Box::new(scalar_by_solid_angle),
    ]
}
