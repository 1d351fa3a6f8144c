//! Walls that are one closed surface.

use crate::common::small;
use glam::DVec3;
use octray::scene::SceneDesc;
use octray::scene::desc::{EnvironmentDesc, Scattering};
use octray::{Engine, Scene, Settings, Strategy, render};
use std::collections::HashMap;

/// The corners of a triangle, counter-clockwise seen from its front.
pub fn corners(scene: &SceneDesc, triangle: usize) -> [DVec3; 3] {
    scene.geometry().vertices(triangle).map(|v| DVec3::from(v.map(f64::from)))
}

/// The material of a triangle.
pub fn material(scene: &SceneDesc, triangle: usize) -> &str {
    &scene.materials[scene.geometry().triangles[triangle].material as usize].name
}

/// The triangles whose material `wanted` accepts.
pub fn of(scene: &SceneDesc, wanted: impl Fn(&str) -> bool) -> Vec<usize> {
    (0..scene.geometry().triangles.len()).filter(|&i| wanted(material(scene, i))).collect()
}

/// Asserts that every edge of `triangles` is passed once in either direction: a closed surface without T-junctions, by the bits
/// of its corners. The volume it encloses, positive if its fronts look inwards.
pub fn enclosed(scene: &SceneDesc, triangles: &[usize]) -> f64 {
    let mut passed: HashMap<[[u64; 3]; 2], u32> = HashMap::new();
    let mut volume = 0.0;
    for &i in triangles {
        let points = corners(scene, i);
        volume -= points[0].dot(points[1].cross(points[2])) / 6.0;
        // No -0: it is the same place as 0.
        let bits = points.map(|p| (p + 0.0).to_array().map(f64::to_bits));
        for k in 0..3 {
            *passed.entry([bits[k], bits[(k + 1) % 3]]).or_default() += 1;
        }
    }
    for (&[from, to], &count) in &passed {
        let place = [from, to].map(|p| p.map(f64::from_bits));
        assert!(
            count == 1 && passed.get(&[to, from]) == Some(&1),
            "the edge {place:?} is open, or passed {count} times"
        );
    }
    volume
}

/// Asserts that no path leaves: all is white and dark, in surroundings of radiance 1, so that any light has come from outside.
pub fn assert_tight(mut scene: SceneDesc) {
    for material in &mut scene.materials {
        (material.scattering, material.emission) = (Scattering::Diffuse { albedo: [1.0; 3] }, [0.0; 3]);
    }
    scene.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    let prepared = Scene::from(scene).prepare().unwrap_or_else(|error| panic!("{error}"));
    let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(100), rr_depth: None, ..small(32, 24, 16) };
    for engine in [Engine::Packet, Engine::Scalar] {
        let settings = Settings { engine, spp: if engine == Engine::Packet { 16 } else { 2 }, ..settings.clone() };
        let render = render(&prepared, &settings);
        assert!(render.stats.rays.bounce > 100 * 32 * 24, "{} rays prove little", render.stats.rays.bounce);
        assert_eq!((render.film.mean_radiance(), render.stats.nonfinite), ([0.0; 3], 0), "{engine}");
    }
}
