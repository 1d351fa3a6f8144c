//! The film: per pixel, in f64, the sum of its samples and what tells its error, added in sample order.
//!
//! **Errors.** Independent samples tell the variance of their mean by their own spread, s^2 / n: a pixel has the sum of their
//! squares beside. Those of the `sobol` sampler do not: points of one group know of each other, and their mean is better than
//! that. So a pixel then has a sum for each of its four independent groups instead, and the spread of the groups' means tells.
//!
//! **Invariant:** a pixel's sums depend on its samples and their order alone, so the same bits come out of any number of
//! threads, any tile order and any split into passes.

pub mod checkpoint;
pub mod error;
pub mod layers;
pub mod part;
pub mod sums;

pub use error::{ErrorSums, RelativeError};
pub use sums::{GroupSums, Pixel, SquareSums, Sums, SumsMut};

use crate::error::Result;
use crate::files::memory;
use crate::settings::{Crop, Sampler};
use layers::Layers;

/// A sample that was not finite: where it arose. Such samples never reach the film's sums.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NonFinite {
    /// Column in the whole film.
    pub x: u32,
    /// Row in the whole film.
    pub y: u32,
    /// Sample number.
    pub sample: u32,
    /// The stage that first made a value that is not finite.
    pub stage: &'static str,
}

/// Where a crop lies in its film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The crop's first column.
    pub x: u32,
    /// The crop's first row.
    pub y: u32,
    /// Columns and rows of the whole film.
    pub film: (u32, u32),
}

/// Pixels whose values leave the range of f32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutOfRange {
    /// With a mean above the largest f32.
    pub means: usize,
    /// With a variance above the largest f32.
    pub large_variances: usize,
    /// With a variance below the smallest normal f32, but above 0.
    pub small_variances: usize,
}

/// How many samples pixels have where a render was stopped in the middle of a pass: each tile has samples of its own number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileCounts {
    /// Columns and rows of a tile; the last ones of a row or column may be cut.
    pub tile: (u32, u32),
    /// Samples in every pixel of each tile, tiles row by row.
    pub counts: Vec<u32>,
}

impl TileCounts {
    /// Tiles of a film of so many columns and rows.
    pub fn grid(tile: (u32, u32), (width, height): (u32, u32)) -> (u32, u32) {
        (width.div_ceil(tile.0), height.div_ceil(tile.1))
    }

    /// Samples of the pixel in column `x` of row `y`, of a film of `width` columns.
    fn at(&self, x: u32, y: u32, width: u32) -> u32 {
        let (columns, _) = TileCounts::grid(self.tile, (width, 1));
        self.counts[(y / self.tile.1) as usize * columns as usize + (x / self.tile.0) as usize]
    }
}

/// How OpenEXR files hold numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Encoding {
    /// Radiance, alpha, albedo and normals as f16: what is above 65,504 is cut to it. Depths and variances stay f32, whose range
    /// they need.
    pub half: bool,
    /// By ZIP, without loss, in blocks of 16 rows.
    pub zip: bool,
}

impl Encoding {
    /// The largest f16.
    pub const MOST_HALF: f32 = 65504.0;
}

/// The sums of a picture (or of a crop of it), row 0 at the top.
#[derive(Clone, Debug, Default)]
pub struct Film {
    /// Columns held.
    pub width: u32,
    /// Rows held.
    pub height: u32,
    /// Where these pixels lie in the film; `None`: they are all of it.
    pub place: Option<Place>,
    /// Samples in every pixel; where not all have as many, in those that have least.
    pub spp: u32,
    /// How many each has, if they have not equally many.
    pub uneven: Option<TileCounts>,
    /// `width * height` pixels, row by row.
    pub pixels: Vec<Pixel>,
    /// The pixels' sums of squares; empty where samples are not independent.
    pub squares: Vec<SquareSums>,
    /// The pixels' sums by group; empty where samples are independent.
    pub groups: Vec<GroupSums>,
    /// The settings of the render, as (key, value), written into EXR headers.
    pub metadata: Vec<(String, String)>,
    /// PNG exposure in stops; other formats hold radiance as it is.
    pub exposure: f64,
    /// What files hold beside radiance.
    pub layers: Layers,
    /// How OpenEXR files hold numbers.
    pub encoding: Encoding,
}

impl Film {
    /// An empty film for `crop` and samples that are independent.
    pub fn new(crop: Crop) -> Film {
        Film::of_sampler(crop, Sampler::Independent)
    }

    /// An empty film for `crop` and the samples of `sampler`.
    ///
    /// # Panics
    /// Where memory for it cannot be had; see [`Film::try_of_sampler`].
    pub fn of_sampler(crop: Crop, sampler: Sampler) -> Film {
        Film::try_of_sampler(crop, sampler).unwrap_or_else(|error| panic!("{error}"))
    }

    /// An empty film for `crop` and the samples of `sampler`.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if there is not enough for it.
    pub fn try_of_sampler(crop: Crop, sampler: Sampler) -> Result<Film> {
        let count = crop.width as usize * crop.height as usize;
        let (independent, grouped) = if sampler == Sampler::Sobol { (0, count) } else { (count, 0) };
        let what = format!("a film of {} x {} pixels", crop.width, crop.height);
        // As a whole, so that the message says what it takes; then table by table.
        memory::claim(Film::bytes(count, sampler), &what)?;
        Ok(Film {
            width: crop.width,
            height: crop.height,
            pixels: memory::table(count, &what)?,
            squares: memory::table(independent, &what)?,
            groups: memory::table(grouped, &what)?,
            ..Film::default()
        })
    }

    /// Bytes that the tables of so many pixels take.
    fn bytes(count: usize, sampler: Sampler) -> u64 {
        let beside = if sampler == Sampler::Sobol { size_of::<GroupSums>() } else { size_of::<SquareSums>() };
        (count as u64).saturating_mul((size_of::<Pixel>() + beside) as u64)
    }

    /// Samples of the pixel in column `x` of row `y`.
    pub fn spp_at(&self, x: u32, y: u32) -> u32 {
        self.uneven.as_ref().map_or(self.spp, |uneven| uneven.at(x, y, self.width))
    }

    /// How many samples pixels have, in words: `16`, or `16 to 32`.
    pub fn spp_in_words(&self) -> String {
        match self.most_spp() {
            most if most > self.spp => format!("{} to {most}", self.spp),
            _ => self.spp.to_string(),
        }
    }

    /// The most samples that a pixel has.
    pub fn most_spp(&self) -> u32 {
        self.uneven.iter().flat_map(|uneven| uneven.counts.iter().copied()).max().unwrap_or(self.spp)
    }

    /// Adds to pixel `index`, counted row by row, its sample number `sample`; true if it was finite, else it is left out (and
    /// still counts as a sample of value 0).
    pub fn add(&mut self, index: usize, sample: u32, radiance: [f32; 3]) -> bool {
        self.sums_mut().add(1.0, index, sample, radiance)
    }

    /// The film's sums, to be added to.
    pub fn sums_mut(&mut self) -> SumsMut<'_> {
        SumsMut { pixels: &mut self.pixels, squares: &mut self.squares, groups: &mut self.groups }
    }

    /// The film's sums.
    pub fn sums(&self) -> Sums<'_> {
        Sums { pixels: &self.pixels, squares: &self.squares, groups: &self.groups, spp: self.spp }
    }

    /// The mean of a pixel's samples: its radiance, rounded once to f32; the largest f32 where it is larger.
    pub fn mean(&self, x: u32, y: u32) -> [f32; 3] {
        let pixel = self.pixel(x, y);
        let spp = self.spp_at(x, y).max(1) as f64;
        pixel.sum.map(|sum| match sum / spp {
            mean if mean.is_finite() => (mean as f32).clamp(f32::MIN, f32::MAX),
            mean => mean as f32,
        })
    }

    /// The estimated variance of [`Film::mean`], per channel: s^2 / n, or by the spread of the groups' means; 0 where it is
    /// not known: below two samples, or four that are not independent. What leaves the range of f32 (squares do so soon: those
    /// of 2e19 above, of 1e-19 below) is its largest or its smallest normal number instead; see [`Film::out_of_range`].
    pub fn variance(&self, x: u32, y: u32) -> [f32; 3] {
        let sums = Sums { spp: self.spp_at(x, y), ..self.sums() };
        if !sums.tell_errors() {
            return [0.0; 3];
        }
        sums.variance(y as usize * self.width as usize + x as usize).map(|variance| match variance {
            0.0 => 0.0,
            _ => (variance as f32).clamp(f32::MIN_POSITIVE, f32::MAX),
        })
    }

    /// How many pixels of image files hold a bound of f32 in place of a value beyond it.
    pub fn out_of_range(&self) -> OutOfRange {
        let mut found = OutOfRange::default();
        for (index, pixel) in self.pixels.iter().enumerate() {
            let sums = Sums { spp: self.spp_of(index), ..self.sums() };
            let most = pixel.sum.iter().copied().fold(0.0, f64::max) / sums.spp.max(1) as f64;
            found.means += (most > f64::from(f32::MAX)) as usize;
            if sums.tell_errors() {
                let variance = sums.variance(index);
                found.large_variances += variance.iter().any(|&v| v > f64::from(f32::MAX)) as usize;
                found.small_variances += variance.iter().any(|&v| v > 0.0 && v < f64::from(f32::MIN_POSITIVE)) as usize;
            }
        }
        found
    }

    /// How many pixels are brighter than the largest f16, 65,504.
    pub fn beyond_half(&self) -> usize {
        let all = (0..self.height).flat_map(|y| (0..self.width).map(move |x| self.mean(x, y)));
        all.filter(|mean| mean.iter().any(|&value| value > Encoding::MOST_HALF)).count()
    }

    /// Samples of pixel `index`, counted row by row.
    fn spp_of(&self, index: usize) -> u32 {
        match &self.uneven {
            None => self.spp,
            Some(uneven) => {
                uneven.at((index % self.width as usize) as u32, (index / self.width as usize) as u32, self.width)
            }
        }
    }

    /// The mean radiance of the picture, per channel.
    pub fn mean_radiance(&self) -> [f64; 3] {
        if self.uneven.is_none() {
            let samples = self.pixels.len().max(1) as f64 * self.spp.max(1) as f64;
            return std::array::from_fn(|c| self.pixels.iter().map(|p| p.sum[c]).sum::<f64>() / samples);
        }
        let mean = |(index, pixel): (usize, &Pixel), c: usize| pixel.sum[c] / self.spp_of(index).max(1) as f64;
        let count = self.pixels.len().max(1) as f64;
        std::array::from_fn(|c| self.pixels.iter().enumerate().map(|pixel| mean(pixel, c)).sum::<f64>() / count)
    }

    /// The picture's estimated relative standard error: the root of (mean variance of a pixel's mean) over the mean
    /// radiance, channels averaged; `None` below two samples (four with the `sobol` sampler) or for a black picture.
    pub fn relative_error(&self) -> Option<f64> {
        self.relative_error_estimate().map(|(error, _)| error)
    }

    /// [`Film::relative_error`], and how far it may be from the error that this very picture has: a standard error. It
    /// comes from what the squared errors of so many pixels add up to by chance, each with twice the square of its variance
    /// (as normal means have), the channels of a pixel fully correlated.
    pub fn relative_error_estimate(&self) -> Option<(f64, f64)> {
        let Some(uneven) = &self.uneven else { return ErrorSums::of(self.sums()).estimate() };
        // Runs of pixels in a row that have equally many samples.
        let mut all = ErrorSums::default();
        let sums = self.sums();
        for y in 0..self.height {
            for x in (0..self.width).step_by(uneven.tile.0 as usize) {
                let start = y as usize * self.width as usize + x as usize;
                let run = start..start + (self.width - x).min(uneven.tile.0) as usize;
                all.add(&ErrorSums::of(Sums {
                    pixels: &sums.pixels[run.clone()],
                    squares: sums.squares.get(run.clone()).unwrap_or_default(),
                    groups: sums.groups.get(run).unwrap_or_default(),
                    spp: self.spp_at(x, y),
                }));
            }
        }
        all.estimate()
    }

    fn pixel(&self, x: u32, y: u32) -> &Pixel {
        &self.pixels[y as usize * self.width as usize + x as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_estimate_matches_numbers_worked_by_hand() {
        let mut film = Film::new(Crop { x: 0, y: 0, width: 2, height: 1 });
        film.spp = 2;
        assert_eq!(film.relative_error_estimate(), None);
        // Pixel 0: samples 1 and 3, variance of the mean 2 / 2 = 1. Pixel 1: samples 2 and 2, variance 0.
        for (pixel, samples) in [(0, [1.0, 3.0]), (1, [2.0, 2.0])] {
            assert!((0..).zip(samples).all(|(sample, value)| film.add(pixel, sample, [value; 3])));
        }
        assert_eq!(film.variance(0, 0), [1.0; 3]);
        // Mean variance 1/2, mean 2; the squared errors, expected to be 1 and 0, have the variances 2 and 0.
        let (error, standard_error) = film.relative_error_estimate().unwrap();
        assert!((error - 0.5f64.sqrt() / 2.0).abs() < 1e-12);
        assert!((standard_error - 0.5 * 2f64.sqrt() * error).abs() < 1e-12);
    }

    #[test]
    fn pixels_of_unequal_counts_are_each_divided_by_their_own() {
        // Two tiles of one column: the first has samples 1 and 3, the second 2, 4, 6 and 8.
        let mut film = Film::new(Crop { x: 0, y: 0, width: 2, height: 1 });
        for (pixel, samples) in [(0, &[1.0, 3.0][..]), (1, &[2.0, 4.0, 6.0, 8.0])] {
            assert!((0..).zip(samples).all(|(sample, value)| film.add(pixel, sample, [*value; 3])));
        }
        film.spp = 2;
        film.uneven = Some(TileCounts { tile: (1, 1), counts: vec![2, 4] });
        assert_eq!((film.mean(0, 0), film.mean(1, 0), film.most_spp()), ([2.0; 3], [5.0; 3], 4));
        // Variances of the means: 2 / 2 and (9 + 1 + 1 + 9) / 3 / 4.
        assert_eq!((film.variance(0, 0), film.variance(1, 0)), ([1.0; 3], [20.0 / 12.0; 3]));
        assert_eq!(film.mean_radiance(), [3.5; 3]);
        let error = film.relative_error().unwrap();
        assert!((error - ((1.0 + 20.0 / 12.0) / 2.0f64).sqrt() / 3.5).abs() < 1e-12);
        // A tile without a sample is black.
        film.uneven = Some(TileCounts { tile: (1, 1), counts: vec![2, 0] });
        assert!(film.mean(1, 0)[0].is_finite() && film.variance(1, 0) == [0.0; 3]);
    }

    #[test]
    fn a_film_that_no_machine_holds_is_refused() {
        let crop = Crop { x: 0, y: 0, width: u32::MAX, height: u32::MAX };
        let refused = Film::try_of_sampler(crop, Sampler::Sobol).unwrap_err().to_string();
        assert!(refused.starts_with("a film of 4294967295 x 4294967295 pixels needs "), "{refused}");
    }

    #[test]
    fn what_f32_cannot_hold_saturates_and_is_counted() {
        // Two samples, 0 and 2 s, have the mean s and the variance of the mean s^2.
        let of = |s: f32| {
            let mut film = Film { spp: 2, ..Film::new(Crop { x: 0, y: 0, width: 1, height: 1 }) };
            assert!(film.add(0, 0, [0.0; 3]) && film.add(0, 1, [0.0, s, 2.0 * s]));
            let ([_, _, mean], [none, half, variance]) = (film.mean(0, 0), film.variance(0, 0));
            assert!(none == 0.0 && half.is_finite() && half > 0.0 && half <= variance, "{s}: {half} {variance}");
            (mean, variance, film.out_of_range())
        };
        let fine = OutOfRange::default();
        assert_eq!(of(1.0), (1.0, 1.0, fine));
        for s in [1e18, 1.8e19, 2.3e-19, 1e-10] {
            let (mean, variance, found) = of(s);
            assert_eq!((mean, variance, found), (s, (f64::from(s) * f64::from(s)) as f32, fine), "{s}");
        }
        let (large, small) = (OutOfRange { large_variances: 1, ..fine }, OutOfRange { small_variances: 1, ..fine });
        for s in [2e19, 1e25, 1e30, 1.7e38] {
            assert_eq!(of(s), (s, f32::MAX, large), "{s}");
        }
        for s in [1e-19, 1e-25, 1e-38, 1e-45] {
            assert_eq!(of(s), (s, f32::MIN_POSITIVE, small), "{s}");
        }
        // Samples in a unit of their own may be brighter than any f32.
        let mut film = Film { spp: 1, ..Film::new(Crop { x: 0, y: 0, width: 1, height: 1 }) };
        let mut sums = film.sums_mut();
        assert!(sums.add(2f64.powi(60), 0, 0, [1e30; 3]) && !sums.add(2.0, 0, 1, [f32::NAN; 3]));
        assert_eq!((film.mean(0, 0), film.out_of_range()), ([f32::MAX; 3], OutOfRange { means: 1, ..fine }));
    }

    #[test]
    fn a_pixel_takes_what_its_error_needs_and_no_more() {
        let bytes = |sampler: Sampler| {
            let film = Film::of_sampler(Crop { x: 0, y: 0, width: 30, height: 10 }, sampler);
            let squares = film.squares.capacity() * size_of::<SquareSums>();
            let tables = film.pixels.capacity() * size_of::<Pixel>() + squares;
            (tables + film.groups.capacity() * size_of::<GroupSums>()) / 300
        };
        assert_eq!([Sampler::Independent, Sampler::Sobol].map(bytes), [48, 120]);
    }

    #[test]
    fn groups_tell_the_error_by_their_means() {
        let crop = Crop { x: 0, y: 0, width: 1, height: 1 };
        let film = |samples: &[f32]| {
            let mut film = Film::of_sampler(crop, Sampler::Sobol);
            film.spp = samples.len() as u32;
            for (number, &value) in samples.iter().enumerate() {
                assert!(film.add(0, number as u32, [value; 3]));
            }
            film
        };
        // Three samples say nothing, though they differ; independent ones would.
        let three = film(&[1.0, 2.0, 4.0]);
        assert_eq!((three.variance(0, 0), three.relative_error()), ([0.0; 3], None));
        // Groups (1, 7), (2, 6), (3, 5), (2, 2): means 4, 4, 4, 2 about 3.5; (3 * 0.25 + 2.25) / 3 / 4 = 0.25.
        let eight = film(&[1.0, 2.0, 3.0, 2.0, 7.0, 6.0, 5.0, 2.0]);
        assert_eq!(eight.variance(0, 0), [0.25; 3]);
        assert!((eight.relative_error().unwrap() - 0.5 / 3.5).abs() < 1e-12);
        // Groups (4, 8), (2), (2), (4): means 6, 2, 2, 4 about 4; (2 * 4 + 4 + 4 + 0) / 3 / 5.
        let five = film(&[4.0, 2.0, 2.0, 4.0, 8.0]);
        assert_eq!(five.variance(0, 0), [(16.0f64 / 15.0) as f32; 3]);
    }
}
