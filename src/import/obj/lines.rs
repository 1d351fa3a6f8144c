//! The lines of OBJ and MTL text, and their words.

use std::borrow::Cow;

/// The lines of a text with their numbers from 1, those that end in `\` joined with the next; comments are not joined,
/// they may well end in a Windows path.
pub fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let first = first.trim();
        let Some(start) = first.strip_suffix('\\').filter(|start| !start.starts_with('#')) else {
            return Some((index + 1, Cow::Borrowed(first)));
        };
        let mut joined = start.to_owned();
        for (_, next) in lines.by_ref() {
            let next = next.trim();
            joined.push(' ');
            match next.strip_suffix('\\') {
                Some(more) => joined.push_str(more),
                None => {
                    joined.push_str(next);
                    break;
                }
            }
        }
        Some((index + 1, Cow::Owned(joined)))
    })
}

/// A line's first word, and what stands behind it.
pub fn split_keyword(line: &str) -> (&str, &str) {
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (keyword, rest.trim())
}

/// The words of a line's values: what stands before a comment.
pub fn values(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|word| !word.starts_with('#'))
}
