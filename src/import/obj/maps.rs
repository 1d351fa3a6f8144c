//! The pictures that MTL lines name (`map_Kd -s 2 2 red.png`), and the lines of those that are not read.

use crate::error::{Error, Result};
use crate::files::read;
use crate::import::obj::lines::split_keyword;
use crate::import::obj::names;
use std::path::{Path, PathBuf};

/// A picture that an MTL names.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureRef {
    /// The file.
    pub path: PathBuf,
    /// Option -s: factors on the coordinates.
    pub scale: [f64; 2],
    /// Option -o: added to them.
    pub offset: [f64; 2],
    /// The colour beside it is black or missing: without the picture there is none.
    pub alone: bool,
}

/// The pictures of one material.
#[derive(Clone, Debug, Default)]
pub struct Maps {
    /// map_Kd.
    pub colour: Option<TextureRef>,
    /// map_Ke.
    pub emission: Option<TextureRef>,
    /// map_d.
    pub alpha_mask: Option<TextureRef>,
}

/// What the options of a line say.
struct Options {
    scale: [f64; 2],
    offset: [f64; 2],
    /// Those without effect.
    ignored: Vec<String>,
}

impl Options {
    /// Takes an option off the start of `text`; `None` where none stands there.
    fn take<'a>(&mut self, text: &'a str) -> Option<&'a str> {
        let (option, mut behind) = split_keyword(text);
        let option = option.to_ascii_lowercase();
        let (fewest, most) = match option.as_str() {
            "-s" | "-o" | "-t" => (1, 3),
            "-mm" => (2, 2),
            "-bm" | "-boost" | "-texres" | "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-type" => (1, 1),
            _ => return None, // or a file name with a dash in front
        };
        let mut numbers = Vec::new();
        for place in 0..most {
            let (word, next) = split_keyword(behind);
            let number = word.parse::<f64>().ok().filter(|x| x.abs() < 1e6);
            if place >= fewest && number.is_none() {
                break;
            }
            numbers.push(number);
            behind = next;
        }
        let target = match option.as_str() {
            "-s" => &mut self.scale,
            "-o" => &mut self.offset,
            _ => {
                self.ignored.push(option);
                return Some(behind);
            }
        };
        numbers.iter().zip(target).for_each(|(number, slot)| *slot = number.unwrap_or(*slot));
        Some(behind)
    }

    /// Takes all options off the start of `text`.
    fn take_all<'a>(&mut self, text: &'a str) -> &'a str {
        let mut rest = text.trim();
        while let Some(behind) = self.take(rest) {
            rest = behind;
        }
        rest
    }
}

/// The file that a line `keyword text` of the MTL file `mtl` names, in the material `material`, and what its options say; they may
/// stand before the name or behind it. `None` where no name is left.
///
/// # Errors
/// Where the name is that of a device or a pipe, or has control characters.
pub fn texture_ref(
    mtl: &Path,
    line: usize,
    material: &str,
    [keyword, text]: [&str; 2],
    warnings: &mut Vec<String>,
) -> Result<Option<TextureRef>> {
    let fault = |why: String| Error::parse(mtl, Some(line), why);
    if names::has_control(text) {
        return Err(fault(format!("`{keyword} {text}`: {}", names::CONTROL)));
    }
    let mut options = Options { scale: [1.0; 2], offset: [0.0; 2], ignored: Vec::new() };
    let rest = options.take_all(text);
    let Some(path) = find(mtl, rest, &mut options) else { return Ok(None) };
    // What is missing is missed; what never ends, or waits for somebody to write, was put there by no exporter.
    if read::is_special(&path) {
        return Err(fault(format!("{keyword}: {} is a device or a pipe; only regular files are read", path.display())));
    }
    let Options { scale, offset, ignored } = options;
    if !ignored.is_empty() {
        let (file, options) = (mtl.display(), ignored.join(" "));
        warnings.push(format!("{file}: material `{material}`: texture options {options} have no effect"));
    }
    Ok(Some(TextureRef { path, scale, offset, alone: false }))
}

/// The file that `rest` names: as written if that exists; else without quotes and comments, else without options behind it.
fn find(mtl: &Path, rest: &str, options: &mut Options) -> Option<PathBuf> {
    let existing = |name: &str| names::paths(mtl, name).find(|path| path.exists());
    // Of a name that does not exist at all, what it is called.
    let missing = |name: &str| names::paths(mtl, name).last();
    if rest.is_empty() || rest.starts_with('#') && existing(rest).is_none() {
        return None;
    }
    if let Some(path) = existing(rest).or_else(|| existing(names::plain(rest))) {
        return Some(path);
    }
    let behind = |options: &mut Options, text: &str| options.take_all(text).is_empty();
    if let Some((quoted, more)) = names::split_quoted(rest) {
        behind(options, names::without_comment(more));
        return existing(quoted).or_else(|| missing(quoted));
    }
    let text = names::without_comment(rest);
    let dashes = text.match_indices(" -").chain(text.match_indices("\t-")).map(|(place, _)| place);
    // A name may have a blank and a dash in it: the first from which on there is nothing but options.
    let mut trial = Options { scale: [1.0; 2], offset: [0.0; 2], ignored: Vec::new() };
    let end = dashes.take(MOST_DASHES).filter(|&place| behind(&mut trial, &text[place..])).min();
    match end {
        Some(end) => {
            behind(options, &text[end..]);
            let name = text[..end].trim_end();
            existing(name).or_else(|| missing(name))
        }
        None => missing(rest),
    }
}

/// Dashes that are tried as the beginning of options: there are ten options.
const MOST_DASHES: usize = 32;

/// Pictures that an MTL can name and no material here can show, by their keywords. Of `map_Ka`, the picture of ambient light,
/// nothing is missed where light is followed.
const UNREAD: [&str; 15] = [
    "map_Bump", "bump", "norm", "map_Ks", "map_Ns", "map_Pr", "map_Pm", "map_Ps", "map_Tr", "map_refl", "refl", "disp",
    "map_disp", "decal", "map_RMA",
];

/// Lines that are not read, counted by keyword.
#[derive(Default)]
pub struct Unread {
    counts: [usize; UNREAD.len()],
    /// Lines of other keywords that begin with `map_`, and the first of them.
    others: usize,
    first: Option<(usize, String)>,
}

impl Unread {
    /// Counts the line `number` if it names a picture.
    pub fn count(&mut self, number: usize, keyword: &str) {
        if let Some(place) = UNREAD.iter().position(|known| known.eq_ignore_ascii_case(keyword)) {
            self.counts[place] += 1;
        } else if keyword.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("map_"))
            && !["map_Ka", "map_aat"].iter().any(|lost| lost.eq_ignore_ascii_case(keyword))
        {
            self.others += 1;
            self.first.get_or_insert_with(|| (number, keyword.to_owned()));
        }
    }

    /// One warning for each keyword.
    pub fn warn(self, mtl: &Path, warnings: &mut Vec<String>) {
        let file = mtl.display();
        for (keyword, count) in UNREAD.iter().zip(self.counts).filter(|(_, count)| *count > 0) {
            warnings.push(format!("{file}: {keyword} is not read: {count} line(s) have no effect"));
        }
        if let Some((line, first)) = self.first {
            let count = self.others;
            let which =
                format!("{count} line(s) of map_ keywords that are unknown have no effect, the first `{first}`");
            warnings.push(format!("{file}:{line}: {which}"));
        }
    }
}
