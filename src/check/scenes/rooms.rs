//! Closed rooms.

use super::SceneMaker;
use super::maker::Maker;
use crate::scene::SceneDesc;

/// The scenes.
pub const SCENES: &[SceneMaker] = &[
    SceneMaker { name: "furnace", numbers: &["albedo", "emitted radiance"], make: furnace },
    SceneMaker { name: "corridor", numbers: &["length"], make: corridor },
];

/// A closed box whose walls emit and reflect alike: by the geometric sum, L = E (1 + a + .. + a^N) in every direction.
fn furnace(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let wall = maker.diffuse(numbers[0], numbers[1]);
    maker.cuboid([-1.0, -1.0, -1.0], [1.0, 1.5, 2.0], true, wall);
    maker.seen([0.1, 0.2, 0.3], [0.5, 0.4, -1.0], 70.0)
}

/// A closed corridor, 1 wide and high and so long, seen from its one end: whatever leaves it has leaked into surroundings of
/// radiance 1. Its walls are white.
fn corridor(numbers: &[f64]) -> SceneDesc {
    let length = numbers[0];
    let mut maker = Maker::default();
    let wall = maker.diffuse(1.0, 0.0);
    maker.cuboid([0.0, 0.0, 0.0], [1.0, 1.0, length as f32], true, wall);
    maker.desc.set_environment(Some(crate::scene::desc::EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    maker.seen([0.4, 0.55, 0.3], [0.5, 0.5, 1.3], 80.0)
}
