//! What image files hold beside radiance, and how.

use crate::cli::args::{List, list, list_help};
use crate::error::{Error, Result};
use crate::film::{Encoding, Film};
use crate::image::Format;
use crate::settings::{Layer, Settings};
use std::path::{Path, PathBuf};

/// Flags of layers and alpha.
#[derive(clap::Args)]
pub struct LayerArgs {
    // Without a value the settings' own, variance alone.
    #[arg(long, value_name = "LIST", help = layers_help(), value_parser = |text: &str| list(text, Layer::ALL))]
    layers: Option<List<Layer>>,
    /// Albedo and normals of what is seen in mirrors and through glass, in place of those of mirrors and glass
    #[arg(long, requires = "layers")]
    layers_through_specular: bool,
    /// Black and no alpha where the camera sees the environment, which still lights the scene and shows in mirrors and glass;
    /// EXR (associated) and PNG (not associated) then have alpha, the share of a pixel that something covers
    #[arg(long)]
    hide_environment: bool,
}

fn layers_help() -> String {
    let what = "What an EXR file holds beside radiance, for denoisers and compositors: albedo is Albedo.RGB, normal N.XYZ \
                (geometric) and Ns.XYZ (shading), depth Z, variance variance.RGB";
    list_help(what, Layer::ALL, "variance")
}

impl LayerArgs {
    /// Puts the flags over `settings`.
    pub fn apply(&self, settings: &mut Settings) {
        if let Some(List(layers)) = &self.layers {
            settings.layers.clone_from(layers);
        }
        settings.layers_through_specular = self.layers_through_specular;
        settings.hide_environment = self.hide_environment;
    }

    /// Whether one of `outputs` can hold what is asked for.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn check(&self, outputs: &[PathBuf]) -> Result<()> {
        if self.layers.is_some() {
            check(outputs, "--layers", &[Format::Exr], "layers are in .exr files alone: add -o NAME.exr")?;
        }
        if self.hide_environment {
            let where_to = "alpha is in .exr and .png files alone: add -o NAME.exr or -o NAME.png";
            check(outputs, "--hide-environment", &[Format::Exr, Format::Png], where_to)?;
        }
        Ok(())
    }
}

/// Flags of how EXR files hold numbers.
#[derive(clap::Args)]
pub struct EncodingArgs {
    /// EXR files in half precision (f16), but for Z and the variance
    #[arg(long)]
    half: bool,
    /// EXR files compressed by ZIP, without loss
    #[arg(long)]
    zip: bool,
}

impl EncodingArgs {
    /// How EXR files are to hold numbers.
    pub fn encoding(&self) -> Encoding {
        Encoding { half: self.half, zip: self.zip }
    }

    /// Whether one of `outputs` is a file that this is about.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn check(&self, outputs: &[PathBuf]) -> Result<()> {
        for (given, flag) in [(self.half, "--half"), (self.zip, "--zip")] {
            if given {
                check(outputs, flag, &[Format::Exr], "it says how .exr files are written: add -o NAME.exr")?;
            }
        }
        Ok(())
    }

    /// Refuses what says nothing of a part.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn check_part(&self) -> Result<()> {
        for (given, flag) in [(self.half, "--half"), (self.zip, "--zip")] {
            if given {
                return Err(Error::Usage(format!("{flag}: parts are no images: give it to octray merge")));
            }
        }
        Ok(())
    }

    /// What f16 cannot hold of `film`, in a sentence.
    pub fn beyond_half(&self, film: &Film, outputs: &[PathBuf]) -> Option<String> {
        let count =
            if self.half && outputs.iter().any(|path| is(path, &[Format::Exr])) { film.beyond_half() } else { 0 };
        (count > 0).then(|| {
            format!("--half: {count} pixels are brighter than 65504, the largest f16, which stands in their place: leave it out")
        })
    }
}

/// That the layers of a film, or its alpha, are in none of `outputs`.
pub fn left_out(film: &Film, outputs: &[PathBuf]) -> Option<String> {
    let formats = if film.layers.alpha { &[Format::Exr, Format::Png][..] } else { &[Format::Exr] };
    let lost = !film.layers.pixels.is_empty() && !outputs.iter().any(|path| is(path, formats));
    lost.then(|| "the parts have layers or alpha, which are left out: .exr files hold them".to_owned())
}

fn is(path: &Path, formats: &[Format]) -> bool {
    Format::of(path).is_ok_and(|format| formats.contains(&format))
}

fn check(outputs: &[PathBuf], flag: &str, formats: &[Format], what_to_do: &str) -> Result<()> {
    if outputs.iter().any(|path| is(path, formats)) {
        return Ok(());
    }
    let names: Vec<String> = outputs.iter().map(|path| path.display().to_string()).collect();
    Err(Error::Usage(format!("{flag}: {} cannot hold that; {what_to_do}", names.join(", "))))
}
