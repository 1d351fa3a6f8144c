//! The training render: a small picture of the whole film, in passes of doubling length, thrown away.

use crate::settings::Train;

/// Samples a pixel of the grid up to which each pass goes; after each, tables are made anew of all records so far.
pub const PASSES: [u32; 5] = [1, 2, 4, 8, 16];
/// What the seed is combined with (exclusive or), so that no sample of the picture shares a number with the pilot's.
pub const SCRAMBLE: u32 = 0x5bd1_e995;
/// Most pixels of the grid, unless asked otherwise: 65,536 paths, 1.6 % of a picture of 128 x 128 pixels at 256 samples. (Half
/// and twice as many paths were as good.)
const PIXELS: u64 = 4096;
/// The longest side of a grid: a pixel's address has 16 bits an axis.
const MOST_SIDE: u64 = 1 << 14;

/// A render is guided if the second moment of what paths bring after their bounces at diffuse surfaces, over what their pixels
/// show, is this much at least: there is much indirect light, and it is hard to find. (Scenes where guiding gains have 3.2 to 32,
/// others 0.04 to 0.8.)
pub const LEAST_INDIRECT: f64 = 1.5;

/// Samples a pixel of the grid up to which directions are learned for a film of this size, where they are used: 262,144 paths
/// over 64 x 64 pixels, twice as many where the film is large. (In a room lit through a door ajar twice as many gain a quarter
/// of the variance; where light is easily found, they cost more than they gain in a small film.)
pub fn guided_samples((columns, rows): (u32, u32)) -> u32 {
    if u64::from(columns) * u64::from(rows) < 1 << 16 { 64 } else { 128 }
}

/// Columns and rows of the grid for a film of so many; `None`: nothing is learned. It has about as many pixels as asked, not
/// more than the film, and about the film's shape; it always covers the whole film.
pub fn grid(train: Train, film: (u32, u32)) -> Option<(u32, u32)> {
    let pixels = match train {
        Train::Off => return None,
        Train::Auto => PIXELS.min(u64::from(film.0) * u64::from(film.1)),
        Train::Paths(paths) => u64::from(paths / PASSES[PASSES.len() - 1]).max(1),
    };
    Some(shaped(pixels, film))
}

/// Columns and rows of about the shape of a film, not more than `pixels` in all.
fn shaped(pixels: u64, film: (u32, u32)) -> (u32, u32) {
    let (width, height) = (u64::from(film.0), u64::from(film.1));
    // The largest whole root: no rounding of f64 decides anything.
    let columns = (pixels * width / height).isqrt().clamp(1, pixels.min(MOST_SIDE));
    let rows = (pixels / columns).clamp(1, MOST_SIDE);
    (columns as u32, rows as u32)
}

/// Least and most paths of the pilot of one frame of a sequence, unless asked otherwise; between them, a quarter of the film's
/// pixels.
const FRAME_PATHS: [u64; 2] = [4096, 32_768];

/// The grid of the pilot of one frame of a sequence, of which `frames` add up, and its samples a pixel; `None`: nothing is
/// learned.
pub fn frame_grid(train: Train, film: (u32, u32), frames: u32) -> Option<((u32, u32), u32)> {
    let pixels = u64::from(film.0) * u64::from(film.1);
    let paths = match train {
        Train::Off => return None,
        Train::Auto => (pixels / 4).clamp(FRAME_PATHS[0], FRAME_PATHS[1]),
        Train::Paths(paths) => u64::from(paths / frames).max(1),
    };
    let grid = shaped(PIXELS.min(pixels).min(paths), film);
    let spp = paths / (u64::from(grid.0) * u64::from(grid.1));
    Some((grid, spp.clamp(1, u64::from(u32::MAX)) as u32))
}

/// Paths of the pilot over a grid.
pub fn paths((columns, rows): (u32, u32)) -> u64 {
    u64::from(columns) * u64::from(rows) * u64::from(PASSES[PASSES.len() - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_have_the_shape_of_the_film_and_the_size_asked_for() {
        assert_eq!(grid(Train::Auto, (512, 512)), Some((64, 64)));
        assert_eq!(grid(Train::Auto, (1920, 1080)), Some((85, 48)));
        assert_eq!(grid(Train::Auto, (8, 8)), Some((8, 8)));
        assert_eq!(grid(Train::Auto, (65_535, 1)), Some((4096, 1)));
        assert_eq!(grid(Train::Auto, (1, 65_535)), Some((1, 4096)));
        assert_eq!(grid(Train::Paths(4096), (100, 100)), Some((16, 16)));
        assert_eq!(grid(Train::Paths(1), (100, 100)), Some((1, 1)));
        assert_eq!(grid(Train::Off, (100, 100)), None);
        for train in [Train::Auto, Train::Paths(7), Train::Paths(100_000), Train::Paths(u32::MAX)] {
            for film in [(1, 1), (3, 1000), (1000, 3), (65_535, 65_535), (1, 65_535), (640, 480)] {
                let (columns, rows) = grid(train, film).unwrap();
                assert!((1..=1 << 14).contains(&columns) && (1..=1 << 14).contains(&rows), "{train} {film:?}");
                let asked = if let Train::Paths(paths) = train { u64::from(paths).max(16) } else { 65_536 };
                assert!(paths((columns, rows)) <= asked, "{train} {film:?}");
            }
        }
    }
}
