//! Light samples that are drawn so: the density that hits find, and the variance that is gained.

use super::views::*;
use crate::common::Maker;
use glam::{DVec3, Vec3};
use octray::Lights;
use octray::internal::lanes::{F32x8, Mask8, U32x8};
use octray::internal::reference::single;
use octray::internal::reference::single::lights::tree::{Receiver, choose_light};
use octray::internal::reference::single::lights::triangle::solid_angle;
use octray::internal::reference::single::warp::sample_uniform_triangle;
use octray::internal::sampler::random_words;
use octray::internal::simd::native::kernels::lights::sample as light_x8;
use octray::internal::simd::native::kernels::lights::tree::Receivers;
use octray::internal::simd::native::kernels::lights::triangle::solid_angles;
use octray::internal::simd::native::kernels::records::LightColumns;
use octray::internal::simd::native::kernels::surface::surface_points;
use octray::internal::tables::lights::table::{LightTable, Selection};

/// A floor, and above it a large lamp that is near, a small far one, a steep one and one that shines on both sides.
fn lamps() -> octray::PreparedScene {
    let mut maker = Maker::default();
    let floor = maker.diffuse([0.5; 3], [0.0; 3]);
    let lamp = maker.diffuse([0.0; 3], [1.0, 2.0, 4.0]);
    let both = maker.diffuse([0.0; 3], [3.0; 3]);
    maker.desc.materials[both as usize].two_sided = true;
    maker.quad([[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]], floor);
    maker.quad([[-1.0, 0.4, -1.0], [1.0, 0.4, -1.0], [1.0, 0.5, 1.0], [-1.0, 0.5, 1.0]], lamp);
    maker.quad([[-0.1, 3.0, -0.1], [0.1, 3.0, -0.1], [0.1, 3.0, 0.1], [-0.1, 3.0, 0.1]], lamp);
    maker.quad([[2.0, 0.1, 1.0], [2.0, 1.5, 1.0], [2.0, 1.5, -1.0], [2.0, 0.1, -1.0]], lamp);
    maker.quad([[-2.0, 0.1, -1.0], [-2.0, 1.5, -1.0], [-1.6, 1.5, 1.0], [-1.6, 0.1, 1.0]], both);
    maker.seen([0.0, 1.0, 5.0], [0.0, 0.5, 0.0], 40.0)
}

#[test]
fn hits_find_the_density_that_light_samples_were_drawn_with() {
    let scene = lamps();
    let (mut samples, mut by_angle) = (0, 0);
    for &selection in Lights::ALL {
        let lights = LightTable::new(&scene, selection, false);
        if selection != Lights::Tree {
            let total: f64 = (0..lights.records.len() as u32).map(|light| f64::from(lights.probability(light))).sum();
            assert!((total - 1.0).abs() < 1e-6, "{selection}: probabilities sum to {total}");
        }
        for i in 0..4_000 {
            let mut random = random(i);
            let (u, v) = (random() as f32 * 0.5, random() as f32 * 0.5);
            let down = -Vec3::Y;
            let point = single::surface::surface_point(&scene.triangles[i as usize % 2], None, u, v, down);
            let words = random_words(i, 9, 2, 4);
            let lane = |x: f32| F32x8::splat(x);
            let points = surface_points::<false>(
                (&scene.triangles, &scene.corners),
                U32x8::splat(i % 2),
                lane(u),
                lane(v),
                splat3(down),
            );
            let found =
                light_x8::sample_lights(&lights, &points, U32x8::ZERO, Mask8::ALL, &words.map(U32x8::splat).into());
            let sample = single::lights::sample::sample_light(&lights, &point, 0, &words.into());
            assert_eq!(found.valid.any(), sample.is_some());
            let Some(sample) = sample else { continue };
            assert!(found.valid.all());
            assert_eq!(found.pdf_dir.to_array()[7].to_bits(), sample.pdf_dir.to_bits());
            // The ray that a BSDF sample in this direction would be.
            let receiver = Receiver { origin: point.origin, normal: point.normal, row: 0 };
            let chosen = match &lights.selection {
                Selection::Tree(tree) => choose_light(tree, None, &receiver, words[0]).0,
                Selection::Fixed(fixed) => fixed.choose(words[0]),
            };
            let record = &lights.records[chosen as usize];
            let segment = sample.shadow_direction;
            let (t, direction) = (segment.length(), segment.normalize());
            let cosine = direction.dot(Vec3::from(record.normal)).abs();
            let pdf = single::lights::sample::light_pdf_dir(&lights, &receiver, chosen, t, cosine);
            let columns = LightColumns::gather(&lights.records, U32x8::splat(chosen));
            let lanes = light_x8::light_pdf_dir(
                &lights,
                (&Receivers { origin: points.origin, normal: points.normal, row: U32x8::ZERO }, Mask8::ALL),
                (U32x8::splat(chosen), &columns),
                lane(t),
                lane(cosine),
            );
            assert_eq!(lanes.to_array()[3].to_bits(), pdf.to_bits());
            let seen = solid_angle(&record.vertices, record.pdf_area(), point.origin);
            if seen.is_some_and(|seen| seen.part == 1.0) {
                assert_eq!(pdf.to_bits(), sample.pdf_dir.to_bits(), "the same number, not a close one");
                by_angle += 1;
            }
            // By area, the cosine of a ray along the light's plane has few digits, and a shadow ray ends a little off it.
            assert!((pdf / sample.pdf_dir - 1.0).abs() < 3e-2, "{pdf} {}", sample.pdf_dir);
            samples += 1;
        }
    }
    println!("{samples} light samples, {by_angle} of them by solid angle alone");
    assert!(samples > 4_000 && by_angle > 1_000 && by_angle < samples - 1_000);
}

/// Irradiance at `eye` with normal `normal` of a polygon of radiance 1, all above the horizon (Lambert 1760).
fn polygon_irradiance(eye: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let edge = |i: usize| {
        let (a, b) = ((corners[i] - eye).normalize(), (corners[(i + 1) % corners.len()] - eye).normalize());
        a.dot(b).acos() * a.cross(b).normalize().dot(normal)
    };
    0.5 * (0..corners.len()).map(edge).sum::<f64>().abs()
}

#[test]
fn a_near_huge_light_has_less_variance_by_solid_angle() {
    let pairs = pairs();
    let eye = Vec3::new(0.2, 0.0, -0.1);
    for (height, least) in [(0.7_f32, 15.0), (0.4, 20.0), (0.1, 80.0)] {
        let triangle: Triangle = [[-1.0, height, -1.0], [1.0, height, -1.0], [0.0, height, 1.4]];
        let corners = triangle.map(|v| Vec3::from(v).as_dvec3());
        let truth = polygon_irradiance(eye.as_dvec3(), DVec3::Y, &corners);
        let pdf_area = 1.0 / area(&triangle);
        let seen = solid_angle(&triangle, pdf_area as f32, eye).expect("near and large");
        let (by_angle, part) = draw(&triangle, pdf_area as f32, eye, &pairs);
        assert_eq!(part, 1.0);
        let estimate = |weights: [f32; 3], by_angle: bool| {
            let to = (0..3).map(|k| corners[k] * f64::from(weights[k])).sum::<DVec3>() - eye.as_dvec3();
            let cosine = to.normalize().y;
            let by_area = pdf_area * to.length_squared() / cosine;
            cosine / if by_angle { f64::from(seen.pdf_dir(by_area as f32)) } else { by_area }
        };
        let moments = |values: Vec<f64>| {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            (mean, values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0))
        };
        let (mean, variance) = moments(by_angle.into_iter().map(|w| estimate(w, true)).collect());
        let (area_mean, area_variance) =
            moments(pairs.iter().map(|&u| estimate(sample_uniform_triangle(u), false)).collect());
        println!(
            "height {height}: irradiance {truth:.5}, variance by area {:.1} times as large",
            area_variance / variance
        );
        for (mean, variance) in [(mean, variance), (area_mean, area_variance)] {
            let z = (mean - truth) / (variance / pairs.len() as f64).sqrt();
            assert!(z.abs() < 4.0, "height {height}: {mean} for {truth}, z = {z}");
        }
        assert!(area_variance > least * variance, "height {height}: {area_variance} and {variance}");
    }
    let nothing: Mask8 = solid_angles(&[splat3(Vec3::ZERO); 3], F32x8::ONE, splat3(Vec3::ZERO)).chosen();
    assert!(!nothing.any(), "a point seen from itself");
}
