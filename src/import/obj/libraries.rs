//! The MTL files that OBJ files name.

use crate::error::{Error, Result};
use crate::files::read;
use crate::import::obj::mtl;
use crate::import::obj::mtl::MtlMaterial;
use crate::import::obj::names;
use crate::import::obj::text::ObjText;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What a face without `usemtl` is made of, by name.
pub const NO_MATERIAL: &str = "default";

/// A material an OBJ names, and whether an MTL defines it.
#[derive(Clone, Debug)]
pub struct ObjMaterial {
    /// What it is: grey where no MTL says. Shared by all meshes that have it.
    pub material: Rc<MtlMaterial>,
    /// An MTL defines it, or it has no name to define.
    pub defined: bool,
}

/// One MTL file.
#[derive(Debug)]
pub struct Library {
    /// The file.
    pub path: PathBuf,
    /// Its materials by their names as written; of several of one name the first.
    exact: HashMap<String, Rc<MtlMaterial>>,
    /// The same without quotes and comments, and so named, as far as `exact` has no such name.
    plain: HashMap<String, Rc<MtlMaterial>>,
    /// Names that it defines twice, differently.
    differing: HashSet<String>,
}

impl Library {
    fn new(path: &Path, materials: Vec<MtlMaterial>) -> Library {
        let mut library =
            Library { path: path.to_owned(), exact: HashMap::new(), plain: HashMap::new(), differing: HashSet::new() };
        for material in materials {
            match library.exact.get(&material.name) {
                Some(first) if **first == material => {}
                Some(_) => drop(library.differing.insert(material.name)),
                None => drop(library.exact.insert(material.name.clone(), material.into())),
            }
        }
        let mut written: Vec<&Rc<MtlMaterial>> = library.exact.values().collect();
        // Two names may be the same without quotes; which is the first must not depend on a hash.
        written.sort_by(|a, b| a.name.cmp(&b.name));
        for material in written {
            let name = names::plain(&material.name);
            if name != material.name && !library.exact.contains_key(name) && !library.plain.contains_key(name) {
                let named = MtlMaterial { name: name.to_owned(), ..(**material).clone() };
                library.plain.insert(name.to_owned(), named.into());
            }
        }
        library
    }

    /// How many names it has.
    pub fn names(&self) -> usize {
        self.exact.len() + self.plain.len()
    }

    /// The material of exactly this name.
    pub fn exact(&self, name: &str) -> Option<&Rc<MtlMaterial>> {
        self.exact.get(name)
    }

    /// The material of this name, its own name without quotes and comments.
    pub fn plain(&self, name: &str) -> Option<&Rc<MtlMaterial>> {
        self.exact.get(name).or_else(|| self.plain.get(name))
    }

    /// Whether it defines this name twice, differently.
    pub fn differs(&self, name: &str) -> bool {
        self.differing.contains(name)
    }

    /// All its materials by the names they are found by, and whether that is as written.
    pub fn all(&self) -> impl Iterator<Item = (&str, bool, &Rc<MtlMaterial>)> {
        let exact = self.exact.iter().map(|(name, material)| (name.as_str(), true, material));
        exact.chain(self.plain.iter().map(|(name, material)| (name.as_str(), false, material)))
    }
}

/// All MTL files of a scene: each is read once, however many meshes name it.
#[derive(Debug, Default)]
pub struct Libraries {
    /// By path; `None`: it cannot be read.
    files: HashMap<PathBuf, Option<Rc<Library>>>,
}

/// What the `mtllib` lines of one OBJ name.
#[derive(Default)]
pub struct Named {
    /// Each library once, in order of first naming.
    pub libraries: Vec<Rc<Library>>,
    /// By block of lines, the places of its libraries, in order.
    pub blocks: Vec<Vec<usize>>,
}

impl Libraries {
    /// The libraries that `text`, the OBJ file `obj`, names. What a reader should know is appended to `warnings`, once for each
    /// file.
    pub fn named_by(&mut self, obj: &Path, text: &ObjText, warnings: &mut Vec<String>) -> Result<Named> {
        let mut named = Named::default();
        let mut places: HashMap<*const Library, usize> = HashMap::new();
        let mut by_line: HashMap<&str, Vec<usize>> = HashMap::new();
        let mut missed = HashSet::new();
        for lines in &text.libraries {
            let mut block = Vec::new();
            for line in lines {
                if !by_line.contains_key(line.as_str()) {
                    let found = self.read_line(obj, line, warnings, &mut |name| missed.insert(name.to_owned()))?;
                    let mut place = |library: Rc<Library>| {
                        *places.entry(Rc::as_ptr(&library)).or_insert_with(|| {
                            named.libraries.push(library);
                            named.libraries.len() - 1
                        })
                    };
                    by_line.insert(line, found.into_iter().map(&mut place).collect());
                }
                block.extend_from_slice(&by_line[line.as_str()]);
            }
            named.blocks.push(block);
        }
        Ok(named)
    }

    /// The libraries of one `mtllib` line: its whole rest as one name, or else the names that it lists. `missed` is asked
    /// whether it is news that a name cannot be read.
    fn read_line(
        &mut self,
        obj: &Path,
        line: &str,
        warnings: &mut Vec<String>,
        missed: &mut impl FnMut(&str) -> bool,
    ) -> Result<Vec<Rc<Library>>> {
        for name in [line, names::plain(line)] {
            if let Some(library) = self.read(obj, name, warnings)? {
                return Ok(vec![library]);
            }
        }
        let mut found = Vec::new();
        for group in split_names(line) {
            let whole = group.join(" ");
            let before = found.len();
            let mut lost = Vec::new();
            if let Some(library) = self.read(obj, &whole, warnings)? {
                found.push(library);
                continue;
            }
            if group.len() > 1 {
                for name in &group {
                    match self.read(obj, name, warnings)? {
                        Some(library) => found.push(library),
                        None => lost.push(name.as_str()),
                    }
                }
            }
            // Where not even a word of it can be read it is a name with blanks.
            if found.len() == before {
                lost = vec![&whole];
            }
            for name in lost {
                if missed(name) {
                    let file = obj.display();
                    warnings.push(format!("{file}: cannot read its material file `{name}`: grey instead"));
                }
            }
        }
        Ok(found)
    }

    /// The file that `obj` calls `name`; `None` if it cannot be read.
    fn read(&mut self, obj: &Path, name: &str, warnings: &mut Vec<String>) -> Result<Option<Rc<Library>>> {
        for path in names::paths(obj, name) {
            if let Some(known) = self.files.get(&path) {
                match known {
                    Some(library) => return Ok(Some(library.clone())),
                    None => continue,
                }
            }
            let library = match read::bytes(&path) {
                // What is missing is missed; what never ends, or waits for somebody to write, was put there by no exporter.
                Err(error) if read::is_special(&path) => {
                    return Err(Error::parse(obj, None, format!("mtllib: {error}")));
                }
                Err(_) => None,
                Ok(bytes) => Some(Rc::new(Library::new(&path, mtl::parse_mtl(&path, bytes, warnings)?))),
            };
            self.files.insert(path, library.clone());
            if library.is_some() {
                return Ok(library);
            }
        }
        Ok(None)
    }
}

/// The words of a line up to a comment, in groups that end in `.mtl`: names may have blanks. A blank behind a backslash, and what
/// stands in quotes, belongs to its word.
fn split_names(names: &str) -> Vec<Vec<String>> {
    let mut groups = Vec::new();
    let mut group: Vec<String> = Vec::new();
    let mut rest = names.trim();
    while !rest.is_empty() && !rest.starts_with('#') {
        let word = match names::split_quoted(rest) {
            Some((quoted, behind)) => {
                rest = behind;
                quoted.to_owned()
            }
            None => {
                let (word, behind) = first_word(rest);
                rest = behind;
                word
            }
        };
        let ends = word.to_ascii_lowercase().ends_with(".mtl");
        group.push(word);
        if ends {
            groups.push(std::mem::take(&mut group));
        }
    }
    // What follows the last `.mtl` has none: each is a name by itself.
    groups.extend(group.into_iter().map(|word| vec![word]));
    groups
}

/// The first word of a text, and what follows.
fn first_word(text: &str) -> (String, &str) {
    let mut word = String::new();
    let mut letters = text.char_indices().peekable();
    while let Some((place, letter)) = letters.next() {
        match letter {
            '\\' if letters.peek().is_some_and(|next| next.1 == ' ') => word.extend(letters.next().map(|next| next.1)),
            _ if letter.is_whitespace() => return (word, text[place..].trim_start()),
            _ => word.push(letter),
        }
    }
    (word, "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_names_is_split_where_names_end() {
        let cases: &[(&str, &[&[&str]])] = &[
            ("a.mtl b.mtl", &[&["a.mtl"], &["b.mtl"]]),
            ("two words.mtl\tB.MTL x y", &[&["two", "words.mtl"], &["B.MTL"], &["x"], &["y"]]),
            ("\"a b.mtl\" 'c' d.mtl # e.mtl", &[&["a b.mtl"], &["c", "d.mtl"]]),
            ("two\\ words.mtl sub\\a.mtl", &[&["two words.mtl"], &["sub\\a.mtl"]]),
            ("# a.mtl", &[]),
            ("", &[]),
            ("\"a.mtl é", &[&["\"a.mtl"], &["é"]]),
        ];
        for (line, expected) in cases {
            let groups = split_names(line);
            let got: Vec<Vec<&str>> = groups.iter().map(|group| group.iter().map(String::as_str).collect()).collect();
            assert_eq!(got, *expected, "{line}");
        }
    }
}
