//! The packet engine: tables of paths, and stages that loop over them eight lanes at a time.
//!
//! **Law:** every stage reads some queues and appends to others; what happens next to a path is decided by the queue it is
//! put in. A lane's result depends on its own path alone, so the order of a queue never changes a picture. Nothing here
//! names `reference`: that the two agree, bit for bit, is what the tests prove.
//!
//! One tile of paths goes through `generate_camera_rays -> { intersect_closest -> sort_hits -> shade_miss | shade_emitter |
//! shade_surface (density kinds) | shade_specular (delta kinds) -> intersect_shadow }` until no path is left. [`decisions`]
//! are the facts that stages read, [`plan`] is the list that [`tile`] runs, [`explain`] says the same in prose.
//!
//! The folder `kernels` (stages, materials, lights) is compiled once a SIMD level, as part of [`crate::simd`].

pub mod context;
pub mod counters;
pub mod decisions;
pub mod explain;
pub mod layers;
pub mod plan;
pub mod queues;
pub mod tile;
pub mod trace;
