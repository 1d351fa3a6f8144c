//! Header attributes: settings with their types, and one order for all of them.
//!
//! The `exr` crate keeps attributes that are not OpenEXR's own in a hash map and writes them in a different order every time. So
//! the header is noted as it is written, and written once more when the file is whole, its attributes sorted by their names: it
//! is as long as before.

use crate::files::atomic::Sink;
use crate::image::encoding;
use ::exr::prelude::{AttributeValue, Text};
use std::collections::HashMap;
use std::io::{self, Seek, SeekFrom, Write};

/// Bytes before the first attribute: the magic number and the version.
const BEFORE: usize = 8;

/// Settings as attributes of their own, `octray/KEY`: whole numbers as `int`, others as `double`, what is no number as `string`.
pub(super) fn typed(metadata: &[(String, String)]) -> HashMap<Text, AttributeValue> {
    let value = |value: &str| match (value.parse::<i32>(), value.parse::<f64>()) {
        (Ok(number), _) => AttributeValue::I32(number),
        (_, Ok(number)) if number.is_finite() => AttributeValue::F64(number),
        _ => AttributeValue::Text(text(value)),
    };
    metadata.iter().map(|(key, words)| (text(&format!("octray/{}", key.replace(' ', "_"))), value(words))).collect()
}

/// Header text in UTF-8, which the official library's readers take it for.
pub(super) fn text(content: &str) -> Text {
    Text::from_bytes_unchecked(content.bytes().collect())
}

/// A sink that notes the bytes it is given first.
pub(super) struct Noted<'a> {
    out: &'a mut dyn Sink,
    /// What lies at the beginning of the file.
    head: Vec<u8>,
    position: u64,
}

/// Headers are shorter by far.
const MOST_NOTED: usize = 1 << 20;

impl<'a> Noted<'a> {
    /// One at the beginning of `out`.
    pub(super) fn new(out: &'a mut dyn Sink) -> Noted<'a> {
        Noted { out, head: Vec::new(), position: 0 }
    }

    /// Sorts the attributes of the header that has been written.
    pub(super) fn sort(self) -> io::Result<()> {
        let sorted = sorted(&self.head).ok_or_else(|| encoding("the header is no OpenEXR header"))?;
        self.out.seek(SeekFrom::Start(BEFORE as u64))?;
        self.out.write_all(&sorted)?;
        self.out.seek(SeekFrom::End(0)).map(|_| ())
    }
}

impl Write for Noted<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        if self.position == self.head.len() as u64 {
            let room = MOST_NOTED - self.head.len();
            self.head.extend_from_slice(&bytes[..written.min(room)]);
        }
        self.position += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl Seek for Noted<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.position = self.out.seek(to)?;
        Ok(self.position)
    }
}

/// The attributes of a file that begins with `head`, without what lies before them, sorted by name; `None` if it is no file of one
/// part.
fn sorted(head: &[u8]) -> Option<Vec<u8>> {
    let mut rest = head.get(BEFORE..)?;
    let mut attributes: Vec<(&[u8], &[u8])> = Vec::new();
    loop {
        // A name and a type, each ended by a 0, the length, the value; an empty name ends the header.
        let name = rest.get(..rest.iter().position(|byte| *byte == 0)?)?;
        if name.is_empty() {
            break;
        }
        let of_type = rest.get(name.len() + 1..)?;
        let at = name.len() + 1 + of_type.iter().position(|byte| *byte == 0)? + 1;
        let length = u32::from_le_bytes(rest.get(at..at + 4)?.try_into().ok()?) as usize;
        let (attribute, after) = rest.split_at_checked(at + 4 + length)?;
        attributes.push((name, attribute));
        rest = after;
    }
    attributes.sort_unstable();
    Some(attributes.iter().flat_map(|(_, attribute)| attribute.iter().copied()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_have_the_types_that_they_look_like() {
        let pairs =
            [("spp", "64"), ("a seed", "4000000000"), ("error", "0.5"), ("max_depth", "unbounded"), ("x", "nan")];
        let typed = typed(&pairs.map(|(key, value)| (key.to_owned(), value.to_owned())));
        let of = |key: &str| typed[&text(key)].clone();
        assert_eq!(of("octray/spp"), AttributeValue::I32(64));
        assert_eq!((of("octray/a_seed"), of("octray/error")), (AttributeValue::F64(4e9), AttributeValue::F64(0.5)));
        let words = |word: &str| AttributeValue::Text(text(word));
        assert_eq!((of("octray/max_depth"), of("octray/x")), (words("unbounded"), words("nan")));
    }

    #[test]
    fn attributes_are_sorted_and_none_is_lost() {
        let attribute = |name: &str, value: &[u8]| {
            [name.as_bytes(), b"\0string\0", &(value.len() as u32).to_le_bytes(), value].concat()
        };
        let (a, b, c) = (attribute("a", b""), attribute("b", b"1\x002"), attribute("ba", b"xyz"));
        let file = [b"12345678", &c[..], &a, &b, b"\0pixels"].concat();
        assert_eq!(sorted(&file), Some([a, b, c].concat()));
        // What is cut off, or ends in the middle, is no header.
        assert!((0..file.len() - 7).all(|length| sorted(&file[..length]).is_none()));
    }
}
