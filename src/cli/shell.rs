//! `octray completions` and `octray man`: what shells and `man` read, made of the definition of the command line.

use crate::cli::examples;
use crate::cli::output::{check_place, make_directory, print};
use crate::error::{Error, Result};
use crate::files::atomic;
use clap::Command;
use clap_complete::Shell;
use std::path::PathBuf;

/// Flags of `octray completions`.
#[derive(clap::Args)]
#[command(after_help = examples::COMPLETIONS)]
pub struct CompletionsArgs {
    /// The shell that reads them
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints what the shell is to read.
pub fn completions(args: &CompletionsArgs, mut program: Command) -> Result<u8> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut program, "octray", &mut text);
    print(&String::from_utf8_lossy(&text))?;
    Ok(0)
}

/// Flags of `octray man`.
#[derive(clap::Args)]
#[command(after_help = examples::MAN)]
pub struct ManArgs {
    /// Directory for octray.1, octray-render.1 and so on; made if need be
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Writes a page for the program and for each command.
pub fn man(args: &ManArgs, mut program: Command) -> Result<u8> {
    program.build();
    let mut pages = vec![("octray".to_owned(), program.clone())];
    for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
        let name = format!("octray-{}", command.get_name());
        pages.push((name.clone(), command.clone().name(name)));
    }
    let place = |name: &str| args.out.join(format!("{name}.1"));
    pages.iter().try_for_each(|(name, _)| check_place(&place(name), atomic::check))?;
    for (name, command) in pages {
        let path = place(&name);
        make_directory(&path)?;
        let mut text = Vec::new();
        let failed = |error: std::io::Error| Error::Write { path: path.clone(), message: error.to_string() };
        clap_mangen::Man::new(command).render(&mut text).map_err(failed)?;
        atomic::write(&path, |out| out.write_all(&text))?;
    }
    Ok(0)
}
