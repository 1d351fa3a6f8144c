//! Environment maps: kernels against their twins, densities against samples, pictures against closed forms.

use crate::common::{Maker, estimate, exact_strategies, first_difference, small};
use glam::DVec3;
use octray::internal::lanes;
use octray::internal::lanes::{F32x8, LANES, U32x8, Vec3x8};
use octray::internal::math;
use octray::internal::reference::{double, single};
use octray::internal::sampler::{random_words, unit};
use octray::internal::simd::native::kernels::lights::environment as environment_x8;
use octray::internal::tables::lights::environment::{Distribution, EnvironmentMap};
use octray::scene::desc::{EnvironmentDesc, MapDesc, Scattering};
use octray::{Crop, Engine, PreparedScene, Settings, Strategy, render};
use std::f64::consts::PI;

/// A map of `width` x `height` with the radiance that `texel` gives for column and row.
fn map(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> MapDesc {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
    MapDesc { file: "a test's map".into(), width, height, texels, rotate: 0.0, scale: 1.0 }
}

/// Uneven, with black texels and one hot one.
fn rugged(width: u32, height: u32, rotate: f64) -> EnvironmentMap {
    let texel = |x: u32, y: u32| {
        let [a, b, c, d] = random_words(x, y, 5, 9).map(unit);
        let gain = if d < 0.2 { 0.0 } else { d * d };
        if (x, y) == (width / 3, height / 4) { [900.0, 800.0, 700.0] } else { [a * gain, b * gain, c * gain] }
    };
    EnvironmentMap::new(&MapDesc { rotate, ..map(width, height, texel) }, 1.0)
}

const SIZES: [(u32, u32); 6] = [(1, 1), (3, 2), (7, 5), (64, 32), (100, 51), (1024, 512)];

fn bits(v: [f32; 3]) -> [u32; 3] {
    v.map(f32::to_bits)
}

fn lane(v: Vec3x8, lane: usize) -> [f32; 3] {
    [v.x, v.y, v.z].map(|c| c.to_array()[lane])
}

/// Directions all over the sphere, along axes and next to them, and not quite of unit length.
fn directions(count: u32) -> Vec<[f32; 3]> {
    let axes = [-1.0, -0.0, 0.0, 1.0f32].iter().flat_map(|&x| [-1.0, -0.0, 0.0, 1.0].map(|y| [x, y]));
    let axes = axes.flat_map(|[x, y]| [-1.0, -0.0, 0.0, 1.0, 1e-30, -1e-8].map(|z| [x, y, z]));
    let axes = axes.filter(|v| v[0].abs() + v[1].abs() + v[2].abs() > 0.5);
    let unit_length = |v: [f32; 3]| (DVec3::from(v.map(f64::from)).normalize()).as_vec3().to_array();
    let random =
        (0..count).map(|i| random_words(i, 1, 2, 3).map(|w| unit(w) * 2.0 - 1.0)).map(|[x, y, z, _]| [x, y, z]);
    let random = random.filter(|v| v[0].abs() + v[1].abs() + v[2].abs() > 0.1);
    let mut all: Vec<[f32; 3]> = axes.chain(random).map(unit_length).collect();
    all.extend([[0.0, 1.000_000_1, 0.0], [0.0, -1.000_000_1, 0.0], [1e-9, 1.0, -1e-9]]);
    all.truncate(all.len() / LANES * LANES);
    all
}

fn lanes3(v: &[[f32; 3]]) -> Vec3x8 {
    let column = |c: usize| F32x8::from_array(std::array::from_fn(|lane| v[lane][c]));
    Vec3x8::new(column(0), column(1), column(2))
}

#[test]
fn angles_have_the_same_bits_on_lanes() {
    for block in directions(40_000).chunks_exact(LANES) {
        let v = lanes3(block);
        let turns = lanes::atan2_turns(v.x, v.z).to_array();
        let half = lanes::polar_half_turns(F32x8::ONE - v.y.abs()).to_array();
        for i in 0..LANES {
            let [x, y, z] = block[i];
            assert_eq!(turns[i].to_bits(), math::atan2_turns(x, z).to_bits(), "{x} {z}");
            let versine = 1.0 - y.abs();
            assert!(half[i].to_bits() == math::polar_half_turns(versine).to_bits() || versine < 0.0, "{y}");
        }
    }
}

#[test]
fn sampling_and_looking_up_have_the_same_bits_on_lanes() {
    for (width, height) in SIZES {
        let map = rugged(width, height, 77.0);
        for distribution in [map.distribution(false), map.distribution(true)] {
            for first in (0..4000u32).step_by(LANES) {
                let words: [[u32; 4]; LANES] = std::array::from_fn(|i| random_words(first + i as u32, 0, 1, 4));
                let word = |c: usize| U32x8::from_array(words.map(|w| w[c]));
                let u = |c: usize| F32x8::from_array(words.map(|w| unit(w[c])));
                let (direction, texels) =
                    environment_x8::sample_map(&map, distribution, [word(0), word(3)], [u(1), u(2)]);
                let pdf = environment_x8::map_pdf_dir(distribution, &texels).to_array();
                for i in 0..LANES {
                    let w = words[i];
                    let (wanted, texel) = single::lights::environment::sample_map(
                        &map,
                        distribution,
                        [w[0], w[3]],
                        [unit(w[1]), unit(w[2])],
                    );
                    assert_eq!(bits(lane(direction, i)), bits(wanted.to_array()));
                    assert_eq!(bits(lane(texels.radiance, i)), bits(texel.radiance));
                    let wanted = single::lights::environment::map_pdf_dir(distribution, &texel);
                    assert_eq!(pdf[i].to_bits(), wanted.to_bits());
                    assert!(wanted > 0.0, "a texel of density 0 was drawn");
                }
            }
        }
        for block in directions(8000).chunks_exact(LANES) {
            let index = environment_x8::texel_indices(&map, lanes3(block)).to_array();
            for i in 0..LANES {
                let wanted = single::lights::environment::texel_index(&map, block[i].into());
                assert_eq!(index[i] as usize, wanted, "{:?}", block[i]);
            }
        }
    }
}

#[test]
fn a_sampled_direction_is_looked_up_where_it_was_drawn() {
    for (width, height) in SIZES.into_iter().chain([(2048, 1024)]) {
        for rotate in [0.0, 90.0, -123.4, 719.0] {
            let map = rugged(width, height, rotate);
            let uniform = Distribution {
                columns: (0..width * height)
                    .map(|alias| octray::internal::tables::lights::alias::AliasColumn { threshold: 0, alias })
                    .collect(),
                floor: 0.0,
                factor: 1.0,
            };
            for i in 0..20_000u32 {
                let w = random_words(i, 0, 1, 4);
                // Not at the very rim of a texel, where rounding decides.
                let inside = |w: u32| 0.002 + 0.996 * unit(w);
                let u = [inside(w[1]), inside(w[2])];
                let (direction, _) = single::lights::environment::sample_map(&map, &uniform, [w[0], 0], u);
                let index = uniform.choose([w[0], 0]) as usize;
                let found = single::lights::environment::texel_index(&map, direction);
                assert!(found == index, "{width} x {height}, {direction}: {found} instead of {index}");
                let u = u.map(f64::from);
                let (wide, _) = double::lights::environment::sample_map(&map, &uniform, [w[0], 0], u);
                assert!((wide - direction.as_dvec3()).length() < 8e-7, "{wide} {direction}");
                assert!(double::lights::environment::texel_index(&map, wide) == index);
            }
        }
    }
}

#[test]
fn densities_integrate_to_one_and_cover_what_shines() {
    for (width, height) in SIZES {
        let map = rugged(width, height, 0.0);
        let sphere: f64 = (0..map.texels.len()).map(|i| map.solid_angle(i)).sum();
        assert!((sphere / (4.0 * PI) - 1.0).abs() < 1e-10, "the texels tile the sphere: {sphere}");
        for compensated in [false, true] {
            let distribution = map.distribution(compensated);
            let pdf = |i: usize| single::lights::environment::map_pdf_dir(distribution, &map.texels[i]) as f64;
            let total: f64 = (0..map.texels.len()).map(|i| pdf(i) * map.solid_angle(i)).sum();
            assert!((total - 1.0).abs() < 2e-6, "{width} x {height}, compensated: {compensated}: {total}");
            let shines = |i: &usize| map.texels[*i].radiance != [0.0; 3];
            let lost = (0..map.texels.len()).filter(shines).filter(|&i| pdf(i) == 0.0).count();
            assert!(compensated || lost == 0, "{lost} texels shine and are never drawn");
        }
    }
    let even = EnvironmentMap::new(&map(8, 4, |_, _| [0.3, 0.2, 0.1]), 1.0);
    let (plain, compensated) = (even.distribution(false), even.distribution(true));
    assert_eq!(plain.columns, compensated.columns, "a map without contrast has nothing to compensate");
}

/// Pearson's chi-square test of drawn texels against their densities, at significance 1e-4 (fixed seeds: passes once,
/// passes always), by the Wilson-Hilferty normal approximation; and inside texels by quarters.
#[test]
fn samples_follow_their_densities() {
    const SAMPLES: u32 = 2_000_000;
    const QUANTILE: f64 = 3.72;
    for (width, height) in [(7, 5), (64, 32)] {
        let map = rugged(width, height, 33.0);
        for compensated in [false, true] {
            let distribution = map.distribution(compensated);
            let mut counts = vec![[0u32; 4]; map.texels.len()];
            for i in 0..SAMPLES {
                let w = random_words(i, 7, 1, 4);
                let u = [unit(w[1]), unit(w[2])];
                let (direction, _) = single::lights::environment::sample_map(&map, distribution, [w[0], w[3]], u);
                let quarter = (u[0] >= 0.5) as usize + 2 * (u[1] >= 0.5) as usize;
                counts[single::lights::environment::texel_index(&map, direction)][quarter] += 1;
            }
            let (mut chi, mut cells, mut rest) = (0.0, 0.0, [0.0; 2]);
            for (i, quarters) in counts.iter().enumerate() {
                let pdf = single::lights::environment::map_pdf_dir(distribution, &map.texels[i]) as f64;
                let expected = SAMPLES as f64 * pdf * map.solid_angle(i) / 4.0;
                for &count in quarters {
                    if expected < 10.0 {
                        rest = [rest[0] + expected, rest[1] + count as f64];
                    } else {
                        chi += (count as f64 - expected).powi(2) / expected;
                        cells += 1.0;
                    }
                }
            }
            if rest[0] > 10.0 {
                chi += (rest[1] - rest[0]).powi(2) / rest[0];
                cells += 1.0;
            }
            let freedom: f64 = cells - 1.0;
            let spread = 2.0 / (9.0 * freedom);
            let z = ((chi / freedom).cbrt() - (1.0 - spread)) / spread.sqrt();
            assert!(z < QUANTILE, "{width} x {height}, compensated {compensated}: chi^2 {chi} of {freedom}, z {z}");
        }
    }
}

/// The mean of a film's pixels, channel by channel, is `truth` within five standard errors, which prove something.
fn assert_mean(scene: &PreparedScene, settings: &Settings, truth: [f64; 3], precision: f64, what: &str) {
    let film = render(scene, settings).film;
    for (channel, truth) in truth.into_iter().enumerate() {
        let got = estimate(&film, 0..film.width, 0..film.height, channel);
        let bound = 5.0 * got.error + 2e-5 * truth;
        assert!((got.mean - truth).abs() <= bound, "{what}: {} +- {}, truth {truth}", got.mean, got.error);
        assert!(bound <= precision * truth, "{what}: {} +- {} proves nothing", got.mean, got.error);
    }
}

#[test]
fn a_constant_map_is_a_constant_environment() {
    let mut maker = Maker::default();
    let stone = maker.diffuse([0.75, 0.5, 0.25], [0.0; 3]);
    maker.cuboid([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], false, stone);
    maker.desc.set_environment(Some(EnvironmentDesc::Map(MapDesc {
        rotate: 10.0,
        scale: 2.0,
        ..map(16, 8, |_, _| [0.5, 1.0, 1.5])
    })));
    let scene = maker.seen([3.0, 2.5, 4.0], [0.3, 0.1, 0.2], 10.0);
    for strategy in exact_strategies() {
        let settings = Settings { strategy, ..small(16, 16, 512) };
        assert_mean(&scene, &settings, [0.75, 1.0, 0.75], 0.05, strategy.name());
    }
}

/// A floor under a map that is dim but for one texel: radiance of the floor from the texels' own integrals of the cosine.
#[test]
fn one_hot_texel_lights_a_floor() {
    let (width, height, hot) = (32, 16, (20, 3));
    let picture = map(width, height, |x, y| if (x, y) == hot { [1e4, 2e4, 3e4] } else { [1.0; 3] });
    let mut maker = Maker::default();
    let floor = maker.diffuse([0.5; 3], [0.0; 3]);
    maker.quad([[-50.0, 0.0, 50.0], [50.0, 0.0, 50.0], [50.0, 0.0, -50.0], [-50.0, 0.0, -50.0]], floor);
    maker.desc.set_environment(Some(EnvironmentDesc::Map(MapDesc { rotate: 200.0, ..picture })));
    let scene = maker.seen([3.0, 2.5, 4.0], [0.0, 0.0, 0.0], 1.0);
    // Irradiance of a texel: integral of cos over azimuth and cos theta = d_phi (c0^2 - c1^2) / 2.
    let cosine = |row: u32| (row as f64 / height as f64 * PI).cos();
    let part = 2.0 * PI / width as f64 * (cosine(hot.1).powi(2) - cosine(hot.1 + 1).powi(2)) / 2.0;
    let truth = [1e4, 2e4, 3e4].map(|l| 0.5 / PI * (PI - part + l * part));
    for strategy in
        [Strategy::NeeAverage, Strategy::Nee, Strategy::MisOneSample, Strategy::MisBalance, Strategy::MisPower]
    {
        let settings = Settings { strategy, max_depth: Some(1), ..small(16, 16, 512) };
        let precision = if strategy == Strategy::NeeAverage { 0.3 } else { 0.05 };
        assert_mean(&scene, &settings, truth, precision, strategy.name());
    }
    let bsdf = Settings { strategy: Strategy::Bsdf, max_depth: Some(1), ..small(16, 16, 16_384) };
    assert_mean(&scene, &bsdf, truth, 0.1, "bsdf");
}

/// A camera that looks straight at the map sees each texel where the contract puts it.
#[test]
fn the_map_lies_where_the_contract_says() {
    let texel = |x: u32, y: u32| [1.0 + x as f32, 1.0 + y as f32, 7.0];
    let axes = [([0.0, 0.0, -1.0], 4), ([1.0, 0.0, 0.0], 6), ([-1.0, 0.0, 0.0], 2), ([0.0, 0.0, 1.0], 0)];
    for (rotate, shift) in [(0.0, 0), (90.0, 2), (-45.0, -1), (360.0, 0), (135.0, 3)] {
        let mut maker = Maker::default();
        let black = maker.diffuse([0.0; 3], [0.0; 3]);
        maker.quad([[0.0, -9.0, 0.0], [1e-3, -9.0, 0.0], [1e-3, -9.0, 1e-3], [0.0, -9.0, 1e-3]], black);
        maker.desc.set_environment(Some(EnvironmentDesc::Map(MapDesc { rotate, ..map(8, 4, texel) })));
        let Maker { desc, mesh } = maker;
        for (axis, column) in axes {
            // Half a texel to the right of the border at the axis, and up in the middle of a row.
            for (row, elevation) in [(0, 67.5f64), (1, 22.5), (2, -22.5), (3, -67.5)] {
                let forward = DVec3::from(axis);
                let right = forward.cross(DVec3::Y);
                let azimuth = 22.5f64.to_radians();
                let level = forward * azimuth.cos() + right * azimuth.sin();
                let (sine, cosine) = elevation.to_radians().sin_cos();
                let look = (level * cosine + DVec3::Y * sine).to_array();
                let scene = Maker { desc: desc.clone(), mesh: mesh.clone() }.seen([0.0; 3], look, 5.0);
                // Turned by `rotate` about +y the surroundings move to the left: what is seen comes from columns further right.
                let wanted = texel((column + shift) as u32 % 8, row);
                for strategy in Strategy::ALL.iter().filter(|s| **s != Strategy::NeeNoEmission) {
                    let film = render(&scene, &Settings { strategy: *strategy, ..small(3, 3, 1) }).film;
                    assert!(
                        film.pixels.iter().all(|p| p.sum == wanted.map(f64::from)),
                        "{rotate}, {axis:?}, row {row}"
                    );
                }
            }
        }
    }
}

#[test]
fn engines_agree_under_a_map_with_and_without_other_lights() {
    for lamp in [false, true] {
        let mut maker = Maker::default();
        let stone = maker.diffuse([0.75, 0.5, 0.25], [0.0; 3]);
        let mirror = maker.material(Scattering::Mirror { reflectance: [0.9; 3] }, [0.0; 3]);
        let light = maker.diffuse([0.0; 3], [5.0, 4.0, 3.0]);
        maker.quad([[-5.0, -1.0, 5.0], [5.0, -1.0, 5.0], [5.0, -1.0, -5.0], [-5.0, -1.0, -5.0]], stone);
        maker.cuboid([-1.0, -1.0, -1.0], [0.2, 1.0, 1.0], false, stone);
        maker.cuboid([0.5, -1.0, -1.0], [1.5, 0.5, 0.0], false, mirror);
        let metal = Scattering::Conductor { alpha: 0.2, reflectance: [0.9, 0.7, 0.4], complex_ior: None };
        let metal = maker.material(metal, [0.0; 3]);
        maker.cuboid([0.5, -1.0, 0.4], [1.2, 0.0, 1.2], false, metal);
        let coated = maker.material(Scattering::Plastic { albedo: [0.3, 0.5, 0.7], ior: 1.5, alpha: 0.1 }, [0.0; 3]);
        maker.cuboid([-0.8, 1.0, -0.5], [0.0, 1.4, 0.5], false, coated);
        if lamp {
            maker.quad([[-0.5, 3.0, -0.5], [0.5, 3.0, -0.5], [0.5, 3.0, 0.5], [-0.5, 3.0, 0.5]], light);
        }
        let hot = |x: u32, y: u32| if (x, y) == (9, 4) { [3000.0; 3] } else { [0.1 * x as f32, 0.5, 0.1 * y as f32] };
        maker.desc.set_environment(Some(EnvironmentDesc::Map(MapDesc { rotate: 50.0, ..map(32, 16, hot) })));
        let scene = maker.seen([3.0, 2.5, 4.0], [0.3, 0.1, 0.2], 40.0);
        let base = small(24, 24, 600);
        let reference = render(&scene, &Settings { spp: 4000, seed: 9, threads: 0, ..base.clone() }).film;
        for &strategy in Strategy::ALL {
            let settings = Settings { strategy, spp: 4, ..base.clone() };
            let packet = render(&scene, &settings);
            let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings });
            assert_eq!(first_difference(&packet.film, &scalar.film), None, "{strategy}, lamp: {lamp}");
            assert_eq!((packet.stats.nonfinite, packet.stats.rays), (0, scalar.stats.rays));
            // The hot texel makes strategies that only hit it by chance too noisy for a normal test.
            if matches!(strategy, Strategy::Nee | Strategy::MisOneSample | Strategy::MisBalance) {
                let film = render(&scene, &Settings { strategy, threads: 0, ..base.clone() }).film;
                for channel in 0..3 {
                    let [a, b] = [&film, &reference].map(|f| estimate(f, 0..24, 0..24, channel));
                    let z = (a.mean - b.mean) / a.error.hypot(b.error);
                    assert!(z.abs() < 5.0, "{strategy}, lamp {lamp}: {} and {}, z = {z:.1}", a.mean, b.mean);
                }
            }
        }
    }
}

/// The map of `scenes/sky.toml`, texel by texel: a sky that whitens towards the horizon and the sun, a grey-brown ground,
/// and a sun three texels wide, 38 degrees high, 40 degrees to the left of the picture's centre.
fn sky(x: u32, y: u32) -> [f32; 3] {
    let direction = |azimuth: f64, polar: f64| {
        let (azimuth, polar) = (azimuth * PI / 180.0, polar * PI / 180.0);
        DVec3::new(libm::sin(polar) * libm::sin(azimuth), libm::cos(polar), -libm::sin(polar) * libm::cos(azimuth))
    };
    let here = direction((x as f64 + 0.5) / SKY.0 as f64 * 360.0 - 180.0, (y as f64 + 0.5) / SKY.1 as f64 * 180.0);
    let to_sun = 1.0 - here.dot(direction(-40.0, 52.0));
    if to_sun < 6.5e-4 {
        return [1900.0, 1700.0, 1400.0];
    }
    if here.y < 0.0 {
        return [0.16, 0.15, 0.13];
    }
    let (height, glow) = (here.y.sqrt(), 0.004 / (0.004 + to_sun));
    let blend = |horizon: f64, zenith: f64, sun: f64| (horizon + (zenith - horizon) * height + sun * glow) as f32;
    [blend(0.85, 0.10, 2.5), blend(0.90, 0.22, 2.2), blend(0.95, 0.55, 1.7)]
}

/// Size of [`sky`].
const SKY: (u32, u32) = (256, 128);

fn sky_film() -> octray::Film {
    let mut film = octray::Film::new(Crop { x: 0, y: 0, width: SKY.0, height: SKY.1 });
    film.spp = 1;
    for (i, pixel) in film.pixels.iter_mut().enumerate() {
        pixel.sum = sky(i as u32 % SKY.0, i as u32 / SKY.0).map(f64::from);
    }
    film
}

#[test]
fn the_sky_of_our_scene_is_what_its_generator_makes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("sky.hdr");
    sky_film().save(&path).expect("a map");
    let [made, committed] =
        [path.as_path(), "scenes/sky.hdr".as_ref()].map(|p| octray::internal::image::Image::read(p).unwrap());
    assert_eq!(made, committed);
}

/// `cargo test --test engines make_the_sky -- --ignored` writes `scenes/sky.hdr`.
#[test]
#[ignore = "writes into the source tree"]
fn make_the_sky() {
    sky_film().save("scenes/sky.hdr").expect("a map");
}
