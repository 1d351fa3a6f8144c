//! Flags that several commands share, and how their values are read. Precedence: flag, scene's `[render]`, default.

use crate::settings::{Crop, Guide, Lights, MAX_FILM_SIDE, PlanChoice, Roulette, Sampler, Settings, Train};
use crate::strategy::Strategy;
use clap::Args;
use std::fmt::Display;
use std::str::FromStr;
use std::time::Duration;

/// What is estimated, and how.
#[derive(Args, Default)]
pub struct EstimatorArgs {
    #[arg(long, value_name = "S", help = strategy_help(), value_parser = |text: &str| named::<Strategy>(text, &[]))]
    strategy: Option<Strategy>,
    #[arg(long, value_name = "L", help = lights_help(), value_parser = |text: &str| named::<Lights>(text, &[]))]
    lights: Option<Lights>,
    #[arg(long, value_name = "G", help = guide_help(), value_parser = |text: &str| named::<Guide>(text, &[]))]
    guide: Option<Guide>,
    #[arg(long, value_name = "R", help = roulette_help(), value_parser = |text: &str| named::<Roulette>(text, &[]))]
    roulette: Option<Roulette>,
    #[arg(long, value_name = "PATHS|auto|off", help = train_help(), value_parser = |text: &str| text.parse::<Train>(),
          allow_negative_numbers = true)]
    train: Option<Train>,
    #[arg(long, value_name = "S", help = sampler_help(), value_parser = |text: &str| named::<Sampler>(text, &[]))]
    sampler: Option<Sampler>,
    #[arg(long, value_name = "N", help = max_depth_help(), allow_negative_numbers = true)]
    max_depth: Option<u32>,
    #[arg(long, value_name = "D|off", help = rr_depth_help(), value_parser = rr_depth, allow_negative_numbers = true)]
    rr_depth: Option<RrDepth>,
    #[arg(long, value_name = "N", help = seed_help(), allow_negative_numbers = true)]
    seed: Option<u32>,
}

impl EstimatorArgs {
    /// `--max-depth`, if it is given.
    pub fn max_depth(&self) -> Option<u32> {
        self.max_depth
    }

    /// Puts the given flags over `settings`.
    pub fn apply(&self, settings: &mut Settings) {
        settings.strategy = self.strategy.unwrap_or(settings.strategy);
        settings.lights = self.lights.unwrap_or(settings.lights);
        settings.guide = self.guide.unwrap_or(settings.guide);
        settings.roulette = self.roulette.unwrap_or(settings.roulette);
        settings.train = self.train.unwrap_or(settings.train);
        settings.sampler = self.sampler.unwrap_or(settings.sampler);
        settings.max_depth = self.max_depth.or(settings.max_depth);
        settings.rr_depth = self.rr_depth.map_or(settings.rr_depth, |RrDepth(depth)| depth);
        settings.seed = self.seed.unwrap_or(settings.seed);
    }
}

/// Which variants of its stages the packet engine runs.
#[derive(Args)]
pub struct PlanArgs {
    #[arg(long, value_name = "P", help = plan_help(), default_value_t = PlanChoice::Scene, hide_default_value = true,
          value_parser = |text: &str| named::<PlanChoice>(text, &[]))]
    pub plan: PlanChoice,
}

/// The size of the film.
#[derive(Args, Default)]
pub struct FilmArgs {
    /// Film width in pixels [default: the scene's]
    #[arg(long, value_name = "W", value_parser = side, allow_negative_numbers = true)]
    width: Option<u32>,
    /// Film height in pixels [default: the scene's]
    #[arg(long, value_name = "H", value_parser = side, allow_negative_numbers = true)]
    height: Option<u32>,
}

impl FilmArgs {
    /// Puts the given flags over `settings`.
    pub fn apply(&self, settings: &mut Settings) {
        settings.width = self.width.or(settings.width);
        settings.height = self.height.or(settings.height);
    }
}

// Help texts name choices and defaults as the settings have them, so that they cannot say anything else. A default is text
// alone: were it a value of the flag, it would go over what the scene file says.

/// The names of `all`, with commas between them.
fn names(all: &[impl Display]) -> String {
    all.iter().map(|choice| choice.to_string()).collect::<Vec<_>>().join(", ")
}

/// What is taken where the flag is not given.
fn scene_else(default: impl Display) -> String {
    format!("[default: the scene's, else {default}]")
}

fn strategy_help() -> String {
    let name = |strategy: &Strategy| format!("{strategy}{}", if strategy.is_biased() { " (biased)" } else { "" });
    let all = names(&Strategy::ALL.iter().map(name).collect::<Vec<_>>());
    format!("How direct light is estimated: {all} {}", scene_else(Settings::default().strategy))
}

fn lights_help() -> String {
    format!("How a light sample chooses its light: {} {}", names(Lights::ALL), scene_else(Settings::default().lights))
}

fn guide_help() -> String {
    let default = Settings::default().guide;
    format!("Whether directions at diffuse surfaces are guided: {} [default: {default}]", names(Guide::ALL))
}

fn roulette_help() -> String {
    format!("What roulette goes by: {} [default: {}]", names(Roulette::ALL), Settings::default().roulette)
}

/// Help of `--train`.
pub fn train_help() -> String {
    let default = Settings::default().train;
    format!(
        "Paths of the training render of --lights learned and nee-plus-plus, --guide and --roulette learned; `auto`: by the film's size [default: {default}]"
    )
}

fn plan_help() -> String {
    format!(
        "What stages hold besides what the scene needs, for measuring: scene (nothing), general (all that any scene needs) \
         or one part of that, {}; the bits are the same [default: {}]",
        names(PlanChoice::parts()),
        Settings::default().plan
    )
}

fn sampler_help() -> String {
    format!("Where sample numbers come from: {} {}", names(Sampler::ALL), scene_else(Settings::default().sampler))
}

/// Help of `--max-depth`.
pub fn max_depth_help() -> String {
    let default = Settings::default().max_depth.map_or("unbounded".to_owned(), |depth| depth.to_string());
    format!("Most scattering events of a path; 0 shows emission only {}", scene_else(default))
}

/// Help of `--rr-depth`.
pub fn rr_depth_help() -> String {
    let default = Settings::default().rr_depth.map_or("off".to_owned(), |depth| depth.to_string());
    format!("First depth at which Russian roulette may end a path, or `off` {}", scene_else(default))
}

fn seed_help() -> String {
    format!("Seed of all random numbers {}", scene_else(Settings::default().seed))
}

/// Help of a flag that takes a [`List`] of the choices in `all`; `default` is taken without it.
pub fn list_help(what: &str, all: &[impl Display], default: &str) -> String {
    format!("{what}, with commas between them, or `all`: {} [default: {default}]", names(all))
}

/// `--rr-depth`: `None` for `off`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RrDepth(pub Option<u32>);

/// A choice by name; names in `later` are known and not there yet.
pub fn named<T: FromStr<Err = String>>(text: &str, later: &[&str]) -> Result<T, String> {
    text.parse().map_err(|error| match later.contains(&text) {
        true => format!("`{text}` is not in this version yet; leave the flag out or choose another value"),
        false => error,
    })
}

/// `--rr-depth`.
pub fn rr_depth(text: &str) -> Result<RrDepth, String> {
    match text {
        "off" => Ok(RrDepth(None)),
        _ => text.parse().map(|depth| RrDepth(Some(depth))).map_err(|_| "give a depth from 0 on, or `off`".into()),
    }
}

/// Columns or rows of a film.
pub fn side(text: &str) -> Result<u32, String> {
    let valid = |side: &u32| (1..=MAX_FILM_SIDE).contains(side);
    text.parse().ok().filter(valid).ok_or_else(|| format!("give a number of pixels from 1 to {MAX_FILM_SIDE}"))
}

/// A whole number from 1 on.
pub fn positive(text: &str) -> Result<u32, String> {
    text.parse().ok().filter(|&n| n > 0).ok_or_else(|| format!("give a whole number from 1 to {}", u32::MAX))
}

/// What [`seconds`] refuses.
const TIME: &str = "give a number of seconds above 0, or a time with units, as 500ms, 10s, 1m30s, 2m or 1h";
/// Units of time and their seconds, the longest first; of one letter or two.
const UNITS: [(&str, f64); 4] = [("h", 3600.0), ("m", 60.0), ("s", 1.0), ("ms", 1e-3)];

/// A wall time, finite and above 0: seconds, or numbers with units, the longer unit first and each once (`1h30m`).
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.trim().parse::<f64>().ok().or_else(|| with_units(text));
    let duration = seconds.filter(|&s| s > 0.0).and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    duration.filter(|duration| !duration.is_zero()).ok_or_else(|| TIME.into())
}

/// The seconds of `1m30s`; blanks between the parts do not matter.
fn with_units(text: &str) -> Option<f64> {
    let (mut rest, mut sum, mut next) = (text.trim_start(), 0.0, 0);
    while !rest.is_empty() {
        let (number, after) = rest.split_at(rest.find(|c: char| !(c.is_ascii_digit() || c == '.'))?);
        let after = after.trim_start();
        let (unit, after) = after.split_at(after.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(after.len()));
        let at = UNITS.iter().position(|(name, _)| *name == unit).filter(|&at| at >= next)?;
        sum += number.parse::<f64>().ok()? * UNITS[at].1;
        (rest, next) = (after.trim_start(), at + 1);
    }
    Some(sum)
}

/// A number of bytes: with the unit K, M, G or T (powers of 1000), or with none.
pub fn bytes(text: &str) -> Result<u64, String> {
    const UNITS: [(char, f64); 4] = [('K', 1e3), ('M', 1e6), ('G', 1e9), ('T', 1e12)];
    let text = text.trim();
    let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
    let unit = UNITS.iter().find(|(name, _)| text.ends_with([*name, name.to_ascii_lowercase()]));
    let number = if unit.is_some() { &text[..text.len() - 1] } else { text };
    let bytes = number.trim().parse::<f64>().ok().map(|number| number * unit.map_or(1.0, |(_, size)| *size));
    let valid = |bytes: &f64| (1.0..1e18).contains(bytes);
    bytes.filter(valid).map(|bytes| bytes as u64).ok_or_else(|| "give bytes, as 8G, 500M or 1e9".to_owned())
}

/// Frames a second.
pub fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse::<f64>().ok().filter(|rate| *rate > 0.0 && rate.is_finite());
    rate.ok_or_else(|| "give a number of frames a second above 0".to_owned())
}

/// Exposure in stops, within what changes an 8-bit image.
pub fn exposure(text: &str) -> Result<f64, String> {
    let valid = |stops: &f64| (-200.0..=200.0).contains(stops);
    text.parse().ok().filter(valid).ok_or_else(|| "give a number of stops from -200 to 200".into())
}

/// `X,Y,W,H`.
pub fn crop(text: &str) -> Result<Crop, String> {
    match numbers(text)? {
        [x, y, width, height] if width > 0 && height > 0 => Ok(Crop { x, y, width, height }),
        _ => Err("W and H must be at least 1".into()),
    }
}

/// `[NAME=]X,Y,W,H`.
pub fn region(text: &str) -> Result<(String, Crop), String> {
    let (name, place) = text.rsplit_once('=').unwrap_or((text, text));
    match name.trim() {
        "" => Err("give the region a name before the `=`, or leave the `=` out".into()),
        name => Ok((name.to_owned(), crop(place)?)),
    }
}

/// `X,Y,Z`, finite.
pub fn place(text: &str) -> Result<[f64; 3], String> {
    let wanted = "give three numbers with commas between them, such as 0,1.5,-3";
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|x| (*x as f32).is_finite());
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| wanted.to_owned())
}

/// `X,Y`.
pub fn pixel(text: &str) -> Result<[u32; 2], String> {
    numbers(text)
}

/// Choices with commas between them, each once, or `all`.
#[derive(Clone, Debug, PartialEq)]
pub struct List<T>(pub Vec<T>);

/// Reads a [`List`] of the choices in `all`.
pub fn list<T: FromStr<Err = String> + Copy + PartialEq>(text: &str, all: &[T]) -> Result<List<T>, String> {
    if text.trim() == "all" {
        return Ok(List(all.to_vec()));
    }
    let mut chosen = Vec::new();
    for name in text.split(',') {
        let choice = name.trim().parse()?;
        if !chosen.contains(&choice) {
            chosen.push(choice);
        }
    }
    Ok(List(chosen))
}

fn numbers<const N: usize>(text: &str) -> Result<[u32; N], String> {
    let parsed: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let parsed = parsed.and_then(|numbers| numbers.try_into().ok());
    parsed.ok_or_else(|| format!("give {N} whole numbers with commas between them"))
}

/// A relative error: a share (`0.01`) or per cent (`1%`), above 0.
pub fn relative_error(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let error = number.trim().parse::<f64>().ok().map(|number| number * unit);
    let valid = |error: &f64| *error > 0.0 && error.is_finite();
    error.filter(valid).ok_or_else(|| "give an error above 0, as 0.01 or 1%".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_mean_nothing_are_refused() {
        for text in ["nan", "NaN", "inf", "-inf", "", "x", "1e999"] {
            assert!(seconds(text).is_err() && exposure(text).is_err(), "{text}");
        }
        for text in ["0", "-1", "1e-300", "1e30"] {
            assert!(seconds(text).is_err(), "{text}");
        }
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
        assert_eq!(exposure("-1.5"), Ok(-1.5));
        assert_eq!((relative_error("0.02"), relative_error("2 %")), (Ok(0.02), Ok(0.02)));
        for text in ["0", "-1", "nan", "inf", "%", "", "0%", "1 percent"] {
            assert!(relative_error(text).is_err(), "{text}");
        }
    }

    #[test]
    fn amounts_of_memory_have_units() {
        for (text, expected) in
            [("8G", 8_000_000_000), ("500m", 500_000_000), ("1.5 GB", 1_500_000_000), ("1e9", 1_000_000_000)]
        {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for text in ["", "G", "-1", "0", "nan", "inf", "1X", "8GG", "1e30", "\u{e4}"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn times_are_seconds_or_have_units() {
        for (text, milliseconds) in [
            ("10", 10_000),
            ("1e1", 10_000),
            ("10s", 10_000),
            ("2m", 120_000),
            ("1h", 3_600_000),
            ("500ms", 500),
            ("1m30s", 90_000),
            ("1h1m1s1ms", 3_661_001),
            ("1.5h", 5_400_000),
            (".5s", 500),
            ("1h 30m", 5_400_000),
            (" 10 s ", 10_000),
            ("0h5s", 5_000),
        ] {
            assert_eq!(seconds(text), Ok(Duration::from_millis(milliseconds)), "{text}");
        }
        let wrong = ["s", "10x", "10S", "1m30", "30s1m", "1s1s", "1ms1s", "-5s", "5s-", "0s", "0m0s", "1..5s", "1e3s"];
        for text in wrong.into_iter().chain(["10sec", "nans", "infs", "1m,30s", "m5", "1h-30m", "9e99h", "."]) {
            assert_eq!(seconds(text), Err(TIME.into()), "{text}");
        }
    }

    #[test]
    fn crops_and_pixels_take_exactly_their_numbers() {
        assert_eq!(crop("1,2, 3,4"), Ok(Crop { x: 1, y: 2, width: 3, height: 4 }));
        for text in ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "-1,2,3,4", "1.5,2,3,4", "1,2,3,99999999999"] {
            assert!(crop(text).is_err(), "{text}");
        }
        assert_eq!(pixel("7,9"), Ok([7, 9]));
        assert_eq!(place("1, -2.5,3e2"), Ok([1.0, -2.5, 300.0]));
        for text in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "1,2,nan", "1,2,1e39", "1 2 3"] {
            assert!(place(text).is_err(), "{text}");
        }
    }

    #[test]
    fn lists_hold_each_choice_once() {
        assert_eq!(list("all", Strategy::ALL), Ok(List(Strategy::ALL.to_vec())));
        let two = List(vec![Strategy::Nee, Strategy::Bsdf]);
        assert_eq!(list("nee, bsdf,nee", Strategy::ALL), Ok(two));
        for text in ["", "nee,", "nee,all", "magic"] {
            assert!(list(text, Strategy::ALL).unwrap_err().contains("known: uniform, bsdf"), "{text}");
        }
    }

    #[test]
    fn later_names_are_told_from_unknown_ones() {
        let error = named::<Lights>("treee", &[]).unwrap_err();
        assert_eq!(
            error,
            "unknown light selection `treee` (did you mean `tree`?); known: uniform, power, tree, learned, nee-plus-plus"
        );
        assert!(!named::<Lights>("magic", &[]).unwrap_err().contains("did you mean"));
        assert_eq!(named::<Lights>("tree", &[]), Ok(Lights::Tree));
        assert_eq!(rr_depth("off"), Ok(RrDepth(None)));
        assert!(rr_depth("-1").is_err());
    }

    #[test]
    fn regions_may_have_names() {
        let area = Crop { x: 1, y: 2, width: 3, height: 4 };
        assert_eq!(region("plate=1,2,3,4"), Ok(("plate".into(), area)));
        assert_eq!(region("1,2,3,4"), Ok(("1,2,3,4".into(), area)));
        for text in ["=1,2,3,4", "plate=", "plate=1,2,3", "plate=1,2,0,4"] {
            assert!(region(text).is_err(), "{text}");
        }
    }
}
