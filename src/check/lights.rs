//! Lights near, far, tiny, bright, many: the direct light of a place against Lambert's formula.

use crate::check::item::{Check, Effort, Level};
use crate::check::numbers::Numbers;
use crate::check::row::Outcome;
use crate::check::shots::corners;
use crate::check::trial::{Mean, SIGMAS, Trial, Worst, small};
use crate::check::truth::direct_light;
use crate::check::twin::larger;
use crate::error::{Error, Result};
use crate::reference::single::lights::choose::{Light, probability};
use crate::reference::single::lights::tree::Receiver;
use crate::settings::{Lights, Settings};
use crate::strategy::Strategy;
use crate::tables::PreparedScene;
use crate::tables::lights::table::LightTable;
use glam::DVec3;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "lights", what: "solid_angle_1e-12_to_2pi", run: solid_angle },
    Check { group: "lights", what: "distance_1e-6_to_1e6", run: distance },
    Check { group: "lights", what: "delta_1e-6_to_1e6", run: delta },
    Check { group: "lights", what: "touching_a_floor", run: touching_a_floor },
    Check { group: "lights", what: "touching_a_tilted_floor", run: touching_a_tilted_floor },
    Check { group: "lights", what: "edge_on", run: edge_on },
    Check { group: "lights", what: "in_the_plane_or_facing_away", run: in_the_plane_or_facing_away },
    Check { group: "lights", what: "coincident_lamps", run: coincident_lamps },
    Check { group: "lights", what: "in_a_walls_plane", run: in_a_walls_plane },
    Check { group: "lights", what: "needle_to_1e6", run: needle_to_1e6 },
    Check { group: "lights", what: "tilted_needle_to_1e4", run: tilted_needle_to_1e4 },
    Check { group: "lights", what: "needle_close_by", run: needle_close_by },
    Check { group: "lights", what: "radiance_1e-30_to_1e30", run: radiance },
    Check { group: "lights", what: "radiance_beyond_1e30_is_refused", run: radiance_beyond },
    Check { group: "lights", what: "1e12_apart", run: apart },
    Check { group: "lights", what: "1_to_1e5_lamps", run: lamps },
    Check { group: "lights", what: "probabilities_sum_to_one", run: probabilities_sum_to_one },
];

/// Scenes at which the engines are compared.
pub const CASES: &[(&str, &[f64])] = &[
    ("lamp", &[5e-7, 1.0, 1.0, 0.5, 0.1]),
    ("lamp", &[1.0, 1e-2, 1.0, 0.5, 0.0]),
    ("lamp", &[3e-7, 1e-6, 1.0, 0.5, 0.0]),
    ("lamp", &[3e5, 1e6, 1.0, 0.5, 0.0]),
    ("lamp", &[0.5, 1.0, 1e-30, 0.5, 0.0]),
    ("lamp", &[0.5, 1.0, 1e30, 0.5, 0.0]),
    ("delta", &[0.0, 1e-6, 0.0, 0.0, 1e-6]),
    ("delta", &[1.0, 1e6, 0.1, 0.5, 0.0]),
    ("delta", &[2.0, 1.0, 89.9, 0.0, 0.0]),
    ("touching", &[4e-5, 0.0]),
    ("touching", &[4e-3, 1.0]),
    ("edge_on", &[1e-6]),
    ("coplanar", &[0.0]),
    ("coplanar", &[1e-30]),
    ("coincident", &[0.0, 0.0]),
    ("coincident", &[1.0, 1.0]),
    ("coincident", &[2.0, 1.0]),
    ("coincident", &[3.0, 1.0]),
    ("needle", &[1.0, 1e-6, 1.0, 0.0]),
    ("needle", &[1.0, 1e-4, 1.0, 1.0]),
    ("apart", &[1e12]),
    ("lamps", &[30.0]),
];

/// Strategies whose samples meet lamps however small they are.
const AIMED: &[Strategy] = &[Strategy::Nee, Strategy::MisBalance, Strategy::MisPower];

/// Those, and such as need a lamp large enough to be hit.
const ALL_EXACT: &[Strategy] = &[
    Strategy::Nee,
    Strategy::NeeAverage,
    Strategy::MisOneSample,
    Strategy::MisBalance,
    Strategy::MisPower,
    Strategy::Bsdf,
    Strategy::Uniform,
];

/// Means of scenes held against Lambert's formula.
#[derive(Default)]
pub struct Lit {
    worst: Worst,
    samples: u64,
    scenes: u64,
}

impl Lit {
    /// Renders a scene by `strategies` with `spp` samples in each of 256 pixels; `slack` is the share of the truth that rounding
    /// may cost.
    pub fn add(&mut self, name: &str, numbers: &[f64], strategies: &[Strategy], spp: u32, slack: f64) -> Result<()> {
        self.add_by(name, numbers, strategies, Settings { spp, ..small(16, spp) }, slack)
    }

    /// [`Lit::add`] by other settings.
    pub fn add_by(
        &mut self,
        name: &str,
        numbers: &[f64],
        strategies: &[Strategy],
        settings: Settings,
        slack: f64,
    ) -> Result<()> {
        let trial = Trial::new(name, numbers)?;
        let truth = direct_light(&trial.scene.desc).unwrap_or(f64::NAN);
        self.add_trial(&trial, strategies, settings, truth, slack);
        Ok(())
    }

    /// [`Lit::add`] of a scene that is there, with its truth.
    pub fn add_trial(&mut self, trial: &Trial, strategies: &[Strategy], settings: Settings, truth: f64, slack: f64) {
        self.scenes += 1;
        for &strategy in strategies {
            let settings = Settings { strategy, max_depth: Some(1), ..settings.clone() };
            let mean = trial.mean(&settings, truth);
            self.samples += u64::from(settings.spp) * 256;
            self.take(&format!("{strategy}, {}", trial.prepared.name), mean, slack);
        }
    }

    fn take(&mut self, what: &str, mut mean: Mean, slack: f64) {
        // Where nothing should arrive, the least that does is infinitely many standard errors.
        if mean.truth == 0.0 && mean.estimate.mean != 0.0 {
            mean.estimate.error = 0.0;
        }
        self.worst.add(what, mean, slack);
    }

    /// The row.
    pub fn outcome(self, what: &str) -> Outcome {
        let Lit { worst, samples, scenes } = self;
        Outcome::at_most(worst.sigmas, SIGMAS)
            .tried(samples, format!("samples of {scenes} scenes, {what}, in standard errors"))
            .and(worst.nonfinite == 0, "samples are not finite")
            .note(worst.what)
            .trace(worst.trace)
    }
}

/// A square lamp a unit above the floor, and closer where it fills the hemisphere.
fn solid_angle(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for angle in [1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2] {
        lit.add("lamp", &[0.5 * f64::sqrt(angle), 1.0, 1.0, 0.5, 0.1], AIMED, spp, 1e-4)?;
    }
    for height in [1.0, 0.3, 0.1, 0.03, 0.01, 0.001] {
        // Off the lamp's diagonal: right below it light samples alone have a spread without bound.
        lit.add("lamp", &[1.0, height, 1.0, 0.5, 0.1], ALL_EXACT, spp, 1e-4)?;
    }
    Ok(lit.outcome("lamps of 1e-12 to 6.28 sr"))
}

/// The same lamp, as seen from the floor, at all distances.
fn distance(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for distance in [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6] {
        let strategies = &ALL_EXACT[..6];
        lit.add("lamp", &[0.4 * distance, distance, 1.0, 0.5, 0.1 * distance.min(10.0)], strategies, spp, 1e-4)?;
    }
    Ok(lit.outcome("lamps at 1e-6 to 1e6"))
}

/// Lights that no ray can hit, at all distances and of all cones, each place seen half-way to the edge; only strategies with light
/// samples see them.
fn delta(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    let strategies = &ALL_EXACT[..5];
    for height in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        lit.add("delta", &[0.0, height, 0.0, 0.0, 0.3 * height], strategies, spp, 1e-4)?;
        for (cone, fades) in [(0.1, 1.0), (1.0, 0.5), (30.0, 0.0), (60.0, 1.0), (180.0, 0.5)] {
            let x = (height * f64::tan((0.5 * f64::min(cone, 100.0)).to_radians())).min(10.0 * height);
            lit.add("delta", &[1.0, height, cone, fades, x], strategies, spp, 1e-4)?;
        }
    }
    for degrees in [0.0, 45.0, 89.9, 90.1] {
        lit.add("delta", &[2.0, 1.0, degrees, 0.0, 0.0], strategies, spp, 1e-4)?;
    }
    Ok(lit.outcome("point, spot and directional lights at 1e-6 to 1e6"))
}

/// A lamp of ten heights over a floor 4 wide, from 1e-2 to 1e-6 of it above.
fn touching_a_floor(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for height in [4e-2, 4e-3, 4e-4, 4e-5, 4e-6] {
        lit.add("touching", &[height, 0.0], ALL_EXACT, spp, 1e-4)?;
    }
    Ok(lit.outcome("lamps 1e-2 to 1e-6 of the floor above it"))
}

/// Tilted, corners are rounded to 1e-7 of the floor's size: what a lamp closer than 1e-3 of it gives is that of another place.
fn touching_a_tilted_floor(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for height in [4e-1, 4e-2, 4e-3] {
        lit.add("touching", &[height, 1.0], ALL_EXACT, spp, 1e-3)?;
    }
    Ok(lit.outcome("lamps 1e-1 to 1e-3 of the tilted floor above it"))
}

fn edge_on(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for angle in [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, -1e-5, -1e-2, -1.0] {
        lit.add("edge_on", &[angle], AIMED, spp, 1e-4)?;
    }
    Ok(lit.outcome("lamps seen 1 to 1e-5 off their plane, from before and behind"))
}

fn in_the_plane_or_facing_away(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for height in [0.0, 1e-30, -1e-30, 1e-3, 1.0] {
        lit.add("coplanar", &[height], ALL_EXACT, spp, 0.0)?;
    }
    Ok(lit.outcome("lamps that face up, level with the floor and above it"))
}

/// Of triangles in one place the first is there, by every strategy alike.
fn coincident_lamps(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    let one = Trial::new("coincident", &[3.0, 0.0])?;
    let truth = direct_light(&one.scene.desc).unwrap_or(f64::NAN);
    for (kind, first) in (0..4).flat_map(|kind| [(kind, 0), (kind, 1)]) {
        let trial = Trial::new("coincident", &[f64::from(kind), f64::from(first)])?;
        // A wall that comes first hides the lamp; a reversed lamp that does makes it shine on both sides.
        let hidden = kind == 3 && first == 1;
        lit.add_trial(&trial, ALL_EXACT, small(16, spp), if hidden { 0.0 } else { truth }, 1e-4);
    }
    Ok(lit.outcome("lamps in one place with a lamp or a wall"))
}

fn in_a_walls_plane(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(256, 64));
    for wall_first in [0.0, 1.0] {
        let truth = direct_light(&Trial::new("covered", &[wall_first, 1.0])?.scene.desc).unwrap_or(f64::NAN);
        lit.add_trial(&Trial::new("covered", &[wall_first, 0.0])?, ALL_EXACT, small(16, spp), truth, 1e-4);
    }
    Ok(lit.outcome("a lamp and a wall that overlap in one plane"))
}

fn needle_to_1e6(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for aspect in [1e2, 1e3, 1e4, 1e5, 1e6] {
        lit.add("needle", &[1.0, 1.0 / aspect, 1.0, 0.0], AIMED, spp, 1e-4)?;
    }
    Ok(lit.outcome("lamps of aspect 1e2 to 1e6"))
}

fn tilted_needle_to_1e4(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for aspect in [1e2, 1e3, 1e4] {
        lit.add("needle", &[1.0, 1.0 / aspect, 1.0, 1.0], AIMED, spp, 1e-4)?;
    }
    Ok(lit.outcome("tilted lamps of aspect 1e2 to 1e4"))
}

/// From ten and from two widths away a lamp of aspect 1,000 has to be in its place.
fn needle_close_by(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for (aspect, height) in [(1e2, 2e-2), (1e3, 1e-2), (1e3, 2e-3)] {
        for tilted in [0.0, 1.0] {
            lit.add("needle", &[1.0, 1.0 / aspect, height, tilted], ALL_EXACT, spp, 1e-3)?;
        }
    }
    Ok(lit.outcome("lamps of aspect 100 and 1,000 from 10 and 2 widths away"))
}

fn radiance(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for power in [-30, -20, -10, 0, 10, 20, 30] {
        lit.add("lamp", &[0.5, 1.0, 10f64.powi(power), 0.5, 0.1], ALL_EXACT, spp, 1e-4)?;
    }
    Ok(lit.outcome("lamps of radiance 1e-30 to 1e30"))
}

/// Radiances up to the largest f32 either work or end in an error that says so.
fn radiance_beyond(_: &Effort) -> Result<Outcome> {
    let (mut taken, mut cases) = (0, 0);
    for radiance in [1.01e30, 1e33, 1e37, 3e38] {
        for half in [0.5, 5.0] {
            cases += 1;
            match Trial::new("lamp", &[half, 0.5, radiance, 0.9, 0.1]) {
                Ok(_) => taken += 1,
                Err(Error::Scene { message, .. }) if message.contains("still works") => {}
                Err(error) => return Err(error),
            }
        }
    }
    Ok(Outcome::at_most(f64::from(taken), 0.0).tried(cases, "lamps of radiance 1.01e30 to 3e38, those taken"))
}

/// A lamp is drawn however much brighter another one is, and its stated probability is that with which it is drawn.
fn apart(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(64, 16));
    for factor in [1.0, 1e3, 1e6, 1e9, 1e12] {
        for lights in [Lights::Uniform, Lights::Power, Lights::Tree] {
            lit.add_by("apart", &[factor], AIMED, Settings { lights, ..small(16, spp) }, 1e-4)?;
        }
    }
    Ok(lit.outcome("a lamp beside one up to 1e12 times brighter"))
}

/// One square of lamps, cut into more and more of them.
fn lamps(effort: &Effort) -> Result<Outcome> {
    let (mut lit, spp) = (Lit::default(), effort.samples(16, 4));
    for side in [1.0, 3.0, 10.0, 32.0, 100.0, 317.0] {
        // Two triangles a lamp: the largest number takes a second to prepare.
        if side > 100.0 && effort.level == Level::Quick {
            continue;
        }
        let trial = Trial::new("lamps", &[side])?;
        let truth = direct_light(&trial.scene.desc).unwrap_or(f64::NAN);
        for lights in [Lights::Uniform, Lights::Power, Lights::Tree] {
            lit.add_trial(&trial, AIMED, Settings { lights, ..small(16, spp) }, truth, 1e-4);
        }
    }
    Ok(lit.outcome("1 to 1e5 lamps by 3 selections"))
}

/// The probabilities with which the lights of a scene are chosen, at so many random places of it, by every selection: how far
/// their sum is from 1 at most, and how many places were asked.
pub fn worst_sum_of_probabilities(scene: &PreparedScene, places: u64, seed: u32) -> (f64, u64) {
    let (mut numbers, mut worst, mut asked) = (Numbers::new(seed), 0.0, 0);
    for selection in [Lights::Uniform, Lights::Power, Lights::Tree] {
        let lights = LightTable::new(scene, selection, false);
        if lights.is_empty() {
            continue;
        }
        for _ in 0..places {
            let triangle = numbers.below(scene.triangles.len() as u32) as usize;
            let [a, b, c] = corners(scene, triangle);
            let (u, v) = (numbers.fine(), numbers.fine());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let height = numbers.magnitude(-6.0, 0.0) * (b - a).length();
            let normal = DVec3::from(scene.triangles[triangle].normal.map(f64::from));
            let origin = (a + (b - a) * u + (c - a) * v + normal * height).as_vec3();
            let receiver = Receiver { origin, normal: numbers.direction().as_vec3(), row: 0 };
            let of = |light: Light| f64::from(probability(&lights, &receiver, light));
            let mut sum = if lights.environment.is_some() { of(Light::Environment) } else { 0.0 };
            sum += (0..lights.records.len() as u32).map(|emitter| of(Light::Emitter(emitter))).sum::<f64>();
            // Where no lamp can send anything none need be chosen.
            let none = sum == 0.0 && selection == Lights::Tree;
            worst = larger(worst, if none { 0.0 } else { (sum - 1.0).abs() });
            asked += 1;
        }
    }
    (worst, asked)
}

fn probabilities_sum_to_one(effort: &Effort) -> Result<Outcome> {
    let (mut worst, mut asked) = (0.0, 0);
    let cases: [(&str, &[f64]); 5] = [
        ("lamps", &[1.0]),
        ("lamps", &[30.0]),
        ("apart", &[1e12]),
        ("coincident", &[2.0, 0.0]),
        ("lamp", &[1.0, 1e-3, 1.0, 0.5, 0.0]),
    ];
    for (seed, (name, numbers)) in cases.into_iter().enumerate() {
        let trial = Trial::new(name, numbers)?;
        let (sum, places) = worst_sum_of_probabilities(&trial.prepared, effort.cases(400), seed as u32);
        (worst, asked) = (larger(worst, sum), asked + places);
    }
    Ok(Outcome::at_most(worst, 1e-5)
        .tried(asked, "places among 1 to 1,800 lamps by 3 selections, sum of probabilities"))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (
            MissingCosine,
            &[
                "lights/touching_a_floor",
                "lights/touching_a_tilted_floor",
                "lights/coincident_lamps",
                "lights/in_a_walls_plane",
                "lights/needle_to_1e6",
                "lights/tilted_needle_to_1e4",
                "lights/needle_close_by",
                "lights/1e12_apart",
                "lights/1_to_1e5_lamps",
                "lights/edge_on",
            ],
        ),
        (AbsoluteEpsilon, &["lights/solid_angle_1e-12_to_2pi", "lights/distance_1e-6_to_1e6"]),
        (BothSidesShine, &["lights/in_the_plane_or_facing_away"]),
        (InfiniteRadiance, &["lights/radiance_1e-30_to_1e30"]),
        (SilentLimits, &["lights/radiance_beyond_1e30_is_refused"]),
        (LopsidedChoice, &["lights/probabilities_sum_to_one", "lights/1e12_apart", "lights/delta_1e-6_to_1e6"]),
    ]
};
