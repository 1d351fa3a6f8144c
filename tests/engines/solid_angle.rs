//! Points on triangles by solid angle and by area: chi-square tests, the joins between the two ways, rounding, extreme
//! shapes, the density that multiple importance sampling finds, and the closed form of a near huge light. Everything on
//! lanes and on the scalar twin.

mod lights;
mod views;

use crate::common::chi_square_z;
use glam::{DVec3, Vec3};
use octray::internal::lanes::{F32x8, LANES, Vec3x8};
use octray::internal::reference::double;
use octray::internal::reference::single::lights::triangle::solid_angle;
use octray::internal::simd::native::kernels::lights::triangle::solid_angles;
use std::f64::consts::PI;
use views::*;

/// Significance 0.1 % for the file (Sidak: 6e-7 each of 1,600 tests): z below 4.9.
const MOST_Z: f64 = 4.9;

/// z of points on `triangle` drawn as seen from `eye`, the part drawn by solid angle, and the true solid angle.
fn test_view(triangle: &Triangle, pdf_area: f32, eye: Vec3, pairs: &[[f32; 2]]) -> (f64, f32, f64) {
    let (drawn, part) = draw(triangle, pdf_area, eye, pairs);
    let mut counts = vec![0.0; CELLS * CELLS];
    drawn.iter().for_each(|&weights| counts[cell(weights)] += 1.0);
    let angles: Vec<f64> = cells(triangle).into_iter().map(|c| solid_angle_f64(c, eye.as_dvec3())).collect();
    let total: f64 = angles.iter().sum();
    let even = 1.0 / (CELLS * CELLS) as f64;
    let (part, samples) = (f64::from(part), pairs.len() as f64);
    let by_angle = |angle: f64| if part > 0.0 { part * angle / total } else { 0.0 };
    let expected: Vec<f64> = angles.iter().map(|&a| samples * (by_angle(a) + (1.0 - part) * even)).collect();
    (chi_square_z(&counts, &expected), part as f32, total)
}

#[test]
fn points_are_drawn_with_their_density_from_1e_8_to_2_pi_steradians() {
    let pairs = pairs();
    let (mut worst, mut by_angle, mut mixed, mut smallest, mut largest) = (0.0_f64, 0, 0, f64::MAX, 0.0_f64);
    for i in 0..800 {
        let ratio = 10.0_f64.powf(-8.0 + 12.0 * f64::from(i) / 800.0);
        let (triangle, eye) = random_view(i, ratio);
        // As light sampling does, and then by solid angle wherever that is possible.
        for pdf_area in [(1.0 / area(&triangle)) as f32, 1e-20] {
            let (z, part, total) = test_view(&triangle, pdf_area, eye, &pairs);
            assert!(z < MOST_Z, "z = {z}, part {part}, {total} sr: {triangle:?} from {eye}");
            (worst, smallest, largest) = (worst.max(z), smallest.min(total), largest.max(total));
            by_angle += u32::from(part == 1.0);
            mixed += u32::from(part > 0.0 && part < 1.0);
        }
    }
    println!(
        "{smallest:.1e} to {largest:.4} sr, worst z {worst:.2}; all by solid angle {by_angle}, mixed {mixed} of 1600"
    );
    assert!(smallest < 1e-7 && largest > 6.27 && by_angle > 400 && mixed > 20);
}

#[test]
fn the_density_is_one_over_the_solid_angle_and_f32_is_close_to_f64() {
    // Closed forms: an octant fills pi/2, half of a cube's face pi/3 from the centre.
    let octant = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let face = [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0]];
    for (triangle, angle) in [(octant, PI / 2.0), (face, PI / 3.0)] {
        let seen = solid_angle(&triangle, 0.0, Vec3::ZERO).expect("near");
        assert!((1.0 / f64::from(seen.pdf_dir(0.0)) - angle).abs() < 1e-6 * angle);
        assert!((solid_angle_f64(triangle.map(|v| Vec3::from(v).into()), DVec3::ZERO) - angle).abs() < 1e-12);
    }
    let (mut densities, mut directions) = (Vec::new(), Vec::new());
    for i in 0..20_000 {
        let (triangle, eye) = random_view(i, 10.0_f64.powf(-3.0 + 7.0 * f64::from(i) / 20_000.0));
        let Some(seen) = solid_angle(&triangle, 1e-20, eye) else { continue };
        let Some(exact) = double::lights::triangle::solid_angle(&triangle, 1e-20, eye.as_dvec3()) else { continue };
        let truth = solid_angle_f64(triangle.map(|v| Vec3::from(v).as_dvec3()), eye.as_dvec3());
        // The densities of the cells add up to one: the density integrates to 1.
        let whole: f64 = cells(&triangle).into_iter().map(|c| solid_angle_f64(c, eye.as_dvec3()) / truth).sum();
        assert!((whole - 1.0).abs() < 1e-6, "{whole}");
        assert!((4.0 * PI * exact.half_turns / truth - 1.0).abs() < 1e-9);
        densities.push((4.0 * PI * f64::from(seen.half_turns) / truth - 1.0).abs());
        let mut random = random(i);
        let u = [random() as f32, random() as f32];
        let (narrow, wide) = (seen.sample_solid_angle(u), exact.sample_solid_angle(u.map(f64::from)));
        let point = |w: [f64; 3]| -> DVec3 { (0..3).map(|k| Vec3::from(triangle[k]).as_dvec3() * w[k]).sum() };
        let seen_at = |w: [f64; 3]| (point(w) - eye.as_dvec3()).normalize();
        directions.push((seen_at(narrow.map(f64::from)) - seen_at(wide)).length());
    }
    assert!(densities.len() > 5_000);
    // Of a thousand views the worst loses digits next to the limits.
    for (what, mut errors, bound) in [("density", densities, DENSITY_ERROR), ("direction", directions, DIRECTION_ERROR)]
    {
        errors.sort_by(f64::total_cmp);
        let found = [errors[errors.len() / 2], errors[errors.len() * 999 / 1000], errors[errors.len() - 1]];
        println!(
            "{} views, error of the {what}: half below {:.1e}, 99.9 % below {:.1e}, worst {:.1e}",
            errors.len(),
            found[0],
            found[1],
            found[2]
        );
        assert!((0..3).all(|i| found[i] < bound[i]), "{what}: {found:?}");
    }
}

/// Bounds of the median, the 99.9 % quantile and the worst error of f32: of densities, as a part of them ..
const DENSITY_ERROR: [f64; 3] = [3e-7, 2e-4, 5e-3];
/// .. and of directions, in radians. (A point that moves along the triangle keeps its density.)
const DIRECTION_ERROR: [f64; 3] = [1e-6, 5e-3, 0.1];

#[test]
fn the_two_ways_join_without_a_jump() {
    use double::lights::triangle::solid_angle;
    let (mut joins, mut worst) = (0, 0.0_f64);
    for i in 0..2_000 {
        let (triangle, eye) = random_view(i, 1.0);
        let (eye, mut random) = (eye.as_dvec3(), random(i + 100_000));
        let corners = triangle.map(|v| Vec3::from(v).as_dvec3());
        let pdf_area = 1.0 / area(&triangle);
        let (target, end) = ((corners[0] + corners[1] + corners[2]) / 3.0, eye + direction(&mut random) * 4.0);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        // The density of drawing the middle of the triangle from a place along the way, and how it is drawn there.
        let density = |along: f64| {
            let from = eye + (end - eye) * along;
            let to = target - from;
            let by_area = pdf_area * to.length().powi(3) / to.dot(normal).abs();
            let seen = solid_angle(&triangle, pdf_area, from);
            (
                seen.as_ref().map_or(by_area, |seen| seen.pdf_dir(by_area)),
                seen.map_or(0, |s| 1 + u8::from(s.part == 1.0)),
            )
        };
        let steps = 200;
        for k in 0..steps {
            let (mut low, mut high) = (f64::from(k) / f64::from(steps), f64::from(k + 1) / f64::from(steps));
            let way = density(low).1;
            if way == density(high).1 {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if density(middle).1 == way { low = middle } else { high = middle }
            }
            joins += 1;
            worst = worst.max((density(low).0 / density(high).0 - 1.0).abs());
        }
    }
    println!("{joins} joins, densities on both sides differ by at most {worst:.1e} of them");
    assert!(joins > 1_000 && worst < 1e-6);
}

#[test]
fn extreme_shapes_and_places_give_numbers_and_the_same_bits() {
    let last = 1.0 - 1.0 / 16_777_216.0;
    let edges = [0.0, 1e-8, 0.25, 0.5, 0.999, last];
    let pairs: Vec<[f32; 2]> = edges.iter().flat_map(|&a| edges.map(|b| [a, b])).collect();
    let right: Triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let needle: Triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1e-4, 0.0]];
    let wide: Triangle = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1e-3, 0.0]];
    let places = [
        [0.3, 0.3, 1e-7],
        [0.3, 0.3, 1e-3],
        [0.3, 0.3, 0.1],
        [0.3, 0.3, -0.2],
        [0.3, 0.3, 0.0],
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [0.5, 0.0, 1e-6],
        [0.5, 0.0, 0.2],
        [2.0, 0.0, 0.0],
        [2.0, 2.0, 0.0],
        [0.5, -1e-4, 1e-5],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, 1e-12],
        [1e-12, 0.0, 0.0],
        [1e9, 0.0, 1e9],
    ];
    for (triangle, place) in [right, needle, wide].iter().flat_map(|t| places.map(|place| (t, place))) {
        let pdf_area = (1.0 / area(triangle)) as f32;
        let (unit_size, part) = draw(triangle, pdf_area, place.into(), &pairs);
        // Sizes of powers of two change no bit: 1e-6 and 1e6 are as good as 1.
        for scale in [1.0 / 1_048_576.0_f32, 1_048_576.0] {
            let scaled = triangle.map(|v| v.map(|x| x * scale));
            let eye = Vec3::from(place) * scale;
            let (points, scaled_part) = draw(&scaled, pdf_area / (scale * scale), eye, &pairs);
            assert_eq!((points, scaled_part), (unit_size.clone(), part), "{triangle:?} from {place:?} times {scale}");
        }
    }
    // In the plane, on an edge, on a corner, on the triangle: by area.
    for place in [[0.3, 0.3, 0.0], [0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [2.0, 0.0, 0.0], [0.3, 0.3, 1e-7]] {
        assert!(solid_angle(&right, 2.0, place.into()).is_none(), "{place:?}");
    }
    assert_eq!(solid_angle(&right, 2.0, Vec3::new(0.3, 0.3, 0.1)).map(|seen| seen.part), Some(1.0));
    // Lanes that are drawn by area do not disturb their neighbours.
    let eyes: [Vec3; LANES] = std::array::from_fn(|lane| places[[4, 2, 5, 16, 3, 7, 9, 1][lane]].into());
    let column = |of: fn(&Vec3) -> f32| F32x8::from_array(std::array::from_fn(|lane| of(&eyes[lane])));
    let origin = Vec3x8::new(column(|v| v.x), column(|v| v.y), column(|v| v.z));
    let mixed = solid_angles(&right.map(Vec3x8::splat), F32x8::splat(2.0), origin);
    let weights = mixed.sample([F32x8::splat(0.3), F32x8::splat(0.7)]).map(F32x8::to_array);
    for (lane, &eye) in eyes.iter().enumerate() {
        let wanted = draw(&right, 2.0, eye, &[[0.3, 0.7]]).0[0];
        assert_eq!([weights[0][lane], weights[1][lane], weights[2][lane]], wanted);
    }
}
