//! What must hold of every [`SceneDesc`], whoever made it, and what counts as a triangle without area.

use crate::error::{Error, Result};
use crate::fault::{Fault, planted};
use crate::scene::desc::{
    CameraDesc, DeltaLight, EnvironmentDesc, LightDesc, MaterialDesc, MeshDesc, Scattering, SceneDesc, TextureUse,
};
use crate::scene::flatten::Geometry;
use crate::scene::transform::matrix_fault;
use crate::settings::MAX_FILM_SIDE;
use glam::DVec3;

/// The largest radiance, W sr^-1 m^-2: samples can be brighter than lights (by BSDFs, by one over a small density), and pictures
/// hold f32: above 1e30 there is room for 3e8.
pub const MOST_RADIANCE: f32 = 1e30;

/// The largest radius of a lens, in distances of the plane in focus.
pub const MOST_APERTURE: f64 = 1000.0;

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
    let placed = camera.to_world.is_some();
    let all = [camera.position, camera.look_at, camera.up];
    if !placed && !all.iter().flatten().all(|&x| fits_f32(x)) {
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
    if camera.aperture_radius > MOST_APERTURE * camera.focus_distance {
        return Some(
            "aperture_radius is more than 1000 times focus_distance: a lens so near to what is in focus shows nothing",
        );
    }
    if let Some(rows) = &camera.to_world {
        let length = |i: usize| DVec3::from(rows.map(|row| row[i])).length();
        let near_one = (0..3).all(|i| (1e-6..=1e6).contains(&length(i)));
        let fault = "to_world: the lengths of its axes must lie between 1e-6 and 1e6";
        return matrix_fault(rows).or_else(|| (!near_one).then_some(fault));
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
        Scattering::Principled { base_color, metallic, roughness, ior } => {
            let most = *IOR_RANGE.end();
            let index = (!(1.0..=most).contains(ior)).then(|| format!("ior is {ior}; it must lie in [1, {most}]"));
            let part = |name: &str, part: f64| {
                (!(0.0..=1.0).contains(&part)).then(|| format!("{name} is {part}; it must lie in [0, 1]"))
            };
            let parts = part("metallic", *metallic).or_else(|| part("roughness", *roughness));
            fraction("base_color", base_color).or(parts).or(index)
        }
    }
}

/// The one gate: checks everything the tables rely on, whoever made the scene; its triangles in world space, which the last
/// rules are about. Loading has already said more about where in the files; [`crate::tables::PreparedScene::new`] asks
/// again, since descriptions may be changed in between.
///
/// # Errors
/// [`Error::Scene`] names the first rule that is broken, and the triangle, material or image that breaks it.
pub fn check(scene: &SceneDesc) -> Result<Geometry<'_>> {
    let fault = view_fault(scene)
        .or_else(|| scene.meshes.iter().enumerate().find_map(|(i, mesh)| mesh_fault(scene, i, mesh)))
        .or_else(|| instance_fault(scene))
        .or_else(|| image_fault(scene))
        .or_else(|| scene.materials.iter().enumerate().find_map(|(i, m)| material_fault(scene, i, m)))
        .or_else(|| light_fault(scene));
    let refused = |message| Error::Scene { scene: scene.name.clone(), message };
    if let Some(message) = fault {
        return Err(refused(message));
    }
    // Only now that every instance is known to name a mesh.
    let geometry = scene.geometry();
    match placed_fault(scene, &geometry).or_else(|| nothing_to_see(scene, &geometry)) {
        Some(message) => Err(refused(message)),
        None => Ok(geometry),
    }
}

/// What is wrong with camera, film or render settings.
fn view_fault(scene: &SceneDesc) -> Option<String> {
    if let Some(fault) = camera_fault(&scene.camera) {
        return Some(format!("camera: {fault}"));
    }
    for key in scene.camera_path.keys() {
        if let Some(fault) = camera_fault(&key.camera) {
            return Some(format!("camera key at {} s: {fault}", key.time));
        }
    }
    let (side, (width, height)) = (1..=MAX_FILM_SIDE, scene.film);
    if !side.contains(&width) || !side.contains(&height) {
        return Some(format!("the film is {width} x {height} pixels; each side must be 1 to {MAX_FILM_SIDE}"));
    }
    (scene.render.spp == Some(0)).then(|| "render: spp is 0; it must be at least 1".into())
}

/// What is wrong with mesh number `i`: its positions, or what its triangles name, or the number of its corners.
fn mesh_fault(scene: &SceneDesc, i: usize, mesh: &MeshDesc) -> Option<String> {
    let position = mesh.positions.iter().position(|p| p.iter().any(|x| !x.is_finite()));
    let position = position.map(|v| format!("vertex {v} is not finite: {:?}", mesh.positions[v]));
    let (vertices, materials) = (mesh.positions.len(), scene.materials.len());
    let triangle = || {
        mesh.triangles.iter().enumerate().find_map(|(i, triangle)| {
            let missing = triangle.vertices.into_iter().find(|&v| v as usize >= vertices);
            let vertex = missing.map(|v| format!("triangle {i} names vertex {v}; the mesh has {vertices} vertices"));
            let material = triangle.material;
            let unknown = || format!("triangle {i} names material {material}; the scene has {materials} materials");
            vertex.or_else(|| (material as usize >= materials).then(unknown))
        })
    };
    position.or_else(triangle).or_else(|| corner_fault(mesh)).map(|fault| format!("mesh {i}: {fault}"))
}

/// What is wrong with the normals and texture coordinates of a mesh's corners, whatever its instances.
fn corner_fault(mesh: &MeshDesc) -> Option<String> {
    let (corners, triangles) = (mesh.corners.len(), mesh.triangles.len());
    if corners != 0 && corners != triangles {
        return Some(format!("corners must be empty or one entry a triangle; {corners} are for {triangles} triangles"));
    }
    mesh.corners.iter().enumerate().find_map(|(i, corner)| {
        if !corner.normals.iter().flatten().all(|x| x.is_finite()) {
            return Some(format!("triangle {i} has corner normals that are not finite"));
        }
        let near = corner.uvs.iter().flatten().all(|t| t.abs() < 1e7);
        (!near).then(|| format!("triangle {i} has texture coordinates that are beyond 1e7 or no numbers"))
    })
}

/// What is wrong with an instance by itself, or with their number.
fn instance_fault(scene: &SceneDesc) -> Option<String> {
    let meshes = scene.meshes.len();
    let fault = scene.instances.iter().enumerate().find_map(|(i, instance)| {
        if instance.mesh as usize >= meshes {
            return Some(format!("instance {i} names mesh {}; the scene has {meshes} meshes", instance.mesh));
        }
        instance.transform.fault().map(|fault| format!("instance {i}: {fault}"))
    });
    let total = |count: fn(&MeshDesc) -> usize| {
        scene.instances.iter().map(|instance| count(&scene.meshes[instance.mesh as usize]) as u64).sum::<u64>()
    };
    fault.or_else(|| {
        let many = total(|mesh| mesh.positions.len()).max(total(|mesh| mesh.triangles.len())) > u64::from(u32::MAX);
        many.then(|| "the instances have more than 2^32 vertices or triangles: split the scene".into())
    })
}

/// What is wrong with positions and normals once they are in world space.
fn placed_fault(scene: &SceneDesc, geometry: &Geometry<'_>) -> Option<String> {
    // The instance that has the element number `i` of all, and the number in its mesh.
    let owner = |mut i: usize, count: fn(&MeshDesc) -> usize| {
        let counts = scene.instances.iter().map(|instance| count(&scene.meshes[instance.mesh as usize]));
        for (instance, count) in counts.enumerate() {
            if i < count {
                return format!("instance {instance} of mesh {}, number {i}", scene.instances[instance].mesh);
            }
            i -= count;
        }
        String::new()
    };
    if let Some(i) = geometry.positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
        let owner = owner(i, |mesh| mesh.positions.len());
        return Some(format!("vertex {i} ({owner}) is moved out of the range of f32 by its instance's transform"));
    }
    let unit_or_zero = |n: &[f32; 3]| {
        let square: f64 = n.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
        square == 0.0 || (square - 1.0).abs() < 1e-3
    };
    let bent = geometry.corners.iter().position(|corner| !corner.normals.iter().all(unit_or_zero))?;
    let owner = owner(bent, |mesh| mesh.triangles.len());
    Some(format!("triangle {bent} ({owner}) has corner normals that are neither unit vectors nor zero"))
}

/// What is wrong with the lights that are no surfaces.
fn light_fault(scene: &SceneDesc) -> Option<String> {
    let is_environment = |i: &usize| matches!(scene.lights[*i], LightDesc::Environment(_));
    let mut environments = (0..scene.lights.len()).filter(is_environment);
    if let (Some(first), Some(second)) = (environments.next(), environments.next()) {
        return Some(format!("lights {first} and {second} are both environments; a scene has at most one"));
    }
    scene.lights.iter().enumerate().find_map(|(i, light)| match light {
        LightDesc::Environment(environment) => environment_fault(environment),
        LightDesc::Delta(desc) => {
            delta_light_fault(&desc.light).map(|fault| format!("light {i} `{}`: {fault}", desc.name))
        }
    })
}

/// The smallest cone of a spot light, degrees: the light of a narrower one is the noise of its axis in f32.
pub const LEAST_CONE: f64 = 0.01;

/// What is wrong with a direction of any length, if anything is.
pub fn direction_fault(direction: &[f64; 3]) -> Option<String> {
    // Below 1e-140 the squares vanish in f64 and there is no direction left.
    let fine = direction.iter().all(|&x| fits_f32(x)) && DVec3::from(*direction).length() >= 1e-140;
    (!fine).then(|| format!("is {direction:?}; it must be finite and not zero, for instance [0, -1, 0]"))
}

/// Why this light cannot shine, if it cannot; the text begins with the key to change.
pub fn delta_light_fault(light: &DeltaLight) -> Option<String> {
    let place = |name: &str, v: &[f64; 3]| {
        (!v.iter().all(|&x| fits_f32(x))).then(|| format!("{name} is {v:?}; it must be finite and below 3.4e38"))
    };
    let way = |v: &[f64; 3]| direction_fault(v).map(|fault| format!("direction {fault}"));
    let strength = |name: &str, v: &[f64; 3]| {
        let rule = format!("each channel must be finite, at least 0 and at most {MOST_RADIANCE:e}, which still works");
        (!v.iter().all(|&x| is_radiance(x))).then(|| format!("{name} is {v:?}; {rule}"))
    };
    match light {
        DeltaLight::Point { position, intensity } => {
            place("position", position).or_else(|| strength("intensity", intensity))
        }
        DeltaLight::Spot { position, direction, intensity, cone_angle, cone_delta_angle } => {
            let cone = (LEAST_CONE..=180.0).contains(cone_angle);
            let cone = (!cone).then(|| {
                format!("cone_angle is {cone_angle}; it must lie between {LEAST_CONE} and 180 degrees, from the axis to the edge")
            });
            let fades = (0.0..=*cone_angle).contains(cone_delta_angle);
            let fades = (!fades).then(|| {
                format!(
                    "cone_delta_angle is {cone_delta_angle}; it must lie between 0 and cone_angle, {cone_angle} degrees"
                )
            });
            let place = place("position", position).or_else(|| way(direction));
            place.or_else(|| strength("intensity", intensity)).or(cone).or(fades)
        }
        DeltaLight::Directional { direction, irradiance } => {
            way(direction).or_else(|| strength("irradiance", irradiance))
        }
    }
}

/// What is wrong with the sizes of textures and masks.
fn image_fault(scene: &SceneDesc) -> Option<String> {
    let textures = scene.textures.iter().map(|t| ("texture", &t.name, t.width, t.height, t.texels.len()));
    let masks = scene.masks.iter().map(|m| ("mask", &m.name, m.width, m.height, m.texels.len()));
    for (what, name, width, height, texels) in textures.chain(masks) {
        if texels == 0 || texels as u64 != u64::from(width) * u64::from(height) {
            return Some(format!("{what} `{name}` is {width} x {height} but has {texels} texels"));
        }
    }
    let texels = scene.textures.iter().map(|texture| texture.texels.len()).sum::<usize>();
    let most = texels.max(scene.masks.iter().map(|mask| mask.texels.len()).sum());
    (most > u32::MAX as usize).then(|| "more than 2^32 texels: use smaller textures".into())
}

/// What is wrong with material number `i`.
fn material_fault(scene: &SceneDesc, i: usize, material: &MaterialDesc) -> Option<String> {
    let (textures, masks) = (scene.textures.len(), scene.masks.len());
    let uses = [
        ("texture", material.texture, textures),
        ("emission texture", material.emission_texture, textures),
        ("alpha mask", material.alpha_mask, masks),
    ];
    let image = uses.into_iter().find_map(|(what, used, count)| {
        let TextureUse { texture, scale, offset } = used?;
        if texture as usize >= count {
            return Some(format!("its {what} is number {texture}; the scene has {count}"));
        }
        let near = scale.iter().chain(&offset).all(|x| x.abs() <= 1e6);
        (!near).then(|| format!("its {what} is scaled or shifted beyond 1e6: {scale:?}, {offset:?}"))
    });
    let emission = material.emission;
    let shines = emission.iter().all(|&e| is_radiance(e));
    let fault = image.or_else(|| scattering_fault(&material.scattering)).or_else(|| {
        let rule = format!("each channel must be finite, at least 0 and at most {MOST_RADIANCE:e}, which still works");
        (!shines).then(|| format!("emission is {emission:?}; {rule}"))
    });
    fault.map(|fault| format!("material {i} `{}`: {fault}", material.name))
}

/// Why a picture of this scene would show nothing, whatever its materials, if so.
fn nothing_to_see(scene: &SceneDesc, geometry: &Geometry<'_>) -> Option<String> {
    let visible = || (0..geometry.triangles.len()).any(|id| !is_degenerate(geometry.vertices(id)));
    let message = "no triangle of positive area and no environment: there is nothing to see; check the OBJ";
    (scene.environment().is_none() && !visible()).then(|| message.into())
}

/// Whether `x` can be radiance.
pub fn is_radiance(x: f64) -> bool {
    x >= 0.0 && (x as f32 <= MOST_RADIANCE || planted(Fault::SilentLimits))
}

/// Why this environment cannot shine, if it cannot.
pub fn environment_fault(environment: &EnvironmentDesc) -> Option<String> {
    let map = match environment {
        EnvironmentDesc::Constant { radiance } => {
            let fine = radiance.iter().all(|&e| is_radiance(e));
            let rule = format!("is negative, not finite or above {MOST_RADIANCE:e}, the largest radiance that works");
            return (!fine).then(|| format!("the environment's radiance {radiance:?} {rule}"));
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
    let shines = |c: f32| is_radiance(f64::from(c) * map.scale);
    if let Some(i) = map.texels.iter().position(|texel| !texel.iter().all(|&c| shines(c))) {
        let (x, y, texel) = (i as u32 % map.width, i as u32 / map.width, map.texels[i]);
        return Some(format!(
            "environment map {name}: texel {x},{y} is {texel:?}; times scale it must be finite, not negative and at most \
             {MOST_RADIANCE:e}, the largest radiance that works"
        ));
    }
    let brightest = map.texels.iter().flatten().fold(0.0, |most: f32, &c| if c <= most { most } else { c });
    let lit = (brightest as f64 * map.scale) as f32 >= f32::MIN_POSITIVE;
    (!lit && !planted(Fault::BlackMapTaken)).then(|| format!("environment map {name}: no texel shines"))
}
