//! Names of files and materials as OBJ and MTL files write them.

use std::path::{Path, PathBuf};

/// What is left of a name without quotes around it and without a comment behind it. Names may hold both: this counts only where
/// nothing has the name as written.
pub fn plain(name: &str) -> &str {
    let name = name.trim();
    if let Some((quoted, behind)) = split_quoted(name)
        && (behind.is_empty() || behind.starts_with('#'))
    {
        return quoted;
    }
    match without_comment(name) {
        "" => name,
        short => short,
    }
}

/// What stands in quotes at the start of a text, if something does, and what behind them.
pub fn split_quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|letter| matches!(letter, '"' | '\''))?;
    let (quoted, behind) = text[1..].split_once(quote)?;
    let quoted = quoted.trim();
    (!quoted.is_empty()).then_some((quoted, behind.trim_start()))
}

/// A text up to the first `#` behind a blank.
pub fn without_comment(text: &str) -> &str {
    let mut marks = text.match_indices('#').map(|(place, _)| &text[..place]);
    marks.find(|before| before.is_empty() || before.ends_with(char::is_whitespace)).unwrap_or(text).trim_end()
}

/// Whether a file's name has a character that a terminal would obey. Tabs stand between names.
pub fn has_control(name: &str) -> bool {
    name.chars().any(|letter| letter.is_control() && letter != '\t')
}

/// What is wrong with a name that [`has_control`].
pub const CONTROL: &str = "names of files hold no control characters";

/// The paths that `name` may mean beside the file `from`: as written, and with the slashes that exporters on Windows write as
/// backslashes.
pub fn paths(from: &Path, name: &str) -> impl Iterator<Item = PathBuf> {
    let folder = from.with_file_name("");
    let slashes = name.contains('\\').then(|| name.replace('\\', "/"));
    [Some(name.to_owned()), slashes].into_iter().flatten().map(move |name| folder.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_and_comments_are_taken_off() {
        for (name, expected) in [
            ("red", "red"),
            ("\"red\"", "red"),
            ("'two words' # x", "two words"),
            ("\"a # b\"", "a # b"),
            ("\"a\" b", "\"a\" b"),
            ("red # wall", "red"),
            ("red\t# wall # two", "red"),
            ("red#wall", "red#wall"),
            ("a#b #c", "a#b"),
            ("Material #25", "Material"),
            ("# none", "# none"),
            ("\"\"", "\"\""),
            ("\"", "\""),
            ("é\" \"", "é\" \""),
            ("", ""),
        ] {
            assert_eq!(plain(name), expected, "{name}");
        }
        assert!(has_control("a\u{1b}[31m") && has_control("a\u{9b}") && !has_control("a\tb é.mtl"));
    }
}
