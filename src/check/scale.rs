//! Scale and offset: a scene in other units or elsewhere is the same scene.

use crate::check::item::{Check, Effort};
use crate::check::row::Outcome;
use crate::check::scenes::places::grid_at;
use crate::check::trial::{SIGMAS, Trial, Worst, small};
use crate::check::truth::direct_light;
use crate::check::twin::{Apart, Differing, larger};
use crate::error::{Error, Result};
use crate::settings::Settings;
use crate::strategy::Strategy;
use crate::tables::scale_limits::{LARGEST_COORDINATE, SMALLEST_SIZE};

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "scale", what: "powers_of_two_keep_every_bit", run: powers_of_two_keep_every_bit },
    Check { group: "scale", what: "powers_of_ten_are_twins", run: powers_of_ten_are_twins },
    Check { group: "scale", what: "lamplight_in_any_unit", run: lamplight_in_any_unit },
    Check { group: "scale", what: "beyond_the_limits_is_refused", run: beyond_the_limits_is_refused },
    Check { group: "scale", what: "offset_1e1_to_1e3_sizes", run: offset_1e1_to_1e3_sizes },
    Check { group: "scale", what: "offset_1e4_sizes", run: offset_1e4_sizes },
    Check { group: "scale", what: "offset_1e5_to_1e7_sizes_is_told", run: offset_1e5_to_1e7_sizes_is_told },
];

/// Scenes at which the engines are compared.
pub const CASES: &[(&str, &[f64])] = &[
    ("room", &[1e-9, 0.0, 1e-3]),
    ("room", &[1.0, 0.0, 1e-3]),
    ("room", &[1e11, 0.0, 1e-3]),
    ("room", &[1.0, 1e1, 0.00048828125]),
    ("room", &[1.0, 1e3, 0.00048828125]),
    ("room", &[1.0, 1e4, 0.00390625]),
    ("room", &[1.0, 1e6, 0.25]),
];

/// Settings of the pictures of the room.
fn settings(effort: &Effort, usual: u32) -> Settings {
    Settings { max_depth: Some(6), ..small(24, effort.samples(usual, 4)) }
}

/// Radiance has no unit of length, and every operation, densities over areas and all, scales by powers of two without
/// rounding.
fn powers_of_two_keep_every_bit(effort: &Effort) -> Result<Outcome> {
    let settings = settings(effort, 16);
    let unit = Trial::new("room", &[1.0, 0.0, 1.0 / 2048.0])?.render(&settings).film;
    let mut differing = Differing::default();
    for power in [-33, -20, -7, -1, 1, 10, 25, 38] {
        let trial = Trial::new("room", &[f64::from(power).exp2(), 0.0, 1.0 / 2048.0])?;
        let film = trial.render(&settings).film;
        differing.add(&format!("2^{power}"), &trial.prepared, &settings, [&film, &unit]);
    }
    Ok(Outcome::at_most(differing.pixels as f64, 0.0)
        .tried(differing.samples, "samples at 8 scales, 2^-33 to 2^38, pixels with other bits than at 1")
        .note(differing.what)
        .trace(differing.trace))
}

fn powers_of_ten_are_twins(effort: &Effort) -> Result<Outcome> {
    let settings = settings(effort, 32);
    let unit = Trial::new("room", &[1.0, 0.0, 1.0 / 2048.0])?.render(&settings).film;
    let (mut worst, mut samples) = (0.0, 0);
    for power in [-10, -9, -6, -3, 3, 6, 9, 11] {
        let trial = Trial::new("room", &[10f64.powi(power), 0.0, 1.0 / 2048.0])?;
        let film = trial.render(&settings).film;
        worst = larger(worst, Apart::of(&unit, &film).certain(SIGMAS));
        samples += u64::from(film.spp) * film.pixels.len() as u64;
    }
    Ok(Outcome::at_most(worst, 1e-4).tried(samples, "samples at 8 scales, 1e-10 to 1e11, relative difference from 1"))
}

/// A lamp a unit above a floor, in units of 1e-9 to 1e9, against Lambert's formula.
fn lamplight_in_any_unit(effort: &Effort) -> Result<Outcome> {
    let spp = effort.samples(64, 16);
    let (mut worst, mut samples) = (Worst::default(), 0);
    for unit in [1e-9, 1e-7, 1e-5, 1e-3, 1.0, 1e3, 1e5, 1e7, 1e9] {
        let mut scene = crate::check::scenes::load("lamp:0.5:1:1:0.5:0")?;
        let place = |p: f64| p * unit;
        scene.desc.meshes[0].positions.iter_mut().for_each(|p| *p = p.map(|x| place(f64::from(x)) as f32));
        scene.desc.camera.position = scene.desc.camera.position.map(place);
        scene.desc.camera.look_at = scene.desc.camera.look_at.map(place);
        let truth = direct_light(&scene.desc).unwrap_or(f64::NAN);
        let trial = Trial { prepared: scene.prepare()?, scene };
        for strategy in [Strategy::Nee, Strategy::MisPower, Strategy::Bsdf] {
            let settings = Settings { strategy, max_depth: Some(1), ..small(16, spp) };
            worst.add(&format!("{strategy}, {unit:e}"), trial.mean(&settings, truth), 1e-5);
            samples += u64::from(spp) * 256;
        }
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(samples, "samples of 3 strategies at 9 scales, 1e-9 to 1e9, in standard errors")
        .and(worst.nonfinite == 0, "samples are not finite")
        .note(worst.what))
}

/// Scenes that f32 cannot hold end in an error that says what to do; those within the limits do not.
fn beyond_the_limits_is_refused(_: &Effort) -> Result<Outcome> {
    // The room is 3.4 large and reaches 1.5 far.
    let beyond = [1e-30, 1e-20, 1e-12, 0.25 * SMALLEST_SIZE, LARGEST_COORDINATE, 1e13, 1e20, 1e30];
    let within = [SMALLEST_SIZE, 1e-8, 1e8, 0.5 * LARGEST_COORDINATE];
    let refused = |scale: f64| match Trial::new("room", &[scale, 0.0, 1.0 / 2048.0]) {
        Err(Error::Scene { message, .. }) => message.contains("units"),
        _ => false,
    };
    let wrong: Vec<String> = (beyond.iter().filter(|&&scale| !refused(scale)))
        .chain(within.iter().filter(|&&scale| refused(scale)))
        .map(|scale| format!("{scale:e}"))
        .collect();
    Ok(Outcome::at_most(wrong.len() as f64, 0.0)
        .tried((beyond.len() + within.len()) as u64, "scales, 1e-30 to 1e30, taken though too extreme, or refused")
        .note(wrong.join(", ")))
}

/// The room so many sizes from the origin against the same rounded corners at the origin: the relative difference that is
/// certain, and a note of all.
fn against_twins(effort: &Effort, offsets: &[f64], bound: f64) -> Result<Outcome> {
    let settings = settings(effort, 64);
    let (mut worst, mut notes, mut samples, mut nonfinite) = (0.0, Vec::new(), 0, 0);
    for &sizes in offsets {
        let grid = grid_at(sizes);
        let twin = Trial::new("room", &[1.0, 0.0, grid])?.render(&settings).film;
        let there = Trial::new("room", &[1.0, sizes, grid])?.render(&settings);
        let apart = Apart::of(&twin, &there.film);
        notes.push(format!("{sizes:e}: {:+.1e} +- {:.0e}", apart.relative, apart.error));
        worst = larger(worst, apart.certain(SIGMAS));
        samples += there.stats.paths;
        nonfinite += there.stats.nonfinite;
    }
    Ok(Outcome::at_most(worst, bound)
        .tried(samples, "samples, the mean against the same rounded corners at the origin")
        .and(nonfinite == 0, "samples are not finite")
        .note(notes.join(", ")))
}

fn offset_1e1_to_1e3_sizes(effort: &Effort) -> Result<Outcome> {
    against_twins(effort, &[1e1, 1e2, 1e3], 1e-3)
}

/// Measured, not met: 1e-3. Coordinates are 1e-3 of the room apart there, and rays start 1e-2 of it off its walls.
fn offset_1e4_sizes(effort: &Effort) -> Result<Outcome> {
    against_twins(effort, &[1e4], 5e-2)
}

/// Farther away f32 coordinates are too coarse: octray says so, or refuses, and every sample stays finite.
fn offset_1e5_to_1e7_sizes_is_told(effort: &Effort) -> Result<Outcome> {
    let settings = settings(effort, 16);
    let (mut silent, mut samples, mut notes) = (0, 0, Vec::new());
    for sizes in [1e5, 1e6, 1e7] {
        let grid = grid_at(sizes);
        let trial = match Trial::new("room", &[1.0, sizes, grid]) {
            Ok(trial) => trial,
            Err(Error::Scene { .. }) => {
                notes.push(format!("{sizes:e}: refused"));
                continue;
            }
            Err(error) => return Err(error),
        };
        let there = trial.render(&settings);
        samples += there.stats.paths;
        let told = trial.prepared.warnings.iter().any(|warning| warning.contains("sizes from the origin"));
        silent += u64::from(!told) + there.stats.nonfinite;
        let apart = Trial::new("room", &[1.0, 0.0, grid]).map(|twin| {
            let apart = Apart::of(&twin.render(&settings).film, &there.film);
            format!("{:+.1e} +- {:.0e}", apart.relative, apart.error)
        });
        notes.push(format!("{sizes:e}: {}", apart.unwrap_or_else(|_| "no twin".into())));
    }
    Ok(Outcome::at_most(silent as f64, 0.0)
        .tried(samples, "samples at 3 offsets, silent ones and samples that are not finite")
        .note(notes.join(", ")))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (
            AbsoluteEpsilon,
            &["scale/powers_of_two_keep_every_bit", "scale/powers_of_ten_are_twins", "scale/lamplight_in_any_unit"],
        ),
        (NoScaleLimits, &["scale/beyond_the_limits_is_refused", "scale/offset_1e5_to_1e7_sizes_is_told"]),
        (EyeElsewhere, &["scale/offset_1e1_to_1e3_sizes", "scale/offset_1e4_sizes"]),
    ]
};
