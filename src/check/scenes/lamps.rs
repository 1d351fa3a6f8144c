//! Lamps over floors, whose light a closed form tells.

use super::SceneMaker;
use super::maker::Maker;
use crate::scene::SceneDesc;

/// The scenes.
pub const SCENES: &[SceneMaker] = &[SceneMaker {
    name: "lamp",
    numbers: &["half the side", "height", "radiance", "albedo of the floor", "x of the place seen"],
    make: lamp,
}];

/// A square lamp, level, over a floor of half-size 20, seen through a narrow view of the floor at (x, 0, 0).
fn lamp(numbers: &[f64]) -> SceneDesc {
    let [half, height, radiance, albedo, x] = std::array::from_fn(|i| numbers[i]);
    let mut maker = Maker::default();
    let floor = maker.diffuse(albedo, 0.0);
    let lamp = maker.diffuse(0.0, radiance);
    maker.level(0.0, [20.0; 2], false, floor);
    maker.level(height as f32, [half as f32; 2], true, lamp);
    // From between the two, straight down, so that nothing is in the way and the place is small.
    let eye = [x, 0.4 * height, 0.0];
    maker.seen(eye, [x, 0.0, 0.0], 1e-3)
}
