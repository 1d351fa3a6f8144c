//! Pictures that materials name, put on their materials.

use crate::error::{Error, Result};
use crate::import::assembly::Assembly;
use crate::import::obj::maps::TextureRef;
use crate::import::obj::mtl::{GREY, MtlMaterial};
use crate::import::pictures::{read_mask, read_texture};
use crate::import::toml::parse::MaterialEntry;
use crate::scene::desc::{MaskDesc, MaterialDesc, Scattering, TextureUse};
use std::path::Path;

impl Assembly<'_> {
    /// Loads the pictures of a material. One that the TOML names must be there; where one that an MTL names is not, its
    /// colour stays.
    pub(super) fn add_images(
        &mut self,
        resolved: &mut MaterialDesc,
        material: &MtlMaterial,
        entry: Option<&MaterialEntry>,
    ) -> Result<()> {
        let name = &resolved.name;
        let textured = match &mut resolved.scattering {
            Scattering::Diffuse { albedo } | Scattering::Plastic { albedo, .. } => Some(albedo),
            Scattering::Principled { base_color, .. } => Some(base_color),
            _ => None,
        };
        let has_color = textured.is_some();
        // A kind has one of them.
        let named_color = entry.and_then(|e| e.albedo.or(e.base_color));
        if let Some((file, line)) = entry.and_then(|e| e.texture.as_ref()) {
            let fault = |why: String| Error::parse(self.path, Some(*line), format!("[material.{name}]: {why}"));
            let Some(color) = textured else {
                return Err(fault("only diffuse, plastic and principled have a `texture`: add a `kind`".into()));
            };
            let path = self.path.with_file_name("").join(file);
            let texture = self.texture(&path).map_err(|why| fault(format!("texture `{file}`: {why}")))?;
            // The picture alone, unless the entry itself says by what to multiply it.
            *color = named_color.unwrap_or([1.0; 3]);
            resolved.texture = Some(TextureUse { texture, scale: [1.0; 2], offset: [0.0; 2] });
        } else if let (Some(reference), Some(color), None) = (&material.texture, textured, named_color) {
            resolved.texture = self.mtl_texture(name, reference);
            if resolved.texture.is_none() && reference.alone {
                *color = GREY;
            }
        } else if let (Some(reference), false, None) = (&material.texture, has_color, entry.and_then(|e| e.kind)) {
            // Not where the scene file has chosen the kind: there nobody expects it.
            let file = reference.path.display();
            let kind = match resolved.scattering {
                Scattering::Conductor { .. } => "conductor",
                Scattering::Dielectric { .. } => "dielectric",
                _ => "mirror",
            };
            let warning = format!("{file}: map_Kd has no effect on material `{name}`, a {kind}");
            self.scene.warnings.push(warning);
        }
        if let (Some(reference), None) = (&material.emission_texture, entry.and_then(|e| e.emission)) {
            resolved.emission_texture = self.mtl_texture(name, reference);
            if resolved.emission_texture.is_none() && reference.alone {
                resolved.emission = [0.0; 3];
            }
        }
        if let Some((file, line)) = entry.and_then(|e| e.cutout.as_ref()) {
            let path = self.path.with_file_name("").join(file);
            let texture = self.mask(&path).map_err(|why| {
                Error::parse(self.path, Some(*line), format!("[material.{name}]: cutout `{file}`: {why}"))
            })?;
            resolved.alpha_mask = Some(TextureUse { texture, scale: [1.0; 2], offset: [0.0; 2] });
        } else if let Some(TextureRef { path, scale, offset, .. }) = &material.alpha_mask {
            match self.mask(path) {
                Ok(texture) => resolved.alpha_mask = Some(TextureUse { texture, scale: *scale, offset: *offset }),
                Err(why) => {
                    let file = path.display();
                    let warning = format!("{file}: cannot read the cut-out of material `{name}` ({why}): it is whole");
                    self.scene.warnings.push(warning);
                }
            }
        }
        Ok(())
    }

    /// The picture that an MTL names; a warning if it cannot be read.
    fn mtl_texture(&mut self, material: &str, reference: &TextureRef) -> Option<TextureUse> {
        let TextureRef { path, scale, offset, .. } = reference;
        match self.texture(path) {
            Ok(texture) => Some(TextureUse { texture, scale: *scale, offset: *offset }),
            Err(why) => {
                let file = path.display();
                let warning =
                    format!("{file}: cannot read the texture of material `{material}` ({why}): its colour instead");
                self.scene.warnings.push(warning);
                None
            }
        }
    }

    /// The number of the picture in `path`, read once.
    fn texture(&mut self, path: &Path) -> std::result::Result<u32, String> {
        self.texture_numbers.get_or(path, || {
            self.scene.textures.push(read_texture(path)?);
            Ok(self.scene.textures.len() as u32 - 1)
        })
    }

    /// The number of the mask in `path`, read once.
    fn mask(&mut self, path: &Path) -> std::result::Result<u32, String> {
        self.mask_numbers.get_or(path, || {
            let mask = read_mask(path)?;
            self.scene.warnings.extend(mask_warning(&mask));
            self.scene.masks.push(mask);
            Ok(self.scene.masks.len() as u32 - 1)
        })
    }
}

/// Why a mask is not what its maker wanted, if so.
fn mask_warning(mask: &MaskDesc) -> Option<String> {
    let file = &mask.name;
    let hides = |texel: &u8| *texel < 128;
    match mask.texels.iter().any(hides) {
        false => Some(format!(
            "{file}: as a cut-out it masks nothing: all of its alpha channel (grey values where it has none) is one half or above"
        )),
        true if mask.texels.iter().all(hides) => {
            Some(format!("{file}: as a cut-out it masks everything: nothing is seen of its materials"))
        }
        true => None,
    }
}
