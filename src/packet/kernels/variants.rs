//! Which copy of each stage a render runs.

use super::here;
use crate::packet::context::StageFn;
use crate::packet::counters::Stage;
use crate::packet::decisions::Decisions;
use crate::scene::desc::PixelFilter;
use crate::setup::Setup;
use crate::strategy::Strategy;
use crate::tables::lights::table::EnvironmentLight;
use crate::tables::materials::MaterialKind;
use here::kernels::bsdf::diffuse::Diffuse;
use here::kernels::bsdf::{Bsdf, ForKind, Specular, of_kind};
use here::kernels::stages::gather_layers::gather_layers;
use here::kernels::stages::generate_camera_rays::generate_camera_rays;
use here::kernels::stages::intersect::{intersect_closest, intersect_shadow};
use here::kernels::stages::shade_emitter::shade_emitter;
use here::kernels::stages::shade_miss::shade_miss;
use here::kernels::stages::shade_specular::shade_specular;
use here::kernels::stages::shade_surface::shade_surface;
use here::kernels::stages::sort_hits::sort_hits;

/// A stage as the plan holds it: compiled with this level's instructions.
macro_rules! stage {
    ($stage:expr) => {
        |context, state, counters| {
            here::run(
                #[inline(always)]
                || $stage(context, state, counters),
            )
        }
    };
}

/// What makes the rays of the first round; the stages of a round of a pass for layers, and those of a round, in order.
pub fn stages(setup: &Setup, decisions: &Decisions) -> (StageFn, [StageFn; 2], Vec<(Stage, StageFn)>) {
    let needs = &decisions.needs;
    let closest: StageFn = match needs.alpha_masks {
        true => stage!(intersect_closest::<true>),
        false => stage!(intersect_closest::<false>),
    };
    let mut round: Vec<(Stage, StageFn)> =
        vec![(Stage::IntersectClosest, closest), (Stage::SortHits, stage!(sort_hits))];
    if needs.misses {
        let map = matches!(setup.lights.environment, Some(EnvironmentLight::Map(..)));
        let variant: StageFn = match map || decisions.any_environment {
            true => stage!(shade_miss::<true>),
            false => stage!(shade_miss::<false>),
        };
        round.push((Stage::ShadeMiss, variant));
    }
    if needs.emitters {
        round.push((Stage::ShadeEmitter, stage!(shade_emitter)));
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
        let variant: StageFn = match needs.alpha_masks {
            true => stage!(intersect_shadow::<true>),
            false => stage!(intersect_shadow::<false>),
        };
        round.push((Stage::IntersectShadow, variant));
    }
    let layers: StageFn = if decisions.detail { stage!(gather_layers::<true>) } else { stage!(gather_layers::<false>) };
    (camera_variant(setup, decisions), [closest, layers], round)
}

/// The variant for this camera.
fn camera_variant(setup: &Setup, decisions: &Decisions) -> StageFn {
    let all = decisions.any_camera;
    match (all || setup.camera.filter == PixelFilter::Tent, all || setup.camera.lens.is_some()) {
        (false, false) => stage!(generate_camera_rays::<false, false>),
        (false, true) => stage!(generate_camera_rays::<false, true>),
        (true, false) => stage!(generate_camera_rays::<true, false>),
        (true, true) => stage!(generate_camera_rays::<true, true>),
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
        [$(stage!(shade_surface::<$bsdf, $number, $detail, $learned>)),*]
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
        if self.detail { stage!(shade_specular::<S, true>) } else { stage!(shade_specular::<S, false>) }
    }
}
