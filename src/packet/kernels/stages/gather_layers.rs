//! Stage: what camera rays have hit, for layers. In a pass of its own it stands in the place of all shading; rays go on after
//! mirrors and glass alone, and where the render wants that.

use super::here;
use crate::bvh::ray::NO_HIT;
use crate::film::layers::{FirstHit, MOST_SPECULAR};
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{PathQueue, SLOT, TileState};
use crate::tables::materials::MaterialKind;
use here::kernels::bsdf::Specular;
use here::kernels::bsdf::dielectric::Dielectric;
use here::kernels::bsdf::microfacet::{fresnel_conductor, fresnel_dielectric};
use here::kernels::bsdf::mirror::Mirror;
use here::kernels::columns::{VectorLanes, append_rays};
use here::kernels::records::MaterialColumns;
use here::kernels::stages::sort_hits::look_up_classes;
use here::kernels::surface::{Found, SurfacePoints, surface_points_on};
use here::kernels::texture::look_up;
use here::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8, inlined};
use here::numbers::draws::PathNumbers8;
use here::walks::packets::RayPacket;

/// Notes the hits of `paths` in `first_hits`. `DETAIL`: some surface of the scene is smooth or textured.
#[inline(always)]
pub fn gather_layers<const DETAIL: bool>(context: &StageContext, state: &mut TileState, _: &mut Counters) {
    let StageContext { setup, decisions, .. } = context;
    let scene = setup.scene;
    let TileState { paths, next, hits, first_hits, slots, .. } = state;
    let goes_on = setup.layers_through_specular && context.depth < MOST_SPECULAR.min(setup.max_depth);
    let axis = Vec3x8::splat(setup.camera.axis);
    for first in (0..paths.len).step_by(LANES) {
        let triangle = U32x8::load(&hits.triangle, first);
        let hit = Mask8::first((paths.len - first).min(LANES)).and_not(triangle.eq(U32x8::splat(NO_HIT)));
        if !hit.any() {
            continue;
        }
        // Other lanes look at the first corner of triangle 0.
        let triangle = hit.select_u32(triangle, U32x8::ZERO);
        let weight = inlined(
            #[inline(always)]
            |column: &[f32]| hit.select(F32x8::load(column, first), F32x8::ZERO),
        );
        let (u, v, t) = (weight(&hits.u), weight(&hits.v), weight(&hits.t));
        let slot = hit.select_u32(U32x8::load(&paths.slot, first) & U32x8::splat(SLOT), U32x8::ZERO);
        let RayPacket { origin, direction, .. } = RayPacket::load(&paths.rays, first);
        let position = origin + direction.scale(t);
        let found = decisions.needs.positions.then_some(Found { bvh: &scene.bvh, position });
        let tables = (&scene.triangles[..], decisions.corners(scene));
        let points = surface_points_on::<DETAIL>(tables, found, triangle, u, v, direction);
        let mut material = MaterialColumns::gather(&scene.materials, points.material);
        if DETAIL && decisions.textures {
            let texture = MaterialColumns::gather_textures(&scene.materials, points.material);
            material.color = material.color * look_up(&scene.textures, texture, points.uv);
        }
        let kind = look_up_classes(&scene.classes, triangle) & U32x8::splat(0x7f);
        let is = inlined(
            #[inline(always)]
            |wanted: MaterialKind| hit & kind.eq(U32x8::splat(wanted as u32)),
        );
        let (mirror, glass) = (is(MaterialKind::Mirror), is(MaterialKind::Dielectric));
        let passed = if goes_on { mirror | glass } else { Mask8::NONE };
        let beta = paths.beta.load(first);
        let none = Vec3x8::splat([0.0; 3]);
        let (plastic, principled) = (is(MaterialKind::Plastic), is(MaterialKind::Principled));
        let albedo = passed.select_vec3(none, beta * albedo(&material, plastic, principled, glass));
        let normal = passed.select_vec3(none, points.geometric_normal);
        let shading_normal = passed.select_vec3(none, points.normal);
        let depth = (t * direction.dot(axis)).to_array();
        let (albedo, normal, shading_normal, slot_of) =
            (columns(albedo), columns(normal), columns(shading_normal), slot.to_array());
        let bits = hit.bits();
        for lane in (0..LANES).filter(|lane| bits >> lane & 1 == 1) {
            let noted = &mut first_hits[slot_of[lane] as usize];
            *noted = FirstHit {
                albedo: albedo.map(|column| column[lane]),
                normal: normal.map(|column| column[lane]),
                shading_normal: shading_normal.map(|column| column[lane]),
                depth: if context.depth == 0 { depth[lane] } else { noted.depth },
            };
        }
        if passed.any() {
            let (pixel, sample) = (U32x8::gather(&slots.pixel, slot), U32x8::gather(&slots.sample, slot));
            let numbers = PathNumbers8 { sampler: setup.sampler, seed: setup.seed, pixel, sample };
            let going = Going { points: &points, direction, beta, numbers, slot, color: material.color };
            go_through::<Mirror, DETAIL>(context, &going, mirror, next);
            go_through::<Dielectric, DETAIL>(context, &going, glass, next);
        }
    }
}

/// What denoisers take for the colours of surfaces.
#[inline(always)]
fn albedo(material: &MaterialColumns, plastic: Mask8, principled: Mask8, glass: Mask8) -> Vec3x8 {
    let one = F32x8::ONE;
    let metal = fresnel_conductor(one, material.eta, material.k);
    let reflectance = material.complex_ior.select_vec3(metal, material.color);
    let (coat, _) = fresnel_dielectric(one, material.ior);
    let mixed = material.metallic + material.base_weight * (one - coat);
    let base = material.color.scale(principled.select(mixed, one - coat));
    // Plastics hold no metal.
    let coat = (one - material.metallic) * coat;
    let sum = base + Vec3x8::new(coat, coat, coat);
    let most = Vec3x8::new(sum.x.min(one), sum.y.min(one), sum.z.min(one));
    glass.select_vec3(Vec3x8::splat([1.0; 3]), (plastic | principled).select_vec3(most, reflectance))
}

#[inline(always)]
fn columns(v: Vec3x8) -> [[f32; LANES]; 3] {
    [v.x.to_array(), v.y.to_array(), v.z.to_array()]
}

/// Eight rays that may go on.
struct Going<'a> {
    points: &'a SurfacePoints,
    direction: Vec3x8,
    beta: Vec3x8,
    numbers: PathNumbers8,
    slot: U32x8,
    color: Vec3x8,
}

/// Appends the rays in the lanes of `lanes`, which have hit surfaces of the kind `S`, to `next`, as the paths of the same samples
/// go on.
#[inline(always)]
fn go_through<S: Specular, const DETAIL: bool>(
    context: &StageContext,
    going: &Going,
    lanes: Mask8,
    next: &mut PathQueue,
) {
    if !lanes.any() {
        return;
    }
    let mut points = going.points.clone();
    let material = S::load(&context.setup.scene.materials, points.material);
    let incoming = if DETAIL { S::orient(&mut points, going.direction) } else { going.direction };
    let draws = S::draws(&going.numbers, context.depth);
    let (direction, _, _) = material.sample(incoming, points.normal, points.front, draws.lobe);
    let direction = if DETAIL { points.to_consistent_hemisphere(direction) } else { direction };
    let through = direction.dot(points.geometric_normal).lt(F32x8::ZERO);
    // Not the weight, which knows how glass compresses light: an albedo is at most 1. Glass reflects all colours alike.
    let white = if S::KIND == MaterialKind::Dielectric { Mask8::ALL.and_not(through) } else { Mask8::NONE };
    let sent_on = white.select_vec3(Vec3x8::splat([1.0; 3]), going.color);
    let (at, bits) = (next.len, lanes.bits());
    append_rays(&mut next.rays, at, through.select_vec3(points.origin_behind, points.origin), direction, bits);
    next.beta.append(at, going.beta * sent_on, bits);
    going.slot.compress(bits).store(&mut next.slot, at);
    next.len += bits.count_ones() as usize;
}
