//! An interrupted render goes on where it was: its sums are kept beside the image until it is finished.

use crate::cli::warn;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::film::checkpoint;
use crate::film::checkpoint::Checkpoint;
use crate::render::Render;
use crate::scene::SceneDesc;
use crate::scene::desc::CameraDesc;
use crate::scene::fingerprint;
use crate::settings::Settings;
use crate::setup::frame::Frame;
use crate::setup::recipe::Recipe;
use std::path::{Path, PathBuf};

/// The file that an interrupted render leaves, and what decides whether another render may go on from it.
pub struct State {
    path: PathBuf,
    recipe: Recipe,
    /// Seconds that earlier calls have taken.
    seconds: std::cell::Cell<f64>,
}

impl State {
    /// That of a render to `output`; `learned_from`: the cameras of the frames whose training it shares.
    pub fn new(
        output: &Path,
        scene: &SceneDesc,
        settings: &Settings,
        frame: &Frame,
        learned_from: &[CameraDesc],
    ) -> State {
        let mut path = output.as_os_str().to_owned();
        path.push(".unfinished");
        let content = format!("{:016x}", fingerprint::scene(scene));
        let training = match learned_from.len() {
            0 | 1 => "by itself".to_owned(),
            frames => format!("over {frames} frames, {:016x}", fingerprint::cameras(learned_from)),
        };
        let recipe = Recipe::new(&scene.name, settings, frame).and("content of the scene", content);
        let recipe = recipe.and("training", training);
        State { path: path.into(), recipe, seconds: std::cell::Cell::new(0.0) }
    }

    /// What there is to go on from; `settings.time` is cut by what has been used of it.
    ///
    /// # Errors
    /// [`Error::Usage`] and [`Error::Parse`] if the file is of another render, or damaged: it is left as it is.
    pub fn read(&self, settings: &mut Settings) -> Result<Option<Film>> {
        if !self.path.exists() {
            return Ok(None);
        }
        let found = checkpoint::read(&self.path)?;
        let path = self.path.display();
        if !self.recipe.0.iter().map(|(name, _)| name).eq(found.settings.iter().map(|(name, _)| name)) {
            return Err(Error::Usage(format!(
                "{path}: an unfinished render of another version of octray; finish it with that one, delete that file, or \
                 write to another image"
            )));
        }
        let differs = self.recipe.0.iter().zip(&found.settings).find(|(own, theirs)| own != theirs);
        if let Some(((name, own), (_, theirs))) = differs {
            return Err(Error::Usage(format!(
                "{path}: an unfinished render with {name} {theirs}, and this one has {own}; finish it first, delete that \
                 file, or write to another image"
            )));
        }
        if found.film.spp > settings.spp {
            return Err(Error::Usage(format!(
                "{path}: an unfinished render that has {} samples a pixel, more than {}; ask for more samples or delete \
                 that file",
                found.film.spp, settings.spp
            )));
        }
        warn(&format!("going on from {path} with {} samples a pixel", found.film.spp));
        self.seconds.set(found.seconds);
        let used = std::time::Duration::try_from_secs_f64(found.seconds).unwrap_or_default();
        settings.time = settings.time.map(|time| time.saturating_sub(used));
        Ok(Some(found.film))
    }

    /// Keeps what `render`, which was to have `spp` samples a pixel, has come to.
    pub fn keep(&self, render: &Render, spp: u32) -> Result<()> {
        let film = render.film.clone();
        let of = if spp == u32::MAX { String::new() } else { format!(" of {spp}") };
        let done = film.spp;
        let seconds = self.seconds.get() + render.stats.render_s;
        checkpoint::write(&self.path, &Checkpoint { settings: self.recipe.0.clone(), seconds, film })?;
        let path = self.path.display();
        warn(&format!("stopped after {done}{of} samples a pixel; the same command goes on from there ({path})"));
        Ok(())
    }

    /// Removes the file of a render that is finished now.
    pub fn remove(&self) {
        remove_unfinished(&self.path);
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
