//! The camera, pinhole or thin lens: computed in f64 once, used in f32 by both engines.
//!
//! A pinhole's ray through film position `(x, y)` (pixels, y downwards) has the direction `corner + right x + down y`,
//! normalised. That direction has length 1 along the axis (in camera space, where a matrix places the camera), so a thin
//! lens (pbrt-v4 section 5.2.3) is in focus where the pinhole's ray has the parameter `focus_distance`: a ray from lens
//! point `o` goes to `direction * focus_distance - o`.

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
    /// Distance of the plane in focus, scene units.
    pub focus_distance: f32,
}

impl Camera {
    /// The camera of `desc` (already validated) for a film of `width` x `height` square pixels; `vertical_fov` spans the
    /// height; image right is forward x up, or the first column of [`CameraDesc::to_world`].
    pub fn new(desc: &CameraDesc, filter: PixelFilter, width: u32, height: u32) -> Camera {
        let position = DVec3::from(desc.eye()) * if planted(Fault::EyeElsewhere) { 1.001 } else { 1.0 };
        let [forward, right, down] = axes(desc);
        // libm, not the platform's tan: the camera must have the same bits everywhere.
        let pixel = 2.0 * libm::tan(0.5 * desc.vertical_fov.to_radians()) / height as f64;
        let corner = forward - right * (0.5 * width as f64 * pixel) - down * (0.5 * height as f64 * pixel);
        Camera {
            origin: position.as_vec3().to_array(),
            corner: corner.as_vec3().to_array(),
            right: (right * pixel).as_vec3().to_array(),
            down: (down * pixel).as_vec3().to_array(),
            lens: (desc.aperture_radius > 0.0).then(|| Lens {
                right: (right * desc.aperture_radius).as_vec3().to_array(),
                up: (-down * desc.aperture_radius).as_vec3().to_array(),
                focus_distance: desc.focus_distance as f32,
            }),
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
