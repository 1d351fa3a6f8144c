//! Surroundings over floors and plates.

use super::SceneMaker;
use super::maker::{DARK, Maker};
use crate::check::numbers::Numbers;
use crate::scene::SceneDesc;
use crate::scene::desc::{EnvironmentDesc, MapDesc, Scattering};

/// The scenes.
pub const SCENES: &[SceneMaker] = &[
    SceneMaker { name: "plate", numbers: &["index", "alpha", "degrees from the normal"], make: plate },
    SceneMaker { name: "texel", numbers: &["rows", "row", "columns", "column"], make: texel },
    SceneMaker { name: "noise_sky", numbers: &["columns", "rows", "seed"], make: noise_sky },
    SceneMaker { name: "even_sky", numbers: &["columns", "rows", "radiance", "0 a map, 1 a constant"], make: even_sky },
];

/// A level plate of white plastic under a sky of radiance 1, seen from far away at an angle to its normal.
fn plate(numbers: &[f64]) -> SceneDesc {
    let [ior, alpha, degrees] = std::array::from_fn(|i| numbers[i]);
    let mut maker = Maker::default();
    let coat = maker.material(Scattering::Plastic { albedo: [1.0; 3], ior, alpha }, DARK);
    maker.level(0.0, [2.0; 2], false, coat);
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    let angle = degrees.to_radians();
    maker.seen([50.0 * libm::sin(angle), 50.0 * libm::cos(angle), 0.0], [0.0; 3], 1e-2)
}

/// A white floor that faces up under `environment`, seen from above.
fn floor(environment: EnvironmentDesc) -> SceneDesc {
    let mut maker = Maker::default();
    let floor = maker.diffuse(1.0, 0.0);
    maker.level(0.0, [2.0; 2], false, floor);
    maker.desc.set_environment(Some(environment));
    maker.seen([0.0, 1.0, 0.0], [0.0, 0.0, 0.0], 30.0)
}

fn map(columns: u32, rows: u32, texels: Vec<[f32; 3]>) -> EnvironmentDesc {
    let file = "a map of the suite".into();
    EnvironmentDesc::Map(MapDesc { file, width: columns, height: rows, texels, rotate: 0.0, scale: 1.0 })
}

/// A white floor under a map that is black but for one texel of radiance 1 (black altogether if there is no such texel).
fn texel(numbers: &[f64]) -> SceneDesc {
    let [rows, row, columns, column] = std::array::from_fn(|i| numbers[i] as u32);
    let mut texels = vec![[0.0; 3]; rows as usize * columns as usize];
    if let Some(texel) = texels.get_mut(row as usize * columns as usize + column as usize) {
        *texel = [1.0; 3];
    }
    floor(map(columns, rows, texels))
}

/// The radiances of `noise_sky`, row by row from the top: five decades.
pub fn noise(columns: u32, rows: u32, seed: u32) -> Vec<f32> {
    let mut numbers = Numbers::new(seed);
    (0..columns * rows).map(|_| numbers.magnitude(-3.0, 2.0) as f32).collect()
}

/// A white floor under a map of noise.
fn noise_sky(numbers: &[f64]) -> SceneDesc {
    let [columns, rows, seed] = std::array::from_fn(|i| numbers[i] as u32);
    floor(map(columns, rows, noise(columns, rows, seed).into_iter().map(|value| [value; 3]).collect()))
}

/// A white floor under a sky that is the same everywhere: a map, or a constant.
fn even_sky(numbers: &[f64]) -> SceneDesc {
    let [columns, rows] = std::array::from_fn(|i| numbers[i] as u32);
    floor(match numbers[3] == 0.0 {
        true => map(columns, rows, vec![[numbers[2] as f32; 3]; columns as usize * rows as usize]),
        false => EnvironmentDesc::Constant { radiance: [numbers[2]; 3] },
    })
}
