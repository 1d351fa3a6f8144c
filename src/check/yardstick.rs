//! The f64 yardstick: every kernel of the reference in f32 against itself in f64, with the same numbers.
//!
//! Figures are the largest errors; the notes have the 99.99th percentile besides, in ulp and relative. Where terms cancel, an
//! ulp is that of the terms, as each row says. Bounds are one and a half to
//! four times what was measured.

use crate::bvh::Bvh;
use crate::check::item::{Check, Effort};
use crate::check::numbers::{Errors, Numbers, worse};
use crate::check::row::Outcome;
use crate::check::scenes::skies::noise;
use crate::check::trial::{Estimate, Trial, small};
use crate::error::Result;
use crate::reference::{double, single};
use crate::sampler::draws::LightDraws;
use crate::scene::desc::{MapDesc, MaterialDesc, Scattering};
use crate::settings::{Lights, Settings};
use crate::setup::Setup;
use crate::strategy::Strategy;
use crate::tables::lights::environment::EnvironmentMap;
use crate::tables::lights::table::LightTable;
use crate::tables::margins::Margins;
use crate::tables::materials::MaterialRecord;
use crate::trace::TraceVertex;
use glam::{DVec3, Vec3};

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "yardstick", what: "triangle_t", run: triangle_t },
    Check { group: "yardstick", what: "triangle_t_of_slivers", run: triangle_t_of_slivers },
    Check { group: "yardstick", what: "triangle_weights", run: triangle_weights },
    Check { group: "yardstick", what: "triangle_decisions", run: triangle_decisions },
    Check { group: "yardstick", what: "start_offset", run: start_offset },
    Check { group: "yardstick", what: "cosine_hemisphere", run: cosine_hemisphere },
    Check { group: "yardstick", what: "diffuse", run: diffuse },
    Check { group: "yardstick", what: "conductor_value", run: |effort| glossy(effort, &METAL, false) },
    Check { group: "yardstick", what: "conductor_density", run: |effort| glossy(effort, &METAL, true) },
    Check { group: "yardstick", what: "plastic_value", run: |effort| glossy(effort, &COAT, false) },
    Check { group: "yardstick", what: "plastic_density", run: |effort| glossy(effort, &COAT, true) },
    Check { group: "yardstick", what: "principled_value", run: |effort| glossy(effort, &MIXED, false) },
    Check { group: "yardstick", what: "principled_density", run: |effort| glossy(effort, &MIXED, true) },
    Check { group: "yardstick", what: "visible_normals", run: visible_normals },
    Check { group: "yardstick", what: "balance_weight", run: |effort| weights(effort, false) },
    Check { group: "yardstick", what: "power_weight", run: |effort| weights(effort, true) },
    Check { group: "yardstick", what: "spherical_triangle", run: spherical_triangle },
    Check { group: "yardstick", what: "spherical_triangle_points", run: spherical_triangle_points },
    Check { group: "yardstick", what: "light_density", run: light_density },
    Check { group: "yardstick", what: "light_sample", run: light_sample },
    Check { group: "yardstick", what: "environment_directions", run: environment_directions },
    Check { group: "yardstick", what: "path_decisions", run: path_decisions },
    Check { group: "yardstick", what: "path_cost", run: path_cost },
];

/// Triangles about random places.
struct Soup {
    positions: Vec<[f32; 3]>,
    bvh: Bvh,
}

/// So many triangles a soup.
const TRIANGLES: u32 = 2048;

impl Soup {
    /// Triangles of these sizes and aspects in a cube of half the side 1, the whole `scale` times as large and `shift` of its own
    /// sizes away from the origin.
    fn new(numbers: &mut Numbers, scale: f64, shift: f64, aspect: impl Fn(&mut Numbers) -> f64) -> Soup {
        let away = numbers.direction() * 2.0 * shift;
        let mut positions = Vec::new();
        for _ in 0..TRIANGLES {
            let place = DVec3::new(numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0));
            let along = numbers.direction() * numbers.magnitude(-2.0, 0.0);
            let across = along.cross(numbers.direction()).normalize() * along.length() / aspect(numbers);
            let third = along * numbers.fine() + across;
            for corner in [place, place + along, place + third] {
                positions.push(((corner + away) * scale).as_vec3().to_array());
            }
        }
        let triangles: Vec<[u32; 3]> = (0..TRIANGLES).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let bvh = Bvh::build(&positions, &triangles, |_| true);
        Soup { positions, bvh }
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        [0, 1, 2].map(|k| DVec3::from(self.positions[3 * triangle as usize + k].map(f64::from)))
    }

    /// A ray towards a point of a random triangle whose weights are at least `inset`.
    fn aimed(&self, numbers: &mut Numbers, inset: f64) -> (Vec3, Vec3) {
        let corners = self.corners(numbers.below(TRIANGLES));
        let [u, v] = [numbers.fine().sqrt(), numbers.fine()];
        let weights = [1.0 - u, u * (1.0 - v), u * v].map(|w| inset + w * (1.0 - 3.0 * inset));
        let target = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let size = (corners[1] - corners[0]).length();
        let origin = (target + numbers.direction() * size * numbers.magnitude(-1.0, 1.0)).as_vec3();
        (origin, (target - origin.as_dvec3()).as_vec3())
    }
}

/// A ray's hits in f32 and in f64.
type Hits = (Option<single::intersect::Hit>, Option<double::intersect::Hit>);

/// What walks through a tree need.
type Stacks = (single::intersect::Stack, double::intersect::Stack);

fn hits(bvh: &Bvh, origin: Vec3, direction: Vec3, stacks: &mut Stacks) -> Hits {
    let ray = single::intersect::Ray { origin, direction, tmin: 0.0, tmax: f32::INFINITY };
    let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
    let exact = double::intersect::Ray { origin, direction, tmin: 0.0, tmax: f64::INFINITY };
    let single = single::intersect::intersect(bvh, &ray, &mut stacks.0);
    (single, double::intersect::intersect(bvh, &exact, &mut stacks.1))
}

/// Soups at the scales and shifts that a row goes through.
const PLACES: [(f64, f64); 6] = [(1.0, 0.0), (1e-9, 0.0), (1e9, 0.0), (1.0, 1.0), (1.0, 100.0), (1e6, 10.0)];

/// Tells `each` about rays that hit the same triangle in f32 and f64: soup, ray and both hits.
fn each_hit(
    effort: &Effort,
    usual: u64,
    seed: u32,
    aspect: fn(&mut Numbers) -> f64,
    mut each: impl FnMut(&Soup, (Vec3, Vec3), &single::intersect::Hit, &double::intersect::Hit),
) -> u64 {
    let cases = effort.cases(usual);
    let mut numbers = Numbers::new(seed);
    for (scale, shift) in PLACES {
        let soup = Soup::new(&mut numbers, scale, shift, aspect);
        let mut stacks = (single::intersect::stack(&soup.bvh), double::intersect::stack(&soup.bvh));
        for _ in 0..cases / PLACES.len() as u64 {
            let ray = soup.aimed(&mut numbers, 0.0);
            if let (Some(a), Some(b)) = hits(&soup.bvh, ray.0, ray.1, &mut stacks)
                && a.triangle == b.triangle
            {
                each(&soup, ray, &a, &b);
            }
        }
    }
    cases
}

/// The unit normal of a triangle.
fn normal(corners: [DVec3; 3]) -> DVec3 {
    (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize()
}

/// Errors of t as lengths along the normal, in ulp of the coordinates at hand.
fn along_the_normal(effort: &Effort, seed: u32, aspect: fn(&mut Numbers) -> f64) -> (u64, Errors) {
    let mut errors = Errors::default();
    let cases = each_hit(effort, 240_000, seed, aspect, |soup, (origin, direction), a, b| {
        let corners = soup.corners(a.triangle);
        let cosine = normal(corners).dot(direction.as_dvec3()).abs();
        let size = corners.iter().map(|c| c.abs().element_sum()).fold(origin.as_dvec3().abs().element_sum(), f64::max);
        errors.add_scaled(a.t, b.t, size / cosine, || format!("{:?}", corners.map(|c| c.as_vec3().to_array())));
    });
    (cases, errors)
}

fn triangle_t(effort: &Effort) -> Result<Outcome> {
    let (cases, errors) = along_the_normal(effort, 1, |numbers| numbers.magnitude(0.0, 1.0));
    Ok(Outcome::at_most(errors.largest, 4.0)
        .tried(cases, "rays at triangles of aspect 1 to 10, t along the normal, in ulp of the coordinates")
        .note(errors.note()))
}

fn triangle_t_of_slivers(effort: &Effort) -> Result<Outcome> {
    let (cases, errors) = along_the_normal(effort, 2, |numbers| numbers.magnitude(1.0, 6.0));
    Ok(Outcome::at_most(errors.largest, 8.0)
        .tried(cases, "rays at triangles of aspect 10 to 1e6, t along the normal, in ulp of the coordinates")
        .note(errors.note()))
}

/// Weights of hits are off by what rounding moves a point across the triangle: in ulp of coordinates over the height.
fn triangle_weights(effort: &Effort) -> Result<Outcome> {
    let mut errors = Errors::default();
    let aspect = |numbers: &mut Numbers| numbers.magnitude(0.0, 3.0);
    let cases = each_hit(effort, 240_000, 3, aspect, |soup, (origin, direction), a, b| {
        let corners = soup.corners(a.triangle);
        let [p, q, r] = corners;
        let longest = (q - p).length().max((r - q).length()).max((p - r).length());
        let height = (q - p).cross(r - p).length() / longest;
        let cosine = normal(corners).dot(direction.as_dvec3().normalize()).abs();
        let size = corners.iter().map(|c| c.abs().element_sum()).fold(origin.as_dvec3().abs().element_sum(), f64::max);
        for (got, wanted) in [(a.u, b.u), (a.v, b.v)] {
            errors.add_scaled(got, wanted, size / height / cosine, || format!("aspect {:.1e}", longest / height));
        }
    });
    Ok(Outcome::at_most(errors.largest, 8.0)
        .tried(cases, "rays at triangles of aspect 1 to 1,000, weights, in ulp of coordinates over the height")
        .note(errors.note()))
}

/// A ray through the inside of a triangle hits what it hits in f64: the share of rays that do not.
fn triangle_decisions(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(240_000);
    let mut numbers = Numbers::new(4);
    let (mut differ, mut tried, mut note) = (0u64, 0u64, String::new());
    for (scale, shift) in PLACES {
        let soup = Soup::new(&mut numbers, scale, shift, |numbers| numbers.magnitude(0.0, 1.0));
        let mut stacks = (single::intersect::stack(&soup.bvh), double::intersect::stack(&soup.bvh));
        for _ in 0..cases / PLACES.len() as u64 {
            let (origin, direction) = soup.aimed(&mut numbers, 0.02);
            let (a, b) = hits(&soup.bvh, origin, direction, &mut stacks);
            tried += 1;
            if a.map(|hit| hit.triangle) != b.map(|hit| hit.triangle) {
                differ += 1;
                note = format!("{differ} of {tried}, scale {scale:.0e}, {shift:.0e} sizes from the origin");
            }
        }
    }
    Ok(Outcome::at_most(differ as f64 / tried as f64, 1e-3)
        .tried(tried, "rays at triangles of aspect 1 to 10, share that hit another one in f64")
        .note(note))
}

/// Rounding moves a point along the normal by a part of the offset at which rays start.
fn start_offset(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(200_000);
    let mut numbers = Numbers::new(5);
    let (mut worst, mut note): (f64, String) = (0.0, String::new());
    for _ in 0..cases.div_ceil(64) {
        let shift = numbers.magnitude(-2.0, 4.0);
        let scale = numbers.magnitude(-6.0, 6.0);
        let place = numbers.direction() * shift;
        let along = numbers.direction();
        let across = along.cross(numbers.direction()).normalize();
        let corners = [place, place + along, place + across].map(|c| (c * scale).as_vec3().to_array());
        let n = normal(corners.map(|c| DVec3::from(c.map(f64::from))));
        let margin = Margins::of(corners, false).offset;
        for _ in 0..64 {
            let u = [numbers.unit(), numbers.unit()];
            let weights = single::warp::sample_uniform_triangle(u);
            let (position, offset) = single::surface::point_and_offset(&corners, weights, margin);
            let exact = weights.map(f64::from);
            let (truth, _) = double::surface::point_and_offset(&corners, exact, 0.0);
            // The weights' own sum is off 1 in f32: along the plane, not along the normal, only about the origin.
            let off = truth + DVec3::from(corners[0].map(f64::from)) * (1.0 - exact.iter().sum::<f64>());
            let share = (position.as_dvec3() - off).dot(n).abs() / f64::from(offset);
            if worse(share, worst) {
                (worst, note) = (share, format!("worst {shift:.1e} edges from the origin"));
            }
        }
    }
    Ok(Outcome::at_most(worst, 0.5)
        .tried(cases, "points on triangles up to 1e4 edges from the origin, error along the normal over the offset")
        .note(note))
}

fn cosine_hemisphere(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(500_000);
    let mut numbers = Numbers::new(6);
    let mut errors = Errors::default();
    for _ in 0..cases {
        let u = [numbers.unit(), numbers.unit()];
        let got = single::warp::sample_cosine_hemisphere(u).to_array();
        let wanted = double::warp::sample_cosine_hemisphere(u.map(f64::from)).to_array();
        for (got, wanted) in got.into_iter().zip(wanted) {
            errors.add_scaled(got, wanted, 1.0, || format!("{u:?}"));
        }
    }
    Ok(Outcome::at_most(errors.largest, 3.0)
        .tried(cases, "directions of the cosine hemisphere, components, in ulp of 1")
        .note(errors.note()))
}

fn record(scattering: Scattering) -> MaterialRecord {
    MaterialRecord::new(&MaterialDesc { scattering, ..MaterialDesc::default() })
}

fn diffuse(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(500_000);
    let mut numbers = Numbers::new(7);
    let mut errors = Errors::default();
    for _ in 0..cases.div_ceil(64) {
        let albedo = numbers.magnitude(-6.0, 0.0);
        let material = record(Scattering::Diffuse { albedo: [albedo; 3] });
        for _ in 0..64 {
            let cosine = numbers.magnitude(-7.0, 0.0) as f32;
            let (value, density) = single::bsdf::diffuse::evaluate(&material, cosine);
            let (exact, exact_density) = double::bsdf::diffuse::evaluate(&material, f64::from(cosine));
            errors.add(value.x, exact.x, || format!("albedo {albedo:.1e}, cosine {cosine:.1e}"));
            errors.add(density, exact_density, || format!("cosine {cosine:.1e}"));
        }
    }
    Ok(Outcome::at_most(errors.largest, 4.0)
        .tried(cases, "diffuse values and densities at cosines from 1e-7, in ulp")
        .note(errors.note()))
}

/// Makes a material of this width; and the bound of its rows.
struct Glossy {
    make: fn(f64) -> Scattering,
    bound: f64,
}

const METAL: Glossy =
    Glossy { make: |alpha| Scattering::Conductor { alpha, reflectance: [0.9; 3], complex_ior: None }, bound: 4.0 };
const MIXED: Glossy = Glossy {
    make: |alpha| Scattering::Principled { base_color: [0.5; 3], metallic: 0.5, roughness: alpha.sqrt(), ior: 1.5 },
    bound: 4.0,
};
const COAT: Glossy = Glossy { make: |alpha| Scattering::Plastic { albedo: [0.5; 3], ior: 1.5, alpha }, bound: 3.0 };

/// Value or density of a glossy material towards directions of its lobe, widths 1e-4 to 1. A direction in f32 is half an ulp
/// wide, which is so much more of a lobe as that is narrow, and of a cosine as that is small: errors are in ulp of the truth
/// times 1 + 1 / alpha + 1 / cosine.
fn glossy(effort: &Effort, glossy: &Glossy, density: bool) -> Result<Outcome> {
    const WIDTHS: u32 = 9;
    let cases = effort.cases(270_000);
    let mut numbers = Numbers::new(8);
    let mut errors = Errors::default();
    for step in 0..WIDTHS {
        let alpha = 10f64.powf(-4.0 * f64::from(step) / f64::from(WIDTHS - 1));
        let material = record((glossy.make)(alpha));
        let alpha = f64::from(material.alpha);
        for _ in 0..cases / u64::from(WIDTHS) {
            let cosine = numbers.magnitude(-2.0, 0.0);
            let wo = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine).as_vec3();
            let exact_wo = wo.as_dvec3();
            let half =
                double::bsdf::microfacet::sample_visible_normal(alpha, exact_wo, [numbers.fine(), numbers.fine()]);
            let wi = double::bsdf::microfacet::reflect_about(exact_wo, half).as_vec3();
            if wi.z < 1e-2 {
                continue;
            }
            // Local directions are world directions about +z.
            let (value, pdf) = single::bsdf::evaluate(&material, Vec3::Z, -wo, wi);
            let (exact, exact_pdf) = double::bsdf::evaluate(&material, DVec3::Z, -exact_wo, wi.as_dvec3());
            let (got, wanted) = if density { (pdf, exact_pdf) } else { (value.x, exact.x) };
            let size = wanted * (1.0 + 1.0 / alpha + 1.0 / f64::from(wo.z) + 1.0 / f64::from(wi.z));
            errors.add_scaled(got, wanted, size, || format!("alpha {alpha:.1e}, cosine {:.1e}", wo.z));
        }
    }
    let what = if density { "densities" } else { "values" };
    Ok(Outcome::at_most(errors.largest, glossy.bound)
        .tried(cases, format!("{what}, alpha 1e-4 to 1, in ulp times 1 + 1/alpha + 1/cosines"))
        .note(errors.note()))
}

fn visible_normals(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(300_000);
    let mut numbers = Numbers::new(9);
    let mut errors = Errors::default();
    for _ in 0..cases {
        let alpha = numbers.magnitude(-4.0, 0.0) as f32;
        let cosine = numbers.magnitude(-3.0, 0.0);
        let wo = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine).as_vec3();
        let u = [numbers.unit(), numbers.unit()];
        let got = single::bsdf::microfacet::sample_visible_normal(alpha, wo, u);
        let wanted = double::bsdf::microfacet::sample_visible_normal(f64::from(alpha), wo.as_dvec3(), u.map(f64::from));
        // Tangent components in units of the lobe: the normal's own is next to 1.
        for (got, wanted) in [(got.x, wanted.x), (got.y, wanted.y)] {
            let size = f64::from(alpha).max(wanted.abs());
            errors.add_scaled(got, wanted, size, || format!("alpha {alpha:.1e}, cosine {cosine:.1e}"));
        }
    }
    // At the end of a lobe seen along the surface a normal's own component vanishes: there a few are off by far more.
    Ok(Outcome::at_most(errors.usual()[0], 2048.0)
        .tried(cases, "visible normals, tangent components, 99.99 % of them, in ulp of the lobe's width")
        .note(errors.note()))
}

/// Weights against f64; those below the normal numbers count as 0.
fn weights(effort: &Effort, power: bool) -> Result<Outcome> {
    let cases = effort.cases(1_000_000);
    let mut numbers = Numbers::new(10);
    let mut errors = Errors::default();
    let floor = f64::from(f32::MIN_POSITIVE);
    for _ in 0..cases {
        let a = numbers.magnitude(-38.0, 38.0) as f32;
        let b = match numbers.below(2) {
            0 => numbers.magnitude(-38.0, 38.0) as f32,
            _ => (f64::from(a) * numbers.magnitude(-3.0, 3.0)).min(3e38) as f32,
        };
        let (wide_a, wide_b) = (f64::from(a), f64::from(b));
        let (got, wanted) = match power {
            false => (single::mis::balance(a, b), double::mis::balance(wide_a, wide_b)),
            true => (single::mis::power(a, b), double::mis::power(wide_a, wide_b)),
        };
        if wanted >= floor || f64::from(got) >= floor {
            errors.add(got, wanted, || format!("{a:e}, {b:e}"));
        }
    }
    Ok(Outcome::at_most(errors.largest, 4.0)
        .tried(cases, "pairs of densities of 1e-38 to 1e38, in ulp")
        .note(errors.note()))
}

/// A triangle and a point about as far away as it is large.
fn seen_triangle(numbers: &mut Numbers) -> ([[f32; 3]; 3], Vec3) {
    let scale = numbers.magnitude(-3.0, 3.0);
    let corners = [(); 3].map(|()| numbers.direction() * scale);
    let origin =
        (corners[0] + corners[1] + corners[2]) / 3.0 + numbers.direction() * scale * numbers.magnitude(-3.0, 0.3);
    (corners.map(|c| c.as_vec3().to_array()), origin.as_vec3())
}

/// One over the area of a triangle.
fn density_by_area(corners: &[[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|c| DVec3::from(c.map(f64::from)));
    2.0 / (b - a).cross(c - a).length()
}

/// The density of drawing points of a triangle by its solid angle, part by area where that says so.
fn spherical_triangle(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(300_000);
    let mut numbers = Numbers::new(11);
    let mut errors = Errors::default();
    for _ in 0..cases {
        let (corners, origin) = seen_triangle(&mut numbers);
        let pdf_area = density_by_area(&corners) as f32;
        let got = single::lights::triangle::solid_angle(&corners, pdf_area, origin);
        let wanted = double::lights::triangle::solid_angle(&corners, f64::from(pdf_area), origin.as_dvec3());
        if let (Some(got), Some(wanted)) = (got, wanted) {
            let at = || format!("{:.2e} turns, part {:.2}", wanted.half_turns, wanted.part);
            errors.add_scaled(got.half_turns, wanted.half_turns, wanted.half_turns.max(1e-3), at);
        }
    }
    Ok(Outcome::at_most(errors.largest, 8192.0)
        .tried(cases, "triangles seen from near by, solid angles of 1e-3 to 6.2 sr, in ulp")
        .note(errors.note()))
}

/// The points drawn, in ulp of the triangle's size; on the way from f32 weights.
fn spherical_triangle_points(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(300_000);
    let mut numbers = Numbers::new(12);
    let mut errors = Errors::default();
    for _ in 0..cases {
        let (corners, origin) = seen_triangle(&mut numbers);
        let pdf_area = density_by_area(&corners) as f32;
        let got = single::lights::triangle::solid_angle(&corners, pdf_area, origin);
        let wanted = double::lights::triangle::solid_angle(&corners, f64::from(pdf_area), origin.as_dvec3());
        let u = [numbers.unit(), numbers.unit()];
        if let (Some(got), Some(wanted)) = (got, wanted)
            && wanted.half_turns > 1e-3
        {
            let (a, b) = (got.sample_solid_angle(u), wanted.sample_solid_angle(u.map(f64::from)));
            for (a, b) in a.into_iter().zip(b) {
                errors.add_scaled(a, b, 1.0, || format!("{:.2e} turns, u {u:?}", wanted.half_turns));
            }
        }
    }
    Ok(Outcome::at_most(errors.largest, 2048.0)
        .tried(cases, "points drawn by solid angle, barycentric weights, in ulp of 1")
        .note(errors.note()))
}

/// Points of a floor under many lamps, as both copies of the reference see them.
fn floor_point(numbers: &mut Numbers) -> (Vec3, Vec3) {
    let at = |numbers: &mut Numbers| numbers.between(-3.0, 3.0);
    (DVec3::new(at(numbers), 1e-6, at(numbers)).as_vec3(), Vec3::Y)
}

/// Densities of hits on lamps, by the light tree, for points of a floor.
fn light_density(effort: &Effort) -> Result<Outcome> {
    let trial = Trial::new("lamp_grid", &[8.0])?;
    let lights = LightTable::new(&trial.prepared, Lights::Tree, true);
    let cases = effort.cases(100_000);
    let mut numbers = Numbers::new(13);
    let mut errors = Errors::default();
    for _ in 0..cases {
        let (origin, normal) = floor_point(&mut numbers);
        let light = numbers.below(lights.records.len() as u32);
        let corners = lights.records[light as usize].vertices.map(Vec3::from);
        let target = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
        let t = (target - origin).length();
        let cosine = -Vec3::from(lights.records[light as usize].normal).dot((target - origin) * (1.0 / t));
        if cosine < 0.01 {
            continue;
        }
        let receiver = single::lights::tree::Receiver { origin, normal, row: 0 };
        let got = single::lights::sample::light_pdf_dir(&lights, &receiver, light, t, cosine);
        let receiver = double::lights::tree::Receiver { origin: origin.as_dvec3(), normal: normal.as_dvec3(), row: 0 };
        let wanted = double::lights::sample::light_pdf_dir(&lights, &receiver, light, f64::from(t), f64::from(cosine));
        errors.add(got, wanted, || format!("lamp {light} from {origin:?}"));
    }
    Ok(Outcome::at_most(errors.largest, 64.0)
        .tried(cases, "densities of 64 lamps by the light tree, in ulp")
        .note(errors.note()))
}

/// Light samples from the same numbers: what they bring over their density.
fn light_sample(effort: &Effort) -> Result<Outcome> {
    let trial = Trial::new("lamp_grid", &[8.0])?;
    let lights = LightTable::new(&trial.prepared, Lights::Power, true);
    let cases = effort.cases(100_000);
    let mut numbers = Numbers::new(14);
    let mut errors = Errors::default();
    let floor = &trial.prepared.triangles[0];
    for _ in 0..cases {
        let [_, u, v] = single::warp::sample_uniform_triangle([numbers.unit(), numbers.unit()]);
        let draws: LightDraws<u32, f32> = [(); 4].map(|()| numbers.word()).into();
        let point = single::surface::surface_point(floor, None, u, v, Vec3::NEG_Y);
        let exact = double::surface::surface_point(floor, None, f64::from(u), f64::from(v), DVec3::NEG_Y);
        let got = single::lights::sample::sample_light(&lights, &point, 0, &draws);
        let wanted = double::lights::sample::sample_light(&lights, &exact, 0, &draws);
        if let (Some(got), Some(wanted)) = (got, wanted) {
            let value = got.radiance.x * got.cosine / got.pdf_dir;
            let truth = wanted.radiance.x * wanted.cosine / wanted.pdf_dir;
            errors.add(value, truth, || format!("from {:?}", point.position));
        }
    }
    Ok(Outcome::at_most(errors.largest, 512.0)
        .tried(cases, "light samples of 64 lamps, what they bring over their density, in ulp")
        .note(errors.note()))
}

fn environment_directions(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(300_000);
    let mut numbers = Numbers::new(15);
    let mut errors = Errors::default();
    for (columns, rows) in [(7, 5), (64, 32), (4, 4096)] {
        let texels = noise(columns, rows, 5).into_iter().map(|value| [value; 3]).collect();
        let file = "noise".to_string();
        let desc = MapDesc { file, width: columns, height: rows, texels, rotate: 77.0, scale: 1.0 };
        let map = EnvironmentMap::new(&desc, 1.0);
        let distribution = map.distribution(false);
        for _ in 0..cases / 3 {
            let words = [numbers.word(), numbers.word()];
            let u = [numbers.unit(), numbers.unit()];
            let (got, _) = single::lights::environment::sample_map(&map, distribution, words, u);
            let (wanted, _) = double::lights::environment::sample_map(&map, distribution, words, u.map(f64::from));
            for (got, wanted) in got.to_array().into_iter().zip(wanted.to_array()) {
                errors.add_scaled(got, wanted, 1.0, || format!("{columns} x {rows}"));
            }
        }
    }
    Ok(Outcome::at_most(errors.largest, 16.0)
        .tried(cases, "directions drawn from maps, components, in ulp of 1")
        .note(errors.note()))
}

/// What both copies of the reference made of the same paths of one scene.
struct Paths {
    count: u64,
    /// Paths that met other triangles or ended elsewhere.
    apart: u64,
    first: Option<(u32, u32, u32)>,
    /// Radiance in f32 less radiance in f64, path by path.
    difference: Estimate,
    truth: Estimate,
}

/// The scenes whose paths are followed in both: rooms, lamps, coats, skies.
const PATH_SCENES: [(&str, &[f64]); 6] = [
    ("furnace", &[0.5, 0.5]),
    ("lamp", &[0.5, 1.0, 1.0, 0.5, 0.0]),
    ("lamp_grid", &[8.0]),
    ("mirrored_lamp", &[0.05, 0.5]),
    ("plate", &[1.5, 0.2, 60.0]),
    ("noise_sky", &[16.0, 8.0, 5.0]),
];

fn follow(effort: &Effort, trial: &Trial) -> Paths {
    let spp = effort.samples(16, 4);
    let settings = Settings { strategy: Strategy::MisPower, max_depth: Some(6), ..small(16, spp) };
    let setup = Setup::new(&trial.prepared, &settings);
    let (mut differences, mut truths) = (Vec::new(), Vec::new());
    let (mut apart, mut first) = (0, None);
    for (x, y, sample) in (0..16).flat_map(|y| (0..16).flat_map(move |x| (0..spp).map(move |sample| (x, y, sample)))) {
        let (mut met, mut exactly) = (Vec::new(), Vec::new());
        let decision = |vertex: &TraceVertex| (vertex.event, vertex.triangle);
        let got = single::path::trace_path(&setup, (x, y), sample, &mut |v: TraceVertex| met.push(decision(&v)));
        let wanted = double::path::trace_path(&setup, (x, y), sample, &mut |v: TraceVertex| exactly.push(decision(&v)));
        if met != exactly {
            apart += 1;
            first = first.or(Some((x, y, sample)));
        }
        differences.push(f64::from(got.radiance.x) - wanted.radiance.x);
        truths.push(wanted.radiance.x);
    }
    let count = truths.len() as u64;
    Paths { count, apart, first, difference: Estimate::of_values(&differences), truth: Estimate::of_values(&truths) }
}

/// How often a path meets other triangles or ends elsewhere in f64.
fn path_decisions(effort: &Effort) -> Result<Outcome> {
    let (mut apart, mut count, mut trace, mut notes) = (0, 0, None, Vec::new());
    for (name, numbers) in PATH_SCENES {
        let trial = Trial::new(name, numbers)?;
        let paths = follow(effort, &trial);
        apart += paths.apart;
        count += paths.count;
        notes.push(format!("{name} {} of {}", paths.apart, paths.count));
        if let (None, Some((x, y, sample))) = (&trace, paths.first) {
            let settings = Settings { strategy: Strategy::MisPower, max_depth: Some(6), ..small(16, 1) };
            trace = Some(trial.trace(&settings, (x, y), sample));
        }
    }
    Ok(Outcome::at_most(apart as f64 / count as f64, 5e-3)
        .tried(count, "paths of 6 scenes, share that goes another way in f64")
        .note(notes.join(", "))
        .trace(trace))
}

/// What that costs: the difference of the means, of what it can be told to be, relative to the mean.
fn path_cost(effort: &Effort) -> Result<Outcome> {
    let (mut worst, mut count, mut note): (f64, u64, String) = (0.0, 0, String::new());
    for (name, numbers) in PATH_SCENES {
        let paths = follow(effort, &Trial::new(name, numbers)?);
        count += paths.count;
        // What is left once five standard errors of the difference are forgiven: paths that part differ by noise.
        let off = (paths.difference.mean.abs() - 5.0 * paths.difference.error).max(0.0) / paths.truth.mean;
        let total = paths.difference.mean / paths.truth.mean;
        if worse(off, worst) || note.is_empty() {
            worst = worst.max(off);
            note = format!("{name}: means differ by {total:.1e} +- {:.1e}", paths.difference.error / paths.truth.mean);
        }
    }
    Ok(Outcome::at_most(worst, 2e-4)
        .tried(count, "paths of 6 scenes, difference of the means of f32 and f64, relative, noise forgiven")
        .note(note))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (
            LostDigits,
            &[
                "yardstick/triangle_t",
                "yardstick/triangle_t_of_slivers",
                "yardstick/triangle_weights",
                "yardstick/path_cost",
                "yardstick/start_offset",
                "yardstick/cosine_hemisphere",
                "yardstick/diffuse",
                "yardstick/conductor_value",
                "yardstick/conductor_density",
                "yardstick/plastic_value",
                "yardstick/plastic_density",
                "yardstick/principled_value",
                "yardstick/principled_density",
                "yardstick/visible_normals",
                "yardstick/spherical_triangle",
                "yardstick/spherical_triangle_points",
                "yardstick/light_density",
                "yardstick/light_sample",
                "yardstick/environment_directions",
            ],
        ),
        (WeightOfNoNumber, &["yardstick/balance_weight", "yardstick/power_weight"]),
        (SmallTriangles, &["yardstick/triangle_decisions", "yardstick/path_decisions"]),
    ]
};
