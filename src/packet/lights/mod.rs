//! Light sampling, eight surface points at a time.

pub mod environment;
pub mod sample;
pub mod tree;
pub mod triangle;
