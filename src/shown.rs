//! Text of files and names as messages may show it: nothing that a terminal would obey, and no more than a reader will read.

use std::borrow::Cow;
use std::path::Path;

/// Characters of one message, at most: what is longer loses its middle.
const MOST: usize = 2000;

/// `text` with every character that a terminal may take for a command written as `\u{..}`, and cut to what can be read. Line
/// ends stay: messages have them.
pub fn shown(text: &str) -> Cow<'_, str> {
    if text.len() <= MOST && !text.chars().any(is_command) {
        return Cow::Borrowed(text);
    }
    // A character is written with up to ten; bytes bound characters from above.
    if text.len() <= MOST {
        return Cow::Owned(escaped(text));
    }
    let half = MOST / 2;
    // A character has four bytes at most, and one of its boundaries is among any four places.
    let boundary = |place: &usize| text.is_char_boundary(*place);
    let start = (half - 3..=half).rev().find(boundary).unwrap_or(0);
    let end = (text.len() - half..).find(boundary).unwrap_or(text.len());
    let (first, last) = (escaped(&text[..start]), escaped(&text[end..]));
    Cow::Owned(format!("{first} [... {} bytes ...] {last}", end - start))
}

/// [`shown`] for output that is as long as it is meant to be: only escaped.
pub fn escaped(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        if is_command(c) { plain.extend(c.escape_unicode()) } else { plain.push(c) }
    }
    plain
}

/// [`shown`] of a path.
pub fn shown_path(path: &Path) -> String {
    shown(&path.display().to_string()).into_owned()
}

/// Control characters but for line ends and tabs, and those that turn the direction of writing, by which one text can look like
/// another.
fn is_command(c: char) -> bool {
    let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{61c}');
    (c.is_control() && c != '\n' && c != '\t') || turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_shown_and_text_is_left() {
        for text in ["", "scenes/größe.toml: \u{4f60}\u{597d}", "two\nlines\tand a tab"] {
            assert!(matches!(shown(text), Cow::Borrowed(same) if same == text));
        }
        assert_eq!(shown("a\u{1b}]0;x\u{7}b\r\u{9b}\u{202e}"), r"a\u{1b}]0;x\u{7}b\u{d}\u{9b}\u{202e}");
        assert_eq!(shown_path(Path::new("a\u{1b}b")), r"a\u{1b}b");
    }

    #[test]
    fn long_text_loses_its_middle() {
        let long = format!("start{}end", "ä".repeat(1_000_000));
        let short = shown(&long);
        assert!(short.starts_with("startä") && short.ends_with("äend") && short.contains(" bytes ...] "), "{short}");
        assert!(short.len() < MOST + 100);
        assert!(shown(&"\u{1b}".repeat(1 << 20)).len() < 20 * MOST);
    }
}
