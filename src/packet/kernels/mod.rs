//! Everything that stages do to lanes: compiled once a SIMD level ([`crate::simd`]).

use super::here;

pub mod alpha_masks;
pub mod bsdf;
pub mod columns;
pub mod guide;
pub mod lights;
pub mod mis;
pub mod records;
pub mod stages;
pub mod surface;
pub mod texture;
pub mod variants;
pub mod warp;
