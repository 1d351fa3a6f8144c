//! What both engines are told about one render: the prepared scene plus everything settings decide.

pub mod frame;
pub mod recipe;

use frame::Frame;

use crate::camera;
use crate::camera::Camera;
use crate::learn::outcome::Learning;
use crate::scene::desc::CameraDesc;
use crate::settings::{DEPTH_GUARD, PlanChoice, Roulette, Sampler, Settings, Shard};
use crate::strategy::Strategy;
use crate::tables::PreparedScene;
use crate::tables::guide::Guide;
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
    /// Which variants of its stages the packet engine runs.
    pub plan: PlanChoice,
    /// Scattering events a path may have.
    pub max_depth: u32,
    /// First depth at which roulette may end a path; `u32::MAX`: never.
    pub rr_depth: u32,
    /// What roulette goes by.
    pub roulette: Roulette,
    /// What was learned of the directions light comes from; only where directions are guided or roulette goes by it.
    pub guide: Option<Guide>,
    /// Where sample numbers come from.
    pub sampler: Sampler,
    /// Seed of all random numbers.
    pub seed: u32,
    /// The film and the part of it that is rendered.
    pub frame: Frame,
    /// Of that, the tiles; `None`: all.
    pub shard: Option<Shard>,
    /// Camera rays that leave the scene see nothing.
    pub hide_environment: bool,
    /// Layers show what is seen in mirrors and through glass.
    pub layers_through_specular: bool,
    /// What learning came to; `None`: nothing was to be learned, or has been yet.
    pub learning: Option<Learning>,
    /// What the user should know of these settings, one sentence each.
    pub warnings: Vec<String>,
}

/// A warning of lights that `strategy` never finds.
pub fn unseen(scene: &PreparedScene, strategy: Strategy) -> Option<String> {
    (!scene.is_seen_by(strategy)).then(|| {
        let count = scene.delta_lights.records.len();
        format!(
            "{strategy} does not see the {count} point, spot or directional light(s) of {}, which no ray can hit: choose a \
             strategy that samples lights, such as mis-power",
            scene.name
        )
    })
}

impl<'a> Setup<'a> {
    /// Resolves `settings` for `scene`. A crop is cut to the film. Nothing has been learned yet: see
    /// [`crate::render::pilot::resolve`].
    pub fn new(scene: &'a PreparedScene, settings: &Settings) -> Setup<'a> {
        Setup::seen_by(scene, settings, &scene.camera)
    }

    /// The same for another camera than the scene's.
    pub fn seen_by(scene: &'a PreparedScene, settings: &Settings, camera: &CameraDesc) -> Setup<'a> {
        let frame = Frame::nearest(settings, scene.film);
        let (width, height) = frame.film;
        // Only weights by density make up for what compensated light samples leave to the BSDF.
        let mut lights = LightTable::new(scene, settings.lights, settings.strategy.is_mis());
        if settings.plan.puts_back(PlanChoice::Lights) {
            lights.generalise(scene, settings.lights);
        }
        Setup {
            scene,
            lights,
            camera: Camera::new(camera, scene.filter, width, height),
            strategy: settings.strategy,
            plan: settings.plan,
            max_depth: settings.max_depth.unwrap_or(DEPTH_GUARD).min(DEPTH_GUARD),
            rr_depth: settings.rr_depth.unwrap_or(u32::MAX),
            // There is nothing yet that was learned.
            roulette: if settings.roulette == Roulette::Albedo { Roulette::Albedo } else { Roulette::Throughput },
            guide: None,
            sampler: settings.sampler,
            seed: settings.seed,
            frame,
            shard: settings.shard,
            hide_environment: settings.hide_environment,
            layers_through_specular: settings.layers_through_specular,
            learning: None,
            warnings: camera::warnings(camera, height).into_iter().chain(unseen(scene, settings.strategy)).collect(),
        }
    }

    /// Whether vertices draw light samples: the strategy asks for them and there is something to sample.
    pub fn samples_lights(&self) -> bool {
        self.strategy.samples_lights() && !self.lights.is_empty()
    }
}
