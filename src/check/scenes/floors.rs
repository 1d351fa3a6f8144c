//! Floors and lamps of every shape, whose direct light Lambert's formula tells ([`crate::check::truth`]).

use super::SceneMaker;
use super::maker::Maker;
use crate::scene::SceneDesc;
use glam::{DMat3, DVec3};

/// The scenes.
pub const SCENES: &[SceneMaker] = &[
    SceneMaker { name: "needle", numbers: &["length", "width", "height", "tilted (0 or 1)"], make: needle },
    SceneMaker {
        name: "sliver_floor",
        numbers: &["width of a strip", "strips", "tilted (0 or 1)"],
        make: sliver_floor,
    },
    SceneMaker { name: "ground", numbers: &["half the ground's size", "tilted (0 or 1)"], make: ground },
    SceneMaker { name: "touching", numbers: &["height", "tilted (0 or 1)"], make: touching },
    SceneMaker { name: "edge_on", numbers: &["distance from the lamp's plane"], make: edge_on },
    SceneMaker { name: "coplanar", numbers: &["height above the floor's plane"], make: coplanar },
    SceneMaker { name: "lamps", numbers: &["lamps along a side"], make: lamps },
    SceneMaker { name: "apart", numbers: &["radiance of the bright lamp"], make: apart },
    SceneMaker {
        name: "coincident",
        numbers: &["kind of the copy, 0 to 3", "1: the copy comes first"],
        make: coincident,
    },
    SceneMaker {
        name: "covered",
        numbers: &["1: the wall comes first", "1: no wall, only what is seen of the lamp"],
        make: covered,
    },
    SceneMaker { name: "pinhole", numbers: &["half the hole", "half the lamp"], make: pinhole },
    SceneMaker { name: "fan", numbers: &["triangles around the hub"], make: fan },
    SceneMaker { name: "overlapping", numbers: &["layers", "1: copies are reversed"], make: overlapping },
];

/// A rotation that leaves nothing parallel to an axis.
pub fn tilt() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(0.3, 0.8, -0.52).normalize(), 0.7)
}

/// `maker`'s scene, tilted if `tilted` is not 0, and seen from `eye` straight down onto the floor below.
fn from_above(maker: Maker, tilted: f64, eye: [f64; 3], fov: f64) -> SceneDesc {
    let below = [eye[0], 0.0, eye[2]];
    if tilted == 0.0 {
        return maker.seen(eye, below, fov);
    }
    let turned = |p: [f64; 3]| (tilt() * DVec3::from(p)).to_array();
    maker.moved(turned).seen(turned(eye), turned(below), fov)
}

/// A level rectangle of half-sizes `half` about (x, z).
fn level_at(maker: &mut Maker, [x, y, z]: [f32; 3], half: [f32; 2], down: bool, material: u32) {
    let [a, b] = half;
    let corners = [[x - a, y, z + b], [x + a, y, z + b], [x + a, y, z - b], [x - a, y, z - b]];
    let [p, q, r, s] = corners;
    maker.quad(if down { [s, r, q, p] } else { corners }, material);
}

/// A lamp of two slivers over a floor.
fn needle(numbers: &[f64]) -> SceneDesc {
    let [length, width, height, tilted] = std::array::from_fn(|i| numbers[i]);
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0));
    maker.ground(2.0, floor);
    level_at(&mut maker, [0.0, height as f32, 0.0], [0.5 * length as f32, 0.5 * width as f32], true, lamp);
    from_above(maker, tilted, [0.1 * length, 0.4 * height, 0.0], 1e-3)
}

/// A floor of strips 20 long under a square lamp.
fn sliver_floor(numbers: &[f64]) -> SceneDesc {
    let [width, strips, tilted] = std::array::from_fn(|i| numbers[i]);
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0));
    for strip in 0..strips as u32 {
        let edge = |k: u32| ((f64::from(k) - 0.5 * strips) * width) as f32;
        let (near, far) = (edge(strip + 1), edge(strip));
        maker.quad([[-10.0, 0.0, near], [10.0, 0.0, near], [10.0, 0.0, far], [-10.0, 0.0, far]], floor);
    }
    level_at(&mut maker, [0.2, 1.0, 0.1], [0.3, 0.3], true, lamp);
    let seen = (0.5 * strips * width / 0.4).to_degrees();
    from_above(maker, tilted, [0.013, 0.4, 0.0], seen.min(1e-3))
}

/// A lamp of half-size 0.3 a unit above a ground far larger than it.
fn ground(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0));
    let half = numbers[0] as f32;
    level_at(&mut maker, [0.13 * half, 0.0, -0.21 * half], [half; 2], false, floor);
    level_at(&mut maker, [0.2, 1.0, 0.1], [0.3, 0.3], true, lamp);
    from_above(maker, numbers[1], [0.1, 0.4, 0.0], 1e-3)
}

/// A lamp of ten heights close above a floor 4 wide.
fn touching(numbers: &[f64]) -> SceneDesc {
    let height = numbers[0];
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(1.0, 0.0), maker.diffuse(0.0, 1.0));
    level_at(&mut maker, [0.13, 0.0, -0.21], [2.0; 2], false, floor);
    level_at(&mut maker, [0.0, height as f32, 0.0], [5.0 * height as f32; 2], true, lamp);
    from_above(maker, numbers[1], [0.3 * height, 0.5 * height, 0.2 * height], 1e-3)
}

/// An upright lamp that faces the place seen from a plane next to it.
fn edge_on(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0));
    maker.ground(4.0, floor);
    let z = -numbers[0] as f32;
    maker.quad([[1.0, 0.5, z], [2.0, 0.5, z], [2.0, 1.5, z], [1.0, 1.5, z]], lamp);
    from_above(maker, 0.0, [0.0, 0.4, 0.0], 1e-3)
}

/// A lamp that faces up, beside the place seen and level with it.
fn coplanar(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0));
    maker.ground(4.0, floor);
    level_at(&mut maker, [1.0, numbers[0] as f32, 0.0], [0.5; 2], false, lamp);
    from_above(maker, 0.0, [0.0, 0.4, 0.0], 1e-3)
}

/// A square of so many lamps, a fifth of each cell dark, over a floor.
fn lamps(numbers: &[f64]) -> SceneDesc {
    let count = numbers[0].max(1.0) as u32;
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0));
    maker.ground(4.0, floor);
    let cell = 1.0 / f64::from(count);
    for (i, k) in (0..count).flat_map(|i| (0..count).map(move |k| (i, k))) {
        let centre = |n: u32| ((f64::from(n) + 0.5) * cell - 0.5) as f32;
        level_at(&mut maker, [centre(i), 1.0, centre(k)], [0.45 * cell as f32; 2], true, lamp);
    }
    from_above(maker, 0.0, [0.1, 0.4, 0.05], 1e-3)
}

/// A dim lamp over a floor, and a bright one beside it that faces away.
fn apart(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let (floor, dim, bright) = (maker.diffuse(1.0, 0.0), maker.diffuse(0.0, 1.0), maker.diffuse(0.0, numbers[0]));
    maker.ground(2.0, floor);
    level_at(&mut maker, [0.3, 1.0, 0.1], [0.25; 2], true, dim);
    level_at(&mut maker, [-1.0, 1.0, 0.1], [0.25; 2], false, bright);
    from_above(maker, 0.0, [0.0, 0.5, 0.0], 1e-2)
}

/// A lamp over a floor and, in its very place, 0: itself again, 1: with its corners in another order, 2: one that faces the
/// other way, 3: a wall that does not emit.
fn coincident(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let (floor, lamp, wall) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0), maker.diffuse(0.7, 0.0));
    maker.ground(2.0, floor);
    let corners = [[-0.3, 1.0, -0.4], [0.5, 1.0, -0.4], [0.5, 1.0, 0.4], [-0.3, 1.0, 0.4]];
    let [a, b, c, d]: [[f32; 3]; 4] = corners;
    let original = |maker: &mut Maker| maker.quad([a, b, c, d], lamp);
    let copy = |maker: &mut Maker| match numbers[0] as u32 {
        0 => maker.quad([a, b, c, d], lamp),
        1 => {
            maker.triangle([b, c, a], lamp);
            maker.triangle([d, a, c], lamp);
        }
        2 => {
            maker.triangle([c, b, a], lamp);
            maker.triangle([d, c, a], lamp);
        }
        _ => maker.quad([a, b, c, d], wall),
    };
    if numbers[1] == 0.0 {
        original(&mut maker);
        copy(&mut maker);
    } else {
        copy(&mut maker);
        original(&mut maker);
    }
    from_above(maker, 0.0, [0.1, 0.4, 0.05], 1e-3)
}

/// A lamp of which a wall in the same plane covers a part, or is covered by it, whichever comes first in the file.
fn covered(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let (floor, lamp, wall) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0), maker.diffuse(0.7, 0.0));
    maker.ground(2.0, floor);
    let level = |maker: &mut Maker, [x0, x1]: [f32; 2], half: f32, material: u32| {
        maker.quad([[x0, 1.3, -half], [x1, 1.3, -half], [x1, 1.3, half], [x0, 1.3, half]], material)
    };
    let (wall_first, seen) = (numbers[0] != 0.0, numbers[1] != 0.0);
    if wall_first && !seen {
        level(&mut maker, [-0.7, 0.2], 0.9, wall);
    }
    level(&mut maker, if wall_first && seen { [0.2, 0.5] } else { [-0.3, 0.5] }, 0.4, lamp);
    if !wall_first && !seen {
        level(&mut maker, [-0.7, 0.2], 0.9, wall);
    }
    from_above(maker, 0.0, [0.1, 0.4, 0.05], 1e-3)
}

/// A lamp two units above a floor, seen from it through a hole in a black sheet halfway.
fn pinhole(numbers: &[f64]) -> SceneDesc {
    let (hole, half) = (numbers[0] as f32, numbers[1] as f32);
    let mut maker = Maker::default();
    let (floor, lamp, sheet) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0), maker.diffuse(0.0, 0.0));
    maker.ground(2.0, floor);
    maker.level(2.0, [half; 2], true, lamp);
    let ring = |half: f32| [[-half, 1.0, half], [half, 1.0, half], [half, 1.0, -half], [-half, 1.0, -half]];
    let (inner, outer) = (ring(hole), ring(2.0));
    for i in 0..4 {
        let next = (i + 1) % 4;
        maker.quad([outer[i], outer[next], inner[next], inner[i]], sheet);
    }
    from_above(maker, 0.0, [0.0, 0.4, 0.0], 1e-4)
}

/// A lamp over a floor whose triangles all meet in one vertex, seen next to that.
fn fan(numbers: &[f64]) -> SceneDesc {
    let count = numbers[0] as u32;
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0));
    let rim = |i: u32| {
        let (sine, cosine) = (f64::from(i % count) / f64::from(count) * std::f64::consts::TAU).sin_cos();
        [(2.0 * cosine) as f32, 0.0, (-2.0 * sine) as f32]
    };
    (0..count).for_each(|i| maker.triangle([[0.0; 3], rim(i), rim(i + 1)], floor));
    level_at(&mut maker, [0.2, 1.0, 0.1], [0.3, 0.3], true, lamp);
    from_above(maker, 0.0, [0.011, 0.4, 0.013], 1e-3)
}

/// A lamp over several floors in one plane, no two of which are cut alike.
fn overlapping(numbers: &[f64]) -> SceneDesc {
    let mut maker = Maker::default();
    let (floor, lamp) = (maker.diffuse(0.5, 0.0), maker.diffuse(0.0, 1.0));
    for layer in 0..numbers[0] as u32 {
        let half = 1.0 + 0.37 * layer as f32;
        let [x, z] = [0.11 * layer as f32, -0.07 * layer as f32];
        level_at(&mut maker, [x, 0.0, z], [half, 1.3 * half], numbers[1] != 0.0 && layer % 2 == 1, floor);
    }
    level_at(&mut maker, [0.2, 1.0, 0.1], [0.3, 0.3], true, lamp);
    from_above(maker, 1.0, [0.1, 0.4, 0.05], 1e-3)
}
