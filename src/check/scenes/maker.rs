//! Scenes put together in code.

use crate::scene::desc::{CameraDesc, MaterialDesc, MeshDesc, Scattering, SceneDesc, TriangleDesc};
use crate::scene::transform::Transform;

/// No light.
pub const DARK: [f64; 3] = [0.0; 3];

/// A scene in the making.
#[derive(Default)]
pub struct Maker {
    /// Everything but the mesh.
    pub desc: SceneDesc,
    /// All its triangles, in world space.
    pub mesh: MeshDesc,
}

impl Maker {
    /// A material; its index.
    pub fn material(&mut self, scattering: Scattering, emission: [f64; 3]) -> u32 {
        let name = format!("m{}", self.desc.materials.len());
        self.desc.materials.push(MaterialDesc { name, scattering, emission, ..Default::default() });
        self.desc.materials.len() as u32 - 1
    }

    /// A grey diffuse material that emits grey light; its index.
    pub fn diffuse(&mut self, albedo: f64, radiance: f64) -> u32 {
        self.material(Scattering::Diffuse { albedo: [albedo; 3] }, [radiance; 3])
    }

    /// One triangle; corners counter-clockwise seen from the front.
    pub fn triangle(&mut self, corners: [[f32; 3]; 3], material: u32) {
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(corners);
        let vertices = [first, first + 1, first + 2];
        self.mesh.triangles.push(TriangleDesc { vertices, material, flipped: false });
    }

    /// Two triangles; corners counter-clockwise seen from the front.
    pub fn quad(&mut self, [a, b, c, d]: [[f32; 3]; 4], material: u32) {
        self.triangle([a, b, c], material);
        self.triangle([a, c, d], material);
    }

    /// A rectangle at height `y`, of half-sizes `x` and `z` about the y axis, facing up or down.
    pub fn level(&mut self, y: f32, [x, z]: [f32; 2], down: bool, material: u32) {
        let [a, b, c, d] = [[-x, y, z], [x, y, z], [x, y, -z], [-x, y, -z]];
        self.quad(if down { [d, c, b, a] } else { [a, b, c, d] }, material);
    }

    /// A floor at height 0 of about so many units to all sides, whose diagonal runs beside the origin: points on edges are kept
    /// off them by a little.
    pub fn ground(&mut self, size: f32, material: u32) {
        let (near, far) = (-size, 1.5 * size);
        self.quad([[near, 0.0, size], [far, 0.0, size], [far, 0.0, near], [near, 0.0, near]], material);
    }

    /// The six sides of a box, fronts outwards or inwards.
    pub fn cuboid(&mut self, [x0, y0, z0]: [f32; 3], [x1, y1, z1]: [f32; 3], inwards: bool, material: u32) {
        let sides = [
            [[x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]],
            [[x1, y0, z0], [x0, y0, z0], [x0, y1, z0], [x1, y1, z0]],
            [[x0, y0, z0], [x0, y0, z1], [x0, y1, z1], [x0, y1, z0]],
            [[x1, y0, z1], [x1, y0, z0], [x1, y1, z0], [x1, y1, z1]],
            [[x0, y1, z1], [x1, y1, z1], [x1, y1, z0], [x0, y1, z0]],
            [[x0, y0, z0], [x1, y0, z0], [x1, y0, z1], [x0, y0, z1]],
        ];
        for [a, b, c, d] in sides {
            self.quad(if inwards { [d, c, b, a] } else { [a, b, c, d] }, material);
        }
    }

    /// Moves every vertex.
    pub fn moved(mut self, place: impl Fn([f64; 3]) -> [f64; 3]) -> Maker {
        for position in &mut self.mesh.positions {
            *position = place(position.map(f64::from)).map(|x| x as f32);
        }
        self
    }

    /// The scene, seen from `position` towards `look_at` with a vertical field of view of `fov` degrees.
    pub fn seen(self, position: [f64; 3], look_at: [f64; 3], fov: f64) -> SceneDesc {
        let along_y = (position[0] - look_at[0]).abs() + (position[2] - look_at[2]).abs()
            < 1e-9 * (position[1] - look_at[1]).abs();
        let up = if along_y { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        self.seen_by(CameraDesc { position, look_at, up, vertical_fov: fov, ..CameraDesc::default() })
    }

    /// The scene, seen by this camera on a film of 16 x 16 pixels.
    pub fn seen_by(mut self, camera: CameraDesc) -> SceneDesc {
        self.desc.camera = camera;
        self.desc.film = (16, 16);
        self.desc.add_mesh(self.mesh, Transform::Identity);
        self.desc
    }
}
