//! A file being read: what its JSON says, and the bytes that it points at.

use super::buffers::Buffers;
use crate::error::Error;
use gltf::json::Root;
use std::fmt::Display;
use std::path::Path;

/// A file, its references checked.
pub struct File<'a> {
    /// Its path.
    pub path: &'a Path,
    /// Its JSON.
    pub root: Root,
    /// Its buffers.
    pub buffers: Buffers,
}

impl File<'_> {
    /// An error that blames `place`, a path into the JSON.
    pub fn fault(&self, place: impl Display, why: impl Display) -> Error {
        Error::parse(self.path, None, format!("{place}: {why}"))
    }
}
