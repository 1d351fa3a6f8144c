//! What must hold of every [`SceneDesc`], whoever made it, and what counts as a triangle without area.

use crate::error::{Error, Result};
use crate::scene::desc::{CameraDesc, Scattering, SceneDesc};
use crate::settings::MAX_FILM_SIDE;
use glam::DVec3;

/// Whether a triangle has no area, exactly: its corners lie on one line (judged in f64) or are not finite. Such
/// triangles keep their number but are left out of the BVH and of the light table.
pub fn is_degenerate(p: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = p.map(|v| DVec3::from(v.map(f64::from)));
    let normal = (b - a).cross(c - a);
    normal == DVec3::ZERO || !normal.is_finite()
}

/// Whether `x` is finite once it is an f32.
pub fn fits_f32(x: f64) -> bool {
    (x as f32).is_finite()
}

/// Why this camera cannot look, if it cannot.
pub fn camera_fault(camera: &CameraDesc) -> Option<&'static str> {
    let all = [camera.position, camera.look_at, camera.up];
    if !all.iter().flatten().all(|&x| fits_f32(x)) {
        return Some("position, look_at and up must be finite numbers below 3.4e38");
    }
    if !(camera.vertical_fov > 0.0 && camera.vertical_fov < 180.0) {
        return Some("vertical_fov must lie between 0 and 180 degrees, both excluded");
    }
    if !(camera.aperture_radius >= 0.0 && fits_f32(camera.aperture_radius)) {
        return Some("aperture_radius must be 0 (a pinhole) or above, and finite");
    }
    if !(camera.focus_distance > 0.0 && fits_f32(camera.focus_distance)) {
        return Some("focus_distance must be above 0 and finite");
    }
    let forward = DVec3::from(camera.look_at) - DVec3::from(camera.position);
    let up = DVec3::from(camera.up);
    // Below 1e-140 the squares vanish in f64 and there is no direction left.
    if forward.length() < 1e-140 {
        return Some("position and look_at are the same point: move look_at to what the camera shall see");
    }
    if up.length() < 1e-140 {
        return Some("up is zero: use for instance [0, 1, 0]");
    }
    if forward.normalize().cross(up.normalize()).length() < 1e-6 {
        return Some("up is parallel to the view direction: choose another up, for instance [0, 0, 1]");
    }
    None
}

/// Checks everything the tables rely on. Loading has already said more about where; this is the last gate, also for
/// scenes that a program put together.
pub fn check(scene: &SceneDesc) -> Result<()> {
    let fail = |message: String| Err(Error::Scene { scene: scene.name.clone(), message });
    if let Some(fault) = camera_fault(&scene.camera) {
        return fail(format!("camera: {fault}"));
    }
    let side = 1..=MAX_FILM_SIDE;
    if !side.contains(&scene.film.0) || !side.contains(&scene.film.1) {
        let (width, height) = scene.film;
        return fail(format!("the film is {width} x {height} pixels; each side must be 1 to {MAX_FILM_SIDE}"));
    }
    if scene.triangles.is_empty() {
        return fail("no triangles: name an OBJ file that has faces".into());
    }
    if let Some(i) = scene.positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
        return fail(format!("vertex {i} is not finite: {:?}", scene.positions[i]));
    }
    let (vertices, materials) = (scene.positions.len(), scene.materials.len());
    if let Some(i) = scene
        .triangles
        .iter()
        .position(|t| t.material as usize >= materials || t.vertices.iter().any(|&v| v as usize >= vertices))
    {
        return fail(format!("triangle {i} names a vertex or material that does not exist"));
    }
    for material in &scene.materials {
        let (Scattering::Diffuse { albedo: factor } | Scattering::Mirror { reflectance: factor }) = material.scattering;
        if !factor.iter().all(|f| (0.0..=1.0).contains(f)) {
            return fail(format!("material `{}` reflects {factor:?}; each channel must lie in [0, 1]", material.name));
        }
        if !material.emission.iter().all(|&e| e >= 0.0 && fits_f32(e)) {
            return fail(format!("material `{}` emits {:?}, not finite or negative", material.name, material.emission));
        }
    }
    if let Some(environment) = scene.environment
        && !environment.radiance.iter().all(|&e| e >= 0.0 && fits_f32(e))
    {
        return fail(format!("the environment's radiance {:?} is negative or not finite", environment.radiance));
    }
    Ok(())
}
