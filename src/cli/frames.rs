//! Sequences of frames: which, where their files go, what tells one from another.

use crate::cli::args;
use crate::error::{Error, Result};
use crate::import::assembly::load_camera_path;
use crate::render::sequence::{MOST_TRAIN_FRAMES, Sequence, TRAIN_FRAMES};
use crate::scene::SceneDesc;
use crate::scene::desc::CameraDesc;
use crate::tables::PreparedScene;
use std::path::{Path, PathBuf};

/// Flags of a sequence.
#[derive(clap::Args)]
pub struct FrameArgs {
    /// Render frames A to B, both included, or a single one: with the camera where its path has it at frame / fps seconds,
    /// and random numbers of their own. `####` in the names of outputs becomes the frame's number
    #[arg(long, value_name = "A..B", value_parser = Frames::parse)]
    frames: Option<Frames>,
    /// Frames a second
    #[arg(long, value_name = "F", default_value = "24", value_parser = args::rate, allow_negative_numbers = true)]
    fps: f64,
    /// Take the camera and its path from this TOML file: what `[camera]` of a scene file holds, its keys as [[key]]
    #[arg(long, value_name = "FILE")]
    camera_path: Option<PathBuf>,
    /// Frames whose training renders add up to what a frame learns, itself and those before it; 1: each frame trains by
    /// itself, as long as an image does, and so it is under --lights nee-plus-plus
    #[arg(long, value_name = "N", requires = "frames", default_value_t = TRAIN_FRAMES,
          value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_TRAIN_FRAMES)), allow_negative_numbers = true)]
    train_frames: u32,
    /// Leave out frames whose outputs are all there
    #[arg(long, requires = "frames")]
    skip_existing: bool,
}

/// Frames `first` to `last`, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    first: u32,
    last: u32,
}

impl Frames {
    /// `A..B` or `A`.
    fn parse(text: &str) -> std::result::Result<Frames, String> {
        let wanted = "give whole numbers: A..B for frames A to B, both included, or A for one";
        let number = |text: &str| text.trim().parse::<u32>().map_err(|_| wanted.to_owned());
        let (first, last) = text.split_once("..").unwrap_or((text, text));
        let frames = Frames { first: number(first)?, last: number(last)? };
        match frames.first <= frames.last {
            true => Ok(frames),
            false => Err(format!("frame {first} comes after {last}: give the first frame first")),
        }
    }
}

/// One render of a call.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// Its frame; `None`: an image by itself.
    pub frame: Option<u32>,
    /// Its images.
    pub outputs: Vec<PathBuf>,
    /// Where its statistics go.
    pub stats: Option<PathBuf>,
    /// Where its checkpoint is, if that is said.
    pub checkpoint: Option<PathBuf>,
    /// Where the picture so far goes while it is rendered.
    pub preview: Option<PathBuf>,
}

/// The names of files of a call, as they are typed.
#[derive(Clone, Copy, Debug)]
pub struct Names<'a> {
    /// Images.
    pub outputs: &'a [PathBuf],
    /// As in [`Shot`].
    pub stats: Option<&'a Path>,
    /// As in [`Shot`].
    pub checkpoint: Option<&'a Path>,
    /// As in [`Shot`]; all frames may share it.
    pub preview: Option<&'a Path>,
}

impl FrameArgs {
    /// The renders that are asked for.
    ///
    /// # Errors
    /// [`Error::Usage`] where several frames would go to one file.
    pub fn shots(&self, names: Names) -> Result<Vec<Shot>> {
        let Names { outputs, stats, checkpoint, preview } = names;
        let owned = |path: Option<&Path>| path.map(Path::to_owned);
        let Some(Frames { first, last }) = self.frames else {
            return Ok(vec![Shot {
                frame: None,
                outputs: outputs.to_vec(),
                stats: owned(stats),
                checkpoint: owned(checkpoint),
                preview: owned(preview),
            }]);
        };
        let mut own = outputs.iter().map(PathBuf::as_path).chain(stats).chain(checkpoint);
        if let Some(path) = own.find(|path| numbered(path, 0).is_none())
            && first < last
        {
            return Err(Error::Usage(format!(
                "{}: every frame needs a file of its own: put #### for its number into the name",
                path.display()
            )));
        }
        let named = |path: &Path, frame: u32| numbered(path, frame).unwrap_or_else(|| path.to_owned());
        let shot = |frame: u32| Shot {
            frame: Some(frame),
            outputs: outputs.iter().map(|path| named(path, frame)).collect(),
            stats: stats.map(|path| named(path, frame)),
            checkpoint: checkpoint.map(|path| named(path, frame)),
            preview: preview.map(|path| named(path, frame)),
        };
        Ok((first..=last).map(shot).collect())
    }

    /// Whether the camera may move.
    pub fn moves(&self) -> bool {
        self.frames.is_some() || self.camera_path.is_some()
    }

    /// Whether `shot` was made by an earlier call and is to be left out.
    pub fn is_left_out(&self, shot: &Shot) -> bool {
        self.skip_existing && shot.outputs.iter().all(|path| path.exists())
    }

    /// Gives `scene` the camera path that a flag names; what to warn of.
    ///
    /// # Errors
    /// [`Error::Read`] and [`Error::Parse`] of the file.
    pub fn place(&self, scene: &mut SceneDesc) -> Result<Option<String>> {
        if let Some(path) = &self.camera_path {
            (scene.camera, scene.camera_path) = load_camera_path(path)?;
        }
        let still = scene.camera_path.keys().is_empty() && self.frames.is_some_and(|frames| frames.first < frames.last);
        Ok(still.then(|| {
            "the camera does not move: the scene has no [[camera.key]], and no --camera-path is given".to_owned()
        }))
    }

    /// The camera of `scene` in `frame`; that of an image by itself where it does not move, or in no frame.
    pub fn camera(&self, scene: &SceneDesc, frame: Option<u32>) -> CameraDesc {
        let at = frame.and_then(|frame| scene.camera_path.at_frame(i64::from(frame), self.fps));
        at.unwrap_or(scene.camera)
    }

    /// The frames of a scene, prepared from `scene`.
    pub fn sequence<'a>(&self, scene: &SceneDesc, prepared: &'a PreparedScene) -> Sequence<'a> {
        Sequence::new(prepared, scene.camera_path.clone(), self.fps, self.train_frames)
    }
}

/// `path` with the frame's number in place of the last run of `#` in its name; `None` where there is none.
fn numbered(path: &Path, frame: u32) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let end = name.rfind('#')? + 1;
    let start = name[..end].trim_end_matches('#').len();
    Some(path.with_file_name(format!("{}{frame:0width$}{}", &name[..start], &name[end..], width = end - start)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_a_range_or_one() {
        assert_eq!(Frames::parse("3..12"), Ok(Frames { first: 3, last: 12 }));
        assert_eq!(Frames::parse("7"), Ok(Frames { first: 7, last: 7 }));
        for text in ["", "..", "3..", "..4", "-1..2", "1.5", "4..3", "1...3", "a..b", "99999999999"] {
            assert!(Frames::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_stand_where_the_name_has_them() {
        let of = |path: &str| numbered(Path::new(path), 42).map(|path| path.display().to_string());
        assert_eq!(of("out#/a.####.exr").as_deref(), Some("out#/a.0042.exr"));
        assert_eq!(of("#.png").as_deref(), Some("42.png"));
        assert_eq!(of("take#2_##.exr").as_deref(), Some("take#2_42.exr"));
        assert_eq!((of("a.exr"), of("####/a.exr")), (None, None));
    }

    #[test]
    fn every_frame_has_its_files() {
        let args = |frames: Option<&str>| FrameArgs {
            frames: frames.map(|text| Frames::parse(text).unwrap()),
            fps: 24.0,
            camera_path: None,
            train_frames: TRAIN_FRAMES,
            skip_existing: false,
        };
        let outputs = ["a.##.exr", "b#.png"].map(PathBuf::from);
        fn of<'a>(outputs: &'a [PathBuf], stats: Option<&'a Path>) -> Names<'a> {
            Names { outputs, stats, checkpoint: None, preview: None }
        }
        let shots = args(Some("9..10")).shots(of(&outputs, Some(Path::new("s#.json")))).unwrap();
        let files =
            |shot: &Shot| shot.outputs.iter().chain(&shot.stats).map(|path| path.display().to_string()).collect();
        let files: Vec<Vec<String>> = shots.iter().map(files).collect();
        assert_eq!(files, [["a.09.exr", "b9.png", "s9.json"], ["a.10.exr", "b10.png", "s10.json"]]);
        // One frame may go to a plain name, several may not.
        let plain = [PathBuf::from("a.exr")];
        assert_eq!(args(Some("9")).shots(of(&plain, None)).unwrap()[0].outputs, plain);
        assert!(args(Some("9..10")).shots(of(&plain, None)).is_err());
        assert_eq!(args(None).shots(of(&outputs, None)).unwrap()[0].outputs, outputs);
    }
}
