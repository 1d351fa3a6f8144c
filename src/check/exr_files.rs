//! The film's values through an EXR file.

use crate::check::item::{Check, Effort};
use crate::check::numbers::{Numbers, worse};
use crate::check::row::Outcome;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::image::Image;
use crate::settings::Crop;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "film", what: "means_read_back", run: means_read_back },
    Check { group: "film", what: "variances_read_back", run: variances_read_back },
];

/// A film of a 25th of every magnitude: pixel `i` has samples about 10^(i - 25) that spread by half.
fn all_magnitudes() -> Film {
    let mut film = Film::new(Crop { x: 0, y: 0, width: 51, height: 1 });
    film.spp = 16;
    let mut numbers = Numbers::new(9);
    for i in 0..51 {
        for sample in 0..16 {
            let value = 10f64.powi(i as i32 - 25) * (0.5 + numbers.fine());
            film.add(i, sample, [value as f32; 3]);
        }
    }
    film
}

/// A film written to an EXR file and read again.
fn read_back(film: &Film) -> Result<Image> {
    let failed = |error: std::io::Error| Error::Usage(format!("no temporary directory: {error}"));
    let directory = tempfile::tempdir().map_err(failed)?;
    let path = directory.path().join("film.exr");
    film.save(&path)?;
    Image::read(&path)
}

fn means_read_back(_: &Effort) -> Result<Outcome> {
    let film = all_magnitudes();
    let image = read_back(&film)?;
    let differs = |x: &u32| image.pixel(*x, 0).map(f32::to_bits) != film.mean(*x, 0).map(f32::to_bits);
    let wrong = (0..film.width).filter(differs).count();
    let sums = (0..film.width as usize).filter(|&i| {
        let wanted = film.pixels[i].sum[0] / 16.0;
        worse((f64::from(image.pixels[i][0]) / wanted - 1.0).abs(), 1e-7)
    });
    Ok(Outcome::at_most((wrong + sums.count()) as f64, 0.0)
        .tried(u64::from(film.width), "means of 1e-25 to 1e25 through an EXR file, those that changed"))
}

/// Variances of radiance 1e-25 to 1e25 come back as positive finite numbers: those within f32 as they are, those beyond as
/// its ends.
fn variances_read_back(_: &Effort) -> Result<Outcome> {
    let film = all_magnitudes();
    let image = read_back(&film)?;
    let Some(variances) = &image.variance else {
        return Ok(Outcome::impossible("the file has no variance"));
    };
    let mut wrong = Vec::new();
    for (i, (pixel, squares)) in film.pixels.iter().zip(&film.squares).enumerate() {
        let squares = squares.0[0] - pixel.sum[0] * pixel.sum[0] / 16.0;
        let wanted = (squares / 15.0 / 16.0).clamp(1e-45, f64::from(f32::MAX));
        let got = f64::from(variances[i][0]);
        let fits = (f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX)).contains(&wanted);
        let right = if fits { (got / wanted - 1.0).abs() < 1e-6 } else { got > 0.0 && got.is_finite() };
        if !right {
            wrong.push(format!("1e{}: {got:e}", i as i32 - 25));
        }
    }
    Ok(Outcome::at_most(wrong.len() as f64, 0.0)
        .tried(u64::from(film.width), "variances of radiance 1e-25 to 1e25 through an EXR file, wrong ones")
        .note(wrong.join(", ")))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] =
    &[(crate::fault::Fault::RoundedFile, &["film/means_read_back", "film/variances_read_back"])];
