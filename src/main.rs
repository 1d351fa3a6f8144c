//! The `octray` program; everything it does is in [`octray::cli`].

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: octray::cli::allocator::Guarded = octray::cli::allocator::Guarded;

fn main() -> ExitCode {
    octray::cli::main()
}
