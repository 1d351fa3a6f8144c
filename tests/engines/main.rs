//! The ladder, fourth rung: the packet engine against the scalar reference and both against recorded pictures, bit for
//! bit, with each feature of scenes that both know.

#[path = "../common/mod.rs"]
mod common;

mod camera;
mod camera_extremes;
mod cutouts;
mod environment;
mod general_plan;
mod golden;
mod guide;
mod layers;
mod learned;
mod light_tree;
mod patches;
mod paths;
mod polar_rows;
mod power;
mod sequence;
mod smooth;
mod solid_angle;
mod sums;
mod textures;
mod visibility;
