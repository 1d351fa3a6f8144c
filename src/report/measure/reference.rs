//! The picture that runs are measured against: a closed form, a file, or a long render of its own.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::image::Image;
use crate::render::render_with;
use crate::report::measure::closed_form;
use crate::report::measure::experiment::{Budget, Case, Configuration, Experiment, REFERENCE_SEEDS};
use crate::report::measure::truth::{Reference, Source};
use crate::scene::fingerprint;
use crate::setup::frame::Frame;
use crate::setup::recipe::Recipe;

/// Parts a rendered reference is made of; their spread is its noise, whatever the sampler.
pub const PARTS: u32 = 8;

/// The closed form of `case`, if it has one.
pub fn closed_form(case: &Case, experiment: &Experiment) -> Option<Reference> {
    let radiance = closed_form::radiance(&case.desc, case.max_depth)?;
    let (width, height) = experiment.film();
    let pixels = vec![radiance.map(|value| value as f32); width as usize * height as usize];
    let image = Image { width, height, pixels, ..Image::default() };
    Some(Reference { image, source: Source::ClosedForm })
}

/// What decides a rendered reference's every bit, as text; a cached one is taken if its text is the same.
pub fn key(case: &Case, experiment: &Experiment, how: Configuration, budget: Budget) -> String {
    let settings = experiment.settings_of(case, how, budget, experiment.settings.seed);
    let frame = Frame::nearest(&settings, experiment.film());
    let recipe = Recipe::new(&case.desc.name, &settings, &frame)
        .and("content of the scene", format!("{:016x}", fingerprint::scene(&case.desc)))
        .and("budget", format!("{budget:?} in {PARTS}"));
    recipe.line()
}

/// Renders the reference of `case`: `budget` in all, in [`PARTS`] parts with a seed each. `None` if `stop` was set.
/// `told` hears how many parts are done.
pub fn render(
    case: &Case,
    experiment: &Experiment,
    how: Configuration,
    budget: Budget,
    stop: &AtomicBool,
    told: &dyn Fn(u32),
) -> Option<Reference> {
    let (mut seconds, mut cpu_seconds, mut parts) = (0.0, 0.0, Vec::new());
    let mut each = match budget {
        Budget::Spp(spp) => Budget::Spp(spp.div_ceil(PARTS)),
        Budget::Time(time) => Budget::Time(time / PARTS),
    };
    let mut spp = 0;
    for part in 0..PARTS {
        let seed = experiment.settings.seed.wrapping_add(REFERENCE_SEEDS + part);
        let settings = experiment.settings_of(case, how, each, seed);
        let render = render_with(&case.scene, &settings, &|_| !stop.load(Ordering::Relaxed));
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        // Equal parts: what the first reaches in its time, the others take.
        each = Budget::Spp(render.film.spp);
        spp += render.film.spp;
        seconds += render.stats.render_s;
        cpu_seconds += render.stats.cpu_s;
        parts.push(render.film.to_image().pixels);
        told(part + 1);
    }
    let (pixels, variance) = mean_and_variance(&parts);
    let (width, height) = experiment.film();
    let image = Image { width, height, pixels, variance: Some(variance), ..Image::default() };
    let (strategy, lights, sampler) = (how.strategy.name(), how.lights.name(), how.sampler.name());
    let source = Source::Rendered { strategy, lights, sampler, spp, seconds, cpu_seconds, cached: false };
    Some(Reference { image, source })
}

/// The mean of equally long parts and its variance, s^2 / n.
fn mean_and_variance(parts: &[Vec<[f32; 3]>]) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let n = parts.len() as f64;
    let at = |i: usize, c: usize| {
        let mean = parts.iter().map(|part| part[i][c] as f64).sum::<f64>() / n;
        let squares: f64 = parts.iter().map(|part| (part[i][c] as f64 - mean).powi(2)).sum();
        (mean as f32, (squares / (n - 1.0) / n) as f32)
    };
    (0..parts[0].len())
        .map(|i| {
            let channels = [0, 1, 2].map(|c| at(i, c));
            (channels.map(|(mean, _)| mean), channels.map(|(_, variance)| variance))
        })
        .unzip()
}

/// Keeps `reference` in `path` under `key`.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn keep(reference: &Reference, key: &str, path: &Path) -> crate::Result<()> {
    let Source::Rendered { spp, seconds, cpu_seconds, .. } = &reference.source else { return Ok(()) };
    let mut image = reference.image.clone();
    let texts = [("reference", key.to_owned()), ("spp", spp.to_string())];
    let costs = [("seconds", seconds.to_string()), ("cpu_seconds", cpu_seconds.to_string())];
    image.metadata = texts.into_iter().chain(costs).map(|(key, value)| (key.to_owned(), value)).collect();
    image.save_exr(path)
}

/// The reference kept in `path`, if it was made for `key`. Whatever else stands there is no reference of ours.
pub fn kept(path: &Path, key: &str, how: Configuration) -> Option<Reference> {
    let mut image = Image::read(path).ok()?;
    let text = |name: &str| image.metadata.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone());
    if text("reference")? != key
        || image.variance.is_none()
        || crate::report::measure::metrics::check(&image, &image).is_err()
    {
        return None;
    }
    let source = Source::Rendered {
        strategy: how.strategy.name(),
        lights: how.lights.name(),
        sampler: how.sampler.name(),
        spp: text("spp")?.parse().ok()?,
        seconds: text("seconds")?.parse().ok()?,
        cpu_seconds: text("cpu_seconds")?.parse().ok()?,
        cached: true,
    };
    image.metadata.clear();
    Some(Reference { image, source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_make_a_mean_and_its_variance() {
        let parts = [1.0, 2.0, 6.0].map(|value| vec![[value, 1.0, 0.0]]);
        let (mean, variance) = mean_and_variance(&parts);
        assert_eq!(mean, [[3.0, 1.0, 0.0]]);
        // Deviations -2, -1, 3: 14 / 2 / 3.
        assert_eq!(variance, [[14.0 / 6.0, 0.0, 0.0]]);
    }
}
