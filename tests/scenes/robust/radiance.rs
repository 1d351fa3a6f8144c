//! The range of radiance: up to the largest that is accepted, and down to where f64 ends, no product overflows, and a scene
//! whose lights are a power of two brighter has the same picture, as much brighter, to the last bit.

use super::shapes::{add, skew, sphere};
use crate::common::{Maker, small};
use octray::scene::SceneDesc;
use octray::scene::desc::{EnvironmentDesc, MapDesc, Scattering};
use octray::scene::validate::MOST_RADIANCE;
use octray::{Engine, Lights, PreparedScene, Sampler, Settings, Strategy, render};

const DARK: [f64; 3] = [0.0; 3];

/// The largest power of two that is accepted.
const MOST: i32 = 99;

/// The sharpest and the strongest of every kind of surface.
fn stiff_surfaces(maker: &mut Maker) -> [u32; 6] {
    let metal = ([0.2, 0.9, 1.5], [3.9, 2.4, 2.1]);
    [
        Scattering::Conductor { alpha: 1e-4, reflectance: [1.0; 3], complex_ior: None },
        Scattering::Conductor { alpha: 1e-3, reflectance: [1.0; 3], complex_ior: Some(metal) },
        Scattering::Plastic { albedo: [1.0, 0.9, 0.8], ior: 20.0, alpha: 1e-4 },
        Scattering::Principled { base_color: [1.0, 0.9, 0.8], metallic: 0.5, roughness: 0.0, ior: 20.0 },
        Scattering::Dielectric { ior: 20.0, transmittance: [1.0; 3] },
        Scattering::Mirror { reflectance: [1.0; 3] },
    ]
    .map(|scattering| maker.material(scattering, DARK))
}

/// A box with a ball of each surface, its walls sharp metal, lit by lamps of several solid angles: a panel, a needle, a speck,
/// one that all but touches the floor.
fn room(radiance: f64) -> SceneDesc {
    let mut maker = Maker::default();
    let white = maker.diffuse([1.0; 3], DARK);
    let balls = stiff_surfaces(&mut maker);
    let lamp = maker.diffuse([0.5; 3], [radiance, 0.5 * radiance, 0.25 * radiance]);
    let dim = maker.diffuse([0.0; 3], [1e-9 * radiance; 3]);
    maker.cuboid([-1.0; 3], [1.0; 3], true, white);
    maker.quad([[-0.9, -0.99, -0.99], [0.9, -0.99, -0.99], [0.9, 0.9, -0.99], [-0.9, 0.9, -0.99]], balls[0]);
    maker.quad([[-0.99, -0.9, -0.9], [-0.99, 0.9, -0.9], [-0.99, 0.9, 0.9], [-0.99, -0.9, 0.9]], balls[2]);
    for (i, material) in balls.into_iter().enumerate() {
        let center = glam::DVec3::new(0.32 * i as f64 - 0.8, -0.7, 0.2 * i as f64 - 0.5);
        add(&mut maker, &sphere(2), material, |p| skew() * p * 0.18 + center);
    }
    let level = |maker: &mut Maker, [x, y, z]: [f32; 3], [a, b]: [f32; 2], material| {
        maker.quad([[x - a, y, z - b], [x + a, y, z - b], [x + a, y, z + b], [x - a, y, z + b]], material);
    };
    level(&mut maker, [0.0, 0.9, 0.0], [0.3, 0.3], lamp);
    level(&mut maker, [0.0, 0.5, 0.0], [0.5, 1e-4], lamp);
    level(&mut maker, [0.3, 0.2, 0.3], [1e-5, 1e-5], lamp);
    level(&mut maker, [-0.4, -1.0 + 1e-4, 0.5], [0.2, 0.2], lamp);
    level(&mut maker, [0.5, 0.8, 0.5], [0.01, 0.01], dim);
    maker.desc.camera.position = [0.1, 0.0, 0.95];
    maker.desc.camera.vertical_fov = 80.0;
    (maker.desc.name, maker.desc.film) = ("radiances".into(), (16, 16));
    maker.whole()
}

/// The same surfaces in the open, lit by a map with one bright texel or by even light.
fn open(radiance: f64, map: bool) -> SceneDesc {
    let mut scene = room(1.0);
    for material in &mut scene.materials {
        material.emission = DARK;
    }
    scene.meshes[0].triangles.retain(|t| t.material != 0);
    let texels = (0..64 * 32).map(|i| if i == 517 { [1.0, 0.75, 0.5] } else { [1e-6; 3] }).collect();
    let sky = MapDesc { width: 64, height: 32, texels, scale: radiance, ..MapDesc::default() };
    scene.set_environment(Some(match map {
        true => EnvironmentDesc::Map(sky),
        false => EnvironmentDesc::Constant { radiance: [radiance, 0.5 * radiance, 0.25 * radiance] },
    }));
    scene
}

fn prepared(scene: &SceneDesc) -> PreparedScene {
    PreparedScene::new(scene).unwrap_or_else(|error| panic!("{error}"))
}

/// Renders of `make(2^n)` are those of `make(1)` times 2^n, and finite.
fn assert_scales(make: impl Fn(f64) -> SceneDesc, settings: &Settings, exponents: &[i32]) {
    let plain = prepared(&make(1.0));
    for strategy in Strategy::ALL.iter().copied() {
        for lights in [Lights::Uniform, Lights::Power, Lights::Tree] {
            let settings = Settings { strategy, lights, ..settings.clone() };
            let expected = render(&plain, &settings);
            assert_eq!(expected.stats.nonfinite, 0, "{strategy}, {lights}");
            for &n in exponents {
                let scale = 2f64.powi(n);
                let scene = prepared(&make(scale));
                let found = render(&scene, &settings);
                let what = format!("2^{n}, {strategy}, {lights}, {}", settings.sampler);
                assert_eq!(found.stats.nonfinite, 0, "{what}: {:?}", found.stats.nonfinite_samples);
                for (a, b) in found.film.pixels.iter().zip(&expected.film.pixels) {
                    assert_eq!(a.sum, b.sum.map(|x| x * scale), "{what}");
                }
                for (a, b) in found.film.squares.iter().zip(&expected.film.squares) {
                    assert_eq!(a.0, b.0.map(|x| x * scale * scale), "{what}");
                }
                for (a, b) in found.film.groups.iter().zip(&expected.film.groups) {
                    assert_eq!(a.0, b.0.map(|group| group.map(|x| x * scale)), "{what}");
                }
                let image = found.film.to_image();
                let variance = image.variance.iter().flatten();
                assert!(image.pixels.iter().chain(variance).flatten().all(|x| x.is_finite() && *x >= 0.0), "{what}");
            }
        }
    }
}

#[test]
fn a_room_as_bright_as_is_accepted_has_the_picture_of_an_ordinary_one() {
    let settings = Settings { sampler: Sampler::Independent, ..small(10, 10, 8) };
    assert_scales(room, &settings, &[MOST, 41, -140]);
}

#[test]
fn surroundings_as_bright_as_is_accepted_too() {
    let settings = Settings { max_depth: Some(6), ..small(8, 8, 8) };
    assert_scales(|radiance| open(radiance, true), &settings, &[MOST, 41, -99]);
    assert_scales(|radiance| open(radiance, false), &settings, &[MOST, 41, -140]);
}

#[test]
fn both_engines_count_in_the_same_unit() {
    for scale in [2f64.powi(MOST), 1e25, 1e-25] {
        let scene = prepared(&room(scale));
        let settings = small(8, 8, 4);
        let films = Engine::ALL.iter().map(|&engine| render(&scene, &Settings { engine, ..settings.clone() }).film);
        let films: Vec<_> = films.collect();
        assert!(crate::common::first_difference(&films[0], &films[1]).is_none(), "{scale}");
        assert!(films[0].mean_radiance()[0] > 1e-3 * scale, "{scale}: {:?}", films[0].mean_radiance());
    }
}

#[test]
fn brighter_lights_are_refused_with_the_largest_radiance_that_works() {
    let most = f64::from(MOST_RADIANCE);
    let fault = |scene: SceneDesc| PreparedScene::new(&scene).err().map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(fault(room(most)) + &fault(open(most, true)) + &fault(open(most, false)), "");
    for radiance in [1.001 * most, 1e31, 1e38, 3e38] {
        let said = [fault(room(radiance)), fault(open(radiance, true)), fault(open(radiance, false))];
        assert!(said.iter().all(|message| message.contains("1e30")), "{said:?}");
    }
}
