//! OBJ meshes and their MTL materials.

pub mod choice;
pub mod corners;
pub mod encoding;
pub mod index_set;
pub mod libraries;
pub mod lines;
pub mod maps;
pub mod mesh;
pub mod mtl;
pub mod names;
pub mod point_tree;
pub mod sweep;
pub mod text;
pub mod triangulate;
pub mod vectors;
