//! Stage: camera rays of the paths in the tile's slots.

use super::state::{COUNTS_ONE, TileState};
use crate::lanes::{F32x8, LANES, U32x8, Vec3x8};
use crate::sampler::{CAMERA_BLOCK, random_words_x8, unit_x8};
use crate::setup::Setup;

/// Fills `paths` with one ray for every slot, in slot order.
pub fn generate_camera_rays(setup: &Setup, state: &mut TileState) {
    let camera = &setup.camera;
    let origin = Vec3x8::splat(camera.origin);
    let [corner, right, down] = [camera.corner, camera.right, camera.down].map(Vec3x8::splat);
    let paths = &mut state.paths;
    paths.len = state.slots.len;
    for first in (0..state.slots.len).step_by(LANES) {
        let pixel = U32x8::load(&state.slots.pixel, first);
        let sample = U32x8::load(&state.slots.sample, first);
        let words = random_words_x8(pixel, sample, CAMERA_BLOCK, setup.seed);
        let film_x = (pixel & U32x8::splat(0xffff)).to_f32() + unit_x8(words[0]);
        let film_y = (pixel >> 16).to_f32() + unit_x8(words[1]);
        let direction = corner + right.scale(film_x) + down.scale(film_y);
        let direction = direction.scale(F32x8::ONE / direction.dot(direction).sqrt());
        super::state::append_rays(&mut paths.rays, first, origin, direction, 0xff);
        paths.beta.append(first, Vec3x8::splat([1.0; 3]), 0xff);
        let slot = U32x8::lane_numbers() + U32x8::splat(first as u32);
        (slot | U32x8::splat(COUNTS_ONE)).store(&mut paths.slot, first);
    }
}
