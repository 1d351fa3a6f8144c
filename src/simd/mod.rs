//! What is chosen at run time by what the CPU can do.

mod level;

pub use level::{COMPILED, SimdLevel, VARIABLE};
