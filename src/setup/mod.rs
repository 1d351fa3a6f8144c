//! What both engines are told about one render: the prepared scene plus everything settings decide.

use crate::camera::Camera;
use crate::settings::{Crop, DEPTH_GUARD, MAX_FILM_SIDE, Sampler, Settings};
use crate::strategy::Strategy;
use crate::tables::PreparedScene;
use crate::tables::lights::table::LightTable;

/// One render, resolved: no option left open.
pub struct Setup<'a> {
    /// The scene's tables.
    pub scene: &'a PreparedScene,
    /// Its lights under the chosen selection.
    pub lights: LightTable<'a>,
    /// The camera for this film.
    pub camera: Camera,
    /// How direct light is estimated.
    pub strategy: Strategy,
    /// Scattering events a path may have.
    pub max_depth: u32,
    /// First depth at which roulette may end a path; `u32::MAX`: never.
    pub rr_depth: u32,
    /// Where sample numbers come from.
    pub sampler: Sampler,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Size of the whole film (width, height).
    pub film: (u32, u32),
    /// The part that is rendered.
    pub crop: Crop,
}

impl<'a> Setup<'a> {
    /// Resolves `settings` for `scene`. A crop is cut to the film.
    pub fn new(scene: &'a PreparedScene, settings: &Settings) -> Setup<'a> {
        let width = settings.width.unwrap_or(scene.film.0).clamp(1, MAX_FILM_SIDE);
        let height = settings.height.unwrap_or(scene.film.1).clamp(1, MAX_FILM_SIDE);
        let crop = settings.crop.unwrap_or(Crop { x: 0, y: 0, width, height });
        let (x, y) = (crop.x.min(width - 1), crop.y.min(height - 1));
        let crop = Crop { x, y, width: crop.width.clamp(1, width - x), height: crop.height.clamp(1, height - y) };
        Setup {
            scene,
            // Only weights by density make up for what compensated light samples leave to the BSDF.
            lights: LightTable::new(scene, settings.lights, settings.strategy.is_mis()),
            camera: Camera::new(&scene.camera, scene.filter, width, height),
            strategy: settings.strategy,
            max_depth: settings.max_depth.unwrap_or(DEPTH_GUARD).min(DEPTH_GUARD),
            rr_depth: settings.rr_depth.unwrap_or(u32::MAX),
            sampler: settings.sampler,
            seed: settings.seed,
            film: (width, height),
            crop,
        }
    }

    /// Whether vertices draw light samples: the strategy asks for them and there is something to sample.
    pub fn samples_lights(&self) -> bool {
        self.strategy.samples_lights() && !self.lights.is_empty()
    }
}
