//! Stage: camera rays of the paths in the tile's slots. One variant a (filter, lens) pair.

use crate::lanes::{F32x8, LANES, U32x8, Vec3x8};
use crate::packet::queues::{COUNTS_ONE, TileState, append_rays};
use crate::packet::warp::sample_uniform_disk;
use crate::sampler::{ALL_WORDS, CAMERA_BLOCK, PIXEL_WORDS, sample_words_x8, unit_x8};
use crate::scene::desc::PixelFilter;
use crate::setup::Setup;

/// A variant of the stage.
pub type CameraStage = fn(&Setup, &mut TileState);

/// The variant for this camera.
pub fn variant(setup: &Setup) -> CameraStage {
    match (setup.camera.filter, setup.camera.lens.is_some()) {
        (PixelFilter::Box, false) => generate_camera_rays::<false, false>,
        (PixelFilter::Box, true) => generate_camera_rays::<false, true>,
        (PixelFilter::Tent, false) => generate_camera_rays::<true, false>,
        (PixelFilter::Tent, true) => generate_camera_rays::<true, true>,
    }
}

/// Fills `paths` with one ray for every slot, in slot order.
fn generate_camera_rays<const TENT: bool, const LENS: bool>(setup: &Setup, state: &mut TileState) {
    let camera = &setup.camera;
    let eye = Vec3x8::splat(camera.origin);
    let [corner, right, down] = [camera.corner, camera.right, camera.down].map(Vec3x8::splat);
    let paths = &mut state.paths;
    paths.len = state.slots.len;
    for first in (0..state.slots.len).step_by(LANES) {
        let pixel = U32x8::load(&state.slots.pixel, first);
        let sample = U32x8::load(&state.slots.sample, first);
        let words = if LENS {
            sample_words_x8::<ALL_WORDS>(setup.sampler, pixel, sample, CAMERA_BLOCK, setup.seed)
        } else {
            sample_words_x8::<PIXEL_WORDS>(setup.sampler, pixel, sample, CAMERA_BLOCK, setup.seed)
        };
        let offset = |word: U32x8| if TENT { tent(unit_x8(word)) } else { unit_x8(word) };
        let film_x = (pixel & U32x8::splat(0xffff)).to_f32() + offset(words[0]);
        let film_y = (pixel >> 16).to_f32() + offset(words[1]);
        let mut origin = eye;
        let mut direction = corner + right.scale(film_x) + down.scale(film_y);
        if let (true, Some(lens)) = (LENS, &camera.lens) {
            let [x, y] = sample_uniform_disk([unit_x8(words[2]), unit_x8(words[3])]);
            let on_lens = Vec3x8::splat(lens.right).scale(x) + Vec3x8::splat(lens.up).scale(y);
            origin = origin + on_lens;
            direction = direction.scale(F32x8::splat(lens.focus_distance)) - on_lens;
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
