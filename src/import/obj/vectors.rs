//! `v` and `vn` lines through tobj 4: the numbers of all of them, in file order.
//!
//! tobj gives out only what a face names, and finds what it has given out by a hash table. So a face line that names the last
//! `NAMED_AT_ONCE` vectors follows each such block, and an `o` line that begins the next table. (One table for all of them
//! would not stay in the cache.)

use std::fmt::Write;
use tobj::{LoadError, LoadOptions};

/// Vectors a face names: 1,024 take a table of 32 KB.
const NAMED_AT_ONCE: usize = 1024;

/// Lines of three numbers, gathered for tobj to read.
#[derive(Debug, Default)]
pub struct VectorLines {
    text: String,
    /// Lines that no face names so far.
    unnamed: usize,
    /// The line that names [`NAMED_AT_ONCE`] vectors; empty before the first.
    whole_block: String,
}

impl VectorLines {
    /// Adds a line of these words; whether they are three numbers is for tobj to say.
    pub fn push<'a>(&mut self, words: impl Iterator<Item = &'a str>) {
        self.text.push('v');
        // A fourth coordinate would divide, and a fifth is an error to tobj.
        for word in words.take(3) {
            self.text.push(' ');
            self.text.push_str(word);
        }
        self.text.push('\n');
        self.unnamed += 1;
        if self.unnamed == NAMED_AT_ONCE {
            if self.whole_block.is_empty() {
                self.whole_block = naming(NAMED_AT_ONCE);
            }
            self.text.push_str(&self.whole_block);
            self.unnamed = 0;
        }
    }

    /// The numbers of all lines.
    ///
    /// # Errors
    /// Where a line does not have three numbers.
    pub fn read(mut self) -> Result<Vec<[f64; 3]>, LoadError> {
        self.text.push_str(&naming(self.unnamed));
        let options = LoadOptions { single_index: false, triangulate: false, ..LoadOptions::default() };
        let no_materials = |_: &std::path::Path| Ok(Default::default());
        let (models, _) = tobj::load_obj_buf(&mut self.text.as_bytes(), &options, no_materials)?;
        drop(self.text);
        let mut vectors = Vec::with_capacity(models.iter().map(|model| model.mesh.positions.len() / 3).sum());
        for model in models {
            vectors.extend_from_slice(model.mesh.positions.as_chunks().0);
        }
        Ok(vectors)
    }
}

/// A face of the last `count` vectors, and the end of its block.
fn naming(count: usize) -> String {
    let mut line = String::from("f");
    for back in (1..=count).rev() {
        let _ = write!(line, " -{back}"); // writing to a String cannot fail
    }
    if count == 0 { String::new() } else { line + "\no\n" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_comes_back_once_and_in_order() {
        for count in [0, 1, 2, 3, 4, 5, NAMED_AT_ONCE - 1, NAMED_AT_ONCE, NAMED_AT_ONCE + 1, 2 * NAMED_AT_ONCE, 5000] {
            let mut lines = VectorLines::default();
            // Equal vectors are not one, and words behind the third do not count.
            (0..count).for_each(|i| lines.push([&(i / 2).to_string(), "-0.1", "1e400", "0", "x"].into_iter()));
            let expected: Vec<[f64; 3]> = (0..count).map(|i| [(i / 2) as f64, -0.1, f64::INFINITY]).collect();
            assert_eq!(lines.read().unwrap(), expected);
        }
    }

    #[test]
    fn what_is_not_three_numbers_is_refused() {
        for words in ["", "1 2", "1 2 x", "1,5 2 3"] {
            let mut lines = VectorLines::default();
            lines.push(["1", "2", "3"].into_iter());
            lines.push(words.split_whitespace());
            assert!(lines.read().is_err(), "{words}");
        }
    }
}
