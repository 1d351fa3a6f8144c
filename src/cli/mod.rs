//! The command line: one file per command.
//!
//! **Law:** results go to standard output, everything else to standard error. Exit status 0: done; 1: a check failed, the
//! image was not finished or an output could not be written; 2: bad input or flags. Nothing below this folder prints.

pub mod allocator;
mod args;
mod bench;
mod check;
mod converge;
mod cpu;
mod diff;
mod examples;
mod frames;
mod info;
mod interrupt;
mod keep;
mod layers;
mod merge;
mod messages;
mod numbers;
mod output;
mod places;
mod progress;
mod render;
mod resume;
mod shell;
mod stats;
mod suggest;
mod trace;
mod view;

use crate::api::Scene;
use crate::error::Result;
use crate::files::memory::set_max_memory;
use crate::shown::shown;
use crate::simd::{SimdLevel, simd_level};
use crate::tables::PreparedScene;
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};
use messages::{report, tell, warn, warn_of};
use std::io::Write;
use std::process::ExitCode;
use std::sync::LazyLock;

static VERSION: LazyLock<String> = LazyLock::new(|| format!("{} {}", env!("CARGO_PKG_VERSION"), simd_level()));

/// A data-oriented SIMD packet path tracer.
#[derive(Parser)]
#[command(name = "octray", version = VERSION.as_str(), max_term_width = 110, after_help = examples::FIRST)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// What is said on standard error, beside results: off, error, warn, info or debug
    #[arg(long, global = true, value_name = "LEVEL", default_value = "warn")]
    log: log::LevelFilter,
    /// Take at most so much memory (8G, 500M, or bytes) [default: 0.9 of what the machine or its control group has]
    #[arg(long, global = true, value_name = "SIZE", value_parser = args::bytes, allow_negative_numbers = true)]
    max_memory: Option<u64>,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to image files
    Render(Box<render::RenderArgs>),
    /// What a scene holds and needs: tables, the plan, what was left out
    Info(info::InfoArgs),
    /// One path, vertex by vertex, in both engines
    Trace(trace::TraceArgs),
    /// Numerical checks: extreme and stiff cases against what is known, or those that apply to a scene
    Check(check::CheckArgs),
    /// Throughput of the engines, side by side
    Bench(bench::BenchArgs),
    /// Error against run time, for every strategy: a report, plots, tables
    #[command(after_help = examples::CONVERGE)]
    Converge(Box<converge::ConvergeArgs>),
    /// How far image A is from image B, the reference
    Diff(diff::DiffArgs),
    /// Parts of a render, made by themselves, to the image that one machine would have made
    Merge(merge::MergeArgs),
    /// Completions of this command line, for a shell
    Completions(shell::CompletionsArgs),
    /// Pages for man
    Man(shell::ManArgs),
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
    messages::begin();
    interrupt::survive_full_files();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => return start(),
        Err(error) => return report_usage(&error),
    };
    messages::set_level(cli.log);
    set_max_memory(cli.max_memory);
    if let Err(error) = SimdLevel::from_environment() {
        report(&error);
        return error.exit_status();
    }
    let done = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Trace(args) => trace::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Converge(args) => converge::run(&args),
        Command::Diff(args) => diff::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Completions(args) => shell::completions(&args, Cli::command()),
        Command::Man(args) => shell::man(&args, Cli::command()),
    };
    match done {
        Ok(status) => status,
        Err(error) => {
            report(&suggest::with_hint(&error));
            error.exit_status()
        }
    }
}

/// `octray` alone: where to begin. On standard output, since that is what was asked for; with the status of a missing argument,
/// as git and clap have it, so that a script whose variable was empty does not go on.
fn start() -> u8 {
    let _ = output::print(&format!(
        "octray {}: a path tracer for triangle scenes\n\n{}\n\n\
         All commands: octray --help. Flags and examples of one: octray render --help.\n",
        *VERSION,
        examples::FIRST
    ));
    2
}

/// Help and versions go to standard output with status 0, wrong arguments to standard error with status 2.
fn report_usage(error: &clap::Error) -> u8 {
    let text = error.to_string();
    if !error.use_stderr() {
        // A closed standard output is no reason for another status.
        let _ = output::print(&text);
        return error.exit_code() as u8;
    }
    // What was typed stands in it, and may come from anywhere.
    let _ = write!(std::io::stderr(), "{}", shown(&text));
    if let Some(tip) = suggest::tip(error) {
        let _ = writeln!(std::io::stderr(), "\n  tip: {}", shown(&tip));
    }
    error.exit_code() as u8
}

/// [`Scene::prepare`], with what it warns of on stderr.
fn prepare(scene: &Scene) -> Result<PreparedScene> {
    let prepared = scene.prepare()?;
    prepared.warnings.iter().for_each(|warning| warn(warning));
    tell(&format!("{}: tables and tree made in {} s", prepared.name, numbers::three_digits(prepared.build_s)));
    Ok(prepared)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The commands in a text: lines that begin with two blanks and the program's name.
    fn commands(text: &str) -> Vec<&str> {
        text.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| line.starts_with("octray ")).collect()
    }

    #[test]
    fn the_commands_that_help_shows_are_understood() {
        let mut program = Cli::command().term_width(100);
        program.build();
        let own = program.render_help().to_string();
        let mut all = commands(&own);
        assert_eq!(all, commands(examples::FIRST), "{own}");
        assert_eq!(all.len(), 3);
        let mut helps = Vec::new();
        for command in program.get_subcommands_mut().filter(|command| command.get_name() != "help") {
            helps.push((command.get_name().to_owned(), command.render_help().to_string()));
        }
        assert_eq!(helps.len(), 10);
        for (name, help) in &helps {
            let section = help.split_once("\nExamples:\n").unwrap_or_else(|| panic!("{name}: {help}")).1;
            let examples = commands(section);
            assert!(examples.len() >= 2, "{name}: {section}");
            assert!(examples.iter().all(|line| line.split(' ').nth(1) == Some(name)), "{name}: {section}");
            all.extend(examples);
        }
        for command in all {
            // So that no terminal breaks them.
            assert!(command.len() <= 78, "{command}");
            if let Err(error) = Cli::try_parse_from(command.split(' ')) {
                panic!("{command}: {error}");
            }
        }
    }

    #[test]
    fn the_arguments_are_sound() {
        Cli::command().debug_assert();
    }
}
