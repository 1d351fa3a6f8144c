//! Files that appear whole or not at all: written beside their target under a temporary name, then renamed.

use crate::error::{Error, Result};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Cursor, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Somewhere an encoder can write and step back.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Whether [`write()`] to `path` can be expected to work. Makes (and removes) a temporary file in its directory, since
/// nothing else answers the question on every file system.
pub fn check(path: &Path) -> Result<()> {
    let target = Target::of(path)?;
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
        // Links are followed so that the file they lead to is replaced, not the link.
        let real = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let parent = real.parent().filter(|parent| !parent.as_os_str().is_empty());
        let directory = parent.unwrap_or(Path::new(".")).to_owned();
        match fs::metadata(&real) {
            Ok(found) if found.is_dir() => Err(refusal(path, "it is a directory; name a file in it")),
            Ok(found) if found.is_file() => Ok(Target::File { directory, existing: true, path: real }),
            Ok(_) => Ok(Target::Special(real)),
            Err(_) if directory.is_dir() => Ok(Target::File { directory, existing: false, path: real }),
            Err(_) if directory.exists() => Err(refusal(path, &format!("{} is not a directory", directory.display()))),
            Err(_) => {
                Err(refusal(path, &format!("the directory {} does not exist; make it first", directory.display())))
            }
        }
    }
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
    Ok(())
}

fn stream(device: &Path, encode: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> io::Result<()> {
    let mut bytes = Cursor::new(Vec::new());
    encode(&mut bytes)?;
    let mut out = OpenOptions::new().write(true).open(device)?;
    out.write_all(bytes.get_ref())?;
    out.flush()
}

/// A new file in `directory`, removed again unless it is renamed; with the permissions a plain new file would have.
fn temporary(directory: &Path) -> io::Result<NamedTempFile<File>> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".octray-").suffix(".tmp");
    #[cfg(unix)]
    let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(directory)
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
