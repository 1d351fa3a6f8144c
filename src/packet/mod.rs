//! The packet engine: tables of paths, and stages that loop over them eight lanes at a time.
//!
//! **Law:** every stage reads some queues and appends to others; what happens next to a path is decided by the queue it is
//! put in. A lane's result depends on its own path alone, so the order of a queue never changes a picture. Nothing here
//! names `reference`: that the two agree, bit for bit, is what the tests prove.
//!
//! One tile of paths goes through `generate_camera_rays -> { intersect_closest -> sort_hits -> shade_miss | shade_emitter |
//! shade_diffuse | shade_mirror | shade_conductor | shade_dielectric | shade_plastic -> intersect_shadow }` until no path is left; [`plan`] says which of these a render needs.

pub mod alpha_masks;
pub mod bsdf;
pub mod counters;
pub mod lights;
pub mod mis;
pub mod plan;
pub mod queues;
pub mod stages;
pub mod surface;
pub mod texture;
pub mod tile;
pub mod trace;
pub mod warp;
