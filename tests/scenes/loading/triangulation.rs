//! Polygons: always n - 2 triangles that cover the polygon once, whatever its shape.

use super::common::load_obj;
use glam::{DVec2, DVec3};
use octray::internal::import::obj::sweep::sweep;
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

/// The plain way to cut ears, as it was before there was a tree to ask: every corner in turn, every vertex against it.
fn cut_plainly(points: &[DVec2]) -> (Vec<[u32; 3]>, Cut) {
    let turn = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    let mut triangles = Vec::new();
    let mut ring: Vec<u32> = (0..points.len() as u32).collect();
    let fan = |ring: &[u32], triangles: &mut Vec<[u32; 3]>| {
        triangles.extend(ring.windows(2).skip(1).map(|e| [ring[0], e[0], e[1]]));
    };
    let mut cut_flat = false;
    let (mut at, mut since_last_ear) = (0, 0);
    while ring.len() > 3 {
        let n = ring.len();
        if since_last_ear == n && !cut_flat {
            (cut_flat, since_last_ear) = (true, 0);
        }
        if since_last_ear == n {
            fan(&ring, &mut triangles);
            return (triangles, Cut::Crossing);
        }
        let corner = [(at + n - 1) % n, at % n, (at + 1) % n];
        let [a, b, c] = corner.map(|place| points[ring[place] as usize]);
        let area = turn(a, b, c);
        let empty = || {
            ring.iter().enumerate().all(|(place, &vertex)| {
                let p = points[vertex as usize];
                let outside = || turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0;
                corner.contains(&place) || p == a || p == b || p == c || outside()
            })
        };
        let is_ear = if area <= 0.0 { area == 0.0 && cut_flat } else { empty() };
        if is_ear {
            triangles.push(corner.map(|place| ring[place]));
            ring.remove(corner[1]);
            (cut_flat, since_last_ear) = (false, 0);
            at = if corner[1] + 1 == n { 1 } else { corner[1] + 1 };
        } else {
            since_last_ear += 1;
            at = corner[2];
        }
    }
    fan(&ring, &mut triangles);
    (triangles, Cut::Tiled)
}

/// Points of a whole polygon, whether it crosses itself or not, and its mirror image: both are cut as [`cut_plainly`] cuts
/// the one of them that runs counter-clockwise, unless they get a fan.
fn assert_cut_plainly(points: &[DVec2]) {
    let corners: Vec<DVec3> = points.iter().map(|p| p.extend(0.0)).collect();
    let (origin, normal) = (points[0], newell_normal(&corners));
    let flat = |p: &DVec2| match *p - origin {
        q if normal.z < 0.0 => DVec2::new(q.y, q.x),
        q => q,
    };
    let seen_whole = |i: usize| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]).dot(normal) >= 0.0;
    if points.len() > 3 && !(1..points.len() - 1).all(seen_whole) {
        let projected: Vec<DVec2> = points.iter().map(flat).collect();
        assert_eq!(cut(&corners), cut_plainly(&projected), "{points:?}");
    }
}

#[test]
fn the_tree_changes_no_triangle_of_larger_polygons() {
    let star = |i: u32| DVec2::from_angle(f64::from(i) / 1000.0 * std::f64::consts::TAU) * [0.45, 0.9][i as usize % 2];
    let wild = |i: u32| DVec2::new(f64::from(i * 7919 % 1009), f64::from(i * i % 1013));
    let comb = |i: u32| match i {
        0 => DVec2::new(0.0, -1.0),
        1 => DVec2::new(999.0, -1.0),
        _ => DVec2::new(f64::from(1000 - i), f64::from(i % 2 * 5)),
    };
    // Along a tilted line, where only rounding says which corners turn.
    let nearly_in_line = |i: u32| DVec2::new(0.1, 0.3) * f64::from(i.min(1000 - i)) + DVec2::X * f64::from(i / 999);
    for shape in [&star as &dyn Fn(u32) -> DVec2, &wild, &comb, &nearly_in_line] {
        let points: Vec<DVec2> = (0..1000).map(shape).collect();
        assert_cut_plainly(&points);
        assert_cut_plainly(&points.into_iter().rev().collect::<Vec<_>>());
    }
}

/// Seconds that cutting `corners` takes, whatever becomes of them.
fn seconds_of(corners: &[DVec3]) -> f64 {
    let start = std::time::Instant::now();
    assert_eq!(cut(corners).0.len(), corners.len() - 2);
    start.elapsed().as_secs_f64()
}

#[test]
fn a_hundred_thousand_corners_are_tiled_soon() {
    let n = 100_000;
    let radius = |i: u32| [0.45, 0.9][i as usize % 2];
    let star: Vec<_> = (0..n)
        .map(|i| (DVec2::from_angle(f64::from(i) / f64::from(n) * std::f64::consts::TAU) * radius(i)).extend(0.0))
        .collect();
    let teeth = (0..n).rev().map(|i| (f64::from(i), if i % 2 == 0 { 0.1 } else { 5.0 }));
    let comb: Vec<_> = [(0.0, 0.0), (f64::from(n - 1), -1.0)].into_iter().chain(teeth).collect();
    let arm = |r: f64| (0..n / 2).map(move |i| f64::from(i) * 0.01).map(move |t| DVec2::from_angle(t) * (1.0 + t + r));
    let spiral: Vec<_> =
        arm(0.5).chain(arm(0.0).collect::<Vec<_>>().into_iter().rev()).map(|p| p.extend(0.0)).collect();
    for corners in [star, flat(&comb), spiral] {
        let start = std::time::Instant::now();
        let (triangles, kind) = cut(&corners);
        assert_eq!((triangles.len(), kind), (corners.len() - 2, Cut::Tiled));
        assert!(start.elapsed().as_secs_f64() < 10.0);
        let direction = newell_normal(&corners).normalize();
        let areas = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| corners[i as usize]);
            (b - a).cross(c - a).dot(direction)
        });
        let (sum, least) = areas.fold((0.0, 0.0f64), |(sum, least), area| (sum + area, least.min(area)));
        let whole = newell_normal(&corners).length();
        assert!((sum - whole).abs() < 1e-9 * whole && least > -1e-9 * whole, "{sum} of {whole}, {least}");
    }
}

/// The sweep's triangles of a simple polygon tile it: that many, none turned, areas adding up, every edge in one triangle and
/// every diagonal in two.
fn assert_swept(points: &[DVec2]) {
    let n = points.len() as u32;
    let triangles = sweep(points).unwrap_or_else(|| panic!("{n} corners are not swept"));
    assert_eq!(triangles.len(), points.len() - 2);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize]);
        (b - a).perp_dot(c - a)
    };
    let whole: f64 = (0..points.len() - 1).map(|i| (points[i] - points[0]).perp_dot(points[i + 1] - points[0])).sum();
    assert!(triangles.iter().all(|t| area(t) >= -1e-9 * whole));
    assert!((triangles.iter().map(area).sum::<f64>() - whole).abs() < 1e-9 * whole);
    let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let edges: std::collections::HashSet<[u32; 2]> = edges.collect();
    assert_eq!(edges.len(), 3 * triangles.len(), "no edge twice in one direction");
    assert!(edges.iter().all(|&[a, b]| (a + 1) % n == b || edges.contains(&[b, a])));
}

/// Hilbert's curve over 2^order by 2^order places, thickened.
fn hilbert(order: u32) -> Vec<DVec2> {
    let places = 1u32 << (2 * order);
    let place = |number: u32| {
        let (mut t, mut x, mut y) = (number, 0u32, 0u32);
        for s in (0..order).map(|bit| 1 << bit) {
            let (right, up) = (1 & (t / 2), 1 & (t ^ (t / 2)));
            if up == 0 {
                if right == 1 {
                    (x, y) = (s - 1 - x, s - 1 - y);
                }
                (x, y) = (y, x);
            }
            (x, y, t) = (x + s * right, y + s * up, t / 4);
        }
        DVec2::new(x.into(), y.into())
    };
    let curve: Vec<DVec2> = (0..places).map(place).collect();
    let last = curve.len() - 1;
    let offset = |i: usize| {
        let (into, out) = (curve[i] - curve[i.saturating_sub(1)], curve[(i + 1).min(last)] - curve[i]);
        0.2 * match (into.perp(), out.perp()) {
            (DVec2::ZERO, one) | (one, DVec2::ZERO) => one,
            (one, other) if one == other => one,
            (one, other) => one + other,
        }
    };
    let right = (0..=last).map(|i| curve[i] - offset(i));
    right.chain((0..=last).rev().map(|i| curve[i] + offset(i))).collect()
}

fn star(corners: u32, radius: impl Fn(u32) -> f64) -> Vec<DVec2> {
    let angle = |i: u32| f64::from(i) / f64::from(corners) * std::f64::consts::TAU;
    (0..corners).map(|i| DVec2::from_angle(angle(i)) * radius(i)).collect()
}

#[test]
fn the_sweep_tiles_what_is_simple() {
    let wild = |i: u32| 0.05 + f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
    let arm = |r: f64| (0..500).map(move |i| f64::from(i) * 0.05).map(move |t| DVec2::from_angle(t) * (1.0 + t + r));
    let teeth = (0..200).rev().map(|i| DVec2::new(f64::from(i), if i % 2 == 0 { 0.1 } else { 5.0 }));
    let shapes: Vec<Vec<DVec2>> = vec![
        star(3, |_| 1.0),
        star(4, |_| 1.0),
        star(1000, |_| 1.0),
        star(1000, |i| [0.45, 0.9][i as usize % 2]),
        star(1001, wild),
        arm(0.5).rev().chain(arm(0.0)).rev().collect(),
        [DVec2::ZERO, DVec2::new(199.0, -1.0)].into_iter().chain(teeth).collect(),
        hilbert(1),
        hilbert(4),
    ];
    for mut points in shapes {
        for turned in 0..7 {
            let angle = DVec2::from_angle(f64::from(turned) * 0.9);
            let turned: Vec<DVec2> = points.iter().map(|p| angle.rotate(*p)).collect();
            assert_swept(&turned);
            let middle = points.len() / 3;
            points.rotate_left(middle);
            assert_swept(&points);
        }
    }
}

#[test]
fn a_simple_polygon_of_very_many_corners_is_not_said_to_cross_itself() {
    let wild = |i: u32| 0.05 + f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
    let shapes = [
        ("star", star(300_000, |i| [0.45, 0.9][i as usize % 2])),
        ("wild star", star(300_000, wild)),
        ("curve", hilbert(9)),
    ];
    for (name, points) in shapes {
        let start = std::time::Instant::now();
        assert_swept(&points);
        let corners: Vec<DVec3> = points.iter().map(|p| DVec3::new(p.x, 0.0, -p.y)).collect();
        assert_eq!(cut(&corners).1, Cut::Tiled, "{name}");
        assert!(start.elapsed().as_secs_f64() < 20.0, "{name}: {:?}", start.elapsed());
    }
}

#[test]
fn polygons_of_many_corners_that_cross_themselves_end_soon() {
    let n = 300_000u64;
    let point = |x: u64, y: u64| DVec3::new(x as f64, y as f64, 0.0);
    let wild: Vec<_> = (0..n).map(|i| point(i * 7919 % 300_007, i * 104_729 % 300_017)).collect();
    let zigzag: Vec<_> = (0..n).map(|i| point(i % 2 * (i % 997), i)).collect();
    let one_centre: Vec<_> =
        (0..n).map(|i| if i % 2 == 0 { DVec3::ZERO } else { point(i * i % 1009, i % 1013) }).collect();
    let in_line: Vec<_> = (0..n).map(|i| DVec3::new(0.1, 0.3, 0.0) * (i * 7919 % 300_007) as f64).collect();
    for (corners, name) in [(wild, "wild"), (zigzag, "zigzag"), (one_centre, "one centre"), (in_line, "in line")] {
        let seconds = seconds_of(&corners);
        assert!(seconds < 10.0, "{name}: {seconds} s");
    }
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

    /// The sweep takes no polygon that crosses itself, and every one in general position that does not.
    #[test]
    fn the_sweep_knows_what_crosses_itself(points in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 4..9)) {
        let mut points: Vec<DVec2> = points.into_iter().map(|(x, y)| DVec2::new(x, y)).collect();
        if (0..points.len() - 1).map(|i| points[i].perp_dot(points[i + 1])).sum::<f64>()
            + points[points.len() - 1].perp_dot(points[0]) < 0.0
        {
            points.reverse();
        }
        let n = points.len();
        let side = |a: usize, b: usize, c: usize| (points[b % n] - points[a % n]).perp_dot(points[c % n] - points[a % n]) > 0.0;
        let cross = |i: usize, j: usize| side(i, i + 1, j) != side(i, i + 1, j + 1) && side(j, j + 1, i) != side(j, j + 1, i + 1);
        let neighbours = |i: usize, j: usize| i == j || (i + 1) % n == j || (j + 1) % n == i;
        let crosses = (0..n).any(|i| (0..i).any(|j| !neighbours(i, j) && cross(i, j)));
        prop_assert_eq!(sweep(&points).is_none(), crosses, "{:?}", points);
        if !crosses {
            assert_swept(&points);
        }
    }

    /// Few places for many corners: most of them cross themselves, meet in points and turn back along their edges.
    #[test]
    fn the_tree_changes_no_triangle(
        places in prop::collection::vec((0u8..7, 0u8..7), 4..60),
        step in prop_oneof![Just(1.0), Just(0.1), Just(1e-3)],
    ) {
        let points: Vec<DVec2> = places.iter().map(|&(x, y)| DVec2::new(f64::from(x), f64::from(y)) * step).collect();
        assert_cut_plainly(&points);
    }
}
