//! What a long render keeps while it runs: a checkpoint, and the picture so far.

use crate::cli::frames::Shot;
use crate::cli::output::{check_place, make_directory};
use crate::cli::progress::Bar;
use crate::cli::resume::{State, remove_unfinished};
use crate::cli::{args, messages, places, warn};
use crate::error::{Error, Result};
use crate::files::atomic;
use crate::files::read::is_special;
use crate::film::Film;
use crate::image::check_output_path;
use crate::render::{Progress, Watch};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Flags of what is kept.
#[derive(clap::Args)]
pub struct KeepArgs {
    /// Keep the samples so far in FILE, from which the same command goes on after whatever ended it [default: the image's name
    /// and .unfinished]
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// How often, at least (30s, 5m)
    #[arg(long, value_name = "TIME", default_value = "5m", value_parser = args::seconds, allow_negative_numbers = true)]
    every: Duration,
    /// Leave the checkpoint when the render is finished, so that --resume can go on from it
    #[arg(long)]
    keep_checkpoint: bool,
    /// Go on from the checkpoint of a finished render, to more samples (an interrupted one goes on without this)
    #[arg(long)]
    resume: bool,
    /// Write the image so far to FILE now and then; viewers such as tev show it as it grows
    #[arg(long, value_name = "FILE")]
    preview: Option<PathBuf>,
    /// How often (10s, 1m)
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = args::seconds, allow_negative_numbers = true)]
    preview_every: Duration,
}

/// What follows an image's name in that of its checkpoint.
const UNFINISHED: &str = ".unfinished";

impl KeepArgs {
    /// The checkpoint and the preview, as they are named.
    pub fn files(&self) -> (Option<&Path>, Option<&Path>) {
        (self.checkpoint.as_deref(), self.preview.as_deref())
    }

    /// Whether the checkpoint of a finished render is to be gone on from.
    pub fn resumes(&self) -> bool {
        self.resume
    }

    /// Whether the checkpoint outlives the render.
    pub fn keeps(&self) -> bool {
        self.keep_checkpoint
    }

    /// Whether what is kept of these renders, `of_images` or of parts, can be written, asked before the first.
    ///
    /// # Errors
    /// [`crate::Error::Write`]; [`crate::Error::Usage`] where two outputs have one file.
    pub fn check(&self, shots: &[Shot], of_images: bool) -> Result<()> {
        for shot in shots {
            if let Some(path) = self.path(shot) {
                check_place(&path, atomic::check)?;
                places::claim(&path)?;
            }
            let images = if of_images { &shot.outputs[..] } else { &[] };
            let mut partial = images.iter().filter_map(|path| partial_path(path));
            partial.try_for_each(|path| check_place(&path, atomic::check).and_then(|()| places::claim(&path)))?;
        }
        // Frames may take turns in one preview.
        let mut previews: Vec<&PathBuf> = shots.iter().filter_map(|shot| shot.preview.as_ref()).collect();
        previews.dedup();
        for path in previews {
            check_place(path, |path| check_output_path(path))?;
            places::claim(path)?;
        }
        Ok(())
    }

    /// The checkpoint of a render: the one that is named; or that of whichever of its images has one; or that of the first that
    /// is a file.
    pub fn path(&self, shot: &Shot) -> Option<PathBuf> {
        let beside = |image: &PathBuf| {
            let mut path = image.clone().into_os_string();
            path.push(UNFINISHED);
            PathBuf::from(path)
        };
        let named = self.checkpoint.as_ref().and(shot.checkpoint.clone());
        let files = || shot.outputs.iter().filter(|path| !is_special(path)).map(beside);
        named.or_else(|| files().find(|path| path.symlink_metadata().is_ok())).or_else(|| files().next())
    }
}

/// Where the picture so far of an interrupted render goes, so that an older image stays: `a.partial.png` for `a.png`. `None`
/// where the image is a device or a pipe.
pub fn partial_path(image: &Path) -> Option<PathBuf> {
    if is_special(image) {
        return None;
    }
    let (stem, extension) = (image.file_stem()?, image.extension()?);
    let mut name = stem.to_owned();
    name.push(".partial.");
    name.push(extension);
    Some(image.with_file_name(name))
}

/// Removes the pictures so far of a render that is finished now.
pub fn remove_partial(images: &[PathBuf]) {
    images.iter().filter_map(|path| partial_path(path)).for_each(|path| remove_unfinished(&path));
}

/// Looks on for the program: shows progress, hears the wish to stop, keeps checkpoints and previews.
pub struct Watcher<'a> {
    args: &'a KeepArgs,
    state: &'a State,
    preview: Option<&'a Path>,
    bar: &'a Bar,
    stop: &'a AtomicBool,
    exposure: f64,
    due: Mutex<Due>,
    /// What could not be written last, so that it is told once.
    told: Mutex<String>,
}

/// When what is to be kept next, if it is kept at all.
#[derive(Clone, Copy)]
struct Due {
    checkpoint: Option<Instant>,
    preview: Option<Instant>,
}

impl<'a> Watcher<'a> {
    /// For a render that begins now.
    pub fn new(
        args: &'a KeepArgs,
        state: &'a State,
        preview: Option<&'a Path>,
        bar: &'a Bar,
        stop: &'a AtomicBool,
        exposure: f64,
    ) -> Watcher<'a> {
        let now = Instant::now();
        // A device has no checkpoint beside it.
        let checkpoint = state.path().map(|_| later(now, args.every));
        let due = Due { checkpoint, preview: preview.map(|_| later(now, args.preview_every)) };
        Watcher { args, state, preview, bar, stop, exposure, due: Mutex::new(due), told: Mutex::default() }
    }

    /// A disk may be full for a while: what was kept before is kept still, and the render is worth going on.
    fn go_on(&self, error: &Error) {
        let message = format!("{error}; the render goes on");
        let mut told = self.told.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if *told != message {
            warn(&message);
            *told = message;
        }
    }

    fn due(&self) -> Due {
        *self.due.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// `now` and `time` later, or as late as can be told.
fn later(now: Instant, time: Duration) -> Instant {
    const YEARS: Duration = Duration::from_secs(100 * 365 * 24 * 3600);
    now + time.min(YEARS)
}

impl Watch for Watcher<'_> {
    fn progress(&self, progress: Progress) -> bool {
        self.bar.show(&progress);
        !self.stop.load(Ordering::Relaxed)
    }

    fn pause_after(&self) -> Option<Duration> {
        let Due { checkpoint, preview } = self.due();
        let next = [checkpoint, preview].into_iter().flatten().min()?;
        Some(next.saturating_duration_since(Instant::now()))
    }

    fn pause(&self, film: &Film, seconds: f64) {
        let (now, due) = (Instant::now(), self.due());
        let mut next = due;
        if due.checkpoint.is_some_and(|due| now >= due) {
            match self.state.keep(film, seconds, false) {
                Ok(()) => {
                    let file = self.state.path().map(|path| path.display().to_string());
                    messages::event(&json!({ "event": "checkpoint", "file": file, "samples_per_pixel": film.spp }));
                }
                Err(error) => self.go_on(&error),
            }
            // Where keeping takes longer than the time between, half of the time is work.
            next.checkpoint = Some(later(Instant::now(), self.args.every.max(now.elapsed())));
        }
        if let (Some(path), Some(preview)) = (self.preview, due.preview)
            && now >= preview
        {
            let now = Instant::now();
            if let Err(error) = make_directory(path).and_then(|()| film.save_exposed(path, self.exposure)) {
                self.go_on(&error);
            }
            // A picture to look at is to cost a tenth of the time at most.
            next.preview = Some(later(Instant::now(), self.args.preview_every.max(9 * now.elapsed())));
        }
        *self.due.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_so_far_has_a_name_of_its_own() {
        let of = |path: &str| partial_path(Path::new(path)).map(|path| path.display().to_string());
        assert_eq!(of("out/a.b.png").as_deref(), Some("out/a.b.partial.png"));
        if cfg!(unix) {
            assert_eq!(of("/dev/null"), None);
        }
    }
}
