//! Files that only this program reads, and that say whether they are whole: a line of text that names the kind, a line of
//! JSON, many f64 (little-endian), and a fingerprint of all that.

use std::io;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};
use crate::fingerprint::Fingerprint;
use crate::image::atomic;

/// Writes `header` and `numbers` to `path`, whole or not at all.
///
/// # Errors
/// [`Error::Write`].
pub fn write(path: &Path, magic: &str, header: &impl Serialize, numbers: impl Iterator<Item = f64>) -> Result<()> {
    atomic::write(path, |out| {
        let header = serde_json::to_string(header).map_err(io::Error::other)?;
        let mut bytes = format!("{magic}\n{header}\n").into_bytes();
        numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
        out.write_all(&bytes)?;
        out.write_all(&fingerprint(&bytes).to_le_bytes())
    })
}

/// Reads such a file; `None` if it is of another kind or not as it was written.
///
/// # Errors
/// [`Error::Read`].
pub fn read<H: DeserializeOwned>(path: &Path, magic: &str) -> Result<Option<(H, Vec<f64>)>> {
    let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    Ok(parse(&bytes, magic))
}

fn parse<H: DeserializeOwned>(bytes: &[u8], magic: &str) -> Option<(H, Vec<f64>)> {
    let (whole, sum) = bytes.split_last_chunk::<8>()?;
    if fingerprint(whole) != u64::from_le_bytes(*sum) {
        return None;
    }
    let rest = whole.strip_prefix(magic.as_bytes())?.strip_prefix(b"\n")?;
    let end = rest.iter().position(|byte| *byte == b'\n')?;
    let header = serde_json::from_slice(&rest[..end]).ok()?;
    let (numbers, left) = rest[end + 1..].as_chunks::<8>();
    left.is_empty().then(|| (header, numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()))
}

fn fingerprint(bytes: &[u8]) -> u64 {
    let mut print = Fingerprint::default();
    print.bytes(bytes);
    print.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_damaged_byte_is_seen() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        write(&path, "kind", &["a\nb", "\"c\""], [1.5, -0.0, 1e300].into_iter()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let (header, numbers) = parse::<Vec<String>>(&bytes, "kind").unwrap();
        assert_eq!((header, numbers), (vec!["a\nb".into(), "\"c\"".into()], vec![1.5, -0.0, 1e300]));
        assert!(parse::<Vec<String>>(&bytes, "other").is_none());
        for place in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[place] ^= 1;
            assert!(parse::<Vec<String>>(&flipped, "kind").is_none(), "byte {place}");
            assert!(parse::<Vec<String>>(&bytes[..place], "kind").is_none(), "length {place}");
        }
    }
}
