//! The ladder, sixth rung: scenes from files, real ones, and shapes made to break an engine.

#[path = "../common/mod.rs"]
mod common;

mod hidden_lights;
mod loading;
mod real;
mod robust;
