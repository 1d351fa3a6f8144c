//! The delta lights: lights of no size, which only light samples find (pbrt-v4, sections 12.1 to 12.3).
//!
//! One row serves all kinds. A point light is a spot light whose cone is everywhere; a directional light has a direction in the
//! place of its position, and its strength does not fall with the distance.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::scene::desc::{DeltaLight, SceneDesc};
use crate::scene::flatten::Geometry;
use crate::scene::transform::versine;

/// One delta light as light sampling sees it: one cache line.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct DeltaRecord {
    /// Where it is, scene units; of a directional light the unit direction towards it.
    pub position: [f32; 3],
    /// 1 of a directional light, else 0.
    pub distant: u32,
    /// Radiant intensity along the axis (W sr^-1), of a directional light irradiance (W m^-2), in
    /// [`crate::tables::PreparedScene::radiance_unit`].
    pub strength: [f32; 3],
    /// Angles are counted as versines, 1 - cos, which tell small ones apart in f32: that of the cone's edge. Where there is no
    /// cone, so much that no direction comes near it.
    pub edge: f32,
    /// Unit axis of the cone, away from the light; 0 where there is no cone.
    pub axis: [f32; 3],
    /// One over the versines between the edge and where the light is whole.
    pub falloff: f32,
    /// To the length of a cache line.
    spare: [u32; 4],
}

/// Where there is no cone: every direction's versine, 2 at most, is this much and more inside it.
const NO_EDGE: f32 = 4.0;

/// The least part of a cone that light fades over: what is written as a sharp edge.
const LEAST_FADE: f64 = 1e-6;

/// A cone of so many degrees has no side that is dark, for the light tree: a little less than a quarter turn.
const MOST_ONE_SIDED: f64 = 89.9;

/// How many radii of the scene the light tree takes a directional light to be away. Over the scene its directions then differ by
/// 2 degrees and its distances by 3 %, which choosing does not notice.
const DISTANCE: f64 = 32.0;

/// A ball about all triangles of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ball {
    /// Its centre, scene units.
    pub center: DVec3,
    /// Its radius.
    pub radius: f64,
}

impl Ball {
    /// That about the box of all triangles; of radius 0 where there are none.
    fn about(geometry: &Geometry<'_>) -> Ball {
        let Some((low, high)) = geometry.bounds() else { return Ball::default() };
        Ball { center: 0.5 * (low + high), radius: 0.5 * (high - low).length() }
    }
}

/// How the light tree sees a light.
pub struct Bounds {
    /// The lower corner of a box that holds the light.
    pub low: DVec3,
    /// The upper corner.
    pub high: DVec3,
    /// Where it shines within a quarter turn of one direction, that; else zero.
    pub normal: DVec3,
    /// What, over the squared distance and times both cosines, is the irradiance it may bring; see [`super::tree`].
    pub power: f64,
}

/// The delta lights of a scene.
#[derive(Clone, Debug, Default)]
pub struct DeltaLights {
    /// Per light.
    pub records: Vec<DeltaRecord>,
    lights: Vec<DeltaLight>,
    ball: Ball,
}

impl DeltaLights {
    /// Those of `desc` that shine at all, their strengths in `unit`.
    pub fn new(desc: &SceneDesc, geometry: &Geometry<'_>, unit: f64) -> DeltaLights {
        let shines = |light: &DeltaLight| light.strength().iter().any(|&c| (c / unit) as f32 > 0.0);
        let lights: Vec<DeltaLight> = desc.delta_lights().map(|desc| desc.light).filter(shines).collect();
        let records = lights.iter().map(|light| record(light, unit)).collect();
        let ball = if lights.is_empty() { Ball::default() } else { Ball::about(geometry) };
        DeltaLights { records, lights, ball }
    }

    /// What the scene says of them, in the order of the records.
    pub fn lights(&self) -> &[DeltaLight] {
        &self.lights
    }

    /// Their flux over pi, up to the factor that the powers of emitters have too; of a directional light that through the ball
    /// about the scene.
    pub fn powers(&self) -> impl Iterator<Item = f64> {
        self.lights.iter().zip(&self.records).map(|(light, record)| {
            let spread = match *light {
                DeltaLight::Point { .. } => 4.0,
                // The smooth step has the area of a straight one.
                DeltaLight::Spot { cone_angle, cone_delta_angle, .. } => {
                    versine(cone_angle) + versine(cone_angle - cone_delta_angle)
                }
                DeltaLight::Directional { .. } => self.ball.radius * self.ball.radius,
            };
            spread * total(record)
        })
    }

    /// How the light tree sees them.
    pub fn bounds(&self) -> impl Iterator<Item = Bounds> {
        self.lights.iter().zip(&self.records).map(|(light, record)| {
            let strength = total(record);
            let at = DVec3::from(record.position.map(f64::from));
            match light {
                DeltaLight::Spot { cone_angle, .. } if *cone_angle <= MOST_ONE_SIDED => {
                    Bounds { low: at, high: at, normal: DVec3::from(record.axis.map(f64::from)), power: strength }
                }
                // All around, the tree takes the mean cosine, 1/4.
                DeltaLight::Point { .. } | DeltaLight::Spot { .. } => {
                    Bounds { low: at, high: at, normal: DVec3::ZERO, power: 4.0 * strength }
                }
                // Whatever is above a surface's horizon in the light's direction is, for some point of this box.
                DeltaLight::Directional { .. } => {
                    let radius = self.ball.radius.max(f64::from(f32::MIN_POSITIVE));
                    let (center, half) = (self.ball.center + at * (DISTANCE * radius), DVec3::splat(1.001 * radius));
                    let power = strength * (DISTANCE * radius) * (DISTANCE * radius);
                    Bounds { low: center - half, high: center + half, normal: -at, power }
                }
            }
        })
    }

    /// The largest coordinate, from the origin, of what is near the lights and the scene.
    pub fn reach(&self) -> f64 {
        let near = self.records.iter().filter(|record| record.distant == 0);
        let lights = near.flat_map(|record| record.position).fold(0.0, |most: f64, x| most.max(f64::from(x).abs()));
        if self.records.is_empty() { 0.0 } else { lights.max(self.ball.center.abs().max_element() + self.ball.radius) }
    }
}

/// A light's strength, summed over the channels.
fn total(record: &DeltaRecord) -> f64 {
    record.strength.iter().map(|&c| f64::from(c)).sum()
}

fn record(light: &DeltaLight, unit: f64) -> DeltaRecord {
    let strength = light.strength().map(|c| (c / unit) as f32);
    let unit_vector = |v: [f64; 3]| DVec3::from(v).normalize();
    let everywhere = DeltaRecord { strength, edge: NO_EDGE, falloff: 1.0, ..DeltaRecord::zeroed() };
    match *light {
        DeltaLight::Point { position, .. } => DeltaRecord { position: position.map(|x| x as f32), ..everywhere },
        DeltaLight::Directional { direction, .. } => {
            DeltaRecord { position: (-unit_vector(direction)).as_vec3().to_array(), distant: 1, ..everywhere }
        }
        DeltaLight::Spot { position, direction, cone_angle, cone_delta_angle, .. } => {
            let edge = versine(cone_angle);
            let fade = (edge - versine(cone_angle - cone_delta_angle)).max(LEAST_FADE * edge);
            DeltaRecord {
                position: position.map(|x| x as f32),
                edge: edge as f32,
                axis: unit_vector(direction).as_vec3().to_array(),
                falloff: (1.0 / fade) as f32,
                ..everywhere
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::desc::{DeltaLightDesc, LightDesc, TriangleDesc};

    fn lights(lights: impl IntoIterator<Item = DeltaLight>) -> DeltaLights {
        let corner = |x: f32| [x, 0.0, 0.0];
        let triangle = TriangleDesc { vertices: [0, 1, 1], material: 0, flipped: false };
        let positions = vec![corner(-1.0), corner(3.0)].into();
        let geometry = Geometry { positions, triangles: vec![triangle].into(), ..Geometry::default() };
        let named = |light| LightDesc::Delta(DeltaLightDesc { name: String::new(), light });
        let lights = lights.into_iter().map(named).collect();
        DeltaLights::new(&SceneDesc { lights, ..SceneDesc::default() }, &geometry, 1.0)
    }

    #[test]
    fn powers_are_fluxes_over_pi() {
        let (position, direction, intensity) = ([0.0; 3], [0.0, -2.0, 0.0], [1.0, 2.0, 0.0]);
        let spot = |cone_angle, cone_delta_angle| DeltaLight::Spot {
            position,
            direction,
            intensity,
            cone_angle,
            cone_delta_angle,
        };
        let all = lights([
            DeltaLight::Point { position, intensity },
            spot(180.0, 0.0),
            spot(90.0, 0.0),
            spot(60.0, 30.0),
            DeltaLight::Directional { direction, irradiance: intensity },
            DeltaLight::Point { position, intensity: [0.0; 3] },
        ]);
        let mut powers = all.powers();
        let mut next = || powers.next().unwrap();
        assert_eq!([next(), next()], [12.0, 12.0]);
        assert!((next() - 6.0).abs() < 1e-12, "half of all directions");
        // The integral of the falloff over the cone, by the midpoint rule in f64.
        let (edge, start) = (60f64.to_radians().cos(), 30f64.to_radians().cos());
        let steps = 100_000;
        let integral: f64 = (0..steps)
            .map(|i| {
                let cosine = 1.0 - (i as f64 + 0.5) / steps as f64;
                let t = ((cosine - edge) / (start - edge)).clamp(0.0, 1.0);
                t * t * (3.0 - 2.0 * t) / steps as f64
            })
            .sum();
        assert!((next() - 2.0 * integral * 3.0).abs() < 1e-4, "{integral}");
        assert_eq!(next(), 3.0 * 4.0, "through the ball of radius 2");
        assert_eq!(powers.next(), None, "a light of no strength is none");
    }

    #[test]
    fn small_cones_keep_their_edges_in_f32() {
        for cone_angle in [0.01, 1.0, 30.0, 90.0, 180.0] {
            let direction = [1.0, 2.0, -3.0];
            let (position, intensity, cone_delta_angle) = ([1.0, 0.0, 0.0], [1.0; 3], 0.5 * cone_angle);
            let spot = DeltaLight::Spot { position, direction, intensity, cone_angle, cone_delta_angle };
            let record = lights([spot]).records[0];
            let degrees = 2.0 * (0.5 * f64::from(record.edge)).sqrt().min(1.0).asin().to_degrees();
            assert!((degrees / cone_angle - 1.0).abs() < 1e-3, "{cone_angle}: {degrees}");
        }
    }
}
