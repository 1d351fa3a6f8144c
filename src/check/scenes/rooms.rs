//! Closed rooms.

use super::SceneMaker;
use super::maker::Maker;
use crate::scene::SceneDesc;
use crate::scene::desc::EnvironmentDesc;

/// The scenes.
pub const SCENES: &[SceneMaker] = &[
    SceneMaker { name: "furnace", numbers: &["albedo", "emitted radiance"], make: furnace },
    SceneMaker { name: "globe", numbers: &["rings"], make: globe },
    SceneMaker { name: "corridor", numbers: &["length"], make: corridor },
];

/// A closed ball of radius 1 about the origin, faceted by so many rings, its inside white, in surroundings of radiance 1. Its
/// facets share the bits of their vertices.
fn globe(numbers: &[f64]) -> SceneDesc {
    let rings = numbers[0] as u32;
    let at = |ring: u32, step: u32| {
        if ring == 0 || ring == rings {
            return [0.0, if ring == 0 { 1.0 } else { -1.0 }, 0.0];
        }
        let part = std::f64::consts::PI / f64::from(rings);
        let (theta, phi) = (part * f64::from(ring), part * f64::from(step % (2 * rings)));
        let (sine, cosine) = (libm::sin(theta), libm::cos(theta));
        [sine * libm::cos(phi), cosine, sine * libm::sin(phi)].map(|x| x as f32)
    };
    let mut maker = Maker::default();
    let wall = maker.diffuse(1.0, 0.0);
    for (ring, step) in (0..rings).flat_map(|ring| (0..2 * rings).map(move |step| (ring, step))) {
        let [a, b, c, d] = [at(ring, step), at(ring + 1, step), at(ring + 1, step + 1), at(ring, step + 1)];
        // Fronts inwards; the caps are triangles.
        if ring > 0 {
            maker.triangle([a, d, c], wall);
        }
        if ring + 1 < rings {
            maker.triangle([a, c, b], wall);
        }
    }
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    maker.seen([0.1, 0.05, 0.2], [0.3, 0.2, -1.0], 90.0)
}

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
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    maker.seen([0.4, 0.55, 0.3], [0.5, 0.5, 1.3], 80.0)
}
