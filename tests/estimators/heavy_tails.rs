//! Target errors where few samples carry much of the light: paths that meet a lamp by chance. What such renders have not
//! met their samples do not tell, so a small spread is no proof of a small error.

use crate::common::{Maker, first_difference, prepared, small};
use octray::scene::desc::{EnvironmentDesc, LightDesc, MapDesc, Scattering};
use octray::{Engine, Film, PreparedScene, Render, Sampler, Settings, Strategy, render, render_from};
use std::f64::consts::{PI, TAU};

const GLASS: Scattering = Scattering::Dielectric { ior: 1.5, transmittance: [1.0; 3] };
const EYE: [f64; 3] = [0.0, 2.5, 3.0];

/// A white floor, 4 x 4 units.
fn floor() -> Maker {
    let mut maker = Maker::default();
    let white = maker.diffuse([0.8; 3], [0.0; 3]);
    maker.quad([[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]], white);
    maker
}

/// A square lamp that shines downwards.
fn hang_lamp(maker: &mut Maker, [x, y, z]: [f32; 3], half: f32, radiance: f64) {
    let shine = maker.diffuse([0.0; 3], [radiance; 3]);
    let corner = |right: f32, near: f32| [x + right * half, y, z + near * half];
    maker.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], shine);
}

/// A lamp before a leaning mirror: 7.5 % of the light comes by the mirror.
fn mirror() -> PreparedScene {
    let mut maker = floor();
    let mirror = maker.material(Scattering::Mirror { reflectance: [0.9; 3] }, [0.0; 3]);
    maker.quad([[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [1.3, 2.0, 1.0], [1.3, 2.0, -1.0]], mirror);
    hang_lamp(&mut maker, [0.0, 1.0, 0.0], 0.05, 200.0);
    maker.seen(EYE, [0.3, 0.0, 0.0], 40.0)
}

/// A glass ball of flat facets that gathers a lamp's light on a small part of the floor.
fn glass_ball() -> PreparedScene {
    const ROWS: u32 = 12;
    const COLUMNS: u32 = 24;
    let mut maker = floor();
    let glass = maker.material(GLASS, [0.0; 3]);
    let at = |row: u32, column: u32| {
        let (theta, phi) = (PI * row as f64 / ROWS as f64, TAU * (column % COLUMNS) as f64 / COLUMNS as f64);
        let across = if row.is_multiple_of(ROWS) { 0.0 } else { theta.sin() };
        let unit = [across * phi.sin(), theta.cos(), across * phi.cos()];
        std::array::from_fn(|axis| (0.4 * unit[axis] + [0.2, 0.7, 0.0][axis]) as f32)
    };
    for (row, column) in (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(down, right)| at(row + down, column + right));
        maker.quad(corners, glass);
    }
    hang_lamp(&mut maker, [0.0, 2.0, 0.0], 0.05, 800.0);
    maker.seen(EYE, [0.0; 3], 40.0)
}

/// A small lamp in a glass box below a large dim one.
fn lamp_in_glass() -> PreparedScene {
    let mut maker = floor();
    let glass = maker.material(GLASS, [0.0; 3]);
    maker.cuboid([-0.2, 0.9, -0.2], [0.2, 1.3, 0.2], false, glass);
    hang_lamp(&mut maker, [0.0, 1.1, 0.0], 0.03, 400.0);
    hang_lamp(&mut maker, [0.0, 4.0, 0.0], 2.0, 1.0);
    maker.seen(EYE, [0.3, 0.0, 0.0], 40.0)
}

/// A small lamp under an even sky.
fn small_lamp() -> PreparedScene {
    let mut maker = floor();
    hang_lamp(&mut maker, [0.0, 1.0, 0.0], 0.03, 300.0);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [0.5; 3] }));
    maker.seen(EYE, [0.3, 0.0, 0.0], 40.0)
}

/// A sky of one, with a sun of one texel.
fn tiny_sun() -> PreparedScene {
    let mut maker = floor();
    let (width, height) = (128, 64);
    let mut texels = vec![[1.0f32; 3]; width * height];
    texels[10 * width + 40] = [1000.0; 3];
    let (width, height) = (width as u32, height as u32);
    let map = MapDesc { file: "sun".into(), width, height, texels, rotate: 0.0, scale: 1.0 };
    maker.desc.lights.push(LightDesc::Environment(EnvironmentDesc::Map(map)));
    maker.seen(EYE, [0.3, 0.0, 0.0], 40.0)
}

/// A scene and how it is rendered to a target error.
struct Case {
    name: &'static str,
    scene: PreparedScene,
    /// Columns and rows.
    film: (u32, u32),
    strategy: Strategy,
    sampler: Sampler,
    target: f64,
    /// What the truth is rendered with: a strategy, samples a pixel.
    truth: (Strategy, u32),
}

impl Case {
    fn settings(&self) -> Settings {
        let (strategy, sampler) = (self.strategy, self.sampler);
        Settings { strategy, sampler, threads: 0, ..small(self.film.0, self.film.1, u32::MAX) }
    }

    fn truth(&self) -> Film {
        let (strategy, spp) = self.truth;
        render(&self.scene, &Settings { strategy, spp, seed: 1 << 20, ..self.settings() }).film
    }

    fn stopped(&self, seed: u32) -> Render {
        render(&self.scene, &Settings { seed, target_error: Some(self.target), ..self.settings() })
    }

    /// What `seeds` renders come to.
    fn outcome(&self, seeds: u32) -> Outcome {
        let truth = self.truth();
        let mut outcome = Outcome::default();
        for seed in 0..seeds {
            let done = self.stopped(seed);
            let (seen, standard_error) = done.film.relative_error_estimate().expect("light and enough samples");
            let unseen = done.stats.unseen_error.expect("a target error was given");
            assert!(done.stats.finished && seen.hypot(unseen) <= self.target, "{seen} {unseen}");
            let error = true_error(&done.film, &truth);
            outcome.far += u32::from(error > 1.5 * self.target);
            outcome.inside += u32::from((error - seen).abs() <= 1.96 * standard_error);
            outcome.spp.push(done.film.spp);
        }
        outcome.spp.sort_unstable();
        let Outcome { far, inside, spp } = &outcome;
        let (least, middle) = (spp[0], spp[spp.len() / 2]);
        let Case { name, strategy, sampler, target, .. } = self;
        println!(
            "{name}, {strategy}, {sampler}, target {target}: {far} of {seeds} above 1.5 targets, {inside} in the interval, \
             {middle} samples a pixel (least {least})"
        );
        outcome
    }
}

#[derive(Default)]
struct Outcome {
    /// Renders whose true error is above 1.5 times the one asked for.
    far: u32,
    /// Those whose true error lies in the interval they state.
    inside: u32,
    /// Samples a pixel, ascending.
    spp: Vec<u32>,
}

/// The error of `film`: root mean square over pixels and channels, by the mean of the truth, whose own error is taken off.
fn true_error(film: &Film, truth: &Film) -> f64 {
    let (mut squares, mut mean) = (0.0, 0.0);
    for (x, y) in (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y))) {
        let (got, wanted, noise) = (film.mean(x, y), truth.mean(x, y), truth.variance(x, y));
        for c in 0..3 {
            squares += (got[c] as f64 - wanted[c] as f64).powi(2) - noise[c] as f64;
            mean += wanted[c] as f64;
        }
    }
    let count = 3.0 * film.pixels.len() as f64;
    (squares.max(0.0) / count).sqrt() / (mean / count)
}

fn case(name: &'static str, scene: PreparedScene, strategy: Strategy, target: f64, truth: (Strategy, u32)) -> Case {
    Case { name, scene, film: (8, 8), strategy, sampler: Sampler::Sobol, target, truth }
}

/// The two cases that end soon.
fn quick_cases() -> [Case; 2] {
    use Strategy::{Bsdf, MisPower};
    [
        case("small lamp", small_lamp(), Bsdf, 0.1, (MisPower, 1 << 14)),
        case("tiny sun", tiny_sun(), Bsdf, 0.14, (MisPower, 1 << 14)),
    ]
}

/// Eight seeds each. Of a rule that errs in 3 of 100 renders, two or fewer of 16 do with 98.9 % confidence; one that looks
/// at the samples' spread alone errs in three quarters of them, and passes with a probability of 1e-7.
#[test]
fn a_target_error_is_met_where_lamps_are_met_by_chance() {
    let far: u32 = quick_cases().iter().map(|case| case.outcome(8).far).sum();
    assert!(far <= 2, "{far} of 16 renders are far from the error asked for");
}

/// A hundred seeds each; the figures in README.md and in `ErrorSums::relative_error` are from here.
#[test]
#[ignore = "minutes: cargo test --release --test estimators heavy_tails -- --ignored --nocapture"]
fn a_target_error_is_met_in_every_heavy_tail() {
    use Strategy::{MisPower, Nee};
    let mut cases = Vec::from(quick_cases());
    let glass = (Nee, 1 << 20);
    cases.extend([0.05, 0.1].map(|target| case("mirror", mirror(), MisPower, target, (MisPower, 1 << 20))));
    cases.extend([0.2, 0.4].map(|target| case("lamp in glass", lamp_in_glass(), Nee, target, glass)));
    cases.push(Case { sampler: Sampler::Independent, ..case("lamp in glass", lamp_in_glass(), Nee, 0.2, glass) });
    let ball = |target: f64| case("glass ball", glass_ball(), MisPower, target, (MisPower, 1 << 19));
    cases.extend([0.4, 0.6].map(|target| Case { film: (12, 12), ..ball(target) }));
    let truth = (MisPower, 1 << 17);
    cases.push(Case { film: (32, 32), truth, ..ball(0.6) });
    let far: Vec<u32> = cases.iter().map(|case| case.outcome(100).far).collect();
    assert!(far.iter().all(|&far| far <= 10), "{far:?} of 100 renders each are far from the error asked for");
}

/// What decides is known of the film and the scene alone, so threads, engine and a break leave no trace.
#[test]
fn stopping_is_the_same_for_threads_and_engines_and_after_a_break() {
    let case = case("mirror", mirror(), Strategy::MisPower, 0.5, (Strategy::MisPower, 1));
    let one = render(&case.scene, &Settings { threads: 1, target_error: Some(0.5), ..case.settings() });
    assert!(one.film.spp > 256, "16,384 samples in all at least, and {} a pixel", one.film.spp);
    for (threads, engine) in [(3, Engine::Packet), (2, Engine::Scalar)] {
        let other = render(&case.scene, &Settings { threads, engine, target_error: Some(0.5), ..case.settings() });
        assert_eq!(first_difference(&one.film, &other.film), None);
        assert_eq!(one.stats.unseen_error, other.stats.unseen_error);
    }
    // Finished is finished, and one sample less is not.
    let on = |spp: u32| {
        let start = render(&case.scene, &Settings { spp, ..case.settings() }).film;
        let settings = Settings { target_error: Some(0.5), ..case.settings() };
        render_from(&case.scene, &settings, Some(start), &|_| true).film
    };
    assert_eq!(first_difference(&on(one.film.spp), &one.film), None);
    assert_eq!(first_difference(&on(256), &one.film), None);
}

/// Where light samples see to all lights, the samples' spread alone decides as soon as there are enough of them.
#[test]
fn ordinary_scenes_stop_where_their_spread_says() {
    let scene = prepared("scenes/cornell.toml");
    for (side, least) in [(12, 114), (32, 16), (40, 16)] {
        let done = render(&scene, &Settings { target_error: Some(5.0), ..small(side, side, u32::MAX) });
        assert_eq!((done.film.spp, done.stats.unseen_error), (least, Some(0.0)), "{side}");
    }
    assert_eq!(render(&scene, &small(8, 8, 4)).stats.unseen_error, None);
}

/// A lamp so small that a hundred thousand samples may miss it: the picture is black, and not given up as such.
#[test]
fn a_picture_that_is_black_so_far_is_waited_for() {
    let mut maker = floor();
    hang_lamp(&mut maker, [0.0, 1.0, 0.0], 0.003, 30_000.0);
    let scene = maker.seen(EYE, [0.3, 0.0, 0.0], 40.0);
    let (strategy, target_error) = (Strategy::Bsdf, Some(3.0));
    let done = render(&scene, &Settings { strategy, target_error, max_depth: Some(1), ..small(2, 2, u32::MAX) });
    assert!(done.film.mean_radiance()[0] > 0.0, "black after {} samples a pixel", done.film.spp);
}
