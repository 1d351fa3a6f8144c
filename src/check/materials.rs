//! Materials: narrow and wide lobes, extreme indices, energy.

use crate::check::item::{Check, Effort};
use crate::check::numbers::{Numbers, worse};
use crate::check::row::Outcome;
use crate::check::trial::{Estimate, SIGMAS, Trial, Worst, small};
use crate::error::Result;
use crate::reference::double::bsdf::microfacet as exact;
use crate::reference::single::bsdf::{evaluate, microfacet, sample};
use crate::scene::desc::{MaterialDesc, Scattering};
use crate::settings::Settings;
use crate::strategy::Strategy;
use crate::tables::materials::MaterialRecord;
use glam::{DVec3, Vec3};

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "materials", what: "conductor_energy", run: conductor_energy },
    Check { group: "materials", what: "plastic_energy", run: plastic_energy },
    Check { group: "materials", what: "plastic_samples", run: plastic_samples },
    Check { group: "materials", what: "principled_samples", run: principled_samples },
    Check { group: "materials", what: "samples_and_densities", run: samples_and_densities },
    Check { group: "materials", what: "grazing_is_finite", run: grazing_is_finite },
    Check { group: "materials", what: "fresnel_range", run: fresnel_range },
    Check { group: "materials", what: "glass_of_index_one", run: glass_of_index_one },
    Check { group: "materials", what: "glass_in_and_out", run: glass_in_and_out },
    Check { group: "materials", what: "albedo_zero_and_one", run: albedo_zero_and_one },
    Check { group: "materials", what: "plates_under_a_sky", run: plates_under_a_sky },
];

/// The record of a material that scatters so.
fn record(scattering: Scattering) -> MaterialRecord {
    MaterialRecord::new(&MaterialDesc { scattering, ..MaterialDesc::default() })
}

/// A direction with this cosine, towards +x.
fn at(cosine: f64) -> DVec3 {
    DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine)
}

/// A GGX width from 1e-4 to 1 and a cosine from 1e-5 to 1.
fn width_and_cosine(numbers: &mut Numbers) -> (f64, f64) {
    (numbers.magnitude(-4.0, 0.0), numbers.magnitude(-5.0, 0.0))
}

/// A metal that reflects everything gives back at most what arrives: no sample weighs more than 1.
fn conductor_energy(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(500_000);
    let mut numbers = Numbers::new(1);
    let (mut worst, mut note) = (0.0, String::new());
    for _ in 0..cases {
        let (alpha, cosine) = width_and_cosine(&mut numbers);
        let material = record(Scattering::Conductor { alpha, reflectance: [1.0; 3], complex_ior: None });
        let u = [numbers.unit(), numbers.unit()];
        if let Some(drawn) = sample(&material, Vec3::Z, -at(cosine).as_vec3(), true, u, 0.0)
            && worse(f64::from(drawn.weight.x), worst)
        {
            worst = f64::from(drawn.weight.x);
            note = format!("alpha {alpha:.2e}, cosine {cosine:.2e}");
        }
    }
    Ok(Outcome::at_most(worst - 1.0, 4e-7)
        .tried(cases, "samples of white metals, alpha 1e-4 to 1, to grazing, largest weight less 1")
        .note(note))
}

/// What facets of width `alpha` reflect of light from a direction with this cosine, by quadrature in f64 over `steps` x `steps`
/// points of their visible normals. `fresnel`: what each reflects at a cosine.
fn facets_albedo(alpha: f64, cosine: f64, steps: u32, fresnel: impl Fn(f64) -> f64) -> f64 {
    let wo = at(cosine);
    let o = exact::smith_a(alpha, wo) / wo.z;
    let mut sum = 0.0;
    for u in points(steps) {
        for j in 0..steps {
            let normal = exact::sample_visible_normal(alpha, wo, [u, (f64::from(j) + 0.25) / f64::from(steps)]);
            let wi = exact::reflect_about(wo, normal);
            if wi.z > 0.0 {
                let i = exact::smith_a(alpha, wi) / wi.z;
                sum += fresnel(wo.dot(normal)) * (1.0 + o) / (o + i);
            }
        }
    }
    sum / (2.0 * f64::from(steps) * f64::from(steps))
}

/// Gauss's points of two a cell: other ones than the midpoints by which the scale of bases was found.
fn points(steps: u32) -> impl Iterator<Item = f64> {
    let pair = move |i| [-1.0, 1.0].map(|side: f64| (f64::from(i) + 0.5 + side / 12f64.sqrt()) / f64::from(steps));
    (0..steps).flat_map(pair)
}

/// What a plastic of index `ior` and width `alpha` with a white base reflects of light from a direction with this cosine, by
/// quadrature in f64: the coat over its visible normals, the base over its cosines. The scale of the base is the renderer's
/// own.
fn plastic_albedo(ior: f64, alpha: f64, base: f64, cosine: f64, steps: u32) -> f64 {
    let fresnel = |cosine: f64| exact::fresnel_dielectric(cosine, ior).0;
    let through: f64 = points(steps).map(|u| (1.0 - fresnel(u)) * 2.0 * u).sum();
    let coat = facets_albedo(alpha, cosine, steps, fresnel);
    coat + base * (1.0 - fresnel(cosine)) * through / (2.0 * f64::from(steps))
}

fn white_plastic(ior: f64, alpha: f64) -> MaterialRecord {
    record(Scattering::Plastic { albedo: [1.0; 3], ior, alpha })
}

/// No plastic gives back more than arrives.
fn plastic_energy(effort: &Effort) -> Result<Outcome> {
    let steps = effort.samples(128, 128).min(400);
    let (mut worst, mut note, mut cases) = (0.0, String::new(), 0);
    for ior in [1.01, 1.1, 1.5, 2.5, 5.0, 10.0, 20.0] {
        for alpha in [1e-4, 0.01, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0] {
            let base = f64::from(white_plastic(ior, alpha).color[0]);
            for degrees in [0.0f64, 30.0, 50.0, 65.0, 75.0, 80.0, 85.0, 88.0, 89.5, 89.99] {
                let albedo = plastic_albedo(ior, alpha, base, degrees.to_radians().cos(), steps);
                cases += u64::from(steps) * u64::from(steps) * 2;
                if worse(albedo, worst) {
                    worst = albedo;
                    note = format!("index {ior}, alpha {alpha}, {degrees} degrees");
                }
            }
        }
    }
    Ok(Outcome::at_most(worst - 1.0, 0.0)
        .tried(
            cases,
            "points of quadratures over index 1.01 to 20, alpha, angle, largest albedo of white plastics less 1",
        )
        .note(note))
}

/// The mean weight of a plastic's samples is the albedo that quadrature finds.
fn plastic_samples(effort: &Effort) -> Result<Outcome> {
    let count = effort.cases(40_000);
    let mut numbers = Numbers::new(2);
    let (mut worst, mut note, mut cases) = (0.0, String::new(), 0);
    for (ior, alpha) in [(1.01, 0.5), (1.5, 0.1), (1.5, 1.0), (2.5, 0.3), (10.0, 0.3), (20.0, 0.05)] {
        let material = white_plastic(ior, alpha);
        for degrees in [0.0f64, 45.0, 75.0, 85.0] {
            let cosine = degrees.to_radians().cos();
            let truth = plastic_albedo(ior, alpha, f64::from(material.color[0]), cosine, 100);
            let estimate = mean_weight(&material, cosine, count, &mut numbers);
            cases += count;
            let sigmas = estimate.sigmas(truth, 1e-3);
            if worse(sigmas, worst) {
                worst = sigmas;
                note = format!("index {ior}, alpha {alpha}, {degrees} degrees: {:.5} for {truth:.5}", estimate.mean);
            }
        }
    }
    Ok(Outcome::at_most(worst, SIGMAS)
        .tried(cases, "samples of white plastics, mean weight against quadrature, in standard errors")
        .note(note))
}

/// The mean weight of `count` samples seen at this cosine.
fn mean_weight(material: &MaterialRecord, cosine: f64, count: u64, numbers: &mut Numbers) -> Estimate {
    let incoming = -at(cosine).as_vec3();
    let mut weight = |_| {
        let u = [numbers.unit(), numbers.unit()];
        let drawn = sample(material, Vec3::Z, incoming, true, u, numbers.unit());
        drawn.map_or(0.0, |drawn| f64::from(drawn.weight.x))
    };
    Estimate::of_values(&(0..count).map(&mut weight).collect::<Vec<f64>>())
}

/// The mean weight of a principled material's samples is the mean, by `metallic`, of the albedos of a plastic and a metal.
fn principled_samples(effort: &Effort) -> Result<Outcome> {
    let count = effort.cases(40_000);
    let mut numbers = Numbers::new(8);
    let (mut worst, mut note, mut cases) = (0.0, String::new(), 0);
    for (color, metallic, roughness, ior) in
        [(0.8, 0.0, 0.3, 1.5), (1.0, 0.4, 0.7, 1.5), (0.2, 0.7, 1.0, 2.5), (0.0, 0.5, 0.5, 1.0), (0.6, 1.0, 0.4, 1.5)]
    {
        let alpha = f64::from((roughness * roughness) as f32);
        let material = record(Scattering::Principled { base_color: [color; 3], metallic, roughness, ior });
        let base = color * f64::from(white_plastic(ior, alpha).color[0]);
        for degrees in [0.0f64, 45.0, 75.0, 85.0] {
            let cosine = degrees.to_radians().cos();
            let schlick = |cosine: f64| color + (1.0 - color) * (1.0 - cosine).powi(5);
            let metal = facets_albedo(alpha, cosine, 100, schlick);
            let truth = metallic * metal + (1.0 - metallic) * plastic_albedo(ior, alpha, base, cosine, 100);
            let estimate = mean_weight(&material, cosine, count, &mut numbers);
            cases += count;
            let sigmas = estimate.sigmas(truth, 1e-3);
            if worse(sigmas, worst) {
                worst = sigmas;
                note = format!(
                    "metallic {metallic}, roughness {roughness}, {degrees} degrees: {:.5} for {truth:.5}",
                    estimate.mean
                );
            }
        }
    }
    Ok(Outcome::at_most(worst, SIGMAS)
        .tried(cases, "samples of principled materials, mean weight against quadrature, in standard errors")
        .note(note))
}

/// Widths that a check goes through: a coat's energy takes a while to work out.
const ALPHAS: u32 = 16;

/// A sample's density and its weight are those that evaluating the same direction gives: what the two techniques of multiple
/// importance sampling must agree on. Widths from 0.01 on: narrower lobes are f32 directions wide.
fn samples_and_densities(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(300_000);
    let mut numbers = Numbers::new(3);
    let (mut worst, mut note) = (0.0, String::new());
    for step in 0..ALPHAS {
        let alpha = 10f64.powf(-2.0 * f64::from(step) / f64::from(ALPHAS - 1));
        let materials = [
            record(Scattering::Diffuse { albedo: [0.7; 3] }),
            record(Scattering::Conductor { alpha, reflectance: [0.9; 3], complex_ior: None }),
            record(Scattering::Plastic { albedo: [0.5; 3], ior: 1.5, alpha }),
            record(Scattering::Principled { base_color: [0.7; 3], metallic: 0.5, roughness: alpha.sqrt(), ior: 1.5 }),
        ];
        for _ in 0..cases / u64::from(ALPHAS) {
            let material = &materials[numbers.below(4) as usize];
            let n = numbers.direction().as_vec3();
            let n = n * (1.0 / n.length());
            let incoming = numbers.direction().as_vec3();
            let incoming = if incoming.dot(n) < 0.0 { incoming } else { -incoming };
            if -incoming.dot(n) < 0.01 {
                continue;
            }
            let u = [numbers.unit(), numbers.unit()];
            let Some(drawn) = sample(material, n, incoming, true, u, numbers.unit()) else { continue };
            if drawn.cosine < 0.01 {
                continue;
            }
            let (f_cosine, pdf_dir) = evaluate(material, n, incoming, drawn.direction);
            let density = f64::from(drawn.pdf_dir) / f64::from(pdf_dir) - 1.0;
            let weight = f64::from(drawn.weight.x) * f64::from(pdf_dir) / f64::from(f_cosine.x) - 1.0;
            let error = if density.abs() >= weight.abs() || density.is_nan() { density.abs() } else { weight.abs() };
            if worse(error, worst) {
                worst = error;
                note = format!("{}, alpha {alpha:.3}", material.kind().name());
            }
        }
    }
    Ok(Outcome::at_most(worst, 2e-3)
        .tried(cases, "samples against evaluations of their directions, relative error of density and weight")
        .note(note))
}

/// Weights and densities at grazing angles are finite and not negative, for all kinds.
fn grazing_is_finite(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(300_000);
    let mut numbers = Numbers::new(4);
    let (mut wrong, mut note) = (0, String::new());
    for step in 0..ALPHAS {
        let alpha = 10f64.powf(-4.0 * f64::from(step) / f64::from(ALPHAS - 1));
        let ior = [1.01, 1.5, 2.5, 20.0][step as usize % 4];
        let metal = Some(([0.2, 1.0, 900.0], [3.0, 0.0, 900.0]));
        let materials = [
            record(Scattering::Diffuse { albedo: [1.0; 3] }),
            record(Scattering::Conductor { alpha, reflectance: [1.0; 3], complex_ior: metal }),
            record(Scattering::Dielectric { ior, transmittance: [1.0; 3] }),
            record(Scattering::Plastic { albedo: [1.0; 3], ior, alpha }),
            record(Scattering::Principled { base_color: [0.0, 0.5, 1.0], metallic: 0.5, roughness: alpha.sqrt(), ior }),
            record(Scattering::Principled { base_color: [0.0; 3], metallic: 1.0, roughness: alpha.sqrt(), ior }),
        ];
        for _ in 0..cases / u64::from(ALPHAS) {
            let material = &materials[numbers.below(6) as usize];
            let cosine = numbers.magnitude(-8.0, 0.0);
            let incoming = -at(cosine).as_vec3();
            let u = [numbers.unit(), numbers.unit()];
            let front = numbers.below(2) == 0;
            let fits = |x: f32| x.is_finite() && x >= 0.0;
            // Reflectances that are 0 round to either side of it: a conductor of index 1 that absorbs nothing.
            let colour = |v: Vec3| v.is_finite() && v.min_element() >= -1e-6 * v.max_element();
            if let Some(drawn) = sample(material, Vec3::Z, incoming, front, u, numbers.unit()) {
                let right = colour(drawn.weight)
                    && fits(drawn.pdf_dir)
                    && drawn.direction.is_finite()
                    && (drawn.direction.length() - 1.0).abs() < 1e-3;
                if !right {
                    wrong += 1;
                    note = format!(
                        "{}, alpha {alpha:.1e}, cosine {cosine:.1e}: weight {:?}, density {:e}, direction {:?}",
                        material.kind().name(),
                        drawn.weight,
                        drawn.pdf_dir,
                        drawn.direction
                    );
                }
            }
            let towards = at(numbers.magnitude(-8.0, 0.0)) * DVec3::new(-1.0, 1.0, 1.0);
            let (f_cosine, pdf_dir) = evaluate(material, Vec3::Z, incoming, towards.as_vec3());
            if !(colour(f_cosine) && fits(pdf_dir)) {
                wrong += 1;
                note =
                    format!("{}, alpha {alpha:.1e}: value {f_cosine:?}, density {pdf_dir:e}", material.kind().name());
            }
        }
    }
    Ok(Outcome::at_most(wrong as f64, 0.0)
        .tried(cases, "samples and evaluations at cosines from 1e-8, those not finite or negative")
        .note(note))
}

/// Fresnel reflectances lie in [0, 1], and next to f64's.
fn fresnel_range(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(500_000);
    let mut numbers = Numbers::new(5);
    let (mut worst, mut note, mut outside) = (0.0, String::new(), 0);
    for _ in 0..cases {
        let cosine = numbers.magnitude(-7.0, 0.0) as f32;
        let eta = match numbers.below(4) {
            0 => 1.0,
            1 => 1.0 + (numbers.fine() - 0.5) as f32 * 4e-6,
            _ => numbers.magnitude(-1.3, 1.3) as f32,
        };
        let (got, _) = microfacet::fresnel_dielectric(cosine, eta);
        let (wanted, _) = exact::fresnel_dielectric(f64::from(cosine), f64::from(eta));
        let metal = [numbers.magnitude(-3.0, 3.0) as f32, numbers.magnitude(-4.0, 3.0) as f32];
        let reflected = microfacet::fresnel_conductor(cosine, Vec3::splat(metal[0]), Vec3::splat(metal[1])).x;
        let whole = DVec3::splat(f64::from(metal[0]));
        let truth = exact::fresnel_conductor(f64::from(cosine), whole, DVec3::splat(f64::from(metal[1]))).x;
        outside += [got, reflected].iter().filter(|r| !(-1e-6..=1.0 + 1e-6).contains(*r)).count();
        // Next to the critical angle and at index 1 a cosine changes faster than f32 can say.
        let steep = f64::from(eta) * f64::from(eta) - 1.0 + f64::from(cosine) * f64::from(cosine);
        if steep.abs() > 1e-2 {
            for (error, what) in [
                ((f64::from(got) - wanted).abs(), format!("index {eta}")),
                ((f64::from(reflected) - truth).abs(), format!("index {} + {} i", metal[0], metal[1])),
            ] {
                if worse(error, worst) {
                    (worst, note) = (error, format!("{what}, cosine {cosine:.2e}"));
                }
            }
        }
    }
    Ok(Outcome::at_most(worst, 2e-3)
        .tried(cases, "Fresnel reflectances of glass and metal, distance from f64's")
        .note(note)
        .and(outside == 0, format!("{outside} lie outside [0, 1]")))
}

/// Glass of index 1 is not there; of 1 +- 1e-6 it bends rays as Snell says, in f64.
fn glass_of_index_one(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(200_000);
    let mut numbers = Numbers::new(6);
    let (mut worst, mut note) = (0.0, String::new());
    for _ in 0..cases {
        let ior = [1.0, 1.0 + 1e-6, 1.0 - 1e-6][numbers.below(3) as usize];
        let material = record(Scattering::Dielectric { ior, transmittance: [1.0; 3] });
        let cosine = numbers.between(0.05, 1.0);
        let incoming = -at(cosine).as_vec3();
        let Some(drawn) = sample(&material, Vec3::Z, incoming, true, [0.5; 2], 0.999) else { continue };
        // Relative to the index that the table holds.
        let eta = f64::from(material.ior);
        let sine = f64::from(incoming.x) / eta;
        let wanted = DVec3::new(sine, 0.0, -(1.0 - sine * sine).sqrt());
        let error = (drawn.direction.as_dvec3() - wanted).length();
        if worse(error, worst) {
            (worst, note) = (error, format!("index {ior}, cosine {cosine:.3}"));
        }
    }
    Ok(Outcome::at_most(worst, 5e-6)
        .tried(cases, "rays through glass of index 1 and 1 +- 1e-6, error in radians")
        .note(note))
}

/// In and out of glass of any index a ray keeps its radiance and its direction, and Snell's law holds on the way.
fn glass_in_and_out(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(200_000);
    let mut numbers = Numbers::new(7);
    let (mut worst, mut note) = (0.0, String::new());
    for _ in 0..cases {
        let ior = numbers.magnitude(0.0, 1.3);
        let material = record(Scattering::Dielectric { ior, transmittance: [1.0; 3] });
        let cosine = numbers.between(0.02, 1.0);
        let incoming = -at(cosine).as_vec3();
        let refracted = |incoming: Vec3, front: bool| {
            sample(&material, Vec3::Z, incoming, front, [0.5; 2], 0.999_999_9).filter(|drawn| drawn.direction.z < 0.0)
        };
        let Some(inside) = refracted(incoming, true) else { continue };
        let Some(outside) = refracted(inside.direction, false) else { continue };
        let sine = f64::from(inside.direction.x) * f64::from(material.ior) - f64::from(incoming.x);
        let radiance = f64::from(inside.weight.x) * f64::from(outside.weight.x) - 1.0;
        // The cosine outside comes from a root that loses its digits at grazing angles.
        let turned = (outside.direction - incoming).length() * cosine as f32;
        // Inside, the sine is what a cosine next to 1 leaves; outside it is larger by the index, its square by that squared.
        let error = sine.abs().max(radiance.abs()).max(f64::from(turned)) / (ior * ior);
        if worse(error, worst) || sine.is_nan() {
            (worst, note) = (error, format!("index {ior:.3}, cosine {cosine:.3}"));
        }
    }
    Ok(Outcome::at_most(worst, 1e-6)
        .tried(cases, "rays into and out of glass of index n = 1 to 20, error of direction and radiance over n^2")
        .note(note))
}

/// Walls that reflect nothing and walls that lose nothing, to the last digit.
fn albedo_zero_and_one(effort: &Effort) -> Result<Outcome> {
    let spp = effort.samples(16, 4);
    let mut worst: f64 = 0.0;
    for (albedo, wanted) in [(0.0, 1.0), (1.0, 9.0)] {
        let trial = Trial::new("furnace", &[albedo, 1.0])?;
        let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(8), rr_depth: None, ..small(16, spp) };
        let film = trial.render(&settings).film;
        for pixel in &film.pixels {
            let error = (pixel.sum[0] / f64::from(spp) / wanted - 1.0).abs();
            worst = if worse(error, worst) { error } else { worst };
        }
    }
    Ok(Outcome::at_most(worst, 2e-6)
        .tried(u64::from(spp) * 512, "samples in furnaces of albedo 0 and 1, largest error of a pixel"))
}

/// Plates of plastic and metal under a sky of radiance 1, seen at 30 to 85 degrees, have their albedo as radiance, by BSDF
/// samples and by light samples.
fn plates_under_a_sky(effort: &Effort) -> Result<Outcome> {
    let (spp, mut worst, mut samples) = (effort.samples(64, 32), Worst::default(), 0);
    for (ior, alpha, degrees) in
        [(1.5, 0.2, 30.0), (1.5, 0.2, 75.0), (2.5, 0.5, 60.0), (10.0, 0.3, 85.0), (20.0, 1.0, 45.0)]
    {
        let trial = Trial::new("plate", &[ior, alpha, degrees])?;
        let base = f64::from(white_plastic(ior, alpha).color[0]);
        let truth = plastic_albedo(ior, alpha, base, degrees.to_radians().cos(), 100);
        for strategy in [Strategy::Bsdf, Strategy::Nee, Strategy::MisPower] {
            let settings = Settings { strategy, max_depth: Some(1), ..small(16, spp) };
            worst.add(&format!("{strategy}, index {ior}, {degrees} degrees"), trial.mean(&settings, truth), 1e-3);
            samples += u64::from(spp) * 256;
        }
    }
    Ok(Outcome::at_most(worst.sigmas, SIGMAS)
        .tried(samples, "samples of plates under a sky by 3 strategies against quadrature, in standard errors")
        .and(worst.nonfinite == 0, "samples are not finite")
        .note(worst.what)
        .trace(worst.trace))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (LostMasking, &["materials/conductor_energy", "materials/plastic_samples", "materials/principled_samples"]),
        (NoNumberAtGrazing, &["materials/grazing_is_finite"]),
        (BrightBase, &["materials/plastic_energy"]),
        (BrightCoat, &["materials/fresnel_range", "materials/plates_under_a_sky"]),
        (StaleDensity, &["materials/samples_and_densities"]),
        (WrongRefraction, &["materials/glass_of_index_one", "materials/glass_in_and_out"]),
        (BrightAlbedo, &["materials/albedo_zero_and_one"]),
    ]
};
