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
//! Whatever it was built for, the inner loops use the best SIMD instructions that the CPU has ([`SimdLevel`]); pictures do not
//! depend on it.
//!
//! # The house
//!
//! Data flows one way, from files to tables to queues to the film:
//!
//! ```text
//! files --import--> SceneDesc --tables--> PreparedScene (immutable tables, BVH)
//!                                             |  + Settings = Setup --> Decisions --> Plan: the stages this render runs
//!                                             v
//!   tile of paths: generate_camera_rays
//!                  { intersect_closest -> sort_hits -> shade_miss | shade_emitter | shade_surface (a queue and a copy for each
//!                    kind with a density) | shade_specular (each kind with delta lobes) -> intersect_shadow }
//!                  until no path is left
//!                                             |
//!                                             v
//!                              Film (f64 sums, in sample order) --> image files, statistics, reports
//! ```
//!
//! What is not listed on this page is internal: the rooms below are modules of `octray::internal`, for this package's own tests
//! and benches, and change without notice.
//!
//! | room | what is in it |
//! | --- | --- |
//! | [`scene`] | what a scene says: descriptions, the gate that checks them, scenes made in code |
//! | `import` | files to [`scene::SceneDesc`] |
//! | `tables` | [`scene::SceneDesc`] to `PreparedScene`; the table of material kinds; lights |
//! | `bvh` | tree of eight children a node, and the walks through it (`walks`: once a SIMD level; `sixteen`: AVX-512); all give the same bits |
//! | `strategy` | one row a strategy: what its samples count |
//! | `setup` | one render, resolved: what both engines are told |
//! | `learn` | what a training render finds out about lights and directions before a render begins; its laws |
//! | `packet` | the fast engine: SoA queues, the plan, stages over eight lanes (`kernels`: once a SIMD level) |
//! | `reference` | the plain engine: one path at a time, compiled for `f32` and for `f64` |
//! | `render` | threads over tiles, passes over samples, one for layers; which engine; sequences of frames |
//! | `sampler` | (pixel, sample, block, seed) to named random numbers, for one path and for eight |
//! | `simd` | which SIMD level is used, chosen at run time; the engine's inner loops, compiled once a level |
//! | `lanes`, `math` | eight `f32`; the exactly rounded operations both engines are made of |
//! | `film`, `image`, `color` | sums, layers, checkpoints and parts, image files (OpenEXR: feature `exr`), the sRGB curve |
//! | `files`, `shown` | files as bytes: read where they are regular and fit into memory, written whole or not at all, sealed by a checksum; their text as messages may show it |
//! | `api` | load a scene, prepare it, ask its triangles about rays |
//! | [`check`] | what `octray check` measures: extreme and stiff cases against closed forms and f64, with bounds |
//! | `fault` | faults that unit tests plant, so that every check is known to fail |
//! | `settings`, `camera`, `stats`, `trace`, `clock`, `fingerprint`, `nearest`, `named_choice`, `error` | what their names say |
//! | `report` | error against run time: measured, analysed, written (feature `cli`) |
//! | `cli` | one file a command (feature `cli`) |
//!
//! Layers, top to bottom, nothing imports upwards and no files form a circle (a test reads the sources): `cli > {report, check} >
//! {render, api} > {packet, reference} > {import, setup, learn, film, image, camera, stats, trace} > tables > {scene, bvh} >
//! {settings, strategy, sampler, lanes, simd, math, color, error, clock, fault, files, fingerprint, nearest, named_choice, shown}`.
//!
//! A material kind is a row in `tables::materials::TABLE`, a file in `packet/kernels/bsdf` and one in `reference/bsdf` (each with
//! its line in the folder's `mod.rs`), and what files say of it in `import`. A strategy is a row in `strategy::TABLE`.
//!
//! # Invariants
//!
//! - `packet` and `reference` never name each other. They share the prepared scene, the sample numbers, `math` and the film;
//!   every formula is written twice, and tests demand equal bits.
//! - Whatever can change a picture is made of `+ - * / sqrt`, comparisons and integer operations, in a stated order: no fused
//!   multiply-add, no platform `sin`, no approximate reciprocal. So no bit depends on the SIMD level.
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

pub mod check;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod internal;
#[cfg(feature = "cli")]
pub mod report;
pub mod scene;

// Inside the crate a room is named without the house.
use internal::{
    api, bvh, camera, clock, color, error, fault, files, film, fingerprint, image, import, lanes, learn, math,
    named_choice, nearest, packet, reference, render, sampler, settings, setup, shown, simd, stats, strategy, tables,
    trace,
};

pub use api::Scene;
pub use bvh::{HitPacket, HitQueue, RayPacket, RayQueue};
pub use error::{Error, Result};
pub use files::memory::{max_memory, set_max_memory};
pub use film::layers::{LayerPixel, Layers};
pub use film::{Encoding, Film};
pub use lanes::{F32x8, Mask8, U32x8, Vec3x8};
pub use render::sequence::Sequence;
pub use render::{Progress, Render, Watch, render, render_from, render_with, try_render, try_render_from};
pub use settings::{Crop, Engine, Guide, Layer, Lights, PlanChoice, Roulette, Sampler, Settings, Shard, Train};
pub use simd::{SimdLevel, simd_level};
pub use stats::{RayCounts, StageStats, Stats};
pub use strategy::Strategy;
pub use tables::PreparedScene;

/// The examples of README.md, compiled with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
