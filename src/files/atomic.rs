//! Files that appear whole or not at all: written beside their target under a temporary name, then renamed.
//!
//! Whoever writes a temporary file holds a lock on it. A run that is killed loses its locks with its life, so one that nobody
//! holds is a leftover, which the next run in that directory removes ([`check`]); on file systems without locks it stays.

use crate::error::{Error, Result};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Cursor, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use tempfile::NamedTempFile;

/// Somewhere an encoder can write and step back.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Whether [`write()`] to `path` can be expected to work. Makes (and removes) a temporary file in its directory, since
/// nothing else answers the question on every file system; removes what killed runs have left there.
pub fn check(path: &Path) -> Result<()> {
    let target = Target::of(path)?;
    if let Target::File { directory, .. } = &target {
        remove_leftovers(directory);
    }
    let tried = match &target {
        Target::File { directory, existing: true, path } => {
            // A rename would replace a read-only file without asking: respect its permissions as a plain write would.
            OpenOptions::new().append(true).open(path).and_then(|_| temporary(directory)).map(drop)
        }
        Target::File { directory, .. } => temporary(directory).map(drop),
        Target::Special(device) => OpenOptions::new().write(true).open(device).map(drop),
    };
    tried.map_err(|error| failure(path, &error))
}

/// Writes `path` by `encode`. On any error nothing is left behind and an older file keeps its bytes.
pub fn write(path: &Path, encode: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> Result<()> {
    let written = match Target::of(path)? {
        Target::File { directory, existing, path } => replace(&directory, existing, &path, encode),
        Target::Special(device) => stream(&device, encode),
    };
    written.map_err(|error| failure(path, &error))
}

/// What a path leads to.
enum Target {
    /// A regular file (links followed) or nothing yet.
    File { directory: PathBuf, existing: bool, path: PathBuf },
    /// A pipe or a device such as `/dev/stdout`: written into, never replaced.
    Special(PathBuf),
}

impl Target {
    fn of(path: &Path) -> Result<Target> {
        let real = followed(path);
        let parent = real.parent().filter(|parent| !parent.as_os_str().is_empty());
        let directory = parent.unwrap_or(Path::new(".")).to_owned();
        match fs::metadata(&real) {
            Ok(found) if found.is_dir() => Err(refusal(path, "it is a directory; name a file in it")),
            Ok(found) if found.is_file() => Ok(Target::File { directory, existing: true, path: real }),
            Ok(_) => Ok(Target::Special(real)),
            // No file can ever have this name.
            Err(error) if directory.is_dir() && error.kind() != io::ErrorKind::NotFound => Err(failure(path, &error)),
            Err(_) if directory.is_dir() => Ok(Target::File { directory, existing: false, path: real }),
            Err(_) if directory.exists() => Err(refusal(path, &format!("{} is not a directory", directory.display()))),
            Err(_) => {
                Err(refusal(path, &format!("the directory {} does not exist; make it first", directory.display())))
            }
        }
    }
}

/// Most links on the way to a file, as Linux has it.
const MOST_LINKS: usize = 40;

/// Where `path` leads: links are followed, to a file that does not exist yet, too, so that it is made or replaced and not the
/// link.
pub fn followed(path: &Path) -> PathBuf {
    let mut real = path.to_owned();
    for _ in 0..MOST_LINKS {
        if let Ok(found) = fs::canonicalize(&real) {
            return found;
        }
        let Ok(target) = fs::read_link(&real) else { break };
        real = real.parent().unwrap_or(Path::new("")).join(target);
    }
    real
}

fn replace(
    directory: &Path,
    existing: bool,
    path: &Path,
    encode: impl FnOnce(&mut dyn Sink) -> io::Result<()>,
) -> io::Result<()> {
    let file = temporary(directory)?;
    let mut out = BufWriter::new(file.as_file());
    encode(&mut out)?;
    out.flush()?;
    drop(out);
    if existing {
        file.as_file().set_permissions(fs::metadata(path)?.permissions())?;
    }
    // A full disk or a lost share may only show here, and must show before the old file goes.
    file.as_file().sync_all()?;
    file.persist(path)?;
    // The new name may else be lost with the power, though the file is not. Not every system can do this to a directory.
    if cfg!(unix) {
        let _ = File::open(directory).and_then(|directory| directory.sync_all());
    }
    Ok(())
}

fn stream(device: &Path, encode: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> io::Result<()> {
    let mut bytes = Cursor::new(Vec::new());
    encode(&mut bytes)?;
    let mut out = OpenOptions::new().write(true).open(device)?;
    out.write_all(bytes.get_ref())?;
    out.flush()
}

const PREFIX: &str = ".octray-";
const SUFFIX: &str = ".tmp";

/// A new file in `directory`, locked, removed again unless it is renamed; with the permissions a plain new file would have.
fn temporary(directory: &Path) -> io::Result<NamedTempFile<File>> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let file = builder.tempfile_in(directory)?;
        // Between the two lines somebody who cleans up may have taken it for a leftover.
        match file.as_file().try_lock() {
            Err(TryLockError::WouldBlock) => {}
            Ok(()) if file.path().symlink_metadata().is_err() => {}
            _ => return Ok(file),
        }
    }
}

/// Directories that this process has looked through for leftovers: once is enough, and each of thousands of frames is checked.
static LOOKED_THROUGH: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes the temporary files in `directory` that nobody holds any more, the first time it is asked. What cannot be removed
/// stays.
fn remove_leftovers(directory: &Path) {
    let mut looked_through = LOOKED_THROUGH.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    if !looked_through.insert(directory.to_owned()) {
        return;
    }
    drop(looked_through);
    let Ok(entries) = fs::read_dir(directory) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        if !(ours && entry.file_type().is_ok_and(|kind| kind.is_file())) {
            continue;
        }
        let path = entry.path();
        if let Ok(file) = File::open(&path)
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(&path);
        }
    }
}

fn refusal(path: &Path, message: &str) -> Error {
    Error::Write { path: path.to_owned(), message: message.to_owned() }
}

fn failure(path: &Path, error: &io::Error) -> Error {
    let hint = match error.kind() {
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => "; choose another place",
        io::ErrorKind::StorageFull => "; make room and try again",
        _ => "",
    };
    refusal(path, &format!("{error}{hint}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn leftovers_go_and_what_is_being_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in [".octray-abc.tmp", ".octray-abc.png", "octray.tmp"] {
            fs::write(at(name), "x").unwrap();
        }
        let held = temporary(folder.path()).unwrap();
        check(&at("a.png")).unwrap();
        let held_name = held.path().file_name().unwrap().to_str().unwrap();
        let mut left = vec![".octray-abc.png", held_name, "octray.tmp"];
        left.sort_unstable();
        assert_eq!(names(folder.path()), left);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        write(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write(&path, |out| {
            out.write_all(b"new")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert!(failed.unwrap_err().to_string().contains("make room"));
        assert_eq!((names(folder.path()), fs::read(&path).unwrap()), (vec!["a".to_owned()], b"old".to_vec()));
    }

    #[test]
    #[cfg(unix)]
    fn links_are_followed_even_to_what_is_not_there_yet() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::os::unix::fs::symlink("two", at("one")).unwrap();
        std::os::unix::fs::symlink("three", at("two")).unwrap();
        write(&at("one"), |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read_link(at("one")).unwrap(), Path::new("two"));
        assert_eq!(fs::read(at("three")).unwrap(), b"new");
        // A circle of links leads nowhere.
        std::os::unix::fs::symlink("b", at("a")).unwrap();
        std::os::unix::fs::symlink("a", at("b")).unwrap();
        assert!(check(&at("a")).is_err());
    }

    #[test]
    fn names_that_no_file_can_have_are_refused_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        assert!(check(&folder.path().join("x".repeat(300))).is_err());
    }
}
