//! The ladder, sixth rung: scenes from files, real ones, and shapes made to break an engine.

#[path = "../common/mod.rs"]
mod common;

/// The fuzz tests read files that ask for more memory than there is.
#[global_allocator]
static ALLOCATOR: octray::cli::allocator::Guarded = octray::cli::allocator::Guarded;

mod fuzz;
mod hidden_lights;
mod loading;
mod real;
mod robust;
