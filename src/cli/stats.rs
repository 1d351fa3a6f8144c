//! The `--stats` file of a render.

use crate::learn::outcome::Learning;
use crate::render::{RayCounts, Render, StageStats};
use crate::settings::Settings;
use crate::setup::frame::Frame;
use crate::simd::simd_level;
use crate::tables::PreparedScene;
use serde::Serialize;

/// Everything a render cost and met, in the order in which it is written.
#[derive(Serialize)]
pub struct Report<'a> {
    version: &'static str,
    scene: &'a str,
    strategy: &'static str,
    /// The strategy's expected image is wrong on purpose.
    biased: bool,
    lights: &'static str,
    guide: &'static str,
    roulette: &'static str,
    /// The length of the training render as asked for.
    train: String,
    /// What learning came to and cost; its seconds are in `render_s` and `cpu_s`. `null`: nothing was to be learned.
    learning: &'a Option<Learning>,
    sampler: &'static str,
    engine: &'static str,
    /// What stages held besides what the scene needs.
    plan: &'static str,
    simd: &'static str,
    threads: usize,
    width: u32,
    height: u32,
    /// x, y, width, height of the part rendered.
    crop: [u32; 4],
    /// Samples in every pixel, as reached.
    spp: u32,
    seed: u32,
    /// `null`: unbounded.
    max_depth: Option<u32>,
    /// `null`: off.
    rr_depth: Option<u32>,
    load_s: f64,
    build_s: f64,
    render_s: f64,
    cpu_s: f64,
    /// What the image file holds beside radiance, in the words of `--layers`.
    layers: Vec<&'static str>,
    /// Camera rays that left the scene saw nothing, and there is alpha.
    hide_environment: bool,
    /// Wall seconds of gathering layers and alpha, which are not in `render_s`; `null`: none were gathered.
    layers_s: Option<f64>,
    paths: u64,
    rays: RayCounts,
    /// All rays, in millions, by CPU second of rendering.
    mrays_per_s: f64,
    stages: &'a [StageStats],
    peak_rss_bytes: Option<u64>,
    mean_radiance: [f64; 3],
    /// The noise: the root of the mean variance of the pixels' means over the mean radiance, as the samples' own spread tells
    /// it; `null` below two samples (four with the `sobol` sampler). Not the root of relMSE, which needs a reference.
    relative_error: Option<f64>,
    /// Standard error of `relative_error` as a statement about this very image.
    relative_error_se: Option<f64>,
    /// 95 % interval: `relative_error` and 1.96 standard errors to both sides, not below 0.
    relative_error_interval: Option<[f64; 2]>,
    /// What light that no sample has met may add to the noise, as the target counts it; `null` without one.
    unseen_error: Option<f64>,
    /// What `--target-error` asked for: the root of the squares of `relative_error` and `unseen_error` is at or below it.
    target_error: Option<f64>,
    /// Samples a pixel that came from an interrupted render; rays, seconds and stages are those of this call alone.
    resumed_from_spp: u32,
    /// Every sample asked for was taken.
    finished: bool,
    nonfinite: u64,
    nonfinite_samples: Vec<NonFiniteRow>,
    guarded: u64,
    /// Tiles rendered, each once for every pass over it.
    tiles: u64,
    /// Locks and atomic read-modify-writes of the worker threads on what they share.
    shared_operations: u64,
    warnings: &'a [String],
}

/// Where a sample that was not finite arose.
#[derive(Serialize)]
struct NonFiniteRow {
    x: u32,
    y: u32,
    sample: u32,
    stage: &'static str,
}

impl<'a> Report<'a> {
    /// The report of `render`, made with `settings`.
    pub fn new(
        scene: &'a PreparedScene,
        settings: &Settings,
        &Frame { film, crop }: &Frame,
        render: &'a Render,
        resumed_from_spp: u32,
        warnings: &'a [String],
    ) -> Report<'a> {
        let stats = &render.stats;
        let error = render.film.relative_error_estimate();
        let nonfinite = stats.nonfinite_samples.iter();
        Report {
            version: env!("CARGO_PKG_VERSION"),
            scene: &scene.name,
            strategy: settings.strategy.name(),
            biased: settings.strategy.is_biased(),
            lights: settings.lights.name(),
            guide: settings.guide.name(),
            roulette: settings.roulette.name(),
            train: settings.train.to_string(),
            learning: &stats.learning,
            sampler: settings.sampler.name(),
            engine: settings.engine.name(),
            plan: settings.plan.name(),
            simd: simd_level(),
            threads: stats.threads,
            width: film.0,
            height: film.1,
            crop: [crop.x, crop.y, crop.width, crop.height],
            spp: render.film.spp,
            seed: settings.seed,
            max_depth: settings.max_depth,
            rr_depth: settings.rr_depth,
            load_s: scene.load_s,
            build_s: scene.build_s + stats.setup_s,
            render_s: stats.render_s,
            cpu_s: stats.cpu_s,
            layers: settings.layers.iter().map(|layer| layer.name()).collect(),
            hide_environment: settings.hide_environment,
            layers_s: stats.layers_s,
            paths: stats.paths,
            rays: stats.rays,
            mrays_per_s: mrays_per_s(&stats.rays, stats.cpu_s),
            stages: &stats.stages,
            peak_rss_bytes: crate::clock::peak_rss_bytes(),
            mean_radiance: render.film.mean_radiance(),
            relative_error: error.map(|(error, _)| error),
            relative_error_se: error.map(|(_, standard_error)| standard_error),
            relative_error_interval: error.map(|(error, se)| [(error - 1.96 * se).max(0.0), error + 1.96 * se]),
            unseen_error: stats.unseen_error,
            target_error: settings.target_error,
            resumed_from_spp,
            finished: stats.finished,
            nonfinite: stats.nonfinite,
            nonfinite_samples: nonfinite
                .map(|found| NonFiniteRow { x: found.x, y: found.y, sample: found.sample, stage: found.stage })
                .collect(),
            guarded: stats.guarded,
            tiles: stats.tiles,
            shared_operations: stats.shared_operations,
            warnings,
        }
    }
}

/// Millions of rays of all kinds by second.
pub fn mrays_per_s(rays: &RayCounts, seconds: f64) -> f64 {
    if seconds > 0.0 { rays.total() as f64 / seconds * 1e-6 } else { 0.0 }
}
