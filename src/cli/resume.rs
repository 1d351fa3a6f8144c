//! An interrupted render goes on where it was, and a finished one can be extended: its sums are kept in a checkpoint.

use crate::cli::messages::tell;
use crate::cli::output::make_directory;
use crate::cli::warn;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::film::checkpoint;
use crate::scene::SceneDesc;
use crate::scene::desc::CameraDesc;
use crate::scene::fingerprint;
use crate::settings::{Settings, Shard};
use crate::setup::frame::Frame;
use crate::setup::recipe::Recipe;
use std::path::{Path, PathBuf};

/// The checkpoint of a render, and what decides whether another render may go on from it.
pub struct State {
    /// `None`: nothing is kept.
    path: Option<PathBuf>,
    recipe: Recipe,
    /// Seconds that earlier calls have taken.
    seconds: f64,
}

/// What decides every bit of a render's samples. `learned_from`: the cameras of the frames whose training it shares.
pub fn recipe_of(scene: &SceneDesc, settings: &Settings, frame: &Frame, learned_from: &[CameraDesc]) -> Recipe {
    let content = format!("{:016x}", fingerprint::scene(scene));
    let training = match learned_from.len() {
        0 | 1 => "by itself".to_owned(),
        frames => format!("over {frames} frames, {:016x}", fingerprint::cameras(learned_from)),
    };
    Recipe::new(&scene.name, settings, frame).and("content of the scene", content).and("training", training)
}

impl State {
    /// That of a render in `path`, if it has one, which `recipe` and the tiles of it that are rendered decide.
    pub fn new(path: Option<PathBuf>, recipe: &Recipe, shard: Option<Shard>) -> State {
        let part = shard.map_or("all".to_owned(), |shard| shard.to_string());
        State { path, recipe: recipe.clone().and("part", part), seconds: 0.0 }
    }

    /// Where it is kept; `None`: nowhere.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// What there is to go on from; `settings.time` is cut by what has been used of it. `resume`: whether a finished render is to
    /// be extended.
    ///
    /// # Errors
    /// [`Error::Usage`] and [`Error::Parse`] if the file is of another render, or damaged, or of a finished render that nobody
    /// asked to go on with: it is left as it is. [`Error::Usage`] if there is none, and `resume` wants one.
    pub fn read(&mut self, settings: &mut Settings, resume: bool) -> Result<Option<Film>> {
        let Some(file) = &self.path else { return Ok(None) };
        let path = file.display();
        if file.symlink_metadata().is_err() {
            return match resume {
                true => Err(Error::Usage(format!(
                    "{path}: there is no such checkpoint to resume; --keep-checkpoint leaves one behind a finished render"
                ))),
                false => Ok(None),
            };
        }
        let found = checkpoint::read(file)?;
        let kind = if found.finished { "the checkpoint of a finished render" } else { "an unfinished render" };
        if !self.recipe.0.iter().map(|(name, _)| name).eq(found.settings.iter().map(|(name, _)| name)) {
            return Err(Error::Usage(format!(
                "{path}: {kind} of another version of octray; go on with that one, delete that file, or write to another \
                 image"
            )));
        }
        let differs = self.recipe.0.iter().zip(&found.settings).find(|(own, theirs)| own != theirs);
        if let Some(((name, own), (_, theirs))) = differs {
            return Err(Error::Usage(format!(
                "{path}: {kind} with {name} {theirs}, and this one has {own}; finish it first, delete that file, or write \
                 to another image"
            )));
        }
        if found.film.most_spp() > settings.spp {
            return Err(Error::Usage(format!(
                "{path}: {kind} that has {} samples a pixel, more than {}; ask for more samples or delete that file",
                found.film.most_spp(),
                settings.spp
            )));
        }
        if found.finished && !resume {
            return Err(Error::Usage(format!(
                "{path}: {kind} of {} samples a pixel; --resume goes on from it, and without that file it is rendered anew",
                found.film.spp
            )));
        }
        warn(&format!("going on from {path} with {} samples a pixel", found.film.spp_in_words()));
        self.seconds = found.seconds;
        let used = std::time::Duration::try_from_secs_f64(found.seconds).unwrap_or_default();
        settings.time = settings.time.map(|time| time.saturating_sub(used));
        Ok(Some(found.film))
    }

    /// Keeps `film`, for which this call has taken `seconds`.
    ///
    /// # Errors
    /// [`Error::Write`]: what was kept before is kept still.
    pub fn keep(&self, film: &Film, seconds: f64, finished: bool) -> Result<()> {
        self.path.as_ref().map_or(Ok(()), |path| self.keep_in(path, film, seconds, finished))
    }

    fn keep_in(&self, path: &Path, film: &Film, seconds: f64, finished: bool) -> Result<()> {
        // A folder that has vanished meanwhile is no reason to lose what it was made for.
        make_directory(path)?;
        checkpoint::write(path, &self.recipe.0, (self.seconds + seconds, finished), film)?;
        tell(&format!("{}: {} samples a pixel are kept", path.display(), film.spp_in_words()));
        Ok(())
    }

    /// Keeps `film`, whose files cannot be written: in the checkpoint, or where that cannot be written either, among the system's
    /// temporary files. Where.
    ///
    /// # Errors
    /// [`Error::Write`] of the first of the two, if both fail.
    pub fn rescue(&self, film: &Film, seconds: f64) -> Result<PathBuf> {
        let elsewhere = |name: &Path| {
            let name = name.file_name().unwrap_or_default().to_string_lossy().into_owned();
            std::env::temp_dir().join(format!("octray-{}-{name}", std::process::id()))
        };
        let path = self.path.clone().unwrap_or_else(|| elsewhere(Path::new("image.unfinished")));
        let first = match self.keep_in(&path, film, seconds, false) {
            Ok(()) => return Ok(path),
            Err(error) => error,
        };
        let path = elsewhere(&path);
        self.keep_in(&path, film, seconds, false).map(|()| path).map_err(|_| first)
    }

    /// Removes the file of a render that is finished now.
    pub fn remove(&self) {
        self.path.iter().for_each(|path| remove_unfinished(path));
    }
}

/// Removes what an interrupted call has kept, now that all of it is done.
pub fn remove_unfinished(path: &Path) {
    if path.exists()
        && let Err(error) = std::fs::remove_file(path)
    {
        warn(&format!("{}: no longer needed, and cannot be removed: {error}", path.display()));
    }
}
