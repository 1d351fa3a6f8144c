//! The stages: one loop over a queue each.

pub mod generate_camera_rays;
mod shade_common;
pub mod shade_emitter;
pub mod shade_glossy;
pub mod shade_miss;
pub mod shade_surface;
pub mod sort_hits;
