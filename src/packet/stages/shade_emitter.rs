//! Stage: rays that hit an emitter find its emission, weighed by what light sampling would have found.

use crate::lanes::{F32x8, LANES, U32x8, Vec3x8};
use crate::packet::lights::sample::{emitted, light_pdf_dir};
use crate::packet::lights::tree::Receivers;
use crate::packet::mis;
use crate::packet::plan::Plan;
use crate::packet::queues::{COUNTS_ONE, COUNTS_ZERO, SLOT, TileState};
use crate::packet::surface::gather_records;
use crate::settings::Strategy;
use crate::setup::Setup;

/// Adds emitted radiance to every path that hit a side of an emitter that shines.
pub fn shade_emitter(setup: &Setup, plan: &Plan, state: &mut TileState) {
    let TileState { paths, hits, emitters, slots, .. } = state;
    for first in (0..emitters.len).step_by(LANES) {
        let (row, active) = emitters.block(first);
        let gather = |column: &[f32]| F32x8::gather(column, row);
        let direction = Vec3x8::new(gather(&paths.rays.dx), gather(&paths.rays.dy), gather(&paths.rays.dz));
        // Idle lanes repeat row 0, which need not have hit an emitter: any light will do for them.
        let triangle =
            gather_records(&setup.scene.triangles, active.select_u32(U32x8::gather(&hits.triangle, row), U32x8::ZERO));
        let light = active.select_u32(triangle[13].to_bits(), U32x8::ZERO);
        let normal = Vec3x8::new(triangle[9], triangle[10], triangle[11]);
        let index = light;
        let light = gather_records(&setup.lights.records, index);
        let mut light_cosine = -normal.dot(direction);
        let mut shines = light_cosine.gt(F32x8::ZERO);
        if setup.lights.two_sided {
            let both = light[15].lt(F32x8::ZERO);
            light_cosine = shines.select(light_cosine, -light_cosine);
            shines = shines | both;
        }
        let slot = U32x8::gather(&paths.slot, row);
        let weight = if plan.needs.pdf {
            let normal = if plan.needs.normal { paths.normal.gather(row) } else { normal };
            let rays = &paths.rays;
            let origin = Vec3x8::new(gather(&rays.ox), gather(&rays.oy), gather(&rays.oz));
            let asks = active & shines & (slot & U32x8::splat(COUNTS_ONE | COUNTS_ZERO)).eq(U32x8::ZERO);
            let receivers = (&Receivers { origin, normal }, asks);
            let found = (index, &light);
            let pdf_light = light_pdf_dir(&setup.lights, receivers, found, gather(&hits.t), light_cosine);
            emission_weight(setup.strategy, slot, gather(&paths.pdf_dir), pdf_light)
        } else {
            emission_weight(setup.strategy, slot, F32x8::ONE, F32x8::ONE)
        };
        let (u, v) = (gather(&hits.u), gather(&hits.v));
        let radiance = emitted(&setup.lights, index, &light, [F32x8::ONE - u - v, u, v]);
        let gain = (paths.beta.gather(row) * radiance).scale(weight);
        slots.add(slot & U32x8::splat(SLOT), gain, (active & shines).bits());
    }
}

/// What emission found by a hit counts (design table, column "emission found by a hit counts"), for directions drawn with
/// density `pdf_dir` where light sampling would have had `pdf_light`. `slot` carries the flags of the last bounce.
#[inline(always)]
pub fn emission_weight(strategy: Strategy, slot: U32x8, pdf_dir: F32x8, pdf_light: F32x8) -> F32x8 {
    let drawn = match strategy {
        Strategy::Uniform | Strategy::Bsdf | Strategy::NeeSum => F32x8::ONE,
        Strategy::NeeAverage => F32x8::splat(0.5),
        Strategy::NeeNoEmission => return F32x8::ZERO,
        Strategy::Nee => F32x8::ZERO,
        Strategy::MisOneSample => F32x8::splat(2.0) * mis::balance(pdf_dir, pdf_light),
        Strategy::MisBalance => mis::balance(pdf_dir, pdf_light),
        Strategy::MisPower => mis::power(pdf_dir, pdf_light),
    };
    let flag = |bit: u32| (slot & U32x8::splat(bit)).eq(U32x8::splat(bit));
    let drawn = flag(COUNTS_ZERO).select(F32x8::ZERO, drawn);
    flag(COUNTS_ONE).select(F32x8::ONE, drawn)
}
