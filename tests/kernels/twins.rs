//! Every lane kernel against its scalar twin, bit for bit, with idle lanes poisoned.

use octray::internal::lanes::{F32x8, LANES, U32x8, Vec3x8};
use octray::internal::reference::single::{Vec3, mis, surface, warp};
use octray::internal::sampler::{bsdf_block, index_below, light_block, random_words, unit};
use octray::internal::simd::native::kernels::{mis as mis_x8, surface as surface_x8, warp as warp_x8};
use octray::internal::simd::native::numbers::{random_words_x8, unit_x8};
use octray::internal::tables::margins::PRECISE_OFFSET;
use octray::internal::tables::triangles::TriangleRecord;

/// Uniform numbers of a test, from the crate's own generator (its seed 77).
fn numbers(i: u32, block: u32) -> [f32; 4] {
    random_words(i, 0, block, 77).map(unit)
}

fn unit_vector(i: u32, block: u32) -> [f32; 3] {
    let [a, b, ..] = numbers(i, block);
    // Every eighth is along an axis, where frames and comparisons are at their edges.
    match i % 48 {
        0 => [0.0, 0.0, 1.0],
        8 => [0.0, 0.0, -1.0],
        16 => [1.0, 0.0, 0.0],
        24 => [0.0, -1.0, 0.0],
        32 => [-0.0, 1.0, -0.0],
        _ => {
            let v = glam::DVec3::new(a as f64 - 0.5, b as f64 - 0.5, numbers(i, block + 1)[0] as f64 - 0.5);
            v.normalize().as_vec3().to_array()
        }
    }
}

fn lanes3(v: [[f32; 3]; LANES]) -> Vec3x8 {
    let column = |c: usize| F32x8::from_array(v.map(|v| v[c]));
    Vec3x8::new(column(0), column(1), column(2))
}

fn lane3(v: Vec3x8, lane: usize) -> [u32; 3] {
    [v.x, v.y, v.z].map(|c| c.to_array()[lane].to_bits())
}

fn bits3(v: Vec3) -> [u32; 3] {
    v.to_array().map(f32::to_bits)
}

#[test]
fn random_words_have_the_same_bits_on_lanes() {
    for first in 0..2000u32 {
        let pixel: [u32; LANES] = std::array::from_fn(|lane| first * 977 + lane as u32 * 65_536);
        let sample: [u32; LANES] = std::array::from_fn(|lane| first / 3 + lane as u32);
        for block in [0, light_block(first), bsdf_block(first * 50)] {
            let words = random_words_x8(U32x8::from_array(pixel), U32x8::from_array(sample), block, first);
            for lane in 0..LANES {
                let scalar = random_words(pixel[lane], sample[lane], block, first);
                for (word, wanted) in words.into_iter().zip(scalar) {
                    assert_eq!(word.to_array()[lane], wanted);
                    assert_eq!(unit_x8(word).to_array()[lane].to_bits(), unit(wanted).to_bits());
                    assert!((0.0..1.0).contains(&unit(wanted)));
                    let high = word.multiply_high(U32x8::splat(1000)).to_array()[lane];
                    assert_eq!(high, index_below(wanted, 1000));
                }
            }
        }
    }
}

#[test]
fn warps_have_the_same_bits_on_lanes() {
    for first in (0..40_000u32).step_by(LANES) {
        let u: [[f32; 4]; LANES] = std::array::from_fn(|lane| numbers(first + lane as u32, 0));
        let column = |c: usize| F32x8::from_array(u.map(|u| u[c]));
        let n: [[f32; 3]; LANES] = std::array::from_fn(|lane| unit_vector(first + lane as u32, 1));
        let pair = [column(0), column(1)];
        let cosine = warp_x8::sample_cosine_hemisphere(pair);
        let uniform = warp_x8::sample_uniform_hemisphere(pair);
        let triangle = warp_x8::sample_uniform_triangle(pair);
        let world = warp_x8::to_world(cosine, lanes3(n));
        for lane in 0..LANES {
            let u = [u[lane][0], u[lane][1]];
            let wanted = warp::sample_cosine_hemisphere(u);
            assert_eq!(lane3(cosine, lane), bits3(wanted));
            assert_eq!(lane3(uniform, lane), bits3(warp::sample_uniform_hemisphere(u)));
            assert_eq!(
                triangle.map(|w| w.to_array()[lane].to_bits()),
                warp::sample_uniform_triangle(u).map(f32::to_bits)
            );
            let direction = warp::to_world(wanted, Vec3::from(n[lane]));
            assert_eq!(lane3(world, lane), bits3(direction));
            assert!((direction.length() - 1.0).abs() < 2e-6 && direction.dot(Vec3::from(n[lane])) > 0.0);
        }
    }
}

#[test]
fn mis_weights_have_the_same_bits_and_survive_extreme_densities() {
    let extremes = [f32::from_bits(1), f32::MIN_POSITIVE, 1e-30, 0.1, 1.0, 7.5, 1e30, f32::MAX, f32::INFINITY];
    for p_a in extremes {
        for p_b in extremes.into_iter().chain([0.0]) {
            let (a, b) = (F32x8::splat(p_a), F32x8::splat(p_b));
            for (lanes, scalar) in
                [(mis_x8::balance(a, b), mis::balance(p_a, p_b)), (mis_x8::power(a, b), mis::power(p_a, p_b))]
            {
                let lane = lanes.to_array()[6];
                assert!(lane.to_bits() == scalar.to_bits() || lane.is_nan() && scalar.is_nan());
                // Only infinity against infinity has no ratio.
                let both_infinite = p_a.is_infinite() && p_b.is_infinite();
                assert!(both_infinite || (0.0..=1.0).contains(&scalar), "{p_a:e} against {p_b:e}: {scalar}");
            }
            if p_a.is_finite() && p_b.is_finite() {
                let sum = mis::balance(p_a, p_b) + if p_b > 0.0 { mis::balance(p_b, p_a) } else { 0.0 };
                assert!((sum - 1.0).abs() < 1e-6, "weights of {p_a:e} and {p_b:e} sum to {sum}");
            }
        }
    }
}

#[test]
fn surface_points_have_the_same_bits_whatever_idle_lanes_hold() {
    let records: Vec<TriangleRecord> = (0..512u32)
        .map(|i| {
            let scale = [1e-6, 1.0, 1e6, 300.0][i as usize % 4];
            let corner = |block: u32| unit_vector(i, 10 + 2 * block).map(|c| c * scale);
            TriangleRecord {
                vertices: [corner(0), corner(1), corner(2)],
                normal: unit_vector(i, 30),
                material: i,
                light: u32::MAX,
                // (Every eighth has no area, and then no place in a tree.)
                offset: if i % 5 == 0 && i % 8 != 0 { PRECISE_OFFSET } else { 0.5 * i as f32 },
                inset: 100.0 * i as f32,
            }
        })
        .collect();
    for bits in 0..=255u8 {
        let id: [u32; LANES] = std::array::from_fn(|lane| (bits as u32 * 2 + lane as u32 * 61) % 512);
        let live = |lane: usize| bits >> lane & 1 == 1;
        let uv: [[f32; 4]; LANES] = std::array::from_fn(|lane| numbers(id[lane], 40));
        let direction: [[f32; 3]; LANES] =
            std::array::from_fn(|lane| if live(lane) { unit_vector(id[lane], 50) } else { [f32::NAN; 3] });
        let poisoned = |c: usize| {
            F32x8::from_array(std::array::from_fn(|lane| if live(lane) { uv[lane][c] * 0.5 } else { f32::INFINITY }))
        };
        let points = surface_x8::surface_points::<false>(
            (&records, &[]),
            U32x8::from_array(id),
            poisoned(0),
            poisoned(1),
            lanes3(direction),
        );
        for lane in (0..LANES).filter(|&lane| live(lane)) {
            let (u, v) = (uv[lane][0] * 0.5, uv[lane][1] * 0.5);
            let wanted = surface::surface_point(&records[id[lane] as usize], None, u, v, Vec3::from(direction[lane]));
            assert_eq!(lane3(points.position, lane), bits3(wanted.position));
            assert_eq!(lane3(points.normal, lane), bits3(wanted.normal));
            assert_eq!(lane3(points.origin, lane), bits3(wanted.origin));
            assert_eq!(points.material.to_array()[lane], id[lane]);
        }
    }
}
