//! From a [`SceneDesc`](crate::scene::SceneDesc) to the tables the engines read.
//!
//! **Law:** [`prepared`] derives every table once, in f64 where it matters; everything in them is finite and immutable
//! afterwards. It names the files of the single tables and they never name it; only [`lights::table`], which is made per
//! light selection, stands above it. Nothing here knows of engines, strategies or films.

pub mod alpha_masks;
pub mod corners;
mod duplicates;
pub mod emitter_facing;
pub mod features;
pub mod guide;
pub mod lights;
pub mod margins;
pub mod materials;
mod plastic_energy;
pub mod prepared;
pub mod scale_limits;
pub mod textures;
pub mod triangles;

pub use prepared::PreparedScene;
