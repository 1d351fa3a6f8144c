//! The camera, pinhole or thin lens: computed in f64 once, used in f32 by both engines.
//!
//! A pinhole's ray through film position `(x, y)` (pixels, y downwards) has the direction `corner + right x + down y`,
//! normalised. That direction has length 1 along the axis (in camera space, where a matrix places the camera), so a thin
//! lens (pbrt-v4 section 5.2.3) is in focus where the pinhole's ray has the parameter `focus_distance`: a ray from lens
//! point `o` goes to `direction * focus_distance - o`.
//!
//! Rays are normalised by the root of a sum of squares in f32. Where a field of view of nearly 180 degrees or a plane in focus
//! far away would make those overflow (or a near one vanish), all of it is scaled by a power of two, which changes no direction
//! and, everywhere else, no bit.

use crate::fault::{Fault, planted};
use crate::scene::desc::{CameraDesc, PixelFilter};
use glam::DVec3;

/// A camera for one film size.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// The eye, in scene units.
    pub origin: [f32; 3],
    /// Direction to the film's top left corner (not normalised).
    pub corner: [f32; 3],
    /// What one pixel to the right adds to the direction.
    pub right: [f32; 3],
    /// What one pixel downwards adds to the direction.
    pub down: [f32; 3],
    /// Unit direction along its axis.
    pub axis: [f32; 3],
    /// The lens, if it is not a pinhole.
    pub lens: Option<Lens>,
    /// How samples are spread about a pixel's centre.
    pub filter: PixelFilter,
}

/// A thin lens.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// Rightwards, as long as the aperture's radius.
    pub right: [f32; 3],
    /// Upwards, as long as the aperture's radius.
    pub up: [f32; 3],
    /// What the pinhole's direction is multiplied by: the distance of the plane in focus, scene units, times
    /// [`Lens::scale`], over the scale of the camera's directions.
    pub focus_distance: f32,
    /// What the lens point is multiplied by before it is subtracted: a power of two, and 1 but for extreme lenses.
    pub scale: f32,
}

/// The largest sum of lengths that directions are made of, and one over the smallest: their squares stay far from the ends of
/// f32.
const ORDINARY: f64 = 1_099_511_627_776.0; // 2^40

/// The angle of a pixel, radians, below which there is a warning: directions are f32, and where the view is oblique to the axes
/// they are then off by up to 0.38 pixels, 0.09 on average (3,000 random views; building them as the forward direction and small
/// offsets would give 0.31 and 0.08: what is lost is lost by any f32 direction).
pub const LEAST_PIXEL_ANGLE: f64 = 1.0 / 4_194_304.0; // 2^-22

/// What the user should know of this camera with a film of `height` rows, one sentence each.
pub fn warnings(desc: &CameraDesc, height: u32) -> Vec<String> {
    let [forward, right, down] = axes(desc).map(DVec3::length);
    let angle = pixel_length(desc, height) * right.min(down) / forward;
    let warning = || {
        format!(
            "a pixel is {angle:.1e} rad large; below {LEAST_PIXEL_ANGLE:.1e} (2^-22) f32 directions that are oblique to the axes \
             shift pictures by up to {:.1} pixels: use a larger vertical_fov and move the camera nearer",
            0.4 * LEAST_PIXEL_ANGLE / angle
        )
    };
    (angle < LEAST_PIXEL_ANGLE && !planted(Fault::SilentLimits)).then(warning).into_iter().collect()
}

/// The side of a pixel on a film at distance 1.
fn pixel_length(desc: &CameraDesc, height: u32) -> f64 {
    // libm, not the platform's tan: the camera must have the same bits everywhere.
    2.0 * libm::tan(0.5 * desc.vertical_fov.to_radians()) / height as f64
}

/// 1 where `least` to `most` are ordinary, else the power of two that brings `most` near 1, as far as f32 has it.
fn power_of_two(least: f64, most: f64) -> f64 {
    if least >= 1.0 / ORDINARY && most <= ORDINARY {
        return 1.0;
    }
    let exponent = (most.to_bits() >> 52) as i64 - 1023;
    f64::from_bits(((-exponent).clamp(-126, 126) + 1023) as u64 * (1 << 52))
}

impl Camera {
    /// The same view, lens and all, on a film of `grid` (columns, rows) instead of `film` pixels, which need not be square.
    pub fn on_grid(&self, film: (u32, u32), grid: (u32, u32)) -> Camera {
        let stretched = |step: [f32; 3], film: u32, grid: u32| step.map(|x| x * (film as f32 / grid as f32));
        let right = stretched(self.right, film.0, grid.0);
        Camera { right, down: stretched(self.down, film.1, grid.1), ..*self }
    }

    /// The camera of `desc` (already validated) for a film of `width` x `height` square pixels; `vertical_fov` spans the
    /// height; image right is forward x up, or the first column of [`CameraDesc::to_world`].
    pub fn new(desc: &CameraDesc, filter: PixelFilter, width: u32, height: u32) -> Camera {
        let position = DVec3::from(desc.eye()) * if planted(Fault::EyeElsewhere) { 1.001 } else { 1.0 };
        let [forward, right, down] = axes(desc);
        let pixel = pixel_length(desc, height);
        let corner = forward - right * (0.5 * width as f64 * pixel) - down * (0.5 * height as f64 * pixel);
        // Its half diagonal bounds every direction to the film but for the forward part.
        let longest = corner.length() + forward.length();
        let unit = power_of_two(1.0, longest);
        let lens = |aperture: f64| {
            let focus = desc.focus_distance * longest;
            let scale = power_of_two(focus, focus.max(aperture * right.length().max(down.length())));
            Lens {
                right: (right * aperture).as_vec3().to_array(),
                up: (-down * aperture).as_vec3().to_array(),
                focus_distance: (desc.focus_distance * scale / unit) as f32,
                scale: scale as f32,
            }
        };
        Camera {
            origin: position.as_vec3().to_array(),
            corner: (corner * unit).as_vec3().to_array(),
            right: (right * pixel * unit).as_vec3().to_array(),
            down: (down * pixel * unit).as_vec3().to_array(),
            axis: forward.normalize().as_vec3().to_array(),
            lens: (desc.aperture_radius > 0.0).then(|| lens(desc.aperture_radius)),
            filter,
        }
    }
}

/// Forward, the image's right and its down, each one unit of camera space long.
fn axes(desc: &CameraDesc) -> [DVec3; 3] {
    if let Some(rows) = &desc.to_world {
        let column = |i: usize| DVec3::from(rows.map(|row| row[i]));
        if planted(Fault::ScaledAxes) {
            return [-column(2).normalize(), column(0), -column(1)];
        }
        return [-column(2), column(0), -column(1)];
    }
    let forward = (DVec3::from(desc.look_at) - DVec3::from(desc.position)).normalize();
    let right = forward.cross(DVec3::from(desc.up)).normalize();
    [forward, right, forward.cross(right)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_lie_where_the_field_of_view_says() {
        let desc = CameraDesc {
            position: [1.0, 2.0, 3.0],
            look_at: [1.0, 2.0, 0.0],
            up: [0.0, 1.0, 0.0],
            vertical_fov: 90.0,
            ..CameraDesc::default()
        };
        let camera = Camera::new(&desc, PixelFilter::Box, 20, 10);
        let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        // Looking along -z with 90 degrees over the height: the top edge rises at 45 degrees; right is +x.
        assert!(close(camera.corner, [-2.0, 1.0, -1.0]), "{camera:?}");
        assert!(close(camera.right, [0.2, 0.0, 0.0]) && close(camera.down, [0.0, -0.2, 0.0]), "{camera:?}");
    }
}
