//! Rows for what surfaces and lights do: every material kind, every light selection. Rows of tables are named by number, so
//! idle lanes repeat a live row, as in the queues.

use crate::common::prepared;
use crate::runner::{Idle, Kernel, check, columns, direction, lanes3, number, vec3};
use octray::internal::lanes::{F32x8, Mask8, U32x8, Vec3x8};
use octray::internal::reference::single::bsdf::sample::BsdfSample;
use octray::internal::reference::single::lights::tree::Receiver;
use octray::internal::reference::single::surface::surface_point;
use octray::internal::reference::single::{Vec3, bsdf, lights, mis};
use octray::internal::sampler::draws::BsdfDraws;
use octray::internal::sampler::random_words;
use octray::internal::simd::native::kernels::bsdf::conductor::Conductor;
use octray::internal::simd::native::kernels::bsdf::dielectric::Dielectric;
use octray::internal::simd::native::kernels::bsdf::diffuse::Diffuse;
use octray::internal::simd::native::kernels::bsdf::mirror::Mirror;
use octray::internal::simd::native::kernels::bsdf::plastic::Plastic;
use octray::internal::simd::native::kernels::bsdf::principled::Principled;
use octray::internal::simd::native::kernels::bsdf::{Bsdf, Specular};
use octray::internal::simd::native::kernels::lights::tree::Receivers;
use octray::internal::simd::native::kernels::surface::surface_points;
use octray::internal::simd::native::kernels::{lights as lights_x8, mis as mis_x8, warp as warp_x8};
use octray::internal::strategy::{TABLE, Weight};
use octray::internal::tables::lights::table::LightTable;
use octray::internal::tables::materials::MaterialRecord;
use octray::scene::desc::{MaterialDesc, Scattering};
use octray::{Lights, PreparedScene};

#[test]
fn weights_of_all_strategies() {
    let rules: Vec<Weight> = TABLE.iter().flat_map(|row| [row.light_sample, row.hit, row.certain_hit]).collect();
    for rule in rules {
        let seed = |i| [crate::runner::anything(i, 0), crate::runner::anything(i, 1)];
        let (lanes, scalar) =
            (|[a, b]: [F32x8; 2]| [mis_x8::weigh(rule, a, b)], |[a, b]: [f32; 2]| [mis::weigh(rule, a, b)]);
        check(&Kernel { name: "weigh", seed: &seed, lanes: &lanes, scalar: &scalar, idle: Idle::Poison });
    }
}

fn records(scatterings: &[Scattering]) -> Vec<MaterialRecord> {
    let record = |&scattering| MaterialRecord::new(&MaterialDesc { scattering, ..MaterialDesc::default() });
    scatterings.iter().map(record).collect()
}

fn name_of(i: u32, count: usize) -> f32 {
    (i as usize % count) as f32
}

type Evaluate = fn(&MaterialRecord, Vec3, Vec3) -> (Vec3, f32);
type Sample = fn(&MaterialRecord, Vec3, [f32; 2], f32) -> Option<BsdfSample>;

/// A kind with a density: BSDF times cosine and density towards `wi`, and what sampling gives.
fn check_bsdf<B: Bsdf>(name: &str, scatterings: &[Scattering], evaluate: Evaluate, sample: Sample) {
    let materials = records(scatterings);
    let seed = |i| {
        let ([a, b, c], [d, e, f]) = (direction(i, 1), direction(i, 9));
        [name_of(i, materials.len()), a, b, c, d, e, f]
    };
    let lanes = |v: [F32x8; 7]| {
        let scattered = B::load(&materials, U32x8::from_f32(v[0])).evaluate(lanes3(&v[1..4]), lanes3(&v[4..]));
        let [x, y, z] = columns(scattered.f_cosine);
        [x, y, z, scattered.pdf_dir]
    };
    let scalar = |v: [f32; 7]| {
        let (f, pdf) = evaluate(&materials[v[0] as usize], vec3(&v[1..4]), vec3(&v[4..]));
        [f.x, f.y, f.z, pdf]
    };
    check(&Kernel { name, seed: &seed, lanes: &lanes, scalar: &scalar, idle: Idle::Repeat });

    let seed = |i| {
        let [x, y, z] = direction(i, 1);
        [name_of(i, materials.len()), x, y, z, number(i, 9), number(i, 10), number(i, 11)]
    };
    let lanes = |v: [F32x8; 7]| {
        let draws = BsdfDraws { direction: [v[4], v[5]], lobe: v[6], roulette: F32x8::ZERO };
        let sampled = B::load(&materials, U32x8::from_f32(v[0])).sample(lanes3(&v[1..4]), &draws);
        let world = columns(warp_x8::to_world(sampled.wi, Vec3x8::splat([0.0, 0.0, 1.0])));
        let [a, b, c] = columns(sampled.weight);
        [world[0], world[1], world[2], a, b, c, sampled.pdf_dir].map(|x| sampled.valid.select(x, F32x8::ZERO))
    };
    let scalar = |v: [f32; 7]| {
        let sampled = sample(&materials[v[0] as usize], vec3(&v[1..4]), [v[4], v[5]], v[6]);
        sampled.map_or([0.0; 7], |s| {
            [s.direction.x, s.direction.y, s.direction.z, s.weight.x, s.weight.y, s.weight.z, s.pdf_dir]
        })
    };
    check(&Kernel { name, seed: &seed, lanes: &lanes, scalar: &scalar, idle: Idle::Repeat });
}

#[test]
fn kinds_with_a_density() {
    let diffuse = [[0.0; 3], [0.5, 0.2, 1.0]].map(|albedo| Scattering::Diffuse { albedo });
    check_bsdf::<Diffuse>(
        "diffuse",
        &diffuse,
        |m, _, wi| bsdf::diffuse::evaluate(m, wi.z),
        |m, _, u, _| Some(bsdf::diffuse::sample(m, Vec3::Z, u)),
    );
    let index = Some(([0.2, 0.9, 1.1], [3.9, 2.4, 2.2]));
    let metal = [(1e-4, None), (0.1, index), (0.5, None), (1.0, index)]
        .map(|(alpha, complex_ior)| Scattering::Conductor { alpha, reflectance: [0.9, 0.6, 0.3], complex_ior });
    check_bsdf::<Conductor>("conductor", &metal, bsdf::conductor::evaluate, |m, wo, u, _| {
        bsdf::conductor::sample(m, Vec3::Z, wo, u)
    });
    let plastic = [(1e-4, 1.5), (0.2, 1.0), (1.0, 2.4)].map(|(alpha, ior)| Scattering::Plastic {
        albedo: [0.8, 0.5, 0.0],
        ior,
        alpha,
    });
    check_bsdf::<Plastic>("plastic", &plastic, bsdf::plastic::evaluate, |m, wo, u, lobe| {
        bsdf::plastic::sample(m, Vec3::Z, wo, u, lobe)
    });
    let principled = [(0.0, 0.0, 1.5), (0.4, 0.5, 1.0), (1.0, 0.7, 1.5), (0.7, 1.0, 2.4)]
        .map(|(metallic, roughness, ior)| (metallic, roughness, ior, [0.8, 0.5, 0.0]))
        .into_iter()
        .chain([(1.0, 0.3, 1.5, [0.0; 3]), (0.5, 0.3, 1.5, [1.0; 3])])
        .map(|(metallic, roughness, ior, base_color)| Scattering::Principled { base_color, metallic, roughness, ior });
    let principled: Vec<_> = principled.collect();
    check_bsdf::<Principled>("principled", &principled, bsdf::principled::evaluate, |m, wo, u, lobe| {
        bsdf::principled::sample(m, Vec3::Z, wo, u, lobe)
    });
}

type Scatter = fn(&MaterialRecord, Vec3, Vec3, bool, f32) -> BsdfSample;

/// A kind with single directions.
fn check_specular<S: Specular>(name: &str, scatterings: &[Scattering], scatter: Scatter) {
    let materials = records(scatterings);
    let seed = |i: u32| {
        let ([a, b, c], [d, e, f]) = (direction(i, 1), direction(i, 9));
        [name_of(i, materials.len()), a, b, c, d, e, f, (i >> 3 & 1) as f32, number(i, 17)]
    };
    let lanes = |v: [F32x8; 9]| {
        let material = S::load(&materials, U32x8::from_f32(v[0]));
        let front: Mask8 = v[7].gt(F32x8::splat(0.5));
        let (direction, weight, _) = material.sample(lanes3(&v[4..7]), lanes3(&v[1..4]), front, v[8]);
        let ([a, b, c], [d, e, f]) = (columns(direction), columns(weight));
        [a, b, c, d, e, f]
    };
    let scalar = |v: [f32; 9]| {
        let s = scatter(&materials[v[0] as usize], vec3(&v[1..4]), vec3(&v[4..7]), v[7] > 0.5, v[8]);
        [s.direction.x, s.direction.y, s.direction.z, s.weight.x, s.weight.y, s.weight.z]
    };
    check(&Kernel { name, seed: &seed, lanes: &lanes, scalar: &scalar, idle: Idle::Repeat });
}

#[test]
fn kinds_with_single_directions() {
    let mirror = [[0.0; 3], [0.9, 1.0, 0.1]].map(|reflectance| Scattering::Mirror { reflectance });
    check_specular::<Mirror>("mirror", &mirror, |m, n, incoming, _, _| bsdf::mirror::sample(m, n, incoming));
    let glass = [1.5, 1.0, 0.7].map(|ior| Scattering::Dielectric { ior, transmittance: [1.0, 0.5, 0.0] });
    check_specular::<Dielectric>("dielectric", &glass, bsdf::dielectric::sample);
}

/// A triangle, a point on it (u, v), the direction it is seen in, and the words of its light sample.
type Place = (u32, [f32; 2], [f32; 3], [u32; 4]);

/// The place on a scene's triangles that seed `i` names.
fn place(scene: &PreparedScene, i: u32) -> Place {
    let triangle = random_words(i, 5, 0, 1)[0] % scene.triangles.len() as u32;
    let uv = [0.5 * number(i, 1), 0.5 * number(i, 2)];
    (triangle, uv, scene.triangles[triangle as usize].normal.map(|x| -x), random_words(i, 6, 0, 1))
}

/// Choosing a light and drawing a point of it, from anywhere on a scene's triangles.
fn check_lights(path: &str, selection: Lights, compensated: bool) {
    let scene = prepared(path);
    let table = LightTable::new(&scene, selection, compensated);
    let name = format!("lights of {path}, {selection}");
    let seed = |i: u32| [i as f32];
    let lanes = |[seeds]: [F32x8; 1]| {
        let places = seeds.to_array().map(|i| place(&scene, i as u32));
        let number = |of: &dyn Fn(&Place) -> f32| F32x8::from_array(places.each_ref().map(of));
        let seen = Vec3x8::new(number(&|p| p.2[0]), number(&|p| p.2[1]), number(&|p| p.2[2]));
        let triangle = U32x8::from_array(places.map(|p| p.0));
        let tables = (&scene.triangles[..], &scene.corners[..]);
        let points = surface_points::<false>(tables, triangle, number(&|p| p.1[0]), number(&|p| p.1[1]), seen);
        let words: [U32x8; 4] = std::array::from_fn(|w| U32x8::from_array(places.map(|p| p.3[w])));
        let receivers = Receivers { origin: points.origin, normal: points.normal, row: U32x8::ZERO };
        let choice = lights_x8::choose::choose(&table, &receivers, Mask8::ALL, words[0]);
        let light = lights_x8::sample::sample_lights(&table, &points, U32x8::ZERO, Mask8::ALL, &words.into());
        let ([a, b, c], [d, e, f]) = (columns(light.direction), columns(light.shadow_direction));
        let sample = [a, b, c, d, e, f, light.cosine, light.radiance.x, light.pdf_dir, light.shadow_tmax];
        let sample = sample.map(|x| light.valid.select(x, F32x8::ZERO));
        let emitter = choice.environment.select(F32x8::splat(-1.0), choice.emitter.to_f32());
        std::array::from_fn(|m| match m {
            0 => emitter,
            1 => choice.probability,
            _ => sample[m - 2],
        })
    };
    let scalar = |[i]: [f32; 1]| -> [f32; 12] {
        let (triangle, [u, v], seen, words) = place(&scene, i as u32);
        let point = surface_point(&scene.triangles[triangle as usize], None, u, v, Vec3::from(seen));
        let receiver = Receiver { origin: point.origin, normal: point.normal, row: 0 };
        let (light, probability, _) = lights::choose::choose(&table, &receiver, words[0]);
        assert_eq!(lights::choose::probability(&table, &receiver, light).to_bits(), probability.to_bits());
        let emitter = match light {
            lights::choose::Light::Environment => -1.0,
            lights::choose::Light::Emitter(emitter) => emitter as f32,
        };
        let sample = lights::sample::sample_light(&table, &point, 0, &words.into()).map_or([0.0; 10], |s| {
            let (d, t) = (s.direction, s.shadow_direction);
            [d.x, d.y, d.z, t.x, t.y, t.z, s.cosine, s.radiance.x, s.pdf_dir, s.shadow_tmax]
        });
        std::array::from_fn(|m| match m {
            0 => emitter,
            1 => probability,
            _ => sample[m - 2],
        })
    };
    check(&Kernel { name: &name, seed: &seed, lanes: &lanes, scalar: &scalar, idle: Idle::Repeat });
}

#[test]
fn light_samples_under_every_selection() {
    for &selection in Lights::ALL {
        check_lights("builtin:lamp_hall:100", selection, false);
        check_lights("scenes/sky.toml", selection, true);
        check_lights("scenes/lecture_lights.toml", selection, false);
    }
}
