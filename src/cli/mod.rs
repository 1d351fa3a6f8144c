//! The command line: one file per command.
//!
//! **Law:** results go to standard output, everything else to standard error. Exit status 0: done; 1: a check failed, the
//! picture was not finished or an output could not be written; 2: bad input or flags. Nothing below this folder prints.

mod args;
mod bench;
mod check;
mod converge;
mod cpu;
mod diff;
mod info;
mod interrupt;
mod output;
mod progress;
mod render;
mod resume;
mod stats;
mod trace;

use crate::api::Scene;
use crate::error::Result;
use crate::image::check_output_path;
use crate::lanes::simd_level;
use crate::tables::PreparedScene;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Parser, Subcommand};
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::sync::LazyLock;

static VERSION: LazyLock<String> = LazyLock::new(|| format!("{} {}", env!("CARGO_PKG_VERSION"), simd_level()));

/// A data-oriented SIMD packet path tracer.
#[derive(Parser)]
#[command(name = "octray", version = VERSION.as_str(), max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to image files
    Render(render::RenderArgs),
    /// What a scene holds and needs: tables, the plan, what was left out
    Info(info::InfoArgs),
    /// One path, vertex by vertex, in both engines
    Trace(trace::TraceArgs),
    /// Numerical checks: extreme and stiff cases against what is known, or those that apply to a scene
    Check(check::CheckArgs),
    /// Throughput of the engines, side by side
    Bench(bench::BenchArgs),
    /// Error against run time, for every strategy: a report, plots, tables
    Converge(Box<converge::ConvergeArgs>),
    /// How far picture A is from picture B, the reference
    Diff(diff::DiffArgs),
}

/// The whole program: parses the arguments of this process, runs the command, prints what went wrong.
pub fn main() -> ExitCode {
    // First of all, and by code that was compiled for any x86-64: the rest may use instructions this CPU lacks.
    match cpu::missing() {
        Some(missing) => refuse_cpu(missing),
        None => ExitCode::from(run()),
    }
}

#[cold]
#[inline(never)]
fn refuse_cpu(missing: &str) -> ExitCode {
    let mut stderr = std::io::stderr();
    let _ = stderr.write_all(b"error: this build of octray needs a CPU with ");
    let _ = stderr.write_all(missing.as_bytes());
    let _ = stderr.write_all(b"; build one for any x86-64: RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release\n");
    ExitCode::from(2)
}

#[inline(never)]
fn run() -> u8 {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return report_usage(&error),
    };
    let done = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Trace(args) => trace::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Converge(args) => converge::run(&args),
        Command::Diff(args) => diff::run(&args),
    };
    match done {
        Ok(status) => status,
        Err(error) => {
            report(&error);
            error.exit_status()
        }
    }
}

/// Help and versions go to standard output with status 0, wrong arguments to standard error with status 2.
fn report_usage(error: &clap::Error) -> u8 {
    // A closed standard output is no reason for another status.
    let _ = error.print();
    if error.kind() == ErrorKind::UnknownArgument
        && let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg)
        && !argument.starts_with('-')
        && check_output_path(Path::new(argument)).is_ok()
    {
        let _ =
            writeln!(std::io::stderr(), "\n  tip: images to write are named with -o, each with its own: -o {argument}");
    }
    error.exit_code() as u8
}

fn report(error: &impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "error: {error}");
}

/// [`Scene::prepare`], with what it warns of on stderr.
fn prepare(scene: &Scene) -> Result<PreparedScene> {
    let prepared = scene.prepare()?;
    prepared.warnings.iter().for_each(|warning| warn(warning));
    Ok(prepared)
}

fn warn(message: &str) {
    let _ = writeln!(std::io::stderr(), "warning: {message}");
}
