//! How many samples a pass takes.

use crate::film::RelativeError;
use crate::settings::Settings;

/// Samples a pixel in one pass, at most: progress, limits and the wish to stop are looked at between passes.
pub(super) const PASS_SPP: u32 = 64;
/// Samples of the first pass over all pixels, at most, and seconds of the later ones: so that a wish to stop is heard.
const FIRST_PASS_SAMPLES: u64 = 1 << 22;
const PASS_SECONDS: f64 = 2.0;
/// A render stops at a target error no sooner than at so many samples a pixel, and at so many of all pixels: fewer say too
/// little about their own variance. Films of 32 x 32 pixels and more have the second with the first.
const LEAST_SPP_FOR_ERROR: u32 = 16;
const LEAST_SAMPLES_FOR_ERROR: u64 = 1 << 14;
/// A picture that is still black after so many samples a pixel has no relative error and is given up as it is; where paths
/// meet light by chance, not before so many of all pixels.
const BLACK_SPP: u32 = 1024;
const BLACK_SAMPLES: u64 = 1 << 20;

/// Samples a pixel from which on a target error may stop a render of so many pixels.
fn least_spp(pixels: u64) -> u32 {
    LEAST_SPP_FOR_ERROR.max(LEAST_SAMPLES_FOR_ERROR.div_ceil(pixels.max(1)) as u32)
}

/// Whether `error` after `done` samples a pixel is at or below `target`, or will not come to be known. `by_chance`: paths
/// may meet light that light samples do not see to.
pub(super) fn reaches(target: f64, done: u32, pixels: u64, error: Option<RelativeError>, by_chance: bool) -> bool {
    match error {
        Some(error) => done >= least_spp(pixels) && error.whole() <= target,
        None => done >= BLACK_SPP && (!by_chance || done as u64 * pixels >= BLACK_SAMPLES),
    }
}

/// Samples of the next pass, where `taken` samples a pixel have cost so many seconds so far. No pass is longer than
/// [`PASS_SECONDS`] as far as can be foreseen. Under a time limit passes start at one sample and grow, so that the last one
/// does not overshoot by more than about a tenth of the limit; on the way to a target error they end where the error is
/// foreseen to get there.
pub(super) fn pass_length(
    settings: &Settings,
    done: u32,
    (taken, seconds): (u32, f64),
    pixels: u64,
    error: Option<RelativeError>,
) -> u32 {
    let mut most = (settings.spp.max(1) - done).min(PASS_SPP);
    if taken == 0 {
        most = most.min((FIRST_PASS_SAMPLES / pixels.max(1)).clamp(1, PASS_SPP as u64) as u32);
    }
    let each = (seconds / taken.max(1) as f64).max(1e-9);
    let within = |seconds: f64| ((seconds / each) as u32).max(1);
    if taken > 0 {
        most = most.min(within(PASS_SECONDS));
    }
    let least = least_spp(pixels);
    if settings.target_error.is_some() && done < least {
        most = most.min(least - done);
    }
    if let (Some(target), Some(error)) = (settings.target_error, error) {
        let needed = done as f64 * (error.growth(target) - 1.0);
        most = most.min((needed.ceil() as u32).max(1));
    }
    match (settings.time, taken) {
        (None, _) => most,
        (Some(_), 0) => 1,
        (Some(limit), _) => within(limit.as_secs_f64() * 0.1).min(most).min(taken),
    }
}
