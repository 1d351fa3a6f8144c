//! The lines of OBJ and MTL text, and their words.

use std::borrow::Cow;

/// The lines of a text. A lone CR ends one as LF and CR LF do: old programs write nothing else, and files that were put together
/// have both.
struct RawLines<'a> {
    /// What is left of the line at hand, up to its LF.
    line: Option<&'a str>,
    /// What stands behind that.
    text: &'a str,
}

impl<'a> Iterator for RawLines<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let line = match self.line.take() {
            Some(line) => line,
            None if self.text.is_empty() => return None,
            None => {
                let (line, text) = self.text.split_once('\n').unwrap_or((self.text, ""));
                self.text = text;
                // Conversion of what had been converted leaves several CRs: still one end.
                line.trim_end_matches('\r')
            }
        };
        let Some((first, more)) = line.split_once('\r') else { return Some(line) };
        self.line = Some(more);
        Some(first)
    }
}

/// The lines of a text with their numbers from 1, those that end in `\` joined with the next; comments are not joined,
/// they may well end in a Windows path.
pub fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = RawLines { line: None, text }.enumerate();
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

/// The keyword of `known` that `word` is, in whatever capitals: programs write `Usemtl` and `KD`, too. Another word is itself.
pub fn canonical<'a>(word: &'a str, known: &[&'static str]) -> &'a str {
    known.iter().find(|keyword| keyword.eq_ignore_ascii_case(word)).copied().unwrap_or(word)
}

/// The words of a line's values: what stands before a comment.
pub fn values(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|word| !word.starts_with('#'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(text: &str) -> Vec<(usize, String)> {
        logical_lines(text).map(|(number, line)| (number, line.into_owned())).collect()
    }

    #[test]
    fn every_line_end_is_one() {
        let expected = [(1, "a".into()), (2, "".into()), (3, "b c".into())];
        for text in ["a\n\nb c", "a\r\n\r\nb c\r\n", "a\r\rb c\r", "a\r\r\n\r\nb c", "a\n\rb c\n", "a\r\r b c \n"] {
            assert_eq!(numbered(text), expected, "{text:?}");
        }
        assert_eq!(numbered("a\\\rb\\\r\nc\\\nd\re"), [(1, "a b c d".into()), (5, "e".into())]);
        assert_eq!(numbered("# a\\\rb"), [(1, "# a\\".into()), (2, "b".into())]);
        assert_eq!((numbered(""), numbered("\n")), (vec![], vec![(1, "".into())]));
    }

    #[test]
    fn keywords_have_any_capitals() {
        for (word, meant) in [("v", "v"), ("V", "v"), ("USEMTL", "usemtl"), ("UseMtl", "usemtl"), ("vx", "vx")] {
            assert_eq!(canonical(word, &["v", "vt", "usemtl"]), meant);
        }
    }
}
