//! From scene files to the tables the engines read.
//!
//! **Law:** data flows one way, `file -> SceneDesc -> PreparedScene`. [`load`] reads files and [`builtin`] makes scenes
//! in code; [`desc`] holds what a scene says and nothing derived; [`prepare`] derives every table once, in f64 where it
//! matters, and everything in them is finite. Nothing here knows of engines, strategies or films. No text, however odd,
//! makes loading panic: it ends in a [`SceneDesc`] or in one error that names file and line.

pub mod builtin;
pub mod corners;
pub mod cutouts;
pub mod desc;
pub mod environment;
mod facade;
pub mod light_tree;
pub mod lights;
pub mod load;
mod load_pictures;
pub mod margins;
pub mod material;
pub mod mtl;
pub mod nearest;
pub mod obj;
pub mod obj_text;
pub mod parse;
mod plastic_energy;
pub mod prepare;
pub mod reach;
pub mod sight;
pub mod textures;
pub mod toml_reader;
pub mod transform;
pub mod triangulate;
pub mod validate;

pub use desc::SceneDesc;
pub use facade::Scene;
pub use prepare::PreparedScene;
pub use validate::is_degenerate;
