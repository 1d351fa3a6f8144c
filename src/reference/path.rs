//! One path, from the camera to its end: all nine strategies. The step titles name the packet engine's stages.

use super::alpha_masks::is_hit;
use super::bsdf::sample::{BsdfSample, max_element};
use super::camera::camera_ray;
use super::guide::GuidePlace;
use super::intersect::{Hit, Ray, intersect_where, occluded_where, stack};
use super::lights::factors::place;
use super::lights::sample::{LightSample, emitted, environment_in_direction, light_pdf_dir, sample_light};
use super::lights::tree::Receiver;
use super::lights::visibility::survivor;
use super::observer::{Bounce, Choice, CompensatedSum, Event, Found, Observer, Path};
use super::surface::surface_point_on;
use super::texture::look_up;
use super::{Real, Vec3, bsdf, mis, vec3};
use crate::bvh::precise::HUGE;
use crate::sampler::draws::PathNumbers;
use crate::sampler::pixel_address;
use crate::settings::{DEPTH_GUARD, LEAST_ALBEDO, Roulette};
use crate::setup::Setup;
use crate::strategy::{Row, Weight};
use crate::tables::PreparedScene;
use crate::tables::materials::{MaterialKind, MaterialRecord};
use crate::tables::textures::NO_TEXTURE;

/// What one path came to.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathResult {
    /// Radiance arriving at the camera, W sr^-1 m^-2.
    pub radiance: Vec3,
    /// Rays after a scattering event.
    pub bounce_rays: u32,
    /// Shadow rays.
    pub shadow_rays: u32,
    /// The path was cut by the depth guard.
    pub guarded: bool,
}

/// What must be remembered of the previous bounce to weigh emission that the next hit finds.
#[derive(Clone, Copy)]
enum Previous {
    /// Camera ray or delta lobe: light sampling could not have found it. Counts 1.
    Certain,
    /// A direction drawn with this density per steradian and this cosine at the surface with this normal, where this row is
    /// what was learned of the lights.
    Drawn { pdf_dir: Real, cosine: Real, normal: Vec3, row: u32 },
    /// The one-sample strategy's coin chose the light: counts 0.
    LightChosen,
}

impl Previous {
    /// The cosine at the surface where light sampling could have drawn the direction, else 0.
    fn cosine(self) -> Real {
        match self {
            Previous::Drawn { cosine, .. } => cosine,
            _ => 0.0,
        }
    }

    /// Emission that was found after this, for observers.
    fn found(self, radiance: Vec3, gain: Vec3, weight: Real, pdf_light: Real) -> Found {
        let (pdf_bsdf, how) = match self {
            Previous::Certain => (None, "certain"),
            Previous::Drawn { pdf_dir, .. } => (Some(pdf_dir), "drawn"),
            Previous::LightChosen => (None, "light chosen"),
        };
        Found { radiance, gain, weight, pdf_light, pdf_bsdf, how }
    }

    /// The normal at the surface where light sampling could have drawn the direction.
    fn normal(self) -> Vec3 {
        match self {
            Previous::Drawn { normal, .. } => normal,
            _ => Vec3::ZERO,
        }
    }

    /// The row of what was learned of the lights there.
    fn row(self) -> u32 {
        match self {
            Previous::Drawn { row, .. } => row,
            _ => 0,
        }
    }
}

/// Follows sample `sample` of pixel (`x`, `y`); `observer` is told every step.
pub fn trace_path(setup: &Setup, (x, y): (u32, u32), sample: u32, observer: &mut impl Observer) -> PathResult {
    let pixel = pixel_address(x, y);
    let numbers = PathNumbers { sampler: setup.sampler, seed: setup.seed, pixel, sample };
    let (scene, strategy) = (setup.scene, setup.strategy.row());
    let mut result = PathResult::default();
    let mut path = Path { depth: 0, beta: Vec3::ONE, radiance: CompensatedSum::default() };
    let mut stack = stack(&scene.bvh);

    // generate_camera_rays
    let mut ray = camera_ray(&setup.camera, x, y, &numbers.camera());
    let mut previous = Previous::Certain;
    // Product of the albedos so far over what roulette has let through.
    let mut albedos: Real = 1.0;

    loop {
        // intersect_closest
        observer.note(&path, Event::Ray(&ray));
        result.bounce_rays += (path.depth > 0) as u32;
        let receiver = Receiver { origin: ray.origin, normal: previous.normal(), row: previous.row() };
        let Some(hit) = intersect_where(&scene.bvh, &ray, &mut stack, |hit| is_hit(&scene.alpha_masks, hit)) else {
            // shade_miss
            observer.note(&path, Event::Miss(&ray));
            if setup.hide_environment && path.depth == 0 {
                break;
            }
            let found = environment_in_direction(&setup.lights, &receiver, ray.direction, previous.cosine());
            if let Some((radiance, pdf_light)) = found {
                let weight = emission_weight(strategy, previous, pdf_light);
                let gain = path.beta * radiance * weight;
                path.radiance.add(gain);
                observer.note(&path, Event::Environment(&ray, previous.found(radiance, gain, weight, pdf_light)));
            }
            break;
        };
        let triangle = &scene.triangles[hit.triangle as usize];
        let is_huge = scene.bvh.class(hit.triangle) & HUGE != 0;
        let found = is_huge.then(|| ray.origin + ray.direction * hit.t);
        let corners = scene.corners.get(hit.triangle as usize);
        let mut point = surface_point_on(triangle, corners, found, [hit.u, hit.v], ray.direction);
        observer.note(&path, Event::Hit(&ray, &hit, point.position));

        // shade_emitter
        let light = setup.lights.records.get(triangle.light as usize);
        if light.is_some_and(|light| point.front || light.two_sided()) {
            let light_cosine = -point.geometric_normal.dot(ray.direction);
            let pdf_light = light_pdf_dir(&setup.lights, &receiver, triangle.light, hit.t, light_cosine);
            let weight = emission_weight(strategy, previous, pdf_light);
            let radiance = emitted(&setup.lights, triangle.light, [1.0 - hit.u - hit.v, hit.u, hit.v]);
            let gain = path.beta * radiance * weight;
            path.radiance.add(gain);
            let found = previous.found(radiance, gain, weight, pdf_light);
            observer.note(&path, Event::Emission(&ray, &hit, point.position, found));
        }

        // The path ends on black surfaces and after its last event.
        let material = &scene.materials[triangle.material as usize];
        let kind = material.kind();
        if !kind.scatters() || path.depth == setup.max_depth {
            let why = if kind.scatters() { "that was the last event allowed" } else { "the surface scatters nothing" };
            observer.note(&path, Event::End(why));
            break;
        }
        let textured = textured(scene, material, point.uv);
        let material = textured.as_ref().unwrap_or(material);
        let incoming = bsdf::orient(kind, &mut point, ray.direction);
        let mirrors = (!kind.row().pdf_is_cosine).then_some(ray.direction);
        let place = place(&setup.lights, point.origin, point.normal, mirrors);
        let guide = setup.guide.as_ref().filter(|_| kind == MaterialKind::Diffuse);
        let guide = guide.map(|guide| GuidePlace::find(guide, point.origin, point.normal));
        let event = path.depth;
        result.guarded = event + 1 == DEPTH_GUARD;

        // shade_surface: light sample
        let mut light_chosen = false;
        if setup.samples_lights() && !kind.is_delta() {
            let draws = numbers.light(event);
            light_chosen = strategy.coin && draws.coin();
            if strategy.coin {
                observer.note(&path, Event::Coin(light_chosen));
            }
            let wanted = !strategy.coin || light_chosen;
            let above = |light: &LightSample| light.direction.dot(point.geometric_normal) > 0.0;
            let light = wanted.then(|| sample_light(&setup.lights, &point, place.row, &draws)).flatten();
            let light = light.filter(above);
            let choice = Choice { lights: &setup.lights, point: &point, place, word: draws.select, fork: draws.fork() };
            if wanted && light.is_none() {
                observer.note(&path, Event::LightIdle(choice, "light and surface do not face each other"));
            }
            // Roulette of its shadow ray
            let found = light.is_some();
            let light = light.and_then(|light| survivor(&setup.lights, point.origin, light, draws.roulette() as Real));
            if found && light.is_none() {
                observer.note(&path, Event::LightIdle(choice, "roulette has ended its shadow ray"));
            }
            if let Some(light) = light {
                let (f_cosine, pdf_bsdf) = bsdf::evaluate(material, point.normal, ray.direction, light.direction);
                let pdf_bsdf = guide.map_or(pdf_bsdf, |guide| guide.pdf_dir(light.direction, pdf_bsdf));
                let weight = match light.delta {
                    true => strategy.light_sample.of_delta_light() as Real,
                    false => mis::weigh(strategy.light_sample, light.pdf_dir, pdf_bsdf),
                };
                let gain = path.beta * f_cosine * light.radiance * (weight / light.pdf_dir);
                // intersect_shadow
                if !(gain.x + gain.y + gain.z == 0.0) {
                    result.shadow_rays += 1;
                    let (direction, tmax) = (light.shadow_direction, light.shadow_tmax);
                    let shadow = Ray { origin: point.origin, direction, tmin: 0.0, tmax };
                    let blocks = |hit: &Hit| light.target.is_blocked_by(hit, tmax) && is_hit(&scene.alpha_masks, hit);
                    let blocked = occluded_where(&scene.bvh, &shadow, &mut stack, blocks);
                    if !blocked {
                        path.radiance.add(gain);
                    }
                    let light = &light;
                    observer.note(&path, Event::Light { choice, light, f_cosine, pdf_bsdf, weight, gain, blocked });
                } else {
                    observer
                        .note(&path, Event::LightIdle(choice, "the surface sends none of it on, or its weight is 0"));
                }
            }
        }

        // shade_surface, shade_specular: BSDF sample
        let draws = numbers.bsdf(event);
        let u = draws.direction.map(|u| u as Real);
        let bounce = if strategy.uniform_directions && !kind.is_delta() {
            Some(bsdf::sample_uniformly(material, point.normal, ray.direction, u))
        } else if let Some(guide) = guide {
            guide.sample(material, point.normal, u, draws.lobe as Real)
        } else {
            bsdf::sample(material, point.normal, incoming, point.front, u, draws.lobe as Real)
        };
        let Some(bounce) = bounce else {
            observer.note(&path, Event::Lost(guide, "the direction drawn carries nothing"));
            break;
        };
        let Some(direction) = point.to_consistent_hemisphere(bounce.direction, bounce.delta) else {
            observer.note(&path, Event::Lost(guide, "the direction drawn leads below the surface"));
            break;
        };
        let arriving = path.beta;
        path.beta *= bounce.weight;
        previous = match () {
            _ if bounce.delta => Previous::Certain,
            _ if light_chosen => Previous::LightChosen,
            _ => {
                let (cosine, normal) = (bounce.cosine, point.normal);
                Previous::Drawn { pdf_dir: bounce.pdf_dir, cosine, normal, row: place.row }
            }
        };
        let BsdfSample { weight, pdf_dir, cosine, delta, .. } = bounce;
        let drawn = Bounce { direction, weight, pdf_dir, cosine, delta, place: guide };
        observer.note(&path, Event::Bounce(kind.name(), &hit, point.position, drawn));
        path.depth += 1;

        // Nothing more to find?
        if path.depth == setup.max_depth && !emission_can_count(setup, previous) {
            observer.note(&path, Event::End("no emission that the last ray could find would count"));
            break;
        }

        // Russian roulette
        // A throughput below the normal numbers is as good as none; left alone it would not even shrink: three quarters
        // of the smallest number round to the smallest number, and a path without roulette would run to the guard.
        let mut survival = max_element(path.beta);
        if !(survival >= Real::MIN_POSITIVE) {
            observer.note(&path, Event::End("the throughput is 0"));
            break;
        }
        if setup.roulette != Roulette::Throughput {
            let least = LEAST_ALBEDO as Real;
            albedos *= bounce.albedo;
            albedos = if albedos > least { albedos } else { least };
            // What the path is expected to bring, over what its pixel is expected to show.
            let expected = match (guide, &setup.guide) {
                (Some(guide), Some(tables)) if setup.roulette == Roulette::Learned => {
                    guide.expected(arriving * vec3(material.color), tables.pixels.inverse(pixel) as Real)
                }
                _ => 0.0,
            };
            survival = if albedos > expected { albedos } else { expected };
        }
        if path.depth >= setup.rr_depth {
            let survival = if survival < 1.0 { survival } else { 1.0 };
            if !((draws.roulette as Real) < survival) {
                observer.note(&path, Event::Roulette(&hit, point.position, survival));
                break;
            }
            path.beta *= 1.0 / survival;
            albedos /= survival;
            observer.note(&path, Event::Survival(&hit, point.position, survival));
        }
        let through = direction.dot(point.geometric_normal) < 0.0;
        let origin = if through { point.origin_behind } else { point.origin };
        ray = Ray { origin, direction, tmin: 0.0, tmax: Real::INFINITY };
    }
    result.radiance = path.radiance.value();
    result
}

/// The material with its texture at `uv` in its colour; `None` if it has no texture.
pub fn textured(scene: &PreparedScene, material: &MaterialRecord, uv: [Real; 2]) -> Option<MaterialRecord> {
    (material.texture != NO_TEXTURE).then(|| {
        let color = vec3(material.color) * look_up(&scene.textures, material.texture, uv);
        let mut textured = *material;
        textured.color = [color.x as f32, color.y as f32, color.z as f32];
        textured
    })
}

/// What emission found by a hit counts by the strategy's row, where light sampling would have found it with density
/// `pdf_light`.
fn emission_weight(strategy: &Row, previous: Previous, pdf_light: Real) -> Real {
    match previous {
        Previous::Certain => mis::weigh(strategy.certain_hit, 1.0, pdf_light),
        Previous::LightChosen => 0.0,
        Previous::Drawn { pdf_dir, .. } => mis::weigh(strategy.hit, pdf_dir, pdf_light),
    }
}

/// Whether emission found by the next hit can count at all; if not, the last ray need not be traced.
fn emission_can_count(setup: &Setup, previous: Previous) -> bool {
    let strategy = setup.strategy.row();
    let counts = match previous {
        Previous::Certain => strategy.certain_hit != Weight::Zero,
        Previous::LightChosen => false,
        Previous::Drawn { .. } => strategy.hit != Weight::Zero,
    };
    counts && setup.lights.can_be_hit()
}
