//! Files that other people wrote: only regular ones are read, none that is too large for the memory there is.

use crate::error::{Error, Result};
use crate::files::memory;
use std::cell::RefCell;
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

thread_local! {
    /// The files that this thread has opened since [`traced`] was called, if it was.
    static OPENED: RefCell<Option<Vec<PathBuf>>> = const { RefCell::new(None) };
}

/// What `work` returns, and the files that it has opened by this module on this thread: those that no output may replace.
pub fn traced<R>(work: impl FnOnce() -> R) -> (R, Vec<PathBuf>) {
    let before = OPENED.replace(Some(Vec::new()));
    let result = work();
    let opened = OPENED.replace(before).unwrap_or_default();
    OPENED.with_borrow_mut(|all| all.iter_mut().for_each(|all| all.extend_from_slice(&opened)));
    (result, opened)
}

/// All bytes of the regular file `path`.
///
/// # Errors
/// [`Error::Read`] if it cannot be read or is no regular file: a device never ends, and a pipe that nobody writes to waits
/// without a word. [`Error::Memory`] if it is too large.
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    let failed = |source| Error::Read { path: path.to_owned(), source };
    let mut file = open(path)?;
    let length = file.metadata().map_err(failed)?.len();
    let room = usize::try_from(length).unwrap_or(usize::MAX);
    let mut bytes = memory::reserved(room, &path.display().to_string())?;
    // A file that grows meanwhile ends where it was to end; one of the system's that says 0 has what it has, if that is little.
    let most = if length == 0 { MOST_UNTOLD } else { length };
    file.by_ref().take(most).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// Most bytes that are read of a file whose length the system does not tell (in `/proc`).
const MOST_UNTOLD: u64 = 1 << 24;

/// Opens the regular file `path`.
///
/// # Errors
/// [`Error::Read`].
pub fn open(path: &Path) -> Result<File> {
    let failed = |source| Error::Read { path: path.to_owned(), source };
    // Before it is opened: to open a pipe is to wait for its writer.
    let found = std::fs::metadata(path).map_err(failed)?;
    match kind(&found) {
        None => {
            OPENED.with_borrow_mut(|all| all.iter_mut().for_each(|all| all.push(path.to_owned())));
            File::open(path).map_err(failed)
        }
        Some(kind) => Err(failed(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("it is {kind}; only regular files are read"),
        ))),
    }
}

/// Whether `path` is there and is neither a regular file nor a directory: a device, a pipe, a socket.
pub fn is_special(path: &Path) -> bool {
    path.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// What a file is that is no regular file, with its article.
fn kind(found: &Metadata) -> Option<&'static str> {
    if found.is_file() {
        return None;
    }
    if found.is_dir() {
        return Some("a directory");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = found.file_type();
        let kinds = [(kind.is_fifo(), "a pipe"), (kind.is_socket(), "a socket")];
        if let Some((_, name)) = kinds.into_iter().find(|(is, _)| *is) {
            return Some(name);
        }
    }
    Some("a device")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        std::fs::write(&file, "text").unwrap();
        let (inner, outer) = traced(|| traced(|| bytes(&file)));
        assert_eq!((inner.0.unwrap(), inner.1, outer), (b"text".to_vec(), vec![file.clone()], vec![file.clone()]));
        let refused = bytes(folder.path()).unwrap_err().to_string();
        assert!(refused.contains("it is a directory; only regular files are read"), "{refused}");
        if cfg!(target_os = "linux") {
            assert!(bytes(Path::new("/dev/zero")).unwrap_err().to_string().contains("it is a device"));
            assert!(bytes(Path::new("/proc/self/status")).unwrap().starts_with(b"Name:"));
        }
        assert!(matches!(bytes(&folder.path().join("b")), Err(Error::Read { .. })));
    }
}
