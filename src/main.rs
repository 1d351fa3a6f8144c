//! The `octray` program; everything it does is in [`octray::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    octray::cli::main()
}
