//! Measuring: what is compared, the truth it is compared with, and the runs.
//!
//! **Law:** nothing here draws a conclusion or writes a page.

pub mod closed_form;
pub mod experiment;
pub mod flip;
pub mod machine;
pub mod metrics;
pub mod parts;
pub mod reference;
pub mod run_error;
pub mod spectrum;
pub mod truth;
