//! From files to a [`SceneDesc`](crate::scene::SceneDesc).
//!
//! **Law:** no text, however odd, makes loading panic: it ends in a description or in one error that names file and line.
//! One folder a format; [`assembly`] puts together what they give. Nothing here knows of tables or engines.

/// How the names of scene files end; where several fit, in the order in which they are looked for.
pub const SCENE_FILES: [&str; 4] = ["toml", "obj", "gltf", "glb"];

pub mod assembly;
mod environment;
pub mod framing;
#[cfg(feature = "gltf")]
mod gltf;
mod images;
mod jpeg;
mod lamps;
pub mod obj;
mod pictures;
pub mod toml;
