//! Light sampling from one surface point.

use super::{
    INV_2PI, Real, Vec3, alpha_masks, atan2_turns, intersect, polar_half_turns, sin_cos_turns, surface, texture, vec3,
    warp,
};

pub mod choose;
pub mod delta;
pub mod environment;
pub mod factors;
pub mod light_sample;
pub mod sample;
pub mod tree;
pub mod triangle;
pub mod visibility;
