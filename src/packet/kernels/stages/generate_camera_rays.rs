//! Stage: camera rays of the paths in the tile's slots. A variant for what there may be: a filter, a lens.

use super::here;
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::queues::{COUNTS_ONE, TileState};
use crate::sampler::{ALL_WORDS, PIXEL_WORDS};
use crate::scene::desc::PixelFilter;
use here::kernels::columns::{VectorLanes, append_rays};
use here::kernels::warp::sample_uniform_disk;
use here::lanes::{Each, F32x8, LANES, U32x8, Vec3x8, inlined};
use here::numbers::draws::PathNumbers8;

/// Fills `paths` with one ray for every slot, in slot order.
#[inline(always)]
pub fn generate_camera_rays<const TENT: bool, const LENS: bool>(
    context: &StageContext,
    state: &mut TileState,
    _: &mut Counters,
) {
    let setup = context.setup;
    let camera = &setup.camera;
    let is_tent = TENT && camera.filter == PixelFilter::Tent;
    let eye = Vec3x8::splat(camera.origin);
    let [corner, right, down] = [camera.corner, camera.right, camera.down].each(Vec3x8::splat);
    let paths = &mut state.paths;
    paths.len = state.slots.len;
    for first in (0..state.slots.len).step_by(LANES) {
        let pixel = U32x8::load(&state.slots.pixel, first);
        let sample = U32x8::load(&state.slots.sample, first);
        let numbers = PathNumbers8 { sampler: setup.sampler, seed: setup.seed, pixel, sample };
        let draws = if LENS { numbers.camera::<ALL_WORDS>() } else { numbers.camera::<PIXEL_WORDS>() };
        let offset = inlined(
            #[inline(always)]
            |u: F32x8| if is_tent { tent(u) } else { u },
        );
        let film_x = (pixel & U32x8::splat(0xffff)).to_f32() + offset(draws.film[0]);
        let film_y = (pixel >> 16).to_f32() + offset(draws.film[1]);
        let mut origin = eye;
        let mut direction = corner + right.scale(film_x) + down.scale(film_y);
        if let (true, Some(lens)) = (LENS, &camera.lens) {
            let [x, y] = sample_uniform_disk(draws.lens);
            let on_lens = Vec3x8::splat(lens.right).scale(x) + Vec3x8::splat(lens.up).scale(y);
            origin = origin + on_lens;
            direction = direction.scale(F32x8::splat(lens.focus_distance)) - on_lens.scale(F32x8::splat(lens.scale));
        }
        let direction = direction.scale(F32x8::ONE / direction.dot(direction).sqrt());
        append_rays(&mut paths.rays, first, origin, direction, 0xff);
        paths.beta.append(first, Vec3x8::splat([1.0; 3]), 0xff);
        let slot = U32x8::lane_numbers() + U32x8::splat(first as u32);
        (slot | U32x8::splat(COUNTS_ONE)).store(&mut paths.slot, first);
    }
}

/// Where about its pixel a sample lies under the tent filter, from numbers in [0, 1): 0.5 is the centre.
#[inline(always)]
fn tent(u: F32x8) -> F32x8 {
    let two = F32x8::splat(2.0);
    let rising = (two * u).sqrt() - F32x8::splat(0.5);
    let falling = F32x8::splat(1.5) - (two - two * u).sqrt();
    u.lt(F32x8::splat(0.5)).select(rising, falling)
}
