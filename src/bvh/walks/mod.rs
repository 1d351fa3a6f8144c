//! The walks through the tree and the tests that they are made of: compiled once a SIMD level ([`crate::simd`]).

use super::here;

pub mod aim;
pub mod ask;
mod boxes;
pub mod packets;
mod sort;
mod triangle;
mod walk_flat;
mod walk_packet;
mod walk_single;
mod walk_stream;
