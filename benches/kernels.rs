//! Every lane kernel beside its scalar twin: wall time for 1,000 items, so microseconds read as nanoseconds an item.
//!
//! `cargo bench --bench kernels`. Each pair is first checked to give the same bits on all its inputs. Results go through
//! memory on both sides. Lane kernels are always inlined; a larger scalar twin is called, as it is in the reference.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use octray::internal::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8, sin_cos_turns as sin_cos_turns_x8};
use octray::internal::math::sin_cos_turns;
use octray::internal::reference::single::lights::sample::sample_light;
use octray::internal::reference::single::surface::{SurfacePoint, surface_point};
use octray::internal::reference::single::{Vec3, mis, warp};
use octray::internal::sampler::{random_words, unit};
use octray::internal::simd::native::kernels::lights::sample::sample_lights;
use octray::internal::simd::native::kernels::surface::{SurfacePoints, surface_points};
use octray::internal::simd::native::kernels::{mis as mis_x8, warp as warp_x8};
use octray::internal::simd::native::numbers::{random_words_x8, unit_x8};
use octray::internal::tables::lights::table::LightTable;
use octray::{Lights, PreparedScene, Scene};
use std::hint::black_box;
use std::time::Duration;

/// Items a benchmark: whole blocks of eight, and a round number.
const ITEMS: usize = 1000;

/// Inputs of one kind, for both twins: one array a column, random numbers in [0, 1).
struct Columns(Vec<[f32; ITEMS]>);

impl Columns {
    fn new(columns: u32) -> Columns {
        let number = |item: usize, column: u32| unit(random_words(item as u32, 0, column, 5)[0]);
        Columns((0..columns).map(|column| std::array::from_fn(|item| number(item, column))).collect())
    }
    fn lanes(&self, column: usize, first: usize) -> F32x8 {
        F32x8::load(&self.0[column], first)
    }
    fn vector(&self, column: usize, item: usize) -> [f32; 3] {
        [0, 1, 2].map(|axis| self.0[column + axis][item])
    }
    fn vectors(&self, column: usize, first: usize) -> Vec3x8 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.lanes(column + axis, first));
        Vec3x8::new(x, y, z)
    }
}

/// Random unit vectors.
fn directions() -> Columns {
    let mut columns = Columns::new(3);
    for item in 0..ITEMS {
        let v = columns.vector(0, item).map(|c| f64::from(c) - 0.5);
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        for (column, c) in columns.0.iter_mut().zip(v) {
            column[item] = (c / length) as f32;
        }
    }
    columns
}

/// Checks that both twins give the same bits, then times them.
fn twins<const K: usize>(
    criterion: &mut Criterion,
    name: &str,
    lanes: impl Fn(usize) -> [F32x8; K],
    scalar: impl Fn(usize) -> [f32; K],
) {
    for first in (0..ITEMS).step_by(LANES) {
        let values = lanes(first).map(F32x8::to_array);
        for lane in 0..LANES {
            let (of_lane, wanted) = (values.map(|value| value[lane].to_bits()), scalar(first + lane).map(f32::to_bits));
            assert_eq!(of_lane, wanted, "{name}: item {}", first + lane);
        }
    }
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(ITEMS as u64));
    group.bench_function("lanes", |b| {
        b.iter(|| {
            for first in (0..ITEMS).step_by(LANES) {
                black_box(lanes(black_box(first)));
            }
        })
    });
    group.bench_function("scalar", |b| {
        b.iter(|| {
            for item in 0..ITEMS {
                black_box(scalar(black_box(item)));
            }
        })
    });
    group.finish();
}

fn columns3(v: Vec3x8) -> [F32x8; 3] {
    [v.x, v.y, v.z]
}

fn numbers(criterion: &mut Criterion) {
    let (pixels, samples) = (std::array::from_fn::<u32, ITEMS, _>(|i| i as u32 * 977), [3; ITEMS]);
    twins(
        criterion,
        "sampler words",
        |first| {
            let (pixel, sample) = (U32x8::load(&pixels, first), U32x8::load(&samples, first));
            random_words_x8(pixel, sample, 2, 9).map(unit_x8)
        },
        |item| random_words(pixels[item], samples[item], 2, 9).map(unit),
    );
    let columns = Columns::new(2);
    twins(
        criterion,
        "sin and cos",
        |first| sin_cos_turns_x8(columns.lanes(0, first)).into(),
        |item| sin_cos_turns(columns.0[0][item]).into(),
    );
    let densities = |column: usize, first: usize| columns.lanes(column, first) * F32x8::splat(4.0) + F32x8::ONE;
    let density = |column: usize, item: usize| columns.0[column][item] * 4.0 + 1.0;
    twins(
        criterion,
        "mis weights",
        |first| {
            let (a, b) = (densities(0, first), densities(1, first));
            [mis_x8::balance(a, b), mis_x8::power(a, b)]
        },
        |item| {
            let (a, b) = (density(0, item), density(1, item));
            [mis::balance(a, b), mis::power(a, b)]
        },
    );
}

fn warps(criterion: &mut Criterion) {
    let (columns, normals) = (Columns::new(2), directions());
    let pairs = |first: usize| [columns.lanes(0, first), columns.lanes(1, first)];
    let pair = |item: usize| [columns.0[0][item], columns.0[1][item]];
    twins(
        criterion,
        "warp to cosine hemisphere",
        |first| columns3(warp_x8::sample_cosine_hemisphere(pairs(first))),
        |item| warp::sample_cosine_hemisphere(pair(item)).to_array(),
    );
    twins(
        criterion,
        "warp to uniform hemisphere",
        |first| columns3(warp_x8::sample_uniform_hemisphere(pairs(first))),
        |item| warp::sample_uniform_hemisphere(pair(item)).to_array(),
    );
    twins(
        criterion,
        "warp to triangle",
        |first| warp_x8::sample_uniform_triangle(pairs(first)),
        |item| warp::sample_uniform_triangle(pair(item)),
    );
    let local = Vec3::new(0.48, -0.6, 0.64);
    twins(
        criterion,
        "frame to world",
        |first| columns3(warp_x8::to_world(Vec3x8::splat(local.to_array()), normals.vectors(0, first))),
        |item| warp::to_world(local, Vec3::from(normals.vector(0, item))).to_array(),
    );
}

/// Hits on random triangles of the Cornell box.
struct Hits {
    ids: [u32; ITEMS],
    weights: Columns,
    directions: Columns,
}

impl Hits {
    fn new(scene: &PreparedScene) -> Hits {
        let count = scene.triangles.len() as u32;
        Hits {
            ids: std::array::from_fn(|item| random_words(item as u32, 1, 0, 5)[0] % count),
            weights: Columns::new(2),
            directions: directions(),
        }
    }
    fn points(&self, scene: &PreparedScene, first: usize) -> SurfacePoints {
        let half = F32x8::splat(0.5);
        let (u, v) = (self.weights.lanes(0, first) * half, self.weights.lanes(1, first) * half);
        surface_points::<false>(
            (&scene.triangles, &[]),
            U32x8::load(&self.ids, first),
            u,
            v,
            self.directions.vectors(0, first),
        )
    }
    fn point(&self, scene: &PreparedScene, item: usize) -> SurfacePoint {
        let (u, v) = (self.weights.0[0][item] * 0.5, self.weights.0[1][item] * 0.5);
        let direction = Vec3::from(self.directions.vector(0, item));
        surface_point(&scene.triangles[self.ids[item] as usize], None, u, v, direction)
    }
}

fn surfaces_and_lights(criterion: &mut Criterion) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
    let scene = Scene::load(path).and_then(|scene| scene.prepare()).expect("the Cornell box");
    let hits = Hits::new(&scene);
    twins(
        criterion,
        "surface points",
        |first| {
            let points = hits.points(&scene, first);
            let [[a, b, c], [d, e, f]] = [points.origin, points.normal].map(columns3);
            [a, b, c, d, e, f]
        },
        |item| {
            let point = hits.point(&scene, item);
            let [[a, b, c], [d, e, f]] = [point.origin, point.normal].map(|v| v.to_array());
            [a, b, c, d, e, f]
        },
    );
    let lights = LightTable::new(&scene, Lights::Uniform, false);
    let blocks: Vec<SurfacePoints> = (0..ITEMS).step_by(LANES).map(|first| hits.points(&scene, first)).collect();
    let points: Vec<SurfacePoint> = (0..ITEMS).map(|item| hits.point(&scene, item)).collect();
    let words: [[u32; ITEMS]; 4] =
        std::array::from_fn(|word| std::array::from_fn(|item| random_words(item as u32, 2, 0, 5)[word]));
    twins(
        criterion,
        "light sample on a triangle",
        |first| {
            let words = [0, 1, 2, 3].map(|word| U32x8::load(&words[word], first));
            let light = sample_lights(&lights, &blocks[first / LANES], U32x8::ZERO, Mask8::ALL, &words.into());
            let [x, y, z] = columns3(light.shadow_direction);
            // Samples that cannot contribute hold anything on lanes and nothing in the reference.
            let valid: Mask8 = light.valid;
            [light.pdf_dir, light.cosine, x, y, z].map(|value| valid.select(value, F32x8::ZERO))
        },
        |item| {
            sample_light(&lights, &points[item], 0, &words.map(|word| word[item]).into()).map_or([0.0; 5], |light| {
                let [x, y, z] = light.shadow_direction.to_array();
                [light.pdf_dir, light.cosine, x, y, z]
            })
        },
    );
}

fn short() -> Criterion {
    let moment = Duration::from_millis(300);
    Criterion::default().warm_up_time(moment).measurement_time(2 * moment).sample_size(30)
}

criterion_group! {
    name = kernels;
    config = short();
    targets = numbers, warps, surfaces_and_lights
}
criterion_main!(kernels);
