//! Sequences of frames: a camera that moves through a scene that stands still, and learning that is shared between frames.
//!
//! What is learned is a property of places and directions in the world, so it outlives the view that it was learned from
//! (Dittebrandt, Hanika and Dachsbacher, "Temporal Sample Reuse for Next Event Estimation and Path Guiding for Real-Time Path
//! Tracing", EGSR 2020). Each frame has a pilot of its own, a fraction of an image's, that starts from nothing; what a frame is
//! rendered with is made of the records of its own pilot and of those of the frames before it, [`TRAIN_FRAMES`] in all. So a
//! frame is the same, bit for bit, whether it is rendered after those before it or by itself, which only takes longer: the
//! pilots of the frames before it are then made for it alone. Before the first frame, the camera stands where its path begins.
//!
//! Records are kept as they were found, at the finest cells: sums of integers have no order, and leaves are cut from the sum.
//! Nothing of them is ever weighed down by age, since nothing moves but the camera.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use crate::clock::Stopwatch;
use crate::error::Result;
use crate::film::Film;
use crate::learn::guide::pixels::inverse_pixels;
use crate::learn::guide::records::{Outcomes, SQUARE_UNIT};
use crate::learn::guide::training::Training;
use crate::learn::guide::window;
use crate::learn::outcome::{GuideLearning, Learning};
use crate::learn::patches::{PatchRecord, forecast_of_others};
use crate::learn::pilot::frame_grid;
use crate::learn::records::{LightRecords, NodeRecord};
use crate::render::pilot::{Pilot, Stop, Wanted, bytes, guides, judge_lights, new_tables, roulette, why};
use crate::render::watch::Watch;
use crate::render::{Progress, Render, asked_to_stop, expect, render_trained, train_and_render};
use crate::scene::camera::CameraPath;
use crate::scene::desc::CameraDesc;
use crate::settings::{Lights, Roulette, Settings};
use crate::setup::Setup;
use crate::tables::PreparedScene;
use crate::tables::guide::Guide;

/// Frames whose pilots add up, unless asked otherwise. (16 are a tenth less efficient in `builtin:rooms`, 64 as much more.)
pub const TRAIN_FRAMES: u32 = 32;
/// Most frames that may.
pub const MOST_TRAIN_FRAMES: u32 = 1024;

/// The seed of a frame of a sequence that begins with `seed`: every frame has noise of its own.
pub fn seed_of(seed: u32, frame: i64) -> u32 {
    // The golden ratio of 2^32: an odd step, so that no two frames share a seed, and far from those of neighbouring seeds.
    seed.wrapping_add((frame as u32).wrapping_mul(0x9e37_79b9))
}

/// A sequence of frames of a scene. Keeps what the last pilots have recorded.
pub struct Sequence<'a> {
    scene: &'a PreparedScene,
    path: CameraPath,
    fps: f64,
    train_frames: u32,
    /// By frame, what its pilot has recorded; all for the settings that `made_for` has.
    pilots: BTreeMap<i64, FramePilot>,
    made_for: String,
}

/// What the pilot of a frame has recorded.
struct FramePilot {
    lights: Vec<NodeRecord>,
    patches: Vec<PatchRecord>,
    outcomes: Outcomes,
    /// As [`crate::learn::guide::records::GuideRecords::indirect`].
    indirect: u64,
    /// One over what the pixels of its grid are expected to show.
    inverse: Vec<f32>,
}

impl<'a> Sequence<'a> {
    /// The sequence of `scene` seen along `path`, `fps` frames a second; by the scene's own camera if that has no keys. What
    /// each frame learns is learned from `train_frames` frames, itself included (at most [`MOST_TRAIN_FRAMES`]); 1: every frame
    /// trains by itself, as long as an image does, as it does in any case under [`Lights::NeePlusPlus`].
    pub fn new(scene: &'a PreparedScene, path: CameraPath, fps: f64, train_frames: u32) -> Sequence<'a> {
        let train_frames = train_frames.clamp(1, MOST_TRAIN_FRAMES);
        Sequence { scene, path, fps, train_frames, pilots: BTreeMap::new(), made_for: String::new() }
    }

    /// The camera of a frame.
    pub fn camera(&self, frame: i64) -> CameraDesc {
        self.path.at_frame(frame, self.fps).unwrap_or(self.scene.camera)
    }

    /// The cameras of all frames whose pilots a frame learns from, its own last.
    pub fn cameras(&self, frame: u32) -> Vec<CameraDesc> {
        self.window(frame).map(|frame| self.camera(frame)).collect()
    }

    /// Renders a frame. The seed of `settings` is that of the sequence: each frame has one of its own, made of it. `start` and
    /// `progress` as in [`crate::render_from`].
    pub fn render(
        &mut self,
        frame: u32,
        settings: &Settings,
        start: Option<Film>,
        progress: &(dyn Fn(Progress) -> bool + Sync),
    ) -> Render {
        expect(self.try_render(frame, settings, start, &progress))
    }

    /// [`Sequence::render`]; `watch` as in [`crate::try_render_from`].
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if there is not enough.
    pub fn try_render(
        &mut self,
        frame: u32,
        settings: &Settings,
        start: Option<Film>,
        watch: &dyn Watch,
    ) -> Result<Render> {
        let camera = self.camera(i64::from(frame));
        let own = Settings { seed: seed_of(settings.seed, i64::from(frame)), ..settings.clone() };
        let preparing = Stopwatch::start();
        let mut setup = Setup::seen_by(self.scene, &own, &camera);
        let setup_s = preparing.wall_seconds();
        // A map of visibility is made of one pilot's records: each frame makes its own.
        if self.train_frames == 1 || settings.lights == Lights::NeePlusPlus {
            return train_and_render(setup, &own, start, watch, setup_s);
        }
        let clock = Stopwatch::start();
        let stop = AtomicBool::new(false);
        if settings.learns() {
            let asked = || asked_to_stop(watch, &stop, start.as_ref(), &own, &clock);
            let mut learning = self.learn(&mut setup, settings, frame, &asked);
            (learning.seconds, learning.cpu_seconds) = (clock.wall_seconds(), clock.cpu_seconds());
            setup.learning = Some(learning);
        }
        render_trained(&setup, &own, start, (watch, &stop), (setup_s, clock))
    }

    /// The frames whose pilots a frame learns from.
    fn window(&self, frame: u32) -> std::ops::RangeInclusive<i64> {
        let last = i64::from(frame);
        last - i64::from(self.train_frames - 1)..=last
    }

    /// Gives `setup`, which is that of `frame`, what the frames up to it have learned.
    fn learn(&mut self, setup: &mut Setup<'a>, settings: &Settings, frame: u32, stop: Stop) -> Learning {
        let wanted = Wanted::new(setup, settings);
        let (grid, spp) = match frame_grid(settings.train, setup.frame.film, self.train_frames) {
            Some(grid) if !wanted.is_nothing() => grid,
            _ => return wanted.learning,
        };
        self.forget_others(setup, settings, frame);
        for frame in self.window(frame) {
            if !self.pilots.contains_key(&frame) {
                let pilot = self.pilot(&wanted, settings, frame, (grid, spp), stop);
                // One that was stopped lacks paths, and is not to be taken for whole by the next frame.
                if stop() {
                    return wanted.learning;
                }
                self.pilots.insert(frame, pilot);
            }
        }
        let pilots = || self.pilots.values();
        let paths = u64::from(grid.0) * u64::from(grid.1) * u64::from(spp) * self.pilots.len() as u64;
        new_tables(setup, &wanted);
        let Wanted { guides: directions, mut learning, .. } = wanted;
        (learning.grid, learning.paths, learning.frames) = (Some(grid), paths, self.train_frames);
        if let Some(learned) = &mut setup.lights.learned {
            // Whether patches of the environment pay: what one half of the frames has learned is tried on the other.
            let mut halves = [0, 1].map(|_| LightRecords::new(learned));
            for (frame, pilot) in &self.pilots {
                let half = &mut halves[(frame & 1) as usize];
                pilot.lights.iter().for_each(|node| half.add(node));
                pilot.patches.iter().for_each(|record| half.patches.add(record));
            }
            let [mut records, mut odd] = halves;
            learned.learn(&records);
            let of_patches = forecast_of_others(learned, &odd.patches);
            records.take(&mut odd);
            learned.learn(&records);
            judge_lights(setup, (&records, of_patches), &mut learning);
        }
        if directions {
            let indirect =
                pilots().map(|pilot| pilot.indirect as f64 / f64::from(SQUARE_UNIT)).sum::<f64>() / paths as f64;
            let guides = guides(setup, settings, indirect);
            let used = guides || settings.roulette == Roulette::Learned;
            let mut outcome = GuideLearning {
                used,
                guides,
                indirect: Some(indirect),
                ..GuideLearning::none(&why(settings.guide, setup.strategy.is_mis(), indirect))
            };
            if used {
                let mut guide = Guide::new(self.scene, grid);
                let half = |odd: i64| self.pilots.iter().filter(move |(frame, _)| **frame & 1 == odd);
                let [even, odd] = [0, 1].map(|odd| half(odd).map(|(_, pilot)| &pilot.outcomes).collect::<Vec<_>>());
                (outcome.leaves, outcome.guided) = window::fill(&mut guide, [&even, &odd], paths, guides);
                if let Some((_, own)) = self.pilots.last_key_value() {
                    guide.pixels.inverse.clone_from(&own.inverse);
                }
                guide.pixels.spread(grid, setup.frame.film);
                outcome.bytes = bytes(&guide.tables());
                setup.roulette = roulette(setup, settings);
                setup.guide = Some(guide);
            }
            learning.guide = Some(outcome);
        }
        learning
    }

    /// Drops the pilots that a frame does not learn from, and all if they were made for something else.
    fn forget_others(&mut self, setup: &Setup, settings: &Settings, frame: u32) {
        // Nothing else has any say in what a pilot records.
        let Settings { strategy, lights, guide, roulette, train, sampler, max_depth, rr_depth, seed, .. } = settings;
        let learned = (lights, guide, roulette, train, settings.hide_environment);
        let made_for =
            format!("{strategy} {learned:?} {sampler} {max_depth:?} {rr_depth:?} {seed} {:?}", setup.frame.film);
        if made_for != self.made_for {
            self.pilots.clear();
            self.made_for = made_for;
        }
        let window = self.window(frame);
        self.pilots.retain(|frame, _| window.contains(frame));
    }

    /// The pilot of one frame: paths that nothing was learned for.
    fn pilot(
        &self,
        wanted: &Wanted,
        settings: &Settings,
        frame: i64,
        (grid, spp): ((u32, u32), u32),
        stop: Stop,
    ) -> FramePilot {
        let own = Settings { seed: seed_of(settings.seed, frame), ..settings.clone() };
        let mut setup = Setup::seen_by(self.scene, &own, &self.camera(frame));
        let mut pilot = Pilot::new(&mut setup, &own, grid, wanted, stop);
        pilot.training = wanted.guides.then(|| Training::one_by_one(grid));
        pilot.run(spp);
        let records = pilot.lights.take().unwrap_or_default();
        let (lights, patches) = (records.sorted(), records.patches.into_sorted());
        let records = pilot.training.take().map(Training::into_records).unwrap_or_default();
        let mut outcomes = records.outcomes.unwrap_or_default();
        let inverse = if wanted.guides { inverse_pixels(&records.image, grid, spp) } else { Vec::new() };
        let indirect = outcomes.indirect(&inverse);
        outcomes.gains = Vec::new();
        FramePilot { lights, patches, outcomes, indirect, inverse }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_has_its_seed() {
        let seeds: std::collections::HashSet<u32> = (-500..500).map(|frame| seed_of(7, frame)).collect();
        assert_eq!((seeds.len(), seed_of(7, 0)), (1000, 7));
    }
}
