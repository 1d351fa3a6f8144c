//! What must hold of every [`SceneDesc`], whoever made it, and what counts as a triangle without area.

use crate::error::{Error, Result};
use crate::scene::desc::{CameraDesc, EnvironmentDesc, Scattering, SceneDesc, TextureUse};
use crate::settings::MAX_FILM_SIDE;
use glam::DVec3;

/// The most texels an environment map may have.
pub const MAX_TEXELS: usize = 1 << 28;

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

/// The smallest and the largest index of refraction of glass and coats.
pub const IOR_RANGE: std::ops::RangeInclusive<f64> = 0.05..=20.0;
/// The smallest index of refraction of a coat: below, it would not be there.
pub const LEAST_COAT_IOR: f64 = 1.01;
/// The largest component of a conductor's complex index of refraction.
pub const MOST_COMPLEX_IOR: f64 = 1e3;

/// What is wrong with how a material scatters, if anything is; the text begins with the key to change.
pub fn scattering_fault(scattering: &Scattering) -> Option<String> {
    let fraction = |name: &str, v: &[f64; 3]| {
        let fine = v.iter().all(|f| (0.0..=1.0).contains(f));
        (!fine).then(|| format!("{name} is {v:?}; each channel must lie in [0, 1]"))
    };
    let width = |alpha: f64| {
        (!(0.0..=1.0).contains(&alpha)).then(|| format!("alpha is {alpha}; a GGX width must lie in [0, 1]"))
    };
    match scattering {
        Scattering::Diffuse { albedo } => fraction("albedo", albedo),
        Scattering::Mirror { reflectance } => fraction("reflectance", reflectance),
        Scattering::Conductor { alpha, reflectance, complex_ior } => {
            let index = complex_ior.iter().find_map(|(eta, k)| {
                let eta_fits = eta.iter().all(|x| (1e-3..=MOST_COMPLEX_IOR).contains(x));
                let k_fits = k.iter().all(|x| (0.0..=MOST_COMPLEX_IOR).contains(x));
                match (eta_fits, k_fits) {
                    (false, _) => Some(format!("eta is {eta:?}; each channel must lie in [0.001, {MOST_COMPLEX_IOR}]")),
                    (_, false) => Some(format!("k is {k:?}; each channel must lie in [0, {MOST_COMPLEX_IOR}]")),
                    _ => None,
                }
            });
            width(*alpha).or_else(|| fraction("reflectance", reflectance)).or(index)
        }
        Scattering::Dielectric { ior, transmittance } => {
            let index = (!IOR_RANGE.contains(ior)).then(|| format!("ior is {ior}; glass has 0.05 to 20"));
            index.or_else(|| fraction("transmittance", transmittance))
        }
        Scattering::Plastic { albedo, ior, alpha } => {
            let fits = (LEAST_COAT_IOR..=*IOR_RANGE.end()).contains(ior);
            let index = (!fits).then(|| format!("ior is {ior}; a coat has {LEAST_COAT_IOR} to 20"));
            index.or_else(|| fraction("albedo", albedo)).or_else(|| width(*alpha))
        }
    }
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
    if !scene.corners.is_empty() && scene.corners.len() != scene.triangles.len() {
        return fail("corners must be empty or one entry a triangle".into());
    }
    let unit_or_zero = |n: &[f32; 3]| {
        let square: f64 = n.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
        square == 0.0 || (square - 1.0).abs() < 1e-3
    };
    if let Some(i) = scene.corners.iter().position(|corner| !corner.normals.iter().all(unit_or_zero)) {
        return fail(format!("triangle {i} has corner normals that are neither unit vectors nor zero"));
    }
    if let Some(i) = scene.corners.iter().position(|corner| !corner.uvs.iter().flatten().all(|t| t.abs() < 1e7)) {
        return fail(format!("triangle {i} has texture coordinates beyond 1e7"));
    }
    for texture in &scene.textures {
        if texture.texels.is_empty() || texture.texels.len() != texture.width as usize * texture.height as usize {
            return fail(format!("texture `{}` has not width x height texels", texture.name));
        }
    }
    for mask in &scene.masks {
        if mask.texels.is_empty() || mask.texels.len() != mask.width as usize * mask.height as usize {
            return fail(format!("mask `{}` has not width x height texels", mask.name));
        }
    }
    let texels = scene.textures.iter().map(|texture| texture.texels.len()).sum::<usize>();
    if texels.max(scene.masks.iter().map(|mask| mask.texels.len()).sum()) > u32::MAX as usize {
        return fail("more than 2^32 texels: use smaller textures".into());
    }
    for material in &scene.materials {
        let uses = [material.texture, material.emission_texture];
        let fine = |u: &TextureUse, textures: usize| {
            let placed = u.scale.iter().chain(&u.offset).all(|x| x.abs() <= 1e6);
            placed && (u.texture as usize) < textures
        };
        let coloured = uses.iter().flatten().all(|u| fine(u, scene.textures.len()));
        if !(coloured && material.alpha_mask.iter().all(|u| fine(u, scene.masks.len()))) {
            return fail(format!(
                "material `{}` has a texture that does not exist or is scaled too far",
                material.name
            ));
        }
        if let Some(fault) = scattering_fault(&material.scattering) {
            return fail(format!("material `{}`: {fault}", material.name));
        }
        if !material.emission.iter().all(|&e| e >= 0.0 && fits_f32(e)) {
            return fail(format!("material `{}` emits {:?}, not finite or negative", material.name, material.emission));
        }
    }
    match scene.environment.as_ref().and_then(environment_fault) {
        Some(fault) => fail(fault),
        None => Ok(()),
    }
}

/// Why this environment cannot shine, if it cannot.
pub fn environment_fault(environment: &EnvironmentDesc) -> Option<String> {
    let map = match environment {
        EnvironmentDesc::Constant { radiance } => {
            let fine = radiance.iter().all(|&e| e >= 0.0 && fits_f32(e));
            return (!fine).then(|| format!("the environment's radiance {radiance:?} is negative or not finite"));
        }
        EnvironmentDesc::Map(map) => map,
    };
    let name = &map.file;
    if map.width == 0 || map.height == 0 || map.texels.len() as u64 != map.width as u64 * map.height as u64 {
        return Some(format!("environment map {name}: {} texels for {} x {}", map.texels.len(), map.width, map.height));
    }
    if map.width > MAX_FILM_SIDE || map.height > MAX_FILM_SIDE || map.texels.len() > MAX_TEXELS {
        let size = format!("{} x {}", map.width, map.height);
        return Some(format!("environment map {name}: {size} texels are too many; scale it down to 16384 x 8192"));
    }
    if !(map.scale > 0.0 && fits_f32(map.scale) && map.rotate.is_finite()) {
        return Some(format!("environment map {name}: scale must be above 0, scale and rotate finite"));
    }
    let brightest = map.texels.iter().flatten().fold(0.0, |most: f32, &c| if c <= most { most } else { c });
    // A NaN takes the brightest's place and fails the test below.
    if !(fits_f32(brightest as f64 * map.scale)) || map.texels.iter().flatten().any(|&c| c < 0.0) {
        return Some(format!("environment map {name}: texels times scale must be finite and not negative"));
    }
    let lit = (brightest as f64 * map.scale) as f32 >= f32::MIN_POSITIVE;
    (!lit).then(|| format!("environment map {name}: no texel shines"))
}
