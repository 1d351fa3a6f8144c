//! TOML scene files.

pub mod lights;
pub mod parse;
pub mod reader;
