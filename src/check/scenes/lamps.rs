//! Lamps over floors, whose light a closed form tells.

use super::SceneMaker;
use super::maker::{DARK, Maker};
use crate::check::numbers::Numbers;
use crate::scene::SceneDesc;
use crate::scene::desc::{DeltaLight, DeltaLightDesc, LightDesc, Scattering};

/// The scenes.
pub const SCENES: &[SceneMaker] = &[
    SceneMaker {
        name: "lamp",
        numbers: &["half the side", "height", "radiance", "albedo of the floor", "x of the place seen"],
        make: lamp,
    },
    SceneMaker {
        name: "delta",
        numbers: &[
            "kind: 0 point, 1 spot, 2 directional",
            "height",
            "cone, degrees",
            "what of it fades",
            "x of the place seen",
        ],
        make: delta,
    },
    SceneMaker { name: "lamp_grid", numbers: &["lamps along a side"], make: lamp_grid },
    SceneMaker { name: "two_lamps", numbers: &["half the side of the small one", "its radiance"], make: two_lamps },
    SceneMaker { name: "parted_lamps", numbers: &["radiance of those behind the wall"], make: parted_lamps },
    SceneMaker { name: "mirrored_lamp", numbers: &["half the side", "height"], make: mirrored_lamp },
];

/// A square lamp, level, over a floor of half-size 20, seen through a narrow view of the floor at (x, 0, 0).
fn lamp(numbers: &[f64]) -> SceneDesc {
    let [half, height, radiance, albedo, x] = std::array::from_fn(|i| numbers[i]);
    let mut maker = Maker::default();
    let floor = maker.diffuse(albedo, 0.0);
    let lamp = maker.diffuse(0.0, radiance);
    maker.ground(20.0, floor);
    maker.level(height as f32, [half as f32; 2], true, lamp);
    // From between the two, straight down, so that nothing is in the way and the place is small.
    let eye = [x, 0.4 * height, 0.0];
    maker.seen(eye, [x, 0.0, 0.0], 1e-3)
}

/// A light that no ray can hit, over a floor. A directional one comes down at so many degrees beside the vertical as the
/// other numbers say of a cone.
fn delta(numbers: &[f64]) -> SceneDesc {
    let [kind, height, cone_angle, fades, x] = std::array::from_fn(|i| numbers[i]);
    let mut maker = Maker::default();
    let floor = maker.diffuse(0.5, 0.0);
    // Not larger than it need be: f32 then has places enough even within a narrow cone.
    let size = if x > 0.0 { x } else { height };
    maker.ground(20.0 * size as f32, floor);
    let (position, down) = ([0.0, height, 0.0], [0.0, -1.0, 0.0]);
    let intensity = [height * height; 3];
    let light = match kind as u32 {
        0 => DeltaLight::Point { position, intensity },
        1 => {
            let cone_delta_angle = fades * cone_angle;
            DeltaLight::Spot { position, direction: down, intensity, cone_angle, cone_delta_angle }
        }
        _ => {
            let (sine, cosine) = cone_angle.to_radians().sin_cos();
            DeltaLight::Directional { direction: [sine, -cosine, 0.0], irradiance: [1.0; 3] }
        }
    };
    maker.desc.lights.push(LightDesc::Delta(DeltaLightDesc { name: "delta".into(), light }));
    maker.seen([x, 0.4 * height, 0.0], [x, 0.0, 0.0], 1e-3)
}

/// A square grid of small lamps over a floor, at heights of 0.5 to 2 and of four decades of radiance; the floor's two triangles
/// come first.
fn lamp_grid(numbers: &[f64]) -> SceneDesc {
    let side = numbers[0] as u32;
    let mut maker = Maker::default();
    let floor = maker.diffuse(0.5, 0.0);
    maker.level(0.0, [4.0; 2], false, floor);
    let mut random = Numbers::new(side);
    for i in 0..side * side {
        let lamp = maker.diffuse(0.0, random.magnitude(-2.0, 2.0));
        let at = |n: u32| 6.0 * (n as f32 + 0.5) / side as f32 - 3.0;
        let (x, y, z, half) = (at(i % side), 0.5 + 1.5 * random.unit(), at(i / side), 0.02 + 0.1 * random.unit());
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        maker.quad(corners.map(|[dx, dz]| [x + dx, y, z + dz]), lamp);
    }
    maker.seen([0.0, 0.4, 3.5], [0.0, 0.0, 0.0], 60.0)
}

/// A lamp of half the side 1 and radiance 1, 1 above a grey floor; half-way below its middle a small one. The floor is seen
/// straight below both.
fn two_lamps(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let floor = maker.diffuse(0.5, 0.0);
    let (large, small) = (maker.diffuse(0.0, 1.0), maker.diffuse(0.0, numbers[1]));
    maker.ground(20.0, floor);
    maker.level(1.0, [1.0; 2], true, large);
    maker.level(0.5, [numbers[0] as f32; 2], true, small);
    maker.seen([0.0, 0.3, 0.0], [0.0; 3], 1e-3)
}

/// Two lamps of radiance 1 on this side of a wall on a floor, and two on the other; they are lower than the wall.
fn parted_lamps(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let floor = maker.diffuse(0.5, 0.0);
    maker.level(0.0, [2.0; 2], false, floor);
    maker.cuboid([-0.1, 0.0, -2.0], [0.1, 1.5, 2.0], false, floor);
    for (x, radiance) in [(-1.0, numbers[0]), (1.0, 1.0)] {
        let lamp = maker.diffuse(0.0, radiance);
        for z in [-1.0, 0.9] {
            maker
                .quad([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]].map(|[dx, dz]| [x + dx, 1.0, z + dz]), lamp);
        }
    }
    maker.seen([1.8, 0.8, 0.0], [0.4, 0.0, 0.0], 75.0)
}

/// Where the middle of the lamp of `mirrored_lamp` is, and the middle of its image, along x.
pub const MIRRORED: [f64; 2] = [0.25, 0.35];

/// A lamp of radiance 1 over a grey floor, and beside it an endless mirror that stands on the floor: the place seen, at the
/// origin, gets light from the lamp and from its image.
fn mirrored_lamp(numbers: &[f64]) -> SceneDesc {
    let [half, height] = [numbers[0] as f32, numbers[1] as f32];
    let mut maker = Maker::default();
    let floor = maker.diffuse(0.5, 0.0);
    let lamp = maker.diffuse(0.0, 1.0);
    let mirror = maker.material(Scattering::Mirror { reflectance: [1.0; 3] }, DARK);
    maker.ground(20.0, floor);
    let middle = MIRRORED[0] as f32;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    maker.quad(corners.map(|[x, z]: [f32; 2]| [middle + x * half, height, z * half]), lamp);
    let x = (0.5 * (MIRRORED[0] + MIRRORED[1])) as f32;
    maker.quad([[x, 0.0, -20.0], [x, 0.0, 20.0], [x, 20.0, 20.0], [x, 20.0, -20.0]], mirror);
    maker.seen([0.0, 0.4 * numbers[1], 0.0], [0.0; 3], 1e-3)
}
