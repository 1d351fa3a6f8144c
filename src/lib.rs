//! octray: a data-oriented path tracer that follows eight paths at a time.
//!
//! It renders triangle scenes with next event estimation and multiple importance sampling, and it can prove that its fast
//! engine computes what a plain one computes: the same picture, bit for bit.
//!
//! ```no_run
//! fn main() -> octray::Result<()> {
//!     let scene = octray::Scene::load("scenes/cornell.toml")?;
//!     let prepared = scene.prepare()?;
//!     let settings = octray::Settings { spp: 16, ..scene.settings() };
//!     let render = octray::render(&prepared, &settings);
//!     println!("{} rays in {:.2} s", render.stats.rays.total(), render.stats.render_s);
//!     render.film.save("cornell.exr")
//! }
//! ```
//!
//! # The house
//!
//! Data flows one way, from files to tables to queues to the film:
//!
//! ```text
//! scene file --load--> SceneDesc --prepare--> PreparedScene (immutable tables, BVH)
//!                                                  |  + Settings = Setup --> Plan: the stages this render needs
//!                                                  v
//!   tile of paths: generate_camera_rays
//!                  { intersect_closest -> sort_hits -> shade_miss | shade_emitter | shade_diffuse | shade_mirror
//!                    -> intersect_shadow }  until no path is left
//!                                                  |
//!                                                  v
//!                                   Film (f64 sums, in sample order) --> image files, statistics
//! ```
//!
//! | room | what is in it |
//! | --- | --- |
//! | [`scene`] | files to [`scene::SceneDesc`] to [`PreparedScene`]; the light table, the environment map |
//! | [`bvh`] | tree of eight children a node, and the walks through it; all give the same bits |
//! | [`packet`] | the fast engine: SoA queues, stages over eight lanes, the plan |
//! | [`mod@reference`] | the plain engine: one path at a time, compiled for `f32` and for `f64` |
//! | [`mod@render`] | threads over tiles, passes over samples; which engine |
//! | [`setup`] | one render, resolved: what both engines are told |
//! | [`sampler`] | (pixel, sample, block, seed) to random numbers, for one path and for eight |
//! | [`lanes`], [`math`] | eight `f32`; the exactly rounded operations both engines are made of |
//! | [`film`], [`image`], [`color`] | sums, files, the sRGB curve |
//! | [`settings`], [`camera`], [`stats`], [`clock`], [`fingerprint`], [`error`] | what their names say |
//! | `report` | error against run time: metrics, statistics, plots, pages (feature `cli`) |
//! | `cli` | one file a command (feature `cli`) |
//!
//! Layers, top to bottom, nothing imports upwards (a test reads the sources): `cli > report > render > {packet, reference} >
//! {setup, scene, bvh, film, image, camera, stats} > {settings, sampler, lanes, math, color, error, clock, fingerprint}`.
//!
//! # Invariants
//!
//! - `packet` and `reference` never name each other. They share the prepared scene, the sample numbers, `math` and the film;
//!   every formula is written twice, and tests demand equal bits.
//! - Whatever can change a picture is made of `+ - * / sqrt`, comparisons and integer operations, in a stated order: no fused
//!   multiply-add, no platform `sin`, no approximate reciprocal. So no bit depends on the SIMD level of the build.
//! - A random number is a function of (pixel, sample, dimension, seed), never of what was drawn before it.
//! - A hit is a function of the ray and the triangles alone: the closest, on equal `t` the lowest id. Tree and walk never
//!   change it.
//! - A pixel's sums are added in sample order: threads, tiles and passes leave no trace.
//! - A sample that is not finite never reaches the film: it is counted and reported with the stage where it arose.
//! - Bad input ends in one error that names file, line and remedy; no text makes loading panic.
//!
//! # Numbers
//!
//! Lengths are in scene units, angles in radians (degrees in scene files), radiance in W sr^-1 m^-2 as linear Rec.709. A
//! density names its measure: `pdf_dir` is per steradian, `pdf_area` per square scene unit.
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod api;
pub mod bvh;
pub mod camera;
#[cfg(feature = "cli")]
pub mod cli;
pub mod clock;
pub mod color;
pub mod error;
pub mod film;
pub mod fingerprint;
pub mod image;
pub mod import;
pub mod lanes;
pub mod math;
pub mod nearest;
pub mod packet;
pub mod reference;
pub mod render;
#[cfg(feature = "cli")]
pub mod report;
pub mod sampler;
pub mod scene;
pub mod settings;
pub mod setup;
pub mod stats;
pub mod tables;
pub mod trace;

pub use api::Scene;
pub use error::{Error, Result};
pub use film::Film;
pub use render::{Render, render, render_from, render_with};
pub use settings::{Crop, Engine, Lights, Sampler, Settings, Strategy};
pub use tables::PreparedScene;

/// The examples of README.md, compiled with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
