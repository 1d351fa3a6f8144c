//! Polygons: always n - 2 triangles that cover the polygon once, whatever its shape.

use super::common::load_obj;
use glam::DVec3;
use octray::internal::import::obj::triangulate::{Cut, newell_normal, triangulate};
use proptest::prelude::*;

fn cut(corners: &[DVec3]) -> (Vec<[u32; 3]>, Cut) {
    let mut triangles = Vec::new();
    let kind = triangulate(corners, &mut triangles);
    (triangles, kind)
}

/// n - 2 triangles, every corner in use, all turning as the polygon does, areas adding up to its area. For a polygon
/// that does not cross itself this means: they tile it.
fn assert_tiles(corners: &[DVec3], slack: f64) {
    let (triangles, kind) = cut(corners);
    assert_eq!((triangles.len(), kind), (corners.len() - 2, Cut::Tiled), "{corners:?}");
    assert!((0..corners.len() as u32).all(|i| triangles.iter().flatten().any(|&v| v == i)));
    let normal = newell_normal(corners);
    let direction = normal.normalize();
    let mut sum = 0.0;
    for t in &triangles {
        let [a, b, c] = t.map(|i| corners[i as usize]);
        let area = (b - a).cross(c - a).dot(direction);
        assert!(area >= -slack * normal.length(), "{t:?} turns the other way by {area} in {corners:?}");
        sum += area;
    }
    assert!((sum - normal.length()).abs() <= slack * normal.length(), "{sum} of {}", normal.length());
}

fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
    points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect()
}

#[test]
fn well_known_shapes_are_tiled_from_every_first_corner_and_side() {
    let shapes: &[&[(f64, f64)]] = &[
        &[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)],
        &[(0.0, 0.0), (2.0, 0.0), (1.0, 0.5), (0.0, 2.0)], // dart
        &[(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)], // L
        &[(0.0, 0.0), (5.0, 0.0), (5.0, 3.0), (4.0, 3.0), (4.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)], // U
        &[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (3.0, 3.0), (1.5, 1.0), (0.0, 3.0)], // corners in line
        &[
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 4.0),
            (0.0, 4.0),
            (0.0, 0.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (3.0, 3.0),
            (3.0, 1.0),
            (1.0, 1.0),
        ], // hole
    ];
    let turns =
        [[DVec3::X, DVec3::Y], [DVec3::Y, DVec3::Z], [DVec3::Z, DVec3::X], [DVec3::Y, DVec3::X], [DVec3::Z, DVec3::Y]];
    for shape in shapes {
        for [across, up] in turns {
            for first in 0..shape.len() {
                let mut corners: Vec<_> =
                    shape.iter().map(|&(x, y)| across * x + up * y + DVec3::new(100.0, -7.0, 3.0)).collect();
                corners.rotate_left(first);
                assert_tiles(&corners, 1e-12);
            }
        }
    }
}

#[test]
fn spirals_and_combs_are_tiled() {
    let teeth = (0..200).map(|i| (f64::from(i), if i % 2 == 0 { 0.1 } else { 5.0 }));
    let comb: Vec<_> = [(0.0, 0.0), (199.0, -1.0)].into_iter().chain(teeth.rev()).collect();
    assert_tiles(&flat(&comb), 1e-9);
    let arm = |r: f64| {
        (0..300).map(move |i| (f64::from(i) * 0.05, r)).map(|(t, r)| ((1.0 + t + r) * t.cos(), (1.0 + t + r) * t.sin()))
    };
    let spiral: Vec<_> = arm(0.5).chain(arm(0.0).collect::<Vec<_>>().into_iter().rev()).collect();
    assert_tiles(&flat(&spiral), 1e-9);
}

#[test]
fn polygons_without_a_right_answer_keep_their_number() {
    let pentagram = flat(&[(0.0, 3.0), (2.0, -3.0), (-3.0, 1.0), (3.0, 1.0), (-2.0, -3.0)]);
    let bow = flat(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]);
    let line = flat(&[(0.0, 0.0), (1.0, 0.0), (3.0, 0.0), (2.0, 0.0), (5.0, 0.0)]);
    let point = flat(&[(1.0, 1.0); 6]);
    for corners in [pentagram, bow, line, point] {
        assert_eq!(cut(&corners).0.len(), corners.len() - 2, "{corners:?}");
    }
    assert!(cut(&[]).0.is_empty() && cut(&flat(&[(0.0, 0.0), (1.0, 0.0)])).0.is_empty());
    // Hostile: thousands of random corners end quickly.
    let wild: Vec<_> =
        (0..20_000u32).map(|i| (f64::from(i * 7919 % 20_011), f64::from(i * 104_729 % 20_021))).collect();
    assert_eq!(cut(&flat(&wild)).0.len(), wild.len() - 2);
}

#[test]
fn ids_count_triangles_in_file_order() {
    let text = "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nusemtl a\nf 1 2 3 4 5 6\nusemtl b\nf 1 2 3\n\
                usemtl a\nf 1 1 1 1\nf 1 2 3 4\n";
    let scene = load_obj(text).unwrap();
    let names: Vec<_> =
        scene.geometry().triangles.iter().map(|t| scene.materials[t.material as usize].name.as_str()).collect();
    assert_eq!(names, ["a", "a", "a", "a", "b", "a", "a", "a", "a"]);
    assert_eq!(scene.materials.len(), 2);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    /// Star-shaped polygons about the origin, in any plane, far from it or not: simple, mostly concave.
    #[test]
    fn random_simple_polygons_are_tiled(
        radii in prop::collection::vec(0.05f64..1.0, 3..40),
        tilt in (0.0f64..6.3, 0.0f64..6.3),
        shift in -100.0f64..100.0,
        mirrored in any::<bool>(),
    ) {
        let n = radii.len() as f64;
        let turn = glam::DQuat::from_rotation_x(tilt.0) * glam::DQuat::from_rotation_y(tilt.1);
        let point = |(i, r): (usize, &f64)| {
            let angle = i as f64 / n * std::f64::consts::TAU;
            turn * DVec3::new(r * angle.cos(), r * angle.sin(), 0.0) + DVec3::splat(shift)
        };
        let mut corners: Vec<_> = radii.iter().enumerate().map(point).collect();
        if mirrored {
            corners.reverse();
        }
        assert_tiles(&corners, 1e-9);
    }
}
