//! Materials: the metallic-roughness model and what extensions add to it.

use super::file::File;
use super::textures::{Placement, decode, image_of};
use crate::scene::desc::{MaskDesc, MaterialDesc, Scattering, SceneDesc, TextureDesc, TextureUse};
use crate::scene::warnings::{MOST_LETTERS, shortened};
use ::image::DynamicImage;
use gltf::json::material::{AlphaMode, Material};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use std::collections::HashMap;

/// The materials that have been met so far.
#[derive(Default)]
pub struct Materials {
    /// By their numbers in the file; `None` is the one of primitives that name none.
    made: HashMap<Option<usize>, Made>,
    /// By the number of the image, the numbers of textures, or why there is none.
    textures: HashMap<usize, Result<u32, String>>,
    /// By the number of the image and the bits of what multiplies its opacities.
    masks: HashMap<(usize, u32), Result<u32, String>>,
    /// Mean green and blue numbers of images, from 0 to 1.
    means: HashMap<usize, Result<[f64; 2], String>>,
}

/// A material of the scene.
#[derive(Clone, Copy)]
pub struct Made {
    /// Its number there.
    pub number: u32,
    /// How its textures lie.
    pub placement: Placement,
    /// Nothing is seen of it.
    pub hidden: bool,
}

impl Materials {
    /// Material number `index` of the file, made when it is first asked for.
    pub fn get(&mut self, file: &File<'_>, index: Option<usize>, scene: &mut SceneDesc) -> Made {
        if let Some(made) = self.made.get(&index) {
            return *made;
        }
        let default = Material::default();
        let material = index.and_then(|index| file.root.materials.get(index)).unwrap_or(&default);
        let name = material.name.clone().filter(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| index.map_or("default".into(), |index| format!("material {index}")));
        let name = shortened(&name, MOST_LETTERS).into_owned();
        let mut maker = Maker { file, material, name, materials: self, scene, placement: None };
        let (desc, hidden) = maker.make();
        let placement = maker.placement.unwrap_or_default();
        scene.materials.push(desc);
        let made = Made { number: scene.materials.len() as u32 - 1, placement, hidden };
        self.made.insert(index, made);
        made
    }
}

/// One material being made.
struct Maker<'a> {
    file: &'a File<'a>,
    material: &'a Material,
    name: String,
    materials: &'a mut Materials,
    scene: &'a mut SceneDesc,
    /// How the first texture lies; the others must lie alike.
    placement: Option<Placement>,
}

impl Maker<'_> {
    fn warn(&mut self, what: impl std::fmt::Display) {
        let warning = format!("{}: material `{}`: {what}", self.file.path.display(), self.name);
        self.scene.warnings.push(warning);
    }

    /// The material, and whether nothing is seen of it.
    fn make(&mut self) -> (MaterialDesc, bool) {
        let material = self.material;
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, alpha] = pbr.base_color_factor.0.map(|c| f64::from(c).clamp(0.0, 1.0));
        let base_color = [r, g, b];
        let texture = pbr.base_color_texture.as_ref().and_then(|info| self.texture(info, "base colour texture"));
        let extensions = material.extensions.as_ref();
        let mut desc = MaterialDesc {
            name: self.name.clone(),
            texture,
            two_sided: material.double_sided,
            ..MaterialDesc::default()
        };
        let (alpha_mask, hidden) = self.alpha_mask(pbr.base_color_texture.as_ref(), alpha);
        desc.alpha_mask = alpha_mask;
        if extensions.is_some_and(|all| all.unlit.is_some()) {
            self.warn("it is unlit: it shines with its colour");
            (desc.emission, desc.emission_texture, desc.texture) = (base_color, texture, None);
            return (desc, hidden);
        }
        desc.scattering = self.scattering(base_color);
        if !matches!(desc.scattering, Scattering::Principled { .. }) && desc.texture.take().is_some() {
            self.warn("glass has no texture: its colour alone is kept");
        }
        let strength = extensions.and_then(|all| all.emissive_strength.as_ref()).map_or(1.0, |s| s.emissive_strength.0);
        desc.emission = material.emissive_factor.0.map(|c| f64::from(c) * f64::from(strength));
        if desc.emission != [0.0; 3] {
            let info = material.emissive_texture.as_ref();
            desc.emission_texture = info.and_then(|info| self.texture(info, "emissive texture"));
        }
        if material.normal_texture.is_some() {
            self.warn("its normal map is not kept: it is as smooth as its mesh");
        }
        if material.occlusion_texture.is_some() {
            self.warn("its occlusion texture is not used: paths find out what is occluded");
        }
        for name in extensions.map(|all| all.others.keys()).into_iter().flatten() {
            if name != VOLUME {
                self.warn(format_args!("`{name}` is not kept"));
            }
        }
        (desc, hidden)
    }

    /// How the surface scatters.
    fn scattering(&mut self, base_color: [f64; 3]) -> Scattering {
        let pbr = &self.material.pbr_metallic_roughness;
        let [mut roughness, mut metallic] = [pbr.roughness_factor.0, pbr.metallic_factor.0].map(f64::from);
        let extensions = self.material.extensions.as_ref();
        let ior = extensions.and_then(|all| all.ior.as_ref()).map_or(1.5, |ior| f64::from(ior.ior.0));
        if let Some(info) = &pbr.metallic_roughness_texture {
            match self.means(info) {
                Ok([green, blue]) => {
                    (roughness, metallic) = (roughness * green, metallic * blue);
                    self.warn("of its metallic-roughness texture the mean is kept");
                }
                Err(why) => self.warn(format_args!("cannot read its metallic-roughness texture ({why})")),
            }
        }
        let [roughness, metallic] = [roughness, metallic].map(|share| share.clamp(0.0, 1.0));
        let transmission = extensions.and_then(|all| all.transmission.as_ref());
        let share = transmission.map_or(0.0, |transmission| f64::from(transmission.transmission_factor.0));
        if share * (1.0 - metallic) >= 0.5 {
            let solid = extensions.and_then(|all| all.others.get(VOLUME)).is_some_and(|volume| {
                volume.get("thicknessFactor").and_then(|thickness| thickness.as_f64()).is_some_and(|t| t > 0.0)
            });
            self.warn(match solid {
                true => "it transmits light: it is smooth glass, without absorption along the way",
                false => "it transmits light and is thin: what it transmits goes straight on, and it reflects nothing",
            });
            let ior = if solid && ior > 0.0 { ior } else { 1.0 };
            return Scattering::Dielectric { ior, transmittance: base_color };
        }
        if share > 0.0 {
            self.warn(format_args!("it transmits {share} of the light, less than half: it is opaque"));
        }
        // An index of 0 asks for a coat that reflects everything.
        let least = if ior > 0.0 { 1.0 } else { 1e3 };
        Scattering::Principled { base_color, metallic, roughness, ior: ior.max(least) }
    }

    /// The texture that `info` names; a warning if there is none to be had.
    fn texture(&mut self, info: &Info, what: &str) -> Option<TextureUse> {
        let image = self.image(info, what)?;
        let (file, scene) = (self.file, &mut *self.scene);
        let made = self.materials.textures.entry(image).or_insert_with(|| {
            let picture = decode(file, image)?.to_rgb8();
            let (width, height) = picture.dimensions();
            let texels = picture.pixels().map(|pixel| pixel.0).collect();
            scene.textures.push(TextureDesc { name: format!("images[{image}]"), width, height, texels });
            Ok(scene.textures.len() as u32 - 1)
        });
        let made = made.clone();
        self.used(made, what)
    }

    /// The number of the image that `info` names, if it lies as the material's other textures do.
    fn image(&mut self, info: &Info, what: &str) -> Option<usize> {
        let placement = Placement::new(self.file, info);
        let first = *self.placement.get_or_insert(placement);
        if (first.set, first.rows) != (placement.set, placement.rows) {
            self.warn(format_args!("its {what} lies otherwise than its other textures and is not kept"));
            return None;
        }
        match image_of(self.file, info.index) {
            Ok(image) => Some(image),
            Err(why) => {
                self.warn(format_args!("cannot read its {what} ({why}): its colour instead"));
                None
            }
        }
    }

    /// A picture that was read, or a warning.
    fn used(&mut self, made: Result<u32, String>, what: &str) -> Option<TextureUse> {
        match made {
            Ok(texture) => Some(TextureUse { texture, scale: [1.0; 2], offset: [0.0; 2] }),
            Err(why) => {
                self.warn(format_args!("cannot read its {what} ({why}): its colour instead"));
                None
            }
        }
    }

    /// Where the surface is, and whether that is nowhere.
    fn alpha_mask(&mut self, info: Option<&Info>, alpha: f64) -> (Option<TextureUse>, bool) {
        let cutoff = match self.material.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => self.material.alpha_cutoff.map_or(0.5, |cutoff| f64::from(cutoff.0)),
            Checked::Valid(AlphaMode::Blend) => {
                self.warn("it is not blended but cut out where its alpha is below one half");
                0.5
            }
            _ => return (None, false),
        };
        // Masks hide what is below one half.
        let factor = if cutoff > 0.0 { 0.5 * alpha / cutoff } else { f64::INFINITY };
        let Some(info) = info else { return (None, factor < 0.5) };
        let Some(image) = self.image(info, "alpha channel") else { return (None, factor < 0.5) };
        let (file, scene) = (self.file, &mut *self.scene);
        let made = self.materials.masks.entry((image, (factor as f32).to_bits())).or_insert_with(|| {
            let picture = decode(file, image)?;
            let opacities = |picture: DynamicImage| picture.to_rgba8().pixels().map(|pixel| pixel.0[3]).collect();
            let (width, height, texels): (_, _, Vec<u8>) = (picture.width(), picture.height(), opacities(picture));
            let scaled = |texel: u8| (f64::from(texel) * factor).round().min(255.0) as u8;
            let texels = texels.into_iter().map(|texel| if factor.is_finite() { scaled(texel) } else { 255 }).collect();
            scene.masks.push(MaskDesc { name: format!("images[{image}]"), width, height, texels });
            Ok(scene.masks.len() as u32 - 1)
        });
        let made = made.clone();
        // A mask that hides nothing costs every ray that meets it.
        let whole = |texture: u32| self.scene.masks[texture as usize].texels.iter().all(|&texel| texel >= 128);
        match made {
            Ok(texture) if whole(texture) => (None, false),
            made => (self.used(made, "alpha channel"), false),
        }
    }

    /// The mean green and blue of a picture, as linear numbers from 0 to 1.
    fn means(&mut self, info: &Info) -> Result<[f64; 2], String> {
        let (file, image) = (self.file, image_of(self.file, info.index)?);
        let made = self.materials.means.entry(image).or_insert_with(|| {
            let picture = decode(file, image)?.to_rgb8();
            let count = f64::from(picture.width()) * f64::from(picture.height());
            let mean = |channel: usize| picture.pixels().map(|pixel| f64::from(pixel.0[channel])).sum::<f64>();
            Ok([1, 2].map(|channel| mean(channel) / (255.0 * count)))
        });
        made.clone()
    }
}

/// The extension of solid bodies.
const VOLUME: &str = "KHR_materials_volume";
