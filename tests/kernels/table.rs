//! The kernels that [`check`] judges, a row each: a new one is a name, its seeds, and both forms.

use crate::runner::{Idle, Kernel, anything, both, check, columns, direction, lanes3, number, vec3};
use octray::internal::lanes::{self, F32x8, U32x8};
use octray::internal::reference::single::bsdf::microfacet;
use octray::internal::reference::single::lights::triangle;
use octray::internal::reference::single::{mis, texture, warp};
use octray::internal::simd::native::kernels::bsdf::microfacet as microfacet_x8;
use octray::internal::simd::native::kernels::lights::triangle as triangle_x8;
use octray::internal::simd::native::kernels::{mis as mis_x8, texture as texture_x8, warp as warp_x8};
use octray::internal::tables::textures::{NO_TEXTURE, TextureTable};
use octray::internal::{math, reference::single::Vec3};
use octray::scene::desc::TextureDesc;

/// A row of the table, idle lanes poisoned.
macro_rules! kernel {
    ($name:literal, $seed:expr, $lanes:expr, $scalar:expr $(,)?) => {
        check(&Kernel { name: $name, seed: &$seed, lanes: &$lanes, scalar: &$scalar, idle: Idle::Poison })
    };
}

fn all_anything<const N: usize>(i: u32) -> [f32; N] {
    std::array::from_fn(|n| anything(i, n as u32))
}

fn all_numbers<const N: usize>(i: u32) -> [f32; N] {
    std::array::from_fn(|n| number(i, n as u32))
}

#[test]
fn functions_of_angles() {
    kernel!("sin_cos_turns", all_numbers::<1>, |[t]| lanes::sin_cos_turns(t).into(), |[t]| math::sin_cos_turns(t)
        .into());
    kernel!("atan2_turns", all_anything::<2>, |[y, x]| [lanes::atan2_turns(y, x)], |[y, x]| [math::atan2_turns(y, x)]);
    kernel!("polar_half_turns", all_anything::<1>, |[v]| [lanes::polar_half_turns(v)], |[v]| [math::polar_half_turns(
        v
    )]);
}

#[test]
fn warps() {
    kernel!("sample_cosine_hemisphere", all_numbers::<2>, |u| columns(warp_x8::sample_cosine_hemisphere(u)), |u| {
        warp::sample_cosine_hemisphere(u).to_array()
    },);
    kernel!("cosine_hemisphere_pdf_dir", all_anything::<1>, |[c]| [warp_x8::cosine_hemisphere_pdf_dir(c)], |[c]| [
        warp::cosine_hemisphere_pdf_dir(c)
    ],);
    kernel!("sample_uniform_hemisphere", all_numbers::<2>, |u| columns(warp_x8::sample_uniform_hemisphere(u)), |u| {
        warp::sample_uniform_hemisphere(u).to_array()
    },);
    kernel!("sample_uniform_disk", all_numbers::<2>, warp_x8::sample_uniform_disk, warp::sample_uniform_disk);
    kernel!(
        "sample_uniform_triangle",
        all_numbers::<2>,
        warp_x8::sample_uniform_triangle,
        warp::sample_uniform_triangle
    );
}

#[test]
fn frames() {
    let frame_x8 = |n: [F32x8; 3]| {
        let (tangent, bitangent) = warp_x8::frame(lanes3(&n));
        both::<_, 3, 3, 6>(columns(tangent), columns(bitangent))
    };
    let frame = |n: [f32; 3]| {
        let (tangent, bitangent) = warp::frame(vec3(&n));
        both::<_, 3, 3, 6>(tangent.to_array(), bitangent.to_array())
    };
    kernel!("frame of unit vectors", |i| direction(i, 0), frame_x8, frame);
    kernel!("frame of anything", all_anything::<3>, frame_x8, frame);
    kernel!("to_local", all_anything::<6>, |v| columns(warp_x8::to_local(lanes3(&v[..3]), lanes3(&v[3..]))), |v| {
        warp::to_local(vec3(&v[..3]), vec3(&v[3..])).to_array()
    },);
    kernel!("to_world", all_anything::<6>, |v| columns(warp_x8::to_world(lanes3(&v[..3]), lanes3(&v[3..]))), |v| {
        warp::to_world(vec3(&v[..3]), vec3(&v[3..])).to_array()
    },);
}

#[test]
fn weights_of_multiple_importance_sampling() {
    kernel!("balance", all_anything::<2>, |[a, b]| [mis_x8::balance(a, b)], |[a, b]| [mis::balance(a, b)]);
    kernel!("power", all_anything::<2>, |[a, b]| [mis_x8::power(a, b)], |[a, b]| [mis::power(a, b)]);
}

#[test]
fn microfacets() {
    // Roughness and direction as surfaces have them, and anything at all.
    let seen = |i| both::<_, 1, 3, 4>([1e-4 + number(i, 9)], direction(i, 0));
    let ggx_x8 =
        |v: [F32x8; 4]| [microfacet_x8::ggx_d(v[0], lanes3(&v[1..])), microfacet_x8::smith_a(v[0], lanes3(&v[1..]))];
    let ggx = |v: [f32; 4]| [microfacet::ggx_d(v[0], vec3(&v[1..])), microfacet::smith_a(v[0], vec3(&v[1..]))];
    kernel!("ggx_d and smith_a", seen, ggx_x8, ggx);
    kernel!("ggx_d and smith_a of anything", all_anything::<4>, ggx_x8, ggx);
    let normal_x8 = |v: [F32x8; 6]| columns(microfacet_x8::sample_visible_normal(v[0], lanes3(&v[1..4]), [v[4], v[5]]));
    let normal = |v: [f32; 6]| microfacet::sample_visible_normal(v[0], vec3(&v[1..4]), [v[4], v[5]]).to_array();
    let numbers = |i| [number(i, 10), number(i, 11)];
    kernel!("sample_visible_normal", |i| both::<_, 4, 2, 6>(seen(i), numbers(i)), normal_x8, normal);
    let anywhere = |i| both::<_, 4, 2, 6>(all_anything::<4>(i), numbers(i));
    kernel!("sample_visible_normal from anywhere", anywhere, normal_x8, normal);
    kernel!(
        "fresnel_dielectric",
        all_anything::<2>,
        |[cosine, eta]| microfacet_x8::fresnel_dielectric(cosine, eta).into(),
        |[cosine, eta]| microfacet::fresnel_dielectric(cosine, eta).into(),
    );
    kernel!(
        "fresnel_conductor",
        all_anything::<7>,
        |v| columns(microfacet_x8::fresnel_conductor(v[0], lanes3(&v[1..4]), lanes3(&v[4..]))),
        |v| microfacet::fresnel_conductor(v[0], vec3(&v[1..4]), vec3(&v[4..])).to_array(),
    );
}

/// The part drawn by solid angle, a point's weights and the density; of `[vertices, origin, pdf_area, u]`.
fn solid_angles_x8(v: [F32x8; 15]) -> [F32x8; 5] {
    let vertices = [lanes3(&v[..3]), lanes3(&v[3..6]), lanes3(&v[6..9])];
    let seen = triangle_x8::solid_angles(&vertices, v[12], lanes3(&v[9..12]));
    both::<_, 2, 3, 5>([seen.part, seen.pdf_dir(v[12])], seen.sample([v[13], v[14]]))
}

fn solid_angle(v: [f32; 15]) -> [f32; 5] {
    let vertices = [0, 3, 6].map(|k| [v[k], v[k + 1], v[k + 2]]);
    let u = [v[13], v[14]];
    match triangle::solid_angle(&vertices, v[12], vec3(&v[9..12])) {
        Some(seen) => both::<_, 2, 3, 5>([seen.part, seen.pdf_dir(v[12])], seen.sample(u)),
        None => both::<_, 2, 3, 5>([0.0, v[12]], warp::sample_uniform_triangle(u)),
    }
}

#[test]
fn triangles_by_solid_angle() {
    let numbers = |i| [number(i, 13), number(i, 14)];
    // Unit triangles around and beside the origin of the view, some of which it lies on.
    let near = |i| {
        let corners: [f32; 9] = std::array::from_fn(|n| 2.0 * number(i, n as u32) - 1.0);
        let [a, b, c] = [0, 3, 6].map(|k| vec3(&corners[k..k + 3]));
        let origin = (1.2 * number(i, 9) - 0.1) * a + number(i, 10) * b * (i % 3) as f32;
        let pdf_area = 2.0 / (b - a).cross(c - a).length();
        let view: [f32; 4] = both(Vec3::to_array(&origin), [pdf_area]);
        both::<_, 13, 2, 15>(both::<_, 9, 4, 13>(corners, view), numbers(i))
    };
    kernel!("solid angles", near, solid_angles_x8, solid_angle);
    let anywhere = |i| both::<_, 13, 2, 15>(all_anything::<13>(i), numbers(i));
    kernel!("solid angles of anything", anywhere, solid_angles_x8, solid_angle);
}

#[test]
fn textures() {
    let desc = |width: u32, height: u32| TextureDesc {
        width,
        height,
        texels: (0..width * height).map(|i| [i * 7, i * 31, i * 101].map(|c| c as u8)).collect(),
        name: "made up".into(),
    };
    let table = TextureTable::new(&[desc(1, 1), desc(7, 3), desc(16, 16), desc(2, 9)]);
    // Coordinates in some tiles, at edges of texels, and so near below 0 that the fraction rounds to 1.
    let coordinate = |i: u32, argument: u32| match i % 8 {
        0 => [0.0, -0.0, f32::from_bits(1), -f32::from_bits(1), -1e-9, 0.5, 1.0, 2048.0][(i / 8) as usize % 8],
        1 => (number(i, argument) * 32.0).floor() / 16.0,
        _ => 8.0 * number(i, argument) - 4.0,
    };
    // Texture 4 stands for none.
    let seed = |i: u32| [(i % 5) as f32, coordinate(i, 1), coordinate(i / 3, 2)];
    check(&Kernel {
        name: "look_up",
        seed: &seed,
        lanes: &|[which, u, v]| {
            let which = U32x8::from_f32(which);
            let which = which.eq(U32x8::splat(4)).select_u32(U32x8::splat(NO_TEXTURE), which);
            columns(texture_x8::look_up(&table, which, [u, v]))
        },
        scalar: &|[which, u, v]| match which as u32 {
            4 => [1.0; 3],
            which => texture::look_up(&table, which, [u, v]).to_array(),
        },
        idle: Idle::Repeat,
    });
    kernel!(
        "interpolate",
        all_anything::<9>,
        |v| texture_x8::interpolate([v[0], v[1], v[2], v[3], v[4], v[5]], [v[6], v[7], v[8]]),
        |v| texture::interpolate(&[[v[0], v[1]], [v[2], v[3]], [v[4], v[5]]], [v[6], v[7], v[8]]),
    );
}
