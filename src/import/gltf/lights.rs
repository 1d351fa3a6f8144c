//! Cameras and KHR_lights_punctual.

use super::file::File;
use super::nodes::{Placed, rows};
use crate::scene::desc::{CameraDesc, DeltaLight, DeltaLightDesc, LightDesc, NamedCamera, SceneDesc};
use crate::scene::validate::{LEAST_CONE, camera_fault, delta_light_fault};
use crate::settings::MAX_FILM_SIDE;
use glam::{DMat4, DVec3};
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;
use std::collections::HashSet;

/// Adds the perspective cameras of all nodes; the first is the scene's own, and its proportions are the film's.
pub fn add_cameras(file: &File<'_>, placed: &[Placed], scene: &mut SceneDesc) {
    let name_of_file = file.path.display();
    let mut names = HashSet::new();
    for &Placed { node: number, ref to_world } in placed {
        let node = &file.root.nodes[number];
        let Some(index) = node.camera.map(|camera| camera.value()) else { continue };
        let Some(camera) = file.root.cameras.get(index) else { continue };
        let name = own_name([&node.name, &camera.name]).unwrap_or_else(|| format!("camera {index}"));
        let Some(perspective) = &camera.perspective else {
            scene.warnings.push(format!("{name_of_file}: the camera `{name}` is orthographic, which octray has not"));
            continue;
        };
        let desc = CameraDesc {
            to_world: Some(rows(&without_scale(to_world))),
            vertical_fov: f64::from(perspective.yfov).to_degrees(),
            ..CameraDesc::default()
        };
        if let Some(fault) = camera_fault(&desc) {
            scene.warnings.push(format!("{name_of_file}: the camera `{name}` is left out: {fault}"));
            continue;
        }
        if scene.cameras.is_empty() {
            scene.camera = desc;
            if let Some(aspect) = perspective.aspect_ratio.filter(|aspect| *aspect > 0.0) {
                let width = (f64::from(scene.film.1) * f64::from(aspect)).round();
                scene.film.0 = width.clamp(1.0, f64::from(MAX_FILM_SIDE)) as u32;
            }
        }
        // Names must tell cameras apart.
        let name = if names.insert(name.clone()) { name } else { format!("{name} (nodes[{number}])") };
        scene.cameras.push(NamedCamera { name, camera: desc, path: Default::default() });
    }
}

/// The first name that says anything.
fn own_name(names: [&Option<String>; 2]) -> Option<String> {
    names.into_iter().flatten().find(|name| !name.is_empty()).cloned()
}

/// Where a node stands and how it is turned; cameras do not care for its scale.
fn without_scale(to_world: &DMat4) -> DMat4 {
    let mut matrix = *to_world;
    for axis in [&mut matrix.x_axis, &mut matrix.y_axis, &mut matrix.z_axis] {
        *axis = axis.normalize_or_zero();
    }
    matrix
}

/// Adds the lights of all nodes.
pub fn add_lights(file: &File<'_>, placed: &[Placed], scene: &mut SceneDesc) {
    let extensions = file.root.extensions.as_ref();
    let lights = extensions.and_then(|all| all.khr_lights_punctual.as_ref()).map_or(&[][..], |all| &all.lights);
    let name_of_file = file.path.display();
    for Placed { node, to_world } in placed {
        let node = &file.root.nodes[*node];
        let extension = node.extensions.as_ref().and_then(|all| all.khr_lights_punctual.as_ref());
        let Some(number) = extension.map(|extension| extension.light.value()) else { continue };
        let Some(light) = lights.get(number) else { continue };
        let name = own_name([&node.name, &light.name]).unwrap_or_else(|| format!("light {number}"));
        let Some(desc) = delta_light(light, to_world) else { continue };
        if light.range.is_some() {
            scene
                .warnings
                .push(format!("{name_of_file}: the range of lights is not kept: they fall off by the square"));
        }
        if let Some(fault) = delta_light_fault(&desc) {
            scene.warnings.push(format!("{name_of_file}: the light `{name}` is left out: {fault}"));
            continue;
        }
        scene.lights.push(LightDesc::Delta(DeltaLightDesc { name, light: desc }));
    }
}

/// How a light at the node `to_world` shines: along its -z.
fn delta_light(light: &Light, to_world: &DMat4) -> Option<DeltaLight> {
    let strength = light.color.map(|c| f64::from(c) * f64::from(light.intensity));
    let position = to_world.w_axis.truncate().to_array();
    let direction = to_world.transform_vector3(-DVec3::Z).to_array();
    let Checked::Valid(kind) = light.type_ else { return None };
    Some(match kind {
        Type::Point => DeltaLight::Point { position, intensity: strength },
        Type::Directional => DeltaLight::Directional { direction, irradiance: strength },
        Type::Spot => {
            let spot = light.spot.as_ref()?;
            let cone_angle = f64::from(spot.outer_cone_angle).to_degrees().max(LEAST_CONE);
            let whole = f64::from(spot.inner_cone_angle).to_degrees().clamp(0.0, cone_angle);
            let cone_delta_angle = cone_angle - whole;
            DeltaLight::Spot { position, direction, intensity: strength, cone_angle, cone_delta_angle }
        }
    })
}
