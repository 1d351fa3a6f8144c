//! Light sampling, eight surface points at a time.

use super::here;

pub mod choose;
pub mod delta;
pub mod environment;
pub mod factors;
pub mod learn;
pub mod light_sample;
pub mod sample;
pub mod tree;
pub mod triangle;
pub mod visibility;
