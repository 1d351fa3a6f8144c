//! Environment maps that scene files name.

use crate::error::{Error, Result};
use crate::image::Image;
use crate::scene::desc::{EnvironmentDesc, MapDesc};
use crate::scene::validate;
use std::path::Path;

/// Reads the environment map that `desc` names; `None` if it is all black. What cannot be radiance is an error where it is
/// infinite, and counts 0, with a warning, where it is negative or no number.
pub fn load_map(scene: &Path, line: usize, mut desc: MapDesc, warnings: &mut Vec<String>) -> Result<Option<MapDesc>> {
    let file = scene.with_file_name("").join(&desc.file);
    let fault = |message: String| Error::parse(scene, Some(line), format!("[environment]: {message}"));
    let mut image = Image::read(&file).map_err(|error| fault(error.to_string().replace('\n', ", ")))?;
    let name = file.display();
    if image.is_cube {
        let why = "its attribute `envmap` says that it is the six faces of a cube";
        return Err(fault(format!("{name}: {why}; make it latitude-longitude, as `exrenvmap -l` does")));
    }
    warnings.extend(std::mem::take(&mut image.warnings).into_iter().map(|warning| format!("{name}: {warning}")));
    let image = image.shown().map_err(|why| fault(format!("{name}: {why}")))?;
    (desc.width, desc.height, desc.texels) = (image.width, image.height, image.pixels);
    let mut mended = 0;
    for texel in &mut desc.texels {
        if texel.iter().any(|&c| c < 0.0 || c.is_nan()) {
            mended += 1;
            *texel = texel.map(|c| if c > 0.0 { c } else { 0.0 });
        }
    }
    if mended > 0 {
        warnings.push(format!("{name}: {mended} texels are negative or not a number; what is counts as 0"));
    }
    if let Some(i) = desc.texels.iter().position(|texel| texel.iter().any(|c| c.is_infinite())) {
        let (x, y) = (i as u32 % desc.width, i as u32 / desc.width);
        return Err(fault(format!("{name}: texel {x},{y} is infinite: clamp the map to what the light really is")));
    }
    if desc.texels.iter().all(|texel| *texel == [0.0; 3]) || desc.scale == 0.0 {
        warnings.push(format!("{name}: the environment map is black"));
        return Ok(None);
    }
    desc.file = name.to_string();
    let environment = EnvironmentDesc::Map(desc);
    match (validate::environment_fault(&environment), environment) {
        (Some(message), _) => Err(fault(message)),
        (None, EnvironmentDesc::Map(desc)) => Ok(Some(desc)),
        (None, EnvironmentDesc::Constant { .. }) => Ok(None),
    }
}
