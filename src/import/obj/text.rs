//! OBJ text taken apart: faces are parsed and checked here, where the line is known; the numbers of `v` and `vn` are left to
//! tobj ([`VectorLines`]).
//!
//! tobj 4 by itself fails on or misreads what real files hold:
//!
//! - several names, or a name with blanks, in one `mtllib`; tabs behind a keyword; `\` at a line's end; comments behind
//!   values; text that is not UTF-8;
//! - a fourth coordinate divides (it weighs rational curves only, and files use it for other things), a fifth is an
//!   error;
//! - polylines (`l`) come back as faces;
//! - a corner without normal takes the normal of the corner before it;
//! - an index of `vn` or `vt` before the first element overflows in its bounds test.

use crate::error::{Error, Result};
use crate::import::obj::corners::{Corner, Counts, read_corners};
use crate::import::obj::lines::{canonical, logical_lines, split_keyword, values};
use crate::import::obj::names;
use crate::import::obj::vectors::VectorLines;
use std::collections::{HashMap, HashSet};
use std::mem::take;
use std::path::Path;

/// Texture coordinates from here on count as 0: f32 leaves them too few digits to tell texels apart.
const LARGEST_COORDINATE: f32 = 1_048_576.0;

/// What an OBJ's text says.
#[derive(Debug, Default)]
pub struct ObjText {
    /// The `v` lines.
    pub positions: VectorLines,
    /// The `vn` lines.
    pub normals: VectorLines,
    /// The `vt` lines.
    pub coordinates: Vec<[f32; 2]>,
    /// The corners of all faces, face after face.
    pub corners: Vec<Corner>,
    /// How many of them each face has: at least three.
    pub sizes: Vec<u32>,
    /// The faces in runs of one material.
    pub runs: Vec<Run>,
    /// The materials used, in order of first use.
    pub materials: Vec<UsedMaterial>,
    /// What stands behind `mtllib`, each once in every block of such lines that no `usemtl` and no face interrupts; blocks that
    /// say the same are one.
    pub libraries: Vec<Vec<String>>,
    /// Faces of fewer than three corners, left out.
    pub small_faces: usize,
    /// Line of the first of them.
    pub first_small_face: usize,
    /// The first vertex has a colour behind its place, as scanners and sculpting programs write it.
    pub coloured: bool,
}

/// What a `usemtl` says, and where.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct UsedMaterial {
    /// The name as written; empty: no name.
    pub name: String,
    /// The block of [`ObjText::libraries`] that stands above it, if one does.
    pub block: Option<u32>,
}

/// Faces that follow one another, of one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Place in [`ObjText::materials`]; `None` before the first `usemtl`.
    pub material: Option<u32>,
    /// How many they are; at least one.
    pub faces: usize,
}

/// The blocks of `mtllib` lines as they come.
#[derive(Default)]
struct Blocks {
    /// The lines of the block that goes on.
    open: Vec<String>,
    /// The number of each block so far.
    numbers: HashMap<Vec<String>, u32>,
    /// The last that was closed.
    last: Option<u32>,
}

impl Blocks {
    /// The number of the block above what is no `mtllib` line.
    fn close(&mut self, blocks: &mut Vec<Vec<String>>) -> Option<u32> {
        if !self.open.is_empty() {
            let mut seen = HashSet::new();
            let mut block = take(&mut self.open);
            block.retain(|line| seen.insert(line.clone()));
            let number = *self.numbers.entry(block).or_insert_with_key(|block| {
                blocks.push(block.clone());
                blocks.len() as u32 - 1
            });
            self.last = Some(number);
        }
        self.last
    }
}

/// The keyword of a line, if it is one that is read in any capitals, and what stands behind it.
fn split(line: &str) -> (&str, &str) {
    let (keyword, rest) = split_keyword(line);
    (canonical(keyword, &["v", "vt", "vn", "f", "usemtl", "mtllib"]), rest)
}

/// How many `v`, `vt` and `vn` lines `text` has.
fn count_elements(text: &str) -> Counts {
    let mut counts = Counts::default();
    for (_, line) in logical_lines(text) {
        match split(&line).0 {
            "v" => counts[0] += 1,
            "vt" => counts[1] += 1,
            "vn" => counts[2] += 1,
            _ => {}
        }
    }
    counts
}

/// Takes apart the text of the OBJ file `path`.
pub fn read_text(path: &Path, text: &str) -> Result<ObjText> {
    let mut obj = ObjText::default();
    let mut numbers: HashMap<UsedMaterial, u32> = HashMap::new();
    let mut blocks = Blocks::default();
    let mut so_far = Counts::default();
    // Only faces that name what stands below them, or nothing, need the whole file counted.
    let mut totals = None;
    let mut totals = || *totals.get_or_insert_with(|| count_elements(text));
    let mut run = Run { material: None, faces: 0 };
    for (number, line) in logical_lines(text) {
        let (keyword, rest) = split(&line);
        match keyword {
            "v" => {
                if so_far[0] == 0 {
                    obj.coloured = matches!(values(rest).count(), 6 | 7);
                }
                obj.positions.push(values(rest));
                so_far[0] += 1;
            }
            "vt" => {
                obj.coordinates.push(coordinates(rest));
                so_far[1] += 1;
            }
            "vn" => {
                obj.normals.push(values(rest));
                so_far[2] += 1;
            }
            "mtllib" if names::has_control(rest) => {
                return Err(Error::parse(path, Some(number), format!("`mtllib {rest}`: {}", names::CONTROL)));
            }
            "mtllib" if !rest.is_empty() => blocks.open.push(rest.to_owned()),
            "usemtl" => {
                let used = UsedMaterial { name: rest.to_owned(), block: blocks.close(&mut obj.libraries) };
                let materials = &mut obj.materials;
                let slot = *numbers.entry(used).or_insert_with_key(|used| {
                    materials.push(used.clone());
                    materials.len() as u32 - 1
                });
                if run.material != Some(slot) {
                    obj.end_run(run);
                    run = Run { material: Some(slot), faces: 0 };
                }
            }
            "f" => {
                blocks.close(&mut obj.libraries);
                let start = obj.corners.len();
                read_corners(rest, so_far, &mut totals, &mut obj.corners)
                    .map_err(|message| Error::parse(path, Some(number), message))?;
                run.faces += usize::from(obj.end_face(start, number));
            }
            _ => {}
        }
    }
    obj.end_run(run);
    blocks.close(&mut obj.libraries);
    Ok(obj)
}

impl ObjText {
    /// The texture coordinates of a corner that names place `vt`.
    pub fn uv(&self, vt: u32) -> [f32; 2] {
        self.coordinates.get((vt as usize).wrapping_sub(1)).copied().unwrap_or_default()
    }

    /// The corners from `start` on are a face of line `line`; whether it is kept.
    fn end_face(&mut self, start: usize, line: usize) -> bool {
        let size = self.corners.len() - start;
        if size >= 3 {
            self.sizes.push(size as u32);
            return true;
        }
        self.corners.truncate(start);
        if self.small_faces == 0 {
            self.first_small_face = line;
        }
        self.small_faces += 1;
        false
    }

    fn end_run(&mut self, run: Run) {
        if run.faces > 0 {
            self.runs.push(run);
        }
    }
}

/// Two texture coordinates. A third is for volumes; one that is missing or no number, as 0, loses no geometry.
fn coordinates(rest: &str) -> [f32; 2] {
    let mut numbers = values(rest).map(|word| word.parse::<f32>().ok().filter(|t| t.abs() < LARGEST_COORDINATE));
    let mut next = || numbers.next().flatten().unwrap_or(0.0);
    [next(), next()]
}

/// The line of the `vn` number `index`, counted from 0.
pub fn line_of_normal(text: &str, index: usize) -> usize {
    let mut normals = logical_lines(text).filter(|(_, line)| split(line).0 == "vn");
    normals.nth(index).map_or(0, |(number, _)| number)
}

/// The second pass, when tobj refuses a file or a vertex is no number that `fits`: the line to blame and why.
pub fn find_bad_number(text: &str, fits: impl Fn(f64) -> bool) -> Option<(usize, String)> {
    logical_lines(text).find_map(|(number, line)| {
        let (keyword, rest) = split(&line);
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
