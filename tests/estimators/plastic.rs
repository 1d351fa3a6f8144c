//! Plastics never reflect more than arrives, from any direction, at any index and roughness: integrals of the BSDF as the
//! engines evaluate it, over directions of light. (While loading, the factor on the albedo is found from means over visible
//! normals, without ever evaluating the BSDF.)

use octray::internal::reference::{double, single};
use octray::internal::tables::materials::MaterialRecord;
use octray::scene::desc::{MaterialDesc, Scattering};
use std::f64::consts::{FRAC_PI_2, PI};

const IORS: [f64; 8] = [1.0 + 1e-6, 1.001, 1.1, 1.5, 2.5, 5.0, 10.0, 20.0];
const ALPHAS: [f64; 7] = [1e-4, 1e-3, 0.01, 0.05, 0.1, 0.3, 1.0];

fn white(ior: f64, alpha: f64) -> MaterialRecord {
    let scattering = Scattering::Plastic { albedo: [1.0; 3], ior, alpha };
    MaterialRecord::new(&MaterialDesc { scattering, ..MaterialDesc::default() })
}

/// Nodes and weights of the Gauss-Legendre rule of eight nodes over [-1, 1].
const RULE: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Nodes and weights over pieces that grow by the factor four from `least` about every one of `centers`, within `low` .. `high`.
fn graded(low: f64, high: f64, centers: &[f64], least: f64) -> Vec<(f64, f64)> {
    let mut edges = vec![low, high];
    for &center in centers {
        edges.push(center);
        let mut step = least;
        while step < high - low {
            edges.extend([center - step, center + step]);
            step *= 4.0;
        }
    }
    edges.retain(|edge| (low..=high).contains(edge));
    edges.sort_by(f64::total_cmp);
    let piece = |ends: &[f64]| {
        let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        RULE.map(|(x, w)| [(middle - half * x, half * w), (middle + half * x, half * w)]).into_iter().flatten()
    };
    edges.windows(2).flat_map(piece).collect()
}

/// What `evaluate` (BSDF times cosine) reflects of light from a direction with this cosine, in all.
pub fn reflected(cosine: f64, alpha: f64, evaluate: impl Fn(glam::DVec3, glam::DVec3) -> f64) -> f64 {
    let polar = cosine.acos();
    let wo = glam::DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    // Elevations are dense about the mirrored direction and towards the horizon, azimuths about the mirrored one: forwards.
    let elevations = graded(0.0, FRAC_PI_2, &[FRAC_PI_2 - polar, 0.0], 0.5 * alpha);
    // (A normal that leans aside by alpha turns a flat direction by far less.)
    let azimuths = graded(0.0, PI, &[0.0], (0.5 * alpha * cosine / polar.sin().max(1e-3)).min(1.0));
    let mut sum = 0.0;
    for &(elevation, width) in &elevations {
        let (z, radius) = elevation.sin_cos();
        for &(azimuth, breadth) in &azimuths {
            let (sin, cos) = azimuth.sin_cos();
            let wi = glam::DVec3::new(-radius * cos, radius * sin, z);
            sum += evaluate(wo, wi) * width * breadth * radius;
        }
    }
    2.0 * sum
}

#[test]
fn plastics_reflect_no_more_than_arrives_and_hardly_less_than_they_may() {
    // Most of them where indices of 10 and 20 have their deepest minimum.
    let cosines = [1.0, 0.8, 0.6, 0.4, 0.25, 0.15, 0.11, 0.0955, 0.083, 0.072, 0.055, 0.042, 0.036, 0.0316, 0.01, 1e-3];
    for ior in IORS {
        let smooth = white(ior, 1e-4);
        for alpha in ALPHAS {
            let material = white(ior, alpha);
            let (mut most, mut most_single) = (0.0f64, 0.0f64);
            for cosine in cosines {
                let wide = reflected(cosine, alpha, |wo, wi| double::bsdf::plastic::evaluate(&material, wo, wi).0.x);
                assert!(wide <= 1.0 + 1e-6, "index {ior}, alpha {alpha}, cosine {cosine}: {wide}");
                most = most.max(wide);
                // In f32 a half vector is 3e-8 / cosine off, by chance: what is left of that in the mean over the nodes of a
                // lobe alpha wide. Where a lobe is hardly wider than that, only drawn directions tell (densities cancel).
                if alpha * cosine < 1e-5 {
                    continue;
                }
                let narrow = reflected(cosine, alpha, |wo, wi| {
                    single::bsdf::plastic::evaluate(&material, wo.as_vec3(), wi.as_vec3()).0.x.into()
                });
                let rounding = 2e-6 + 5e-9 / (alpha * cosine);
                assert!(narrow <= 1.0 + rounding, "index {ior}, alpha {alpha}, cosine {cosine}, in f32: {narrow}");
                most_single = most_single.max(narrow);
            }
            println!("index {ior}, alpha {alpha}: at most {most:.6}, in f32 {most_single:.6}");
            // Where no direction comes back whole, the base is as bright as under a smooth coat: the coat loses the rest.
            let lowered = material.color[0] < 0.999 * smooth.color[0];
            assert!(most > 0.998 || !lowered, "index {ior}, alpha {alpha}: at most {most}");
        }
    }
}
