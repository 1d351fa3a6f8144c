//! Tiles: rectangles of the film, each with the sums of its own pixels.

use std::sync::Mutex;

use crate::fault::{Fault, planted};
use crate::film::{ErrorSums, Film, GroupSums, Pixel, Sums};
use crate::settings::Crop;
use crate::setup::Setup;

/// A rectangle of the film and what it has gathered.
pub(super) struct Tile {
    pub(super) area: Crop,
    pub(super) pixels: Vec<Pixel>,
    /// As [`Film::groups`].
    pub(super) groups: Vec<GroupSums>,
    /// What the engines' radiances count in, W sr^-1 m^-2.
    unit: f64,
    pub(super) nonfinite: Vec<(u32, u32, u32)>,
    /// For the error estimate after this pass.
    pub(super) error: ErrorSums,
}

/// Columns and rows of tiles small enough that a pass over one fills, and does not overflow, the packet engine's queues.
pub(super) fn tile_size(pass_spp: u32) -> (u32, u32) {
    match pass_spp {
        8.. => (16, 16),
        4.. => (32, 16),
        2.. => (32, 32),
        _ => (64, 32),
    }
}

/// The tiles of a film for passes of so many samples.
pub(super) fn cut_into_tiles(setup: &Setup, pass_spp: u32) -> Vec<Mutex<Tile>> {
    let crop = setup.frame.crop;
    let (width, height) = tile_size(pass_spp);
    let mut tiles = Vec::new();
    for y in (0..crop.height).step_by(height as usize) {
        for x in (0..crop.width).step_by(width as usize) {
            let (w, h) = ((crop.width - x).min(width), (crop.height - y).min(height));
            let area = Crop { x: crop.x + x, y: crop.y + y, width: w, height: h };
            let Film { pixels, groups, .. } = Film::of_sampler(area, setup.sampler);
            let (unit, error) = (setup.scene.radiance_unit, ErrorSums::default());
            tiles.push(Mutex::new(Tile { area, pixels, groups, unit, nonfinite: Vec::new(), error }));
        }
    }
    tiles
}

/// Puts into `tile` what `film`, a picture of `crop`, holds of it, and what that tells of its error.
pub(super) fn fill_from(tile: &mut Tile, film: &Film, crop: Crop) {
    if planted(Fault::LostPass) {
        return;
    }
    copy_out(&mut tile.pixels, &film.pixels, tile.area, crop);
    if !tile.groups.is_empty() {
        copy_out(&mut tile.groups, &film.groups, tile.area, crop);
    }
    tile.error = ErrorSums::of(Sums { pixels: &tile.pixels, groups: &tile.groups, spp: film.spp });
}

impl Tile {
    pub(super) fn add(&mut self, index: usize, sample: u32, radiance: [f32; 3]) {
        if !self.pixels[index].add_in(self.unit, radiance) {
            let (x, y) = (index as u32 % self.area.width, index as u32 / self.area.width);
            self.nonfinite.push((self.area.y + y, self.area.x + x, sample));
        } else if let Some(groups) = self.groups.get_mut(index) {
            groups.add_in(self.unit, sample, radiance);
        }
    }
}

/// Puts what a tile holds of every pixel of `area` where it belongs in `crop`.
pub(super) fn copy_into<T: Copy>(film: &mut [T], tile: &[T], area: Crop, crop: Crop) {
    for (row, pixels) in tile.chunks(area.width as usize).enumerate() {
        let start = (area.y - crop.y) as usize + row;
        let start = start * crop.width as usize + (area.x - crop.x) as usize;
        film[start..start + pixels.len()].copy_from_slice(pixels);
    }
}

/// The inverse of [`copy_into`].
fn copy_out<T: Copy>(tile: &mut [T], film: &[T], area: Crop, crop: Crop) {
    for (row, pixels) in tile.chunks_mut(area.width as usize).enumerate() {
        let start = (area.y - crop.y) as usize + row;
        let start = start * crop.width as usize + (area.x - crop.x) as usize;
        pixels.copy_from_slice(&film[start..start + pixels.len()]);
    }
}
