//! The MTL files that OBJ files name.

use crate::error::{Error, Result};
use crate::files::read;
use crate::import::obj::mtl;
use crate::import::obj::mtl::MtlMaterial;
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

/// The materials of one MTL file by their names.
type Library = HashMap<String, Rc<MtlMaterial>>;

/// All MTL files of a scene: each is read once, however many meshes name it.
#[derive(Debug, Default)]
pub struct Libraries {
    /// By path; `None`: it cannot be read.
    files: HashMap<PathBuf, Option<Rc<Library>>>,
}

impl Libraries {
    /// The materials of `text.materials`, then the nameless one. What a reader should know is appended to `warnings`, once for
    /// each file.
    pub fn materials(&mut self, obj: &Path, text: &ObjText, warnings: &mut Vec<String>) -> Result<Vec<ObjMaterial>> {
        let libraries = self.named_by(obj, text, warnings)?;
        let material = |name: &String| {
            // Of several that define a name the last one counts.
            match (libraries.iter().rev().find_map(|library| library.get(name)), name.is_empty()) {
                (Some(material), _) => ObjMaterial { material: material.clone(), defined: true },
                (None, true) => nameless(),
                (None, false) => ObjMaterial { material: MtlMaterial::grey(name).into(), defined: false },
            }
        };
        Ok(text.materials.iter().map(material).chain([nameless()]).collect())
    }

    /// What the `mtllib` lines of an OBJ name, in the order in which they are named last: exporters name a library once a
    /// material.
    fn named_by(&mut self, obj: &Path, text: &ObjText, warnings: &mut Vec<String>) -> Result<Vec<Rc<Library>>> {
        let mut seen = HashSet::new();
        let mut lines: Vec<&String> = text.libraries.iter().rev().filter(|line| seen.insert(*line)).collect();
        lines.reverse();
        let mut libraries = Vec::new();
        for line in lines {
            // The whole rest of the line as one name, or else each of its words.
            if let Some(library) = self.read(obj, line, warnings)? {
                libraries.push(library);
                continue;
            }
            for name in split_names(line) {
                match self.read(obj, &name, warnings)? {
                    Some(library) => libraries.push(library),
                    None => {
                        let file = obj.display();
                        warnings.push(format!("{file}: cannot read its material file `{name}`: grey instead"));
                    }
                }
            }
        }
        Ok(libraries)
    }

    /// The file that `obj` calls `name`; `None` if it cannot be read.
    fn read(&mut self, obj: &Path, name: &str, warnings: &mut Vec<String>) -> Result<Option<Rc<Library>>> {
        // Exporters on Windows write backslashes.
        for name in [name.to_owned(), name.replace('\\', "/")] {
            let path = obj.with_file_name("").join(name);
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
                Ok(bytes) => {
                    let materials = mtl::parse_mtl(&path, &bytes, warnings)?;
                    Some(Rc::new(materials.into_iter().map(|m| (m.name.clone(), m.into())).collect::<Library>()))
                }
            };
            self.files.insert(path, library.clone());
            if library.is_some() {
                return Ok(library);
            }
        }
        Ok(None)
    }
}

fn nameless() -> ObjMaterial {
    ObjMaterial { material: MtlMaterial::grey(NO_MATERIAL).into(), defined: true }
}

/// The words of a line; a blank behind a backslash belongs to its word.
fn split_names(names: &str) -> Vec<String> {
    let mut split = vec![String::new()];
    let mut letters = names.chars().peekable();
    while let Some(letter) = letters.next() {
        let last = split.len() - 1;
        match letter {
            '\\' if letters.peek() == Some(&' ') => split[last].extend(letters.next()),
            _ if letter.is_whitespace() => split.push(String::new()),
            _ => split[last].push(letter),
        }
    }
    split.retain(|name| !name.is_empty());
    split
}
