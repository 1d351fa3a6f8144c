//! The ladder, second rung: kernels on lanes against their scalar twins, bit for bit.

mod runner;
mod table;
mod twins;
