//! A camera for scenes that have none.

use crate::error::{Error, Result};
use crate::scene::desc::{CameraDesc, MeshDesc, RenderDesc, SceneDesc, TriangleDesc};
use crate::scene::validate;

/// How the warning begins that a camera was made up.
pub const NO_CAMERA: &str = "no camera";

/// Gives the scene a camera from +z along -z that has the whole box in view, and says so.
pub fn frame(scene: &mut SceneDesc) -> Result<()> {
    let bounds = scene.geometry().bounds();
    let (low, high) =
        bounds.map_or(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high)| (low.into(), high.into()));
    let centre: [f64; 3] = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
    let half: [f64; 3] = std::array::from_fn(|i| 0.5 * (high[i] - low[i]));
    let aspect = f64::from(scene.film.0) / f64::from(scene.film.1);
    let fov = CameraDesc::default().vertical_fov;
    // The box's near face is its widest outline; 5 % air around it.
    let near_face = 1.05 * half[1].max(half[0] / aspect) / libm::tan(0.5 * fov.to_radians());
    // A line or point of a box: stand back by its depth, or by 1.
    let depth = if half[2] > 0.0 { half[2] } else { centre.iter().fold(1.0, |m: f64, x| m.max(x.abs())) };
    let distance = if near_face > 0.0 { near_face } else { depth };
    scene.camera = CameraDesc {
        position: [centre[0], centre[1], high[2] + distance],
        look_at: centre,
        up: [0.0, 1.0, 0.0],
        vertical_fov: fov,
        ..CameraDesc::default()
    };
    if let Some(fault) = validate::camera_fault(&scene.camera) {
        let message = format!("its box {low:?} to {high:?} cannot be framed: {fault}");
        return Err(Error::Scene { scene: scene.name.clone(), message });
    }
    let [x, y, z] = scene.camera.position.map(|x| x as f32);
    scene.warnings.push(format!("{NO_CAMERA}: one at [{x}, {y}, {z}] looks along -z with vertical_fov {fov}"));
    scene.render = RenderDesc::default();
    Ok(())
}

/// The corners of all triangles; each mesh has one instance, which stands where it does.
pub fn corners(scene: &SceneDesc) -> impl Iterator<Item = [[f32; 3]; 3]> {
    let of_mesh = |mesh: &MeshDesc, t: &TriangleDesc| t.vertices.map(|vertex| mesh.positions[vertex as usize]);
    scene.meshes.iter().flat_map(move |mesh| mesh.triangles.iter().map(move |triangle| of_mesh(mesh, triangle)))
}
