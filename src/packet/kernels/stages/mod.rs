//! The stages: one verb, one loop over a queue each.

use super::here;

pub mod gather_layers;
pub mod generate_camera_rays;
pub mod intersect;
mod shade_common;
pub mod shade_emitter;
pub mod shade_miss;
pub mod shade_specular;
pub mod shade_surface;
pub mod sort_hits;
