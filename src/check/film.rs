//! The film: many samples, large among small, variances.

use crate::check::item::{Check, Effort};
use crate::check::numbers::{Exact, Numbers, worse};
use crate::check::row::Outcome;
use crate::check::trial::{Trial, small};
use crate::error::Result;
use crate::film::Film;
use crate::settings::{Crop, Sampler, Settings};

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "film", what: "many_samples", run: many_samples },
    Check { group: "film", what: "large_among_small", run: large_among_small },
    Check { group: "film", what: "variance_of_many", run: variance_of_many },
    Check { group: "film", what: "variance_of_groups", run: variance_of_groups },
    Check { group: "film", what: "not_finite_left_out", run: not_finite_left_out },
    Check { group: "film", what: "passes_leave_no_trace", run: passes_leave_no_trace },
];

/// A film of one pixel with these samples.
fn film_of(sampler: Sampler, samples: impl Iterator<Item = f32>) -> Film {
    let mut film = Film::of_sampler(Crop { x: 0, y: 0, width: 1, height: 1 }, sampler);
    for (number, value) in samples.enumerate() {
        film.add(0, number as u32, [value; 3]);
        film.spp += 1;
    }
    film
}

/// Samples over twelve decades.
fn samples(seed: u32, count: u64) -> impl Iterator<Item = f32> + Clone {
    (0..count).map(move |i| {
        let mut numbers = Numbers::new(seed.wrapping_mul(0x9E37_79B9) ^ i as u32);
        numbers.magnitude(-6.0, 6.0) as f32
    })
}

/// The sum of a pixel against a compensated one.
fn many_samples(effort: &Effort) -> Result<Outcome> {
    let count = effort.cases(1_000_000).min(1 << 31);
    let film = film_of(Sampler::Independent, samples(1, count));
    let mut exact = Exact::default();
    samples(1, count).for_each(|value| exact.add(f64::from(value)));
    let error = (film.pixels[0].sum[0] / exact.total() - 1.0).abs();
    Ok(Outcome::at_most(error, 1e-12).tried(count, "samples of 1e-6 to 1e6 in a pixel, its sum against the exact one"))
}

/// One sample of 1e12 after many of 1e-6: what those have added is kept. (What comes after it has steps of 1.2e-4.)
fn large_among_small(effort: &Effort) -> Result<Outcome> {
    let count = effort.cases(1_000_000).min(1 << 31);
    let one = |i: u64| if i + 1 == count { 1e12f32 } else { 1e-6 };
    let film = film_of(Sampler::Independent, (0..count).map(one));
    let wanted = (count - 1) as f64 * f64::from(1e-6f32);
    let rest = film.pixels[0].sum[0] - f64::from(1e12f32);
    let error = (rest - wanted).abs() / film.pixels[0].sum[0];
    Ok(Outcome::at_most(error, 2f64.powi(-52))
        .tried(count, "samples of 1e-6 before one of 1e12, error of the sum relative to it")
        .note(format!("the small ones come to {rest:.4e} for {wanted:.4e}")))
}

/// The variance of a pixel whose samples spread by a thousandth of their mean, against that of two passes in f64.
fn variance_of_many(effort: &Effort) -> Result<Outcome> {
    let count = effort.cases(1_000_000).min(1 << 31);
    let values = |i: u64| 1000.0 + Numbers::new(i as u32 ^ 0x5bd1_e995).unit();
    let film = film_of(Sampler::Independent, (0..count).map(values));
    let (mut sum, mut squares) = (Exact::default(), Exact::default());
    (0..count).for_each(|i| sum.add(f64::from(values(i))));
    let mean = sum.total() / count as f64;
    (0..count).for_each(|i| squares.add((f64::from(values(i)) - mean).powi(2)));
    let wanted = squares.total() / (count - 1) as f64 / count as f64;
    let error = (f64::from(film.variance(0, 0)[0]) / wanted - 1.0).abs();
    Ok(Outcome::at_most(error, 1e-4).tried(count, "samples about 1,000 that spread by 1, variance against two passes"))
}

/// The same by the four groups of the sobol sampler.
fn variance_of_groups(effort: &Effort) -> Result<Outcome> {
    let (films, spp) = (effort.cases(2_000), 64);
    let mut worst: f64 = 0.0;
    for number in 0..films {
        let values: Vec<f32> = samples(number as u32 + 7, spp).collect();
        let film = film_of(Sampler::Sobol, values.iter().copied());
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            let (mut sum, mut count) = (Exact::default(), 0.0);
            values.for_each(|value| {
                sum.add(value);
                count += 1.0;
            });
            sum.total() / count
        };
        let wide = |value: &f32| f64::from(*value);
        let groups: Vec<f64> = (0..4).map(|g| mean(&mut values.iter().skip(g).step_by(4).map(wide))).collect();
        let all = mean(&mut values.iter().map(wide));
        let wanted = groups.iter().map(|group| (group - all).powi(2)).sum::<f64>() / 3.0 / 4.0;
        let error = (f64::from(film.variance(0, 0)[0]) / wanted - 1.0).abs();
        worst = if worse(error, worst) { error } else { worst };
    }
    Ok(Outcome::at_most(worst, 1e-7).tried(films * spp, "samples in films, variance by groups against f64"))
}

/// Samples that are no numbers leave a pixel's sums as they are.
fn not_finite_left_out(effort: &Effort) -> Result<Outcome> {
    let count = effort.cases(10_000);
    let mut numbers = Numbers::new(3);
    let mut film = Film::new(Crop { x: 0, y: 0, width: 1, height: 1 });
    let mut wrong = 0;
    for _ in 0..count {
        let mut sample = [numbers.unit(); 3];
        let before = film.pixels[0];
        sample[numbers.below(3) as usize] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][numbers.below(3) as usize];
        wrong += u64::from(film.add(0, 0, sample) || film.pixels[0] != before);
        film.add(0, 0, [numbers.unit(); 3]);
    }
    Ok(Outcome::at_most(wrong as f64, 0.0).tried(count, "samples that are not finite, those that changed the film"))
}

/// A render cut into passes has the bits of one that was not.
fn passes_leave_no_trace(effort: &Effort) -> Result<Outcome> {
    let spp = effort.samples(96, 32);
    let trial = Trial::new("furnace", &[0.5, 0.5])?;
    let mut differ = 0;
    for sampler in [Sampler::Independent, Sampler::Sobol] {
        let settings = Settings { sampler, ..small(16, spp) };
        let whole = trial.render(&settings).film;
        let mut film: Option<Film> = None;
        for spp in [1, 5, spp / 2 + 1, spp] {
            let settings = Settings { spp, ..settings.clone() };
            film = Some(crate::render::render_from(&trial.prepared, &settings, film, &|_| true).film);
        }
        let film = film.expect("four passes");
        differ += whole.pixels.iter().zip(&film.pixels).filter(|(a, b)| a != b).count();
        differ += whole.squares.iter().zip(&film.squares).filter(|(a, b)| a != b).count();
        differ += whole.groups.iter().zip(&film.groups).filter(|(a, b)| a != b).count();
    }
    Ok(Outcome::at_most(differ as f64, 0.0)
        .tried(u64::from(spp) * 512, "samples, whole and in four passes, pixels that differ"))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (F32Sum, &["film/many_samples", "film/large_among_small", "film/variance_of_many", "film/variance_of_groups"]),
        (TakenThoughNotFinite, &["film/not_finite_left_out"]),
        (LostPass, &["film/passes_leave_no_trace"]),
    ]
};
