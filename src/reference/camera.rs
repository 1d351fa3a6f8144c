//! Camera rays.

use super::intersect::Ray;
use super::warp::sample_uniform_disk;
use super::{Real, vec3};
use crate::camera::Camera;
use crate::fault::{Fault, planted};
use crate::sampler::draws::CameraDraws;
use crate::scene::desc::PixelFilter;

/// The ray through a point of pixel (`x`, `y`).
pub fn camera_ray(camera: &Camera, x: u32, y: u32, draws: &CameraDraws<f32>) -> Ray {
    // The film position is rounded to f32 in every copy of the reference: it is part of the sample's address.
    let film_x = (x as f32 + offset_in_pixel(camera.filter, draws.film[0])) as Real;
    let film_x = if planted(Fault::ShiftedFilm) { film_x + 1.5 } else { film_x };
    let film_y = (y as f32 + offset_in_pixel(camera.filter, draws.film[1])) as Real;
    let mut origin = vec3(camera.origin);
    let mut direction = vec3(camera.corner) + vec3(camera.right) * film_x + vec3(camera.down) * film_y;
    if let Some(lens) = &camera.lens {
        let [x, y] = sample_uniform_disk(draws.lens.map(|u| u as Real));
        let on_lens = vec3(lens.right) * x + vec3(lens.up) * y;
        origin += on_lens;
        let focus_distance = lens.focus_distance as Real * if planted(Fault::WrongFocus) { 1.01 } else { 1.0 };
        direction = direction * focus_distance - on_lens * lens.scale as Real;
    }
    let direction = direction * (1.0 / direction.dot(direction).sqrt());
    let longer = planted(Fault::DirectionNotUnit) && camera.lens.is_some() && Real::EPSILON > 1e-10;
    let direction = if longer { direction * 1.001 } else { direction };
    Ray { origin, direction, tmin: 0.0, tmax: Real::INFINITY }
}

/// Where in (or, for the tent, about) its pixel a sample lies, from a number in [0, 1): 0.5 is the centre.
fn offset_in_pixel(filter: PixelFilter, u: f32) -> f32 {
    match filter {
        PixelFilter::Box => u,
        // The inverse of the tent's distribution function.
        PixelFilter::Tent if u < 0.5 => (2.0 * u).sqrt() - 0.5,
        PixelFilter::Tent => 1.5 - (2.0 - 2.0 * u).sqrt(),
    }
}
