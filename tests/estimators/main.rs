//! The ladder, fifth rung: what the estimators come to, against closed forms and by statistics.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/program.rs"]
mod program;

mod chi_square;
mod heavy_tails;
mod learned;
mod materials;
mod plastic;
mod principled;
mod stiff_truth;
mod stopping;
mod strategies;

mod truth;
