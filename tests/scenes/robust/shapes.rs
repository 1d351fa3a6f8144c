//! Meshes made in code, and what is asked of every render of them.

use crate::common::{Maker, first_difference};
use glam::{DMat3, DVec3};
use octray::scene::desc::TriangleDesc;
use octray::{Engine, Film, PreparedScene, Settings, render};

/// Corners and triangles, fronts outwards.
pub type Mesh = (Vec<DVec3>, Vec<[u32; 3]>);

/// The unit sphere: an octahedron whose triangles are split in four `levels` times.
pub fn sphere(levels: u32) -> Mesh {
    let around = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for (i, &a) in around.iter().enumerate() {
        let b = around[(i + 1) % 4];
        triangles.extend([[a, b, DVec3::Z], [b, a, DVec3::NEG_Z]]);
    }
    for _ in 0..levels {
        let split = |&[a, b, c]: &[DVec3; 3]| {
            let [x, y, z] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
            [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
        };
        triangles = triangles.iter().flat_map(split).collect();
    }
    // The midpoint of an edge has the same bits from both sides (addition commutes), so corners meet exactly.
    let corners = triangles.iter().flatten().copied().collect();
    (corners, (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// A closed prism about the y axis from -1 to 1 with `sides` long sides at distance `radius`.
pub fn prism(sides: u32, radius: f64) -> Mesh {
    let corner = |i: u32, y: f64| {
        let turn = i as f64 / sides as f64 * std::f64::consts::TAU;
        DVec3::new(radius * turn.cos(), y, radius * turn.sin())
    };
    let mut corners: Vec<DVec3> =
        (0..sides).map(|i| corner(i, -1.0)).chain((0..sides).map(|i| corner(i, 1.0))).collect();
    corners.extend([DVec3::NEG_Y, DVec3::Y]);
    let side = |i: u32| {
        let next = (i + 1) % sides;
        let (a, b, c, d) = (i, next, sides + next, sides + i);
        [[a, c, b], [a, d, c], [2 * sides, a, b], [2 * sides + 1, c, d]]
    };
    (corners, (0..sides).flat_map(side).collect())
}

/// A closed prism along z whose base has a corner of `degrees`.
pub fn wedge(degrees: f64) -> Mesh {
    let (s, c) = degrees.to_radians().sin_cos();
    let base = [DVec3::ZERO, DVec3::X, DVec3::new(c, s, 0.0)];
    let corners = base.into_iter().chain(base.map(|p| p + DVec3::Z * 2.0)).collect();
    (corners, vec![[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])
}

/// The cube from -1 to 1.
pub fn cube() -> Mesh {
    let mut maker = Maker::default();
    maker.cuboid([-1.0; 3], [1.0; 3], false, 0);
    let corners = maker.mesh.positions.iter().map(|p| DVec3::from(p.map(f64::from)));
    (corners.collect(), maker.mesh.triangles.iter().map(|t| t.vertices).collect())
}

/// A rotation that leaves nothing parallel to an axis.
pub fn skew() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(0.3, 0.8, -0.52).normalize(), 0.7)
}

/// Adds `mesh`, its corners mapped by `place` and rounded.
pub fn add(maker: &mut Maker, mesh: &Mesh, material: u32, place: impl Fn(DVec3) -> DVec3) {
    let first = maker.mesh.positions.len() as u32;
    maker.mesh.positions.extend(mesh.0.iter().map(|&p| place(p).as_vec3().to_array()));
    let triangle = |t: &[u32; 3]| TriangleDesc { vertices: t.map(|v| first + v), material, flipped: false };
    maker.mesh.triangles.extend(mesh.1.iter().map(triangle));
}

/// Renders by both engines: the same bits, no sample that is not finite.
pub fn render_sanely(scene: &PreparedScene, settings: &Settings, what: &str) -> Film {
    let packet = render(scene, settings);
    assert_eq!(packet.stats.nonfinite, 0, "{what}: {:?}", packet.stats.nonfinite_samples);
    let scalar = render(scene, &Settings { engine: Engine::Scalar, ..settings.clone() });
    assert_eq!(first_difference(&packet.film, &scalar.film), None, "{what}");
    packet.film
}
