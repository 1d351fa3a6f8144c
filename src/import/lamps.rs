//! The lights of a scene file, put into the scene.

use crate::error::{Error, Result};
use crate::import::toml::lights::{LampEntry, LightEntry};
use crate::scene::desc::{LightDesc, MaterialDesc, SceneDesc};
use crate::scene::shapes;
use crate::scene::transform::Transform;
use std::f64::consts::PI;
use std::path::Path;

/// Adds the lights of the scene file `path`; after the meshes, whose triangles so keep their numbers.
pub fn add_lights(path: &Path, scene: &mut SceneDesc, lights: Vec<LightEntry>) -> Result<()> {
    for light in lights {
        match light {
            LightEntry::Delta(light) => scene.lights.push(LightDesc::Delta(light)),
            LightEntry::Lamp(lamp) => add_lamp(path, scene, lamp)?,
        }
    }
    Ok(())
}

/// Adds a lamp of triangles: black, and as much brighter than it says as rounding has made its area smaller.
fn add_lamp(path: &Path, scene: &mut SceneDesc, lamp: LampEntry) -> Result<()> {
    let LampEntry { name, line, position, radius, normal, radiance, two_sided } = lamp;
    let material = scene.materials.len() as u32;
    let (mesh, area) = match normal {
        Some(normal) => (shapes::disk(position, normal, radius, material), PI * radius * radius),
        None => (shapes::sphere(position, radius, material), 4.0 * PI * radius * radius),
    };
    let factor = area / shapes::area(&mesh);
    if !(0.5..2.0).contains(&factor) {
        let why = format!("`radius` {radius} is too small where f32 coordinates are as large as in {position:?}");
        return Err(Error::parse(path, Some(line), format!("[[light]]: {why}: make it larger, or a point light")));
    }
    let emission = radiance.map(|c| c * factor);
    scene.materials.push(MaterialDesc { name, emission, two_sided, ..MaterialDesc::default() });
    scene.add_mesh(mesh, Transform::Identity);
    Ok(())
}
