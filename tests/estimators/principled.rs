//! The metallic-roughness model against what it is made of, against glTF's own formulas, and against energy: everything in
//! f64, by formulas written here.

use crate::plastic::reflected;
use octray::internal::reference::double::{Vec3, bsdf};
use octray::internal::tables::materials::MaterialRecord;
use octray::scene::desc::{MaterialDesc, Scattering};
use std::f64::consts::PI;

const COLOR: [f64; 3] = [0.75, 0.5, 0.125];

fn record(scattering: Scattering) -> MaterialRecord {
    MaterialRecord::new(&MaterialDesc { scattering, ..MaterialDesc::default() })
}

fn principled(base_color: [f64; 3], metallic: f64, roughness: f64, ior: f64) -> MaterialRecord {
    record(Scattering::Principled { base_color, metallic, roughness, ior })
}

/// Pairs of directions above the surface, from steep to flat.
fn directions() -> impl Iterator<Item = (Vec3, Vec3)> {
    let direction = |cosine: f64, turn: f64| {
        let sine = (1.0 - cosine * cosine).sqrt();
        Vec3::new(sine * (turn * PI).cos(), sine * (turn * PI).sin(), cosine)
    };
    let cosines = [1.0, 0.9, 0.6, 0.3, 0.1, 0.02];
    let pairs = cosines.into_iter().flat_map(move |o| cosines.map(|i| (o, i)));
    pairs.flat_map(move |(o, i)| [0.0, 0.4, 0.9, 1.0].map(|turn| (direction(o, 0.0), direction(i, turn))))
}

/// BSDFs (times cosine) are the same but for rounded numbers in their records.
fn assert_close(got: Vec3, wanted: Vec3, what: &str) {
    let scale = wanted.abs().max_element();
    assert!((got - wanted).abs().max_element() <= 1e-6 * scale, "{what}: {got} for {wanted}");
}

#[test]
fn without_metal_it_is_plastic() {
    for (roughness, ior) in [(0.0, 1.5), (0.2, 1.1), (0.6, 1.5), (1.0, 2.5)] {
        let mixed = principled(COLOR, 0.0, roughness, ior);
        let plastic = record(Scattering::Plastic { albedo: COLOR, ior, alpha: roughness * roughness });
        for (wo, wi) in directions() {
            let (got, pdf) = bsdf::principled::evaluate(&mixed, wo, wi);
            let (wanted, wanted_pdf) = bsdf::plastic::evaluate(&plastic, wo, wi);
            assert_close(got, wanted, &format!("roughness {roughness}, index {ior}, {wo} {wi}"));
            assert!((pdf - wanted_pdf).abs() <= 1e-6 * wanted_pdf, "{pdf} for {wanted_pdf}");
        }
    }
}

/// White metal is white from everywhere; any metal has its colour where light falls straight on a facet.
#[test]
fn metal_is_a_conductor_at_normal_incidence_and_white_at_grazing() {
    for roughness in [0.0f64, 0.2, 0.6, 1.0] {
        let conductor = |reflectance| {
            record(Scattering::Conductor { alpha: (roughness * roughness).max(1e-4), reflectance, complex_ior: None })
        };
        let (white, mirrors) = (principled([1.0; 3], 1.0, roughness, 1.5), conductor([1.0; 3]));
        let (metal, colored) = (principled(COLOR, 1.0, roughness, 1.5), conductor(COLOR));
        for (wo, wi) in directions() {
            let got = bsdf::principled::evaluate(&white, wo, wi);
            assert_eq!(got, bsdf::conductor::evaluate(&mirrors, wo, wi), "white, roughness {roughness}, {wo} {wi}");
            // Light from where it is seen falls straight on the facets that send it back.
            let straight = bsdf::principled::evaluate(&metal, wo, wo).0;
            assert_close(straight, bsdf::conductor::evaluate(&colored, wo, wo).0, "towards the viewer");
        }
        let flat = 1e-4f64;
        let (wo, wi) = (Vec3::new(1.0, 0.0, flat).normalize(), Vec3::new(-1.0, 0.0, flat).normalize());
        let ratio = bsdf::principled::evaluate(&metal, wo, wi).0 / bsdf::principled::evaluate(&white, wo, wi).0;
        assert!((ratio - Vec3::ONE).abs().max_element() < 1e-3, "grazing: {ratio}");
    }
}

/// glTF 2.0, appendix B.3: D and G as they are written there, with the two maskings independent of each other.
fn appendix_specular(alpha: f64, n_o: f64, n_i: f64, n_h: f64) -> f64 {
    let alpha2 = alpha * alpha;
    let d = alpha2 / (PI * (n_h * n_h * (alpha2 - 1.0) + 1.0).powi(2));
    let g = |n: f64| 2.0 * n / (n + (alpha2 + (1.0 - alpha2) * n * n).sqrt());
    g(n_o) * g(n_i) * d / (4.0 * n_o * n_i)
}

/// By how much facets that are masked by their height reflect more than the appendix's, G2 / (G1 G1): from the maskings'
/// lambdas (Heitz 2014, equations 72 and 99).
fn masking_ratio(alpha: f64, n_o: f64, n_i: f64) -> f64 {
    let lambda = |n: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 - n * n) / (n * n)).sqrt() - 1.0);
    (1.0 + lambda(n_o)) * (1.0 + lambda(n_i)) / (1.0 + lambda(n_o) + lambda(n_i))
}

#[test]
fn metal_is_as_appendix_b_has_it_but_for_masking_by_height() {
    for (roughness, alpha) in [(0.2, 0.04), (0.5, 0.25), (1.0, 1.0)] {
        let metal = principled(COLOR, 1.0, roughness, 1.5);
        for (wo, wi) in directions() {
            let half = (wo + wi).normalize();
            let schlick = (1.0 - wo.dot(half).min(1.0)).powi(5);
            let color = Vec3::from(COLOR) + (1.0 - Vec3::from(COLOR)) * schlick;
            let wanted = color * appendix_specular(alpha, wo.z, wi.z, half.z) * masking_ratio(alpha, wo.z, wi.z) * wi.z;
            assert_close(
                bsdf::principled::evaluate(&metal, wo, wi).0,
                wanted,
                &format!("roughness {roughness}, {wo} {wi}"),
            );
        }
    }
}

#[test]
fn a_mixture_is_the_mean_of_metal_and_plastic() {
    for (metallic, roughness, ior) in [(0.25, 0.3, 1.5), (0.5, 0.6, 1.0), (0.875, 1.0, 2.0)] {
        let [mixed, plastic, metal] = [metallic, 0.0, 1.0].map(|metallic| principled(COLOR, metallic, roughness, ior));
        for (wo, wi) in directions() {
            let of = |material| bsdf::principled::evaluate(material, wo, wi).0;
            let wanted = of(&plastic) * (1.0 - metallic) + of(&metal) * metallic;
            assert_close(of(&mixed), wanted, &format!("metallic {metallic}, {wo} {wi}"));
        }
    }
}

/// A white one reflects what its coat and base, and its facets, reflect: never more than arrives. The dielectric of appendix B
/// does: its base takes no notice of how flat light comes and goes.
#[test]
fn no_mixture_reflects_more_than_arrives_as_the_appendix_would() {
    let mut most_of_appendix = 0.0f64;
    for roughness in [0.1, 0.3, 0.6, 1.0] {
        let alpha = roughness * roughness;
        for cosine in [1.0, 0.6, 0.3, 0.1, 0.03] {
            for (metallic, ior) in [(0.0, 1.0), (0.0, 1.5), (0.3, 1.5), (0.7, 5.0), (1.0, 20.0)] {
                let material = principled([1.0; 3], metallic, roughness, ior);
                let whole = reflected(cosine, alpha, |wo, wi| bsdf::principled::evaluate(&material, wo, wi).0.x);
                let what = format!("metallic {metallic}, roughness {roughness}, index {ior}, cosine {cosine}");
                assert!(whole <= 1.0 + 1e-6, "{what}: {whole}");
                // From straight above little of the coat is hidden.
                assert!(metallic > 0.0 || cosine < 1.0 || whole > 0.95, "{what}: only {whole}");
            }
            let appendix = reflected(cosine, alpha, |wo, wi| {
                // Between directions along the surface the formulas end in 0 / 0.
                if wi.z < 1e-9 {
                    return 0.0;
                }
                let half = (wo + wi).normalize();
                let fresnel = 0.04 + 0.96 * (1.0 - wo.dot(half).min(1.0)).powi(5);
                let specular = appendix_specular(alpha, wo.z, wi.z, half.z);
                (specular * fresnel + (1.0 - fresnel) / PI) * wi.z
            });
            println!("roughness {roughness}, cosine {cosine}: by the appendix {appendix:.3}");
            most_of_appendix = most_of_appendix.max(appendix);
        }
    }
    assert!(most_of_appendix > 1.5, "the appendix's white dielectric reflects at most {most_of_appendix}");
}
