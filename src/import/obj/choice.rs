//! Which of several libraries a `usemtl` means.
//!
//! The `mtllib` lines right above it, as far as no face and no other `usemtl` interrupts them, are asked first: so each part of a
//! file that was joined from several keeps the materials it was made with. What they lack is looked for in all libraries of the
//! file, those named below too. Either way the first that has the name counts, as the format says of its lists. A name as written
//! goes before one that loses quotes or a comment.

use crate::import::obj::libraries::{Library, NO_MATERIAL, Named, ObjMaterial};
use crate::import::obj::mtl::MtlMaterial;
use crate::import::obj::names;
use crate::import::obj::text::ObjText;
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;

/// The definitions of a name, each with the place of its library, in their order.
type Definitions<'a> = Vec<(usize, &'a Rc<MtlMaterial>)>;

/// Where names are looked up.
enum Lookup<'a> {
    /// In one library after the other.
    Each(&'a [Rc<Library>]),
    /// By name, and whether it is as written: what saves asking very many libraries for very many names.
    Index(HashMap<(&'a str, bool), Definitions<'a>>),
}

impl<'a> Lookup<'a> {
    /// The cheaper of the two for so many names.
    fn new(libraries: &'a [Rc<Library>], wanted: usize) -> Lookup<'a> {
        let total: usize = libraries.iter().map(|library| library.names()).sum();
        if libraries.len().saturating_mul(wanted) <= total {
            return Lookup::Each(libraries);
        }
        let mut index: HashMap<_, Definitions<'a>> = HashMap::new();
        for (place, library) in libraries.iter().enumerate() {
            for (name, written, material) in library.all() {
                index.entry((name, written)).or_default().push((place, material));
            }
        }
        Lookup::Index(index)
    }

    fn definitions(&self, name: &str) -> Definitions<'a> {
        let exact = match self {
            Lookup::Each(libraries) => each(libraries, |library| library.exact(name)),
            Lookup::Index(index) => index.get(&(name, true)).cloned().unwrap_or_default(),
        };
        if !exact.is_empty() {
            return exact;
        }
        let name = names::plain(name);
        match self {
            Lookup::Each(libraries) => each(libraries, |library| library.plain(name)),
            Lookup::Index(index) => {
                let of = |written| index.get(&(name, written)).cloned().unwrap_or_default();
                let mut all = [of(true), of(false)].concat();
                all.sort_by_key(|(place, _)| *place);
                all
            }
        }
    }
}

fn each<'a>(
    libraries: &'a [Rc<Library>],
    find: impl Fn(&'a Library) -> Option<&'a Rc<MtlMaterial>>,
) -> Definitions<'a> {
    libraries.iter().enumerate().filter_map(|(place, library)| Some((place, find(library)?))).collect()
}

/// The materials of `text.materials`, then the nameless one. Where a name has several meanings, a warning for the file.
pub fn materials(obj: &Path, text: &ObjText, named: &Named, warnings: &mut Vec<String>) -> Vec<ObjMaterial> {
    let lookup = Lookup::new(&named.libraries, text.materials.len());
    // By block, at which of its places a library stands.
    let ranks = |block: &Vec<usize>| {
        // From the back: of a library that is named twice the first naming stays.
        block.iter().enumerate().rev().map(|(rank, place)| (*place, rank)).collect()
    };
    let ranks: Vec<HashMap<usize, usize>> = named.blocks.iter().map(ranks).collect();
    let mut doubtful = Doubtful::default();
    let mut materials = Vec::with_capacity(text.materials.len() + 1);
    for used in &text.materials {
        let name = &used.name;
        if name.is_empty() {
            materials.push(nameless());
            continue;
        }
        let all = lookup.definitions(name);
        let block = used.block.and_then(|block| ranks.get(block as usize));
        let mut near: Vec<(usize, usize, &Rc<MtlMaterial>)> =
            all.iter().filter_map(|(place, material)| Some((*block?.get(place)?, *place, *material))).collect();
        if near.is_empty() {
            near = all.iter().map(|(place, material)| (*place, *place, *material)).collect();
        }
        let first = near.iter().min_by_key(|(rank, _, _)| *rank).copied();
        let Some((_, place, material)) = first else {
            materials.push(ObjMaterial { material: MtlMaterial::grey(name).into(), defined: false });
            continue;
        };
        let library = &named.libraries[place];
        if library.differs(&material.name) || near.iter().any(|(_, _, other)| ***other != **material) {
            doubtful.add(name, &library.path);
        }
        materials.push(ObjMaterial { material: material.clone(), defined: true });
    }
    doubtful.warn(obj, warnings);
    materials.push(nameless());
    materials
}

/// Names of which two definitions differ.
#[derive(Default)]
struct Doubtful<'a> {
    first: Option<(&'a str, &'a Path)>,
    others: HashSet<&'a str>,
}

impl<'a> Doubtful<'a> {
    fn add(&mut self, name: &'a str, counts: &'a Path) {
        let (first, _) = *self.first.get_or_insert((name, counts));
        if name != first {
            self.others.insert(name);
        }
    }

    fn warn(self, obj: &Path, warnings: &mut Vec<String>) {
        let Some((name, counts)) = self.first else { return };
        let (file, counts) = (obj.display(), counts.display());
        let more = match self.others.len() {
            0 => String::new(),
            more => format!(", and so of {more} more"),
        };
        warnings.push(format!(
            "{file}: its material files define `{name}` twice, differently: the first counts, in {counts}{more}"
        ));
    }
}

fn nameless() -> ObjMaterial {
    ObjMaterial { material: MtlMaterial::grey(NO_MATERIAL).into(), defined: true }
}
