//! Learning where light comes from, for directions and roulette: path guiding.
//!
//! **What.** At diffuse surfaces half of the directions are drawn from a histogram of where paths have found light, by place and
//! normal; the density of the mixture is known everywhere, so that multiple importance sampling goes on as before, and what
//! light samples find well is left out of the histogram by their weights. Cells are leaves of a binary tree over Morton codes
//! that splits where many paths pass; each of the six faces of the normal has a tree of its own (error 6.9 times less than
//! without guiding on a room lit through a door ajar, with one tree for all 4.0), and what is learned is radiance times
//! cosine (radiance alone: 5.6). Histograms are cut by a quad tree that only divides what holds a hundredth of its leaf.
//!
//! Roulette must not end the paths that guiding has just found: with [`crate::settings::Roulette::Learned`] it goes by the product
//! of albedos, and by what the rest of the path is expected to bring to its pixel, whichever is more (Vorba and Krivanek,
//! "Adjoint-Driven Russian Roulette and Splitting in Light Transport Simulation", SIGGRAPH 2016): it only ever keeps more paths.
//!
//! **When.** A picture is guided if what its paths bring after their bounces is much and rarely met
//! ([`crate::learn::pilot::LEAST_INDIRECT`]), as unguided passes tell; in it, the leaves in which the mixture has the smaller second
//! moment.
//!
//! Guiding by adaptive trees goes back to Mueller, Gross and Novak ("Practical Path Guiding", EGSR 2017); learning what a path
//! still gains after each of its bounces, to the same.
//!
//! **Laws** are those of [`crate::learn`]: integers, added up in any order; tables frozen during a pass; nothing of the picture.

pub mod build;
pub mod pixels;
pub mod records;
pub mod steps;
pub mod training;
pub mod window;
