//! The files of one command: no two outputs may be one, and none may be what the command reads.
//!
//! Outputs are claimed where their flags are checked, before anything is read; whatever reads inputs does so inside [`reading`].

use crate::error::{Error, Result};
use crate::files::{atomic, read};
use std::cell::RefCell;
use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

#[derive(Default)]
struct Outputs {
    files: HashSet<PathBuf>,
    /// Directories in which every file with one of these extensions may be written.
    directories: Vec<(PathBuf, &'static [&'static str])>,
}

thread_local! {
    /// Those of the command that runs on this thread.
    static OUTPUTS: RefCell<Outputs> = RefCell::default();
}

/// Claims `path` for an output.
///
/// # Errors
/// [`Error::Usage`] if another output has it.
pub fn claim(path: &Path) -> Result<()> {
    match OUTPUTS.with_borrow_mut(|outputs| outputs.files.insert(whole_path(path))) {
        true => Ok(()),
        false => {
            let path = path.display();
            Err(Error::Usage(format!("{path}: named for two outputs; each needs a file of its own")))
        }
    }
}

/// Claims all files with one of the `extensions` in `directory`.
pub fn claim_directory(directory: &Path, extensions: &'static [&'static str]) {
    OUTPUTS.with_borrow_mut(|outputs| outputs.directories.push((whole_path(directory), extensions)));
}

/// What `work` returns, which reads inputs.
///
/// # Errors
/// Those of `work`; [`Error::Usage`] if it has read what is claimed for an output.
pub fn reading<R>(work: impl FnOnce() -> Result<R>) -> Result<R> {
    let (result, opened) = read::traced(work);
    let result = result?;
    match opened.iter().find(|path| is_claimed(&whole_path(path))) {
        None => Ok(result),
        Some(path) => Err(Error::Usage(format!(
            "{}: an output would replace it, and this command reads it: write to another file",
            path.display()
        ))),
    }
}

fn is_claimed(whole: &Path) -> bool {
    OUTPUTS.with_borrow(|outputs| {
        let extension = whole.extension().unwrap_or_default();
        let mut directories = outputs.directories.iter();
        let written = |known: &&'static str| extension.eq_ignore_ascii_case(known);
        outputs.files.contains(whole)
            || directories.any(|(directory, known)| whole.parent() == Some(directory) && known.iter().any(written))
    })
}

/// The first directory on the way to `path` that does not exist; `None`: all do.
pub fn first_missing(path: &Path) -> Option<PathBuf> {
    let missing = path.ancestors().skip(1).filter(|directory| !directory.as_os_str().is_empty());
    missing.take_while(|directory| directory.symlink_metadata().is_err()).last().map(Path::to_owned)
}

/// The same for `a.png`, `./a.png`, a link to it and any other way to its directory, which need not exist.
pub fn whole_path(path: &Path) -> PathBuf {
    let path = &atomic::followed(path);
    if let Ok(existing) = path.canonicalize() {
        return existing;
    }
    let (directory, rest) = match first_missing(path) {
        Some(missing) => {
            let rest = path.strip_prefix(&missing).unwrap_or(path).to_owned();
            (
                missing.parent().unwrap_or(Path::new("")).to_owned(),
                missing.file_name().map(PathBuf::from).unwrap_or_default().join(rest),
            )
        }
        None => {
            (path.parent().unwrap_or(Path::new("")).to_owned(), path.file_name().map(PathBuf::from).unwrap_or_default())
        }
    };
    let directory = if directory.as_os_str().is_empty() { Path::new(".") } else { &directory };
    let mut whole = directory.canonicalize().unwrap_or_else(|_| directory.to_owned());
    for component in rest.components() {
        match component {
            Component::ParentDir => drop(whole.pop()),
            Component::CurDir => {}
            other => whole.push(other),
        }
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_neither_each_other_nor_inputs() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("in.png"), "x").unwrap();
        let reads = || reading(|| read::bytes(&at("in.png")));
        assert!(reads().is_ok());
        claim(&at("a.png")).unwrap();
        let twice = claim(&at("./b/../a.png")).unwrap_err().to_string();
        assert!(twice.contains("named for two outputs"), "{twice}");
        claim(&folder.path().join(".").join("in.png")).unwrap();
        assert!(reads().unwrap_err().to_string().contains("in.png: an output would replace it"));
        std::fs::write(at("table.csv"), "x").unwrap();
        let table = || reading(|| read::bytes(&at("table.csv")));
        assert!(table().is_ok());
        claim_directory(folder.path(), &["csv"]);
        assert!(table().is_err());
    }
}
