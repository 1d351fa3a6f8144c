//! Stage: rays that left the scene find the environment, weighed by what light sampling would have found.

use super::here;
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{SLOT, TileState};
use crate::tables::lights::table::EnvironmentLight;
use here::kernels::columns::{RowLanes, SlotLanes, VectorLanes};
use here::kernels::lights::choose::{Light8, probability};
use here::kernels::lights::environment::{gather_texels, map_pdf_dir, ratios, texel_indices};
use here::kernels::lights::tree::Receivers;
use here::kernels::stages::shade_emitter::emission_weight;
use here::kernels::warp::cosine_hemisphere_pdf_dir;
use here::lanes::{F32x8, LANES, U32x8, Vec3x8};

/// Adds the environment's radiance to every path that hit nothing, but for camera rays that are not to see it; `MAP`: it depends
/// on direction.
#[inline(always)]
pub fn shade_miss<const MAP: bool>(context: &StageContext, state: &mut TileState, _: &mut Counters) {
    let StageContext { setup, decisions, .. } = context;
    if setup.hide_environment && context.depth == 0 {
        return;
    }
    let constant = match setup.lights.environment {
        Some(EnvironmentLight::Constant(radiance)) => radiance,
        _ => [0.0; 3],
    };
    let patches = setup.lights.learned_patches();
    let TileState { paths, misses, slots, .. } = state;
    for first in (0..misses.len).step_by(LANES) {
        let (row, active) = misses.block(first);
        let gather = |column: &[f32]| F32x8::gather(column, row);
        let rays = &paths.rays;
        let slot = U32x8::gather(&paths.slot, row);
        let pdf_dir = if decisions.needs.pdf { gather(&paths.pdf_dir) } else { F32x8::ONE };
        let (radiance, pdf_light) = match setup.lights.environment {
            Some(EnvironmentLight::Map(map, distribution)) if MAP => {
                let index = texel_indices(map, Vec3x8::new(gather(&rays.dx), gather(&rays.dy), gather(&rays.dz)));
                let texels = gather_texels(map, index);
                let pdf_light = map_pdf_dir(distribution, &texels);
                match patches.filter(|_| decisions.needs.row) {
                    None => (texels.radiance, pdf_light),
                    Some(patches) => {
                        (texels.radiance, pdf_light * ratios(patches, U32x8::gather(&paths.row, row), index))
                    }
                }
            }
            // A constant environment is sampled by a cosine hemisphere; so are diffuse surfaces, which then know the density.
            _ if decisions.needs.cosine => (Vec3x8::splat(constant), cosine_hemisphere_pdf_dir(gather(&paths.cosine))),
            _ => (Vec3x8::splat(constant), pdf_dir),
        };
        let pdf_light = if decisions.needs.pdf {
            let origin = Vec3x8::new(gather(&rays.ox), gather(&rays.oy), gather(&rays.oz));
            let normal = if decisions.needs.normal { paths.normal.gather(row) } else { origin };
            probability(&setup.lights, &Receivers { origin, normal, row: U32x8::ZERO }, active, Light8::Environment)
                * pdf_light
        } else {
            pdf_light
        };
        let weight = emission_weight(setup.strategy.row(), slot, pdf_dir, pdf_light);
        let gain = (paths.beta.gather(row) * radiance).scale(weight);
        slots.add(slot & U32x8::splat(SLOT), gain, active.bits());
    }
}
