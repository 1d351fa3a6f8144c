//! octray (crate docs follow)
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod bvh;
pub mod camera;
#[cfg(feature = "cli")]
pub mod cli;
pub mod clock;
pub mod color;
pub mod error;
pub mod film;
pub mod image;
pub mod lanes;
pub mod math;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod settings;
pub mod setup;
pub mod stats;
pub mod trace;

pub use error::{Error, Result};
pub use film::Film;
pub use render::{Render, render, render_with};
pub use scene::{PreparedScene, Scene};
pub use settings::{Crop, Engine, Lights, Sampler, Settings, Strategy};
pub mod packet;
pub mod reference;

/// The examples of README.md, compiled with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
