//! Every sampling routine against its density, on lanes and on the scalar twin (both in f32): Pearson's chi-square tests of
//! what is drawn, and densities that integrate to 1, or to the part that is drawn at all where some draws carry nothing.
//! Environment maps have theirs in tests/engines/environment.rs, lens and filters in tests/engines/camera.rs.
//!
//! Significance 0.1 % for the file (Sidak: 8e-6 each of 124 tests), by the Wilson-Hilferty normal form: z below 4.3.
//! Seeds are fixed.

use crate::common::{Maker, chi_square_z};
use glam::DVec3;
use octray::Lights;
use octray::internal::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use octray::internal::reference::single::lights::sample as light;
use octray::internal::reference::single::lights::tree::{Receiver, light_probability};
use octray::internal::reference::single::{Vec3, bsdf, surface, warp};
use octray::internal::sampler::draws::BsdfDraws;
use octray::internal::sampler::{random_words, unit};
use octray::internal::simd::native::kernels::bsdf::conductor::Conductor;
use octray::internal::simd::native::kernels::bsdf::plastic::Plastic;
use octray::internal::simd::native::kernels::bsdf::principled::Principled;
use octray::internal::simd::native::kernels::bsdf::{Bsdf, Sampled};
use octray::internal::simd::native::kernels::surface::surface_points;
use octray::internal::simd::native::kernels::{lights::sample as light_x8, warp as warp_x8};
use octray::internal::tables::lights::table::{LightTable, Selection};
use octray::internal::tables::materials::MaterialRecord;
use octray::scene::desc::{MaterialDesc, Scattering};
use std::f64::consts::TAU;

const SAMPLES: u32 = 64_000;
const MOST_Z: f64 = 4.3;

/// Eight directions, `None` where the draw carried nothing.
type Draws = [Option<DVec3>; LANES];

fn words(first: u32) -> [[u32; 4]; LANES] {
    std::array::from_fn(|lane| random_words(first + lane as u32, 11, 3, 2026))
}

fn column(words: &[[u32; 4]; LANES], c: usize) -> F32x8 {
    F32x8::from_array(words.map(|w| unit(w[c])))
}

fn lanes3(v: [DVec3; LANES]) -> Vec3x8 {
    let column = |of: fn(DVec3) -> f64| F32x8::from_array(v.map(|v| of(v) as f32));
    Vec3x8::new(column(|v| v.x), column(|v| v.y), column(|v| v.z))
}

fn wide(v: Vec3x8) -> [DVec3; LANES] {
    let (x, y, z) = (v.x.to_array(), v.y.to_array(), v.z.to_array());
    std::array::from_fn(|lane| glam::Vec3::new(x[lane], y[lane], z[lane]).as_dvec3())
}

/// Draws in cells of (z, turn about z) over the hemisphere of +z, against the integral of the density over each cell.
/// `whole`: every draw counts, so the density integrates to 1.
fn check(
    name: &str,
    whole: bool,
    draw: impl Fn(&[[u32; 4]; LANES]) -> Draws,
    pdf: impl Fn([DVec3; LANES]) -> [f64; LANES],
) {
    const ROWS: usize = 24;
    const COLUMNS: usize = 24;
    const FINE: usize = 8;
    let (mut counts, mut drawn) = (vec![0.0; ROWS * COLUMNS], 0.0);
    for first in (0..SAMPLES).step_by(LANES) {
        for direction in draw(&words(first)).into_iter().flatten() {
            let turn = direction.y.atan2(direction.x) / TAU + 0.5;
            assert!((direction.length() - 1.0).abs() < 1e-5 && direction.z >= 0.0, "{name}: {direction}");
            let row = ((direction.z * ROWS as f64) as usize).min(ROWS - 1);
            counts[row * COLUMNS + ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1)] += 1.0;
            drawn += 1.0;
        }
    }
    let solid_angle = TAU / (ROWS * COLUMNS * FINE * FINE) as f64;
    let expected: Vec<f64> = (0..ROWS * COLUMNS)
        .map(|cell| {
            let place =
                |cell: usize, k: usize, count: usize| (cell as f64 + (k as f64 + 0.5) / FINE as f64) / count as f64;
            let point = |k: usize| {
                let z = place(cell / COLUMNS, k / FINE, ROWS);
                let (sine, cosine) = ((place(cell % COLUMNS, k % FINE, COLUMNS) - 0.5) * TAU).sin_cos();
                DVec3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z)
            };
            let blocks = (0..FINE * FINE).step_by(LANES);
            let sum: f64 = blocks.map(|k| pdf(std::array::from_fn(|i| point(k + i))).iter().sum::<f64>()).sum();
            sum * solid_angle
        })
        .collect();
    let (total, part) = (expected.iter().sum::<f64>(), drawn / f64::from(SAMPLES));
    if whole {
        assert!(drawn == f64::from(SAMPLES) && (total - 1.0).abs() < 1e-4, "{name}: {part} drawn, density {total}");
    }
    let deviation = (part * (1.0 - part) / f64::from(SAMPLES)).sqrt();
    assert!((total - part).abs() < 5.0 * deviation + 2e-3, "{name}: the density integrates to {total}, drawn {part}");
    let expected: Vec<f64> = expected.iter().map(|share| share * f64::from(SAMPLES)).collect();
    let z = chi_square_z(&counts, &expected);
    println!("{name}: density integrates to {total:.4}, drawn {part:.4}, z {z:.2}");
    assert!(z < MOST_Z, "{name}: z = {z}");
}

#[test]
fn hemispheres_are_drawn_with_their_densities() {
    let pair = |words: &[[u32; 4]; LANES]| [column(words, 0), column(words, 1)];
    let each = |words: &[[u32; 4]; LANES], of: fn([f32; 2]) -> Vec3| {
        words.map(|w| Some(of([unit(w[0]), unit(w[1])]).as_dvec3()))
    };
    let cosines = |v: [DVec3; LANES]| F32x8::from_array(v.map(|v| v.z as f32));
    check(
        "cosine, lanes",
        true,
        |words| wide(warp_x8::sample_cosine_hemisphere(pair(words))).map(Some),
        |v| warp_x8::cosine_hemisphere_pdf_dir(cosines(v)).to_array().map(f64::from),
    );
    check(
        "cosine, scalar",
        true,
        |words| each(words, warp::sample_cosine_hemisphere),
        |v| v.map(|v| warp::cosine_hemisphere_pdf_dir(v.z as f32).into()),
    );
    let even = f64::from(octray::internal::math::INV_2PI);
    let uniform = |words: &[[u32; 4]; LANES]| wide(warp_x8::sample_uniform_hemisphere(pair(words))).map(Some);
    check("uniform, lanes", true, uniform, |_| [even; LANES]);
    let scalar = f64::from(warp::uniform_hemisphere_pdf_dir());
    check("uniform, scalar", true, |words| each(words, warp::sample_uniform_hemisphere), |_| [scalar; LANES]);
}

/// Uniform over the disk and over the triangle: cells of equal area, on lanes and scalar.
#[test]
fn disk_and_triangle_are_drawn_evenly() {
    const SIDE: usize = 16;
    let evenly = |name: &str, cell: &dyn Fn(&[[u32; 4]; LANES]) -> [usize; LANES]| {
        let mut counts = vec![0.0; SIDE * SIDE];
        for first in (0..SAMPLES).step_by(LANES) {
            cell(&words(first)).into_iter().for_each(|cell| counts[cell] += 1.0);
        }
        let z = chi_square_z(&counts, &vec![f64::from(SAMPLES) / (SIDE * SIDE) as f64; SIDE * SIDE]);
        assert!(z < MOST_Z, "{name}: z = {z}");
    };
    // Rings of equal area times sectors; bands parallel to a side, halved again and again in area, times shares of them.
    let index = |t: f64| ((t * SIDE as f64) as usize).min(SIDE - 1);
    let disk = |x: f64, y: f64| index(x * x + y * y) * SIDE + index(y.atan2(x) / TAU + 0.5);
    let triangle = |[a, b, c]: [f64; 3]| {
        assert!((a + b + c - 1.0).abs() < 1e-6 && a >= 0.0 && b >= 0.0 && c >= 0.0);
        index((1.0 - a) * (1.0 - a)) * SIDE + index(b / (b + c))
    };
    let pair = |words: &[[u32; 4]; LANES]| [column(words, 0), column(words, 1)];
    let u = |w: [u32; 4]| [unit(w[0]), unit(w[1])];
    evenly("disk, lanes", &|words| {
        let [x, y] = warp_x8::sample_uniform_disk(pair(words)).map(|c| c.to_array());
        std::array::from_fn(|i| disk(x[i].into(), y[i].into()))
    });
    evenly("disk, scalar", &|words| {
        words.map(|w| {
            let [x, y] = warp::sample_uniform_disk(u(w));
            disk(x.into(), y.into())
        })
    });
    evenly("triangle, lanes", &|words| {
        let weights = warp_x8::sample_uniform_triangle(pair(words)).map(|c| c.to_array());
        std::array::from_fn(|i| triangle(weights.map(|w| w[i].into())))
    });
    evenly("triangle, scalar", &|words| words.map(|w| triangle(warp::sample_uniform_triangle(u(w)).map(f64::from))));
}

fn check_glossy<B: Bsdf>(name: &str, record: &MaterialRecord, cosine: f32) {
    let wo = glam::Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let material = B::load(std::slice::from_ref(record), U32x8::ZERO);
    let wo_x8 = Vec3x8::splat(wo.to_array());
    check(
        &format!("{name} at {cosine}, lanes"),
        false,
        |words| {
            let [a, b, lobe, roulette] = [0, 1, 2, 3].map(|c| column(words, c));
            let sampled: Sampled = material.sample(wo_x8, &BsdfDraws { direction: [a, b], lobe, roulette });
            let (valid, wi) = (sampled.valid.bits(), wide(sampled.wi));
            std::array::from_fn(|i| (valid >> i & 1 == 1).then_some(wi[i]))
        },
        |v| material.evaluate(wo_x8, lanes3(v)).pdf_dir.to_array().map(f64::from),
    );
    check(
        &format!("{name} at {cosine}, scalar"),
        false,
        |words| {
            words.map(|w| {
                let u = [unit(w[0]), unit(w[1])];
                let sampled = bsdf::sample(record, Vec3::Z, -wo, true, u, unit(w[2]));
                sampled.map(|sampled| sampled.direction.as_dvec3())
            })
        },
        |v| v.map(|v| bsdf::evaluate(record, Vec3::Z, -wo, v.as_vec3()).1.into()),
    );
}

/// Lobes far narrower than a cell have no density a grid could integrate; their code is the same.
#[test]
fn glossy_lobes_are_drawn_with_their_densities() {
    for alpha in [0.15, 0.4, 1.0] {
        for cosine in [0.95, 0.5, 0.15] {
            let record = |scattering| MaterialRecord::new(&MaterialDesc { scattering, ..MaterialDesc::default() });
            let metal = record(Scattering::Conductor { alpha, reflectance: [0.9; 3], complex_ior: None });
            check_glossy::<Conductor>(&format!("metal, alpha {alpha}"), &metal, cosine);
            let plastic = record(Scattering::Plastic { albedo: [0.8, 0.5, 0.2], ior: 1.5, alpha });
            check_glossy::<Plastic>(&format!("plastic, alpha {alpha}"), &plastic, cosine);
            for metallic in [0.0, 0.5, 1.0] {
                let (base_color, roughness) = ([0.8, 0.5, 0.2], f64::sqrt(alpha));
                let mixed = record(Scattering::Principled { base_color, metallic, roughness, ior: 1.5 });
                check_glossy::<Principled>(&format!("principled, alpha {alpha}, metallic {metallic}"), &mixed, cosine);
            }
        }
    }
}

/// The solid angle of a triangle (Van Oosterom and Strackee 1983).
fn solid_angle(from: DVec3, corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|v| (DVec3::from(v.map(f64::from)) - from).normalize());
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Light samples: each emitter as often as its density says (chi-square), and the mean of 1 / pdf_dir over the samples of
/// an emitter is its solid angle (5 standard errors): the density integrates to 1 over what all emitters cover.
#[test]
fn lights_are_drawn_with_their_densities() {
    const LAMPS: usize = 12;
    let mut maker = Maker::default();
    let floor = maker.diffuse([0.5; 3], [0.0; 3]);
    maker.quad([[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]], floor);
    for i in 0..LAMPS {
        let (x, s) = (i as f32 - 6.0, 0.05 + 0.04 * i as f32);
        // The red channel says which lamp it is.
        let lamp = maker.diffuse([0.0; 3], [1.0 + i as f64, 20.0 / (1.0 + i as f64), 1.0]);
        let y = 1.0 + 0.1 * x * x;
        maker.quad([[x, y, -s], [x + 0.5, y, -s], [x + 0.5, y, s], [x, y, s]], lamp);
    }
    let scene = maker.seen([0.0, 2.0, 9.0], [0.0; 3], 50.0);
    let down = [0.0, -1.0, 0.0];
    let point = surface::surface_point(&scene.triangles[0], None, 0.25, 0.25, down.into());
    let (u, direction) = (F32x8::splat(0.25), Vec3x8::splat(down));
    let points = surface_points::<false>((&scene.triangles, &[]), U32x8::ZERO, u, u, direction);
    for &lights in Lights::ALL {
        let table = LightTable::new(&scene, lights, false);
        let lanes = |words: &[[u32; 4]; LANES]| -> [Option<(f32, f32)>; LANES] {
            let drawn = light_x8::sample_lights(
                &table,
                &points,
                U32x8::ZERO,
                Mask8::ALL,
                &[0, 1, 2, 3].map(|c| U32x8::from_array(words.map(|w| w[c]))).into(),
            );
            let (red, pdf, valid) = (drawn.radiance.x.to_array(), drawn.pdf_dir.to_array(), drawn.valid.bits());
            std::array::from_fn(|i| (valid >> i & 1 == 1).then_some((red[i], pdf[i])))
        };
        let scalar = |words: &[[u32; 4]; LANES]| {
            words.map(|w| {
                light::sample_light(&table, &point, 0, &w.into()).map(|drawn| (drawn.radiance.x, drawn.pdf_dir))
            })
        };
        for (name, draw) in [("lanes", &lanes as &dyn Fn(&_) -> _), ("scalar", &scalar)] {
            let mut sums = [(0.0, 0.0, 0.0); LAMPS];
            for first in (0..SAMPLES).step_by(LANES) {
                for (red, pdf) in draw(&words(first)).into_iter().map(|drawn| drawn.expect("every lamp is in sight")) {
                    let sum = &mut sums[(red - 0.5) as usize];
                    *sum = (sum.0 + 1.0, sum.1 + 1.0 / f64::from(pdf), sum.2 + 1.0 / f64::from(pdf).powi(2));
                }
            }
            let n = f64::from(SAMPLES);
            let receiver = Receiver { origin: point.origin, normal: point.normal, row: 0 };
            let share = |lamp: usize| -> f64 {
                let of = |light: usize| match table.selection {
                    Selection::Tree(tree) => f64::from(light_probability(tree, None, &receiver, light as u32)),
                    _ => f64::from(table.probability(light as u32)),
                };
                of(2 * lamp) + of(2 * lamp + 1)
            };
            let expected: Vec<f64> = (0..LAMPS).map(|lamp| n * share(lamp)).collect();
            assert!((expected.iter().sum::<f64>() / n - 1.0).abs() < 1e-5, "{lights}: chances add up to 1");
            let z = chi_square_z(&sums.map(|sum| sum.0), &expected);
            assert!(z < MOST_Z, "{lights}, {name}: z = {z}");
            for (lamp, &(_, sum, squares)) in sums.iter().enumerate() {
                let at = point.position.as_dvec3();
                let corners = |i: usize| scene.triangles[scene.emitters[i].triangle as usize].vertices;
                let truth = solid_angle(at, corners(2 * lamp)) + solid_angle(at, corners(2 * lamp + 1));
                let (mean, error) = (sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt());
                let what = format!("{lights}, {name}, lamp {lamp}: {mean} +- {error}, {truth} sr");
                assert!((mean - truth).abs() < 5.0 * error && error < 0.05 * truth, "{what}");
            }
        }
    }
}
