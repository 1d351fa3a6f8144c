//! Whole paths: the packet engine has the bits of the scalar reference, whatever the threads, passes and crops.

use crate::common::{SCENES, first_difference, prepared, small};
use octray::internal::packet;
use octray::internal::packet::explain::{self, LeftOut, PlannedStage};
use octray::internal::packet::plan::Plan;
use octray::internal::reference::{path_steps, single};
use octray::internal::setup::Setup;
use octray::internal::tables::materials::MaterialKind;
use octray::internal::trace::PathStep;
use octray::{Crop, Engine, Lights, Sampler, Settings, Strategy, render};

#[test]
fn engines_agree_bit_for_bit_on_every_scene_and_strategy() {
    for path in SCENES {
        let scene = prepared(path);
        for &strategy in Strategy::ALL {
            for (lights, max_depth, sampler) in [
                (Lights::Tree, None, Sampler::Sobol),
                (Lights::Uniform, None, Sampler::Independent),
                (Lights::Power, Some(3), Sampler::Sobol),
            ] {
                let settings = Settings { strategy, lights, max_depth, sampler, ..small(33, 27, 3) };
                let packet = render(&scene, &settings);
                let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings });
                let difference = first_difference(&packet.film, &scalar.film);
                assert_eq!(difference, None, "{path}, {strategy}, {lights}, {sampler}, depth {max_depth:?}");
                assert_eq!(packet.stats.rays, scalar.stats.rays, "{path}, {strategy}");
                assert_eq!((packet.stats.nonfinite, packet.stats.guarded), (0, 0), "{path}, {strategy}");
            }
        }
    }
}

/// One path in both engines, ray by ray.
fn both(setup: &Setup, plan: &Plan, pixel: (u32, u32), sample: u32) -> [Vec<PathStep>; 2] {
    let mut vertices = Vec::new();
    let path = single::path::trace_path(setup, pixel, sample, &mut |vertex| vertices.push(vertex));
    let scalar = path_steps(&vertices);
    let radiance = scalar.last().map_or([0.0; 3], |step| step.radiance);
    assert_eq!(radiance.map(f32::to_bits), path.radiance.to_array().map(f32::to_bits), "a path that is watched");
    assert_eq!(scalar.iter().filter(|step| step.shadow.is_some()).count() as u32, path.shadow_rays);
    [scalar, packet::trace::trace_path(setup, plan, pixel, sample)]
}

#[test]
fn vertex_lists_agree_bit_for_bit_on_every_scene_and_strategy() {
    for path in SCENES {
        let scene = prepared(path);
        let (mut deepest, mut shadows) = (0, 0);
        for &strategy in Strategy::ALL {
            for (max_depth, sampler) in [(None, Sampler::Sobol), (Some(2), Sampler::Independent)] {
                let settings = Settings { strategy, max_depth, sampler, ..small(64, 48, 1) };
                let setup = Setup::new(&scene, &settings);
                let plan = Plan::new(&setup);
                for i in 0..60 {
                    let (pixel, sample) = ((i * 29 % 64, i * 31 % 48), i * 7);
                    let [scalar, packet] = both(&setup, &plan, pixel, sample);
                    let difference = octray::internal::trace::first_difference(&scalar, &packet);
                    let (x, y) = pixel;
                    let address = format!("--pixel {x},{y} --sample {sample} --width 64 --height 48");
                    let flags = format!("--strategy {strategy} --sampler {sampler} {address}");
                    assert_eq!(difference, None, "octray trace {path} {flags}, {max_depth:?}");
                    deepest = deepest.max(scalar.len());
                    shadows += scalar.iter().filter(|step| step.shadow.is_some()).count();
                }
            }
        }
        assert!(deepest > 2 && shadows > 50, "{path}: {deepest} rays at most, {shadows} shadow rays");
    }
}

#[test]
fn threads_passes_and_crops_leave_no_trace() {
    let scene = prepared("scenes/cornell_mirror.toml");
    for (engine, sampler) in
        [(Engine::Packet, Sampler::Independent), (Engine::Packet, Sampler::Sobol), (Engine::Scalar, Sampler::Sobol)]
    {
        let settings = Settings { engine, sampler, ..small(70, 41, 70) };
        let one = render(&scene, &settings);
        for threads in [2, 3] {
            let many = render(&scene, &Settings { threads, ..settings.clone() });
            assert_eq!(first_difference(&one.film, &many.film), None, "{engine}, {threads} threads");
        }
        let crop = Crop { x: 19, y: 5, width: 37, height: 22 };
        let part = render(&scene, &Settings { crop: Some(crop), ..settings.clone() });
        for y in 0..crop.height {
            for x in 0..crop.width {
                let whole = one.film.mean(crop.x + x, crop.y + y);
                assert_eq!(part.film.mean(x, y).map(f32::to_bits), whole.map(f32::to_bits), "{engine}, {x},{y}");
            }
        }
    }
}

#[test]
fn a_time_limit_equals_the_samples_it_reached() {
    let scene = prepared("scenes/cornell.toml");
    let limit = Some(std::time::Duration::from_millis(150));
    let settings = Settings { spp: 1 << 20, time: limit, sampler: Sampler::Sobol, ..small(40, 40, 1) };
    let timed = render(&scene, &settings);
    assert!(timed.film.spp >= 1 && timed.film.spp < 1 << 20 && timed.stats.finished);
    let counted = render(&scene, &Settings { spp: timed.film.spp, time: None, ..settings.clone() });
    assert_eq!(first_difference(&timed.film, &counted.film), None, "{} samples", timed.film.spp);
    let least = Settings { time: Some(std::time::Duration::ZERO), ..settings };
    assert_eq!(render(&scene, &least).film.spp, 1, "at least one whole pass");
}

/// Every tile has the samples that it has, each pixel the first so many of its own; and from there it goes on.
#[test]
fn a_stopped_render_holds_whole_samples_tile_by_tile() {
    let scene = prepared("scenes/cornell.toml");
    for (engine, sampler) in [(Engine::Packet, Sampler::Sobol), (Engine::Scalar, Sampler::Independent)] {
        let settings = Settings { engine, sampler, threads: 2, ..small(50, 40, 300) };
        let calls = std::sync::atomic::AtomicU32::new(0);
        let after = |most: u32| move |calls: u32| calls < most;
        for most in [0, 1, 5, 40] {
            let go_on = after(most);
            calls.store(0, std::sync::atomic::Ordering::Relaxed);
            let heard = |_| go_on(calls.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
            let stopped = octray::render_with(&scene, &settings, &heard);
            assert!(!stopped.stats.finished && stopped.film.spp < 300);
            let film = &stopped.film;
            let mut counts: Vec<u32> = (0..40).flat_map(|y| (0..50).map(move |x| film.spp_at(x, y))).collect();
            counts.sort_unstable();
            counts.dedup();
            assert_eq!((counts[0], counts.last().copied()), (film.spp, Some(film.most_spp())));
            for &spp in counts.iter().filter(|count| **count > 0) {
                let same = render(&scene, &Settings { spp, engine: Engine::Packet, ..settings.clone() }).film;
                for (y, x) in (0..40).flat_map(|y| (0..50).map(move |x| (y, x))) {
                    if film.spp_at(x, y) == spp {
                        assert_eq!((film.mean(x, y), film.variance(x, y)), (same.mean(x, y), same.variance(x, y)));
                    }
                }
            }
            let on = octray::render_from(&scene, &settings, Some(stopped.film), &|_| true).film;
            assert_eq!(first_difference(&on, &render(&scene, &settings).film), None, "{engine} {most}");
        }
    }
}

/// Threads leave the picture alone while it is shown, and nothing of that shows in it.
#[test]
fn a_render_that_pauses_has_the_bits_of_one_that_does_not() {
    struct Shown(std::sync::Mutex<Vec<(u32, u32)>>);
    impl octray::Watch for Shown {
        fn progress(&self, _: octray::Progress) -> bool {
            true
        }
        fn pause_after(&self) -> Option<std::time::Duration> {
            Some(std::time::Duration::from_micros(300))
        }
        fn pause(&self, film: &octray::Film, _: f64) {
            assert!(film.mean(0, 0).iter().all(|mean| mean.is_finite()));
            self.0.lock().unwrap().push((film.spp, film.most_spp()));
        }
    }
    let scene = prepared("scenes/cornell.toml");
    let settings = Settings { threads: 3, ..small(70, 40, 200) };
    let shown = Shown(std::sync::Mutex::default());
    let paused = octray::try_render_from(&scene, &settings, None, &shown).unwrap();
    assert_eq!(first_difference(&paused.film, &render(&scene, &settings).film), None);
    let shown = shown.0.into_inner().unwrap();
    assert!(shown.len() > 1 && shown.is_sorted() && shown.last().unwrap().1 <= 200, "{shown:?}");
}

/// A film that no machine can hold, and a picture that is none of this render, are errors and no panics.
#[test]
fn what_cannot_be_rendered_is_an_error() {
    let scene = prepared("scenes/cornell.toml");
    let huge = Settings { width: Some(65_535), height: Some(65_535), ..Settings::plain() };
    let refused = octray::try_render(&scene, &huge).unwrap_err().to_string();
    assert!(refused.starts_with("a film of 65535 x 65535 pixels needs "), "{refused}");
    let other = render(&scene, &small(5, 5, 1)).film;
    let refused = octray::try_render_from(&scene, &small(6, 5, 1), Some(other), &|_| true).unwrap_err().to_string();
    assert!(refused.contains("none of this film and sampler"), "{refused}");
}

#[test]
fn progress_tells_the_error_of_the_last_whole_pass() {
    let scene = prepared("scenes/cornell.toml");
    let heard = std::sync::Mutex::new(Vec::new());
    let settings = Settings { threads: 2, ..small(10, 16, 130) };
    let render = octray::render_with(&scene, &settings, &|progress| {
        heard.lock().unwrap().push(progress);
        true
    });
    let heard = heard.into_inner().unwrap();
    let first_pass = heard.iter().filter(|progress| progress.samples < 64 * 10 * 16);
    assert!(first_pass.into_iter().all(|progress| progress.relative_error.is_none()));
    let (last, wanted) = (heard.last().unwrap(), render.film.relative_error().unwrap());
    assert_eq!((last.samples, last.total), (130 * 10 * 16, 130 * 10 * 16));
    assert!((last.relative_error.unwrap() / wanted - 1.0).abs() < 1e-12, "{last:?} {wanted}");
    // The first pass has about half of the samples, hence an error larger by about the root of 2.
    let earlier = heard.iter().find_map(|progress| progress.relative_error).unwrap();
    assert!(earlier > wanted && earlier < 2.0 * wanted, "{earlier} {wanted}");
}

#[test]
fn seeds_and_samples_are_different_and_reproducible() {
    let scene = prepared("scenes/cornell.toml");
    let settings = small(16, 16, 2);
    let (a, b) = (render(&scene, &settings), render(&scene, &settings));
    assert_eq!(first_difference(&a.film, &b.film), None);
    let other = render(&scene, &Settings { seed: 1, ..settings });
    assert!(first_difference(&a.film, &other.film).is_some());
}

/// The two number types of the reference follow the same paths: all but a few samples (whose f32 ray takes the other side
/// of an edge) agree to f32 precision.
#[test]
fn f32_and_f64_references_follow_the_same_paths() {
    for path in SCENES {
        let scene = prepared(path);
        let settings = Settings { max_depth: Some(4), ..small(32, 32, 1) };
        let setup = Setup::new(&scene, &settings);
        let (mut apart, mut total) = (0, 0);
        for sample in 0..4 {
            for pixel in (0..32 * 32).map(|i| (i % 32, i / 32)) {
                let single = single::path::trace_path(&setup, pixel, sample, &mut |_| {});
                let double = octray::internal::reference::double::path::trace_path(&setup, pixel, sample, &mut |_| {});
                let difference = (single.radiance.as_dvec3() - double.radiance).abs().max_element();
                apart += (difference > 1e-3 * (double.radiance.abs().max_element() + 0.01)) as u32;
                total += 1;
            }
        }
        assert!(apart * 200 < total, "{path}: {apart} of {total} samples differ");
    }
}

#[test]
fn plans_leave_out_what_a_scene_does_not_need() {
    let cornell = prepared("scenes/cornell.toml");
    let plan = |scene: &octray::PreparedScene, settings: &Settings| {
        let setup = Setup::new(scene, settings);
        let plan = Plan::new(&setup);
        (explain::stages(&setup, &plan), explain::left_out(&setup), plan)
    };
    type Told = (Vec<PlannedStage>, Vec<LeftOut>, Plan);
    let left_out = |told: &Told| told.1.iter().map(|l| l.what).collect::<Vec<_>>();
    let stages = |told: &Told| told.0.iter().map(|s| s.stage).collect::<Vec<_>>();

    let nee = plan(&cornell, &Settings { strategy: Strategy::Nee, ..small(8, 8, 1) });
    assert!(!stages(&nee).contains(&"shade_mirror") && !stages(&nee).contains(&"shade_miss"));
    assert!(left_out(&nee).contains(&"mirror") && left_out(&nee).contains(&"environment"));
    let state = nee.2.tile_state(256);
    assert!(state.paths.pdf_dir.is_empty(), "0/1 weights need no densities");
    assert!(
        state.surfaces[MaterialKind::Mirror].slot.len() <= 8
            && state.misses.rows.len() <= 8
            && state.shadow.slot.len() >= 256
    );

    let bsdf = plan(&cornell, &Settings { strategy: Strategy::Bsdf, ..small(8, 8, 1) });
    assert!(left_out(&bsdf).contains(&"light sampling") && !stages(&bsdf).contains(&"intersect_shadow"));
    assert!(bsdf.2.tile_state(256).shadow.slot.len() <= 8);
    let emission = plan(&cornell, &Settings { max_depth: Some(0), ..small(8, 8, 1) });
    assert!(!stages(&emission).contains(&"shade_diffuse"));
    let mirror = plan(&prepared("scenes/cornell_mirror.toml"), &small(8, 8, 1));
    assert!(stages(&mirror).contains(&"shade_mirror") && !left_out(&mirror).contains(&"mirror"));
}
