//! Environment maps of many rows, lit by one texel next to a pole: there y = 1 - 1e-8 is 1 in f32, and rows are told apart by
//! versines. Expectations of the f32 kernels are summed over strata in f64; closed forms are integrals over the unrounded
//! texel.

use crate::common::{Maker, estimate, first_difference, small};
use glam::DVec3;
use octray::internal::lanes::{F32x8, LANES, U32x8, Vec3x8};
use octray::internal::reference::single::lights::environment::{map_pdf_dir, sample_map, texel_index};
use octray::internal::sampler::{random_words, unit};
use octray::internal::simd::native::kernels::lights::environment as environment_x8;
use octray::internal::tables::lights::environment::{Distribution, EnvironmentMap, LEAST_DENSITY};
use octray::scene::desc::{EnvironmentDesc, MapDesc};
use octray::{Engine, Settings, Strategy, render};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// A map that is black but for the texel at `lit`.
fn one_texel(width: u32, height: u32, lit: (u32, u32)) -> MapDesc {
    let mut texels = vec![[0.0; 3]; (width * height) as usize];
    texels[(lit.1 * width + lit.0) as usize] = [1e6, 2e6, 3e6];
    MapDesc { file: "a test's map".into(), width, height, texels, rotate: 30.0, scale: 1.0 }
}

/// Maps and the texels to light: rows at and near both poles, and some in between.
fn cases() -> Vec<(u32, u32, (u32, u32))> {
    let mut cases = Vec::new();
    for (width, height) in [(4, 4096), (8, 4096), (8, 8192), (4, 8191), (4, 16_384), (8, 16_383)] {
        for row in [0, 1, 2, 7, height / 5] {
            cases.push((width, height, (row % width, row)));
            cases.push((width, height, (width - 1, height - 1 - row)));
        }
    }
    cases
}

/// The unrounded direction at (`column`, `row`), counted in texels, of the map `desc`.
fn exact(desc: &MapDesc, column: f64, row: f64) -> DVec3 {
    // In the hemisphere's own angle: pi - 1e-4 has lost digits.
    let rows = f64::from(desc.height);
    let from_pole = row.min(rows - row) / rows * PI;
    let (sine, cosine) = from_pole.sin_cos();
    let (s, c) = ((column / f64::from(desc.width) - desc.rotate / 360.0) * TAU).sin_cos();
    DVec3::new(-sine * s, if 2.0 * row < rows { cosine } else { -cosine }, sine * c)
}

/// The solid angle of rows `top` to `bottom` over all columns.
fn band(desc: &MapDesc, top: f64, bottom: f64) -> f64 {
    let rows = f64::from(desc.height);
    TAU * 2.0 * ((top + bottom) / (2.0 * rows) * PI).sin() * ((bottom - top) / (2.0 * rows) * PI).sin()
}

/// Normals of floors that see the texel: towards it, and far from it.
fn normals(desc: &MapDesc, (column, row): (u32, u32)) -> [DVec3; 2] {
    let towards = exact(desc, f64::from(column) + 0.5, f64::from(row) + 0.5);
    [towards, (towards + DVec3::new(1.5, 0.2, -0.4)).normalize()]
}

/// What every strategy's estimate of the irradiance through one texel comes to in the mean: light samples, directions of the
/// surface's own, and both of them weighed by the balance heuristic, against radiance times the integral of the cosine.
#[test]
fn every_estimate_of_one_polar_texel_is_right() {
    // Strata a row, a column.
    const ROWS: u32 = 128;
    const COLUMNS: u32 = 48;
    for (width, height, lit) in cases() {
        let desc = one_texel(width, height, lit);
        let map = EnvironmentMap::new(&desc, 1.0);
        let distribution = map.distribution(false);
        for normal in normals(&desc, lit) {
            let what = format!("{width} x {height}, texel {lit:?}, normal {normal}");
            let cosine = |direction: glam::Vec3| direction.as_dvec3().dot(normal).max(0.0);
            let balance = |a: f64, b: f64| if a > 0.0 { a / (a + b) } else { 0.0 };
            let [mut truth, mut light, mut light_weighed, mut surface, mut surface_weighed] = [0.0; 5];
            for i in 0..ROWS * COLUMNS {
                let u = [(i % COLUMNS) as f32 + 0.5, (i / COLUMNS) as f32 + 0.5];
                let u = [u[0] / COLUMNS as f32, u[1] / ROWS as f32];
                let (direction, texel) = sample_map(&map, distribution, [random_words(i, 0, 0, 1)[0], 0], u);
                let pdf = f64::from(map_pdf_dir(distribution, &texel));
                let gain = f64::from(texel.radiance[0]) * cosine(direction) / pdf;
                light += gain / f64::from(ROWS * COLUMNS);
                let by_surface = cosine(direction) * FRAC_1_PI;
                light_weighed += gain * balance(pdf, by_surface) / f64::from(ROWS * COLUMNS);
            }
            // All directions of the texel and a texel around it, as the surface may draw them.
            let (left, top) = (f64::from(lit.0), f64::from(lit.1));
            for i in 0..3 * ROWS {
                let row = top - 1.0 + (f64::from(i) + 0.5) / f64::from(ROWS);
                if !(0.0..f64::from(height)).contains(&row) {
                    continue;
                }
                let half = 0.5 / f64::from(ROWS);
                let solid_angle = band(&desc, row - half, row + half) / f64::from(width * COLUMNS);
                for j in 0..3 * COLUMNS {
                    let column = left - 1.0 + (f64::from(j) + 0.5) / f64::from(COLUMNS);
                    let direction = exact(&desc, column, row);
                    let inside = (COLUMNS..2 * COLUMNS).contains(&j) && (ROWS..2 * ROWS).contains(&i);
                    if inside {
                        truth += 1e6 * direction.dot(normal).max(0.0) * solid_angle;
                    }
                    let texel = &map.texels[texel_index(&map, direction.as_vec3())];
                    let found = f64::from(texel.radiance[0]) * cosine(direction.as_vec3()) * solid_angle;
                    surface += found;
                    let by_surface = cosine(direction.as_vec3()) * FRAC_1_PI;
                    surface_weighed += found * balance(by_surface, f64::from(map_pdf_dir(distribution, texel)));
                }
            }
            for (name, got) in [("light", light), ("surface", surface), ("both", light_weighed + surface_weighed)] {
                // Rows away from the poles end at versines of 24 bits, which is 1e-4 of the row of 16,384.
                let polar = lit.1 < 10 || lit.1 + 10 >= height;
                let bound = if polar { 2e-5 } else { 1e-4 };
                assert!(
                    (got / truth - 1.0).abs() < bound,
                    "{what}: {name} {got}, truth {truth}: {:e}",
                    got / truth - 1.0
                );
            }
        }
    }
}

/// A direction is looked up in the texel it was drawn in, but for 0.2 % of a row's height or a column's width at its ends.
#[test]
fn looking_up_inverts_sampling_in_maps_of_many_rows() {
    for (width, height) in [(1, 16_384), (4, 16_384), (8, 8192), (3, 8191), (2, 4097), (5, 3), (4, 2), (2, 1)] {
        let even = MapDesc { texels: vec![[1.0; 3]; (width * height) as usize], ..one_texel(width, height, (0, 0)) };
        let map = EnvironmentMap::new(&even, 1.0);
        let distribution = Distribution { columns: map.distribution(false).columns.clone(), floor: 0.0, factor: 1.0 };
        let (mut drawn, mut missed) = (0, 0);
        for i in 0..60_000 {
            let w = random_words(i, 2, 7, 4);
            // Half of them in the first and last rows.
            let word = match i % 4 {
                0 => w[0] >> 12,
                1 => !(w[0] >> 12),
                _ => w[0],
            };
            let u = [unit(w[1]), unit(w[2])];
            let index = distribution.choose([word, w[3]]) as usize;
            let (direction, _) = sample_map(&map, &distribution, [word, w[3]], u);
            let found = texel_index(&map, direction);
            let inside =
                u.iter().all(|u| (0.002..0.998).contains(u)) && (height % 2 == 0 || (u[1] - 0.5).abs() > 0.002);
            assert!(!inside || found == index, "{width} x {height}: {direction} of {index} found in {found}, u {u:?}");
            (drawn, missed) = (drawn + 1, missed + (found != index) as u32);
        }
        assert!(f64::from(missed) < 1e-3 * f64::from(drawn), "{width} x {height}: {missed} of {drawn}");
    }
}

#[test]
fn polar_rows_have_the_same_bits_on_lanes() {
    for (width, height, lit) in cases() {
        let map = EnvironmentMap::new(&one_texel(width, height, lit), 1.0);
        let distribution = map.distribution(false);
        for first in (0..400u32).step_by(LANES) {
            let words: [[u32; 4]; LANES] = std::array::from_fn(|i| random_words(first + i as u32, 3, 1, 4));
            let word = |c: usize| U32x8::from_array(words.map(|w| w[c]));
            let u = |c: usize| F32x8::from_array(words.map(|w| unit(w[c])));
            let (direction, _) = environment_x8::sample_map(&map, distribution, [word(0), word(3)], [u(1), u(2)]);
            let [x, y, z] = [direction.x, direction.y, direction.z].map(F32x8::to_array);
            // Found again, and so are their neighbours nearer to the pole and farther from it.
            for stretch in [1.0, 0.3, 3.0] {
                let moved =
                    Vec3x8::new(direction.x * F32x8::splat(stretch), direction.y, direction.z * F32x8::splat(stretch));
                let index = environment_x8::texel_indices(&map, moved).to_array();
                for i in 0..LANES {
                    let w = words[i];
                    let (wanted, _) = sample_map(&map, distribution, [w[0], w[3]], [unit(w[1]), unit(w[2])]);
                    assert_eq!([x[i], y[i], z[i]].map(f32::to_bits), wanted.to_array().map(f32::to_bits));
                    let wanted = texel_index(&map, glam::Vec3::new(stretch * x[i], y[i], stretch * z[i]));
                    assert_eq!(index[i] as usize, wanted, "{width} x {height}");
                }
            }
        }
    }
}

/// The same as a picture: a floor under (or a ceiling above) one texel, seen by the camera.
#[test]
fn one_polar_texel_lights_a_floor() {
    for (height, from_pole) in [(4096, 0), (16_384, 0), (16_384, 3)] {
        for south in [false, true] {
            let row = if south { height - 1 - from_pole } else { from_pole };
            let desc = one_texel(4, height, (1, row));
            let mut maker = Maker::default();
            let floor = maker.diffuse([0.5; 3], [0.0; 3]);
            let mut corners = [[-50.0, 0.0, 50.0], [50.0, 0.0, 50.0], [50.0, 0.0, -50.0], [-50.0, 0.0, -50.0]];
            if south {
                corners.reverse();
            }
            maker.quad(corners, floor);
            // Irradiance: an azimuth of a quarter turn times half the difference of the squared sines.
            let sine = |row: u32| (f64::from(row) / f64::from(height) * PI).sin().powi(2);
            let truth = 1e6 * 0.5 / PI * 0.25 * PI * (sine(from_pole + 1) - sine(from_pole));
            maker.desc.set_environment(Some(EnvironmentDesc::Map(desc)));
            let scene = maker.seen([3.0, if south { -2.5 } else { 2.5 }, 4.0], [0.0; 3], 1.0);
            assert_eq!(scene.warnings, Vec::<String>::new());
            for strategy in [Strategy::Nee, Strategy::MisBalance, Strategy::MisPower] {
                let settings = Settings { strategy, max_depth: Some(1), ..small(8, 8, 4) };
                let film = render(&scene, &settings).film;
                let mean = estimate(&film, 0..8, 0..8, 0).mean;
                assert!((mean / truth - 1.0).abs() < 2e-5, "{height} rows, {row}, {strategy}: {mean}, truth {truth}");
                let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings }).film;
                assert_eq!(first_difference(&film, &scalar), None);
            }
        }
    }
}

/// What light samples are drawn with is what estimators are told, texel by texel: shares of the alias table against density
/// times solid angle, however far radiances lie apart; and nothing that shines is out of reach.
#[test]
fn densities_are_those_of_the_draws() {
    for contrast in [1.0f32, 1e3, 1e12, 1e30] {
        for (width, height) in [(8, 4096), (7, 5), (64, 33)] {
            let texel = |i: u32| match random_words(i, 5, 5, 9).map(unit) {
                [pick, ..] if pick < 0.2 => [0.0; 3],
                [pick, ..] if pick > 0.999 || i == width => [contrast; 3],
                [_, a, b, c] => [a, b, c],
            };
            let texels = (0..width * height).map(texel).collect();
            let map = EnvironmentMap::new(&MapDesc { texels, ..one_texel(width, height, (0, 0)) }, 1.0);
            for compensated in [false, true] {
                let distribution = map.distribution(compensated);
                let columns = &distribution.columns;
                let mut drawn = vec![0.0; columns.len()];
                for (i, column) in columns.iter().enumerate() {
                    drawn[i] += f64::from(column.threshold) / 2f64.powi(32) / columns.len() as f64;
                    let rest = 1.0 - f64::from(column.threshold) / 2f64.powi(32);
                    drawn[column.alias as usize] += rest / columns.len() as f64;
                }
                for (i, texel) in map.texels.iter().enumerate() {
                    let density = f64::from(map_pdf_dir(distribution, texel));
                    let stated = density * map.solid_angle(i);
                    // A share is rounded to a whole 2^-32 of a column.
                    let bound = 3e-7 * stated + 2f64.powi(-32) / columns.len() as f64;
                    assert!((drawn[i] - stated).abs() <= bound, "{contrast}, texel {i}: {}, stated {stated}", drawn[i]);
                    assert_eq!(drawn[i] > 0.0, density > 0.0, "{contrast}, texel {i}");
                    let least = LEAST_DENSITY / (4.0 * PI) * (1.0 - 1e-6);
                    assert!(compensated || texel.radiance == [0.0; 3] || density >= least, "texel {i}: {density}");
                }
            }
        }
    }
}

/// A sky under a sun 1e12 times as bright that the floor cannot see. By light samples alone one in 256 goes to the sky.
#[test]
fn a_sky_is_found_though_a_hidden_sun_outshines_it() {
    let (width, height) = (8, 4);
    let texels = (0..width * height).map(|i| if i == width * height - 3 { [1e12; 3] } else { [1.0; 3] }).collect();
    for lamp in [false, true] {
        let mut maker = Maker::default();
        let floor = maker.diffuse([0.5; 3], [0.0; 3]);
        maker.quad([[-50.0, 0.0, 50.0], [50.0, 0.0, 50.0], [50.0, 0.0, -50.0], [-50.0, 0.0, -50.0]], floor);
        if lamp {
            // Hidden too: it shines down, far below. Beside it a selection word has 29 bits left for the sky.
            let light = maker.diffuse([0.0; 3], [1.0; 3]);
            maker.quad([[-1.0, -9.0, -1.0], [1.0, -9.0, -1.0], [1.0, -9.0, 1.0], [-1.0, -9.0, 1.0]], light);
        }
        let texels: Vec<[f32; 3]> = Vec::clone(&texels);
        let map = MapDesc { texels, ..one_texel(width, height, (0, 0)) };
        maker.desc.set_environment(Some(EnvironmentDesc::Map(map)));
        let scene = maker.seen([3.0, 2.5, 4.0], [0.0; 3], 1.0);
        let settings = Settings { strategy: Strategy::Nee, max_depth: Some(1), ..small(16, 16, 2048) };
        let got = estimate(&render(&scene, &settings).film, 0..16, 0..16, 0);
        assert!((got.mean - 0.5).abs() < 5.0 * got.error, "lamp {lamp}: {} +- {}", got.mean, got.error);
        assert!(got.error < 0.03, "lamp {lamp}: +- {} proves nothing", got.error);
    }
}

/// Rows finer than f32 can draw are told of when loading, before they are wrong by more than 0.1 %.
#[test]
fn rows_too_fine_for_f32_are_warned_of() {
    let lit = |height: u32, row: u32| {
        let mut maker = Maker::default();
        let floor = maker.diffuse([0.5; 3], [0.0; 3]);
        maker.quad([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]], floor);
        maker.desc.set_environment(Some(EnvironmentDesc::Map(one_texel(1, height, (0, row)))));
        maker.seen([3.0, 2.5, 4.0], [0.0; 3], 1.0).warnings
    };
    let height = 65_535;
    let desc = one_texel(1, height, (0, 0));
    let map = EnvironmentMap::new(&desc, 1.0);
    let error = |row: u32| {
        let exact = band(&desc, f64::from(row), f64::from(row + 1));
        (map.solid_angle(row as usize) / exact - 1.0).abs()
    };
    let worst = (0..height).max_by(|&a, &b| error(a).total_cmp(&error(b))).expect("rows");
    assert!(error(worst) > 1e-3, "{}", error(worst));
    assert!(lit(height, worst).iter().any(|warning| warning.contains("65535 rows")), "{:?}", lit(height, worst));
    for row in [0, 1, 100] {
        assert_eq!(lit(height, row), Vec::<String>::new(), "row {row}");
    }
}
