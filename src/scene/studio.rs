//! Ground and light for meshes that have none: what a photographer puts a product on.

use crate::scene::desc::{EnvironmentDesc, MaterialDesc, MeshDesc, Scattering, SceneDesc, TriangleDesc};
use crate::scene::shapes;
use crate::scene::transform::Transform;
use glam::DVec3;

/// Half a side of the ground, in radii of the scene.
const GROUND: f64 = 400.0;
/// How far the ground is below the lowest vertex, in radii: faces that lie on it shall not share its plane.
const GAP: f64 = 1e-4;
/// The radius of the key light in radii of the scene: as soft as a large window.
const KEY_RADIUS: f64 = 1.5;
/// From the middle of the scene to the key light, in radii: to the camera's left, up, and towards the camera.
const KEY_PLACE: [f64; 3] = [2.2, 3.4, 2.4];
/// Radiance of the key light, W sr^-1 m^-2: white that faces it shows about 0.9 together with the fill light.
const KEY_RADIANCE: f64 = 12.0;
/// Radiance of the surroundings, the fill light.
const FILL_RADIANCE: f64 = 0.3;

/// Puts `scene`, seen by its camera, onto a grey ground, below a soft key light and into dim surroundings, which replace its
/// environment.
pub fn add_studio(scene: &mut SceneDesc) {
    let Some((low, high)) = scene.geometry().bounds() else { return };
    let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
    let towards = DVec3::from(scene.camera.eye()) - middle;
    let towards = DVec3::new(towards.x, 0.0, towards.z).try_normalize().unwrap_or(DVec3::Z);
    let left = towards.cross(DVec3::Y);
    let [aside, up, before] = KEY_PLACE;
    let key = middle + (left * aside + DVec3::Y * up + towards * before) * radius;

    let first = scene.materials.len() as u32;
    let ground = Scattering::Diffuse { albedo: [0.5; 3] };
    scene.materials.push(MaterialDesc { name: "studio ground".into(), scattering: ground, ..MaterialDesc::default() });
    let emission = [KEY_RADIANCE; 3];
    scene.materials.push(MaterialDesc { name: "studio key light".into(), emission, ..MaterialDesc::default() });
    let (half, y) = (GROUND * radius, low.y - GAP * radius);
    let corner = |x: f64, z: f64| [(middle.x + x) as f32, y as f32, (middle.z + z) as f32];
    let triangle = |vertices| TriangleDesc { vertices, material: first, flipped: false };
    let ground = MeshDesc {
        positions: vec![corner(-half, half), corner(half, half), corner(half, -half), corner(-half, -half)],
        triangles: vec![triangle([0, 1, 2]), triangle([0, 2, 3])],
        corners: Vec::new(),
    };
    scene.add_mesh(ground, Transform::Identity);
    let facing = (middle - key).to_array();
    scene.add_mesh(shapes::disk(key.to_array(), facing, KEY_RADIUS * radius, first + 1), Transform::Identity);
    scene.set_environment(Some(EnvironmentDesc::Constant { radiance: [FILL_RADIANCE; 3] }));
}
