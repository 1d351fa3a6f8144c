//! The ladder, second rung: kernels on lanes against their scalar twins, bit for bit.

#[path = "../common/mod.rs"]
mod common;

mod runner;
mod surfaces;
mod table;
mod twins;
