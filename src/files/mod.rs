//! Files as bytes, and the memory they may take: read only where they are what they say, written whole or not at all.

pub mod atomic;
pub mod memory;
pub mod read;
pub mod sealed;
