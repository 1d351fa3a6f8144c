//! Next event estimation by learned visibility, a variant for comparison ([`crate::Lights::NeePlusPlus`]): after Guo, Eisemann
//! and Eisemann, "Next Event Estimation++: Visibility Mapping for Efficient Light Transport Simulation" (Computer Graphics Forum
//! 39(7), 2020).
//!
//! **What.** A grid of voxels covers the scene, and for pairs of voxels it is known which part of the shadow rays between them is
//! free. Lights are chosen by this visibility times their importance, and a shadow ray that is likely to be blocked is traced
//! with a small probability only, by Russian roulette.
//!
//! **Choices.** Only what the paper's abstract says was at hand, so all of these are ours:
//!
//! 1. The grid has 16 cubic cells along the longest side of the scene ([`crate::tables::lights::learned::CELLS`]).
//! 2. A pair is the cell where the shadow ray starts and that of the point on the light. Only cells that boxes about emissive
//!    triangles reach into count as cells of lights. Both ways round a pair is one: if both cells hold emitters, the records of
//!    both add up. The environment has no place: its shadow rays are neither recorded nor ended.
//! 3. What is recorded are the shadow rays of the training render of `--lights learned` (same grid, same passes), no others: the
//!    map is not updated while the picture is rendered ([`crate::learn`], laws 1 to 3). While training, lights are chosen by what
//!    is known so far, and every shadow ray is traced.
//! 4. The visibility of a pair is (free + 1) / (traced + 1): unknown pairs count as visible, and none as invisible.
//! 5. The factor of a column of the light tree's root or of one of its child nodes is the mean of the visibilities of the emitters
//!    below it, each in the cell of its centroid, weighed by power; in 255ths of the largest of its node, at least 1/32 of that
//!    ([`crate::tables::lights::learned::LEAST_FACTOR`]). Normals and materials do not matter: all keys of a cell share a row.
//! 6. A shadow ray is traced with the visibility of its pair as probability, in 256ths, at least [`LEAST_SURVIVAL`]; always where
//!    fewer than [`LEAST_TRACED`] were recorded. Its contribution is divided by that. The densities that multiple importance
//!    sampling weighs by do not know of it, so weights are as without: either is unbiased.
//! 7. There is no forecast: the tables are used whatever they may bring. Where there is one light, roulette alone is left.

pub mod build;
pub mod records;

/// The least probability with which a shadow ray is traced. (At 64 samples, where the tree alone has an error of 24.8 % in
/// `builtin:rooms` and of 22.4 % in `builtin:lamp_hall`, the choice alone, without roulette, has 22.9 and 22.5 %; with a floor of
/// 1/2 it has 24.9 and 23.7 %, with 1/4 26.9 and 24.4 %, with 1/16 31.0 and 25.4 %: roulette pays for rays with variance.)
pub const LEAST_SURVIVAL: f64 = 1.0 / 16.0;
/// Pairs with fewer records say too little: all their shadow rays are traced.
pub const LEAST_TRACED: u64 = 8;
