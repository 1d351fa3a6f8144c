//! Round shapes as triangles, for lamps. Their areas are those of the shapes they stand for, and so is what they emit.

use crate::scene::desc::{MeshDesc, TriangleDesc};
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::PI;

/// How often each triangle of the icosahedron becomes four: 1280 triangles, whose points are between 0.997 and 1.003 radii from
/// the centre.
const SUBDIVISIONS: u32 = 3;

/// Triangles of a disk. Its edge lies between 0.9995 and 1.0009 radii from the centre.
const SLICES: u32 = 64;

/// A sphere of triangles, counter-clockwise seen from outside, in material `material`. Its area is that of the sphere.
pub fn sphere(center: [f64; 3], radius: f64, material: u32) -> MeshDesc {
    let (mut points, mut triangles) = icosahedron();
    for _ in 0..SUBDIVISIONS {
        triangles = subdivide(&mut points, &triangles);
    }
    let area: f64 = triangles.iter().map(|t| area_of(t.map(|v| points[v as usize]))).sum();
    let scale = radius * (4.0 * PI / area).sqrt();
    mesh(points.iter().map(|&p| DVec3::from(center) + p * scale), triangles, material)
}

/// A disk of triangles about `center`, counter-clockwise seen from where its normal points, in material `material`. Its area is
/// that of the disk.
pub fn disk(center: [f64; 3], normal: [f64; 3], radius: f64, material: u32) -> MeshDesc {
    let center = DVec3::from(center);
    let (x, y) = DVec3::from(normal).normalize().any_orthonormal_pair();
    let slice = 2.0 * PI / f64::from(SLICES);
    let scale = radius * (slice / slice.sin()).sqrt();
    let rim = (0..SLICES).map(|i| {
        let (sine, cosine) = (f64::from(i) * slice).sin_cos();
        center + (x * cosine + y * sine) * scale
    });
    let triangles = (0..SLICES).map(|i| [0, 1 + i, 1 + (i + 1) % SLICES]).collect();
    mesh(std::iter::once(center).chain(rim), triangles, material)
}

/// The area of a mesh, in f64.
pub fn area(mesh: &MeshDesc) -> f64 {
    let corner = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
    mesh.triangles.iter().map(|triangle| area_of(triangle.vertices.map(corner))).sum()
}

fn area_of([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

fn mesh(positions: impl Iterator<Item = DVec3>, triangles: Vec<[u32; 3]>, material: u32) -> MeshDesc {
    let positions = positions.map(|p| p.as_vec3().to_array()).collect();
    let triangle = |vertices| TriangleDesc { vertices, material, flipped: false };
    MeshDesc { positions, triangles: triangles.into_iter().map(triangle).collect(), corners: Vec::new() }
}

/// Points on the unit sphere, and triangles seen counter-clockwise from outside.
fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).normalize();
    let mut points = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        points.extend([corner(0.0, a, b), corner(a, b, 0.0), corner(b, 0.0, a)]);
    }
    // Three corners that are neighbours of each other are a face.
    let edge = points[1..].iter().map(|&p| points[0].distance(p)).fold(f64::INFINITY, f64::min);
    let near = |a: usize, b: usize| points[a].distance(points[b]) < 1.01 * edge;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in (b + 1..12).filter(|&c| near(a, b) && near(b, c) && near(c, a)) {
                let outwards = (points[b] - points[a]).cross(points[c] - points[a]).dot(points[a]) > 0.0;
                triangles.push(if outwards { [a, b, c] } else { [a, c, b] }.map(|v| v as u32));
            }
        }
    }
    (points, triangles)
}

/// Each triangle as four, with new points on the unit sphere above the middles of its edges.
fn subdivide(points: &mut Vec<DVec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let mut finer = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    finer
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(mesh: &MeshDesc) -> impl Iterator<Item = [DVec3; 3]> {
        let corner = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
        mesh.triangles.iter().map(move |triangle| triangle.vertices.map(corner))
    }

    #[test]
    fn shapes_have_the_areas_they_stand_for() {
        let (ball, plate) = (sphere([1.0, -2.0, 3.0], 0.5, 7), disk([1.0, -2.0, 3.0], [1.0, 2.0, -3.0], 0.5, 7));
        assert!((area(&ball) / PI - 1.0).abs() < 1e-5, "{}", area(&ball));
        assert!((area(&plate) / (0.25 * PI) - 1.0).abs() < 1e-5, "{}", area(&plate));
        assert_eq!((ball.triangles.len(), plate.triangles.len()), (1280, 64));
        assert!(ball.triangles.iter().chain(&plate.triangles).all(|triangle| triangle.material == 7));
    }

    #[test]
    fn a_sphere_is_closed_looks_outwards_and_is_as_round_as_it_says() {
        let ball = sphere([0.0; 3], 1.0, 0);
        let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
        for [a, b, c] in ball.triangles.iter().map(|triangle| triangle.vertices) {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|&sum| sum == 0) && edges.len() == 1920);
        for [a, b, c] in corners(&ball) {
            let normal = (b - a).cross(c - a).normalize();
            let nearest = normal.dot(a);
            assert!((0.997..1.0).contains(&nearest) && (1.0..1.003).contains(&a.length()), "{nearest}, {}", a.length());
        }
    }

    #[test]
    fn a_disk_looks_along_its_normal_and_is_as_round_as_it_says() {
        let normal = DVec3::new(-1.0, 0.5, 2.0);
        for [a, b, c] in corners(&disk([0.0; 3], normal.to_array(), 1.0, 0)) {
            assert!((b - a).cross(c - a).normalize().dot(normal.normalize()) > 0.999_99);
            assert!((1.0..1.0009).contains(&b.length()) && (0.9995..1.0).contains(&(0.5 * (b + c)).length()));
        }
    }
}
