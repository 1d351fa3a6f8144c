//! Stiff transport: long paths, pinholes, mirrors that face each other. Truths are geometric sums and Lambert's formula.

use crate::check::item::{Check, Effort};
use crate::check::lights::Lit;
use crate::check::row::Outcome;
use crate::check::trial::{Estimate, Mean, SIGMAS, Trial, Worst, small};
use crate::check::truth::{direct_light, geometric_sum};
use crate::check::twin::larger;
use crate::error::Result;
use crate::settings::{DEPTH_GUARD, Settings};
use crate::strategy::Strategy;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "transport", what: "depth_limits", run: depth_limits },
    Check { group: "transport", what: "white_walls_lose_nothing", run: white_walls_lose_nothing },
    Check { group: "transport", what: "albedo_.9_to_.999", run: albedo_to_999 },
    Check { group: "transport", what: "albedo_.9999", run: albedo_9999 },
    Check { group: "transport", what: "albedo_.99999", run: albedo_99999 },
    Check { group: "transport", what: "roulette_is_unbiased", run: roulette_is_unbiased },
    Check { group: "transport", what: "strategies_in_a_furnace", run: strategies_in_a_furnace },
    Check { group: "transport", what: "mirror_box", run: mirror_box },
    Check { group: "transport", what: "mirror_corridor", run: mirror_corridor },
    Check { group: "transport", what: "pinholes", run: pinholes },
];

/// Scenes at which the engines are compared.
pub const CASES: &[(&str, &[f64])] = &[
    ("furnace", &[0.9, 0.1]),
    ("furnace", &[0.999, 0.001]),
    ("mirror_box", &[0.99, 0.01]),
    ("mirror_corridor", &[1000.0, 0.999]),
    ("pinhole", &[1e-2, 1e-2]),
    ("pinhole", &[1e-5, 1e-5]),
];

/// An albedo as octray has it.
fn single(albedo: f64) -> f64 {
    f64::from(albedo as f32)
}

/// The relative error of paths that all find the very geometric sum: no noise, so the worst pixel counts.
fn worst_of_sum(trial: &Trial, settings: &Settings, truth: f64) -> f64 {
    let film = trial.render(settings).film;
    let off = |sum: f64| (sum / f64::from(film.spp) / truth - 1.0).abs();
    film.pixels.iter().map(|pixel| off(pixel.sum[0])).fold(0.0, larger)
}

/// What a render without light samples, noise and roulette comes to, worst over some (scene, numbers, events) of few samples.
fn sums(
    name: &str,
    cases: &[([f64; 2], Option<u32>)],
    (side, spp): (u32, u32),
    bound: f64,
    what: &str,
) -> Result<Outcome> {
    let (mut worst, mut at, mut events_in_all, mut trace) = (0.0, String::new(), 0, None);
    for &([albedo, emitted], max_depth) in cases {
        let trial = Trial::new(name, &[albedo, emitted])?;
        let settings = Settings { strategy: Strategy::Bsdf, max_depth, rr_depth: None, ..small(side, spp) };
        let events = max_depth.unwrap_or(DEPTH_GUARD);
        let truth = geometric_sum(single(emitted), single(albedo), events);
        let error = worst_of_sum(&trial, &settings, truth);
        events_in_all += u64::from(spp * side * side) * u64::from(events);
        if larger(worst, error) != worst || trace.is_none() {
            (worst, at) = (error, format!("worst at albedo {albedo}, {events} events"));
            trace = Some(trial.trace(&settings, (0, 0), 0));
        }
    }
    let trace = trace.filter(|_| cases.iter().all(|case| case.1.is_some_and(|depth| depth < 1000)));
    Ok(Outcome::at_most(worst, bound).tried(events_in_all, what).note(at).trace(trace))
}

fn depth_limits(effort: &Effort) -> Result<Outcome> {
    let cases: Vec<([f64; 2], Option<u32>)> = [0.0, 0.1, 0.5, 0.9, 0.99, 0.999]
        .into_iter()
        .flat_map(|albedo| [0, 1, 2, 3, 7, 20, 100].map(|depth| ([albedo, 0.1], Some(depth))))
        .collect();
    let what = "events at 6 albedos and 7 depth limits, relative error of the sum";
    sums("furnace", &cases, (8, effort.samples(8, 2)), 1e-5, what)
}

fn white_walls_lose_nothing(effort: &Effort) -> Result<Outcome> {
    let cases = [10, 1000, 30_000].map(|depth| ([1.0, 0.1], Some(depth)));
    let what = "events between white walls that shine, relative error of the sum";
    sums("furnace", &cases, (2, effort.samples(4, 1)), 1e-5, what)
}

/// Without roulette, to the end of the numbers.
fn albedo_to_999(effort: &Effort) -> Result<Outcome> {
    let cases = [([0.9, 0.1], None), ([0.99, 0.01], None), ([0.999, 0.001], Some(40_000))];
    let what = "events, roulette off, relative error of the sum";
    sums("furnace", &cases, (2, effort.samples(4, 1)), 1e-5, what)
}

fn albedo_9999(effort: &Effort) -> Result<Outcome> {
    let what = "events, roulette off, relative error of the sum";
    sums("furnace", &[([0.9999, 1e-4], Some(250_000))], (1, effort.samples(1, 1)), 1e-5, what)
}

/// To the depth guard.
fn albedo_99999(effort: &Effort) -> Result<Outcome> {
    let what = "events, roulette off, relative error of the sum up to the depth guard";
    sums("furnace", &[([0.99999, 1e-5], None)], (1, effort.samples(1, 1)), 1e-4, what)
}

fn roulette_is_unbiased(effort: &Effort) -> Result<Outcome> {
    let (mut worst, mut samples) = (Worst::default(), 0);
    for (albedo, usual) in [(0.9, 64), (0.99, 16), (0.999, 2)] {
        let trial = Trial::new("furnace", &[albedo, 1.0 - albedo])?;
        let truth = single(1.0 - albedo) / (1.0 - single(albedo));
        for rr_depth in [0, 1, 3, 10] {
            let spp = effort.samples(usual, 1);
            let settings = Settings { strategy: Strategy::Bsdf, rr_depth: Some(rr_depth), ..small(16, spp) };
            samples += u64::from(spp) * 256;
            let film = trial.render(&settings).film;
            // Of few samples a pixel, all pixels alike, the spread between pixels tells more.
            let means: Vec<f64> = film.pixels.iter().map(|pixel| pixel.sum[0] / f64::from(spp)).collect();
            let estimate = Estimate::of_values(&means);
            let mean = Mean { estimate, truth, nonfinite: 0, trace: trial.trace(&settings, (0, 0), 0) };
            worst.add(&format!("albedo {albedo}, roulette from {rr_depth}"), mean, 1e-4);
        }
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(samples, "samples at 3 albedos, .9 to .999, roulette from 4 depths, in standard errors")
        .note(format!("{}; noise to {:.0e}", worst.what, worst.noise)))
}

fn strategies_in_a_furnace(effort: &Effort) -> Result<Outcome> {
    let (mut worst, mut samples) = (Worst::default(), 0);
    let spp = effort.samples(16, 8);
    for (albedo, depth) in [(0.5, 1), (0.9, 2), (0.9, 20), (0.99, 60)] {
        let trial = Trial::new("furnace", &[albedo, 1.0 - albedo])?;
        let truth = geometric_sum(single(1.0 - albedo), single(albedo), depth);
        // Not those without weights: near the corners of a box that shines everywhere their light samples have no finite
        // variance.
        for strategy in [Strategy::Bsdf, Strategy::Uniform, Strategy::MisBalance, Strategy::MisPower] {
            for rr_depth in [None, Some(3)] {
                let settings = Settings { strategy, rr_depth, max_depth: Some(depth), ..small(16, spp) };
                // Uniform directions multiply weights of 0 to 2: of long paths nearly all come to nothing.
                if strategy == Strategy::Uniform && depth > 2 {
                    continue;
                }
                samples += u64::from(spp) * 256;
                worst.add(&format!("{strategy}, albedo {albedo}, depth {depth}"), trial.mean(&settings, truth), 1e-5);
            }
        }
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(samples, "samples of 4 strategies, with and without roulette, in standard errors")
        .note(worst.what)
        .trace(worst.trace))
}

fn mirror_box(effort: &Effort) -> Result<Outcome> {
    let cases = [
        ([0.5, 0.5], Some(50)),
        ([0.9, 0.1], Some(100)),
        ([0.99, 0.01], Some(2000)),
        ([0.999, 0.001], Some(20_000)),
        ([1.0, 0.1], Some(1000)),
    ];
    let what = "reflections in a box of mirrors that shine, relative error of the sum";
    sums("mirror_box", &cases, (3, effort.samples(2, 1)), 1e-5, what)
}

/// Rounding of the throughput is all that may differ from r^n: a reflection too many or too few would be 1e-3.
fn mirror_corridor(effort: &Effort) -> Result<Outcome> {
    let spp = effort.samples(16, 2);
    let (mut worst, mut reflections, mut at, mut trace) = (0.0, 0, String::new(), None);
    for count in [1u32, 10, 100, 1000, 2000] {
        let trial = Trial::new("mirror_corridor", &[f64::from(count), 0.999])?;
        let settings = Settings { rr_depth: None, ..small(4, spp) };
        let truth = single(0.999).powi(count as i32);
        let error = worst_of_sum(&trial, &settings, truth);
        reflections += u64::from(count * spp) * 16;
        if larger(worst, error) != worst || trace.is_none() {
            (worst, at) = (error, format!("worst of {count} reflections"));
            trace = Some(trial.trace(&settings, (0, 0), 0));
        }
    }
    Ok(Outcome::at_most(worst, 2e-4)
        .tried(reflections, "reflections, 1 to 2,000 a path, relative error of r^n")
        .note(at)
        .trace(trace))
}

/// Shadow rays through holes of 1e-1 to 1e-5, which show all of a lamp or a quarter of it.
fn pinholes(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(32, 16));
    for hole in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
        for lamp in [1.9 * hole, 4.0 * hole] {
            let trial = Trial::new("pinhole", &[hole, lamp])?;
            // As much of the lamp as is seen through the hole.
            let seen = crate::check::scenes::load(&format!("pinhole:{hole:e}:{:e}", lamp.min(2.0 * hole)))?;
            let truth = direct_light(&seen.desc).unwrap_or(f64::NAN);
            let strategies = &[Strategy::Nee, Strategy::MisBalance, Strategy::MisPower];
            lit.add_trial(&trial, strategies, small(16, spp), truth, 1e-3);
        }
    }
    Ok(lit.outcome("lamps seen through holes of 1e-1 to 1e-5"))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (
            LossySurfaces,
            &[
                "transport/depth_limits",
                "transport/white_walls_lose_nothing",
                "transport/albedo_.9_to_.999",
                "transport/albedo_.9999",
                "transport/albedo_.99999",
                "transport/strategies_in_a_furnace",
                "transport/mirror_box",
                "transport/mirror_corridor",
            ],
        ),
        (BiasedRoulette, &["transport/roulette_is_unbiased", "transport/strategies_in_a_furnace"]),
        (MissingCosine, &["transport/pinholes", "transport/strategies_in_a_furnace"]),
    ]
};
