//! Mirrors that face each other.

use super::SceneMaker;
use super::maker::{DARK, Maker};
use crate::scene::SceneDesc;
use crate::scene::desc::{EnvironmentDesc, Scattering};

/// The scenes.
pub const SCENES: &[SceneMaker] = &[
    SceneMaker { name: "mirror_corridor", numbers: &["reflections", "reflectance"], make: mirror_corridor },
    SceneMaker { name: "mirror_box", numbers: &["reflectance", "emitted radiance"], make: mirror_box },
];

/// Two mirrors a unit apart and 10 long, seen along at the angle at which a ray that enters between them is reflected so
/// often before it leaves into surroundings of radiance 1: L = r^n.
fn mirror_corridor(numbers: &[f64]) -> SceneDesc {
    let [count, reflectance] = std::array::from_fn(|i| numbers[i]);
    let mut maker = Maker::default();
    let mirror = maker.material(Scattering::Mirror { reflectance: [reflectance; 3] }, DARK);
    maker.quad([[0.0, -1.0, 1.0], [0.0, -1.0, -10.0], [0.0, 1.0, -10.0], [0.0, 1.0, 1.0]], mirror);
    maker.quad([[1.0, -1.0, -10.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, -10.0]], mirror);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    // Unfolded, the ray crosses the planes x = 1, 2, .. count on its way from x = 1/2 to x = count + 1/2.
    maker.seen([0.5, 0.013, 0.0], [0.5 + 0.1 * count, 0.013, -1.0], 1e-4)
}

/// A box of mirrors that emit: by the geometric sum, L = E (1 + r + .. + r^N).
fn mirror_box(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let wall = maker.material(Scattering::Mirror { reflectance: [numbers[0]; 3] }, [numbers[1]; 3]);
    maker.cuboid([-1.0, -1.0, -1.0], [1.0, 1.5, 2.0], true, wall);
    maker.seen([0.1, 0.2, 0.3], [0.5, 0.4, -1.0], 70.0)
}
