//! Error against run time: how far pictures are from each other and from the truth, and what it costs to get there.
//!
//! **Law:** nothing here knows of flags, terminals or exit codes, and nothing here decides anything in a render. Metrics and
//! statistics are plain f64 on whole pictures, written from their definitions.

pub mod analysis;
pub mod closed_form;
pub mod equal_time;
pub mod experiment;
pub mod figures;
pub mod fingerprint;
pub mod heatmap;
pub mod machine;
pub mod measure;
pub mod metrics;
pub mod page;
pub mod plot;
pub mod reference;
pub mod results;
pub mod statistics;
pub mod words;
