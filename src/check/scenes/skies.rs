//! Surroundings over floors.

use super::SceneMaker;
use super::maker::Maker;
use crate::scene::SceneDesc;
use crate::scene::desc::{EnvironmentDesc, MapDesc};

/// The scenes.
pub const SCENES: &[SceneMaker] =
    &[SceneMaker { name: "texel", numbers: &["rows", "row", "column", "columns"], make: texel }];

/// A white floor that faces up under a map which is black but for one texel of radiance 1, seen from above.
fn texel(numbers: &[f64]) -> SceneDesc {
    let [rows, row, column, columns] = std::array::from_fn(|i| numbers[i] as u32);
    let mut texels = vec![[0.0; 3]; rows as usize * columns as usize];
    texels[row as usize * columns as usize + column as usize] = [1.0; 3];
    let map = MapDesc { file: "one texel".into(), width: columns, height: rows, texels, rotate: 0.0, scale: 1.0 };
    let mut maker = Maker::default();
    let floor = maker.diffuse(1.0, 0.0);
    maker.level(0.0, [2.0; 2], false, floor);
    maker.desc.set_environment(Some(EnvironmentDesc::Map(map)));
    maker.seen([0.0, 1.0, 0.0], [0.0, 0.0, 0.0], 30.0)
}
