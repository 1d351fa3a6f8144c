//! What the user should know, told briefly: the list is as long as what it says, not as long as the scene.

use std::borrow::Cow;
use std::collections::HashMap;

/// The most warnings a list may have.
pub const MOST_WARNINGS: usize = 64;

/// The most that are told of one kind: they say the same of other materials or files.
const MOST_OF_A_KIND: usize = 8;

/// The most bytes of a warning, and of a material's name: paths have hardly more.
pub const MOST_LETTERS: usize = 2000;

/// A warning, how often it was given, and its place among the different ones of its kind.
struct Told {
    text: String,
    times: usize,
    kind: usize,
    place: usize,
}

/// Makes `warnings` a list of at most [`MOST_WARNINGS`], in order of first occurrence: equal ones are told once with their
/// number; of those that differ only in names and numbers the first few are told, and how many more there were.
pub fn condense(warnings: &mut Vec<String>) {
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut kinds: HashMap<String, usize> = HashMap::new();
    // Of each kind, how many different ones it has.
    let mut sizes = Vec::new();
    let mut different: Vec<Told> = Vec::new();
    for text in warnings.drain(..) {
        if let Some(&place) = places.get(&text) {
            different[place].times += 1;
            continue;
        }
        let kind = *kinds.entry(kind_of(&text)).or_insert_with(|| {
            sizes.push(0);
            sizes.len() - 1
        });
        places.insert(text.clone(), different.len());
        different.push(Told { text, times: 1, kind, place: sizes[kind] });
        sizes[kind] += 1;
    }
    // Rather fewer of each kind than that a kind goes missing.
    let told = |most: usize| sizes.iter().map(|&size: &usize| size.min(most)).sum::<usize>();
    let most = (1..=MOST_OF_A_KIND).rev().find(|&most| told(most) <= MOST_WARNINGS).unwrap_or(1);
    let room = if told(most) > MOST_WARNINGS { MOST_WARNINGS - 1 } else { MOST_WARNINGS };
    let mut left_out = different.len();
    for Told { text, times, kind, place } in different.into_iter().filter(|told| told.place < most).take(room) {
        let mut line = shortened(&text, MOST_LETTERS).into_owned();
        if times > 1 {
            line += &format!(" ({times} times)");
        }
        left_out -= 1;
        let more = sizes[kind] - most.min(sizes[kind]);
        if place + 1 == most && more > 0 {
            line += &format!(" (and {more} more like this)");
            left_out -= more;
        }
        warnings.push(line);
    }
    if left_out > 0 {
        warnings.push(format!("{left_out} more warnings of other kinds are not told"));
    }
}

/// What is left of a warning without what it is about: the file in front, names in quotes, numbers.
fn kind_of(text: &str) -> String {
    let sentence = text.split_once(": ").map_or(text, |(_, sentence)| sentence);
    let outside = sentence.split('`').step_by(2).flat_map(str::chars);
    outside.filter(|letter| !letter.is_ascii_digit() && !matches!(letter, '.' | '-' | '+')).collect()
}

/// A text of at most about `most` bytes: of a longer one the beginning and the end.
pub fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    if text.len() <= most {
        return Cow::Borrowed(text);
    }
    let boundary = |place: &usize| text.is_char_boundary(*place);
    let start = (0..=most / 4 * 3).rev().find(boundary).unwrap_or(0);
    let end = (text.len() - most / 4..text.len()).find(boundary).unwrap_or(text.len());
    Cow::Owned(format!("{} [{} bytes] {}", &text[..start], end - start, &text[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn condensed(warnings: impl IntoIterator<Item = String>) -> Vec<String> {
        let mut warnings = warnings.into_iter().collect();
        condense(&mut warnings);
        warnings
    }

    #[test]
    fn few_warnings_stay_as_they_are() {
        let few = ["a.obj:4: 2 face(s) were left out", "b: c", "no camera: one at [1, 2, 3]"].map(String::from);
        assert_eq!(condensed(few.clone()), few);
        assert_eq!(condensed([]), [""; 0]);
    }

    #[test]
    fn equal_ones_are_told_once_where_they_came_first() {
        let warnings = ["x", "y", "x", "z", "x", "y"].map(String::from);
        assert_eq!(condensed(warnings), ["x (3 times)", "y (2 times)", "z"]);
    }

    #[test]
    fn of_a_kind_the_first_few_are_told_and_the_number_of_the_others() {
        let clamped = (0..1000).map(|i| format!("{i}.mtl: material `m{i}`: Kd [{i}.5, -0.0, 1.0] is outside [0, 1]"));
        let told = condensed(clamped.chain(["no camera".to_owned()]));
        assert_eq!(told.len(), MOST_OF_A_KIND + 1);
        assert_eq!(told[0], "0.mtl: material `m0`: Kd [0.5, -0.0, 1.0] is outside [0, 1]");
        assert!(told[7].ends_with("is outside [0, 1] (and 992 more like this)"), "{told:?}");
        assert_eq!(told[8], "no camera");
    }

    #[test]
    fn no_list_is_longer_than_it_may_be() {
        let letter = |i: usize| char::from(b'a' + (i % 26) as u8);
        let kinds =
            |count: usize| (0..count).map(move |i| format!("{}{}{}", letter(i), letter(i / 26), letter(i / 676)));
        // Many of some kinds: none goes missing.
        let told = condensed(kinds(50).flat_map(|kind| (0..9).map(move |i| format!("file {i}: {kind}"))));
        assert_eq!(told.len(), 50);
        assert_eq!(told[49], "file 0: xba (and 8 more like this)");
        // Too many kinds: the first are told.
        let told = condensed(kinds(10_000));
        assert_eq!((told.len(), told[63].as_str()), (MOST_WARNINGS, "9937 more warnings of other kinds are not told"));
        assert_eq!(condensed(kinds(64)).len(), 64);
    }

    #[test]
    fn a_warning_is_no_book() {
        let told = condensed([format!("material `{}` is odd", "é".repeat(1_000_000))]);
        assert!(
            told[0].len() < 2100 && told[0].starts_with("material `é") && told[0].ends_with("` is odd"),
            "{told:?}"
        );
        for most in [0, 1, 2, 3, 7, 8] {
            assert!(shortened("ééééé", most).contains(" bytes] "));
        }
        assert_eq!(shortened("ééééé", 10), "ééééé");
    }
}
