//! Who looks on while a render runs: hears how far it is, may stop it, and is shown the picture from time to time.

use std::time::Duration;

use crate::film::Film;

/// How far a render has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Samples finished, over all pixels.
    pub samples: u64,
    /// Those of them that an earlier call has taken.
    pub resumed: u64,
    /// Samples wanted.
    pub total: u64,
    /// Wall seconds since the start of this call.
    pub seconds: f64,
    /// The training render is under way: no sample of the picture is taken yet.
    pub training: bool,
    /// All samples are taken, and the layers are gathered ([`crate::film::layers`]).
    pub layers: bool,
    /// The picture's estimated relative error ([`crate::Film::relative_error`]) after the last whole pass; `None` before there are
    /// two samples (four with the `sobol` sampler) in every pixel, and for a black picture.
    pub relative_error: Option<f64>,
    /// What light that no sample has met may add to it ([`crate::film::RelativeError::unseen`]); 0 without a target error, and
    /// where light samples see to all lights.
    pub unseen_error: f64,
}

/// Who looks on. A closure that takes [`Progress`] is one that never asks to be shown the picture.
pub trait Watch: Sync {
    /// Hears how far the render is, from any of its threads, several times a second if it can be. Once it returns false the
    /// render stops, within the few thousand paths that each thread is following.
    fn progress(&self, progress: Progress) -> bool;

    /// How long the render may go on before it is to [`Watch::pause`]; asked anew after every pause.
    fn pause_after(&self) -> Option<Duration> {
        None
    }

    /// Is shown the picture so far, while no thread works on it: to keep it, or to look at it. `seconds`: wall seconds since
    /// the start of this call. Whatever is done here leaves no trace in the picture.
    fn pause(&self, film: &Film, seconds: f64) {
        let _ = (film, seconds);
    }
}

impl<F: Fn(Progress) -> bool + Sync> Watch for F {
    fn progress(&self, progress: Progress) -> bool {
        self(progress)
    }
}
