//! Light sampling from one surface point.

use super::{
    INV_2PI, Real, Vec3, acos_half_turns, alpha_masks, atan2_turns, intersect, sin_cos_turns, surface, texture, vec3,
    warp,
};

pub mod choose;
pub mod environment;
pub mod sample;
pub mod tree;
pub mod triangle;
