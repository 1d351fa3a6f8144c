//! OBJ meshes and their MTL materials.

pub mod corners;
pub mod index_set;
pub mod libraries;
pub mod lines;
pub mod mesh;
pub mod mtl;
pub mod point_tree;
pub mod text;
pub mod triangulate;
pub mod vectors;
