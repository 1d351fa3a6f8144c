//! Roulette of shadow rays by what was learned of which cells see each other, and what a training render writes down of it.

use super::here;
use crate::bvh::RayQueue;
use crate::fault::{Fault, planted};
use crate::learn::visibility::records::VisibilityRecords;
use crate::tables::lights::visibility::{STEPS, Visibility};
use here::kernels::lights::factors::cells;
use here::kernels::lights::light_sample::LightSamples;
use here::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};

/// Plays roulette, with the numbers `u`, of the shadow rays that light samples of the lanes `active` send to emitters from
/// `origin`: the lanes that are left, whose samples then stand for those that are not.
#[inline(never)]
pub fn play_roulette(
    visibility: &Visibility,
    origin: Vec3x8,
    light: &mut LightSamples,
    active: Mask8,
    u: F32x8,
) -> Mask8 {
    here::run(
        #[inline(always)]
        || {
            let pair = pairs(visibility, origin, light.shadow_direction);
            let steps = U32x8::from_array(pair.map(|pair| visibility.steps(pair))).to_f32();
            let to_emitter = light.shadow_tmax.lt(F32x8::splat(f32::INFINITY));
            let steps = to_emitter.select(steps, F32x8::splat(STEPS));
            if !planted(Fault::ForgottenShadowRays) {
                light.radiance = light.radiance.scale(F32x8::splat(STEPS) / steps);
            }
            active & u.lt(steps * F32x8::splat(1.0 / STEPS))
        },
    )
}

/// Writes down which of the first `len` shadow rays that were traced to emitters were blocked.
#[inline(never)]
pub fn record(visibility: &Visibility, rays: &RayQueue, blocked: &[u8], len: usize, records: &mut VisibilityRecords) {
    here::run(
        #[inline(always)]
        || {
            for first in (0..len).step_by(LANES) {
                let column = |column: &[f32]| F32x8::load(column, first);
                let origin = Vec3x8::new(column(&rays.ox), column(&rays.oy), column(&rays.oz));
                let direction = Vec3x8::new(column(&rays.dx), column(&rays.dy), column(&rays.dz));
                let pair = pairs(visibility, origin, direction);
                for (lane, row) in (first..len.min(first + LANES)).enumerate() {
                    if rays.tmax[row] < f32::INFINITY {
                        records.note(pair[lane], blocked[first / LANES] >> lane & 1 == 0);
                    }
                }
            }
        },
    )
}

/// The pairs of cells between which shadow rays run from `origin` to `origin + direction`.
#[inline(always)]
fn pairs(visibility: &Visibility, origin: Vec3x8, direction: Vec3x8) -> [u32; LANES] {
    let receiver = cells(&visibility.grid, origin).to_array();
    let light = cells(&visibility.grid, origin + direction).to_array();
    std::array::from_fn(|lane| visibility.pair(receiver[lane], light[lane]))
}
