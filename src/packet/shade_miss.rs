//! Stage: rays that left the scene find the constant environment.

use super::plan::Plan;
use super::shade_emitter::emission_weight;
use super::state::{SLOT, TileState};
use super::warp::cosine_hemisphere_pdf_dir;
use crate::lanes::{F32x8, LANES, U32x8, Vec3x8};
use crate::setup::Setup;

/// Adds the environment's radiance to every path that hit nothing.
pub fn shade_miss(setup: &Setup, plan: &Plan, state: &mut TileState) {
    let radiance = Vec3x8::splat(setup.scene.environment.unwrap_or_default());
    let probability = F32x8::splat(setup.lights.environment_probability);
    let TileState { paths, misses, slots, .. } = state;
    for first in (0..misses.len).step_by(LANES) {
        let (row, active) = misses.block(first);
        let slot = U32x8::gather(&paths.slot, row);
        let weight = if plan.needs.pdf {
            let pdf_dir = F32x8::gather(&paths.pdf_dir, row);
            // The environment is sampled by a cosine hemisphere; so are diffuse surfaces, which then know the density.
            let hemisphere =
                if plan.needs.cosine { cosine_hemisphere_pdf_dir(F32x8::gather(&paths.cosine, row)) } else { pdf_dir };
            emission_weight(setup.strategy, slot, pdf_dir, probability * hemisphere)
        } else {
            emission_weight(setup.strategy, slot, F32x8::ONE, F32x8::ONE)
        };
        let gain = (paths.beta.gather(row) * radiance).scale(weight);
        slots.add(slot & U32x8::splat(SLOT), gain, active.bits());
    }
}
