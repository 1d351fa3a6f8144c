//! Scene loading: every rule of the scene format, every fault with its line, and no text that makes it panic.

mod common;
mod descriptions;
mod environments;
mod foreign_images;
mod gltf;
mod growth;
mod instances;
mod lights;
mod materials;
mod meshes;
mod never_panics;
mod pictures;
mod placing;
mod scene_files;
mod shipped;
mod triangulation;
mod wild_losses;
mod wild_obj;
