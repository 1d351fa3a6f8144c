//! MTL text into materials: a first pass checks every value tobj reads (it panics on a colour of fewer than three
//! numbers) and knows the lines; tobj then reads the file; the rules of the scene format give each material its kind.

use crate::error::{Error, Result};
use crate::import::obj::lines::{logical_lines, split_keyword, values};
use crate::scene::validate::{IOR_RANGE, LEAST_COAT_IOR, MOST_RADIANCE};
use std::fmt::Write;
use std::path::{Path, PathBuf};

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
    /// Ni where it is above 1, else 1.5.
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

/// A picture that an MTL names.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureRef {
    /// The file.
    pub path: PathBuf,
    /// Option -s: factors on the coordinates.
    pub scale: [f64; 2],
    /// Option -o: added to them.
    pub offset: [f64; 2],
    /// The colour beside it is black or missing: without the picture there is none.
    pub alone: bool,
}

impl MtlMaterial {
    /// The grey of what has no material.
    pub fn grey(name: &str) -> MtlMaterial {
        MtlMaterial {
            name: name.to_owned(),
            kind: MtlKind::Diffuse,
            diffuse: GREY,
            specular: GREY,
            alpha: 1.0,
            ior: DEFAULT_IOR,
            emission: [0.0; 3],
            texture: None,
            emission_texture: None,
            alpha_mask: None,
        }
    }
}

/// Reads the bytes of the MTL file `path`. Warnings are appended to `warnings`.
pub fn parse_mtl(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<Vec<MtlMaterial>> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let clean = clean_mtl(path, text)?;
    let (materials, _) = tobj::load_mtl_buf(&mut clean.as_bytes())
        .map_err(|e| Error::parse(path, None, format!("not an MTL file: {e}")))?;
    Ok(materials.iter().map(|material| convert(path, material, warnings)).collect())
}

/// The lines that matter, in a form that tobj reads without failing.
fn clean_mtl(path: &Path, text: &str) -> Result<String> {
    let mut clean = String::new();
    for (number, line) in logical_lines(text) {
        let (keyword, rest) = split_keyword(&line);
        let fault = |message: String| Error::parse(path, Some(number), message);
        // Writing to a String cannot fail.
        let _ = match keyword {
            "newmtl" if rest.is_empty() => return Err(fault("`newmtl` needs a name".into())),
            "newmtl" => writeln!(clean, "newmtl {rest}"),
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
            "map_Kd" | "map_Ke" | "map_d" if !rest.is_empty() => writeln!(clean, "{keyword} {rest}"),
            _ => Ok(()),
        };
    }
    Ok(clean)
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

/// The file that stands behind the options of a `map_` line, and what those say.
fn texture_ref(mtl: &Path, material: &str, text: &str, warnings: &mut Vec<String>) -> Option<TextureRef> {
    let (mut scale, mut offset) = ([1.0; 2], [0.0; 2]);
    let mut ignored = Vec::new();
    let mut rest = text.trim();
    while rest.starts_with('-') {
        let (option, mut behind) = split_keyword(rest);
        let (fewest, most) = match option {
            "-s" | "-o" | "-t" => (1, 3),
            "-mm" => (2, 2),
            "-bm" | "-boost" | "-texres" | "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-type" => (1, 1),
            _ => break, // a file name with a dash in front
        };
        let mut numbers = Vec::new();
        for place in 0..most {
            let (word, next) = split_keyword(behind);
            let number = word.parse::<f64>().ok().filter(|x| x.abs() < 1e6);
            if place >= fewest && number.is_none() {
                break;
            }
            numbers.push(number);
            behind = next;
        }
        match option {
            "-s" | "-o" => {
                let target = if option == "-s" { &mut scale } else { &mut offset };
                numbers.iter().zip(target).for_each(|(number, slot)| *slot = number.unwrap_or(*slot));
            }
            _ => ignored.push(option),
        }
        rest = behind;
    }
    if !ignored.is_empty() {
        let (file, options) = (mtl.display(), ignored.join(" "));
        warnings.push(format!("{file}: material `{material}`: texture options {options} have no effect"));
    }
    // Exporters on Windows write backslashes.
    let file = mtl.with_file_name("");
    let as_written = file.join(rest);
    let path = if as_written.exists() { as_written } else { file.join(rest.replace('\\', "/")) };
    (!rest.is_empty()).then_some(TextureRef { path, scale, offset, alone: false })
}

fn convert(path: &Path, material: &tobj::Material, warnings: &mut Vec<String>) -> MtlMaterial {
    let name = &material.name;
    let mut bounded = |keyword: &str, value: Option<[f64; 3]>, largest: f64| {
        // The first pass has written f32 numbers.
        let value = value.map(|v| v.map(|x| x as f32));
        if let Some(v) = value.filter(|v| !v.iter().all(|&x| (0.0..=largest).contains(&x.into()))) {
            let limit = if largest > 1.0 { "below 0" } else { "outside [0, 1]" };
            let file = path.display();
            warnings.push(format!("{file}: material `{name}`: {keyword} {v:?} is {limit} and was clamped"));
        }
        value.map(|v| v.map(|x| f64::from(x).clamp(0.0, largest)))
    };
    let mut diffuse = bounded("Kd", material.diffuse, 1.0);
    let specular = bounded("Ks", material.specular, 1.0);
    let mut emission = bounded("Ke", material.emissive, f64::MAX);
    let extra = |key: &str| material.unknown_param.get(key).and_then(|text| text.parse::<f64>().ok());
    let shines = |colour: Option<[f64; 3]>| colour.is_some_and(|c| c != [0.0; 3]);
    let mut reference = |text: Option<&String>| text.and_then(|text| texture_ref(path, name, text, warnings));
    let mut texture = reference(material.diffuse_texture.as_ref());
    let mut emission_texture = reference(material.unknown_param.get("map_Ke"));
    let alpha_mask = reference(material.dissolve_texture.as_ref());
    // Kd and map_Kd multiply, as the format says; beside a picture, black or nothing means: the picture alone.
    for (colour, picture) in [(&mut diffuse, &mut texture), (&mut emission, &mut emission_texture)] {
        if let (Some(picture), false) = (picture, shines(*colour)) {
            (*colour, picture.alone) = (Some([1.0; 3]), true);
        }
    }
    let of_f32 = |x: f64| f64::from(x as f32);
    let transparent = material.dissolve.is_some_and(|d| d < 1.0) || extra("Tr").is_some_and(|tr| tr > 0.0);
    let kind = match material.illumination_model {
        Some(5) => MtlKind::Mirror,
        Some(4 | 6 | 7) => MtlKind::Dielectric,
        _ if transparent && material.optical_density.is_some() => MtlKind::Dielectric,
        _ if extra("Pm").is_some_and(|pm| pm >= 0.5) => MtlKind::Conductor,
        _ if shines(diffuse) && shines(specular) => MtlKind::Plastic,
        _ if shines(specular) => MtlKind::Conductor,
        _ => MtlKind::Diffuse,
    };
    // An entry that says nothing of light is as good as none; one that shines or mirrors reflects only what it names.
    let fallback = if specular.is_some() || emission.is_some() { [0.0; 3] } else { GREY };
    let diffuse = diffuse.unwrap_or(fallback);
    // A Phong exponent as a GGX width: lobes of equal curvature at the top (Walter et al. 2007).
    let exponent = material.shininess.map_or(0.0, of_f32).max(0.0);
    let roughness = extra("Pr").map(|pr| pr.clamp(0.0, 1.0));
    let alpha = roughness.map_or((2.0 / (exponent + 2.0)).sqrt(), |pr| pr * pr);
    let ior = material.optical_density.map(of_f32).filter(|&ni| ni > 1.0);
    MtlMaterial {
        name: name.clone(),
        kind,
        alpha,
        ior: ior.map_or(DEFAULT_IOR, |ni| ni.clamp(LEAST_COAT_IOR, *IOR_RANGE.end())),
        diffuse,
        specular: specular.unwrap_or(diffuse),
        emission: emission.unwrap_or_default(),
        texture,
        emission_texture,
        alpha_mask,
    }
}
