//! Renders of the suite's scenes at fixed seeds, held against what is known.

use crate::api::Scene;
use crate::check::numbers::worse;
use crate::check::scenes;
use crate::error::Result;
use crate::film::Film;
use crate::render::{Render, render};
use crate::settings::{Sampler, Settings};
use crate::tables::PreparedScene;

/// Statistical rows pass within so many standard errors: by chance one of 1.7 million does not, and seeds are fixed.
pub const SIGMAS: f64 = 5.0;

/// A scene of the suite, ready.
pub struct Trial {
    /// The scene.
    pub scene: Scene,
    /// Its tables.
    pub prepared: PreparedScene,
}

impl Trial {
    /// The scene of this name with these numbers ([`crate::check::scenes`]).
    ///
    /// # Errors
    /// Those of loading and preparing.
    pub fn new(name: &str, numbers: &[f64]) -> Result<Trial> {
        let numbers: String = numbers.iter().map(|number| format!(":{number:e}")).collect();
        let scene = scenes::load(&format!("{name}{numbers}"))?;
        let prepared = scene.prepare()?;
        Ok(Trial { scene, prepared })
    }

    /// A render by `settings`.
    pub fn render(&self, settings: &Settings) -> Render {
        render(&self.prepared, settings)
    }

    /// The command that shows a path of [`Trial::render`].
    pub fn trace(&self, settings: &Settings, pixel: (u32, u32), sample: u32) -> String {
        trace_command(&self.prepared.name, settings, pixel, sample)
    }

    /// Renders, and holds the mean of the picture's first channel against `truth`.
    pub fn mean(&self, settings: &Settings, truth: f64) -> Mean {
        let render = self.render(settings);
        let estimate = Estimate::of(&render.film);
        let worst = worst_pixel(&render.film, truth);
        let nonfinite = render.stats.nonfinite;
        Mean { estimate, truth, nonfinite, trace: self.trace(settings, worst, 0) }
    }
}

/// Settings for a small picture on one thread: independent samples, so that a pixel's own spread tells its error.
pub fn small(side: u32, spp: u32) -> Settings {
    Settings {
        spp,
        sampler: Sampler::Independent,
        width: Some(side),
        height: Some(side),
        threads: 1,
        ..Settings::plain()
    }
}

/// The command that shows sample `sample` of `pixel` of a render of the scene named `scene`.
pub fn trace_command(scene: &str, settings: &Settings, (x, y): (u32, u32), sample: u32) -> String {
    let size = match (settings.width, settings.height) {
        (Some(width), Some(height)) => format!(" --width {width} --height {height}"),
        _ => String::new(),
    };
    let depth = settings.max_depth.map_or(String::new(), |depth| format!(" --max-depth {depth}"));
    let roulette = settings.rr_depth.map_or("off".to_string(), |depth| depth.to_string());
    let train = if settings.learns() { format!(" --train {}", settings.train) } else { String::new() };
    format!(
        "octray trace {scene} --pixel {x},{y} --sample {sample}{size} --strategy {} --lights {} --guide {} --roulette {}{train} \
         --sampler {}{depth} --rr-depth {roulette} --seed {}",
        settings.strategy, settings.lights, settings.guide, settings.roulette, settings.sampler, settings.seed
    )
}

/// A mean and its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub error: f64,
}

impl Estimate {
    /// That of the first channel over a film of independent samples; pixel by pixel, since differences between pixels are the
    /// picture, not noise.
    pub fn of(film: &Film) -> Estimate {
        let n = f64::from(film.spp);
        let variance = |sum: f64, squares: f64| (squares - sum * sum / n).max(0.0) / (n - 1.0).max(1.0) / n;
        let variance: f64 =
            film.pixels.iter().zip(&film.squares).map(|(p, squares)| variance(p.sum[0], squares.0[0])).sum();
        Estimate { mean: film.mean_radiance()[0], error: variance.sqrt() / film.pixels.len() as f64 }
    }

    /// That of independent values.
    pub fn of_values(values: &[f64]) -> Estimate {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        Estimate { mean, error: (squares / (n - 1.0).max(1.0) / n).sqrt() }
    }

    /// How many standard errors the mean is from `truth`, once the share `slack` of it is forgiven: what rounding costs.
    pub fn sigmas(&self, truth: f64, slack: f64) -> f64 {
        let excess = (self.mean - truth).abs() - slack * truth.abs();
        match excess {
            excess if excess <= 0.0 => 0.0,
            // Not a number stays so.
            excess => excess / self.error.max(1e-12 * truth.abs()).max(f64::MIN_POSITIVE),
        }
    }
}

/// The mean of a render and what it should be.
#[derive(Clone, Debug)]
pub struct Mean {
    /// The mean.
    pub estimate: Estimate,
    /// What it should be.
    pub truth: f64,
    /// Samples that were not finite.
    pub nonfinite: u64,
    /// The command that shows a path of the pixel that is farthest off.
    pub trace: String,
}

/// The worst of many means.
#[derive(Clone, Debug, Default)]
pub struct Worst {
    /// The most standard errors that any mean is off.
    pub sigmas: f64,
    /// Of it: what was tried, mean and truth.
    pub what: String,
    /// Of it: the command that shows a path.
    pub trace: Option<String>,
    /// The largest standard error, relative to the truth.
    pub noise: f64,
    /// Samples that were not finite.
    pub nonfinite: u64,
}

impl Worst {
    /// Takes a mean into account; `slack` is the share of the truth that rounding may cost.
    pub fn add(&mut self, what: &str, mean: Mean, slack: f64) {
        let sigmas = mean.estimate.sigmas(mean.truth, slack);
        let off = mean.estimate.mean / mean.truth - 1.0;
        self.nonfinite += mean.nonfinite;
        if mean.truth != 0.0 {
            self.noise = self.noise.max(mean.estimate.error / mean.truth.abs());
        }
        if self.trace.is_none() || worse(sigmas, self.sigmas) {
            self.sigmas = sigmas;
            self.what = format!("{what}: {:.7e} for {:.7e} ({off:+.1e})", mean.estimate.mean, mean.truth);
            self.trace = Some(mean.trace);
        }
    }
}

/// The pixel whose mean is farthest from `truth`.
fn worst_pixel(film: &Film, truth: f64) -> (u32, u32) {
    let off = |p: u32| (f64::from(film.mean(p % film.width, p / film.width)[0]) - truth).abs();
    let worst = (0..film.width * film.height).max_by(|&p, &q| off(p).total_cmp(&off(q))).unwrap_or(0);
    (worst % film.width, worst / film.width)
}
