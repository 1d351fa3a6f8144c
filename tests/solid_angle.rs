//! Points on triangles by solid angle and by area: chi-square tests, the density that MIS finds, the joins between the two
//! ways, rounding, extreme shapes, and the closed form of a near huge light. Everything on lanes and on the scalar twin.

mod common;

use common::Maker;
use glam::{DVec3, Vec3};
use octray::Lights;
use octray::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};
use octray::packet::light as light_x8;
use octray::packet::solid_angle::solid_angles;
use octray::packet::surface::{gather_records, surface_points};
use octray::reference::single::solid_angle::solid_angle;
use octray::reference::single::warp::sample_uniform_triangle;
use octray::reference::{double, single};
use octray::sampler::{random_words, unit};
use octray::scene::lights::LightTable;
use std::f64::consts::{PI, TAU};

type Triangle = [[f32; 3]; 3];

/// Numbers in [0, 1) that belong to `index`.
fn random(index: u32) -> impl FnMut() -> f64 {
    let mut drawn = 0;
    move || {
        drawn += 1;
        f64::from(random_words(index, drawn, 5, 2026)[0]) / 4_294_967_296.0
    }
}

fn direction(random: &mut impl FnMut() -> f64) -> DVec3 {
    let z = 2.0 * random() - 1.0;
    let (sine, cosine) = (TAU * random()).sin_cos();
    DVec3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z)
}

/// A random triangle of about unit size, and a point whose squared distance to a point of it is `area / ratio`.
fn random_view(index: u32, ratio: f64) -> (Triangle, Vec3) {
    let mut random = random(index);
    let corners: [DVec3; 3] = std::array::from_fn(|_| direction(&mut random));
    let thin = if index % 4 == 3 { 0.05 } else { 1.0 };
    let corners = [corners[0], corners[1], corners[1] + (corners[2] - corners[1]) * thin];
    let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
    let root = random().sqrt();
    let v = random();
    let on = corners[0] * (1.0 - root) + corners[1] * (root * (1.0 - v)) + corners[2] * (root * v);
    let eye = on + direction(&mut random) * (area / ratio).sqrt();
    (corners.map(|c| c.as_vec3().to_array()), eye.as_vec3())
}

fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.map(|v| Vec3::from(v).as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}

/// Van Oosterom and Strackee's solid angle, in f64.
fn solid_angle_f64(corners: [DVec3; 3], eye: DVec3) -> f64 {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let [a, b, c] = corners.map(|v| v - eye);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let base = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(normal).abs().atan2(base)
}

fn splat3(v: Vec3) -> Vec3x8 {
    Vec3x8::splat(v.to_array())
}

/// Barycentric weights for each pair of numbers, and the part drawn by solid angle: the lanes', which must be the scalar
/// twin's bit for bit.
fn draw(triangle: &Triangle, pdf_area: f32, eye: Vec3, pairs: &[[f32; 2]]) -> (Vec<[f32; 3]>, f32) {
    let lanes = solid_angles(&triangle.map(Vec3x8::splat), F32x8::splat(pdf_area), splat3(eye));
    let scalar = solid_angle(triangle, pdf_area, eye);
    let part = scalar.as_ref().map_or(0.0, |seen| seen.part);
    assert_eq!(lanes.part.to_array(), [part; LANES], "{triangle:?} from {eye}");
    let by_area = 0.37;
    let wanted = scalar.as_ref().map_or(by_area, |seen| seen.pdf_dir(by_area));
    let found = lanes.pdf_dir(F32x8::splat(by_area)).to_array();
    assert!(found.iter().all(|pdf| pdf.to_bits() == wanted.to_bits() && *pdf > 0.0 && pdf.is_finite()));
    let mut drawn = Vec::with_capacity(pairs.len());
    for block in pairs.chunks(LANES) {
        let pair = |lane: usize| block[lane.min(block.len() - 1)];
        let u = [0, 1].map(|i| F32x8::from_array(std::array::from_fn(|lane| pair(lane)[i])));
        let weights = lanes.sample(u).map(F32x8::to_array);
        for (lane, &u) in block.iter().enumerate() {
            let wanted = scalar.as_ref().map_or(sample_uniform_triangle(u), |seen| seen.sample(u));
            let found = [weights[0][lane], weights[1][lane], weights[2][lane]];
            assert_eq!(found.map(f32::to_bits), wanted.map(f32::to_bits), "{triangle:?} from {eye} at {u:?}");
            let sum = found.iter().sum::<f32>();
            assert!(found.iter().all(|w| (0.0..=1.000_001).contains(w)) && (sum - 1.0).abs() < 1e-6, "{found:?}");
            drawn.push(found);
        }
    }
    (drawn, part)
}

/// Cells along a side of the triangle; `CELLS * CELLS` equal cells in all.
const CELLS: usize = 8;

/// The cell of a point.
fn cell([_, v, w]: [f32; 3]) -> usize {
    let (v, w) = (f64::from(v) * CELLS as f64, f64::from(w) * CELLS as f64);
    let (i, k) = ((v as usize).min(CELLS - 1), (w as usize).min(CELLS - 1));
    // Rows of 2 (CELLS - i) - 1 cells, alternately pointing up and down.
    let up = (v - i as f64) + (w - k as f64) <= 1.0;
    let place = (2 * k + usize::from(!up)).min(2 * (CELLS - i) - 2);
    i * (2 * CELLS - i) + place
}

/// The corners of all cells, in the order of [`cell`].
fn cells(triangle: &Triangle) -> Vec<[DVec3; 3]> {
    let [a, b, c] = triangle.map(|v| Vec3::from(v).as_dvec3());
    let at = |i: usize, k: usize| a + ((b - a) * i as f64 + (c - a) * k as f64) / CELLS as f64;
    let row = |i: usize| {
        (0..2 * (CELLS - i) - 1).map(move |place| {
            let k = place / 2;
            if place % 2 == 0 {
                [at(i, k), at(i + 1, k), at(i, k + 1)]
            } else {
                [at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)]
            }
        })
    };
    (0..CELLS).flat_map(row).collect()
}

/// Pearson's statistic as a standard normal number (Wilson and Hilferty); cells that expect little are put together.
fn chi_square_z(counts: &[f64], expected: &[f64]) -> f64 {
    let (mut sum, mut cells, mut rest) = (0.0, 0.0, (0.0, 0.0));
    for (&count, &expected) in counts.iter().zip(expected) {
        rest = (rest.0 + count, rest.1 + expected);
        if rest.1 >= 10.0 {
            sum += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1;
            (cells, rest) = (cells + 1.0, (0.0, 0.0));
        }
    }
    if rest.1 > 0.0 {
        sum += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1.max(5.0);
    }
    let freedom: f64 = (cells - 1.0_f64).max(1.0);
    let spread = 2.0 / (9.0 * freedom);
    ((sum / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

const SAMPLES: u32 = 16_384;

fn pairs() -> Vec<[f32; 2]> {
    (0..SAMPLES).map(|i| random_words(i, 3, 1, 77)).map(|w| [unit(w[0]), unit(w[1])]).collect()
}

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
        let Some(exact) = double::solid_angle::solid_angle(&triangle, 1e-20, eye.as_dvec3()) else { continue };
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
    use double::solid_angle::solid_angle;
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
    for selection in [Lights::Uniform, Lights::Power] {
        let lights = LightTable::new(&scene, selection, false);
        let total: f64 = (0..lights.records.len() as u32).map(|light| f64::from(lights.probability(light))).sum();
        assert!((total - 1.0).abs() < 1e-6, "{selection}: probabilities sum to {total}");
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
            let found = light_x8::sample_lights(&lights, &points, words.map(U32x8::splat));
            let sample = single::light::sample_light(&lights, &point, words);
            assert_eq!(found.valid.any(), sample.is_some());
            let Some(sample) = sample else { continue };
            assert!(found.valid.all());
            assert_eq!(found.pdf_dir.to_array()[7].to_bits(), sample.pdf_dir.to_bits());
            // The ray that a BSDF sample in this direction would be.
            let chosen = lights.choose_triangle(words[0]);
            let record = &lights.records[chosen as usize];
            let segment = sample.shadow_direction;
            let (t, direction) = (segment.length(), segment.normalize());
            let cosine = direction.dot(Vec3::from(record.normal)).abs();
            let pdf = single::light::light_pdf_dir(&lights, point.origin, chosen, t, cosine);
            let columns = gather_records(&lights.records, U32x8::splat(chosen));
            let lanes = light_x8::light_pdf_dir(
                &lights,
                points.origin,
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
            // By area, the cosine of a ray along the light's plane has few digits.
            assert!((pdf / sample.pdf_dir - 1.0).abs() < 1e-2, "{pdf} {}", sample.pdf_dir);
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
