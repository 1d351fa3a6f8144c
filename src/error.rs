//! What can go wrong, sorted by who can mend it. Every message says where, what and what to do; what it takes from files and
//! names is shown, never passed on ([`crate::shown`]).

use crate::shown::{shown, shown_path};
use std::path::{Path, PathBuf};

/// An error of the library; the command line prints it and exits with [`Error::exit_status`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("{}: cannot read it: {source}", shown_path(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file could not be written. The old file, if there was one, is untouched.
    #[error("{}: cannot write it: {}", shown_path(path), shown(message))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system or the encoder said.
        message: String,
    },
    /// A scene file, OBJ or MTL says something that cannot be used.
    #[error("{}{}: {}", shown_path(path), line.map(|l| format!(":{l}")).unwrap_or_default(), shown(message))]
    Parse {
        /// The file.
        path: PathBuf,
        /// Its line, from 1, where one line is to blame.
        line: Option<usize>,
        /// What is wrong and what to do.
        message: String,
    },
    /// A scene that reads well but cannot be rendered.
    #[error("{}: {}", shown(scene), shown(message))]
    Scene {
        /// The scene's name or path.
        scene: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// What was asked for, or what a file holds, takes more memory than there is.
    #[error("{}", shown(.0))]
    Memory(String),
    /// A flag or setting that cannot be used.
    #[error("{}", shown(.0))]
    Usage(String),
}

impl Error {
    /// 1 for outputs that could not be written, 2 for bad input and flags.
    pub fn exit_status(&self) -> u8 {
        match self {
            Error::Write { .. } => 1,
            _ => 2,
        }
    }

    /// A parse error in `path`, at `line` if one is known.
    pub fn parse(path: &Path, line: Option<usize>, message: impl Into<String>) -> Error {
        Error::Parse { path: path.to_owned(), line, message: message.into() }
    }
}

/// The library's results.
pub type Result<T> = std::result::Result<T, Error>;
