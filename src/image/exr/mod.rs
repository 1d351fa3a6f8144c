//! OpenEXR files, if this build can read and write them (feature `exr`).

#[cfg(not(feature = "exr"))]
mod absent;
#[cfg(feature = "exr")]
mod attributes;
#[cfg(feature = "exr")]
mod read;
#[cfg(feature = "exr")]
mod write;

#[cfg(not(feature = "exr"))]
pub(super) use absent::{read, write};
#[cfg(feature = "exr")]
pub(super) use {read::read, write::write};

use crate::film::Encoding;
use crate::image::Windows;

/// What a file says besides its pixels.
#[cfg_attr(not(feature = "exr"), expect(dead_code, reason = "nothing writes files"))]
pub(super) struct Header<'a> {
    /// Columns and rows.
    pub(super) size: (u32, u32),
    /// As [`crate::image::Image::metadata`].
    pub(super) metadata: &'a [(String, String)],
    /// As [`crate::image::Image::windows`].
    pub(super) windows: Option<Windows>,
    /// Names of the channels.
    pub(super) channels: Vec<&'static str>,
    /// How numbers are held.
    pub(super) encoding: Encoding,
}

/// Radiance.
pub(super) const COLOR: [&str; 3] = ["R", "G", "B"];
/// The variance of each pixel's mean.
pub(super) const VARIANCE: [&str; 3] = ["variance.R", "variance.G", "variance.B"];

/// Gives the values of all channels, in the order of [`Header::channels`], at a column of a row.
pub(super) type Pixels<'a> = &'a (dyn Fn(u32, u32, &mut [f32]) + Sync);
