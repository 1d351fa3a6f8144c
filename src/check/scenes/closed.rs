//! Closed meshes seen from inside: whatever leaves them has leaked into surroundings of radiance 1. Their walls are white, so
//! that paths never end by themselves.

use super::SceneMaker;
use super::floors::tilt;
use super::maker::Maker;
use crate::scene::SceneDesc;
use crate::scene::desc::EnvironmentDesc;
use glam::DVec3;
use std::f64::consts::TAU;

/// The scenes.
pub const SCENES: &[SceneMaker] = &[
    SceneMaker {
        name: "hollow",
        numbers: &["width", "height", "length", "tilted (0 or 1)", "scale", "sizes from the origin"],
        make: hollow,
    },
    SceneMaker { name: "cylinder", numbers: &["facets", "length", "tilted (0 or 1)"], make: cylinder },
    SceneMaker {
        name: "hollow_ball",
        numbers: &["times its octahedron is split", "sizes from the origin"],
        make: ball,
    },
    SceneMaker { name: "spindle", numbers: &["facets"], make: spindle },
    SceneMaker { name: "hollow_wedge", numbers: &["degrees"], make: wedge },
    SceneMaker { name: "room_on_ground", numbers: &["half the ground's size"], make: room_on_ground },
];

/// The scene in surroundings of radiance 1, moved to its place, seen from `inside`.
fn closed(mut maker: Maker, inside: DVec3, ahead: DVec3, place: impl Fn(DVec3) -> DVec3) -> SceneDesc {
    maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    let eye = place(inside);
    let look_at = place(ahead);
    maker.moved(|p| place(DVec3::from(p)).to_array()).seen(eye.to_array(), look_at.to_array(), 80.0)
}

/// Turned if `tilted` is not 0.
fn turned(tilted: f64) -> impl Fn(DVec3) -> DVec3 {
    move |p| if tilted == 0.0 { p } else { tilt() * p }
}

/// Away from the origin.
fn away(distance: f64) -> DVec3 {
    DVec3::new(0.62, -0.57, 0.54).normalize() * distance
}

/// A box.
fn hollow(numbers: &[f64]) -> SceneDesc {
    let [x, y, z, tilted, scale, sizes] = std::array::from_fn(|i| numbers[i]);
    let size = DVec3::new(x, y, z);
    let mut maker = Maker::default();
    let wall = maker.diffuse(1.0, 0.0);
    maker.cuboid([0.0; 3], size.as_vec3().to_array(), true, wall);
    let inside = size * DVec3::new(0.4, 0.55, 0.3);
    let ahead = size * DVec3::new(0.5, 0.5, 0.9);
    let (turn, away) = (turned(tilted), away(size.max_element() * sizes));
    closed(maker, inside, ahead, |p| (turn(p) + away) * scale)
}

/// A cylinder of radius 1 about the y axis.
fn cylinder(numbers: &[f64]) -> SceneDesc {
    let (facets, length) = (numbers[0] as u32, numbers[1]);
    let mut maker = Maker::default();
    let wall = maker.diffuse(1.0, 0.0);
    let corner = |i: u32, y: f64| {
        let (sine, cosine) = (f64::from(i % facets) / f64::from(facets) * TAU).sin_cos();
        [cosine as f32, y as f32, sine as f32]
    };
    let (bottom, top) = ([0.0f32; 3], [0.0, length as f32, 0.0]);
    for i in 0..facets {
        let [a, b, c, d] = [corner(i, 0.0), corner(i + 1, 0.0), corner(i + 1, length), corner(i, length)];
        maker.quad([a, b, c, d], wall);
        maker.triangle([bottom, b, a], wall);
        maker.triangle([top, d, c], wall);
    }
    closed(maker, DVec3::new(0.2, 0.3 * length, 0.1), DVec3::new(0.3, 0.6 * length, 0.0), turned(numbers[2]))
}

/// A ball.
fn ball(numbers: &[f64]) -> SceneDesc {
    let around = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
    let side = |i: usize| {
        let (a, b) = (around[i], around[(i + 1) % 4]);
        [[a, b, DVec3::Z], [b, a, DVec3::NEG_Z]]
    };
    let mut triangles: Vec<[DVec3; 3]> = (0..4).flat_map(side).collect();
    for _ in 0..numbers[0] as u32 {
        // The middle of an edge has the same bits from both sides, since addition commutes: corners meet exactly.
        let split = |&[a, b, c]: &[DVec3; 3]| {
            let [x, y, z] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
            [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
        };
        triangles = triangles.iter().flat_map(split).collect();
    }
    let mut maker = Maker::default();
    let wall = maker.diffuse(1.0, 0.0);
    triangles.iter().for_each(|corners| maker.triangle(corners.map(|p| p.as_vec3().to_array()), wall));
    let away = away(2.0 * numbers[1]);
    closed(maker, DVec3::new(0.1, 0.2, 0.0), DVec3::new(0.3, 0.1, -1.0), |p| tilt() * p + away)
}

/// Two cones, base to base: at either tip as many triangles meet as there are facets.
fn spindle(numbers: &[f64]) -> SceneDesc {
    let facets = numbers[0] as u32;
    let mut maker = Maker::default();
    let wall = maker.diffuse(1.0, 0.0);
    let corner = |i: u32| {
        let (sine, cosine) = (f64::from(i % facets) / f64::from(facets) * TAU).sin_cos();
        [cosine as f32, 0.0, sine as f32]
    };
    for i in 0..facets {
        maker.triangle([corner(i), corner(i + 1), [0.0, -1.0, 0.0]], wall);
        maker.triangle([corner(i + 1), corner(i), [0.0, 1.0, 0.0]], wall);
    }
    closed(maker, DVec3::new(0.1, 0.05, 0.1), DVec3::new(0.01, 1.0, 0.02), turned(1.0))
}

/// A prism with one acute edge.
fn wedge(numbers: &[f64]) -> SceneDesc {
    let (sine, cosine) = numbers[0].to_radians().sin_cos();
    let base = [DVec3::ZERO, DVec3::X, DVec3::new(cosine, sine, 0.0)];
    let corner = |i: usize| if i < 3 { base[i] } else { base[i - 3] + DVec3::Z * 2.0 };
    let mut maker = Maker::default();
    let wall = maker.diffuse(1.0, 0.0);
    for triangle in [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]] {
        maker.triangle(triangle.map(|i| corner(i).as_vec3().to_array()), wall);
    }
    let inside = (base[1] + base[2]) / 3.0 + DVec3::Z;
    closed(maker, inside, DVec3::new(0.5, 0.5 * sine, 0.0), turned(1.0))
}

/// A room whose walls cross a ground of any size.
fn room_on_ground(numbers: &[f64]) -> SceneDesc {
    let half = numbers[0] as f32;
    let mut maker = Maker::default();
    let wall = maker.diffuse(1.0, 0.0);
    maker.cuboid([-1.0, -0.7, -1.0], [1.0, 1.5, 1.3], true, wall);
    let [x, z] = [0.13 * half, -0.21 * half];
    let corners = [[x - half, 0.0, z + half], [x + half, 0.0, z + half], [x + half, 0.0, z - half]];
    maker.quad([corners[0], corners[1], corners[2], [x - half, 0.0, z - half]], wall);
    closed(maker, DVec3::new(0.1, 0.6, 0.2), DVec3::new(0.5, 0.1, -1.0), |p| p)
}
