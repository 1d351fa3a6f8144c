//! Lanes used and possible, and seconds, per stage; rays by kind. Statistics only: nothing reads them to decide anything.

use std::time::Instant;

use crate::bvh::WalkCounters;
use crate::stats::{RayCounts, StageStats};
use crate::tables::materials::{KINDS, MaterialKind};

/// The stages, in the order in which a path meets them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Camera rays from film positions.
    GenerateCameraRays,
    /// Closest hits.
    IntersectClosest,
    /// Hits to queues, by what they hit.
    SortHits,
    /// Rays that left the scene.
    ShadeMiss,
    /// Hits on emitters.
    ShadeEmitter,
    /// Surfaces of one material kind.
    Shade(MaterialKind),
    /// Shadow rays.
    IntersectShadow,
    /// Radiance to the film.
    AddToFilm,
}

/// How many stages there are.
pub const STAGES: usize = 7 + KINDS;

impl Stage {
    /// Every stage.
    pub fn all() -> impl Iterator<Item = Stage> {
        use Stage::*;
        let first = [GenerateCameraRays, IntersectClosest, SortHits, ShadeMiss, ShadeEmitter];
        first.into_iter().chain(MaterialKind::ALL.map(Shade)).chain([IntersectShadow, AddToFilm])
    }

    /// The stage's place in [`Stage::all`].
    fn index(self) -> usize {
        match self {
            Stage::GenerateCameraRays => 0,
            Stage::IntersectClosest => 1,
            Stage::SortHits => 2,
            Stage::ShadeMiss => 3,
            Stage::ShadeEmitter => 4,
            Stage::Shade(kind) => 5 + kind as usize,
            Stage::IntersectShadow => 5 + KINDS,
            Stage::AddToFilm => 6 + KINDS,
        }
    }

    /// The name in plans and reports.
    pub fn name(self) -> &'static str {
        match self {
            Stage::GenerateCameraRays => "generate_camera_rays",
            Stage::IntersectClosest => "intersect_closest",
            Stage::SortHits => "sort_hits",
            Stage::ShadeMiss => "shade_miss",
            Stage::ShadeEmitter => "shade_emitter",
            Stage::Shade(kind) => kind.row().stage,
            Stage::IntersectShadow => "intersect_shadow",
            Stage::AddToFilm => "add_to_film",
        }
    }

    /// Whether the stage serves a scattering event, so that there is nothing for it to do after a path's last one.
    pub fn scatters(self) -> bool {
        matches!(self, Stage::Shade(_) | Stage::IntersectShadow)
    }
}

/// What one stage has done.
#[derive(Clone, Copy, Debug, Default)]
pub struct StageCount {
    /// Lanes that held work.
    pub used: u64,
    /// Lanes that could have.
    pub possible: u64,
    /// Wall seconds.
    pub seconds: f64,
    /// The stage ran at all.
    pub runs: u64,
}

/// One thread's counters.
#[derive(Clone, Debug, Default)]
pub struct Counters {
    /// Per [`Stage`].
    pub stages: [StageCount; STAGES],
    /// Rays by kind.
    pub rays: RayCounts,
    /// What the walks of closest hits through the tree counted.
    pub closest_walk: WalkCounters,
    /// What the walks of shadow rays counted.
    pub shadow_walk: WalkCounters,
    /// Camera paths.
    pub paths: u64,
    /// Paths cut by the depth guard.
    pub guarded: u64,
}

impl Counters {
    /// Notes one run of `stage` over `items` items in whole blocks of eight, begun at `since`; returns now.
    #[inline]
    pub fn note(&mut self, stage: Stage, items: usize, since: Instant) -> Instant {
        let now = Instant::now();
        let count = &mut self.stages[stage.index()];
        count.used += items as u64;
        count.possible += items.next_multiple_of(crate::lanes::LANES) as u64;
        count.seconds += (now - since).as_secs_f64();
        count.runs += 1;
        now
    }

    /// Adds another thread's counters.
    pub fn add(&mut self, other: &Counters) {
        for (mine, theirs) in self.stages.iter_mut().zip(&other.stages) {
            mine.used += theirs.used;
            mine.possible += theirs.possible;
            mine.seconds += theirs.seconds;
            mine.runs += theirs.runs;
        }
        let walks = [(&mut self.closest_walk, &other.closest_walk), (&mut self.shadow_walk, &other.shadow_walk)];
        for (mine, theirs) in walks {
            mine.rays += theirs.rays;
            mine.lanes_used += theirs.lanes_used;
            mine.lanes_possible += theirs.lanes_possible;
        }
        self.rays.camera += other.rays.camera;
        self.rays.bounce += other.rays.bounce;
        self.rays.shadow += other.rays.shadow;
        self.paths += other.paths;
        self.guarded += other.guarded;
    }

    /// The stages that ran, for reports.
    pub fn report(&self) -> Vec<StageStats> {
        let ran = Stage::all().zip(&self.stages).filter(|(_, count)| count.runs > 0);
        ran.map(|(stage, count)| {
            let walk = match stage {
                Stage::IntersectClosest => Some(&self.closest_walk),
                Stage::IntersectShadow => Some(&self.shadow_walk),
                _ => None,
            };
            StageStats {
                stage: stage.name(),
                lanes_used: count.used,
                lanes_possible: count.possible,
                seconds: count.seconds,
                walk_lanes_used: walk.map(|walk| walk.lanes_used),
                walk_lanes_possible: walk.map(|walk| walk.lanes_possible),
            }
        })
        .collect()
    }
}
