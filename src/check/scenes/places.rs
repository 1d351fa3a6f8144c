//! A room in other units and elsewhere.

use super::SceneMaker;
use super::floors::tilt;
use super::maker::Maker;
use crate::scene::SceneDesc;
use crate::scene::desc::{CameraDesc, Scattering};
use glam::DVec3;

/// The scenes.
pub const SCENES: &[SceneMaker] =
    &[SceneMaker { name: "room", numbers: &["scale", "sizes from the origin", "grid"], make: room }];

/// A tilted room with a lamp, a mirror and a stone, of size 3. Its corners are multiples of `grid` before they are moved, and
/// so is the way they are moved: where `grid` is no finer than f32 is there, the room is the very same one elsewhere.
fn room(numbers: &[f64]) -> SceneDesc {
    let [scale, sizes, grid] = std::array::from_fn(|i| numbers[i]);
    let mut maker = Maker::default();
    let wall = maker.diffuse(0.7, 0.0);
    let lamp = maker.diffuse(0.0, 9.0);
    let mirror = maker.material(Scattering::Mirror { reflectance: [0.9; 3] }, super::maker::DARK);
    maker.cuboid([-1.0; 3], [1.0; 3], true, wall);
    maker.level(0.875, [0.3; 2], true, lamp);
    maker.cuboid([-0.6, -0.9, -0.6], [-0.1, 0.1, -0.1], false, wall);
    maker.cuboid([0.2, -0.8, -0.7], [0.7, -0.2, -0.2], false, mirror);
    let on_grid = |p: DVec3| (p / grid).round() * grid;
    let away = on_grid(DVec3::new(3.25, -3.25, 3.25) * sizes);
    let place = |p: DVec3| (on_grid(tilt() * p) + away) * scale;
    let eye = place(DVec3::new(0.1, 0.0, 0.9));
    let camera = CameraDesc {
        position: eye.to_array(),
        look_at: (eye + tilt() * DVec3::new(-0.1, -0.1, -2.0) * scale).to_array(),
        vertical_fov: 80.0,
        ..CameraDesc::default()
    };
    maker.moved(|p| place(DVec3::from(p)).to_array()).seen_by(camera)
}

/// The finest grid, but not below 2^-11, that f32 has so many sizes from the origin.
pub fn grid_at(sizes: f64) -> f64 {
    let farthest = 3.25 * sizes + 2.0;
    (farthest.log2().floor() - 23.0).exp2().max(1.0 / 2048.0)
}
