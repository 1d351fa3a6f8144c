//! The library's way in: load a scene, prepare it, ask its triangles about rays.

use std::path::Path;
use std::time::Instant;

use crate::bvh::{HitPacket, HitQueue, RayPacket, RayQueue};
use crate::error::Result;
use crate::lanes::Mask8;
use crate::scene::desc::SceneDesc;
use crate::settings::Settings;
use crate::tables::prepared::PreparedScene;

/// A scene as its files say it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What the files say; may be changed before [`Scene::prepare`].
    pub desc: SceneDesc,
    load_s: f64,
}

impl Scene {
    /// Loads a `.toml` scene file, a bare `.obj`, or `builtin:NAME`.
    ///
    /// # Errors
    /// [`crate::Error::Read`] and [`crate::Error::Parse`] name the file, the line and what to do.
    pub fn load(path: impl AsRef<Path>) -> Result<Scene> {
        let start = Instant::now();
        let desc = SceneDesc::load(path)?;
        Ok(Scene { desc, load_s: start.elapsed().as_secs_f64() })
    }

    /// Loads an OBJ with a framed camera, whatever its name ends in.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_obj(path: impl AsRef<Path>) -> Result<Scene> {
        let start = Instant::now();
        let desc = SceneDesc::from_obj(path)?;
        Ok(Scene { desc, load_s: start.elapsed().as_secs_f64() })
    }

    /// The default settings with what the scene file's `[render]` says.
    pub fn settings(&self) -> Settings {
        let (file, default) = (&self.desc.render, Settings::default());
        Settings {
            spp: file.spp.unwrap_or(default.spp),
            strategy: file.strategy.unwrap_or(default.strategy),
            lights: file.lights.unwrap_or(default.lights),
            guide: file.guide.unwrap_or(default.guide),
            roulette: file.roulette.unwrap_or(default.roulette),
            train: file.train.unwrap_or(default.train),
            sampler: file.sampler.unwrap_or(default.sampler),
            max_depth: file.max_depth.or(default.max_depth),
            rr_depth: file.rr_depth.unwrap_or(default.rr_depth),
            seed: file.seed.unwrap_or(default.seed),
            ..default
        }
    }

    /// Derives every table and builds the BVH.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] if the description breaks a rule of [`crate::scene::validate`], or if the scene is too
    /// large or too small for f32 ([`crate::tables::scale_limits`]).
    pub fn prepare(&self) -> Result<PreparedScene> {
        let mut prepared = PreparedScene::new(&self.desc)?;
        prepared.load_s = self.load_s;
        Ok(prepared)
    }
}

impl From<SceneDesc> for Scene {
    /// A scene made in code.
    fn from(desc: SceneDesc) -> Scene {
        Scene { desc, load_s: 0.0 }
    }
}

/// Rays by themselves: for throughput measurements and other people's ray sets. Triangle ids count triangles in file order
/// after triangulation. Triangles count whole here, cut out or not.
impl PreparedScene {
    /// The closest hits of the active rays; idle lanes may hold anything and come back without a hit.
    pub fn intersect(&self, rays: &RayPacket, active: Mask8) -> HitPacket {
        self.bvh.intersect(rays, active)
    }

    /// Which of the active rays hit anything.
    pub fn occluded(&self, rays: &RayPacket, active: Mask8) -> Mask8 {
        self.bvh.occluded(rays, active)
    }

    /// The closest hits of all of `rays` (its padding included), row by row; `hits` grows as needed.
    pub fn intersect_stream(&self, rays: &RayQueue, hits: &mut HitQueue) {
        self.bvh.intersect_stream(rays, rays.len(), hits);
    }

    /// Which of `rays` hit anything: bit `i % 8` of byte `i / 8`; `blocked` grows as needed.
    pub fn occluded_stream(&self, rays: &RayQueue, blocked: &mut Vec<u8>) {
        self.bvh.occluded_stream(rays, rays.len(), blocked);
    }
}
