//! Error bars: how often the truth lies within what is stated.

use crate::check::item::{Check, Effort};
use crate::check::numbers::worse;
use crate::check::row::Outcome;
use crate::check::scenes::lamps::MIRRORED;
use crate::check::trial::{SIGMAS, Trial, small};
use crate::error::Result;
use crate::film::Film;
use crate::settings::{Sampler, Settings};
use crate::strategy::Strategy;
use std::f64::consts::PI;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "error_bars", what: "coverage_of_a_furnace", run: coverage_of_a_furnace },
    Check { group: "error_bars", what: "coverage_by_groups", run: coverage_by_groups },
    Check { group: "error_bars", what: "coverage_of_a_lamp", run: coverage_of_a_lamp },
    Check { group: "error_bars", what: "coverage_of_rare_light", run: coverage_of_rare_light },
    Check { group: "error_bars", what: "stated_over_true", run: stated_over_true },
    Check { group: "error_bars", what: "target_error", run: target_error },
    Check { group: "error_bars", what: "target_error_of_rare_light", run: target_error_of_rare_light },
    Check { group: "error_bars", what: "target_error_of_a_caustic", run: target_error_of_a_caustic },
];

/// Pixels of a side.
const SIDE: u32 = 8;

/// Renders of one scene with a seed each.
struct Seeds<'a> {
    trial: &'a Trial,
    settings: Settings,
    count: u32,
}

impl Seeds<'_> {
    fn films(&self) -> impl Iterator<Item = Film> + '_ {
        (0..self.count).map(|seed| self.trial.render(&Settings { seed, ..self.settings.clone() }).film)
    }

    /// The share of seeds whose picture's mean lies within 1.96 stated standard errors of `truth`. Pixels are independent, so
    /// the error of their mean is theirs over the root of their number.
    fn coverage(&self, truth: f64) -> f64 {
        let within = |film: &Film| {
            let (relative, mean) = (film.relative_error().unwrap_or(0.0), film.mean_radiance()[0]);
            (mean - truth).abs() <= 1.959_964 * relative * mean / f64::from(SIDE)
        };
        self.films().filter(within).count() as f64 / f64::from(self.count)
    }

    /// That share should be 95 %: how many of its own standard errors it is off.
    fn coverage_row(&self, truth: f64) -> Outcome {
        let (share, n) = (self.coverage(truth), f64::from(self.count));
        let sigmas = (share - 0.95).abs() / (0.95 * 0.05 / n).sqrt();
        Outcome::at_most(sigmas, SIGMAS)
            .tried(u64::from(self.count), "seeds, coverage of the 95 % interval in its standard errors")
            .note(format!("the truth lies within it in {:.1} %", 100.0 * share))
    }
}

fn coverage_of_a_furnace(effort: &Effort) -> Result<Outcome> {
    let trial = &Trial::new("furnace", &[0.5, 0.5])?;
    let settings = Settings { max_depth: Some(2), rr_depth: None, ..small(SIDE, 16) };
    Ok(Seeds { trial, settings, count: effort.samples(400, 100) }.coverage_row(1.0 - 0.5f64.powi(3)))
}

fn coverage_by_groups(effort: &Effort) -> Result<Outcome> {
    let trial = &Trial::new("furnace", &[0.5, 0.5])?;
    let settings = Settings { sampler: Sampler::Sobol, max_depth: Some(2), rr_depth: None, ..small(SIDE, 16) };
    Ok(Seeds { trial, settings, count: effort.samples(400, 100) }.coverage_row(1.0 - 0.5f64.powi(3)))
}

/// The irradiance from a level square of radiance 1 and half the side `half`, `height` straight above.
fn level_square(half: f64, height: f64) -> f64 {
    let x = half / height;
    let root = (1.0 + x * x).sqrt();
    4.0 * x / root * (x / root).atan()
}

fn coverage_of_a_lamp(effort: &Effort) -> Result<Outcome> {
    let trial = &Trial::new("lamp", &[0.5, 1.0, 1.0, 0.5, 0.0])?;
    let settings = Settings { strategy: Strategy::Nee, max_depth: Some(1), ..small(SIDE, 16) };
    let seeds = Seeds { trial, settings, count: effort.samples(400, 100) };
    Ok(seeds.coverage_row(0.5 / PI * level_square(0.5, 1.0)))
}

/// Two lamps: one large, and a small bright one that BSDF samples rarely hit, with a share `rare` of the light; and the truth.
fn two_lamps(half: f64, rare: f64) -> Result<(Trial, f64)> {
    let large = level_square(1.0, 1.0);
    let small = level_square(half, 0.5);
    let radiance = rare / (1.0 - rare) * large / small;
    let trial = Trial::new("two_lamps", &[half, radiance])?;
    // The small lamp hangs below the large one and hides its own size of it.
    let hidden = level_square(half, 0.5);
    Ok((trial, 0.5 / PI * (large - hidden + radiance * small)))
}

/// A quarter of the light comes from what one sample in 400 finds: with 1,024 samples a pixel the interval holds in nine of ten
/// cases at least.
fn coverage_of_rare_light(effort: &Effort) -> Result<Outcome> {
    let (trial, truth) = two_lamps(0.025, 0.25)?;
    let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(1), ..small(SIDE, 1024) };
    let seeds = Seeds { trial: &trial, settings, count: effort.samples(100, 40) };
    let missed = 1.0 - seeds.coverage(truth);
    Ok(Outcome::at_most(missed, 0.1)
        .tried(u64::from(seeds.count), "seeds of rare light, share of 95 % intervals without the truth"))
}

/// Over many seeds the stated mean squared error of pixels is the true one.
fn stated_over_true(effort: &Effort) -> Result<Outcome> {
    let trial = Trial::new("furnace", &[0.5, 0.5])?;
    let truth = 1.0 - 0.5f64.powi(3);
    let count = effort.samples(300, 100);
    let (mut worst, mut note): (f64, String) = (0.0, String::new());
    for sampler in [Sampler::Independent, Sampler::Sobol] {
        let settings = Settings { sampler, max_depth: Some(2), rr_depth: None, ..small(SIDE, 16) };
        let (mut stated, mut real) = (0.0, 0.0);
        for film in (Seeds { trial: &trial, settings, count }).films() {
            let error = film.relative_error().unwrap_or(0.0) * film.mean_radiance()[0];
            stated += error * error;
            let square = |p: u32| (f64::from(film.mean(p % SIDE, p / SIDE)[0]) - truth).powi(2);
            real += (0..SIDE * SIDE).map(square).sum::<f64>() / f64::from(SIDE * SIDE);
        }
        let off = (stated / real - 1.0).abs();
        if worse(off, worst) {
            (worst, note) = (off, format!("{sampler}: {:.3}", stated / real));
        }
    }
    // A mean of 64 squares a seed, each with a variance of 2: 5 standard errors.
    let bound = SIGMAS * (2.0 / (f64::from(count) * f64::from(SIDE * SIDE))).sqrt() * 1.2;
    Ok(Outcome::at_most(worst, bound)
        .tried(u64::from(2 * count), "seeds, stated over true mean squared error, distance from 1")
        .note(note))
}

/// What a target error asks for is what comes out: the share of seeds whose picture has a relative error of more than 1.5 times
/// that.
fn missed_target(trial: &Trial, settings: Settings, truth: f64, target: f64, count: u32, what: &str) -> Outcome {
    let (mut missed, mut spp, mut worst) = (0, 0, 0.0f64);
    let settings = Settings { target_error: Some(target), spp: 1 << 14, ..settings };
    for film in (Seeds { trial, settings, count }).films() {
        let pixels = SIDE * SIDE;
        let square = |p: u32| (f64::from(film.mean(p % SIDE, p / SIDE)[0]) / truth - 1.0).powi(2);
        let error = ((0..pixels).map(square).sum::<f64>() / f64::from(pixels)).sqrt();
        let off = (film.mean_radiance()[0] / truth - 1.0).abs();
        missed += u32::from(error > 1.5 * target);
        spp += film.spp;
        worst = worst.max(off);
    }
    let share = f64::from(missed) / f64::from(count);
    Outcome::at_most(share, 0.1).tried(u64::from(count), what).note(format!(
        "{} samples a pixel in the mean, means off by {:.1} % at most",
        spp / count,
        100.0 * worst
    ))
}

fn target_error(effort: &Effort) -> Result<Outcome> {
    let trial = Trial::new("lamp", &[0.5, 1.0, 1.0, 0.5, 0.0])?;
    let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(1), ..small(SIDE, 1) };
    let truth = 0.5 / PI * level_square(0.5, 1.0);
    let what = "seeds with a target error of 5 %, share whose error is above 7.5 %";
    Ok(missed_target(&trial, settings, truth, 0.05, effort.samples(100, 40), what))
}

fn target_error_of_rare_light(effort: &Effort) -> Result<Outcome> {
    let (trial, truth) = two_lamps(0.012, 0.4)?;
    let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(1), ..small(SIDE, 1) };
    let what = "seeds of rare light with a target error of 20 %, share whose error is above 30 %";
    Ok(missed_target(&trial, settings, truth, 0.2, effort.samples(50, 40), what))
}

/// A lamp in a mirror: two fifths of the floor's light come by way of a mirror that light samples do not find.
fn target_error_of_a_caustic(effort: &Effort) -> Result<Outcome> {
    let (half, height) = (0.025, 0.5);
    let trial = Trial::new("mirrored_lamp", &[half, height])?;
    let truth = 0.5 / PI * MIRRORED.map(|aside| square_beside(half, height, aside)).iter().sum::<f64>();
    let settings = Settings { strategy: Strategy::MisPower, max_depth: Some(2), ..small(SIDE, 1) };
    let what = "seeds of a caustic with a target error of 20 %, share whose error is above 30 %";
    Ok(missed_target(&trial, settings, truth, 0.2, effort.samples(50, 40), what))
}

/// The irradiance from a level square of radiance 1 and half the side `half`, `height` above and `aside` along x: the corners of
/// two rectangles each side of the foot (configuration B-3 of Howell's catalogue).
fn square_beside(half: f64, height: f64, aside: f64) -> f64 {
    // A right-angled corner over (0, a) x (0, b), one corner straight above.
    let corner = |a: f64, b: f64| {
        let (x, y) = (a / height, b / height);
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        0.5 * (x / p * (y / p).atan() + y / q * (x / q).atan())
    };
    2.0 * (corner(aside + half, half) - corner(aside - half, half))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[(
        SmallErrors,
        &[
            "error_bars/coverage_of_a_furnace",
            "error_bars/coverage_by_groups",
            "error_bars/coverage_of_a_lamp",
            "error_bars/coverage_of_rare_light",
            "error_bars/stated_over_true",
            "error_bars/target_error",
            "error_bars/target_error_of_rare_light",
            "error_bars/target_error_of_a_caustic",
        ],
    )]
};
