//! Scene loading: every rule of the scene format, every fault with its line, and no text that makes it panic.

#[path = "loading/common.rs"]
mod common;
#[path = "loading/descriptions.rs"]
mod descriptions;
#[path = "loading/environments.rs"]
mod environments;
#[path = "loading/materials.rs"]
mod materials;
#[path = "loading/meshes.rs"]
mod meshes;
#[path = "loading/never_panics.rs"]
mod never_panics;
#[path = "loading/scene_files.rs"]
mod scene_files;
#[path = "loading/shipped.rs"]
mod shipped;
#[path = "loading/triangulation.rs"]
mod triangulation;
