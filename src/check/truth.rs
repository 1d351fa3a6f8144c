//! The direct light of a place, from the description alone: Lambert's formula in f64 (Lambert 1760; Arvo, "The Irradiance
//! Jacobian for Partially Occluded Polyhedral Sources", SIGGRAPH 1994); of delta lights pbrt-v4, sections 12.1 to 12.3.

use crate::scene::SceneDesc;
use crate::scene::desc::{DeltaLight, Scattering};
use crate::scene::flatten::Geometry;
use glam::DVec3;
use std::f64::consts::PI;

/// A polygon that is smaller than this part of its distance is taken for a point: that errs by the square of it, while what the
/// formula's edges have in common cancels.
const SMALL: f64 = 1e-5;

/// Irradiance at `point`, on a plane of unit normal `normal`, from a triangle of radiance 1 that shines from its front; above
/// the plane with all its corners, or 0.
pub fn irradiance(point: DVec3, normal: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let area = 0.5 * (b - a).cross(c - a);
    let centre = (a + b + c) / 3.0;
    if area.dot(centre) >= 0.0 || [a, b, c].iter().any(|corner| corner.dot(normal) <= 0.0) {
        return 0.0;
    }
    let distance = centre.length();
    let size = a.distance(b).max(b.distance(c)).max(c.distance(a));
    if size < SMALL * distance {
        return -area.dot(centre) * centre.dot(normal) / distance.powi(4);
    }
    let edge = |p: DVec3, q: DVec3| {
        let across = p.cross(q);
        across.length().atan2(p.dot(q)) * across.normalize_or_zero().dot(normal)
    };
    0.5 * (edge(a, b) + edge(b, c) + edge(c, a)).abs()
}

/// Irradiance at `point`, on a plane of unit normal `normal`, from a delta light.
fn delta_irradiance(point: DVec3, normal: DVec3, light: &DeltaLight) -> f64 {
    let from = |position: [f64; 3]| DVec3::from(position) - point;
    let (to_light, strength) = match *light {
        DeltaLight::Directional { direction, .. } => {
            let to_light = -DVec3::from(direction).normalize();
            return light.strength()[0] * to_light.dot(normal).max(0.0);
        }
        DeltaLight::Point { position, .. } => (from(position), 1.0),
        DeltaLight::Spot { position, direction, cone_angle, cone_delta_angle, .. } => {
            let to_light = from(position);
            let cosine = DVec3::from(direction).normalize().dot(-to_light.normalize());
            let [edge, whole] = [cone_angle, cone_angle - cone_delta_angle].map(|degrees| degrees.to_radians().cos());
            let t = if edge == whole {
                f64::from(cosine > edge)
            } else {
                ((cosine - edge) / (whole - edge)).clamp(0.0, 1.0)
            };
            (to_light, t * t * (3.0 - 2.0 * t))
        }
    };
    light.strength()[0] * strength * to_light.normalize().dot(normal).max(0.0) / to_light.length_squared()
}

/// The radiance that the camera's axis meets after one scattering event where nothing stands between lamps and the diffuse
/// surface it meets; `None` if it meets none.
pub fn direct_light(scene: &SceneDesc) -> Option<f64> {
    let geometry = scene.geometry();
    let eye = DVec3::from(scene.camera.eye());
    let axis = (DVec3::from(scene.camera.look_at) - eye).normalize();
    let first = |id: usize| plane_hit(eye, axis, world(&geometry, id)).map(|t| (id, t));
    let (id, t) = (0..geometry.triangles.len()).filter_map(first).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let [a, b, c] = world(&geometry, id);
    let normal = (b - a).cross(c - a).normalize();
    let normal = if normal.dot(axis) < 0.0 { normal } else { -normal };
    let material = |id: usize| &scene.materials[geometry.triangles[id].material as usize];
    let Scattering::Diffuse { albedo } = material(id).scattering else { return None };
    let point = eye + axis * t;
    let lit: f64 = (0..geometry.triangles.len())
        .filter(|&lamp| material(lamp).emission[0] > 0.0)
        .map(|lamp| f64::from(material(lamp).emission[0] as f32) * irradiance(point, normal, world(&geometry, lamp)))
        .sum();
    let lit = lit + scene.delta_lights().map(|light| delta_irradiance(point, normal, &light.light)).sum::<f64>();
    Some(f64::from(albedo[0] as f32) / PI * lit)
}

/// The corners of a triangle, counter-clockwise seen from its front.
fn world(geometry: &Geometry<'_>, id: usize) -> [DVec3; 3] {
    let [a, b, c] = geometry.vertices(id).map(|p| DVec3::from(p.map(f64::from)));
    if geometry.triangles[id].flipped { [a, c, b] } else { [a, b, c] }
}

/// Where a ray meets a triangle (its edges count, with 2^-40 to spare).
fn plane_hit(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let normal = (b - a).cross(c - a);
    let t = normal.dot(a - origin) / normal.dot(direction);
    if !(t > 0.0 && t.is_finite()) {
        return None;
    }
    let p = origin + direction * t;
    let room = -normal.length_squared() * 2f64.powi(-40);
    let inside = |q: DVec3, r: DVec3| (r - q).cross(p - q).dot(normal) >= room;
    (inside(a, b) && inside(b, c) && inside(c, a)).then_some(t)
}

/// E (1 + a + .. + a^N).
pub fn geometric_sum(emitted: f64, albedo: f64, events: u32) -> f64 {
    let terms = f64::from(events) + 1.0;
    if albedo == 1.0 { emitted * terms } else { emitted * -(terms * albedo.ln()).exp_m1() / (1.0 - albedo) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level square of half-size 1/2 a unit straight above (Howell, configuration B-3, times 4 pi).
    #[test]
    fn squares_above_are_as_tables_say() {
        let corner = |x: f64, z: f64| DVec3::new(x, 1.0, z);
        let [a, b, c, d] = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        let from = |corners| irradiance(DVec3::ZERO, DVec3::Y, corners);
        let x: f64 = 0.5;
        let root = (1.0 + x * x).sqrt();
        assert!((from([a, b, c]) + from([a, c, d]) - 4.0 * x / root * (x / root).atan()).abs() < 1e-14);
        assert_eq!(from([c, b, a]), 0.0, "from behind");
        // Small and large formula meet.
        for size in [0.9e-5, 1.1e-5] {
            let small = from([a * size, b * size, c * size].map(|p| DVec3::new(p.x, 1.0, p.z)));
            assert!((small / (0.5 * size * size) - 1.0).abs() < 1e-5, "{small}");
        }
    }

    #[test]
    fn sums_are_geometric() {
        assert_eq!(geometric_sum(2.0, 1.0, 9), 20.0);
        assert!((geometric_sum(1.0, 0.5, 2) - 1.75).abs() < 1e-15);
        assert!((geometric_sum(1.0, 0.0, 7) - 1.0).abs() < 1e-15);
    }
}
