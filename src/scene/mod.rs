//! What a scene says: meshes and their instances, materials, camera, lights, and the rules they must keep.
//!
//! **Law:** [`desc`] holds what files and code say and nothing derived; [`flatten`] lists the triangles
//! of all instances in world space; [`validate`] is the one gate that every description
//! passes before tables are made of it. Nothing here reads files or knows of tables, engines, strategies or films.

pub mod builtin;
pub mod camera;
pub mod desc;
pub mod fingerprint;
pub mod flatten;
pub mod shapes;
pub mod studio;
pub mod transform;
pub mod validate;
pub(crate) mod warnings;

pub use desc::SceneDesc;
pub use validate::is_degenerate;
