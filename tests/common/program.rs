//! The program from outside, for tests that run it.
#![allow(dead_code)] // not every test file uses every helper

use std::process::{Command, Output};

/// Runs the program to its end; its lines are as wide as where there is no terminal.
pub fn octray(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_octray")).args(arguments).env_remove("COLUMNS").output().unwrap()
}

/// What it has written to standard error.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A directory, and paths in it as text.
pub struct Place(pub tempfile::TempDir);

impl Place {
    /// An empty one, gone with this value.
    pub fn new() -> Place {
        Place(tempfile::tempdir().unwrap())
    }
    /// The path of `name` in it.
    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }
}
