//! Results: text on standard output, JSON on standard output or in a file.

use crate::error::{Error, Result};
use crate::image::atomic;
use serde::Serialize;
use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Prints a result. A reader that has gone away (`octray info .. | head`) is not an error.
pub fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Write { path: PathBuf::from("standard output"), message: error.to_string() })
        }
        _ => Ok(()),
    }
}

/// The `--json [FILE]` flag.
#[derive(clap::Args)]
pub struct JsonArgs {
    /// Print JSON instead of a table, or write it to FILE
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    json: Option<Option<PathBuf>>,
}

impl JsonArgs {
    /// Whether FILE can be written; called before the work whose result goes there.
    pub fn check(&self) -> Result<()> {
        let Some(Some(path)) = &self.json else { return Ok(()) };
        check_json_path("--json", path)
    }

    /// Whether JSON is wanted at all.
    pub fn is_given(&self) -> bool {
        self.json.is_some()
    }

    /// Whether standard output is to hold the JSON alone.
    pub fn to_standard_output(&self) -> bool {
        matches!(self.json, Some(None))
    }

    /// Prints or writes `value` if the flag was given, else prints `table()`.
    pub fn deliver(&self, value: &impl Serialize, table: impl FnOnce() -> String) -> Result<()> {
        match &self.json {
            None => print(&table()),
            Some(None) => print(&json_text(value)?),
            Some(Some(path)) => write_json(path, value),
        }
    }
}

/// Whether the file named by `flag` can be written, and is no scene: `octray bench --json scene.toml` would replace the
/// scene by the result.
pub fn check_json_path(flag: &str, path: &Path) -> Result<()> {
    let scene = |extension: &OsStr| ["toml", "obj", "mtl"].iter().any(|known| extension.eq_ignore_ascii_case(known));
    if path.extension().is_some_and(scene) {
        let path = path.display();
        return Err(Error::Usage(format!("{flag} {path}: that is a scene file; name the scene before {flag}")));
    }
    atomic::check(path)
}

/// Writes `value` as JSON to `path`, whole or not at all.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = json_text(value)?;
    atomic::write(path, |out| out.write_all(text.as_bytes()))
}

fn json_text(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Error::Usage(format!("the result cannot be written as JSON: {error}")))?;
    Ok(text + "\n")
}

/// A table of left-aligned text columns, the last one ragged.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:width$}"));
        text += cells.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    text
}
