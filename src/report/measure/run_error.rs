//! The error of one run, in the parts that statistics need: by tile and by region.

use serde::{Deserialize, Serialize};

use crate::image::Image;
use crate::report::measure::metrics::{FLOOR, variance_of_channel_mean};
use crate::settings::Crop;

/// The image is cut into this many columns and rows of tiles, the strata of all intervals.
pub const TILES: usize = 32;

/// The tile of pixel `i` of an image of `width` by `height` pixels.
pub fn tile_of(i: usize, width: usize, height: usize) -> usize {
    let (x, y) = (i % width, i / width);
    y * TILES / height * TILES + x * TILES / width
}

/// Of so many pixels, the one with the largest relative error is left out of the trimmed relMSE.
pub const TRIMMED: usize = 1000;

/// A named part of the film.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// What it shows.
    pub name: String,
    /// Where it is.
    pub area: Crop,
}

/// The error of an image. Noise of the reference is subtracted and nothing is cut at 0, so means over runs are unbiased.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Mean squared error.
    pub mse: f64,
    /// Relative mean squared error.
    pub relmse: f64,
    /// relMSE of the pixels but for the worst of every [`TRIMMED`]: what a few outliers do not decide.
    pub relmse_trimmed: f64,
    /// Mean of image - reference over pixels and channels.
    pub bias: f64,
    /// Standard error of `bias`.
    pub bias_se: f64,
    /// relMSE by region.
    pub regions: Vec<f64>,
    /// What each tile adds to `mse`.
    pub mse_by_tile: Vec<f64>,
    /// What each tile adds to `relmse`.
    pub relmse_by_tile: Vec<f64>,
}

impl Measured {
    /// The score of the bias; 0 where image and reference agree exactly.
    pub fn bias_z(&self) -> f64 {
        if self.bias_se > 0.0 { self.bias / self.bias_se } else { 0.0 }
    }
}

/// Measures `image` against `reference`, which has the same size and finite values.
pub fn measure(image: &Image, reference: &Image, regions: &[Region]) -> Measured {
    let (width, height) = (image.width as usize, image.height as usize);
    let share = 1.0 / (3.0 * image.pixels.len() as f64);
    let mut mse_by_tile = vec![0.0; TILES * TILES];
    let mut relmse_by_tile = vec![0.0; TILES * TILES];
    let mut by_region = vec![0.0; regions.len()];
    let (mut bias, mut residual) = (0.0, 0.0);
    let mut by_pixel = Vec::with_capacity(image.pixels.len());
    for (i, (a, b)) in image.pixels.iter().zip(&reference.pixels).enumerate() {
        let (x, y) = (i % width, i / width);
        let tile = tile_of(i, width, height);
        let noise = reference.variance.as_ref().map_or([0.0; 3], |variance| variance[i]);
        let (mut squares, mut relative, mut difference) = (0.0, 0.0, 0.0);
        for c in 0..3 {
            let (value, truth) = (a[c] as f64, b[c] as f64);
            let square = (value - truth).powi(2) - noise[c] as f64;
            squares += square;
            relative += square / (truth * truth + FLOOR);
            difference += (value - truth) / 3.0;
        }
        mse_by_tile[tile] += squares * share;
        relmse_by_tile[tile] += relative * share;
        by_pixel.push(relative / 3.0);
        bias += difference;
        residual += difference * difference;
        for (sum, region) in by_region.iter_mut().zip(regions) {
            *sum += if inside(region.area, x as u32, y as u32) { relative } else { 0.0 };
        }
    }
    let pixels = image.pixels.len() as f64;
    for (sum, region) in by_region.iter_mut().zip(regions) {
        *sum /= 3.0 * region.area.width as f64 * region.area.height as f64;
    }
    Measured {
        mse: mse_by_tile.iter().sum(),
        relmse: relmse_by_tile.iter().sum(),
        relmse_trimmed: trimmed_mean(by_pixel),
        bias: bias / pixels,
        bias_se: known_variance(image, reference).unwrap_or(residual).sqrt() / pixels,
        regions: by_region,
        mse_by_tile,
        relmse_by_tile,
    }
}

/// The mean of all but the largest of every [`TRIMMED`] values, at least one.
fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    let kept = values.len() - values.len().div_ceil(TRIMMED);
    if kept == 0 {
        return 0.0;
    }
    let (smaller, ..) = values.select_nth_unstable_by(kept, f64::total_cmp);
    smaller.iter().sum::<f64>() / kept as f64
}

fn inside(area: Crop, x: u32, y: u32) -> bool {
    (area.x..area.x + area.width).contains(&x) && (area.y..area.y + area.height).contains(&y)
}

/// Sum over pixels of the variance of (image - reference), channels averaged. `None` where the image's own is unknown
/// (a sample a pixel): then the squared differences stand for it, which overstates it where there is bias, so a score
/// errs towards 0.
fn known_variance(image: &Image, reference: &Image) -> Option<f64> {
    let sum = |image: &Image| image.variance.as_ref().map(|v| v.iter().map(variance_of_channel_mean).sum::<f64>());
    let own = sum(image).filter(|sum| *sum > 0.0)?;
    Some(own + sum(reference).unwrap_or(0.0))
}

/// The mean of the biases of runs against one reference, weighed by the inverse of their variances, and its standard error.
/// `of_reference` is the part of each variance that the reference's noise makes: it is the same in all runs, and counts once.
pub fn mean_bias<'a>(runs: impl Iterator<Item = &'a Measured>, of_reference: f64) -> (f64, f64) {
    let (mut count, mut plain, mut sum, mut weights) = (0.0, 0.0, 0.0, 0.0);
    for run in runs {
        count += 1.0;
        plain += run.bias;
        let own = run.bias_se * run.bias_se - of_reference;
        if own > 0.0 {
            sum += run.bias / own;
            weights += 1.0 / own;
        }
    }
    match weights > 0.0 {
        true => (sum / weights, (1.0 / weights + of_reference).sqrt()),
        false => (plain / f64::max(count, 1.0), of_reference.sqrt()),
    }
}

/// Independent parts of a [`Pool`]: three, the least whose spread tells an error in every tile by itself.
pub const PARTS: usize = 3;

/// Images of one configuration added up, each as often as it has samples: the least noisy image all runs make together,
/// in [`PARTS`] independent parts. Repeats take parts in turn.
#[derive(Clone, Debug, Default)]
pub struct Pool {
    /// Samples a pixel in each part.
    samples: [f64; PARTS],
    /// By part, the sum of samples x image.
    sums: [Vec<[f64; 3]>; PARTS],
    /// Over all parts: sum of samples^2 x variance of the mean.
    variance: Vec<[f64; 3]>,
}

impl Pool {
    /// Empty, for images of so many pixels.
    pub fn new(pixels: usize) -> Pool {
        let zeros = || vec![[0.0; 3]; pixels];
        Pool { samples: [0.0; PARTS], sums: std::array::from_fn(|_| zeros()), variance: zeros() }
    }

    /// Adds the image of one repeat, of `spp` samples a pixel, if it knows its variance.
    pub fn add(&mut self, image: &Image, repeat: u32, spp: u32) {
        let Some(variance) = image.variance.as_ref().filter(|_| spp > 1) else { return };
        let (weight, part) = (spp as f64, repeat as usize % PARTS);
        self.samples[part] += weight;
        for (i, (pixel, variance)) in image.pixels.iter().zip(variance).enumerate() {
            for c in 0..3 {
                self.sums[part][i][c] += weight * pixel[c] as f64;
                self.variance[i][c] += weight * weight * variance[c] as f64;
            }
        }
    }

    /// Adds the images of another pool of as many pixels.
    pub fn take(&mut self, other: &Pool) {
        let add = |to: &mut [[f64; 3]], from: &[[f64; 3]]| {
            to.as_flattened_mut().iter_mut().zip(from.as_flattened()).for_each(|(to, from)| *to += from);
        };
        for part in 0..PARTS {
            self.samples[part] += other.samples[part];
            add(&mut self.sums[part], &other.sums[part]);
        }
        add(&mut self.variance, &other.variance);
    }

    /// Everything in it, as numbers; see [`Pool::from_numbers`].
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let sums = self.sums.iter().chain([&self.variance]).flatten().flatten().copied();
        self.samples.iter().copied().chain(sums)
    }

    /// How many numbers a pool of so many pixels has.
    pub fn count_of_numbers(pixels: usize) -> usize {
        PARTS + 3 * (PARTS + 1) * pixels
    }

    /// The pool that [`Pool::numbers`] told, of [`Pool::count_of_numbers`] of them.
    pub fn from_numbers(numbers: &[f64]) -> Pool {
        let (samples, rest) = numbers.split_at(PARTS.min(numbers.len()));
        let each = (rest.len() / (PARTS + 1)).max(1);
        let mut columns = rest.chunks(each).map(|column| column.as_chunks().0.to_vec());
        let mut next = || columns.next().unwrap_or_default();
        Pool {
            samples: std::array::from_fn(|part| samples.get(part).copied().unwrap_or(0.0)),
            sums: std::array::from_fn(|_| next()),
            variance: next(),
        }
    }

    /// Samples a pixel in it.
    pub fn samples(&self) -> f64 {
        self.samples.iter().sum()
    }

    /// The image and its variance; `None` if there is none.
    pub fn image(&self, width: u32, height: u32) -> Option<Image> {
        let samples = self.samples();
        if samples == 0.0 {
            return None;
        }
        let sum = |i: usize, c: usize| self.sums.iter().map(|sums| sums[i][c]).sum::<f64>();
        let pixel = |i: usize| std::array::from_fn(|c| (sum(i, c) / samples) as f32);
        let pixels = (0..self.variance.len()).map(pixel).collect();
        let variance = self.variance.iter().map(|sum| sum.map(|v| (v / samples.powi(2)) as f32)).collect();
        Some(Image { width, height, pixels, variance: Some(variance), ..Image::default() })
    }

    /// The parts that have samples: how many, and the sum of samples x image of pixel `i`, channel `c`.
    pub fn parts(&self) -> impl Iterator<Item = (f64, &[[f64; 3]])> {
        let parts = self.samples.iter().copied().zip(self.sums.iter().map(Vec::as_slice));
        parts.filter(|(samples, _)| *samples > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::measure::metrics::compare;
    use crate::sampler::{random_words, unit};

    fn noisy(seed: u32, width: u32, height: u32, variance: f32) -> Image {
        let value = |i: u32| {
            let [r, g, b, _] = random_words(i, 0, 0, seed).map(unit);
            [1.0, 2.0, 0.5].iter().zip([r, g, b]).map(|(mean, u)| mean + (u - 0.5) * (12.0 * variance).sqrt())
        };
        let pixel = |i: u32| {
            let values: Vec<f32> = value(i).collect();
            [values[0], values[1], values[2]]
        };
        let count = width * height;
        Image {
            width,
            height,
            pixels: (0..count).map(pixel).collect(),
            variance: Some(vec![[variance; 3]; count as usize]),
            ..Image::default()
        }
    }

    #[test]
    fn tiles_and_regions_add_up_to_the_whole() {
        let (a, b) = (noisy(1, 37, 21, 0.01), noisy(2, 37, 21, 0.0001));
        let halves = [Crop { x: 0, y: 0, width: 20, height: 21 }, Crop { x: 20, y: 0, width: 17, height: 21 }];
        let regions = halves.map(|area| Region { name: String::new(), area });
        let (found, whole) = (measure(&a, &b, &regions), compare(&a, &b).unwrap());
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        near(found.mse, whole.mse_raw - whole.noise_mse);
        near(found.relmse, whole.relmse_raw - whole.noise_relmse);
        near(found.bias, whole.bias);
        near(found.bias_se, whole.bias_se.unwrap());
        near((found.regions[0] * 20.0 + found.regions[1] * 17.0) / 37.0, found.relmse);
    }

    #[test]
    fn a_few_outliers_do_not_decide_the_trimmed_error() {
        let truth = noisy(2, 64, 64, 0.0);
        let mut image = noisy(1, 64, 64, 0.01);
        let calm = measure(&image, &truth, &[]);
        image.pixels[77] = [1e4; 3];
        let found = measure(&image, &truth, &[]);
        assert!(found.relmse > 1e3 && found.relmse_trimmed < calm.relmse && found.relmse_trimmed > 0.97 * calm.relmse);
        // 4096 pixels: the largest five are left out.
        let values: Vec<f64> = (0..4096).map(|i| ((i * 2049) % 4096) as f64).collect();
        assert_eq!(trimmed_mean(values), (0..4091).sum::<u32>() as f64 / 4091.0);
        assert_eq!((trimmed_mean(vec![3.0]), trimmed_mean(vec![5.0, 1.0])), (0.0, 1.0));
    }

    #[test]
    fn the_noise_of_the_reference_vanishes_on_average() {
        // Truth 1, 2, 0.5; image and reference both with noise 0.01: what is left is the image's.
        let mse = |seed: u32| measure(&noisy(seed, 64, 64, 0.01), &noisy(seed + 100, 64, 64, 0.01), &[]).mse;
        let mean = (0..20).map(mse).sum::<f64>() / 20.0;
        // 20 x 12288 squares of a deviation of 0.02: a standard error of 0.00004.
        assert!((mean - 0.01).abs() < 1.5e-4, "{mean}");
    }

    #[test]
    fn without_variance_the_differences_stand_for_it() {
        let mut a = noisy(3, 64, 64, 0.01);
        let truth = noisy(4, 64, 64, 0.0);
        let known = measure(&a, &truth, &[]).bias_se;
        a.variance = Some(vec![[0.0; 3]; 4096]);
        let told = measure(&a, &truth, &[]).bias_se;
        // The channels of this noise are independent: a third of the variance that full correlation would have.
        assert!((told * 3f64.sqrt() / known - 1.0).abs() < 0.05, "{told} {known}");
        assert_eq!(measure(&truth, &truth, &[]).bias_z(), 0.0);
    }

    #[test]
    fn the_reference_counts_once_in_the_bias_of_many_runs() {
        let blank = measure(&noisy(1, 1, 1, 0.0), &noisy(1, 1, 1, 0.0), &[]);
        let run = |bias: f64, bias_se: f64| Measured { bias, bias_se, ..blank.clone() };
        // Own variances 1 and 3, the reference's 0.5: weights 1 and 1 / 3.
        let runs = [run(1.0, 1.5f64.sqrt()), run(5.0, 3.5f64.sqrt())];
        let (mean, error) = mean_bias(runs.iter(), 0.5);
        assert!((mean - 2.0).abs() < 1e-12 && (error - (0.75f64 + 0.5).sqrt()).abs() < 1e-12, "{mean} {error}");
        assert_eq!(mean_bias([run(1.0, 0.0), run(3.0, 0.0)].iter(), 0.0), (2.0, 0.0));
    }

    #[test]
    fn a_pool_weighs_pictures_by_their_samples() {
        let mut pool = Pool::new(1);
        let one = |value: f32, variance: f32| Image {
            width: 1,
            height: 1,
            pixels: vec![[value; 3]],
            variance: Some(vec![[variance; 3]]),
            ..Image::default()
        };
        assert!(pool.image(1, 1).is_none());
        pool.add(&one(100.0, 0.0), 0, 1);
        pool.add(&one(1.0, 0.5), 0, 2);
        pool.add(&one(3.0, 0.25), 4, 6);
        let image = pool.image(1, 1).unwrap();
        let again = Pool::from_numbers(&pool.numbers().collect::<Vec<_>>());
        assert_eq!(again.image(1, 1), Some(image.clone()));
        assert_eq!(pool.numbers().count(), Pool::count_of_numbers(1));
        assert_eq!((image.pixels[0], pool.samples()), ([2.5; 3], 8.0));
        let parts: Vec<(f64, [f64; 3])> = pool.parts().map(|(samples, sums)| (samples, sums[0])).collect();
        assert_eq!(parts, [(2.0, [2.0; 3]), (6.0, [18.0; 3])]);
        assert_eq!(image.variance.unwrap()[0], [(4.0 * 0.5 + 36.0 * 0.25) / 64.0; 3]);
    }
}
