//! The progress bar of a render, and the line of a scene that takes long to load: on standard error, only where that is a
//! terminal.

use crate::api::Scene;
use crate::cli::messages::{self, tell};
use crate::cli::numbers::{percent, three_digits};
use crate::cli::places;
use crate::error::Result;
use crate::film::RelativeError;
use crate::render::Progress;
use crate::settings::{Settings, Train};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use std::io::IsTerminal;
use std::path::Path;
use std::sync::Mutex;
use std::sync::mpsc;
use std::time::{Duration, Instant};

const STEPS: u64 = 1000;
/// Loading that takes no longer says nothing.
const LOADING_AT_LEAST: Duration = Duration::from_secs(1);

/// [`Scene::load`], with a line for as long as it takes beyond a second; none if `quiet` or if nobody would see it.
pub fn load(path: &Path, quiet: bool) -> Result<Scene> {
    let begun = Instant::now();
    let scene = load_and_tell(path, quiet)?;
    let (seconds, desc) = (begun.elapsed().as_secs_f64(), &scene.desc);
    let triangles: usize = desc.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    tell(&format!(
        "{}: {triangles} triangles in {} meshes, {} materials, {} textures, read in {} s",
        desc.name,
        desc.meshes.len(),
        desc.materials.len(),
        desc.textures.len(),
        three_digits(seconds)
    ));
    Ok(scene)
}

fn load_and_tell(path: &Path, quiet: bool) -> Result<Scene> {
    if quiet || !std::io::stderr().is_terminal() {
        return places::reading(|| Scene::load(path));
    }
    let line = || {
        let line = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(8));
        if let Ok(style) = ProgressStyle::with_template("{spinner} loading {msg}, {elapsed}") {
            line.set_style(style);
        }
        line.set_elapsed(LOADING_AT_LEAST);
        line.set_message(path.display().to_string());
        line.tick();
        line
    };
    beside(LOADING_AT_LEAST, line, |line| line.finish_and_clear(), || places::reading(|| Scene::load(path)))
}

/// What `work` gives; if that takes longer than `patience`, `begin` is called meanwhile, and `end` with what it gave when the
/// work is done.
fn beside<T, L>(
    patience: Duration,
    begin: impl FnOnce() -> L + Send,
    end: impl FnOnce(L) + Send,
    work: impl FnOnce() -> T,
) -> T {
    let (working, done) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        let told = move || {
            // Nothing is ever sent: the channel breaks when the work is done.
            if done.recv_timeout(patience) == Err(mpsc::RecvTimeoutError::Timeout) {
                let begun = begin();
                let _ = done.recv();
                end(begun);
            }
        };
        // Where the system refuses to start a thread, nothing is told.
        let _ = std::thread::Builder::new().spawn_scoped(scope, told);
        let result = work();
        drop(working);
        result
    })
}

/// How progress is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Form {
    /// A bar where standard error is a terminal, else nothing
    #[default]
    Auto,
    /// A JSON object a line on standard error, terminal or not; warnings and errors, too
    Json,
    /// Nothing
    None,
}

/// Seconds between two objects of JSON.
const BETWEEN_OBJECTS: f64 = 0.25;

/// Shows how far a render has come.
pub struct Bar {
    bar: ProgressBar,
    form: Form,
    /// Of what frame, if it is one of a sequence.
    frame: Option<u32>,
    title: String,
    time: Option<Duration>,
    target: Option<f64>,
    /// When the last object of JSON was written, in seconds of the render.
    told: Mutex<Option<f64>>,
}

impl Bar {
    /// A bar for a render with `settings`; hidden if nobody would see it.
    pub fn new(settings: &Settings, frame: Option<u32>, form: Form) -> Bar {
        let hidden = form != Form::Auto || !std::io::stderr().is_terminal();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(8) };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        if let Ok(style) = ProgressStyle::with_template("{bar:24} {percent:>3} %  {wide_msg}") {
            bar.set_style(style);
        }
        let title = frame.map(|frame| format!("frame {frame}: ")).unwrap_or_default();
        if settings.learns() && settings.train != Train::Off {
            bar.set_message(format!("{title}training render"));
        }
        let told = Mutex::new(None);
        Bar { bar, form, frame, title, time: settings.time, target: settings.target_error, told }
    }

    /// Shows `progress`.
    pub fn show(&self, progress: &Progress) {
        if self.form == Form::Json {
            return self.tell(progress);
        }
        if self.bar.is_hidden() || progress.training {
            return;
        }
        let done = fraction(progress, self.time, self.target);
        self.bar.set_position((done * STEPS as f64) as u64);
        let message = match progress.layers {
            true => "layers".to_owned(),
            false => message(progress, seconds_left(progress, self.time, self.target)),
        };
        self.bar.set_message(format!("{}{message}", self.title));
    }

    /// An object of JSON, if the last one was a while ago.
    fn tell(&self, progress: &Progress) {
        // Another thread is at it.
        let Ok(mut told) = self.told.try_lock() else { return };
        if told.is_some_and(|told| progress.seconds < told + BETWEEN_OBJECTS) {
            return;
        }
        *told = Some(progress.seconds);
        messages::event(&json!({
            "event": "progress",
            "frame": self.frame,
            "training": progress.training,
            "layers": progress.layers,
            "samples": progress.samples,
            "total": if self.counts_samples(progress) { Some(progress.total) } else { None },
            "done": fraction(progress, self.time, self.target),
            "seconds": progress.seconds,
            "seconds_left": seconds_left(progress, self.time, self.target),
            "noise": progress.relative_error,
        }));
    }

    /// Whether the number of samples is known from the start.
    fn counts_samples(&self, progress: &Progress) -> bool {
        let unlimited = u64::from(u32::MAX);
        (self.time.is_none() && self.target.is_none()) || progress.total < unlimited
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// The finished part, in [0, 1]: of the samples, of the time or of the way to the target, whichever ends first. The
/// parts of the error fall as known powers of the samples, so the samples still needed follow from them.
fn fraction(progress: &Progress, time: Option<Duration>, target: Option<f64>) -> f64 {
    let samples = progress.samples as f64 / progress.total.max(1) as f64;
    let time = time.map_or(0.0, |time| progress.seconds / time.as_secs_f64());
    let target = growth(progress, target).map_or(0.0, f64::recip);
    samples.max(time).max(target).min(1.0)
}

/// The factor on the samples that leads to the target error.
fn growth(progress: &Progress, target: Option<f64>) -> Option<f64> {
    let error = RelativeError { seen: progress.relative_error?, unseen: progress.unseen_error };
    Some(error.growth(target?))
}

/// Samples a second of this call: those of earlier calls cost it no time.
fn samples_per_second(progress: &Progress) -> f64 {
    progress.samples.saturating_sub(progress.resumed) as f64 / progress.seconds.max(1e-9)
}

/// Seconds to the end that comes first, at the pace of this call; `None` before it has a pace.
fn seconds_left(progress: &Progress, time: Option<Duration>, target: Option<f64>) -> Option<f64> {
    let pace = samples_per_second(progress);
    if pace <= 0.0 {
        return None;
    }
    let samples = progress.samples as f64;
    let to_samples = |wanted: f64| (wanted - samples).max(0.0) / pace;
    let to_time = time.map(|time| (time.as_secs_f64() - progress.seconds).max(0.0));
    let to_target = growth(progress, target).map(|growth| to_samples(samples * growth));
    let to_total = to_samples(progress.total as f64);
    Some([to_time, to_target].into_iter().flatten().fold(to_total, f64::min))
}

fn message(progress: &Progress, seconds_left: Option<f64>) -> String {
    let mut parts = vec![format!("{} Msamples/s", three_digits(samples_per_second(progress) * 1e-6))];
    if let Some(seconds) = seconds_left {
        parts.push(format!("{} left", duration(seconds)));
    }
    if let Some(error) = progress.relative_error {
        parts.push(format!("noise {}", percent(error)));
        if progress.unseen_error > 0.1 * error {
            parts.push(format!("light not met up to {}", percent(progress.unseen_error)));
        }
    }
    parts.join(", ")
}

fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn only_what_takes_long_is_told() {
        let calls = AtomicU32::new(0);
        let told = |patience: u64, work: u64| {
            calls.store(0, Ordering::Relaxed);
            let begin = || calls.fetch_add(1, Ordering::Relaxed);
            let end = |_| _ = calls.fetch_add(10, Ordering::Relaxed);
            let [patience, work] = [patience, work].map(Duration::from_millis);
            let result = beside(patience, begin, end, || {
                std::thread::sleep(work);
                "result"
            });
            assert_eq!(result, "result");
            calls.load(Ordering::Relaxed)
        };
        assert_eq!((told(10_000, 1), told(1, 500)), (0, 11));
    }

    #[test]
    fn the_bar_follows_whichever_ends_first() {
        let progress = Progress {
            samples: 25,
            resumed: 0,
            total: 100,
            seconds: 6.0,
            training: false,
            layers: false,
            relative_error: None,
            unseen_error: 0.0,
        };
        assert_eq!(fraction(&progress, None, None), 0.25);
        assert_eq!(fraction(&progress, Some(Duration::from_secs(8)), None), 0.75);
        assert_eq!(fraction(&progress, Some(Duration::from_secs(1)), None), 1.0);
        assert_eq!(message(&progress, seconds_left(&progress, None, None)), "4.17e-6 Msamples/s, 18 s left");
        let later = Progress { relative_error: Some(0.0312), ..progress };
        assert_eq!(fraction(&Progress { relative_error: Some(0.02), ..progress }, None, Some(0.01)), 0.25);
        assert_eq!(fraction(&later, None, Some(0.05)), 1.0);
        assert_eq!(message(&later, seconds_left(&later, None, None)), "4.17e-6 Msamples/s, 18 s left, noise 3.12 %");
        // What no sample has met counts as well, and falls faster.
        let unseen = Progress { relative_error: Some(1e-9), unseen_error: 0.08, ..progress };
        assert!((fraction(&unseen, None, Some(0.04)) - 0.5).abs() < 1e-6);
        let words = "4.17e-6 Msamples/s, 6 s left, noise 1.00e-7 %, light not met up to 8 %";
        assert_eq!(message(&unseen, seconds_left(&unseen, None, Some(0.04))), words);
        assert_eq!([59.0, 61.0, 3700.0].map(duration), ["59 s", "1 min 01 s", "1 h 01 min"]);
    }

    #[test]
    fn the_time_left_follows_from_the_samples_of_this_call() {
        // An earlier call has taken 60; this one 20 in 10 seconds.
        let (resumed, relative_error, unseen_error) = (60, Some(0.02), 0.0);
        let (seconds, training, layers) = (10.0, false, false);
        let progress =
            Progress { samples: 80, resumed, total: 100, seconds, training, layers, relative_error, unseen_error };
        let left = |time: Option<u64>, target| seconds_left(&progress, time.map(Duration::from_secs), target);
        assert_eq!(samples_per_second(&progress), 2.0);
        assert_eq!(left(None, None), Some(10.0));
        assert_eq!((left(Some(13), None), left(Some(1000), None)), (Some(3.0), Some(10.0)));
        // Half the error needs four times the samples, more than are wanted; the same error needs none.
        assert_eq!((left(None, Some(0.01)), left(None, Some(0.02))), (Some(10.0), Some(0.0)));
        assert_eq!(seconds_left(&Progress { samples: 60, ..progress }, None, None), None);
        // Without an earlier call it is the rule of three.
        assert_eq!(seconds_left(&Progress { resumed: 0, ..progress }, None, None), Some(2.5));
    }
}
