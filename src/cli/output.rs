//! Results: text on standard output, JSON on standard output or in a file, and the places of files.

use crate::cli::places::{self, first_missing};
use crate::error::{Error, Result};
use crate::files::atomic;
use crate::image::Format;
use crate::import::SCENE_FILES;
use crate::shown::escaped;
use serde::Serialize;
use std::ffi::OsStr;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Prints a result. A reader that has gone away (`octray info .. | head`) is not an error.
pub fn print(text: &str) -> Result<()> {
    print_as_it_is(&escaped(text))
}

/// [`print`] for what has its own way to write what a terminal would obey, as JSON has.
fn print_as_it_is(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Write { path: PathBuf::from("standard output"), message: error.to_string() })
        }
        _ => Ok(()),
    }
}

/// The `--json[=FILE]` flag.
#[derive(clap::Args)]
pub struct JsonArgs {
    /// Print JSON instead of text, or with the text write it to FILE (only behind an equals sign: `--json FILE` names none)
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    json: Option<Option<PathBuf>>,
}

impl JsonArgs {
    /// The file named; `-` is standard output, as no file is.
    fn file(&self) -> Option<&Path> {
        self.json.as_ref()?.as_deref().filter(|path| *path != Path::new("-"))
    }

    /// Whether FILE can be written; called before the work whose result goes there.
    pub fn check(&self) -> Result<()> {
        self.file().map_or(Ok(()), |path| check_json_path("--json", path))
    }

    /// Whether standard output is to hold the JSON alone.
    pub fn to_standard_output(&self) -> bool {
        self.json.is_some() && self.file().is_none()
    }

    /// Prints `value` if it is to go to standard output, else `text()`, and writes `value` to FILE if one was named.
    pub fn deliver(&self, value: &impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
        match self.to_standard_output() {
            true => print_as_it_is(&json_text(value)?),
            false => print(&text()),
        }?;
        self.file().map_or(Ok(()), |path| write_json(path, value))
    }
}

/// Whether the file named by `flag` can be written, and is neither scene nor image: a slip must not replace what cannot be had
/// again.
pub fn check_json_path(flag: &str, path: &Path) -> Result<()> {
    let scene =
        |extension: &OsStr| SCENE_FILES.iter().chain(&["mtl"]).any(|known| extension.eq_ignore_ascii_case(known));
    let what = match path.extension() {
        Some(extension) if scene(extension) => "a scene file",
        Some(_) if Format::of(path).is_ok() => "an image",
        _ => {
            check_place(path, atomic::check)?;
            return places::claim(path);
        }
    };
    Err(Error::Usage(format!("{flag} {}: that is {what}; name a .json file", path.display())))
}

/// Writes `value` as JSON to `path`, whole or not at all; makes its directory.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    write_text(path, &json_text(value)?)
}

/// Writes `text` to `path`, whole or not at all; makes its directory.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    make_directory(path)?;
    atomic::write(path, |out| out.write_all(text.as_bytes()))
}

/// Whether the plot named by `flag` can be written, and is of the one kind that plots are.
pub fn check_plot_path(flag: &str, path: &Path) -> Result<()> {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("svg") => {
            check_place(path, atomic::check)?;
            places::claim(path)
        }
        _ => Err(Error::Usage(format!("{flag} {}: plots are written as SVG; name a .svg file", path.display()))),
    }
}

fn json_text(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Error::Usage(format!("the result cannot be written as JSON: {error}")))?;
    Ok(text + "\n")
}

/// What `check` says of `path`; where its directory does not exist yet, whether [`make_directory`] can be expected to make it.
/// Makes nothing.
pub fn check_place(path: &Path, check: impl Fn(&Path) -> Result<()>) -> Result<()> {
    match first_missing(path) {
        Some(directory) => atomic::check(&directory),
        None => check(path),
    }
}

/// Makes the directory of `path` and those above it: after all other checks, so that bad input leaves nothing behind.
pub fn make_directory(path: &Path) -> Result<()> {
    let Some(parent) = path.parent().filter(|_| first_missing(path).is_some()) else { return Ok(()) };
    std::fs::create_dir_all(parent).map_err(|error| Error::Write {
        path: path.to_owned(),
        message: format!("the directory {} cannot be made: {error}; choose another place", parent.display()),
    })
}

/// The columns that text may take: of the terminal that standard output goes to, or what COLUMNS says; 120 at most, and where it
/// goes elsewhere.
pub fn columns() -> usize {
    let said = std::env::var("COLUMNS").ok().and_then(|text| text.parse().ok());
    let width = said.or_else(|| io::stdout().is_terminal().then(terminal_columns)).unwrap_or(MOST_COLUMNS);
    width.clamp(LEAST_COLUMNS, MOST_COLUMNS)
}

const LEAST_COLUMNS: usize = 60;
const MOST_COLUMNS: usize = 120;

/// The terminal's width, which clap asks for to wrap its help: a text of the shortest words is as wide as that. (The first word
/// has two letters, so that lines of even and of odd length occur.)
fn terminal_columns() -> usize {
    let text = format!("xx{}", " x".repeat(MOST_COLUMNS));
    let mut command = clap::Command::new("x").about(text).max_term_width(MOST_COLUMNS).help_template("{about}");
    command.render_help().to_string().lines().map(str::len).max().unwrap_or(MOST_COLUMNS)
}

/// `text` in lines of at most `width` columns; those after the first begin with `indent` blanks, which do not count. A word is
/// never broken.
pub fn wrapped(text: &str, width: usize, indent: usize) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join(&format!("\n{:indent$}", ""))
}

/// A table of left-aligned text columns; the last one wraps where the terminal ends.
pub fn table(rows: &[Vec<String>]) -> String {
    aligned(rows, &[])
}

/// [`table`] in a place of so many columns.
pub fn table_in(rows: &[Vec<String>], columns: usize) -> String {
    aligned_in(rows, &[], columns)
}

/// [`table`] with the columns in `right` aligned to the right.
pub fn aligned(rows: &[Vec<String>], right: &[usize]) -> String {
    aligned_in(rows, right, columns())
}

/// The last column is wrapped if it can be at least so wide; where there is less room, lines run over.
const LEAST_LAST: usize = 24;

/// [`aligned`] in a place of so many columns.
pub fn aligned_in(rows: &[Vec<String>], right: &[usize], most: usize) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let before: usize = widths.iter().take(columns.saturating_sub(1)).map(|width| width + 2).sum();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            let last = column + 1 == columns;
            line += &match (right.contains(&column), last) {
                (true, _) => format!("{cell:>width$}"),
                (false, true) if most >= before + LEAST_LAST => wrapped(cell, most - before, before),
                (false, _) => format!("{cell:width$}"),
            };
            line += if last { "" } else { "  " };
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_line_up_and_wrap_their_last_column() {
        let rows = [["a", "1", "short"], ["longer", "234", "one two three four five six"]];
        let rows = rows.map(|row| row.map(str::to_owned).to_vec());
        let text = "a         1  short\nlonger  234  one two three four five six\n";
        assert_eq!(aligned_in(&rows, &[1], 120), text);
        let narrow = "a         1  short\nlonger  234  one two three four five\n             six\n";
        assert_eq!(aligned_in(&rows, &[1], 37), narrow);
        // No room at all: nothing is lost.
        assert_eq!(aligned_in(&rows, &[1], 20), text);
        assert_eq!(aligned_in(&[], &[], 80), "");
    }

    #[test]
    fn words_are_wrapped_whole() {
        assert_eq!(wrapped("aa bb cc", 5, 0), "aa bb\ncc");
        assert_eq!(wrapped("aa bb cc dd", 5, 2), "aa bb\n  cc dd");
        assert_eq!(wrapped("much_too_long b", 4, 1), "much_too_long\n b");
        assert_eq!(wrapped("", 4, 1), "");
    }

    #[test]
    fn directories_are_checked_and_made_from_the_first_that_is_missing() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a/b/c.json");
        assert_eq!(first_missing(&path), Some(place.path().join("a")));
        assert_eq!((first_missing(Path::new("c.json")), first_missing(Path::new("/c.json"))), (None, None));
        check_place(&path, |_| panic!("there is no directory to check")).unwrap();
        assert!(!place.path().join("a").exists());
        make_directory(&path).unwrap();
        assert_eq!((path.parent().unwrap().is_dir(), first_missing(&path)), (true, None));
        let same = ["a/b/c.json", "a/./b/../b/c.json", "x/../a/b/c.json"].map(|name| place.path().join(name));
        assert_eq!(places::whole_path(&same[0]), places::whole_path(&same[1]));
        assert_eq!(places::whole_path(&same[0]), places::whole_path(&same[2]));
    }
}
