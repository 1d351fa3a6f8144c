//! What a camera ray hits, for layers ([`crate::film::layers`]).

use super::alpha_masks::is_hit;
use super::bsdf::microfacet::{fresnel_conductor, fresnel_dielectric};
use super::camera::camera_ray;
use super::intersect::{Ray, intersect_where, stack};
use super::path::textured;
use super::surface::surface_point_on;
use super::{Real, Vec3, bsdf, vec3};
use crate::bvh::precise::HUGE;
use crate::film::layers::{FirstHit, MOST_SPECULAR};
use crate::sampler::draws::PathNumbers;
use crate::sampler::pixel_address;
use crate::setup::Setup;
use crate::tables::materials::{MaterialKind, MaterialRecord};

/// What the camera ray of sample `sample` of pixel (`x`, `y`) hits; or, where the render wants that, what it hits by way of the
/// mirrors and through the glass that the sample's path meets.
pub fn find_first_hit(setup: &Setup, (x, y): (u32, u32), sample: u32) -> FirstHit {
    let pixel = pixel_address(x, y);
    let numbers = PathNumbers { sampler: setup.sampler, seed: setup.seed, pixel, sample };
    let scene = setup.scene;
    let mut stack = stack(&scene.bvh);
    let mut ray = camera_ray(&setup.camera, x, y, &numbers.camera());
    let mut found = FirstHit::NONE;
    // What the mirrors and the glass on the way send on.
    let mut beta = Vec3::ONE;
    for event in 0.. {
        let Some(hit) = intersect_where(&scene.bvh, &ray, &mut stack, |hit| is_hit(&scene.alpha_masks, hit)) else {
            break;
        };
        if event == 0 {
            found.depth = (hit.t * ray.direction.dot(vec3(setup.camera.axis))) as f32;
        }
        let triangle = &scene.triangles[hit.triangle as usize];
        let is_huge = scene.bvh.class(hit.triangle) & HUGE != 0;
        let place = is_huge.then(|| ray.origin + ray.direction * hit.t);
        let corners = scene.corners.get(hit.triangle as usize);
        let mut point = surface_point_on(triangle, corners, place, [hit.u, hit.v], ray.direction);
        let material = &scene.materials[triangle.material as usize];
        let textured = textured(scene, material, point.uv);
        let material = textured.as_ref().unwrap_or(material);
        let kind = material.kind();
        let goes_on = setup.layers_through_specular && kind.is_delta();
        if !goes_on || event == MOST_SPECULAR.min(setup.max_depth) {
            let narrow = |v: Vec3| [v.x as f32, v.y as f32, v.z as f32];
            found.albedo = narrow(beta * albedo(material));
            found.normal = narrow(point.geometric_normal);
            found.shading_normal = narrow(point.normal);
            break;
        }
        let incoming = bsdf::orient(kind, &mut point, ray.direction);
        let draws = numbers.bsdf(event);
        let u = draws.direction.map(|u| u as Real);
        let bounce = bsdf::sample(material, point.normal, incoming, point.front, u, draws.lobe as Real);
        let direction = bounce.and_then(|bounce| point.to_consistent_hemisphere(bounce.direction, bounce.delta));
        let Some(direction) = direction else { break };
        let through = direction.dot(point.geometric_normal) < 0.0;
        // Not the BSDF weight, which knows how glass compresses light: an albedo is at most 1. Glass reflects all colours alike.
        if through || kind != MaterialKind::Dielectric {
            beta *= vec3(material.color);
        }
        let origin = if through { point.origin_behind } else { point.origin };
        ray = Ray { origin, direction, tmin: 0.0, tmax: Real::INFINITY };
    }
    found
}

/// What denoisers take for the colour of a surface: as Open Image Denoise recommends it, independent of light and of the viewing
/// angle.
fn albedo(material: &MaterialRecord) -> Vec3 {
    let color = vec3(material.color);
    // What coats reflect, and the bases under them; the constants in their colours may bring them above 1.
    let coated = |base: Real, coat: Real| {
        let least = |x: Real| if x < 1.0 { x } else { 1.0 };
        let sum = color * base + Vec3::splat(coat);
        Vec3::new(least(sum.x), least(sum.y), least(sum.z))
    };
    match material.kind() {
        MaterialKind::Black | MaterialKind::Diffuse | MaterialKind::Mirror => color,
        MaterialKind::Conductor if !material.has_complex_ior() => color,
        MaterialKind::Conductor => fresnel_conductor(1.0, vec3(material.eta), vec3(material.k)),
        MaterialKind::Dielectric => Vec3::ONE,
        MaterialKind::Plastic => {
            let (coat, _) = fresnel_dielectric(1.0, material.ior as Real);
            coated(1.0 - coat, coat)
        }
        MaterialKind::Principled => {
            let (coat, _) = fresnel_dielectric(1.0, material.ior as Real);
            let metallic = material.metallic as Real;
            coated(metallic + material.base_weight as Real * (1.0 - coat), (1.0 - metallic) * coat)
        }
    }
}
