//! The tables of all checks.

#[cfg(feature = "exr")]
use crate::check::exr_files;
use crate::check::item::{Check, SceneCheck};
use crate::check::{
    camera, directions, engines, environment, error_bars, film, geometry, lights, materials, mis, scale, subject,
    transport, yardstick,
};

/// The built-in suite, group after group.
pub const SUITE: &[&[Check]] = &[
    scale::CHECKS,
    lights::CHECKS,
    mis::CHECKS,
    transport::CHECKS,
    geometry::CHECKS,
    directions::CHECKS,
    materials::CHECKS,
    environment::CHECKS,
    camera::CHECKS,
    film::CHECKS,
    #[cfg(feature = "exr")]
    exr_files::CHECKS,
    error_bars::CHECKS,
    engines::CHECKS,
    yardstick::CHECKS,
];

/// What applies to a scene.
pub const OF_A_SCENE: &[&[SceneCheck]] = &[subject::CHECKS];
