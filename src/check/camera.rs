//! Cameras: angles of view and lenses at their extremes.

use crate::camera::{Camera, warnings};
use crate::check::item::{Check, Effort};
use crate::check::numbers::{Numbers, worse};
use crate::check::row::Outcome;
use crate::check::scenes;
use crate::error::Result;
use crate::reference::double;
use crate::reference::single::camera::camera_ray;
use crate::sampler::draws::CameraDraws;
use crate::scene::desc::{CameraDesc, PixelFilter};
use glam::DVec3;

/// The checks.
pub const CHECKS: &[Check] = &[
    Check { group: "camera", what: "narrow_views", run: narrow_views },
    Check { group: "camera", what: "narrowest_views_are_told", run: narrowest_views_are_told },
    Check { group: "camera", what: "wide_views", run: wide_views },
    Check { group: "camera", what: "directions_are_unit", run: directions_are_unit },
    Check { group: "camera", what: "lens_in_focus", run: lens_in_focus },
    Check { group: "camera", what: "lens_focused_far_away", run: lens_focused_far_away },
    Check { group: "camera", what: "lens_wide_open", run: lens_wide_open },
    Check { group: "camera", what: "scaled_matrices", run: scaled_matrices },
    Check { group: "camera", what: "filters_are_centred", run: filters_are_centred },
];

/// Rows and columns of the film.
const SIDE: u32 = 64;

/// A camera at an odd place that looks in an odd direction: no component is round.
fn oblique(numbers: &mut Numbers, fov: f64) -> CameraDesc {
    let position = numbers.direction() * numbers.between(0.1, 10.0);
    let look_at = position + numbers.direction() * numbers.magnitude(-1.0, 2.0);
    let up = numbers.direction();
    CameraDesc {
        position: position.to_array(),
        look_at: look_at.to_array(),
        up: up.to_array(),
        vertical_fov: fov,
        ..CameraDesc::default()
    }
}

/// The numbers of a camera ray through the middle of the lens.
fn draws(film: [f32; 2]) -> CameraDraws<f32> {
    CameraDraws { film, lens: [0.0; 2] }
}

/// The direction through film position (x, y) of a pinhole, in f64 from its description.
fn wanted(desc: &CameraDesc, x: f64, y: f64) -> DVec3 {
    let forward = (DVec3::from(desc.look_at) - DVec3::from(desc.position)).normalize();
    let right = forward.cross(DVec3::from(desc.up)).normalize();
    let down = forward.cross(right);
    let pixel = 2.0 * (0.5 * desc.vertical_fov.to_radians()).tan() / f64::from(SIDE);
    let half = 0.5 * f64::from(SIDE);
    (forward + right * ((x - half) * pixel) + down * ((y - half) * pixel)).normalize()
}

/// The largest error of directions under these fields of view, in pixels of the film's centre, and the field.
fn directions(effort: &Effort, seed: u32, usual: u64, fov: impl Fn(&mut Numbers) -> f64) -> (u64, f64, f64) {
    let cases = effort.cases(usual);
    let mut numbers = Numbers::new(seed);
    let (mut worst, mut at) = (0.0, 0.0);
    for _ in 0..cases.div_ceil(16) {
        let fov = fov(&mut numbers);
        let desc = oblique(&mut numbers, fov);
        let camera = Camera::new(&desc, PixelFilter::Box, SIDE, SIDE);
        for _ in 0..16 {
            let (x, y) = (numbers.below(SIDE), numbers.below(SIDE));
            let film = [numbers.unit(), numbers.unit()];
            let ray = camera_ray(&camera, x, y, &draws(film));
            let wanted = wanted(&desc, f64::from(x as f32 + film[0]), f64::from(y as f32 + film[1]));
            let error = (ray.direction.as_dvec3() - wanted).length() / (fov.to_radians() / f64::from(SIDE));
            if worse(error, worst) {
                (worst, at) = (error, fov);
            }
        }
    }
    (cases, worst, at)
}

/// Down to 2^-22 radians a pixel a ray is within a pixel of where it should go.
fn narrow_views(effort: &Effort) -> Result<Outcome> {
    let narrowest = (2f64.powi(-22) * f64::from(SIDE)).to_degrees();
    let fov = |numbers: &mut Numbers| numbers.magnitude(narrowest.log10(), 1.5);
    let (cases, worst, at) = directions(effort, 1, 400_000, fov);
    Ok(Outcome::at_most(worst, 1.0)
        .tried(cases, "oblique rays of views down to 2^-22 rad a pixel, error in pixels")
        .note(format!("worst at {at:.2e} degrees over {SIDE} pixels")))
}

/// Narrower views are wrong in f32 by more than a pixel, so loading says so.
fn narrowest_views_are_told(_: &Effort) -> Result<Outcome> {
    let mut silent = 0;
    let views = [1e-6, 1e-5, 1e-4, 3e-4];
    for fov in views {
        let mut scene = scenes::load("furnace:0.5:0.5")?;
        scene.desc.camera.vertical_fov = fov;
        scene.desc.film = (1000, 1000);
        // An error is as good as a warning.
        silent += scene.prepare().is_ok_and(|prepared| warnings(&prepared.camera, 1000).is_empty()) as usize;
    }
    Ok(Outcome::at_most(silent as f64, 0.0)
        .tried(views.len() as u64, "views below 2^-22 rad a pixel, those without a warning"))
}

fn wide_views(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(200_000);
    let mut numbers = Numbers::new(2);
    let (mut worst, mut at) = (0.0, 0.0);
    for _ in 0..cases {
        let fov = 180.0 - numbers.magnitude(-3.0, 2.0);
        let desc = oblique(&mut numbers, fov);
        let camera = Camera::new(&desc, PixelFilter::Box, SIDE, SIDE);
        let (x, y) = (numbers.below(SIDE), numbers.below(SIDE));
        let film = [numbers.unit(), numbers.unit()];
        let ray = camera_ray(&camera, x, y, &draws(film));
        let (x, y) = (f64::from(x as f32 + film[0]), f64::from(y as f32 + film[1]));
        let wanted = |x: f64, y: f64| wanted(&desc, x, y);
        // A pixel's own size there: the larger one, since pixels far from the centre are seen foreshortened.
        let pixel = (wanted(x + 0.01, y) - wanted(x - 0.01, y)).length() / 0.02;
        let pixel = pixel.max((wanted(x, y + 0.01) - wanted(x, y - 0.01)).length() / 0.02);
        let error = (ray.direction.as_dvec3() - wanted(x, y)).length() / pixel;
        if worse(error, worst) {
            (worst, at) = (error, fov);
        }
    }
    Ok(Outcome::at_most(worst, 1e-4)
        .tried(cases, "rays of views of 80 to 179.999 degrees, error in pixels")
        .note(format!("worst at {at:.3} degrees")))
}

fn directions_are_unit(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(400_000);
    let mut numbers = Numbers::new(3);
    let mut worst: f64 = 0.0;
    for _ in 0..cases.div_ceil(8) {
        let fov = match numbers.below(2) {
            0 => numbers.magnitude(-6.0, 2.0),
            _ => 180.0 - numbers.magnitude(-3.0, 2.0),
        };
        let mut desc = oblique(&mut numbers, fov);
        desc.aperture_radius = numbers.magnitude(-6.0, 2.0);
        desc.focus_distance = numbers.magnitude(-3.0, 6.0);
        let camera = Camera::new(&desc, PixelFilter::Tent, SIDE, SIDE);
        for _ in 0..8 {
            let draws = CameraDraws { film: [numbers.unit(), numbers.unit()], lens: [numbers.unit(), numbers.unit()] };
            let ray = camera_ray(&camera, numbers.below(SIDE), numbers.below(SIDE), &draws);
            let error = (ray.direction.as_dvec3().length() - 1.0).abs();
            worst = if worse(error, worst) { error } else { worst };
        }
    }
    Ok(Outcome::at_most(worst, 4.0 * f64::from(f32::EPSILON))
        .tried(cases, "rays of all views and lenses, distance of their lengths from 1"))
}

/// Rays of one film position through all of a lens meet in the plane in focus, within a share of the lens's diameter that f32
/// can tell and a share of a pixel there.
fn lens_in_focus(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(200_000);
    let mut numbers = Numbers::new(4);
    let (mut worst, mut at) = (0.0, String::new());
    for _ in 0..cases.div_ceil(8) {
        let mut desc = oblique(&mut numbers, 40.0);
        desc.focus_distance = numbers.magnitude(-3.0, 6.0);
        desc.aperture_radius = desc.focus_distance * numbers.magnitude(-6.0, 0.0);
        let camera = Camera::new(&desc, PixelFilter::Box, SIDE, SIDE);
        let (x, y) = (numbers.below(SIDE), numbers.below(SIDE));
        let film = [numbers.unit(), numbers.unit()];
        let axis = (DVec3::from(desc.look_at) - DVec3::from(desc.position)).normalize();
        let pinhole = wanted(&desc, f64::from(x as f32 + film[0]), f64::from(y as f32 + film[1]));
        let point = DVec3::from(desc.position) + pinhole * (desc.focus_distance / pinhole.dot(axis));
        for _ in 0..8 {
            let ray = camera_ray(&camera, x, y, &CameraDraws { film, lens: [numbers.unit(), numbers.unit()] });
            let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let missed = (point - origin).cross(direction).length() / direction.length();
            // f32 places the eye to half an ulp of its coordinates.
            let error = missed / (desc.focus_distance + DVec3::from(desc.position).length());
            if worse(error, worst) {
                worst = error;
                at = format!("focus {:.1e}, radius {:.1e}", desc.focus_distance, desc.aperture_radius);
            }
        }
    }
    Ok(Outcome::at_most(worst, 1e-6)
        .tried(cases, "rays of lenses focused at 1e-3 to 1e6, distance from the point in focus over its own")
        .note(at))
}

/// A lens focused so far away that its rays are parallel sees what the pinhole sees; or loading refuses it.
fn lens_focused_far_away(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(20_000);
    let mut numbers = Numbers::new(5);
    let (mut worst, mut at): (f64, f64) = (0.0, 0.0);
    for _ in 0..cases.div_ceil(8) {
        let mut scene = scenes::load("furnace:0.5:0.5")?;
        scene.desc.camera.aperture_radius = 0.01;
        scene.desc.camera.focus_distance = numbers.magnitude(8.0, 38.4).min(3e38);
        let focus = scene.desc.camera.focus_distance;
        if scene.prepare().is_err() {
            continue;
        }
        let lens = Camera::new(&scene.desc.camera, PixelFilter::Box, SIDE, SIDE);
        let pinhole = Camera { lens: None, ..lens };
        for _ in 0..8 {
            let (x, y) = (numbers.below(SIDE), numbers.below(SIDE));
            let draws = CameraDraws { film: [numbers.unit(), numbers.unit()], lens: [numbers.unit(), numbers.unit()] };
            let [a, b] = [lens, pinhole].map(|camera| camera_ray(&camera, x, y, &draws).direction.as_dvec3());
            let error = (a - b).length();
            if worse(error, worst) {
                (worst, at) = (error, focus);
            }
        }
    }
    Ok(Outcome::at_most(worst, 4.0 * f64::from(f32::EPSILON))
        .tried(cases, "rays focused at 1e8 to 3e38, distance from the pinhole's")
        .note(format!("worst at {at:.1e}")))
}

/// Lenses far wider than what they look at is away, against the same rays in f64.
fn lens_wide_open(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(200_000);
    let mut numbers = Numbers::new(6);
    let (mut worst, mut at): (f64, String) = (0.0, String::new());
    for _ in 0..cases {
        let mut desc = oblique(&mut numbers, 60.0);
        desc.focus_distance = numbers.magnitude(-3.0, 3.0);
        desc.aperture_radius = desc.focus_distance * numbers.magnitude(0.0, 6.0);
        let camera = Camera::new(&desc, PixelFilter::Box, SIDE, SIDE);
        let (x, y) = (numbers.below(SIDE), numbers.below(SIDE));
        let draws = CameraDraws { film: [numbers.unit(), numbers.unit()], lens: [numbers.unit(), numbers.unit()] };
        let got = camera_ray(&camera, x, y, &draws).direction.as_dvec3();
        let error = (got - double::camera::camera_ray(&camera, x, y, &draws).direction).length();
        if worse(error, worst) {
            worst = error;
            at = format!("focus {:.1e}, radius {:.1e}", desc.focus_distance, desc.aperture_radius);
        }
    }
    Ok(Outcome::at_most(worst, 1e-5)
        .tried(cases, "rays of lenses 1 to 1e6 focus distances wide, error in radians against f64")
        .note(at))
}

/// A camera placed by a matrix whose axes are longer or shorter sees the same.
fn scaled_matrices(effort: &Effort) -> Result<Outcome> {
    let cases = effort.cases(100_000);
    let mut numbers = Numbers::new(7);
    let mut worst: f64 = 0.0;
    for _ in 0..cases {
        let desc = oblique(&mut numbers, 50.0);
        let forward = (DVec3::from(desc.look_at) - DVec3::from(desc.position)).normalize();
        let right = forward.cross(DVec3::from(desc.up)).normalize();
        let up = right.cross(forward);
        let scale = numbers.magnitude(-6.0, 6.0);
        let eye = desc.position;
        let row = |i: usize| [right[i] * scale, up[i] * scale, -forward[i] * scale, eye[i]];
        let placed = CameraDesc { to_world: Some([row(0), row(1), row(2)]), ..desc };
        let camera = Camera::new(&placed, PixelFilter::Box, SIDE, SIDE);
        let (x, y) = (numbers.below(SIDE), numbers.below(SIDE));
        let film = [numbers.unit(), numbers.unit()];
        let ray = camera_ray(&camera, x, y, &draws(film));
        let wanted = wanted(&desc, f64::from(x as f32 + film[0]), f64::from(y as f32 + film[1]));
        let error = (ray.direction.as_dvec3() - wanted).length();
        worst = if worse(error, worst) { error } else { worst };
    }
    Ok(Outcome::at_most(worst, 4.0 * f64::from(f32::EPSILON))
        .tried(cases, "rays of matrices with axes of 1e-6 to 1e6, error in radians"))
}

/// Pixel filters put as many samples on either side of a pixel's centre, spread as they say: by 1/12 (box) and 1/6 (tent).
fn filters_are_centred(effort: &Effort) -> Result<Outcome> {
    let steps = effort.cases(65_536).min(1 << 22);
    let mut worst: f64 = 0.0;
    let desc = CameraDesc { vertical_fov: 90.0, ..CameraDesc::default() };
    for (filter, variance) in [(PixelFilter::Box, 1.0 / 12.0), (PixelFilter::Tent, 1.0 / 6.0)] {
        // Looks along -z, so that a direction's x / -z is linear in the film position.
        let camera = Camera::new(&desc, filter, 2, 2);
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..steps {
            let u = (i as f32 + 0.5) / steps as f32;
            let direction = camera_ray(&camera, 1, 1, &draws([u, 0.5])).direction.as_dvec3();
            let offset = direction.x / -direction.z - 0.5;
            sum += offset;
            squares += offset * offset;
        }
        let (mean, spread) = (sum / steps as f64, squares / steps as f64);
        worst = [mean.abs(), (spread / variance - 1.0).abs()]
            .into_iter()
            .fold(worst, |worst, error| if worse(error, worst) { error } else { worst });
    }
    Ok(Outcome::at_most(worst, 1e-4).tried(2 * steps, "film positions of box and tent, error of mean and variance"))
}

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = {
    use crate::fault::Fault::*;
    &[
        (ShiftedFilm, &["camera/narrow_views", "camera/wide_views", "camera/filters_are_centred"]),
        (DirectionNotUnit, &["camera/directions_are_unit", "camera/lens_focused_far_away", "camera/lens_wide_open"]),
        (WrongFocus, &["camera/lens_in_focus"]),
        (ScaledAxes, &["camera/scaled_matrices"]),
        (SilentLimits, &["camera/narrowest_views_are_told"]),
    ]
};
