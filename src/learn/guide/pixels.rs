//! What pixels are expected to show, from the paths of a pilot.

use crate::learn::guide::records::UNIT;

/// To the expected image this part of its mean is added: black pixels are no reason to follow paths for ever. (0.02 and 0.3 are
/// 5 % less efficient.)
const LEAST_OF_MEAN: f64 = 0.1;

/// One over what the pixels of a grid are expected to show, from the sums of `spp` samples of each
/// ([`crate::learn::guide::records::GuideRecords::image`]): the paths' mean, spread over some pixels as long as it is noisy, and
/// a part of the whole image's mean.
pub fn inverse_pixels(sums: &[u64], grid: (u32, u32), spp: u32) -> Vec<f32> {
    let radius = match spp {
        0..8 => 3,
        8..32 => 2,
        _ => 1,
    };
    let (columns, rows) = (grid.0 as usize, grid.1 as usize);
    let scale = 1.0 / (UNIT as f64 * f64::from(spp.max(1)));
    let sums: Vec<f64> = sums.iter().map(|&sum| sum as f64 * scale).collect();
    let mean = sums.iter().sum::<f64>() / sums.len() as f64;
    // Rows first, then columns: a square's mean is that of its rows' means.
    let range = |at: usize, end: usize| at.saturating_sub(radius)..(at + radius + 1).min(end);
    let mean_of = |values: &mut dyn Iterator<Item = f64>, count: usize| values.sum::<f64>() / count as f64;
    let by_row = |i: usize| {
        let (y, near) = (i / columns, range(i % columns, columns));
        mean_of(&mut near.clone().map(|x| sums[y * columns + x]), near.len())
    };
    let blurred: Vec<f64> = (0..columns * rows).map(by_row).collect();
    let inverse = |i: usize| {
        let (x, near) = (i % columns, range(i / columns, rows));
        let shown = mean_of(&mut near.clone().map(|y| blurred[y * columns + x]), near.len());
        let shown = shown + LEAST_OF_MEAN * mean;
        if shown > 0.0 { (1.0 / shown).min(f64::from(f32::MAX)) as f32 } else { 0.0 }
    };
    (0..columns * rows).map(inverse).collect()
}
