//! Layers: the same bits from both engines and any threads, and closed forms.

use crate::common::{Maker, SCENES, first_difference, prepared, small};
use crate::smooth::ball;
use crate::textures::{PAPERS, poster, room};
use glam::DVec3;
use octray::internal::film::layers::{LayerPixel, NOTHING, NUMBERS};
use octray::scene::desc::{CornerDesc, EnvironmentDesc, PixelFilter, Scattering};
use octray::{Crop, Engine, Film, Layer, PreparedScene, Sampler, Scene, Settings, Strategy, render};

/// Settings with all layers, and alpha.
fn all(settings: Settings) -> Settings {
    Settings { layers: Layer::ALL.to_vec(), hide_environment: true, ..settings }
}

fn bits(pixel: &LayerPixel) -> [u32; NUMBERS] {
    pixel.to_array().map(f32::to_bits)
}

/// The first pixel in which radiance or layers differ, bit for bit.
fn difference(a: &Film, b: &Film) -> Option<String> {
    let radiance = first_difference(a, b);
    if radiance.is_some() {
        return radiance;
    }
    let (a, b) = (&a.layers.pixels, &b.layers.pixels);
    assert!(!a.is_empty() && a.len() == b.len(), "{} and {} pixels", a.len(), b.len());
    let at = (0..a.len()).find(|&i| bits(&a[i]) != bits(&b[i]))?;
    Some(format!("pixel {at}: {:?} and {:?}", a[at], b[at]))
}

fn layers(scene: &PreparedScene, settings: &Settings) -> Vec<LayerPixel> {
    render(scene, settings).film.layers.pixels
}

#[test]
fn engines_and_threads_agree_bit_for_bit() {
    for path in SCENES {
        let scene = prepared(path);
        for layers_through_specular in [false, true] {
            let settings = Settings { layers_through_specular, ..all(small(49, 35, 5)) };
            let packet = render(&scene, &settings).film;
            let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings.clone() }).film;
            assert_eq!(difference(&packet, &scalar), None, "{path}, through specular {layers_through_specular}");
            let threads = render(&scene, &Settings { threads: 3, ..settings.clone() }).film;
            assert_eq!(difference(&packet, &threads), None, "{path}, threads");
            let general = Settings { plan: octray::PlanChoice::General, ..settings };
            assert_eq!(difference(&packet, &render(&scene, &general).film), None, "{path}, general plan");
        }
    }
}

#[test]
fn both_engines_see_through_every_lens_filter_and_sampler() {
    for filter in [PixelFilter::Box, PixelFilter::Tent] {
        for (aperture_radius, sampler) in [(0.0, Sampler::Independent), (12.0, Sampler::Sobol)] {
            let mut scene = Scene::load("scenes/cornell_mirror.toml").expect("a scene of ours");
            scene.desc.filter = filter;
            scene.desc.camera.aperture_radius = aperture_radius;
            scene.desc.camera.focus_distance = 1100.0;
            let scene = scene.prepare().expect("a scene of ours");
            let settings = Settings { sampler, layers_through_specular: true, ..all(small(33, 31, 4)) };
            let [packet, scalar] = [Engine::Packet, Engine::Scalar]
                .map(|engine| render(&scene, &Settings { engine, ..settings.clone() }).film);
            assert_eq!(difference(&packet, &scalar), None, "{filter:?}, aperture {aperture_radius}");
        }
    }
}

/// The film of both engines, which must be one.
fn of_both(scene: &PreparedScene, settings: &Settings) -> Film {
    let [packet, scalar] =
        [Engine::Packet, Engine::Scalar].map(|engine| render(scene, &Settings { engine, ..settings.clone() }).film);
    assert_eq!(difference(&packet, &scalar), None);
    packet
}

#[test]
fn textures_are_in_the_albedo() {
    for paper in PAPERS {
        of_both(&room(paper), &all(small(33, 27, 4)));
    }
    // Radiance of a poster in white light from everywhere is its albedo, and that of its layer.
    let mut maker = poster(2.0, Scattering::Diffuse { albedo: [0.75, 1.0, 0.5] }, false);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    let scene = maker.seen([0.5, 0.5, 2.0], [0.5, 0.5, 0.0], 20.0);
    let film = of_both(&scene, &Settings { strategy: Strategy::Bsdf, ..all(small(24, 24, 4)) });
    for (index, pixel) in (0..).zip(&film.layers.pixels) {
        let radiance = film.mean(index % 24, index / 24);
        assert!(pixel.albedo.iter().zip(radiance).all(|(a, b)| (a - b).abs() < 1e-5), "{pixel:?}, {radiance:?}");
    }
}

#[test]
fn shading_normals_are_those_of_the_smooth_surface() {
    let materials = [
        Scattering::Diffuse { albedo: [0.5; 3] },
        Scattering::Mirror { reflectance: [0.9; 3] },
        Scattering::Conductor { alpha: 0.1, reflectance: [0.9; 3], complex_ior: None },
        Scattering::Dielectric { ior: 1.5, transmittance: [0.9, 0.8, 0.7] },
        Scattering::Plastic { albedo: [0.5; 3], ior: 1.5, alpha: 0.1 },
        Scattering::Principled { base_color: [0.5; 3], metallic: 0.5, roughness: 0.3, ior: 1.5 },
    ];
    for scattering in materials {
        let mut maker = Maker::default();
        let material = maker.material(scattering, [0.0; 3]);
        let floor = maker.diffuse([0.2, 0.4, 0.6], [0.0; 3]);
        ball(&mut maker, 16, 1.0, material);
        maker.quad([[-9.0, -1.0, 9.0], [9.0, -1.0, 9.0], [9.0, -1.0, -9.0], [-9.0, -1.0, -9.0]], floor);
        maker.mesh.corners.resize(maker.mesh.triangles.len(), CornerDesc::default());
        let eye = DVec3::new(0.0, 0.0, 40.0);
        let scene = maker.seen(eye.to_array(), [0.0; 3], 2.4);
        let settings = all(small(20, 20, 1));
        of_both(&scene, &Settings { layers_through_specular: true, ..all(small(20, 20, 5)) });
        let mut most = [0.0f64; 2];
        for (index, pixel) in (0..).zip(of_both(&scene, &settings).layers.pixels) {
            // The ball about the origin, where the middle of the pixel sees it.
            let at = |i: u32| (f64::from(i) + 0.5) / 10.0 - 1.0;
            let step = 1.2f64.to_radians().tan();
            let direction = DVec3::new(at(index % 20) * step, -at(index / 20) * step, -1.0).normalize();
            let along = -eye.dot(direction);
            let off = (eye + direction * along).length_squared();
            // Away from the edge, where half a pixel is a large angle.
            if off > 0.5 {
                continue;
            }
            let wanted = eye + direction * (along - (1.0 - off).sqrt());
            for (most, normal) in most.iter_mut().zip([pixel.shading_normal, pixel.normal]) {
                *most = most.max((DVec3::from(normal.map(f64::from)) - wanted).length());
            }
        }
        // Half a pixel is 0.06 of the radius here; facets are off by half of their 11 degrees more.
        assert!(most[0] < 0.09 && most[1] > most[0] + 0.04, "{scattering:?}: {most:?}");
    }
}

#[test]
fn radiance_knows_nothing_of_layers() {
    let scene = prepared("scenes/glass.toml");
    let settings = small(40, 30, 4);
    let plain = render(&scene, &settings);
    let with = render(&scene, &Settings { layers: Layer::ALL.to_vec(), layers_through_specular: true, ..settings });
    assert_eq!(first_difference(&plain.film, &with.film), None);
    assert!(plain.film.layers.pixels.is_empty() && plain.stats.layers_s.is_none());
    assert_eq!(plain.stats.rays, with.stats.rays);
    assert!(with.film.layers.pixels.len() == 40 * 30 && with.stats.layers_s.is_some());
}

#[test]
fn a_render_that_is_stopped_while_it_gathers_layers_has_its_samples_and_no_layers() {
    let scene = prepared("scenes/cornell.toml");
    let settings = all(small(40, 30, 4));
    let whole = render(&scene, &settings);
    for threads in [1, 3] {
        let settings = Settings { threads, ..settings.clone() };
        let stopped = octray::render_with(&scene, &settings, &|progress| !progress.layers);
        assert!(!stopped.stats.finished && stopped.film.layers.pixels.is_empty() && stopped.film.spp == 4);
        // Going on takes no sample more.
        let gone_on = octray::render_from(&scene, &settings, Some(stopped.film), &|_| true);
        assert!(gone_on.stats.finished && gone_on.stats.paths == 0);
        assert_eq!(difference(&gone_on.film, &whole.film), None);
    }
}

#[test]
fn a_crop_has_the_layers_of_its_place() {
    let scene = prepared("scenes/leaves.toml");
    let whole = layers(&scene, &all(small(40, 30, 3)));
    let crop = Crop { x: 7, y: 5, width: 21, height: 18 };
    let part = layers(&scene, &Settings { crop: Some(crop), ..all(small(40, 30, 3)) });
    for (index, pixel) in (0..).zip(&part) {
        let (x, y) = (crop.x + index % crop.width, crop.y + index / crop.width);
        assert_eq!(bits(pixel), bits(&whole[(y * 40 + x) as usize]), "pixel {x},{y}");
    }
}

/// A wall of this material behind the origin's plane, seen face on from 8 units before it: it fills the view.
fn wall(scattering: Scattering) -> PreparedScene {
    let mut maker = Maker::default();
    let material = maker.material(scattering, [0.0; 3]);
    maker.quad([[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]], material);
    maker.seen([0.0, 0.0, 8.0], [0.0; 3], 40.0)
}

#[test]
fn a_wall_has_its_colour_its_normal_and_its_depth() {
    let conductor = |complex_ior| Scattering::Conductor { alpha: 0.3, reflectance: [0.9, 0.7, 0.2], complex_ior };
    let (eta, k) = ([0.2, 0.9, 1.4], [3.9, 2.4, 1.6]);
    // At normal incidence a conductor reflects ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2), glass ((ior - 1) / (ior + 1))^2.
    let metal: [f64; 3] =
        std::array::from_fn(|c| ((eta[c] - 1.0f64).powi(2) + k[c] * k[c]) / ((eta[c] + 1.0f64).powi(2) + k[c] * k[c]));
    let principled = |base_color, metallic| Scattering::Principled { base_color, metallic, roughness: 0.3, ior: 1.5 };
    for (scattering, wanted) in [
        (Scattering::Diffuse { albedo: [0.25, 0.5, 0.75] }, [0.25, 0.5, 0.75]),
        (Scattering::Diffuse { albedo: [0.0; 3] }, [0.0; 3]),
        (Scattering::Mirror { reflectance: [0.9, 0.8, 0.7] }, [0.9, 0.8, 0.7]),
        (conductor(None), [0.9, 0.7, 0.2]),
        (conductor(Some((eta, k))), metal),
        (Scattering::Dielectric { ior: 1.5, transmittance: [0.2, 0.4, 0.6] }, [1.0; 3]),
        (Scattering::Plastic { albedo: [0.0; 3], ior: 1.5, alpha: 0.2 }, [0.04; 3]),
        // The base's energy constant is above 1: without the limit this were 1.05.
        (Scattering::Plastic { albedo: [1.0; 3], ior: 1.5, alpha: 0.01 }, [1.0; 3]),
        (principled([0.0; 3], 0.5), [0.02; 3]),
        (principled([1.0; 3], 0.25), [1.0; 3]),
        (principled([0.9, 0.7, 0.2], 1.0), [0.9, 0.7, 0.2]),
    ] {
        for filter in [PixelFilter::Box, PixelFilter::Tent] {
            let mut scene = wall(scattering);
            scene.filter = filter;
            for pixel in layers(&scene, &all(small(9, 7, 4))) {
                let close = |a: [f32; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-5);
                let normals = [pixel.normal, pixel.shading_normal].iter().all(|n| close(*n, [0.0, 0.0, 1.0]));
                assert!(close(pixel.albedo, wanted) && normals, "{scattering:?}: {pixel:?}");
                assert!((pixel.depth - 8.0).abs() < 1e-4 && pixel.alpha == 1.0, "{scattering:?}: {pixel:?}");
            }
        }
    }
}

#[test]
fn a_mirror_shows_the_layers_of_what_is_seen_in_it() {
    // A mirror that is tilted by 45 degrees shows the coloured wall beside it.
    let mut maker = Maker::default();
    let mirror = maker.material(Scattering::Mirror { reflectance: [0.5, 1.0, 0.5] }, [0.0; 3]);
    let wall = maker.diffuse([0.8, 0.25, 0.5], [0.0; 3]);
    maker.quad([[-2.0, -2.0, -6.0], [2.0, -2.0, -2.0], [2.0, 2.0, -2.0], [-2.0, 2.0, -6.0]], mirror);
    maker.quad([[30.0, -90.0, -90.0], [30.0, -90.0, 90.0], [30.0, 90.0, 90.0], [30.0, 90.0, -90.0]], wall);
    maker.quad([[-30.0, -90.0, 90.0], [-30.0, -90.0, -90.0], [-30.0, 90.0, -90.0], [-30.0, 90.0, 90.0]], wall);
    let scene = maker.seen([0.0; 3], [0.0, 0.0, -1.0], 10.0);
    let settings = all(small(4, 4, 4));
    let (first, through) =
        (layers(&scene, &settings), layers(&scene, &Settings { layers_through_specular: true, ..settings.clone() }));
    for (first, through) in first.iter().zip(&through) {
        let tilted = DVec3::from(first.normal.map(f64::from));
        assert!((tilted.z - 0.5f64.sqrt()).abs() < 1e-5 && first.albedo == [0.5, 1.0, 0.5], "{first:?}");
        assert!(through.normal[0].abs() > 0.9999, "{through:?}");
        let wanted = [0.4, 0.25, 0.25];
        assert!(through.albedo.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{through:?}");
        // What things are put before and behind each other by.
        assert_eq!((first.depth, first.alpha), (through.depth, through.alpha));
    }
    // One event is one mirror; none, and the mirror is the end.
    for (max_depth, as_first) in [(0, true), (1, false)] {
        let found =
            layers(&scene, &Settings { layers_through_specular: true, max_depth: Some(max_depth), ..settings.clone() });
        assert_eq!(found[5] == first[5], as_first, "{max_depth}");
    }
}

#[test]
fn glass_shows_the_blend_of_what_it_reflects_and_lets_through() {
    // A pane of two faces before a wall, a wall of another colour behind the camera.
    let mut maker = Maker::default();
    let glass = maker.material(Scattering::Dielectric { ior: 1.5, transmittance: [1.0; 3] }, [0.0; 3]);
    let (front, back) = (maker.diffuse([1.0, 0.0, 0.0], [0.0; 3]), maker.diffuse([0.0, 0.0, 1.0], [0.0; 3]));
    maker.cuboid([-50.0, -50.0, -6.0], [50.0, 50.0, -5.0], false, glass);
    maker.quad([[-90.0, -90.0, -9.0], [90.0, -90.0, -9.0], [90.0, 90.0, -9.0], [-90.0, 90.0, -9.0]], front);
    maker.quad([[90.0, -90.0, 9.0], [-90.0, -90.0, 9.0], [-90.0, 90.0, 9.0], [90.0, 90.0, 9.0]], back);
    let scene = maker.seen([0.0; 3], [0.0, 0.0, -1.0], 2.0);
    let settings = Settings { layers_through_specular: true, ..all(small(2, 2, 4096)) };
    // Of the light 4 % are reflected at a face; a pane reflects 2 R / (1 + R) of it in all.
    let reflected = 2.0 * 0.04 / 1.04;
    let found = layers(&scene, &settings);
    let mean = |c: usize| found.iter().map(|pixel| f64::from(pixel.albedo[c])).sum::<f64>() / 4.0;
    let error = (reflected * (1.0 - reflected) / (4.0 * 4096.0f64)).sqrt();
    assert!((mean(0) - (1.0 - reflected)).abs() < 5.0 * error && (mean(2) - reflected).abs() < 5.0 * error);
    assert!((mean(0) + mean(2) - 1.0).abs() < 1e-6 && mean(1) == 0.0);
    assert!(found.iter().all(|pixel| (pixel.depth - 5.0).abs() < 1e-4));
}

#[test]
fn coverage_is_the_filters_share_of_the_pixel() {
    // The left half of the view is covered; the edge runs between two columns of pixels, or through the middle of one.
    for (filter, columns, share) in [
        (PixelFilter::Box, 16, vec![(6, 1.0), (7, 1.0), (8, 0.0), (9, 0.0)]),
        (PixelFilter::Tent, 16, vec![(6, 1.0), (7, 0.875), (8, 0.125), (9, 0.0)]),
        (PixelFilter::Box, 17, vec![(7, 1.0), (8, 0.5), (9, 0.0)]),
    ] {
        let mut maker = Maker::default();
        let wall = maker.diffuse([0.5, 0.25, 1.0], [0.0; 3]);
        maker.quad([[-9.0, -9.0, 0.0], [0.0, -9.0, 0.0], [0.0, 9.0, 0.0], [-9.0, 9.0, 0.0]], wall);
        maker.desc.filter = filter;
        let scene = maker.seen([0.0, 0.0, 8.0], [0.0; 3], 20.0);
        let found = layers(&scene, &all(small(columns, 16, 1024)));
        for (column, wanted) in share {
            let of_column = || (0..16).map(|y| found[(y * columns + column) as usize]);
            let mean = of_column().map(|pixel| f64::from(pixel.alpha)).sum::<f64>() / 16.0;
            let error = (wanted * (1.0 - wanted) / (16.0 * 1024.0f64)).sqrt();
            assert!((mean - wanted).abs() <= 5.0 * error, "{filter:?}, column {column}: {mean}, {wanted} wanted");
            for pixel in of_column() {
                // Albedo and normal are premultiplied with it; depth is that of what is there.
                assert!((pixel.albedo[2] - pixel.alpha).abs() < 1e-6 && (pixel.normal[2] - pixel.alpha).abs() < 1e-6);
                let depth = if pixel.alpha > 0.0 { 8.0 } else { NOTHING };
                assert!((pixel.depth - depth).abs() < 1e-4, "{pixel:?}");
            }
        }
    }
}

#[test]
fn a_hidden_environment_is_missing_where_camera_rays_leave_and_nowhere_else() {
    let radiance = [0.5, 1.0, 2.0];
    let mut maker = Maker::default();
    let (grey, mirror) =
        (maker.diffuse([0.6; 3], [0.0; 3]), maker.material(Scattering::Mirror { reflectance: [0.9; 3] }, [0.0; 3]));
    maker.cuboid([-1.0, -1.0, -1.0], [0.0, 0.5, 1.0], false, grey);
    maker.cuboid([0.1, -1.0, -1.0], [1.0, 0.5, 1.0], false, mirror);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance }));
    let scene = maker.seen([0.5, 1.0, 8.0], [0.0; 3], 25.0);
    for engine in [Engine::Packet, Engine::Scalar] {
        for sampler in Sampler::ALL {
            let settings = Settings { sampler: *sampler, engine, ..small(24, 20, 16) };
            let seen = render(&scene, &settings).film;
            let hidden = render(&scene, &Settings { hide_environment: true, ..settings }).film;
            assert!(hidden.layers.pixels.iter().any(|pixel| pixel.alpha > 0.0 && pixel.alpha < 1.0));
            for (index, pixel) in hidden.layers.pixels.iter().enumerate() {
                let missing = 16.0 * (1.0 - f64::from(pixel.alpha));
                for (c, radiance) in radiance.iter().enumerate() {
                    let [seen, hidden] = [&seen, &hidden].map(|film| film.pixels[index].sum[c]);
                    assert!((seen - hidden - missing * radiance).abs() < 1e-9 * seen, "{index}: {seen}, {hidden}");
                    assert!((hidden == 0.0) == (pixel.alpha == 0.0), "{index}: {hidden} with alpha {}", pixel.alpha);
                }
            }
        }
    }
}
