//! The plan: the stages that a render needs, in the order in which they run.
//!
//! **Invariant:** a stage that is not needed is not in the list, is never called, and its queue holds no memory. A stage's
//! variant is chosen here, once; [`super::explain`] says of the same list what it does and what was left out.

use crate::packet::bsdf::diffuse::Diffuse;
use crate::packet::bsdf::{Bsdf, ForKind, Specular, of_kind};
use crate::packet::context::StageFn;
use crate::packet::counters::Stage;
use crate::packet::decisions::Decisions;
use crate::packet::queues::TileState;
use crate::packet::stages::generate_camera_rays;
use crate::packet::stages::intersect::{intersect_closest, intersect_shadow};
use crate::packet::stages::shade_emitter::shade_emitter;
use crate::packet::stages::shade_miss;
use crate::packet::stages::shade_specular::shade_specular;
use crate::packet::stages::shade_surface::shade_surface;
use crate::packet::stages::sort_hits::sort_hits;
use crate::setup::Setup;
use crate::strategy::Strategy;
use crate::tables::materials::MaterialKind;

/// What a render runs.
pub struct Plan {
    /// Makes the rays of the first round.
    pub generate_camera_rays: StageFn,
    /// The stages of a round, in order.
    pub round: Vec<(Stage, StageFn)>,
    /// What the stages read.
    pub decisions: Decisions,
}

impl Plan {
    /// The plan of one render.
    pub fn new(setup: &Setup) -> Plan {
        let decisions = Decisions::new(setup);
        let needs = &decisions.needs;
        let masks = needs.alpha_masks;
        let mut round: Vec<(Stage, StageFn)> = vec![
            (Stage::IntersectClosest, if masks { intersect_closest::<true> } else { intersect_closest::<false> }),
            (Stage::SortHits, sort_hits),
        ];
        if needs.misses {
            round.push((Stage::ShadeMiss, shade_miss::variant(setup)));
        }
        if needs.emitters {
            round.push((Stage::ShadeEmitter, shade_emitter));
        }
        for &kind in &decisions.kinds {
            let learned = decisions.learned && kind == MaterialKind::Diffuse;
            let variant = match learned {
                true => Some(learned_variant(setup.strategy, decisions.detail)),
                false => of_kind(kind, SurfaceVariant { strategy: setup.strategy, detail: decisions.detail }),
            };
            round.extend(variant.map(|variant| (Stage::Shade(kind), variant)));
        }
        if needs.shadow {
            let variant = if masks { intersect_shadow::<true> } else { intersect_shadow::<false> };
            round.push((Stage::IntersectShadow, variant));
        }
        Plan { generate_camera_rays: generate_camera_rays::variant(setup), round, decisions }
    }

    /// One thread's queues, for `capacity` paths.
    pub fn tile_state(&self, capacity: usize) -> TileState {
        self.decisions.tile_state(capacity)
    }
}

/// Chooses the monomorphised copy of a surface stage: one a strategy where light is sampled, each without or with what
/// smooth and textured surfaces need. (The sampler is a branch in them, always taken alike: copies for it would double the
/// code to save 1 % of the instructions.)
struct SurfaceVariant {
    strategy: Strategy,
    detail: bool,
}

/// The copies of `shade_surface` by the numbers of the strategies.
macro_rules! by_strategy {
    ($bsdf:ty, $detail:literal, $learned:literal) => {
        by_strategy!($bsdf, $detail, $learned, 0 1 2 3 4 5 6 7 8)
    };
    ($bsdf:ty, $detail:literal, $learned:literal, $($number:literal)*) => {
        [$(shade_surface::<$bsdf, $number, $detail, $learned>),*]
    };
}

/// The copies of the stage for diffuse surfaces that look up what was learned of directions.
fn learned_variant(strategy: Strategy, detail: bool) -> StageFn {
    let variants: [StageFn; Strategy::ALL.len()] = match detail {
        false => by_strategy!(Diffuse, false, true),
        true => by_strategy!(Diffuse, true, true),
    };
    variants[strategy as usize]
}

impl ForKind for SurfaceVariant {
    type Output = StageFn;

    fn bsdf<B: Bsdf>(self) -> StageFn {
        let variants: [StageFn; Strategy::ALL.len()] = match self.detail {
            false => by_strategy!(B, false, false),
            true => by_strategy!(B, true, false),
        };
        variants[self.strategy as usize]
    }

    fn specular<S: Specular>(self) -> StageFn {
        if self.detail { shade_specular::<S, true> } else { shade_specular::<S, false> }
    }
}
