//! OBJ text made fit for tobj 4, which fails on or misreads what real files hold:
//!
//! - several names, or a name with blanks, in one `mtllib`; tabs behind a keyword; `\` at a line's end; comments behind
//!   values; text that is not UTF-8;
//! - a fourth coordinate divides (it weighs rational curves only, and files use it for other things), a fifth is an
//!   error;
//! - polylines (`l`) come back as faces;
//! - a corner without normal takes the normal of the corner before it;
//! - an index of `vn` or `vt` before the first element overflows in its bounds test.
//!
//! So every vertex, normal, material change and face is written out anew: positions first, material names as numbers,
//! corners as absolute `v/vt/vn`. Faces are counted and checked here, where the line is known; numbers are left to tobj.

use crate::error::{Error, Result};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

/// Texture coordinates from here on count as 0: f32 leaves them too few digits to tell texels apart.
const LARGEST_COORDINATE: f32 = 1_048_576.0;

/// An OBJ's text, rewritten for tobj.
#[derive(Debug, Default)]
pub struct CleanObj {
    /// `mtllib`, `v`, `vt` and `vn` lines.
    pub vertices: String,
    /// `usemtl` and `f` lines; materials are named by their place in [`CleanObj::materials`].
    pub faces: String,
    /// Names of the materials used, in order of first use; empty: no name.
    pub materials: Vec<String>,
    /// What stands behind each `mtllib`.
    pub libraries: Vec<String>,
    /// Faces of fewer than three corners, left out.
    pub small_faces: usize,
    /// Line of the first of them.
    pub first_small_face: usize,
    /// `vn` lines that are zero or not finite.
    pub bad_normals: usize,
    /// Line of the first of them.
    pub first_bad_normal: usize,
}

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

/// How many `v`, `vt` and `vn` lines there are.
type Counts = [usize; 3];

fn count_element(counts: &mut Counts, keyword: &str) {
    match keyword {
        "v" => counts[0] += 1,
        "vt" => counts[1] += 1,
        "vn" => counts[2] += 1,
        _ => {}
    }
}

/// Rewrites the text of the OBJ file `path`.
pub fn clean_obj(path: &Path, text: &str) -> Result<CleanObj> {
    let mut totals = Counts::default();
    for (_, line) in logical_lines(text) {
        count_element(&mut totals, split_keyword(&line).0);
    }
    let mut clean = CleanObj { vertices: "mtllib all\n".into(), ..CleanObj::default() };
    let mut numbers: HashMap<String, usize> = HashMap::new();
    let mut so_far = Counts::default();
    let mut corners = Vec::new();
    for (number, line) in logical_lines(text) {
        let (keyword, rest) = split_keyword(&line);
        count_element(&mut so_far, keyword);
        match keyword {
            "v" | "vn" => {
                write_vector(&mut clean.vertices, keyword, rest);
                if keyword == "vn" && is_bad_normal(rest) {
                    clean.first_bad_normal = if clean.bad_normals == 0 { number } else { clean.first_bad_normal };
                    clean.bad_normals += 1;
                }
            }
            "vt" => write_coordinates(&mut clean.vertices, rest),
            "mtllib" if !rest.is_empty() => clean.libraries.push(rest.to_owned()),
            "usemtl" => {
                let materials = &mut clean.materials;
                let slot = *numbers.entry(rest.to_owned()).or_insert_with(|| {
                    materials.push(rest.to_owned());
                    materials.len() - 1
                });
                let _ = writeln!(clean.faces, "usemtl {slot}"); // writing to a String cannot fail
            }
            "f" => {
                read_corners(rest, so_far, totals, &mut corners)
                    .map_err(|message| Error::parse(path, Some(number), message))?;
                write_face(&mut clean, &corners, totals, number);
            }
            _ => {}
        }
    }
    if totals[1] > 0 {
        clean.vertices.push_str("vt 0 0\n"); // the coordinates of corners that have none
    }
    if totals[2] > 0 {
        clean.vertices.push_str("vn 0 0 0\n"); // the normal of corners that have none
    }
    Ok(clean)
}

/// The keyword and its first three values; whether they are numbers is for tobj to say.
fn write_vector(out: &mut String, keyword: &str, rest: &str) {
    out.push_str(keyword);
    for word in values(rest).take(3) {
        out.push(' ');
        out.push_str(word);
    }
    out.push('\n');
}

/// Two texture coordinates. A third is for volumes; one that is missing or no number, as 0, loses no geometry.
fn write_coordinates(out: &mut String, rest: &str) {
    let mut numbers = values(rest).map(|word| word.parse::<f32>().ok().filter(|t| t.abs() < LARGEST_COORDINATE));
    let mut next = || numbers.next().flatten().unwrap_or(0.0);
    let _ = writeln!(out, "vt {} {}", next(), next()); // writing to a String cannot fail
}

/// Whether a `vn` line's numbers have no direction. (Words that are no numbers are for tobj to refuse.)
fn is_bad_normal(rest: &str) -> bool {
    let numbers = || values(rest).take(3).filter_map(|word| word.parse::<f32>().ok());
    numbers().any(|x| !x.is_finite()) || numbers().all(|x| x == 0.0)
}

/// A face's corners: places from 1 of position, texture coordinates and normal, 0 for none.
fn read_corners(
    rest: &str,
    so_far: Counts,
    totals: Counts,
    corners: &mut Vec<[usize; 3]>,
) -> std::result::Result<(), String> {
    corners.clear();
    for word in values(rest) {
        let mut places = [0; 3];
        for (i, field) in word.split('/').enumerate() {
            let Some(place) = places.get_mut(i) else {
                return Err(format!("face corner `{word}` has more than the three parts v/vt/vn"));
            };
            // Indices into vt or vn that the file does not have at all are harmless leftovers of an export.
            let leftover = i > 0 && totals[i] == 0;
            if !field.is_empty() && !leftover {
                *place = resolve(field, so_far[i], totals[i])
                    .ok_or_else(|| index_fault(word, field, ["v", "vt", "vn"][i], so_far[i], totals[i]))?;
            }
        }
        if places[0] == 0 {
            return Err(format!("face corner `{word}` names no vertex; write v, v/vt, v//vn or v/vt/vn"));
        }
        corners.push(places);
    }
    Ok(())
}

/// The place from 1 that an index means: from the start, or, if negative, back from the last element so far.
fn resolve(field: &str, so_far: usize, total: usize) -> Option<usize> {
    let index: i64 = field.parse().ok()?;
    let place = if index < 0 { i64::try_from(so_far).ok()?.checked_add(index)?.checked_add(1)? } else { index };
    usize::try_from(place).ok().filter(|place| (1..=total).contains(place))
}

fn index_fault(word: &str, field: &str, element: &str, so_far: usize, total: usize) -> String {
    if field.parse::<i64>().is_err() {
        return format!("face corner `{word}`: `{field}` is not a whole number");
    }
    format!(
        "face corner `{word}`: there is no `{element}` number {field} (the file has {total}, {so_far} of them above \
         this line; numbers start at 1, or at -1 counting back)"
    )
}

fn write_face(clean: &mut CleanObj, corners: &[[usize; 3]], totals: Counts, line: usize) {
    if corners.len() < 3 {
        if clean.small_faces == 0 {
            clean.first_small_face = line;
        }
        clean.small_faces += 1;
        return;
    }
    clean.faces.push('f');
    let or_last = |place: usize, total: usize| if place == 0 { total + 1 } else { place };
    for &[v, vt, vn] in corners {
        let (vt, vn) = (or_last(vt, totals[1]), or_last(vn, totals[2]));
        // Writing to a String cannot fail.
        let _ = match (totals[1] > 0, totals[2] > 0) {
            (false, false) => write!(clean.faces, " {v}"),
            (false, true) => write!(clean.faces, " {v}//{vn}"),
            (true, false) => write!(clean.faces, " {v}/{vt}"),
            (true, true) => write!(clean.faces, " {v}/{vt}/{vn}"),
        };
    }
    clean.faces.push('\n');
}

/// The second pass, when tobj refuses a file or a vertex is no number that `fits`: the line to blame and why.
pub fn find_bad_number(text: &str, fits: impl Fn(f64) -> bool) -> Option<(usize, String)> {
    logical_lines(text).find_map(|(number, line)| {
        let (keyword, rest) = split_keyword(&line);
        if !matches!(keyword, "v" | "vn") {
            return None;
        }
        let words: Vec<&str> = values(rest).take(3).collect();
        if words.len() < 3 {
            return Some((number, format!("`{keyword}` needs three numbers; it has {}", words.len())));
        }
        let bad = |word: &&&str| !word.parse::<f64>().is_ok_and(|x| fits(x) || keyword == "vn");
        let word = words.iter().find(bad)?;
        Some((number, format!("`{word}` is not a finite number that fits f32; write a plain decimal such as 1.5e-3")))
    })
}
