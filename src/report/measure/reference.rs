//! The image that runs are measured against: a closed form, a file, or a long render of its own.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

use crate::files::sealed::{self, Checksum, Found};
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

/// The parts of a reference that are done.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Parts {
    /// Samples a pixel of each.
    spp: u32,
    seconds: f64,
    cpu_seconds: f64,
    #[serde(skip)]
    pixels: Vec<Vec<[f32; 3]>>,
}

const MAGIC: &str = "octray unfinished reference, version 2";

impl Parts {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.pixels.len()
    }

    /// Keeps the parts in `path`, so that the reference of the same `key` can go on.
    ///
    /// # Errors
    /// [`crate::Error::Write`].
    pub fn keep(&self, key: &str, path: &Path) -> crate::Result<()> {
        sealed::write(path, MAGIC, &(key.to_owned(), self.clone()), |out| {
            self.pixels.iter().flatten().try_for_each(|pixel| out.numbers(&pixel.map(f64::from)))
        })
    }

    /// The parts kept in `path` for `key`, of images of so many pixels; none if they are of something else, or damaged.
    pub fn kept(key: &str, pixels: usize, path: &Path) -> Parts {
        let read = || {
            let Ok(Found::Whole((found, parts), numbers)) = sealed::open::<(String, Parts)>(path, MAGIC) else {
                return None;
            };
            if found != key || numbers.left() > u64::from(PARTS) * 3 * pixels as u64 {
                return None;
            }
            let numbers: Vec<f64> = numbers.collect();
            let pixel = |value: &[f64; 3]| value.map(|value| value as f32);
            let images = numbers.chunks(3 * pixels.max(1)).map(|part| part.as_chunks().0.iter().map(pixel).collect());
            let images: Vec<Vec<[f32; 3]>> = images.collect();
            let whole = images.len() < PARTS as usize && images.iter().all(|image| image.len() == pixels);
            (whole && parts.spp > 0 && numbers.iter().all(|number| number.is_finite()))
                .then_some(Parts { pixels: images, ..parts })
        };
        read().unwrap_or_default()
    }
}

/// Renders the reference of `case`: `budget` in all, in [`PARTS`] parts with a seed each, those that `parts` lacks. `None` if
/// `stop` was set; `parts` then holds what is done. `told` hears of every part.
pub fn render(
    case: &Case,
    experiment: &Experiment,
    how: Configuration,
    budget: Budget,
    parts: &mut Parts,
    stop: &AtomicBool,
    told: &mut dyn FnMut(&Parts),
) -> Option<Reference> {
    for part in parts.count() as u32..PARTS {
        // Equal parts: what the first reaches in its time, the others take.
        let each = match budget {
            _ if part > 0 => Budget::Spp(parts.spp),
            Budget::Spp(spp) => Budget::Spp(spp.div_ceil(PARTS)),
            Budget::Time(time) => Budget::Time(time / PARTS),
        };
        let seed = experiment.settings.seed.wrapping_add(REFERENCE_SEEDS + part);
        let settings = experiment.settings_of(case, how, each, seed);
        let render = render_with(&case.scene, &settings, &|_| !stop.load(Ordering::Relaxed));
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        parts.spp = render.film.spp;
        parts.seconds += render.stats.render_s;
        parts.cpu_seconds += render.stats.cpu_s;
        parts.pixels.push(render.film.to_image().pixels);
        told(parts);
    }
    let (pixels, variance) = mean_and_variance(&parts.pixels);
    let (width, height) = experiment.film();
    let image = Image { width, height, pixels, variance: Some(variance), ..Image::default() };
    let (strategy, lights, sampler) = (how.strategy.name(), how.lights.name(), how.sampler.name());
    let Parts { seconds, cpu_seconds, spp, .. } = *parts;
    let source = Source::Rendered { strategy, lights, sampler, spp: PARTS * spp, seconds, cpu_seconds, cached: false };
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
    image.metadata.push(("checksum".to_owned(), checksum(&image)));
    image.save_exr(path)
}

/// A checksum of all that a kept reference says, but itself: the file format has none.
fn checksum(image: &Image) -> String {
    let mut sum = Checksum::default();
    let said =
        image.metadata.iter().filter(|(key, _)| key != "checksum").map(|(key, value)| format!("{key} = {value}\n"));
    said.for_each(|line| sum.add(line.as_bytes()));
    sum.add(&[image.width.to_le_bytes(), image.height.to_le_bytes()].concat());
    for value in image.pixels.iter().chain(image.variance.iter().flatten()).flatten() {
        sum.add(&value.to_le_bytes());
    }
    format!("{:016x}", sum.value())
}

/// The reference kept in `path`, if it was made for `key` and nothing of it has changed. Whatever else stands there is no
/// reference of ours.
pub fn kept(path: &Path, key: &str, how: Configuration) -> Option<Reference> {
    let mut image = Image::read(path).ok()?;
    let text = |name: &str| image.metadata.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone());
    if text("reference")? != key
        || text("checksum")? != checksum(&image)
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
    fn parts_that_were_kept_are_taken_for_the_same_reference_only() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("reference.unfinished");
        let image = |value: f32| vec![[value, 0.1, -value]; 6];
        let parts = Parts { spp: 4, seconds: 1.5, cpu_seconds: 3.0, pixels: vec![image(0.3), image(1e30)] };
        parts.keep("key", &path).unwrap();
        let again = Parts::kept("key", 6, &path);
        assert_eq!((again.count(), again.spp, again.cpu_seconds), (2, 4, 3.0));
        assert_eq!(again.pixels, parts.pixels);
        assert_eq!((Parts::kept("other", 6, &path).count(), Parts::kept("key", 5, &path).count()), (0, 0));
        std::fs::write(&path, "nonsense").unwrap();
        assert_eq!(Parts::kept("key", 6, &path).count(), 0);
    }

    #[test]
    fn a_kept_reference_that_was_changed_is_made_anew() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("reference.exr");
        let how = Configuration {
            strategy: crate::Strategy::MisPower,
            lights: crate::Lights::Tree,
            guide: crate::Guide::Off,
            sampler: crate::Sampler::Sobol,
            engine: crate::Engine::Packet,
        };
        let (strategy, lights, sampler) = ("mis-power", "tree", "sobol");
        let source =
            Source::Rendered { strategy, lights, sampler, spp: 8, seconds: 1.5, cpu_seconds: 3.0, cached: false };
        let pixels = vec![[0.25, 0.5, 1.0]; 6];
        let image = Image { width: 3, height: 2, variance: Some(pixels.clone()), pixels, ..Image::default() };
        keep(&Reference { image, source }, "key", &path).unwrap();
        assert!(kept(&path, "key", how).is_some() && kept(&path, "other", how).is_none());
        let bytes = std::fs::read(&path).unwrap();
        // The last bytes are values: a bit of two of them.
        let mut changed = bytes.clone();
        changed[bytes.len() - 3] ^= 1;
        changed[bytes.len() - 11] ^= 1;
        std::fs::write(&path, changed).unwrap();
        assert!(kept(&path, "key", how).is_none());
    }

    #[test]
    fn parts_make_a_mean_and_its_variance() {
        let parts = [1.0, 2.0, 6.0].map(|value| vec![[value, 1.0, 0.0]]);
        let (mean, variance) = mean_and_variance(&parts);
        assert_eq!(mean, [[3.0, 1.0, 0.0]]);
        // Deviations -2, -1, 3: 14 / 2 / 3.
        assert_eq!(variance, [[14.0 / 6.0, 0.0, 0.0]]);
    }
}
