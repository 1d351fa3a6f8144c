//! TOML scene files.

pub mod parse;
pub mod reader;
