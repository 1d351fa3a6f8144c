//! Files that only this program reads, and that say whether they are whole: a line of text that names kind and version, a line
//! of JSON, many f64 (little-endian), and a checksum of all that. They are written and read piece by piece: a film may take
//! gigabytes, and no copy of it is made.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};
use crate::files::atomic::Sink;
use crate::files::{atomic, read};

/// Bytes of the checksum.
const SUM: u64 = 8;
/// Bytes moved at once.
const PIECE: usize = 1 << 16;
/// Most bytes of the line of JSON.
const MOST_HEADER: u64 = 1 << 28;

/// Writes `header` and the numbers that `numbers` gives to `path`, whole or not at all.
///
/// # Errors
/// [`Error::Write`].
pub fn write(
    path: &Path,
    magic: &str,
    header: &impl Serialize,
    numbers: impl FnOnce(&mut Writer) -> io::Result<()>,
) -> Result<()> {
    atomic::write(path, |out| {
        let mut writer = Writer { out, sum: Checksum::default(), piece: Vec::with_capacity(PIECE) };
        let header = serde_json::to_string(header).map_err(io::Error::other)?;
        writer.piece.extend_from_slice(format!("{magic}\n{header}\n").as_bytes());
        numbers(&mut writer)?;
        writer.flush()?;
        let sum = writer.sum.value();
        writer.out.write_all(&sum.to_le_bytes())
    })
}

/// Takes the numbers of a file that is being written.
pub struct Writer<'a> {
    out: &'a mut dyn Sink,
    sum: Checksum,
    piece: Vec<u8>,
}

impl Writer<'_> {
    /// The file's next numbers.
    pub fn numbers(&mut self, numbers: &[f64]) -> io::Result<()> {
        for some in numbers.chunks(PIECE / 8) {
            self.piece.extend(some.iter().flat_map(|number| number.to_le_bytes()));
            if self.piece.len() >= PIECE {
                self.flush()?;
            }
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sum.add(&self.piece);
        self.out.write_all(&self.piece)?;
        self.piece.clear();
        Ok(())
    }
}

/// What is found where such a file is looked for.
pub enum Found<H> {
    /// What was written: the header, and a reader of the numbers.
    Whole(H, Numbers),
    /// A file of this kind, but of another version of the program.
    OtherVersion,
    /// Something else, or not as it was written.
    Damaged,
}

/// Opens such a file: of the kind and version that `magic` says, a text whose last word is the version.
///
/// # Errors
/// [`Error::Read`].
pub fn open<H: DeserializeOwned>(path: &Path, magic: &str) -> Result<Found<H>> {
    let failed = |source| Error::Read { path: path.to_owned(), source };
    let mut file = BufReader::with_capacity(PIECE, read::open(path)?);
    let Some(length) = whole(&mut file).map_err(failed)? else { return Ok(Found::Damaged) };
    file.rewind().map_err(failed)?;
    let mut line = Vec::new();
    let mut next_line = |file: &mut BufReader<File>| -> io::Result<Option<Vec<u8>>> {
        line.clear();
        file.by_ref().take(MOST_HEADER).read_until(b'\n', &mut line)?;
        Ok(line.strip_suffix(b"\n").map(<[u8]>::to_vec))
    };
    let kind = next_line(&mut file).map_err(failed)?.unwrap_or_default();
    if kind != magic.as_bytes() {
        let name = magic.rsplit_once(' ').map_or(magic, |(name, _)| name);
        return Ok(if kind.starts_with(name.as_bytes()) { Found::OtherVersion } else { Found::Damaged });
    }
    let Some(header) = next_line(&mut file).map_err(failed)? else { return Ok(Found::Damaged) };
    let bytes = (length - SUM).checked_sub(kind.len() as u64 + header.len() as u64 + 2);
    match (serde_json::from_slice(&header), bytes) {
        (Ok(header), Some(bytes)) if bytes.is_multiple_of(8) => {
            Ok(Found::Whole(header, Numbers { file, left: bytes / 8 }))
        }
        _ => Ok(Found::Damaged),
    }
}

/// The length of a file whose checksum is right.
fn whole(file: &mut BufReader<File>) -> io::Result<Option<u64>> {
    let length = file.get_ref().metadata()?.len();
    let Some(mut left) = length.checked_sub(SUM) else { return Ok(None) };
    let mut sum = Checksum::default();
    while left > 0 {
        let piece = file.fill_buf()?;
        let taken = piece.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        if taken == 0 {
            return Ok(None);
        }
        sum.add(&piece[..taken]);
        file.consume(taken);
        left -= taken as u64;
    }
    let mut said = Vec::new();
    file.take(SUM + 1).read_to_end(&mut said)?;
    Ok((said == sum.value().to_le_bytes()).then_some(length))
}

/// The numbers of a file, in their order.
pub struct Numbers {
    file: BufReader<File>,
    left: u64,
}

impl Numbers {
    /// How many there still are.
    pub fn left(&self) -> u64 {
        self.left
    }

    /// The next `N` numbers.
    pub fn array<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.next()?;
        }
        Some(numbers)
    }
}

/// The next number; `None` behind the last, or if the file cannot be read any more.
impl Iterator for Numbers {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        self.left = self.left.checked_sub(1)?;
        let mut bytes = [0; 8];
        self.file.read_exact(&mut bytes).ok()?;
        Some(f64::from_le_bytes(bytes))
    }
}

/// A checksum of 64 bits, word by word: no change within one word goes unseen, and none of two bits anywhere. (FNV-1a's step on
/// whole words, and then the upper half into the lower one: else two changed signs of numbers that follow one another would
/// cancel.)
#[derive(Clone)]
pub struct Checksum {
    state: u64,
    /// What does not fill a word yet.
    rest: [u8; 8],
    length: u64,
}

impl Default for Checksum {
    fn default() -> Checksum {
        Checksum { state: 0xcbf2_9ce4_8422_2325, rest: [0; 8], length: 0 }
    }
}

impl Checksum {
    /// Takes `bytes` in; how they are cut into pieces does not matter.
    pub fn add(&mut self, mut bytes: &[u8]) {
        let filled = (self.length % 8) as usize;
        self.length += bytes.len() as u64;
        if filled > 0 {
            let (first, others) = bytes.split_at(bytes.len().min(8 - filled));
            self.rest[filled..filled + first.len()].copy_from_slice(first);
            if filled + first.len() < 8 {
                return;
            }
            (self.state, bytes) = (step(self.state, self.rest), others);
        }
        let (words, rest) = bytes.as_chunks::<8>();
        self.state = words.iter().fold(self.state, |state, word| step(state, *word));
        self.rest[..rest.len()].copy_from_slice(rest);
    }

    /// The checksum of all that was taken in.
    pub fn value(&self) -> u64 {
        let filled = (self.length % 8) as usize;
        let mut last = [0; 8];
        last[..filled].copy_from_slice(&self.rest[..filled]);
        step(step(self.state, last), self.length.to_le_bytes())
    }
}

fn step(state: u64, word: [u8; 8]) -> u64 {
    let state = (state ^ u64::from_le_bytes(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    state ^ state >> 32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(path: &Path, magic: &str) -> Option<(Vec<String>, Vec<f64>)> {
        match open(path, magic).unwrap() {
            Found::Whole(header, numbers) => Some((header, numbers.collect())),
            _ => None,
        }
    }

    #[test]
    fn every_damaged_byte_is_seen() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        let numbers = [1.5, -0.0, 1e300];
        write(&path, "kind, version 2", &["a\nb", "\"c\""], |out| out.numbers(&numbers)).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let expected = (vec!["a\nb".to_owned(), "\"c\"".to_owned()], numbers.to_vec());
        assert_eq!(read(&path, "kind, version 2"), Some(expected));
        assert!(matches!(open::<Vec<String>>(&path, "kind, version 3"), Ok(Found::OtherVersion)));
        assert!(matches!(open::<Vec<String>>(&path, "other, version 2"), Ok(Found::Damaged)));
        for place in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[place] ^= 1;
            for damaged in [&flipped[..], &bytes[..place], &[&bytes[..], &bytes[..=place]].concat()] {
                std::fs::write(&path, damaged).unwrap();
                assert!(matches!(open::<Vec<String>>(&path, "kind, version 2"), Ok(Found::Damaged)), "byte {place}");
            }
        }
    }

    #[test]
    fn two_flipped_bits_anywhere_are_seen() {
        let bytes: Vec<u8> = (0..40u8).map(|byte| byte.wrapping_mul(97)).collect();
        let sum = |bytes: &[u8]| {
            let mut sum = Checksum::default();
            sum.add(bytes);
            sum.value()
        };
        let whole = sum(&bytes);
        let bits = bytes.len() * 8;
        for first in 0..bits {
            for second in 0..first {
                let mut flipped = bytes.clone();
                flipped[first / 8] ^= 1 << (first % 8);
                flipped[second / 8] ^= 1 << (second % 8);
                assert_ne!(sum(&flipped), whole, "bits {first} and {second}");
            }
        }
    }

    #[test]
    fn pieces_do_not_matter_and_zeros_at_the_end_do() {
        let bytes: Vec<u8> = (0..100).collect();
        let mut whole = Checksum::default();
        whole.add(&bytes);
        for piece in 1..30 {
            let mut pieces = Checksum::default();
            bytes.chunks(piece).for_each(|piece| pieces.add(piece));
            assert_eq!(pieces.value(), whole.value(), "{piece}");
        }
        let mut longer = whole.clone();
        longer.add(&[0]);
        assert_ne!(longer.value(), whole.value());
    }
}
