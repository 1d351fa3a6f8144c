//! "Did you mean": the known word nearest to an unknown one.

/// The letters of a word that count: longer ones are never a slip of a known one.
const MOST_LETTERS: usize = 64;

/// The word of `known` with the smallest edit distance to `word`; the first of equals. `None` if `known` is empty. Of long words
/// the first 64 letters count, so that the costs are those of `known` alone: some 100 ns a word.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let pattern = Pattern::new(word);
    known.into_iter().min_by_key(|candidate| pattern.distance(candidate))
}

/// The word of `known` that a slip of the keys may have turned into `word`: one in three letters wrong at most, or one at all,
/// upper and lower case alike; else the only one that has `word` in it. `None` where nothing is near enough to be meant.
pub fn close<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let known: Vec<&str> = known.into_iter().collect();
    if word.chars().nth(MOST_LETTERS).is_some() {
        return None;
    }
    let lower = word.to_lowercase();
    let pattern = Pattern::new(&lower);
    let distance = |candidate: &str| pattern.distance(&candidate.to_lowercase());
    let most = (word.chars().count() / 3).max(1);
    let near = known.iter().min_by_key(|candidate| distance(candidate)).filter(|near| distance(near) <= most);
    // Words of one or two letters are near everything of their length, and part of much.
    if word.chars().count() < 3 {
        return near.filter(|near| near.eq_ignore_ascii_case(word)).copied();
    }
    let mut holders = known.iter().filter(|candidate| candidate.to_lowercase().contains(&lower));
    near.or_else(|| holders.next().filter(|_| holders.next().is_none())).copied()
}

/// What `word`, which is none of `known`, may have been meant to be: the [`close`] one, or else the only one that it has the most
/// letters in a row in common with, at least three and half of the shorter (`vfov` for `vertical_fov`).
pub fn meant<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    if let Some(near) = close(word, known.iter().copied()) {
        return Some(near);
    }
    if word.chars().nth(MOST_LETTERS).is_some() {
        return None;
    }
    let lower = word.to_lowercase();
    let shared = |candidate: &str| {
        let (common, shorter) = (longest_common(&lower, candidate), lower.len().min(candidate.len()));
        if common >= 3 && 2 * common >= shorter { common } else { 0 }
    };
    let most = known.iter().map(|candidate| shared(candidate)).max().filter(|&most| most > 0)?;
    let mut best = known.iter().filter(|candidate| shared(candidate) == most);
    best.next().filter(|_| best.next().is_none()).copied()
}

/// The length in bytes of the longest run that two short words have in common.
fn longest_common(a: &str, b: &str) -> usize {
    let mut row = vec![0; b.len() + 1];
    let mut longest = 0;
    for x in a.bytes() {
        for (place, y) in b.bytes().enumerate().rev() {
            row[place + 1] = if x == y { row[place] + 1 } else { 0 };
            longest = longest.max(row[place + 1]);
        }
    }
    longest
}

/// A word that others are compared with, letter by letter: by each letter, at which of its places it stands.
struct Pattern {
    /// Of the letters that are ASCII.
    ascii: [u64; 128],
    /// Of others.
    others: Vec<(char, u64)>,
    length: usize,
}

impl Pattern {
    fn new(word: &str) -> Pattern {
        let mut pattern = Pattern { ascii: [0; 128], others: Vec::new(), length: 0 };
        for letter in word.chars().take(MOST_LETTERS) {
            let place = 1 << pattern.length;
            match pattern.ascii.get_mut(letter as usize) {
                Some(places) => *places |= place,
                None => pattern.others.push((letter, place)),
            }
            pattern.length += 1;
        }
        pattern
    }

    fn places_of(&self, letter: char) -> u64 {
        let other = || self.others.iter().filter(|other| other.0 == letter).fold(0, |all, other| all | other.1);
        self.ascii.get(letter as usize).copied().unwrap_or_else(other)
    }

    /// Insertions, deletions, substitutions and swaps of neighbours that turn the word into `text` (Damerau 1964, the
    /// restricted form): a swap counts 1 because `widht` is nearer to `width` than to anything two keys away.
    ///
    /// The table of distances between beginnings of both words is gone through column by column; one column is the bits of two
    /// numbers, which say where it rises and where it falls by one (Hyyro 2003).
    fn distance(&self, text: &str) -> usize {
        let (mut rises, mut falls) = (u64::MAX, 0u64);
        let (mut diagonal, mut last_places) = (0u64, 0u64);
        let Some(end) = self.length.checked_sub(1) else { return text.chars().take(MOST_LETTERS).count() };
        let mut distance = self.length;
        for letter in text.chars().take(MOST_LETTERS) {
            let places = self.places_of(letter);
            let swapped = ((!diagonal & places) << 1) & last_places;
            diagonal = ((places & rises).wrapping_add(rises) ^ rises) | places | falls | swapped;
            let (right_rises, right_falls) = (falls | !(diagonal | rises), diagonal & rises);
            distance = distance + (right_rises >> end & 1) as usize - (right_falls >> end & 1) as usize;
            let right_rises = right_rises << 1 | 1;
            (rises, falls) = (right_falls << 1 | !(diagonal | right_rises), right_rises & diagonal);
            last_places = places;
        }
        distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edit_distance(a: &str, b: &str) -> usize {
        Pattern::new(a).distance(b)
    }

    /// The whole table of distances.
    fn by_table(a: &str, b: &str) -> usize {
        let [a, b]: [Vec<char>; 2] = [a, b].map(|word| word.chars().take(MOST_LETTERS).collect());
        let mut table = vec![vec![0; b.len() + 1]; a.len() + 1];
        for i in 0..=a.len() {
            for j in 0..=b.len() {
                if i == 0 || j == 0 {
                    table[i][j] = i + j;
                    continue;
                }
                let substitute = table[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                table[i][j] = substitute.min(table[i - 1][j] + 1).min(table[i][j - 1] + 1);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    table[i][j] = table[i][j].min(table[i - 2][j - 2] + 1);
                }
            }
        }
        table[a.len()][b.len()]
    }

    #[test]
    fn distances_are_those_of_the_whole_table() {
        let mut random = 1u64;
        let mut below = |bound: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) % bound
        };
        for round in 0..20_000 {
            let longest = [4, 9, 70][round % 3];
            let [a, b] = [(); 2].map(|()| -> String {
                (0..below(longest)).map(|_| ['a', 'b', 'c', '\u{e9}', '\u{4e2d}'][below(5) as usize]).collect()
            });
            assert_eq!(edit_distance(&a, &b), by_table(&a, &b), "{a} {b}");
        }
    }

    #[test]
    fn words_of_megabytes_cost_no_more_than_others() {
        let long = "m".repeat(1 << 24);
        let known = vec![long.as_str(); 100_000];
        let start = std::time::Instant::now();
        assert_eq!(nearest(&long, known.iter().copied()), Some(long.as_str()));
        assert_eq!((close(&long, known.iter().copied()), close(&long, ["mm"])), (None, None));
        assert!(start.elapsed().as_secs_f64() < 5.0);
    }

    #[test]
    fn distances_count_single_slips() {
        for (a, b, distance) in [("", "", 0), ("width", "widht", 1), ("a", "", 1), ("kitten", "sitting", 3)] {
            assert_eq!((edit_distance(a, b), edit_distance(b, a)), (distance, distance), "{a} {b}");
        }
        assert_eq!(nearest("heigth", ["width", "height"]), Some("height"));
        assert_eq!(nearest("x", []), None);
    }

    #[test]
    fn words_in_common_tell_what_is_meant() {
        let known = ["position", "look_at", "up", "vertical_fov", "aperture_radius", "focus_distance", "key"];
        for (word, wanted) in [
            ("fov", Some("vertical_fov")),
            ("vfov", Some("vertical_fov")),
            ("fovy", Some("vertical_fov")),
            ("FOV", Some("vertical_fov")),
            ("camera_position", Some("position")),
            ("lookat", Some("look_at")),
            ("aperture", Some("aperture_radius")),
            ("focal_distance", Some("focus_distance")),
            ("keys", Some("key")),
            ("eye", None),
            ("width", None),
            ("target", None),
            ("", None),
        ] {
            assert_eq!(meant(word, &known), wanted, "{word}");
        }
        assert_eq!(meant("fov", &[]), None);
        assert_eq!((longest_common("abcab", "xcabx"), longest_common("", "a"), longest_common("a", "")), (3, 0, 0));
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
