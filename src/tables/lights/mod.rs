//! What light sampling reads: emissive triangles, delta lights, the environment, and how to choose between them.

pub mod alias;
pub mod deltas;
pub mod emitters;
pub mod environment;
pub mod learned;
pub mod patches;
pub mod table;
pub mod targets;
pub mod tree;
pub mod unit;
pub mod visibility;
