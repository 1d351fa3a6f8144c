//! From scene files to the tables the engines read.
//!
//! **Law:** data flows one way, `file -> SceneDesc -> PreparedScene`. [`desc`] holds what a scene says and nothing derived;
//! [`prepare`] derives every table once, in f64 where it matters, and everything in them is finite. Nothing here knows of
//! engines, strategies or films.

pub mod desc;
pub mod lights;
pub mod validate;
pub mod prepare;

pub use desc::SceneDesc;
pub use prepare::PreparedScene;
