//! Stage: rays that hit an emitter find its emission, weighed by what light sampling would have found.

use super::here;
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{COUNTS_ONE, COUNTS_ZERO, SLOT, TileState};
use crate::strategy::Row;
use here::kernels::columns::{RowLanes, SlotLanes, VectorLanes};
use here::kernels::lights::sample::{emitted, light_pdf_dir};
use here::kernels::lights::tree::Receivers;
use here::kernels::mis;
use here::kernels::records::{LightColumns, TriangleColumns};
use here::lanes::{F32x8, LANES, U32x8, Vec3x8};

/// Adds emitted radiance to every path that hit a side of an emitter that shines.
#[inline(always)]
pub fn shade_emitter(context: &StageContext, state: &mut TileState, _: &mut Counters) {
    let StageContext { setup, decisions, .. } = context;
    let TileState { paths, hits, emitters, slots, .. } = state;
    for first in (0..emitters.len).step_by(LANES) {
        let (row, active) = emitters.block(first);
        let gather = |column: &[f32]| F32x8::gather(column, row);
        let direction = Vec3x8::new(gather(&paths.rays.dx), gather(&paths.rays.dy), gather(&paths.rays.dz));
        // Idle lanes repeat row 0, which need not have hit an emitter: any light will do for them.
        let triangle = active.select_u32(U32x8::gather(&hits.triangle, row), U32x8::ZERO);
        let triangle = TriangleColumns::gather(&setup.scene.triangles, triangle);
        let normal = triangle.normal;
        let index = active.select_u32(triangle.light, U32x8::ZERO);
        let light = LightColumns::gather(&setup.lights.records, index);
        let mut light_cosine = -normal.dot(direction);
        let mut shines = light_cosine.gt(F32x8::ZERO);
        if setup.lights.two_sided {
            light_cosine = shines.select(light_cosine, -light_cosine);
            shines = shines | light.two_sided();
        }
        let slot = U32x8::gather(&paths.slot, row);
        let weight = if decisions.needs.pdf {
            let normal = if decisions.needs.normal { paths.normal.gather(row) } else { normal };
            let rays = &paths.rays;
            let origin = Vec3x8::new(gather(&rays.ox), gather(&rays.oy), gather(&rays.oz));
            let known = if decisions.needs.row { U32x8::gather(&paths.row, row) } else { U32x8::ZERO };
            let asks = active & shines & (slot & U32x8::splat(COUNTS_ONE | COUNTS_ZERO)).eq(U32x8::ZERO);
            let receivers = (&Receivers { origin, normal, row: known }, asks);
            let found = (index, &light);
            let pdf_light = light_pdf_dir(&setup.lights, receivers, found, gather(&hits.t), light_cosine);
            emission_weight(setup.strategy.row(), slot, gather(&paths.pdf_dir), pdf_light)
        } else {
            emission_weight(setup.strategy.row(), slot, F32x8::ONE, F32x8::ONE)
        };
        let (u, v) = (gather(&hits.u), gather(&hits.v));
        let radiance = emitted(&setup.lights, index, &light, [F32x8::ONE - u - v, u, v]);
        let gain = (paths.beta.gather(row) * radiance).scale(weight);
        slots.add(slot & U32x8::splat(SLOT), gain, (active & shines).bits());
    }
}

/// What emission found by a hit counts by the strategy's row, for directions drawn with density `pdf_dir` where light
/// sampling would have had `pdf_light`. `slot` carries the flags of the last bounce.
#[inline(always)]
pub fn emission_weight(row: &Row, slot: U32x8, pdf_dir: F32x8, pdf_light: F32x8) -> F32x8 {
    let drawn = mis::weigh(row.hit, pdf_dir, pdf_light);
    let certain = mis::weigh(row.certain_hit, pdf_dir, pdf_light);
    let flag = |bit: u32| (slot & U32x8::splat(bit)).eq(U32x8::splat(bit));
    let drawn = flag(COUNTS_ZERO).select(F32x8::ZERO, drawn);
    flag(COUNTS_ONE).select(certain, drawn)
}
