//! Triangles as seen from points, what is drawn on them, and in which cells it lies.

use glam::{DVec3, Vec3};
use octray::internal::lanes::{F32x8, LANES, Vec3x8};
use octray::internal::reference::single::lights::triangle::solid_angle;
use octray::internal::reference::single::warp::sample_uniform_triangle;
use octray::internal::sampler::{random_words, unit};
use octray::internal::simd::native::kernels::lights::triangle::solid_angles;
use std::f64::consts::TAU;

pub type Triangle = [[f32; 3]; 3];

/// Numbers in [0, 1) that belong to `index`.
pub fn random(index: u32) -> impl FnMut() -> f64 {
    let mut drawn = 0;
    move || {
        drawn += 1;
        f64::from(random_words(index, drawn, 5, 2026)[0]) / 4_294_967_296.0
    }
}

pub fn direction(random: &mut impl FnMut() -> f64) -> DVec3 {
    let z = 2.0 * random() - 1.0;
    let (sine, cosine) = (TAU * random()).sin_cos();
    DVec3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z)
}

/// A random triangle of about unit size, and a point whose squared distance to a point of it is `area / ratio`.
pub fn random_view(index: u32, ratio: f64) -> (Triangle, Vec3) {
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

pub fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.map(|v| Vec3::from(v).as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}

/// Van Oosterom and Strackee's solid angle, in f64.
pub fn solid_angle_f64(corners: [DVec3; 3], eye: DVec3) -> f64 {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let [a, b, c] = corners.map(|v| v - eye);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let base = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(normal).abs().atan2(base)
}

pub fn splat3(v: Vec3) -> Vec3x8 {
    Vec3x8::splat(v.to_array())
}

/// Barycentric weights for each pair of numbers, and the part drawn by solid angle: the lanes', which must be the
/// scalar twin's bit for bit.
pub fn draw(triangle: &Triangle, pdf_area: f32, eye: Vec3, pairs: &[[f32; 2]]) -> (Vec<[f32; 3]>, f32) {
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
pub const CELLS: usize = 8;

/// The cell of a point.
pub fn cell([_, v, w]: [f32; 3]) -> usize {
    let (v, w) = (f64::from(v) * CELLS as f64, f64::from(w) * CELLS as f64);
    let (i, k) = ((v as usize).min(CELLS - 1), (w as usize).min(CELLS - 1));
    // Rows of 2 (CELLS - i) - 1 cells, alternately pointing up and down.
    let up = (v - i as f64) + (w - k as f64) <= 1.0;
    let place = (2 * k + usize::from(!up)).min(2 * (CELLS - i) - 2);
    i * (2 * CELLS - i) + place
}

/// The corners of all cells, in the order of [`cell`].
pub fn cells(triangle: &Triangle) -> Vec<[DVec3; 3]> {
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

pub const SAMPLES: u32 = 16_384;

pub fn pairs() -> Vec<[f32; 2]> {
    (0..SAMPLES).map(|i| random_words(i, 3, 1, 77)).map(|w| [unit(w[0]), unit(w[1])]).collect()
}
