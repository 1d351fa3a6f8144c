//! Which file names which: modules, `use` trees and paths in the code, read from the sources.

use std::collections::{BTreeMap, BTreeSet};

/// A path as segments, `crate::bvh::Walk` for one.
pub type Names = Vec<String>;

/// The code of a file: without comments, and without the test module at its end.
pub fn code(text: &str) -> String {
    let without: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let mut end = without.len();
    for (i, line) in without.iter().enumerate() {
        let declared = without[i + 1..].iter().find(|line| !line.trim_start().starts_with("#["));
        if line.trim() == "#[cfg(test)]" && declared.is_some_and(|line| line.starts_with("mod ")) {
            end = i;
            break;
        }
    }
    let cut = |line: &&str| line.split(" // ").next().unwrap_or("").to_string();
    without[..end].iter().map(cut).collect::<Vec<_>>().join("\n")
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Reads one tree of a `use`, or a path in the code, from the front of `text`: what it names; the text behind it.
pub fn tree<'a>(text: &'a str, before: &[String], names: &mut Vec<Names>) -> &'a str {
    let mut rest = text.trim_start();
    let mut path = before.to_vec();
    loop {
        if let Some(mut group) = rest.strip_prefix('{') {
            loop {
                group = group.trim_start();
                if let Some(end) = group.strip_prefix('}') {
                    return end;
                }
                let behind = tree(group, &path, names).trim_start();
                let next = behind.strip_prefix(',').unwrap_or(behind);
                if next.len() == group.len() {
                    return next; // no tree of a `use`
                }
                group = next;
            }
        }
        let end = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
        if end == 0 {
            names.push(path);
            return rest.strip_prefix('*').unwrap_or(rest);
        }
        if &rest[..end] != "self" || path.is_empty() {
            path.push(rest[..end].to_string());
        }
        rest = &rest[end..];
        match rest.strip_prefix("::") {
            Some(deeper) if deeper.starts_with(|c| is_name(c) || c == '{' || c == '*') => rest = deeper,
            _ => {
                names.push(path);
                let alias = rest.trim_start().strip_prefix("as ");
                return alias.map_or(rest, |alias| alias.trim_start().trim_start_matches(is_name));
            }
        }
    }
}

/// Everything that `code` names from `crate`, `super` or `here` (the SIMD level it is compiled for), in `use` trees or anywhere else.
pub fn named(code: &str) -> Vec<Names> {
    let mut names = Vec::new();
    for start in ["crate::", "super::", "here::"] {
        for (at, _) in code.match_indices(start) {
            if !code[..at].ends_with(|c| is_name(c) || c == ':') {
                tree(&code[at..], &[], &mut names);
            }
        }
    }
    names
}

/// What the `pub use` of `code` offer, whole paths; and the code without them.
pub fn offered(code: &str) -> (Vec<Names>, String) {
    let (mut names, mut rest, mut others) = (Vec::new(), code, String::new());
    while let Some(at) =
        ["pub use ", "pub(super) use ", "pub(crate) use "].iter().filter_map(|word| rest.find(word)).min()
    {
        others += &rest[..at];
        let from = at + rest[at..].find("use ").expect("just found") + 4;
        rest = tree(&rest[from..], &[], &mut names);
    }
    (names, others + rest)
}

/// `place` as seen from `folder`, which ends in `/` or is empty.
fn joined(folder: &str, place: &str) -> String {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in place.split('/') {
        match part {
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// A source file.
pub struct File {
    pub code: String,
    /// The modules it is compiled as: of the scalar reference's files, and of those compiled once a SIMD level, there are two each.
    pub modules: Vec<Names>,
    offers: Vec<Names>,
    /// Without what it offers of other files.
    own: String,
}

/// All files that `lib.rs` leads to, by their path below `src`.
pub struct Sources {
    pub files: BTreeMap<String, File>,
    modules: BTreeMap<Names, String>,
}

impl Sources {
    /// Follows `mod` and `#[path]` from `lib.rs`; `texts` are all files by their path below `src`.
    pub fn new(texts: &BTreeMap<String, String>) -> Self {
        let mut sources = Self { files: BTreeMap::new(), modules: BTreeMap::new() };
        sources.add("lib.rs", vec!["crate".to_string()], texts);
        sources
    }

    fn add(&mut self, path: &str, module: Names, texts: &BTreeMap<String, String>) {
        let text = texts.get(path).unwrap_or_else(|| panic!("{path} is declared as {module:?}, and not there"));
        let file = self.files.entry(path.to_string()).or_insert_with(|| {
            let code = code(text);
            let (offers, own) = offered(&code);
            File { code, modules: Vec::new(), offers, own }
        });
        file.modules.push(module.clone());
        self.modules.insert(module.clone(), path.to_string());
        let folder = path.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        let is_root = path.ends_with("mod.rs") || path == "lib.rs";
        let mut elsewhere = None;
        for line in file.code.clone().lines().map(str::trim) {
            if let Some(place) = line.strip_prefix("#[path = \"") {
                elsewhere = place.strip_suffix("\"]").map(str::to_string);
            }
            let declared = line.strip_suffix(';').and_then(|line| line.rsplit_once("mod "));
            let Some((before, name)) = declared.filter(|(_, name)| name.chars().all(is_name)) else { continue };
            if !before.is_empty() && !before.starts_with("pub") {
                continue;
            }
            let below = if is_root { folder.clone() } else { format!("{}/", path.trim_end_matches(".rs")) };
            let usual = [format!("{below}{name}.rs"), format!("{below}{name}/mod.rs")];
            let child = match elsewhere.take() {
                Some(place) => joined(&folder, &place),
                None => usual.iter().find(|p| texts.contains_key(*p)).expect("a declared file").clone(),
            };
            // `lib.rs` names the rooms that `internal.rs` declares as its own: `crate::bvh`.
            let parent = if path == "internal.rs" { &module[..1] } else { &module[..] };
            let module = parent.iter().cloned().chain([name.to_string()]).collect();
            self.add(&child, module, texts);
        }
    }

    /// The file that defines what is named in `module`, looked up through what files offer of others.
    fn definer(&self, named: &Names, module: &Names, depth: usize) -> Option<String> {
        let (mut path, mut rest) = (module.clone(), named.as_slice());
        match rest[0].as_str() {
            "crate" => (path, rest) = (vec!["crate".to_string()], &rest[1..]),
            "super" => {}
            // The module of the SIMD level: `crate::simd::native`.
            "here" => (path, rest) = (module.get(..3)?.to_vec(), &rest[1..]),
            // A child, as in `pub use child::Name`; anything else is another crate's.
            child => {
                path.push(child.to_string());
                rest = &rest[1..];
                self.modules.get(&path)?;
            }
        }
        while rest.first().is_some_and(|name| name == "super") {
            path.pop();
            rest = &rest[1..];
        }
        while let Some(name) = rest.first() {
            path.push(name.clone());
            if !self.modules.contains_key(&path) {
                path.pop();
                break;
            }
            rest = &rest[1..];
        }
        let file = self.modules.get(&path)?;
        if let Some(item) = rest.first().filter(|_| depth < 8) {
            let offered = self.files[file].offers.iter().find(|offer| offer.last() == Some(item) && offer.len() > 1);
            if let Some(found) = offered.and_then(|offer| self.definer(offer, &path, depth + 1)) {
                return Some(found);
            }
        }
        Some(file.clone())
    }

    /// The files that `path` names. What a file only offers of others is not named by it.
    pub fn imports(&self, path: &str) -> BTreeSet<String> {
        let file = &self.files[path];
        let names = named(&file.own);
        let of = |module| names.iter().filter_map(move |name| self.definer(name, module, 0));
        file.modules.iter().flat_map(of).filter(|other| other != path).collect()
    }

    /// All imports.
    pub fn graph(&self) -> Graph {
        self.files.keys().map(|path| (path.clone(), self.imports(path))).collect()
    }
}

/// The files that each file names.
pub type Graph = BTreeMap<String, BTreeSet<String>>;

/// A circle of `graph`, the first file once more at its end; the shortest from the first file that lies on one.
pub fn circle(graph: &Graph) -> Option<Vec<String>> {
    graph.keys().find_map(|file| way(graph, file, file))
}

/// The shortest way of one import or more from `from` to `to`, both included.
pub fn way(graph: &Graph, from: &str, to: &str) -> Option<Vec<String>> {
    let mut came_from: BTreeMap<&str, &str> = BTreeMap::new();
    let mut border = vec![from];
    while !border.is_empty() {
        let mut next = Vec::new();
        for file in border {
            for other in graph.get(file).into_iter().flatten() {
                if !came_from.contains_key(other.as_str()) {
                    came_from.insert(other, file);
                    next.push(other.as_str());
                }
            }
        }
        if let Some(&last) = came_from.get(to) {
            let mut files = vec![to.to_string(), last.to_string()];
            while files[files.len() - 1] != from {
                let before = came_from[files[files.len() - 1].as_str()];
                files.push(before.to_string());
            }
            files.reverse();
            return Some(files);
        }
        border = next;
    }
    None
}
