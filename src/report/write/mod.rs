//! Writing: findings as words, tables, plots, a page, CSV and JSON.
//!
//! **Law:** every figure written comes from what was measured or found; nothing is worked out here but how it looks.

pub mod contents;
pub mod figures;
pub mod heatmap;
pub mod images;
pub mod numbers;
pub mod page;
pub mod plot;
pub mod results;
pub mod tables;
pub mod words;
