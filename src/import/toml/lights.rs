//! What a scene file says of light: `[environment]` and `[[light]]`.

use crate::error::Result;
use crate::import::toml::reader::Table;
use crate::scene::desc::{DeltaLight, DeltaLightDesc};
use crate::scene::transform::versine;
use crate::scene::validate;
use crate::scene::validate::is_radiance;
use std::f64::consts::PI;

/// What `[environment]` says.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentEntry {
    /// The same from every direction.
    Constant {
        /// Radiance, W sr^-1 m^-2, scale included; not all 0.
        radiance: [f64; 3],
    },
    /// A picture.
    Map {
        /// Its file, as written.
        file: String,
        /// The line that names it.
        line: usize,
        /// Degrees about +y.
        rotate: f64,
        /// Factor from texels to radiance, at least 0.
        scale: f64,
    },
}

/// One `[[light]]`.
#[derive(Clone, Debug, PartialEq)]
pub enum LightEntry {
    /// A point, spot or directional light.
    Delta(DeltaLightDesc),
    /// A lamp of a shape.
    Lamp(LampEntry),
}

/// A sphere or a disk that emits.
#[derive(Clone, Debug, PartialEq)]
pub struct LampEntry {
    /// Its name.
    pub name: String,
    /// The line it begins at.
    pub line: usize,
    /// Its centre, scene units.
    pub position: [f64; 3],
    /// Its radius, above 0.
    pub radius: f64,
    /// Of a disk the normal of the side that emits; `None`: a sphere.
    pub normal: Option<[f64; 3]>,
    /// Radiance, W sr^-1 m^-2.
    pub radiance: [f64; 3],
    /// A disk whose back emits, too.
    pub two_sided: bool,
}

/// The kinds of light, with the keys that each has besides `kind` and `name`.
const KINDS: [(&str, &[&str]); 5] = [
    ("point", &["position", "intensity", "power"]),
    ("spot", &["position", "look_at", "direction", "intensity", "power", "cone_angle", "cone_delta_angle"]),
    ("directional", &["direction", "irradiance"]),
    ("sphere", &["position", "radius", "radiance", "power"]),
    ("disk", &["position", "look_at", "direction", "radius", "radiance", "power", "two_sided"]),
];

/// The cone of a spot light that does not say, and what of it fades, degrees: those of pbrt-v4.
const DEFAULT_CONE: (f64, f64) = (30.0, 5.0);

/// The `[[light]]` tables of a scene file.
pub(super) fn parse_lights(root: &Table<'_>) -> Result<Vec<LightEntry>> {
    let entries = root.tables("light", "a light is written [[light]], with double brackets")?;
    entries.iter().enumerate().map(|(i, table)| parse_light(table, i + 1)).collect()
}

fn parse_light(table: &Table<'_>, number: usize) -> Result<LightEntry> {
    let word = table.need("kind", table.string("kind")?)?;
    let Some(&(kind, keys)) = KINDS.iter().find(|(kind, _)| *kind == word) else {
        let names = KINDS.map(|(kind, _)| format!("\"{kind}\"")).join(", ");
        return Err(table.error_at("kind", format!("unknown kind \"{word}\"; known: {names}")));
    };
    let foreign =
        KINDS.iter().flat_map(|(_, keys)| *keys).find(|key| table.entries.contains_key(**key) && !keys.contains(key));
    if let Some(key) = foreign {
        let has = keys.join("`, `");
        return Err(table.error_at(key, format!("a {kind} light has no `{key}`; it has `{has}`")));
    }
    table.check_keys(&[&["kind", "name"], keys].concat(), &[])?;
    let name = table.string("name")?.map_or_else(|| format!("light {number}"), str::to_owned);
    let line = table.document.line(table.span.clone());
    let light = match kind {
        "point" => DeltaLight::Point { position: position(table)?, intensity: strength(table, "intensity", 4.0 * PI)? },
        "spot" => {
            let (cone, delta) = DEFAULT_CONE;
            let cone_angle = table.number("cone_angle")?.unwrap_or(cone);
            let cone_delta_angle = table.number("cone_delta_angle")?.unwrap_or(delta.min(cone_angle));
            // The smooth step between the angles has the mean of a straight one.
            let solid_angle = PI * (versine(cone_angle) + versine(cone_angle - cone_delta_angle));
            let position = position(table)?;
            let direction = direction(table, position)?;
            let intensity = strength(table, "intensity", solid_angle)?;
            DeltaLight::Spot { position, direction, intensity, cone_angle, cone_delta_angle }
        }
        "directional" => {
            let irradiance = table.need("irradiance", table.radiance("irradiance")?)?;
            DeltaLight::Directional { direction: table.need("direction", table.vector("direction")?)?, irradiance }
        }
        _ => return parse_lamp(table, kind == "disk", name, line).map(LightEntry::Lamp),
    };
    match validate::delta_light_fault(&light) {
        // The line of the key to change: the fault's text begins with its name.
        Some(fault) => Err(table.error_at(fault.split(' ').next().unwrap_or_default(), fault.as_str())),
        None => Ok(LightEntry::Delta(DeltaLightDesc { name, light })),
    }
}

fn parse_lamp(table: &Table<'_>, disk: bool, name: String, line: usize) -> Result<LampEntry> {
    let position = position(table)?;
    let radius = table.need("radius", table.number("radius")?)?;
    if radius <= 0.0 {
        return Err(table.error_at("radius", format!("`radius` is {radius}; it must be above 0")));
    }
    let two_sided = table.boolean("two_sided")?.unwrap_or(false);
    let normal = if disk { Some(direction(table, position)?) } else { None };
    let area = if disk { PI * radius * radius } else { 4.0 * PI * radius * radius };
    let sides = if two_sided { 2.0 } else { 1.0 };
    let radiance = strength(table, "radiance", PI * area * sides)?;
    Ok(LampEntry { name, line, position, radius, normal, radiance, two_sided })
}

fn position(table: &Table<'_>) -> Result<[f64; 3]> {
    table.need("position", table.vector("position")?)
}

/// Where a light looks, as a vector: `direction`, or from its position to `look_at`.
fn direction(table: &Table<'_>, position: [f64; 3]) -> Result<[f64; 3]> {
    let (key, direction) = match (table.vector("direction")?, table.vector("look_at")?) {
        (Some(_), Some(_)) => {
            return Err(table.error_at("look_at", "`direction` and `look_at` exclude each other: keep one"));
        }
        (None, None) => return Err(table.error("`look_at` or `direction` is missing")),
        (Some(direction), None) => ("direction", direction),
        (None, Some(look_at)) => ("look_at", std::array::from_fn(|i| look_at[i] - position[i])),
    };
    match validate::direction_fault(&direction) {
        Some(fault) if key == "direction" => Err(table.error_at(key, format!("`direction` {fault}"))),
        Some(_) => Err(table.error_at(key, "`look_at` is where the light is: move it to what the light shall face")),
        None => Ok(direction),
    }
}

/// What a light is as bright as: `key`, or `power` over what one unit of that sends out in all.
fn strength(table: &Table<'_>, key: &str, flux_of_one: f64) -> Result<[f64; 3]> {
    match (table.radiance(key)?, table.radiance("power")?) {
        (Some(_), Some(_)) => Err(table.error_at("power", format!("`{key}` and `power` exclude each other: keep one"))),
        (None, None) => Err(table.error(format!("`{key}` or `power` is missing"))),
        (Some(strength), None) => Ok(strength),
        (None, Some(power)) => {
            let strength = power.map(|watts| watts / flux_of_one);
            match strength.iter().all(|&x| is_radiance(x)) {
                true => Ok(strength),
                false => {
                    Err(table.error_at("power", format!("`power` makes the light too bright: {key} {strength:?}")))
                }
            }
        }
    }
}

/// `[environment]`; `None` where nothing of it shines.
pub(super) fn parse_environment(table: &Table<'_>) -> Result<Option<EnvironmentEntry>> {
    table.check_keys(&["radiance", "map", "rotate", "scale"], &[])?;
    let scale = table.number("scale")?.unwrap_or(1.0);
    if scale < 0.0 {
        return Err(table.error_at("scale", "`scale` is negative; light cannot be"));
    }
    let (radiance, map) = (table.radiance("radiance")?, table.string("map")?);
    let Some(radiance) = radiance else {
        let file = map.ok_or_else(|| table.error("`radiance` or `map` is missing"))?.to_owned();
        if file.is_empty() {
            return Err(table.error_at("map", "`map` is empty: name an .exr, .hdr, .pfm or .png file"));
        }
        let rotate = table.number("rotate")?.unwrap_or(0.0);
        return Ok(Some(EnvironmentEntry::Map { file, line: table.line_of("map"), rotate, scale }));
    };
    if map.is_some() {
        return Err(table.error_at("map", "`radiance` and `map` exclude each other: keep one"));
    }
    if table.number("rotate")?.is_some() {
        return Err(table.error_at("rotate", "`rotate` turns a `map`; constant radiance has nothing to turn"));
    }
    let radiance = radiance.map(|x| x * scale);
    if !radiance.iter().all(|&x| validate::is_radiance(x)) {
        let most = validate::MOST_RADIANCE;
        let fault = format!("radiance times scale must be at most {most:e}, the largest radiance that works");
        return Err(table.error_at("scale", fault));
    }
    Ok((radiance != [0.0; 3]).then_some(EnvironmentEntry::Constant { radiance }))
}
