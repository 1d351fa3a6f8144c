//! "Did you mean": the known word nearest to an unknown one.

/// The word of `known` with the smallest edit distance to `word`; the first of equals. `None` if `known` is empty.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known.into_iter().min_by_key(|candidate| edit_distance(word, candidate))
}

/// The word of `known` that a slip of the keys may have turned into `word`: one in three letters wrong at most, or one at all,
/// upper and lower case alike; else the only one that has `word` in it. `None` where nothing is near enough to be meant.
pub fn close<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let known: Vec<&str> = known.into_iter().collect();
    let lower = word.to_lowercase();
    let distance = |candidate: &str| edit_distance(&lower, &candidate.to_lowercase());
    let most = (word.chars().count() / 3).max(1);
    let near = known.iter().min_by_key(|candidate| distance(candidate)).filter(|near| distance(near) <= most);
    // Words of one or two letters are near everything of their length, and part of much.
    if word.chars().count() < 3 {
        return near.filter(|near| near.eq_ignore_ascii_case(word)).copied();
    }
    let mut holders = known.iter().filter(|candidate| candidate.to_lowercase().contains(&lower));
    near.or_else(|| holders.next().filter(|_| holders.next().is_none())).copied()
}

/// Insertions, deletions, substitutions and swaps of neighbours that turn `a` into `b` (Damerau 1964, the restricted
/// form): a swap counts 1 because `widht` is nearer to `width` than to anything two keys away.
fn edit_distance(a: &str, b: &str) -> usize {
    // Long words cost quadratic time and are never a slip of a known one.
    let a: Vec<char> = a.chars().take(64).collect();
    let b: Vec<char> = b.chars().take(64).collect();
    let mut before_last: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let substitute = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = substitute.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(before_last[j - 2] + 1);
            }
            row.push(best);
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_count_single_slips() {
        for (a, b, distance) in [("", "", 0), ("width", "widht", 1), ("a", "", 1), ("kitten", "sitting", 3)] {
            assert_eq!((edit_distance(a, b), edit_distance(b, a)), (distance, distance), "{a} {b}");
        }
        assert_eq!(nearest("heigth", ["width", "height"]), Some("height"));
        assert_eq!(nearest("x", []), None);
    }

    #[test]
    fn only_what_may_be_meant_is_close() {
        let known = ["uniform", "nee", "nee-average", "mis-balance", "mis-power"];
        for (word, wanted) in [
            ("mis-powr", Some("mis-power")),
            ("MIS-POWER", Some("mis-power")),
            ("mispower", Some("mis-power")),
            ("unifrom", Some("uniform")),
            ("ne", None),
            ("NEE", Some("nee")),
            ("nes", Some("nee")),
            ("balance", Some("mis-balance")),
            ("average", Some("nee-average")),
            ("mis-", None),
            ("magic", None),
            ("", None),
            ("x", None),
        ] {
            assert_eq!(close(word, known), wanted, "{word}");
        }
        assert_eq!(close("nee", []), None);
    }
}
