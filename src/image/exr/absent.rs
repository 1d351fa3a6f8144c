//! What a build without OpenEXR says when it is asked for it.

use crate::files::atomic::Sink;
use crate::image::exr::{Header, Pixels};
use crate::image::{Image, NO_EXR};
use std::io;

/// Writes nothing.
pub(in super::super) fn write(_: &Header, _: Pixels, _: &mut dyn Sink) -> io::Result<()> {
    Err(io::Error::new(io::ErrorKind::Unsupported, NO_EXR))
}

/// Reads nothing.
pub(in super::super) fn read(_: &[u8]) -> std::result::Result<Image, String> {
    Err(NO_EXR.into())
}
