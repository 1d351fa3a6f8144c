//! Scenes whose image is known without rendering: furnaces.
//!
//! Inside a closed surface that everywhere emits E and diffusely reflects the fraction a of what arrives, the radiance is
//! the same in every direction from every point: L = E + a L, so L = E / (1 - a). Cut after N scattering events it is
//! E (1 + a + .. + a^N). What must hold for it is checked on the scene, not taken from its name.

use std::collections::HashMap;

use crate::scene::SceneDesc;
use crate::scene::desc::Scattering;
use crate::scene::flatten::Geometry;
use glam::DVec3;

/// The radiance of every pixel, W sr^-1 m^-2, if `scene` is a furnace whose inside the camera sees.
pub fn radiance(scene: &SceneDesc, max_depth: Option<u32>) -> Option<[f64; 3]> {
    let geometry = scene.geometry();
    let first = &scene.materials[geometry.triangles.first()?.material as usize];
    let Scattering::Diffuse { albedo } = first.scattering else { return None };
    let same = geometry.triangles.iter().all(|triangle| {
        let material = &scene.materials[triangle.material as usize];
        material.scattering == first.scattering
            && material.emission == first.emission
            && material.two_sided == first.two_sided
            && (material.texture, material.emission_texture) == (None, None)
    });
    let lit = first.emission.iter().any(|e| *e > 0.0) && albedo.iter().all(|a| *a < 1.0);
    // Interpolated normals change what a surface reflects; a lens could reach outside.
    if !same || !lit || !scene.lights.is_empty() || !geometry.corners.is_empty() || scene.camera.aperture_radius > 0.0 {
        return None;
    }
    if !closed_and_fronts_inwards(&geometry, DVec3::from_array(scene.camera.eye())) {
        return None;
    }
    let channel = |c: usize| {
        let (e, a) = (first.emission[c], albedo[c]);
        let cut = max_depth.map_or(0.0, |n| a.powi(n.saturating_add(1).min(i32::MAX as u32) as i32));
        e * (1.0 - cut) / (1.0 - a)
    };
    Some(std::array::from_fn(channel))
}

/// Whether the triangles make one closed surface around the camera, with its front towards it: every directed edge is met
/// once and its opposite once, all triangles hang together, and they turn once around the eye.
fn closed_and_fronts_inwards(geometry: &Geometry<'_>, eye: DVec3) -> bool {
    let corner = |index: u32| geometry.positions[index as usize];
    // Vertices are the same where their positions are: files repeat them.
    let mut ids: HashMap<[u32; 3], usize> = HashMap::new();
    let mut id = |index: u32| {
        let next = ids.len();
        *ids.entry(corner(index).map(|value| (value + 0.0).to_bits())).or_insert(next)
    };
    let mut edges: HashMap<(usize, usize), usize> = HashMap::new();
    let mut parts = Parts((0..geometry.triangles.len()).collect());
    let mut solid_angle = 0.0;
    for (number, triangle) in geometry.triangles.iter().enumerate() {
        let [a, b, c] = triangle.vertices;
        let [a, b, c] = if triangle.flipped { [a, c, b] } else { [a, b, c] };
        solid_angle += signed_solid_angle([a, b, c].map(|i| DVec3::from_array(corner(i).map(f64::from)) - eye));
        let [a, b, c] = [id(a), id(b), id(c)];
        for edge in [(a, b), (b, c), (c, a)] {
            if edges.insert(edge, number).is_some() {
                return false;
            }
        }
    }
    for ((a, b), number) in &edges {
        let Some(neighbour) = edges.get(&(*b, *a)) else { return false };
        parts.join(*number, *neighbour);
    }
    let whole = (0..geometry.triangles.len()).all(|number| parts.root(number) == parts.root(0));
    // Fronts turn counter-clockwise seen from the front: seen from inside a surface that faces inwards, once around.
    whole && (solid_angle + 4.0 * std::f64::consts::PI).abs() < 1e-3
}

/// The solid angle of a triangle seen from the origin, above 0 where its corners turn clockwise for the observer (van
/// Oosterom and Strackee, *The Solid Angle of a Plane Triangle*, 1983).
fn signed_solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot(b.cross(c));
    2.0 * volume.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// Disjoint sets of triangles.
struct Parts(Vec<usize>);

impl Parts {
    fn root(&mut self, mut of: usize) -> usize {
        while self.0[of] != of {
            self.0[of] = self.0[self.0[of]];
            of = self.0[of];
        }
        of
    }
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::desc::EnvironmentDesc;

    fn furnace() -> SceneDesc {
        SceneDesc::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace.toml")).unwrap()
    }

    #[test]
    fn the_furnace_is_known_and_so_are_its_first_bounces() {
        assert_eq!(radiance(&furnace(), None), Some([1.0; 3]));
        assert_eq!([0, 1, 2].map(|n| radiance(&furnace(), Some(n)).unwrap()[0]), [0.5, 0.75, 0.875]);
    }

    #[test]
    fn what_is_nearly_a_furnace_is_not_taken_for_one() {
        let mut open = furnace();
        open.meshes[0].triangles.pop();
        let mut turned = furnace();
        turned.meshes[0].triangles[0].flipped = !turned.meshes[0].triangles[0].flipped;
        let mut inside_out = furnace();
        inside_out.meshes[0].triangles.iter_mut().for_each(|triangle| triangle.flipped = !triangle.flipped);
        let mut outside = furnace();
        outside.camera.position = [0.0, 0.0, 1e3];
        let mut dark = furnace();
        dark.materials.iter_mut().for_each(|material| material.emission = [0.0; 3]);
        let mut sky = furnace();
        sky.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
        let mut mixed = furnace();
        mixed.materials.push(mixed.materials[0].clone());
        mixed.materials.last_mut().unwrap().emission = [0.25; 3];
        mixed.meshes[0].triangles[0].material = mixed.materials.len() as u32 - 1;
        let cornell = SceneDesc::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml")).unwrap();
        for (i, scene) in [open, turned, inside_out, outside, dark, sky, mixed, cornell].iter().enumerate() {
            assert_eq!(radiance(scene, None), None, "{i}");
        }
    }
}
