//! Tiles: rectangles of the film, each with the sums of its own pixels.
//!
//! The film lends its tables to the tiles, so that no sum exists twice. Meanwhile a table is in the order of the tiles, each of
//! which is one piece of it: a band of tiles as high as a tile takes the same place in either order, so pixels move within
//! bands only, with a copy of one band aside.

use crate::error::Result;
use crate::film::{ErrorSums, Film, Pixel, SumsMut, TileCounts, part};
use crate::render::shared::Locked;
use crate::settings::{Crop, Sampler};
use crate::setup::Setup;

/// A rectangle of the film and what it has gathered.
pub(super) struct Tile<'f> {
    pub(super) area: Crop,
    /// Samples in every pixel.
    pub(super) done: u32,
    sums: SumsMut<'f>,
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

/// Where the tiles of a render lie, in the film and in its tables.
pub(super) struct Layout {
    /// Of each, its pixels in the film.
    pub(super) areas: Vec<Crop>,
    /// Columns and rows of all but the last ones of a row or column.
    tile: (u32, u32),
    /// The tables are a strip of the tiles of a part: they have no rows.
    is_strip: bool,
}

impl Layout {
    /// That of `setup`, in tiles of this size; those of a part have a size of their own.
    pub(super) fn new(setup: &Setup, tile: (u32, u32)) -> Layout {
        let crop = setup.frame.crop;
        if let Some(shard) = setup.shard {
            let areas = part::tiles(setup.frame.film, crop, shard);
            return Layout { areas, tile: (part::PIXELS, 1), is_strip: true };
        }
        let mut areas = Vec::new();
        for y in (0..crop.height).step_by(tile.1 as usize) {
            for x in (0..crop.width).step_by(tile.0 as usize) {
                let (width, height) = ((crop.width - x).min(tile.0), (crop.height - y).min(tile.1));
                areas.push(Crop { x: crop.x + x, y: crop.y + y, width, height });
            }
        }
        Layout { areas, tile, is_strip: false }
    }

    /// An empty film for it.
    pub(super) fn film(&self, setup: &Setup) -> Result<Film> {
        match self.is_strip {
            true => part::strip(&self.areas, setup.sampler),
            false => Film::try_of_sampler(setup.frame.crop, setup.sampler),
        }
    }

    /// What of `table`, which is in the order of tiles, belongs to each tile; where it is empty, nothing.
    pub(super) fn pieces<'f, T>(&self, mut table: &'f mut [T]) -> impl Iterator<Item = &'f mut [T]> {
        self.areas.iter().map(move |area| {
            let count = area.width as usize * area.height as usize;
            // What a tile at the edge lacks in a strip belongs to nobody.
            let taken = if self.is_strip { part::PIXELS as usize } else { count };
            first(split_off(&mut table, taken), count)
        })
    }

    /// Pixels of all tiles.
    pub(super) fn pixels(&self) -> u64 {
        self.areas.iter().map(|area| u64::from(area.width) * u64::from(area.height)).sum()
    }

    /// Samples of all pixels of `film`, which is of this layout.
    pub(super) fn samples(&self, film: &Film) -> u64 {
        let Some(uneven) = &film.uneven else { return u64::from(film.spp) * self.pixels() };
        let of_tile = |(area, count): (&Crop, &u32)| u64::from(area.width) * u64::from(area.height) * u64::from(*count);
        self.areas.iter().zip(&uneven.counts).map(of_tile).sum()
    }

    /// Whether a render can go on from `film`.
    pub(super) fn fits(&self, film: &Film, setup: &Setup) -> bool {
        let crop = setup.frame.crop;
        let size = match self.is_strip {
            true => (self.areas.len() as u32 * part::PIXELS, u32::from(!self.areas.is_empty())),
            false => (crop.width, crop.height),
        };
        let count = size.0 as usize * size.1 as usize;
        let (squares, groups) = if setup.sampler == Sampler::Sobol { (0, count) } else { (count, 0) };
        let of_tiles = |uneven: &TileCounts| uneven.tile == self.tile && uneven.counts.len() == self.areas.len();
        (film.width, film.height) == size
            && (film.pixels.len(), film.squares.len(), film.groups.len()) == (count, squares, groups)
            && film.uneven.as_ref().is_none_or(of_tiles)
    }

    /// Gives `film` the number of samples of each tile; `done`: what all have if there is none.
    pub(super) fn count(&self, film: &mut Film, counts: Vec<u32>, done: u32) {
        film.spp = counts.iter().copied().min().unwrap_or(done);
        let even = counts.iter().all(|count| *count == film.spp);
        film.uneven = (!even).then_some(TileCounts { tile: self.tile, counts });
    }

    /// Brings a table of this layout from the order of tiles into rows of `width` pixels.
    pub(super) fn to_rows<T: Copy>(&self, table: &mut [T], width: u32) {
        if !self.is_strip {
            reorder_table(table, width as usize, self.tile, Order::Rows);
        }
    }

    /// Brings all tables of `film` from the other order into `to`.
    pub(super) fn reorder(&self, film: &mut Film, to: Order) {
        if !self.is_strip {
            reorder(film, self.tile, to);
        }
    }
}

/// The tiles of `film`, in the order of tiles of this layout. The counts of an uneven film go into them.
pub(super) fn cut_into_tiles<'f>(setup: &Setup, film: &'f mut Film, layout: &Layout) -> Vec<Locked<Tile<'f>>> {
    let spp = film.spp;
    let mut counts = film.uneven.take().map(|uneven| uneven.counts).unwrap_or_default().into_iter();
    let SumsMut { pixels, squares, groups } = film.sums_mut();
    let (mut squares, mut groups) = (layout.pieces(squares), layout.pieces(groups));
    let of_tile = |(&area, pixels): (&Crop, &'f mut [Pixel])| {
        let (squares, groups) = (squares.next().unwrap_or_default(), groups.next().unwrap_or_default());
        let sums = SumsMut { pixels, squares, groups };
        let done = counts.next().unwrap_or(spp);
        let unit = setup.scene.radiance_unit;
        let mut tile = Tile { area, done, sums, unit, nonfinite: Vec::new(), error: ErrorSums::default() };
        if done > 0 {
            tile.note_error();
        }
        Locked::new(tile)
    };
    layout.areas.iter().zip(layout.pieces(pixels)).map(of_tile).collect()
}

/// The first `count` of `rows`, or all there are.
fn first<T>(rows: &mut [T], count: usize) -> &mut [T] {
    let count = count.min(rows.len());
    &mut rows[..count]
}

/// The first `count` of `table`, which is left with the others; nothing of an empty table.
fn split_off<'f, T>(table: &mut &'f mut [T], count: usize) -> &'f mut [T] {
    table.split_off_mut(..count).unwrap_or_default()
}

/// An order of a film's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// Row by row.
    Rows,
    /// Tile by tile, in each row by row.
    Tiles,
}

/// Brings all tables of `film` from the other order into `to`, for tiles of this size.
fn reorder(film: &mut Film, tile: (u32, u32), to: Order) {
    let width = film.width as usize;
    reorder_table(&mut film.pixels, width, tile, to);
    reorder_table(&mut film.squares, width, tile, to);
    reorder_table(&mut film.groups, width, tile, to);
}

fn reorder_table<T: Copy>(table: &mut [T], width: usize, (tile_width, tile_height): (u32, u32), to: Order) {
    let mut before = Vec::new();
    for band in table.chunks_mut(width * tile_height as usize) {
        before.clear();
        before.extend_from_slice(band);
        let rows = band.len() / width;
        for x in (0..width).step_by(tile_width as usize) {
            let columns = (width - x).min(tile_width as usize);
            for row in 0..rows {
                // All tiles to the left are full, as high as the band.
                let (in_rows, in_tiles) = (row * width + x, x * rows + row * columns);
                let (from, to) = if to == Order::Rows { (in_tiles, in_rows) } else { (in_rows, in_tiles) };
                band[to..to + columns].copy_from_slice(&before[from..from + columns]);
            }
        }
    }
}

impl Tile<'_> {
    /// Its pixels.
    pub(super) fn len(&self) -> usize {
        self.sums.pixels.len()
    }

    pub(super) fn add(&mut self, index: usize, sample: u32, radiance: [f32; 3]) {
        if !self.sums.add(self.unit, index, sample, radiance) {
            let (x, y) = (index as u32 % self.area.width, index as u32 / self.area.width);
            self.nonfinite.push((self.area.y + y, self.area.x + x, sample));
        }
    }

    /// Notes what its samples tell of the error.
    pub(super) fn note_error(&mut self) {
        self.error = ErrorSums::of(self.sums.after(self.done));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_come_back_from_the_order_of_tiles_as_they_were() {
        for (width, height, tile) in
            [(1, 1, (16, 16)), (40, 33, (16, 16)), (64, 32, (64, 32)), (7, 70, (32, 16)), (100, 3, (32, 32))]
        {
            for sampler in Sampler::ALL.iter().copied() {
                let mut film = Film::of_sampler(Crop { x: 5, y: 3, width, height }, sampler);
                (0..film.pixels.len()).for_each(|i| assert!(film.add(i, i as u32, [i as f32, 1.0, 2.0])));
                let before = film.clone();
                reorder(&mut film, tile, Order::Tiles);
                // Each tile is one piece, row by row.
                let mut place = 0;
                for y in (0..height).step_by(tile.1 as usize) {
                    for x in (0..width).step_by(tile.0 as usize) {
                        for row in y..(y + tile.1).min(height) {
                            for column in x..(x + tile.0).min(width) {
                                let index = (row * width + column) as usize;
                                assert_eq!(film.pixels[place], before.pixels[index]);
                                assert_eq!(film.groups.get(place), before.groups.get(index));
                                assert_eq!(film.squares.get(place), before.squares.get(index));
                                place += 1;
                            }
                        }
                    }
                }
                reorder(&mut film, tile, Order::Rows);
                assert_eq!((film.pixels, film.squares, film.groups), (before.pixels, before.squares, before.groups));
            }
        }
    }
}
