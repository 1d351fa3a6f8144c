//! MTL text into materials: a first pass checks every value tobj reads (it panics on a colour of fewer than three
//! numbers) and knows the lines; tobj then reads the file; the rules of the scene format give each material its kind.

use crate::error::{Error, Result};
use crate::import::obj::encoding::decode;
use crate::import::obj::lines::{canonical, logical_lines, split_keyword, values};
use crate::import::obj::maps::{Maps, TextureRef, Unread, texture_ref};
use crate::scene::validate::{IOR_RANGE, LEAST_COAT_IOR, MOST_RADIANCE};
use std::fmt::Write;
use std::path::Path;

/// Albedo of what has no material at all.
pub const GREY: [f64; 3] = [0.5; 3];

/// The index of refraction of glass and coats that do not say.
pub const DEFAULT_IOR: f64 = 1.5;

/// What an MTL entry is, by the first rule that fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MtlKind {
    /// Lambertian, albedo Kd.
    Diffuse,
    /// illum 5: perfect mirror, reflectance Ks.
    Mirror,
    /// illum 4, 6, 7, or transparent with Ni.
    Dielectric,
    /// Pm of at least 0.5, or Ks without Kd.
    Conductor,
    /// Kd and Ks.
    Plastic,
}

/// One material of an MTL file.
#[derive(Clone, Debug, PartialEq)]
pub struct MtlMaterial {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: MtlKind,
    /// Kd, in [0, 1].
    pub diffuse: [f64; 3],
    /// Ks, or Kd where there is none, in [0, 1].
    pub specular: [f64; 3],
    /// GGX width: from Pr where there is one, else from Ns.
    pub alpha: f64,
    /// Pm, in [0, 1]; without one 0.
    pub metallic: f64,
    /// Of a dielectric Ni, of others Ni where it is above 1; else 1.5.
    pub ior: f64,
    /// Ke.
    pub emission: [f64; 3],
    /// map_Kd.
    pub texture: Option<TextureRef>,
    /// map_Ke.
    pub emission_texture: Option<TextureRef>,
    /// map_d.
    pub alpha_mask: Option<TextureRef>,
}

impl MtlMaterial {
    /// The index of refraction of a coat: one of 1 would not be there.
    pub fn coat_ior(&self) -> f64 {
        if self.ior > 1.0 { self.ior.max(LEAST_COAT_IOR) } else { DEFAULT_IOR }
    }

    /// The grey of what has no material.
    pub fn grey(name: &str) -> MtlMaterial {
        MtlMaterial {
            name: name.to_owned(),
            kind: MtlKind::Diffuse,
            diffuse: GREY,
            specular: GREY,
            alpha: 1.0,
            metallic: 0.0,
            ior: DEFAULT_IOR,
            emission: [0.0; 3],
            texture: None,
            emission_texture: None,
            alpha_mask: None,
        }
    }
}

/// Keywords that are read, in any capitals.
const KEYWORDS: [&str; 14] =
    ["newmtl", "Kd", "Ks", "Ke", "d", "Tr", "Ni", "Ns", "Pm", "Pr", "illum", "map_Kd", "map_Ke", "map_d"];

/// Reads the bytes of the MTL file `path`. Warnings are appended to `warnings`.
pub fn parse_mtl(path: &Path, bytes: Vec<u8>, warnings: &mut Vec<String>) -> Result<Vec<MtlMaterial>> {
    let text = decode(path, bytes)?;
    let Clean { text, maps } = clean_mtl(path, &text, warnings)?;
    let (materials, _) = tobj::load_mtl_buf(&mut text.as_bytes())
        .map_err(|e| Error::parse(path, None, format!("not an MTL file: {e}")))?;
    Ok(materials.iter().zip(maps).map(|(material, maps)| convert(path, material, maps, warnings)).collect())
}

/// What the first pass has found.
struct Clean {
    /// The lines that matter but for those of pictures, in a form that tobj reads without failing.
    text: String,
    /// The pictures of each material.
    maps: Vec<Maps>,
}

fn clean_mtl(path: &Path, text: &str, warnings: &mut Vec<String>) -> Result<Clean> {
    let (mut clean, mut maps, mut unread) = (String::new(), Vec::new(), Unread::default());
    let mut name = String::new();
    for (number, line) in logical_lines(text) {
        let (word, rest) = split_keyword(&line);
        let keyword = canonical(word, &KEYWORDS);
        let fault = |message: String| Error::parse(path, Some(number), message);
        // Writing to a String cannot fail.
        let _ = match keyword {
            "newmtl" if rest.is_empty() => return Err(fault("`newmtl` needs a name".into())),
            "newmtl" => {
                maps.push(Maps::default());
                rest.clone_into(&mut name);
                writeln!(clean, "newmtl {rest}")
            }
            // A spectrum or CIE colour is outside what we read: the entry counts as missing.
            "Kd" | "Ks" | "Ke" if matches!(values(rest).next(), Some("spectral" | "xyz")) => Ok(()),
            "Kd" | "Ks" | "Ke" => {
                let [r, g, b] = colour(keyword, rest).map_err(fault)?;
                if keyword == "Ke" && [r, g, b].iter().any(|&x| x > MOST_RADIANCE) {
                    let rule = format!("the largest radiance that works is {MOST_RADIANCE:e}");
                    return Err(fault(format!("`Ke {r:e} {g:e} {b:e}`: {rule}")));
                }
                writeln!(clean, "{keyword} {r} {g} {b}")
            }
            "d" | "Tr" | "Ni" | "Ns" | "Pm" | "Pr" => {
                let value = values(rest).find(|word| *word != "-halo").unwrap_or_default();
                writeln!(clean, "{keyword} {}", number_of(keyword, value).map_err(fault)?)
            }
            "illum" => {
                let value = values(rest).next().unwrap_or_default();
                let illum = number_of(keyword, value).map_err(fault)?;
                if !(illum.fract() == 0.0 && (0.0..=255.0).contains(&illum)) {
                    return Err(fault(format!("`illum {value}`: illumination models are numbered 0 to 10")));
                }
                writeln!(clean, "illum {illum}")
            }
            "map_Kd" | "map_Ke" | "map_d" => {
                let texture = texture_ref(path, number, &name, [keyword, rest], warnings)?;
                if let (Some(maps), Some(texture)) = (maps.last_mut(), texture) {
                    let slot = match keyword {
                        "map_Kd" => &mut maps.colour,
                        "map_Ke" => &mut maps.emission,
                        _ => &mut maps.alpha_mask,
                    };
                    *slot = Some(texture);
                }
                Ok(())
            }
            _ => {
                unread.count(number, word);
                Ok(())
            }
        };
    }
    unread.warn(path, warnings);
    Ok(Clean { text: clean, maps })
}

fn number_of(keyword: &str, word: &str) -> std::result::Result<f32, String> {
    match word.parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ if word.is_empty() => Err(format!("`{keyword}` needs a number")),
        _ => Err(format!("`{keyword} {word}`: not a finite number")),
    }
}

/// Three numbers, or one for all three as the MTL format allows.
fn colour(keyword: &str, rest: &str) -> std::result::Result<[f32; 3], String> {
    let words: Vec<&str> = values(rest).take(3).collect();
    match words[..] {
        [all] => number_of(keyword, all).map(|x| [x; 3]),
        [r, g, b] => Ok([number_of(keyword, r)?, number_of(keyword, g)?, number_of(keyword, b)?]),
        _ => Err(format!("`{keyword}` needs three numbers (red green blue); it has {}", words.len())),
    }
}

/// What `d` and `Tr` say of a material, if one of them says something.
fn transparency(d: Option<f64>, tr: Option<f64>, mut tell: impl FnMut(String)) -> Option<(String, bool)> {
    match (d, tr) {
        (Some(d), Some(tr)) if (d + tr - 1.0).abs() > 0.01 => {
            // Some programs mean opacity by both.
            tell(format!("d {d} and Tr {tr} contradict each other (Tr is 1 - d): d counts"));
            Some((format!("d {d}"), d < 1.0))
        }
        (Some(d), tr) => Some((format!("d {d}"), d < 1.0 || tr.is_some_and(|tr| tr > 0.0))),
        (None, Some(tr)) => Some((format!("Tr {tr}"), tr > 0.0)),
        (None, None) => None,
    }
}

/// The index of refraction of a material of this kind; where Ni is not what is used, and nobody could have meant that, it is said.
fn index_of_refraction(kind: MtlKind, ni: Option<f64>, mut tell: impl FnMut(String)) -> f64 {
    let (least, most) = (*IOR_RANGE.start(), *IOR_RANGE.end());
    let Some(ni) = ni else { return DEFAULT_IOR };
    let used = match kind {
        // 1 bends no light; below, the inside is the thinner medium.
        MtlKind::Dielectric if ni >= least => ni.min(most),
        MtlKind::Dielectric => DEFAULT_IOR,
        // A coat of 1 would not be there. Programs write 1 where nobody has chosen.
        _ if ni > 1.0 => ni.clamp(LEAST_COAT_IOR, most),
        _ => DEFAULT_IOR,
    };
    match kind {
        MtlKind::Dielectric if ni < 1.0 && ni == used => {
            tell(format!("Ni {} is below 1: light bends as it does from glass into air", ni as f32));
        }
        MtlKind::Dielectric | MtlKind::Plastic if used != ni && (ni < 1.0 || ni > most) => {
            tell(format!("Ni {} is no index of refraction of glass: {used} instead", ni as f32));
        }
        _ => {}
    }
    used
}

fn convert(path: &Path, material: &tobj::Material, maps: Maps, warnings: &mut Vec<String>) -> MtlMaterial {
    let name = &material.name;
    let mut tell = |what: String| warnings.push(format!("{}: material `{name}`: {what}", path.display()));
    let mut bounded = |keyword: &str, value: Option<[f64; 3]>, largest: f64| {
        // The first pass has written f32 numbers.
        let value = value.map(|v| v.map(|x| x as f32));
        if let Some(v) = value.filter(|v| !v.iter().all(|&x| (0.0..=largest).contains(&x.into()))) {
            let limit = if largest > 1.0 { "below 0" } else { "outside [0, 1]" };
            tell(format!("{keyword} {v:?} is {limit} and was clamped"));
        }
        value.map(|v| v.map(|x| f64::from(x).clamp(0.0, largest)))
    };
    let mut diffuse = bounded("Kd", material.diffuse, 1.0);
    let specular = bounded("Ks", material.specular, 1.0);
    let mut emission = bounded("Ke", material.emissive, f64::MAX);
    let extra = |key: &str| material.unknown_param.get(key).and_then(|text| text.parse::<f64>().ok());
    let shines = |colour: Option<[f64; 3]>| colour.is_some_and(|c| c != [0.0; 3]);
    let Maps { colour: mut texture, emission: mut emission_texture, alpha_mask } = maps;
    // Kd and map_Kd multiply, as the format says; beside a picture, black or nothing means: the picture alone.
    for (colour, picture) in [(&mut diffuse, &mut texture), (&mut emission, &mut emission_texture)] {
        if let (Some(picture), false) = (picture, shines(*colour)) {
            (*colour, picture.alone) = (Some([1.0; 3]), true);
        }
    }
    let of_f32 = |x: f64| f64::from(x as f32);
    let dissolved = transparency(material.dissolve, extra("Tr"), &mut tell).filter(|(_, transparent)| *transparent);
    let kind = match material.illumination_model {
        Some(5) => MtlKind::Mirror,
        Some(4 | 6 | 7) => MtlKind::Dielectric,
        _ if dissolved.is_some() && material.optical_density.is_some() => MtlKind::Dielectric,
        _ if extra("Pm").is_some_and(|pm| pm >= 0.5) => MtlKind::Conductor,
        _ if shines(diffuse) && shines(specular) => MtlKind::Plastic,
        _ if shines(specular) => MtlKind::Conductor,
        _ => MtlKind::Diffuse,
    };
    match dissolved {
        Some((said, _)) if kind == MtlKind::Mirror => {
            tell(format!("{said} has no effect: illum 5 is a mirror, which is opaque"))
        }
        Some((said, _)) if kind != MtlKind::Dielectric => {
            tell(format!("{said} without Ni has no effect: it stays opaque; glass has Ni, and Ni 1 bends no light"));
        }
        _ => {}
    }
    // An entry that says nothing of light is as good as none; one that shines or mirrors reflects only what it names.
    let fallback = if specular.is_some() || emission.is_some() { [0.0; 3] } else { GREY };
    let diffuse = diffuse.unwrap_or(fallback);
    // A Phong exponent as a GGX width: lobes of equal curvature at the top (Walter et al. 2007).
    let exponent = material.shininess.map_or(0.0, of_f32).max(0.0);
    let roughness = extra("Pr").map(|pr| pr.clamp(0.0, 1.0));
    let alpha = roughness.map_or((2.0 / (exponent + 2.0)).sqrt(), |pr| pr * pr);
    MtlMaterial {
        name: name.clone(),
        kind,
        alpha,
        metallic: extra("Pm").map_or(0.0, |pm| pm.clamp(0.0, 1.0)),
        ior: index_of_refraction(kind, material.optical_density.map(of_f32), &mut tell),
        diffuse,
        specular: specular.unwrap_or(diffuse),
        emission: emission.unwrap_or_default(),
        texture,
        emission_texture,
        alpha_mask,
    }
}
