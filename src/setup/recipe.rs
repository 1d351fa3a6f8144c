//! A render's identity: all that decides the bits of its image but for the scene's content and the number of samples, as
//! named text, written once. Checkpoints, references of reports and image headers take it from here.

use super::frame::Frame;
use crate::settings::{Crop, Settings};

/// The name and value of everything that two renders must have in common to be parts of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe(pub Vec<(String, String)>);

impl Recipe {
    /// That of a render of the scene named `scene`.
    pub fn new(scene: &str, settings: &Settings, frame: &Frame) -> Recipe {
        let depth = |depth: Option<u32>, none: &str| depth.map_or(none.to_string(), |depth| depth.to_string());
        // Where nothing is learned the length of the training changes no bit.
        let (width, height) = frame.film;
        let Crop { x, y, width: w, height: h } = frame.crop;
        let pairs = [
            ("software", concat!("octray ", env!("CARGO_PKG_VERSION")).to_string()),
            ("scene", scene.to_string()),
            ("strategy", settings.strategy.to_string()),
            ("lights", settings.lights.to_string()),
            ("guide", settings.guide.to_string()),
            ("roulette", settings.roulette.to_string()),
            ("train", if settings.learns() { settings.train.to_string() } else { "nothing".into() }),
            ("sampler", settings.sampler.to_string()),
            ("seed", settings.seed.to_string()),
            ("max_depth", depth(settings.max_depth, "unbounded")),
            ("rr_depth", depth(settings.rr_depth, "off")),
            ("environment", if settings.hide_environment { "hidden" } else { "seen" }.to_string()),
            ("film", format!("{width} x {height}")),
            ("crop", format!("{x},{y},{w},{h}")),
        ];
        Recipe(pairs.map(|(name, value)| (name.to_string(), value)).to_vec())
    }

    /// The recipe with one more pair.
    pub fn and(mut self, name: &str, value: String) -> Recipe {
        self.0.push((name.to_string(), value));
        self
    }

    /// All of it in one line.
    pub fn line(&self) -> String {
        self.0.iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
    }
}
