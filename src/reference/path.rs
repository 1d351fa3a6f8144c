//! One path, from the camera to its end: all nine strategies. The step titles name the packet engine's stages.

use super::alpha_masks::is_hit;
use super::bsdf::BsdfSample;
use super::intersect::{Ray, intersect_where, occluded_where, stack};
use super::lights::sample::{LightSample, emitted, environment_in_direction, light_pdf_dir, sample_light};
use super::lights::tree::Receiver;
use super::surface::{SurfacePoint, surface_point};
use super::texture::look_up;
use super::warp::sample_uniform_disk;
use super::{Real, Vec3, bsdf, intersect, mis, vec3};
use crate::bvh::ray::NO_HIT;
use crate::sampler::{CAMERA_BLOCK, bsdf_block, light_block, sample_words, unit};
use crate::scene::desc::PixelFilter;
use crate::settings::{DEPTH_GUARD, Strategy};
use crate::setup::Setup;
use crate::tables::PreparedScene;
use crate::tables::materials::{MaterialKind, MaterialRecord};
use crate::tables::textures::NO_TEXTURE;
use crate::trace::{LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED, RAY, TraceVertex};

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
    /// A direction drawn with this density per steradian and this cosine at the surface with this normal.
    Drawn { pdf_dir: Real, cosine: Real, normal: Vec3 },
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

    /// The normal at the surface where light sampling could have drawn the direction.
    fn normal(self) -> Vec3 {
        match self {
            Previous::Drawn { normal, .. } => normal,
            _ => Vec3::ZERO,
        }
    }
}

/// Follows sample `sample` of pixel (`x`, `y`); `record` is told every step.
pub fn trace_path(setup: &Setup, (x, y): (u32, u32), sample: u32, record: &mut impl FnMut(TraceVertex)) -> PathResult {
    let pixel = crate::sampler::pixel_address(x, y);
    let numbers = |block: u32| sample_words(setup.sampler, pixel, sample, block, setup.seed);
    let scene = setup.scene;
    let mut result = PathResult::default();
    let mut step = Step { depth: 0, beta: Vec3::ONE, radiance: Vec3::ZERO, stack: stack(&scene.bvh), record };

    // generate_camera_rays
    let mut ray = camera_ray(setup, x, y, numbers(CAMERA_BLOCK));
    let mut previous = Previous::Certain;

    loop {
        // intersect_closest
        step.note(Event { direction: ray.direction, ..Event::new(RAY, ray.origin) });
        result.bounce_rays += (step.depth > 0) as u32;
        let Some(hit) = intersect_where(&scene.bvh, &ray, &mut step.stack, |hit| is_hit(&scene.alpha_masks, hit))
        else {
            // shade_miss
            step.note(Event { t: Real::INFINITY, direction: ray.direction, ..Event::new("miss", ray.origin) });
            let receiver = Receiver { origin: ray.origin, normal: previous.normal() };
            let found = environment_in_direction(&setup.lights, &receiver, ray.direction, previous.cosine());
            if let Some((radiance, pdf_light)) = found {
                let weight = emission_weight(setup, previous, pdf_light);
                let gain = step.beta * radiance * weight;
                step.radiance += gain;
                let direction = ray.direction;
                step.note(Event { direction, gain, weight, ..Event::new("environment", ray.origin) });
            }
            break;
        };
        let triangle = &scene.triangles[hit.triangle as usize];
        let mut point = surface_point(triangle, scene.corners.get(hit.triangle as usize), hit.u, hit.v, ray.direction);
        let position = point.position;
        let here = |name| Event { triangle: hit.triangle, t: hit.t, ..Event::new(name, position) };
        step.note(Event { direction: ray.direction, ..here("hit") });

        // shade_emitter
        let light = setup.lights.records.get(triangle.light as usize);
        if light.is_some_and(|light| point.front || light.two_sided()) {
            let light_cosine = -point.geometric_normal.dot(ray.direction);
            let receiver = Receiver { origin: ray.origin, normal: previous.normal() };
            let pdf_light = light_pdf_dir(&setup.lights, &receiver, triangle.light, hit.t, light_cosine);
            let weight = emission_weight(setup, previous, pdf_light);
            let radiance = emitted(&setup.lights, triangle.light, [1.0 - hit.u - hit.v, hit.u, hit.v]);
            let gain = step.beta * radiance * weight;
            step.radiance += gain;
            step.note(Event { direction: ray.direction, gain, weight, ..here("emission") });
        }

        // shade_surface: the path ends on black surfaces and after its last event
        let material = &scene.materials[triangle.material as usize];
        let kind = material.kind();
        if kind == MaterialKind::Black || step.depth == setup.max_depth {
            break;
        }
        let textured = textured(scene, material, point.uv);
        let material = textured.as_ref().unwrap_or(material);
        let mut incoming = ray.direction;
        match kind {
            MaterialKind::Diffuse => {}
            MaterialKind::Dielectric => incoming = point.graze(incoming),
            _ => point.face(-incoming),
        }
        let event = step.depth;
        result.guarded = event + 1 == DEPTH_GUARD;
        let delta = bsdf::is_delta(kind);

        // shade_surface: light sample
        let mut light_chosen = false;
        if setup.samples_lights() && !delta {
            let words = numbers(light_block(event));
            light_chosen = unit(words[3]) < 0.5;
            let draws = setup.strategy != Strategy::MisOneSample || light_chosen;
            let above = |light: &LightSample| light.direction.dot(point.geometric_normal) > 0.0;
            let light = draws.then(|| sample_light(&setup.lights, &point, words)).flatten();
            if let Some(light) = light.filter(above) {
                let scattered = bsdf::evaluate(material, point.normal, ray.direction, light.direction);
                result.shadow_rays += direct_light(setup, &point, &light, scattered, &mut step) as u32;
            }
        }

        // shade_surface: BSDF sample
        let words = numbers(bsdf_block(event));
        let u = [unit(words[0]) as Real, unit(words[1]) as Real];
        let bounce = if setup.strategy == Strategy::Uniform && !delta {
            Some(bsdf::sample_uniformly(material, point.normal, ray.direction, u))
        } else {
            bsdf::sample(material, point.normal, incoming, point.front, u, unit(words[2]) as Real)
        };
        let Some(mut bounce) = bounce else { break };
        let Some(kept) = point.to_consistent_hemisphere(bounce.direction, bounce.delta) else { break };
        bounce.direction = kept;
        step.beta *= bounce.factor;
        previous = remember(setup, &bounce, light_chosen, point.normal);
        step.note(Event { direction: bounce.direction, pdf: bounce.pdf_dir, ..here(kind.name()) });
        step.depth += 1;

        // shade_surface: nothing more to find?
        let last = step.depth == setup.max_depth;
        if last && !emission_can_count(setup, previous) {
            break;
        }

        // shade_surface: Russian roulette
        // A throughput below the normal numbers is as good as none; left alone it would not even shrink: three quarters
        // of the smallest number round to the smallest number, and a path without roulette would run to the guard.
        let survival = max_element(step.beta);
        if !(survival >= Real::MIN_POSITIVE) {
            break;
        }
        if step.depth >= setup.rr_depth {
            let survival = if survival < 1.0 { survival } else { 1.0 };
            if !((unit(words[3]) as Real) < survival) {
                step.note(here("roulette"));
                break;
            }
            step.beta *= 1.0 / survival;
        }
        let through = bounce.direction.dot(point.geometric_normal) < 0.0;
        let origin = if through { point.origin_behind } else { point.origin };
        ray = Ray { origin, direction: bounce.direction, tmin: 0.0, tmax: Real::INFINITY };
    }
    result.radiance = step.radiance;
    result
}

/// The material with its texture at `uv` in its colour; `None` if it has no texture.
fn textured(scene: &PreparedScene, material: &MaterialRecord, uv: [Real; 2]) -> Option<MaterialRecord> {
    (material.texture != NO_TEXTURE).then(|| {
        let color = vec3(material.color) * look_up(&scene.textures, material.texture, uv);
        let mut textured = *material;
        textured.color = [color.x as f32, color.y as f32, color.z as f32];
        textured
    })
}

/// Adds the contribution of a light sample if nothing blocks it; whether a shadow ray was traced. `scattered`: BSDF times
/// cosine towards the light, and the density with which the BSDF itself would have drawn that direction.
fn direct_light<R: FnMut(TraceVertex)>(
    setup: &Setup,
    point: &SurfacePoint,
    light: &LightSample,
    (f_cosine, pdf_bsdf): (Vec3, Real),
    step: &mut Step<R>,
) -> bool {
    let weight = light_sample_weight(setup.strategy, light.pdf_dir, pdf_bsdf);
    let contribution = step.beta * f_cosine * light.radiance * (weight / light.pdf_dir);
    if contribution.x + contribution.y + contribution.z == 0.0 {
        return false;
    }
    let shadow_ray =
        Ray { origin: point.origin, direction: light.shadow_direction, tmin: 0.0, tmax: light.shadow_tmax };
    // intersect_shadow
    let scene = setup.scene;
    let blocked = occluded_where(&scene.bvh, &shadow_ray, &mut step.stack, |hit| is_hit(&scene.alpha_masks, hit));
    if !blocked {
        step.radiance += contribution;
    }
    let name = if blocked { LIGHT_SAMPLE_BLOCKED } else { LIGHT_SAMPLE };
    let direction = light.shadow_direction;
    step.note(Event { direction, gain: contribution, pdf: light.pdf_dir, weight, ..Event::new(name, point.position) });
    true
}

/// The ray through a point of pixel (`x`, `y`).
fn camera_ray(setup: &Setup, x: u32, y: u32, words: [u32; 4]) -> Ray {
    let camera = &setup.camera;
    // The film position is rounded to f32 in every copy of the reference: it is part of the sample's address.
    let film_x = (x as f32 + offset_in_pixel(camera.filter, unit(words[0]))) as Real;
    let film_y = (y as f32 + offset_in_pixel(camera.filter, unit(words[1]))) as Real;
    let mut origin = vec3(camera.origin);
    let mut direction = vec3(camera.corner) + vec3(camera.right) * film_x + vec3(camera.down) * film_y;
    if let Some(lens) = &camera.lens {
        let [x, y] = sample_uniform_disk([unit(words[2]) as Real, unit(words[3]) as Real]);
        let on_lens = vec3(lens.right) * x + vec3(lens.up) * y;
        origin += on_lens;
        direction = direction * lens.focus_distance as Real - on_lens;
    }
    let direction = direction * (1.0 / direction.dot(direction).sqrt());
    Ray { origin, direction, tmin: 0.0, tmax: Real::INFINITY }
}

/// Where in (or, for the tent, about) its pixel a sample lies, from a number in [0, 1): 0.5 is the centre.
fn offset_in_pixel(filter: PixelFilter, u: f32) -> f32 {
    match filter {
        PixelFilter::Box => u,
        // The inverse of the tent's distribution function.
        PixelFilter::Tent if u < 0.5 => (2.0 * u).sqrt() - 0.5,
        PixelFilter::Tent => 1.5 - (2.0 - 2.0 * u).sqrt(),
    }
}

/// What a light sample counts (design table, column "light samples").
fn light_sample_weight(strategy: Strategy, pdf_light: Real, pdf_bsdf: Real) -> Real {
    match strategy {
        Strategy::Uniform | Strategy::Bsdf => 0.0,
        Strategy::NeeSum | Strategy::NeeNoEmission | Strategy::Nee => 1.0,
        Strategy::NeeAverage => 0.5,
        Strategy::MisOneSample => 2.0 * mis::balance(pdf_light, pdf_bsdf),
        Strategy::MisBalance => mis::balance(pdf_light, pdf_bsdf),
        Strategy::MisPower => mis::power(pdf_light, pdf_bsdf),
    }
}

/// What emission found by a hit counts (design table, column "emission found by a hit counts"), where light sampling
/// would have found it with density `pdf_light`.
fn emission_weight(setup: &Setup, previous: Previous, pdf_light: Real) -> Real {
    if setup.strategy == Strategy::NeeNoEmission {
        return 0.0;
    }
    let pdf_dir = match previous {
        Previous::Certain => return 1.0,
        Previous::LightChosen => return 0.0,
        Previous::Drawn { pdf_dir, .. } => pdf_dir,
    };
    match setup.strategy {
        Strategy::Uniform | Strategy::Bsdf | Strategy::NeeSum => 1.0,
        Strategy::NeeAverage => 0.5,
        Strategy::NeeNoEmission | Strategy::Nee => 0.0,
        Strategy::MisOneSample => 2.0 * mis::balance(pdf_dir, pdf_light),
        Strategy::MisBalance => mis::balance(pdf_dir, pdf_light),
        Strategy::MisPower => mis::power(pdf_dir, pdf_light),
    }
}

/// Whether emission found by the next hit can count at all; if not, the last ray need not be traced.
fn emission_can_count(setup: &Setup, previous: Previous) -> bool {
    let strategy = setup.strategy;
    let lit = !setup.lights.is_empty();
    let excluded = match previous {
        Previous::Certain => strategy == Strategy::NeeNoEmission,
        Previous::LightChosen => true,
        Previous::Drawn { .. } => matches!(strategy, Strategy::Nee | Strategy::NeeNoEmission),
    };
    lit && !excluded
}

fn remember(setup: &Setup, bounce: &BsdfSample, light_chosen: bool, normal: Vec3) -> Previous {
    if bounce.delta {
        Previous::Certain
    } else if setup.strategy == Strategy::MisOneSample && light_chosen {
        Previous::LightChosen
    } else {
        Previous::Drawn { pdf_dir: bounce.pdf_dir, cosine: bounce.cosine, normal }
    }
}

/// The largest component, by the crate's definition of the maximum.
fn max_element(v: Vec3) -> Real {
    let xy = if v.x > v.y { v.x } else { v.y };
    if xy > v.z { xy } else { v.z }
}

/// A path's state, and who is told of it.
struct Step<'a, R: FnMut(TraceVertex)> {
    depth: u32,
    beta: Vec3,
    radiance: Vec3,
    stack: intersect::Stack,
    record: &'a mut R,
}

/// What a [`TraceVertex`] tells besides the path's state.
struct Event {
    name: &'static str,
    triangle: u32,
    t: Real,
    position: Vec3,
    direction: Vec3,
    gain: Vec3,
    pdf: Real,
    weight: Real,
}

impl Event {
    #[inline(always)]
    fn new(name: &'static str, position: Vec3) -> Event {
        let zero = Vec3::ZERO;
        Event { name, triangle: NO_HIT, t: 0.0, position, direction: zero, gain: zero, pdf: 0.0, weight: 0.0 }
    }
}

impl<R: FnMut(TraceVertex)> Step<'_, R> {
    #[inline(always)]
    fn note(&mut self, event: Event) {
        let wide = |v: Vec3| [v.x as f64, v.y as f64, v.z as f64];
        (self.record)(TraceVertex {
            depth: self.depth,
            event: event.name,
            triangle: event.triangle,
            t: event.t as f64,
            position: wide(event.position),
            direction: wide(event.direction),
            beta: wide(self.beta),
            gain: wide(event.gain),
            radiance: wide(self.radiance),
            pdf: event.pdf as f64,
            weight: event.weight as f64,
        });
    }
}
