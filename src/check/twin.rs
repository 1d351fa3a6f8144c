//! Pictures that should be the same: bit by bit, or but for a few paths that took another way.

use crate::check::numbers::worse;
use crate::check::trial::{Estimate, trace_command};
use crate::film::Film;
use crate::render::render;
use crate::settings::{Engine, Settings};
use crate::tables::PreparedScene;

/// How many pixels have sums whose bits differ, and the first of them.
pub fn differing(a: &Film, b: &Film) -> (u64, Option<(u32, u32)>) {
    let bits = |v: [f64; 3]| v.map(f64::to_bits);
    let differs = |i: &usize| {
        let (p, q) = (&a.pixels[*i], &b.pixels[*i]);
        bits(p.sum) != bits(q.sum) || a.squares.get(*i) != b.squares.get(*i) || a.groups.get(*i) != b.groups.get(*i)
    };
    let first = (0..a.pixels.len()).find(differs).map(|i| (i as u32 % a.width, i as u32 / a.width));
    ((0..a.pixels.len()).filter(differs).count() as u64, first)
}

/// Pictures that differ, over many renders.
#[derive(Clone, Debug, Default)]
pub struct Differing {
    /// Pixels that differ.
    pub pixels: u64,
    /// Of the first picture that does: what it was.
    pub what: String,
    /// Of the first pixel: the command that shows a path of it.
    pub trace: Option<String>,
    /// Samples compared.
    pub samples: u64,
    /// Pictures compared.
    pub pictures: u64,
}

impl Differing {
    /// Takes two films of `scene` by `settings` into account.
    pub fn add(&mut self, what: &str, scene: &PreparedScene, settings: &Settings, [a, b]: [&Film; 2]) {
        let (pixels, first) = differing(a, b);
        self.pictures += 1;
        self.samples += u64::from(a.spp) * a.pixels.len() as u64;
        if let Some(pixel) = first
            && self.pixels == 0
        {
            self.what = format!("{what}: {pixels} pixels");
            self.trace = Some(trace_command(&scene.name, settings, pixel, first_sample(scene, settings, pixel)));
        }
        self.pixels += pixels;
    }

    /// Renders by both engines.
    pub fn engines(&mut self, what: &str, scene: &PreparedScene, settings: &Settings) {
        let scalar = Settings { engine: Engine::Scalar, ..settings.clone() };
        self.add(what, scene, settings, [&render(scene, settings).film, &render(scene, &scalar).film]);
    }
}

/// The first sample of `pixel` in which the engines differ, by halving; 0 where they do not (or only in passing).
fn first_sample(scene: &PreparedScene, settings: &Settings, (x, y): (u32, u32)) -> u32 {
    let crop = Some(crate::settings::Crop { x, y, width: 1, height: 1 });
    let differ = |spp: u32| {
        let film = |engine| render(scene, &Settings { engine, spp, crop, threads: 1, ..settings.clone() }).film;
        differing(&film(Engine::Packet), &film(Engine::Scalar)).0 > 0
    };
    if !differ(settings.spp) {
        return 0;
    }
    let (mut same, mut different) = (0, settings.spp);
    while different - same > 1 {
        let middle = same + (different - same) / 2;
        if differ(middle) { different = middle } else { same = middle }
    }
    different - 1
}

/// What two pictures of the same samples differ by in the mean: no noise is between them but for paths that took another way.
#[derive(Clone, Copy, Debug)]
pub struct Apart {
    /// Mean difference over the mean of the first.
    pub relative: f64,
    /// Its standard error, by the spread over pixels.
    pub error: f64,
}

impl Apart {
    /// That of the first channel of `b` from `a`.
    pub fn of(a: &Film, b: &Film) -> Apart {
        let (n, m) = (f64::from(a.spp.max(1)), f64::from(b.spp.max(1)));
        let differences: Vec<f64> = a.pixels.iter().zip(&b.pixels).map(|(p, q)| q.sum[0] / m - p.sum[0] / n).collect();
        let estimate = Estimate::of_values(&differences);
        let mean = a.mean_radiance()[0].abs().max(f64::MIN_POSITIVE);
        Apart { relative: estimate.mean / mean, error: estimate.error / mean }
    }

    /// How far the means are apart for certain: `sigmas` standard errors forgiven.
    pub fn certain(&self, sigmas: f64) -> f64 {
        let apart = self.relative.abs() - sigmas * self.error;
        if apart < 0.0 { 0.0 } else { apart }
    }
}

/// The larger of two figures; one that is no number is larger.
pub fn larger(a: f64, b: f64) -> f64 {
    if worse(b, a) { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::trial::{Trial, small};

    #[test]
    fn differences_are_counted_and_traced() {
        let trial = Trial::new("furnace", &[0.5, 1.0]).unwrap();
        let settings = Settings { max_depth: Some(2), ..small(4, 3) };
        let film = trial.render(&settings).film;
        let mut other = film.clone();
        other.pixels[6].sum[1] += 1e-12;
        assert_eq!((differing(&film, &film), differing(&film, &other)), ((0, None), (1, Some((2, 1)))));
        let mut differing = Differing::default();
        differing.add("a", &trial.prepared, &settings, [&film, &film]);
        assert!(differing.pixels == 0 && differing.trace.is_none() && differing.samples == 48);
        differing.add("b", &trial.prepared, &settings, [&film, &other]);
        assert!(differing.pixels == 1 && differing.trace.unwrap().contains("--pixel 2,1 --sample 0"));
    }

    #[test]
    fn noise_that_two_pictures_share_is_none_between_them() {
        let trial = Trial::new("lamp", &[0.5, 1.0, 1.0, 0.5, 0.0]).unwrap();
        let settings = Settings { max_depth: Some(1), ..small(8, 4) };
        let film = trial.render(&settings).film;
        let mut brighter = film.clone();
        brighter.pixels.iter_mut().for_each(|pixel| pixel.sum[0] *= 1.001);
        assert_eq!(Apart::of(&film, &film).certain(5.0), 0.0);
        assert!((Apart::of(&film, &brighter).relative - 1e-3).abs() < 1e-9);
    }
}
