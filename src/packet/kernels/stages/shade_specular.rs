//! Stage: surfaces that scatter to single directions. After them light sampling could not have worked, so the next hit counts
//! as the strategy says for certain hits; the strategy itself changes nothing here.

use super::here;
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{COUNTS_ONE, TileState};
use here::kernels::bsdf::Specular;
use here::kernels::stages::shade_common::{Bounce, go_on, load_hits};
use here::lanes::{F32x8, LANES, U32x8};

/// Hits on surfaces of the kind `S`. `DETAIL`: some surface of the scene is smooth or textured.
#[inline(always)]
pub fn shade_specular<S: Specular, const DETAIL: bool>(
    context: &StageContext,
    state: &mut TileState,
    _: &mut Counters,
) {
    let StageContext { setup, decisions, .. } = context;
    let TileState { surfaces, next, slots, .. } = state;
    if context.is_last_event() && !decisions.last_delta_counts {
        return;
    }
    let queue = &surfaces[S::KIND];
    for first in (0..queue.len).step_by(LANES) {
        let mut hits = load_hits::<DETAIL>(context, queue, slots, first);
        let material = S::load(&setup.scene.materials, hits.points.material);
        let incoming = if DETAIL { S::orient(&mut hits.points, hits.direction) } else { hits.direction };
        let draws = S::draws(&hits.numbers, context.depth);
        let points = &hits.points;
        let (direction, weight, albedo) = material.sample(incoming, points.normal, points.front, draws.lobe);
        let direction = if DETAIL { points.to_consistent_hemisphere(direction) } else { direction };
        let through = direction.dot(points.geometric_normal).lt(F32x8::ZERO);
        let bounce = Bounce {
            active: hits.active,
            origin: through.select_vec3(points.origin_behind, points.origin),
            direction,
            beta: hits.beta * weight,
            pdf_dir: F32x8::ONE,
            cosine: F32x8::ZERO,
            flags: U32x8::splat(COUNTS_ONE),
        };
        go_on(context, &hits, &bounce, draws.roulette, next, slots, |_| (albedo, F32x8::ZERO));
    }
}
