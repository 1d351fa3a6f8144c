//! Environment maps: polar rows, seams, single texels, thousands of rows.

use crate::check::item::{Check, Effort};
use crate::check::numbers::{Exact, Numbers, worse};
use crate::check::row::Outcome;
use crate::check::scenes::skies::noise;
use crate::check::trial::{SIGMAS, Trial, Worst, small};
use crate::error::Result;
use crate::reference::double;
use crate::reference::single::lights::environment::{map_pdf_dir, sample_map, texel_index};
use crate::scene::desc::MapDesc;
use crate::settings::Settings;
use crate::strategy::Strategy;
use crate::tables::lights::environment::EnvironmentMap;
use glam::Vec3;
use std::f64::consts::PI;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "environment", what: "polar_row_of_256", run: |effort| polar_row(effort, 256) },
    Check { group: "environment", what: "polar_row_of_4096", run: |effort| polar_row(effort, 4096) },
    Check { group: "environment", what: "polar_row_of_16384", run: |effort| polar_row(effort, 16_384) },
    Check { group: "environment", what: "one_texel", run: one_texel },
    Check { group: "environment", what: "found_where_sampled", run: found_where_sampled },
    Check { group: "environment", what: "seams_and_poles", run: seams_and_poles },
    Check { group: "environment", what: "densities_integrate_to_one", run: densities_integrate_to_one },
    Check { group: "environment", what: "total_power", run: total_power },
    Check { group: "environment", what: "strategies_agree", run: strategies_agree },
    Check { group: "environment", what: "black", run: black },
    Check { group: "environment", what: "even_maps_are_constants", run: even_maps_are_constants },
];

/// The irradiance on a level floor from row `row` of a map with `rows` rows, whose radiance is 1 all around: the difference of
/// pi sin^2 at the row's edges, above the horizon.
fn row_irradiance(row: u32, rows: u32) -> f64 {
    let angle = |edge: u32| (f64::from(edge) / f64::from(rows) * PI).min(0.5 * PI);
    // sin^2 b - sin^2 a = sin(b - a) sin(b + a): no digits are lost at the pole.
    let (a, b) = (angle(row), angle(row + 1));
    PI * (b - a).sin() * (b + a).sin()
}

/// One bright texel next to the pole: a floor gets the light of its solid angle, by light samples.
fn polar_row(effort: &Effort, rows: u32) -> Result<Outcome> {
    let (spp, mut worst, mut note, mut trace) = (effort.samples(64, 16), 0.0, String::new(), None);
    let (mut samples, mut nonfinite) = (0, 0);
    for row in [0, 1, 2] {
        for strategy in [Strategy::Nee, Strategy::MisPower] {
            let trial = Trial::new("texel", &[f64::from(rows), f64::from(row), 4.0, 1.0])?;
            let truth = row_irradiance(row, rows) / 4.0 / PI;
            let settings = Settings { strategy, max_depth: Some(1), ..small(16, spp) };
            let mean = trial.mean(&settings, truth);
            samples += u64::from(spp) * 256;
            nonfinite += mean.nonfinite;
            let error = (mean.estimate.mean / truth - 1.0).abs();
            if worse(error, worst) || trace.is_none() {
                (worst, trace) = (error, Some(mean.trace));
                note = format!("row {row}, {strategy}: {:.6e} for {truth:.6e}", mean.estimate.mean);
            }
        }
    }
    Ok(Outcome::at_most(worst, 1e-4)
        .tried(samples, "samples under one texel of the three polar rows, relative error")
        .and(nonfinite == 0, format!("{nonfinite} samples are not finite"))
        .note(note)
        .trace(trace))
}

/// One bright texel anywhere, at the seam too.
fn one_texel(effort: &Effort) -> Result<Outcome> {
    let (spp, mut worst, mut samples) = (effort.samples(64, 16), Worst::default(), 0);
    for (rows, row) in [(8, 0), (8, 2), (32, 9), (32, 15), (64, 3), (512, 200)] {
        for column in [0, 5, 15] {
            let trial = Trial::new("texel", &[f64::from(rows), f64::from(row), 16.0, f64::from(column)])?;
            let truth = row_irradiance(row, rows) / 16.0 / PI;
            for strategy in [Strategy::Nee, Strategy::MisBalance] {
                let settings = Settings { strategy, max_depth: Some(1), ..small(16, spp) };
                samples += u64::from(spp) * 256;
                let what = format!("row {row} of {rows}, column {column}, {strategy}");
                worst.add(&what, trial.mean(&settings, truth), 2e-6);
            }
        }
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(samples, "samples under one texel of 16 columns, in standard errors")
        .and(worst.nonfinite == 0, "samples are not finite")
        .note(worst.what)
        .trace(worst.trace))
}

/// A map of noise, ready.
fn noise_map(columns: u32, rows: u32) -> EnvironmentMap {
    let texels = noise(columns, rows, 5).into_iter().map(|value| [value; 3]).collect();
    let file = "noise".to_string();
    EnvironmentMap::new(&MapDesc { file, width: columns, height: rows, texels, rotate: 77.0, scale: 1.0 }, 1.0)
}

/// Columns and rows of maps.
const SIZES: [(u32, u32); 6] = [(1, 1), (2, 1), (7, 5), (64, 32), (4, 1024), (2, 16_384)];

/// A direction that was drawn from a texel is found in it again, or next to it with the densities of both almost equal in
/// what they come to: the share of directions that are not.
fn found_where_sampled(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(300_000);
    let mut numbers = Numbers::new(1);
    let (mut worst, mut note) = (0.0, String::new());
    for (columns, rows) in SIZES {
        let map = noise_map(columns, rows);
        let distribution = map.distribution(false);
        let (mut lost, count) = (0u64, cases / SIZES.len() as u64);
        for _ in 0..count {
            let words = [numbers.word(), numbers.word()];
            let (direction, texel) = sample_map(&map, distribution, words, [numbers.unit(), numbers.unit()]);
            lost += u64::from(map.texels[texel_index(&map, direction)] != texel);
        }
        let share = lost as f64 / count as f64;
        if worse(share, worst) {
            (worst, note) = (share, format!("worst on {columns} x {rows}"));
        }
    }
    Ok(Outcome::at_most(worst, 5e-4)
        .tried(cases, "directions drawn from maps of up to 16,384 rows, share found in another texel")
        .note(note))
}

/// Directions next to the seam and the poles are looked up where f64 looks them up, but for those within rounding of an edge.
fn seams_and_poles(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(300_000);
    let mut numbers = Numbers::new(2);
    let mut wrong = 0;
    for (columns, rows) in [(64, 32), (1000, 500)] {
        let map = noise_map(columns, rows);
        for _ in 0..cases / 2 {
            let tilt = numbers.magnitude(-9.0, 0.0);
            let v = numbers.direction();
            let near = match numbers.below(3) {
                0 => glam::DVec3::new(v.x * tilt, v.y.signum(), v.z * tilt),
                1 => glam::DVec3::new(v.x * tilt, v.y, v.z),
                _ => v,
            };
            let direction = near.normalize().as_vec3();
            let (got, wanted) = (texel_index(&map, direction), exact_index(&map, direction));
            wrong += u64::from(!wanted.contains(&got));
        }
    }
    Ok(Outcome::at_most(wrong as f64, 0.0)
        .tried(cases, "directions next to seams and poles, those looked up more than 1e-6 turns beside"))
}

/// The texels that a direction may be looked up in: those within 1e-6 turns, and 1e-6 of the distance to the pole, of where f64 says.
fn exact_index(map: &EnvironmentMap, direction: Vec3) -> Vec<usize> {
    let d = direction.as_dvec3().normalize();
    let turns = double::atan2_turns(-d.x, d.z) + f64::from(map.turn);
    // Next to the poles azimuths are as uncertain as the direction's horizontal part is short.
    let slack = 1e-6 + 1e-8 / (d.x * d.x + d.z * d.z).sqrt().max(1e-12);
    let mut found = Vec::new();
    let columns: Vec<u32> = match slack * f64::from(map.width) < 0.5 {
        true => [-slack, slack]
            .map(|off| (((turns + off).rem_euclid(1.0) * f64::from(map.width)) as u32).min(map.width - 1))
            .to_vec(),
        false => (0..map.width).collect(),
    };
    let down = (d.x * d.x + d.z * d.z).sqrt().atan2(d.y) / PI;
    for off in [-1e-6, 0.0, 1e-6] {
        let row = (((down + off * down.min(1.0 - down)) * f64::from(map.height)) as u32).min(map.height - 1);
        found.extend(columns.iter().map(|column| row as usize * map.width as usize + *column as usize));
    }
    found
}

/// Densities of light samples over the solid angles of their texels, exact ones, come to 1: plain and compensated.
fn densities_integrate_to_one(_: &Effort) -> Result<Outcome> {
    let (mut worst, mut note, mut cases) = (0.0, String::new(), 0);
    for (columns, rows) in SIZES {
        let map = noise_map(columns, rows);
        for compensated in [false, true] {
            let distribution = map.distribution(compensated);
            let mut sum = Exact::default();
            for (i, texel) in map.texels.iter().enumerate() {
                sum.add(f64::from(map_pdf_dir(distribution, texel)) * texel_angle(i as u32 / columns, columns, rows));
                cases += 1;
            }
            let error = (sum.total() - 1.0).abs();
            if worse(error, worst) {
                (worst, note) = (error, format!("worst on {columns} x {rows}, compensated: {compensated}"));
            }
        }
    }
    Ok(Outcome::at_most(worst, 1e-4)
        .tried(cases, "texels of maps of up to 16,384 rows, distance of the integral from 1")
        .note(note))
}

/// The solid angle of a texel of row `row`: no digits are lost at the pole.
fn texel_angle(row: u32, columns: u32, rows: u32) -> f64 {
    let angle = |edge: u32| f64::from(edge) / f64::from(rows) * PI;
    let (a, b) = (angle(row), angle(row + 1));
    2.0 * (0.5 * (a + b)).sin() * (0.5 * (b - a)).sin() * 2.0 * PI / f64::from(columns)
}

/// The mean radiance of a map against the exact sum over its texels, bright ones next to the pole among them.
fn total_power(_: &Effort) -> Result<Outcome> {
    let (mut worst, mut note, mut cases) = (0.0, String::new(), 0);
    for (columns, rows) in SIZES {
        for bright in [None, Some(0), Some(rows / 2), Some(rows - 1)] {
            let values = match bright {
                None => noise(columns, rows, 5),
                Some(row) => (0..columns * rows).map(|i| if i / columns == row { 1.0 } else { 0.0 }).collect(),
            };
            let mut wanted = Exact::default();
            for (i, value) in values.iter().enumerate() {
                wanted.add(3.0 * f64::from(*value) * texel_angle(i as u32 / columns, columns, rows) / (4.0 * PI));
            }
            cases += values.len() as u64;
            let texels = values.into_iter().map(|value| [value; 3]).collect();
            let file = "a map".to_string();
            let map = MapDesc { file, width: columns, height: rows, texels, rotate: 0.0, scale: 1.0 };
            let error = (EnvironmentMap::new(&map, 1.0).mean_radiance / wanted.total() - 1.0).abs();
            if worse(error, worst) {
                (worst, note) = (error, format!("worst on {columns} x {rows}, bright row {bright:?}"));
            }
        }
    }
    Ok(Outcome::at_most(worst, 1e-4)
        .tried(cases, "texels of maps of up to 16,384 rows, relative error of the mean radiance")
        .note(note))
}

/// Under noise of five decades every exact strategy gives the exact sum over the texels.
fn strategies_agree(effort: &Effort) -> Result<Outcome> {
    let (spp, mut worst, mut samples) = (effort.samples(128, 64), Worst::default(), 0);
    let (columns, rows) = (16, 8);
    let trial = Trial::new("noise_sky", &[f64::from(columns), f64::from(rows), 5.0])?;
    let mut truth = Exact::default();
    for (i, value) in noise(columns, rows, 5).into_iter().enumerate() {
        truth.add(f64::from(value) * row_irradiance(i as u32 / columns, rows) / f64::from(columns) / PI);
    }
    for &strategy in Strategy::ALL.iter().filter(|strategy| !strategy.is_biased()) {
        let settings = Settings { strategy, max_depth: Some(1), ..small(16, spp) };
        samples += u64::from(spp) * 256;
        worst.add(strategy.name(), trial.mean(&settings, truth.total()), 2e-6);
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(samples, "samples of 7 strategies under a map of five decades, in standard errors")
        .and(worst.nonfinite == 0, "samples are not finite")
        .and(worst.noise < 0.05, "too noisy to prove anything")
        .note(worst.what)
        .trace(worst.trace))
}

/// Maps without light are refused, constants without light are black, and a half that is black stays so.
fn black(effort: &Effort) -> Result<Outcome> {
    let spp = effort.samples(16, 4);
    let mut wrong = Vec::new();
    // A texel beyond the last: the scene's map is black.
    if Trial::new("texel", &[4.0, 4.0, 4.0, 0.0]).is_ok() {
        wrong.push("a black map was taken");
    }
    let constant = Trial::new("even_sky", &[1.0, 1.0, 0.0, 1.0])?;
    // The lower half shines: the floor, which faces up, is black.
    let below = Trial::new("texel", &[4.0, 3.0, 1.0, 0.0])?;
    for (what, trial) in [("a black constant shines", constant), ("light leaks through the horizon", below)] {
        for strategy in [Strategy::Bsdf, Strategy::Nee, Strategy::MisPower] {
            let settings = Settings { strategy, max_depth: Some(1), ..small(16, spp) };
            let render = trial.render(&settings);
            if render.stats.nonfinite > 0 || render.film.mean_radiance() != [0.0; 3] {
                wrong.push(what);
            }
        }
    }
    Ok(Outcome::at_most(wrong.len() as f64, 0.0)
        .tried(u64::from(spp) * 1536, "samples without light, cases that are not black")
        .note(wrong.join(", ")))
}

/// A map of any size that is the same everywhere lights a white floor to its own radiance, with no noise by light samples.
fn even_maps_are_constants(effort: &Effort) -> Result<Outcome> {
    let (spp, mut worst, mut samples) = (effort.samples(128, 32), Worst::default(), 0);
    for (columns, rows) in [(1.0, 1.0), (3.0, 2.0), (64.0, 32.0), (1.0, 16_384.0), (4096.0, 1.0)] {
        for radiance in [1e-30, 1.0, 1e30] {
            let trial = Trial::new("even_sky", &[columns, rows, radiance, 0.0])?;
            for strategy in [Strategy::Bsdf, Strategy::Nee, Strategy::MisBalance] {
                let settings = Settings { strategy, max_depth: Some(1), ..small(16, spp) };
                samples += u64::from(spp) * 256;
                let truth = f64::from(radiance as f32);
                let what = format!("{columns} x {rows}, radiance {radiance:e}, {strategy}");
                worst.add(&what, trial.mean(&settings, truth), 1e-5);
            }
        }
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(samples, "samples under even maps of radiance 1e-30 to 1e30, in standard errors")
        .and(worst.nonfinite == 0, "samples are not finite")
        .note(worst.what)
        .trace(worst.trace))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (
            TallRows,
            &[
                "environment/polar_row_of_256",
                "environment/polar_row_of_4096",
                "environment/polar_row_of_16384",
                "environment/one_texel",
                "environment/densities_integrate_to_one",
                "environment/total_power",
            ],
        ),
        (DensityTwice, &["environment/even_maps_are_constants", "environment/strategies_agree"]),
        (ShiftedLookup, &["environment/found_where_sampled", "environment/seams_and_poles"]),
        (BlackMapTaken, &["environment/black"]),
    ]
};
