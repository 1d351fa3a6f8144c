//! Metals, glass, plastics and their mixtures: engines of equal bits; energy, reciprocity and densities against what physics and
//! probability ask for. Statistical bounds are stated where they are used; seeds are fixed.

use crate::common::{Maker, chi_square_z, estimate, exact_strategies, first_difference, small};
use octray::internal::reference::double::{Real, Vec3, bsdf};
use octray::internal::sampler::{random_words, unit};
use octray::internal::tables::materials::MaterialRecord;
use octray::scene::desc::{MaterialDesc, Scattering};
use octray::{Engine, Lights, Scene, Settings, Strategy, render};

const GOLD: ([f64; 3], [f64; 3]) = ([0.143, 0.375, 1.442], [3.983, 2.386, 1.603]);

fn glossy() -> Vec<(&'static str, Scattering)> {
    let conductor = |alpha: f64| Scattering::Conductor { alpha, reflectance: [0.9, 0.8, 0.7], complex_ior: None };
    let plastic = |alpha: f64| Scattering::Plastic { albedo: [0.8, 0.5, 0.2], ior: 1.5, alpha };
    let principled = |metallic: f64, roughness: f64| Scattering::Principled {
        base_color: [0.8, 0.5, 0.2],
        metallic,
        roughness,
        ior: 1.5,
    };
    vec![
        ("metal, alpha 1e-4", conductor(1e-4)),
        ("metal, alpha 0.01", conductor(0.01)),
        ("metal, alpha 0.15", conductor(0.15)),
        ("metal, alpha 1", conductor(1.0)),
        ("gold", Scattering::Conductor { alpha: 0.2, reflectance: [1.0; 3], complex_ior: Some(GOLD) }),
        ("plastic, alpha 0.02", plastic(0.02)),
        ("plastic, alpha 0.3", plastic(0.3)),
        ("plastic, alpha 1", plastic(1.0)),
        ("principled, smooth", principled(0.0, 0.0)),
        ("principled, a third metal", principled(1.0 / 3.0, 0.5)),
        ("principled, metal", principled(1.0, 0.6)),
    ]
}

fn record(scattering: Scattering) -> MaterialRecord {
    MaterialRecord::new(&MaterialDesc { scattering, ..MaterialDesc::default() })
}

fn numbers(i: u32, block: u32) -> [Real; 4] {
    random_words(i, 1, block, 4242).map(|word| unit(word) as Real)
}

/// A direction towards the surface whose back makes this cosine with +z.
fn incoming(cosine: Real) -> Vec3 {
    Vec3::new(-(1.0 - cosine * cosine).sqrt(), 0.0, -cosine)
}

#[test]
fn engines_agree_bit_for_bit_on_every_material_and_strategy() {
    let glass = ("glass", Scattering::Dielectric { ior: 1.5, transmittance: [0.9, 1.0, 0.8] });
    for (name, scattering) in glossy().into_iter().chain([glass]) {
        let mut scene = Scene::load("scenes/cornell.toml").expect("a scene of ours");
        for block in ["tall_block", "short_block", "white"] {
            if let Some(material) = scene.desc.materials.iter_mut().find(|m| m.name == block) {
                material.scattering = scattering;
            }
        }
        scene.desc.set_environment(Some(octray::scene::desc::EnvironmentDesc::Constant { radiance: [0.1, 0.2, 0.3] }));
        let scene = scene.prepare().expect("a scene of ours");
        for &strategy in Strategy::ALL {
            for (lights, max_depth) in [(Lights::Uniform, None), (Lights::Power, Some(2))] {
                let settings = Settings { strategy, lights, max_depth, ..small(32, 24, 3) };
                let packet = render(&scene, &settings);
                let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings });
                let what = format!("{name}, {strategy}, {lights}, depth {max_depth:?}");
                assert_eq!(first_difference(&packet.film, &scalar.film), None, "{what}");
                assert_eq!(packet.stats.rays, scalar.stats.rays, "{what}");
                assert_eq!(packet.stats.nonfinite, 0, "{what}");
            }
        }
    }
}

/// The mean weight of `SAMPLES` draws in a white furnace, and its standard error.
fn reflected(material: &MaterialRecord, cosine: Real) -> (Real, Real) {
    const SAMPLES: u32 = 20_000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..SAMPLES {
        let [a, b, lobe, _] = numbers(i, 3);
        let drawn = bsdf::sample(material, Vec3::Z, incoming(cosine), true, [a, b], lobe);
        let weight = drawn.map_or(0.0, |s| s.weight.x);
        sum += weight;
        squares += weight * weight;
    }
    let n = SAMPLES as Real;
    (sum / n, ((squares / n - (sum / n).powi(2)).max(0.0) / n).sqrt())
}

/// The same by quadrature of the evaluated BSDF over (z, phi), for lobes that a grid resolves.
fn reflected_by_quadrature(material: &MaterialRecord, cosine: Real) -> Real {
    const SIDE: usize = 400;
    let mut sum = 0.0;
    for i in 0..SIDE * SIDE {
        let (z, turn) = ((i / SIDE) as Real + 0.5, (i % SIDE) as Real + 0.5);
        let (z, (sine, cosine_phi)) = (z / SIDE as Real, (turn / SIDE as Real * std::f64::consts::TAU).sin_cos());
        let wi = Vec3::new((1.0 - z * z).sqrt() * cosine_phi, (1.0 - z * z).sqrt() * sine, z);
        sum += bsdf::evaluate(material, Vec3::Z, incoming(cosine), wi).0.x;
    }
    sum * std::f64::consts::TAU / (SIDE * SIDE) as Real
}

fn white(scattering: Scattering) -> Scattering {
    match scattering {
        Scattering::Conductor { alpha, .. } => {
            Scattering::Conductor { alpha, reflectance: [1.0; 3], complex_ior: None }
        }
        Scattering::Plastic { ior, alpha, .. } => Scattering::Plastic { albedo: [1.0; 3], ior, alpha },
        Scattering::Principled { metallic, roughness, ior, .. } => {
            Scattering::Principled { base_color: [1.0; 3], metallic, roughness, ior }
        }
        other => other,
    }
}

/// The white furnace: what a surface reflects of light 1 from everywhere is never above 1.
#[test]
fn no_material_reflects_more_than_arrives() {
    for (name, scattering) in glossy() {
        let material = record(white(scattering));
        for cosine in [1.0, 0.8, 0.5, 0.2, 0.05] {
            let (mean, error) = reflected(&material, cosine);
            assert!(mean <= 1.0 + 5.0 * error + 1e-9, "{name} at cosine {cosine}: reflects {mean} +- {error}");
        }
    }
}

/// What white GGX metal loses in the furnace, in percent, at cosines 1, 0.5 and 0.2: single scattering loses what further
/// bounces among the facets would have saved. Drawn weights and the integral of the evaluated BSDF tell the same; at
/// alpha 1 the normals are cosine-distributed and the loss at normal incidence is exactly ln 2. (`--nocapture` prints it.)
#[test]
fn the_loss_of_rough_metal_is_as_stated() {
    const TABLE: [(f64, [f64; 3]); 8] = [
        (0.01, [0.01, 0.03, 0.11]),
        (0.05, [0.28, 0.74, 3.67]),
        (0.1, [1.30, 3.08, 9.54]),
        (0.2, [5.24, 10.48, 14.16]),
        (0.3, [12.27, 17.83, 16.15]),
        (0.5, [31.22, 30.17, 21.01]),
        (0.7, [49.63, 41.01, 26.93]),
        (1.0, [69.31, 54.93, 35.84]),
    ];
    println!("alpha  loss in percent at cosine 1, 0.5, 0.2");
    for (alpha, stated) in TABLE {
        let material = record(white(Scattering::Conductor { alpha, reflectance: [1.0; 3], complex_ior: None }));
        let losses = [1.0, 0.5, 0.2].map(|cosine| {
            let (mean, error) = reflected(&material, cosine);
            if alpha < 0.1 {
                return (100.0 * (1.0 - mean), 500.0 * error);
            }
            let integral = reflected_by_quadrature(&material, cosine);
            assert!((mean - integral).abs() < 5.0 * error + 1e-4, "alpha {alpha} at {cosine}: {mean} and {integral}");
            (100.0 * (1.0 - integral), 0.0)
        });
        println!("{alpha:<5}  {:.2}  {:.2}  {:.2}", losses[0].0, losses[1].0, losses[2].0);
        for ((loss, noise), stated) in losses.into_iter().zip(stated) {
            assert!((loss - stated).abs() < 0.011 + noise, "alpha {alpha}: {loss} % lost, {stated} % stated");
        }
        if alpha == 1.0 {
            assert!((losses[0].0 - 100.0 * std::f64::consts::LN_2).abs() < 0.01, "ln 2: {}", losses[0].0);
        }
    }
}

#[test]
fn glossy_bsdfs_are_reciprocal() {
    for (name, scattering) in glossy() {
        let material = record(scattering);
        for i in 0..2000 {
            let [a, b, c, d] = numbers(i, 5);
            let direction = |u: Real, v: Real| {
                let z = 0.05 + 0.95 * u;
                let r = (1.0 - z * z).sqrt();
                {
                    let (sine, cosine) = (v * std::f64::consts::TAU).sin_cos();
                    Vec3::new(r * cosine, r * sine, z)
                }
            };
            let (wo, wi) = (direction(a, b), direction(c, d));
            let (there, _) = bsdf::evaluate(&material, Vec3::Z, -wo, wi);
            let (back, _) = bsdf::evaluate(&material, Vec3::Z, -wi, wo);
            // The functions return BSDF times the cosine of the light's direction.
            let (there, back) = (there / wi.z, back / wo.z);
            let difference = (there - back).abs().max_element();
            assert!(difference <= 1e-9 * (there.abs().max_element() + 1e-30), "{name}: {there} and {back}");
        }
    }
}

/// Pearson's chi-square over a grid of (cos theta, phi) cells: counts of drawn directions against the integrated density.
/// Significance 0.1 % for the file (Sidak: 1.25e-5 each of 80 tests), by the Wilson-Hilferty normal form: z below 4.3.
#[test]
fn directions_are_drawn_with_their_density() {
    const SAMPLES: u32 = 60_000;
    const ROWS: usize = 24;
    const COLUMNS: usize = 24;
    for (name, scattering) in glossy() {
        let material = record(scattering);
        // Lobes far narrower than a cell have no density a grid could integrate; their kernels are the same code.
        if material.alpha < 0.1 {
            continue;
        }
        for cosine in [0.95, 0.5, 0.15] {
            let wo = incoming(cosine);
            let mut counts = vec![0.0; ROWS * COLUMNS];
            let mut drawn = 0.0;
            for i in 0..SAMPLES {
                let [a, b, lobe, _] = numbers(i, 9);
                let Some(s) = bsdf::sample(&material, Vec3::Z, wo, true, [a, b], lobe) else { continue };
                let turn = s.direction.y.atan2(s.direction.x) / std::f64::consts::TAU + 0.5;
                let row = ((s.direction.z * ROWS as Real) as usize).min(ROWS - 1);
                let column = ((turn * COLUMNS as Real) as usize).min(COLUMNS - 1);
                counts[row * COLUMNS + column] += 1.0;
                drawn += 1.0;
            }
            let mut expected = vec![0.0; ROWS * COLUMNS];
            const FINE: usize = 12;
            for (cell, expected) in expected.iter_mut().enumerate() {
                for k in 0..FINE * FINE {
                    let z = ((cell / COLUMNS) as Real + ((k / FINE) as Real + 0.5) / FINE as Real) / ROWS as Real;
                    let turn = ((cell % COLUMNS) as Real + ((k % FINE) as Real + 0.5) / FINE as Real) / COLUMNS as Real;
                    let (sine, cosine) = ((turn - 0.5) * std::f64::consts::TAU).sin_cos();
                    let r = (1.0 - z * z).sqrt();
                    let (_, pdf) = bsdf::evaluate(&material, Vec3::Z, wo, Vec3::new(r * cosine, r * sine, z));
                    *expected += pdf;
                }
                let solid_angle = std::f64::consts::TAU / (ROWS * COLUMNS * FINE * FINE) as Real;
                *expected *= solid_angle * SAMPLES as Real;
            }
            let total: Real = expected.iter().sum();
            let tolerance = 5.0 * (SAMPLES as Real).sqrt() + 2e-3 * SAMPLES as Real;
            assert!((total - drawn).abs() < tolerance, "{name} at {cosine}: density {total}, drawn {drawn}");
            let z = chi_square_z(&counts, &expected);
            assert!(z < 4.3, "{name} at {cosine}: z = {z}");
        }
    }
}

/// A slab of clear glass in a furnace is invisible: what it reflects and what it lets through add up to 1.
#[test]
fn clear_glass_in_the_furnace_is_invisible() {
    let mut maker = Maker::default();
    let wall = maker.diffuse([0.5; 3], [0.5; 3]);
    let glass = maker.material(Scattering::Dielectric { ior: 1.5, transmittance: [1.0; 3] }, [0.0; 3]);
    maker.cuboid([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], true, wall);
    maker.cuboid([-0.4, -0.4, -0.6], [0.3, 0.3, -0.3], false, glass);
    let scene = maker.seen([0.1, 0.2, 0.8], [-0.1, 0.0, -1.0], 50.0);
    for strategy in exact_strategies() {
        let film = render(&scene, &Settings { strategy, ..small(24, 24, 256) }).film;
        let got = estimate(&film, 0..24, 0..24, 1);
        assert!((got.mean - 1.0).abs() < 5.0 * got.error + 1e-5, "{strategy}: {} +- {}", got.mean, got.error);
        assert!(got.error < 0.02, "{strategy}: {} is too noisy to prove anything", got.error);
    }
}

/// All exact strategies agree on every material: z-tests of the mean, 5 standard errors. On lobes narrower than 0.1 only
/// those are compared that draw from the lobe and do not count light samples whole: the others find it about never.
#[test]
fn exact_strategies_agree_on_every_material() {
    let glass = ("glass", Scattering::Dielectric { ior: 1.5, transmittance: [0.9, 1.0, 0.8] });
    for (name, scattering) in glossy().into_iter().chain([glass]) {
        let mut maker = Maker::default();
        let floor = maker.diffuse([0.5; 3], [0.0; 3]);
        let object = maker.material(scattering, [0.0; 3]);
        let light = maker.diffuse([0.0; 3], [2.0, 3.0, 4.0]);
        maker.quad([[-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0], [-4.0, 0.0, -4.0]], floor);
        maker.quad([[-1.5, 3.0, -1.5], [1.5, 3.0, -1.5], [1.5, 3.0, 1.5], [-1.5, 3.0, 1.5]], light);
        maker.cuboid([-0.7, 0.2, -0.7], [0.7, 1.2, 0.7], false, object);
        maker.desc.set_environment(Some(octray::scene::desc::EnvironmentDesc::Constant { radiance: [0.3, 0.2, 0.1] }));
        let scene = maker.seen([2.5, 2.6, 3.0], [0.0, 0.7, 0.0], 32.0);
        let settings = Settings { max_depth: Some(6), threads: 0, ..small(20, 20, 1024) };
        let truth = render(&scene, &Settings { seed: 77, spp: 4096, ..settings.clone() }).film;
        let narrow = match scattering {
            Scattering::Conductor { alpha, .. } | Scattering::Plastic { alpha, .. } => alpha < 0.1,
            Scattering::Principled { roughness, .. } => roughness * roughness < 0.1,
            _ => false,
        };
        for strategy in exact_strategies() {
            if narrow && strategy != Strategy::Bsdf && !strategy.is_mis() {
                continue;
            }
            let film = render(&scene, &Settings { strategy, ..settings.clone() }).film;
            for channel in 0..3 {
                let [a, b] = [&film, &truth].map(|f| estimate(f, 0..20, 0..20, channel));
                let z = (a.mean - b.mean) / a.error.hypot(b.error);
                assert!(z.abs() < 5.0, "{name}, {strategy}, channel {channel}: {} and {}, z = {z:.1}", a.mean, b.mean);
            }
        }
    }
}
