//! Reads tables of a TOML document key by key and says file, line, fault and remedy when something does not fit.

use crate::error::{Error, Result};
use crate::nearest::meant;
use crate::scene::validate::{MOST_RADIANCE, fits_f32, is_radiance};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Where the lines of a text end: which line a byte is in is asked for every table, and must not cost a look at all of it.
pub struct Lines(Vec<usize>);

impl Lines {
    /// The lines of `text`.
    pub fn of(text: &str) -> Lines {
        Lines(text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(place, _)| place).collect())
    }

    /// The line, from 1, of the byte at `place`; behind the text, the last.
    fn at(&self, place: usize) -> usize {
        1 + self.0.partition_point(|&end| end < place)
    }
}

/// A TOML file and the lines of its text.
#[derive(Clone, Copy)]
pub struct Document<'a> {
    /// The file, as it was named.
    pub path: &'a Path,
    /// Its lines.
    pub lines: &'a Lines,
}

impl<'a> Document<'a> {
    /// The error `message` at the line where `span` begins.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> Error {
        Error::parse(self.path, Some(self.line(span)), message)
    }

    /// The line, from 1, where `span` begins.
    pub fn line(&self, span: Range<usize>) -> usize {
        self.lines.at(span.start)
    }

    /// What TOML itself cannot read, in one line.
    pub fn syntax_error(&self, error: &toml::de::Error) -> Error {
        let message = format!("not TOML: {}", error.message().replace('\n', ", "));
        // A fault at the end of the text has a span just behind it.
        Error::parse(self.path, error.span().map(|span| self.line(span)), message)
    }

    /// A view of `value` as the table called `name`.
    pub fn table<'d>(&self, name: impl Into<String>, value: &'d Spanned<DeValue<'d>>) -> Result<Table<'d>>
    where
        'a: 'd,
    {
        let name = name.into();
        match value.get_ref() {
            DeValue::Table(entries) => Ok(Table { document: *self, name, span: value.span(), entries }),
            DeValue::Array(items) if !items.is_empty() && items.iter().all(|item| item.get_ref().is_table()) => {
                Err(self
                    .error(value.span(), format!("{name} may stand only once: write one table with single brackets")))
            }
            other => Err(self.error(value.span(), format!("{name} must be a table, not {}", a_kind(other)))),
        }
    }
}

/// The kind of a value, with its article.
fn a_kind(value: &DeValue<'_>) -> String {
    let kind = value.type_str();
    let article = if kind.starts_with(['a', 'i']) { "an" } else { "a" };
    format!("{article} {kind}")
}

/// One table of a document.
pub struct Table<'a> {
    /// The document it stands in.
    pub document: Document<'a>,
    /// How messages call it, e.g. `[camera]`.
    pub name: String,
    /// Where it begins.
    pub span: Range<usize>,
    /// What it holds.
    pub entries: &'a DeTable<'a>,
}

impl<'a> Table<'a> {
    /// An error at this table's first line.
    pub fn error(&self, message: impl std::fmt::Display) -> Error {
        self.document.error(self.span.clone(), format!("{}: {message}", self.name))
    }

    /// An error at the line of `key`, or of the table if it has no such key.
    pub fn error_at(&self, key: &str, message: impl std::fmt::Display) -> Error {
        let span = self.entries.get_key_value(key).map_or(self.span.clone(), |(key, _)| key.span());
        self.document.error(span, format!("{}: {message}", self.name))
    }

    /// The line of `key`, or of the table if it has no such key.
    pub fn line_of(&self, key: &str) -> usize {
        self.document.line(self.entries.get_key_value(key).map_or(self.span.clone(), |(key, _)| key.span()))
    }

    /// Refuses keys outside `known`, naming the nearest; keys of `later` exist but this version cannot do them.
    pub fn check_keys(&self, known: &[&str], later: &[&str]) -> Result<()> {
        // In the order of the file, so that the first fault is the one reported.
        let mut keys: Vec<_> = self.entries.keys().collect();
        keys.sort_by_key(|key| key.span().start);
        for key in keys {
            let word: &str = key.get_ref();
            if later.contains(&word) {
                return Err(self.not_yet(word, &format!("`{word}`")));
            }
            if !known.contains(&word) {
                let all = [known, later].concat();
                // Where nothing is near, all that may stand here: the nearest of words that have nothing in common misleads.
                let hint = match meant(word, &all) {
                    Some(near) => format!("; did you mean `{near}`?"),
                    None => format!("; known here: {}", all.join(", ")),
                };
                return Err(self.document.error(key.span(), format!("unknown key `{word}` in {}{hint}", self.name)));
            }
        }
        Ok(())
    }

    /// The error for what the format has and this version has not.
    pub fn not_yet(&self, key: &str, what: &str) -> Error {
        self.error_at(key, format!("{what} is not supported yet by this version of octray: remove it"))
    }

    fn wrong_type(&self, key: &str, wanted: &str, value: &DeValue<'_>) -> Error {
        self.error_at(key, format!("`{key}` must be {wanted}, not {}", a_kind(value)))
    }

    /// A finite number that fits f32, if the key is there. Whole numbers count.
    pub fn number(&self, key: &str) -> Result<Option<f64>> {
        let Some(value) = self.entries.get(key) else { return Ok(None) };
        self.read_number(key, value.get_ref()).map(Some)
    }

    fn read_number(&self, key: &str, value: &DeValue<'_>) -> Result<f64> {
        let number = match value {
            DeValue::Integer(i) => i128::from_str_radix(i.as_str(), i.radix()).ok().map(|i| i as f64),
            DeValue::Float(f) => f.as_str().parse().ok(),
            other => return Err(self.wrong_type(key, "a number", other)),
        };
        match number {
            Some(x) if fits_f32(x) => Ok(x),
            _ => Err(self.error_at(key, format!("`{key}` must be finite and below 3.4e38"))),
        }
    }

    /// Three numbers, if the key is there.
    pub fn vector(&self, key: &str) -> Result<Option<[f64; 3]>> {
        let Some(value) = self.entries.get(key) else { return Ok(None) };
        let wanted = "three numbers, such as [0, 1, 0]";
        let Some(items) = value.get_ref().as_array() else {
            return Err(self.wrong_type(key, wanted, value.get_ref()));
        };
        if items.len() != 3 {
            return Err(self.error_at(key, format!("`{key}` must be {wanted}; it has {}", items.len())));
        }
        let mut vector = [0.0; 3];
        for (slot, item) in vector.iter_mut().zip(items.iter()) {
            *slot = self.read_number(key, item.get_ref())?;
        }
        Ok(Some(vector))
    }

    /// Three numbers in [0, 1], if the key is there.
    pub fn fraction(&self, key: &str) -> Result<Option<[f64; 3]>> {
        self.vector_where(key, "must lie between 0 and 1 in each channel", |x| (0.0..=1.0).contains(&x))
    }

    /// Three numbers that can be radiance, if the key is there.
    pub fn radiance(&self, key: &str) -> Result<Option<[f64; 3]>> {
        self.vector_where(key, "must not be negative", |x| x >= 0.0)?;
        let must = format!("must be at most {MOST_RADIANCE:e}, the largest radiance that works");
        self.vector_where(key, &must, is_radiance)
    }

    fn vector_where(&self, key: &str, must: &str, holds: impl Fn(f64) -> bool) -> Result<Option<[f64; 3]>> {
        match self.vector(key)? {
            Some(v) if !v.iter().all(|&x| holds(x)) => Err(self.error_at(key, format!("`{key}` is {v:?}; it {must}"))),
            fine => Ok(fine),
        }
    }

    /// A whole number in `range`, if the key is there.
    pub fn whole(&self, key: &str, range: std::ops::RangeInclusive<u32>) -> Result<Option<u32>> {
        let Some(value) = self.entries.get(key) else { return Ok(None) };
        let Some(integer) = value.get_ref().as_integer() else {
            return Err(self.wrong_type(key, "a whole number", value.get_ref()));
        };
        match u32::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(n) if range.contains(&n) => Ok(Some(n)),
            _ => {
                let (first, last) = (range.start(), range.end());
                Err(self
                    .error_at(key, format!("`{key}` is {integer}; it must be a whole number from {first} to {last}")))
            }
        }
    }

    /// A text, if the key is there.
    pub fn string(&self, key: &str) -> Result<Option<&'a str>> {
        let Some(value) = self.entries.get(key) else { return Ok(None) };
        value.get_ref().as_str().map(Some).ok_or_else(|| self.wrong_type(key, "a text in quotes", value.get_ref()))
    }

    /// true or false, if the key is there.
    pub fn boolean(&self, key: &str) -> Result<Option<bool>> {
        let Some(value) = self.entries.get(key) else { return Ok(None) };
        value.get_ref().as_bool().map(Some).ok_or_else(|| self.wrong_type(key, "true or false", value.get_ref()))
    }

    /// A table inside this one, if the key is there.
    pub fn table(&self, key: &str) -> Result<Option<Table<'a>>> {
        let Some(value) = self.entries.get(key) else { return Ok(None) };
        self.document.table(format!("{} {key}", self.name), value).map(Some)
    }

    /// The tables of the array `key`, none if it is not there; `wanted` says how they are written.
    pub fn tables(&self, key: &str, wanted: &str) -> Result<Vec<Table<'a>>> {
        let Some(value) = self.entries.get(key) else { return Ok(Vec::new()) };
        let fault = |span: Range<usize>| self.document.error(span, wanted);
        let Some(items) = value.get_ref().as_array() else { return Err(fault(value.span())) };
        let table = |item: &'a Spanned<DeValue<'a>>| match item.get_ref().is_table() {
            true => self.document.table(format!("[[{key}]]"), item),
            false => Err(fault(item.span())),
        };
        items.iter().map(table).collect()
    }

    /// `value`, or the error that `key` is missing.
    pub fn need<T>(&self, key: &str, value: Option<T>) -> Result<T> {
        value.ok_or_else(|| self.error(format!("`{key}` is missing")))
    }
}
