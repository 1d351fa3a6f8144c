//! What is learned before a render begins: a training render (the pilot) finds out which lights matter where.
//!
//! **What.** The light tree's importances know distances and angles, but neither walls nor what a surface makes of the light. So
//! for a cell of the scene and the face of a surface in it (of a glossy one: where it mirrors the viewer to) the columns of the
//! tree's root and of its child nodes are weighed by what their samples were worth: the root of the mean square of the
//! contribution over what the importance had promised, blocked samples being worth 0. The root mean square, not the mean, nor
//! visibility: choosing in proportion to it makes the variance of the choice least (error per time on a hall of 2,000 lamps
//! 1.75 times better against 1.57 by the mean and 0.93 by visibility). These factors are bytes, at least 1/32 of the largest:
//! [`crate::tables::lights::learned`].
//!
//! An environment map is a light of many parts, of which a place behind a window sees few: so 128 patches of it are weighed in the
//! same way ([`patches`]), as [`crate::tables::lights::patches`] says.
//!
//! Learning where light comes from goes back to Vevoda, Kondapaneni and Krivanek ("Bayesian Online Regression for Adaptive
//! Direct Illumination Sampling", SIGGRAPH 2018); learned visibility to Guo, Eisemann and Eisemann ("Next Event Estimation++",
//! 2020), which [`visibility`] is a variant of, for comparison.
//!
//! **Laws.**
//!
//! 1. A picture depends on its recipe alone. Tables are a function of scene, camera, film size, strategy, depths, sampler, seed
//!    and the length of the training (those of a frame also of the cameras of the frames before it, of as many whatever is
//!    rendered: [`crate::render::sequence`]); never of samples a pixel, crop, time limit, resume, threads or engine. So the
//!    pilot goes over a grid of its own on the whole film ([`pilot`]), with fixed numbers of samples, and its image is thrown
//!    away.
//! 2. Its random numbers are scrambled by a seed of its own ([`pilot::SCRAMBLE`]): no sample of the picture has shaped its own
//!    density, so the picture is unbiased.
//! 3. Tables are frozen while a pass runs. Choosing a light and the density of having chosen it look up the same word.
//! 4. Order leaves no trace: records are integers ([`records`]), added up in any order; none is dropped.
//! 5. Whatever can contribute keeps a probability: factors have a floor ([`crate::tables::lights::learned::LEAST_FACTOR`]).
//! 6. A [`forecast`] says whether it pays. Where it does not, the render does without, and only the pilot's time is lost; that
//!    time counts as time of rendering.

pub mod build;
pub mod forecast;
pub mod guide;
pub mod outcome;
pub mod patches;
pub mod pilot;
pub mod records;
pub mod visibility;
