//! "Did you mean": what a user who was refused may have wanted.

use crate::error::Error;
use crate::image::check_output_path;
use crate::import::SCENE_FILES;
use crate::nearest::close;
use crate::scene::builtin;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::io;
use std::path::{Path, PathBuf};

/// What stands before the names of scenes made in code.
const BUILTIN: &str = "builtin";
/// Where scenes are looked for that are not where they were said to be: our own lie there.
const SCENES: &str = "scenes";
/// Names of a directory that are compared at most: a mistake must not cost a walk through a million of them.
const MOST_NAMES: usize = 10_000;

/// A tip for arguments that clap has refused, where it has none of its own.
pub fn tip(error: &clap::Error) -> Option<String> {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    match error.kind() {
        ErrorKind::UnknownArgument => {
            let argument = text(ContextKind::InvalidArg).filter(|argument| !argument.starts_with('-'))?;
            let path = Path::new(argument);
            if has_extension(path, &["json"]) {
                return Some(format!("--json takes a file with an equals sign only: --json={argument}"));
            }
            check_output_path(path)
                .is_ok()
                .then(|| format!("images to write are named with -o, each with its own: -o {argument}"))
        }
        ErrorKind::InvalidSubcommand => {
            let argument = text(ContextKind::InvalidSubcommand)?;
            let scene = argument.starts_with("builtin:") || has_extension(Path::new(argument), &SCENE_FILES);
            scene.then(|| format!("a command comes first: octray render {argument} -o image.exr"))
        }
        _ => None,
    }
}

/// The message of `error`, with the path that may have been meant where it names one that does not exist.
pub fn with_hint(error: &Error) -> String {
    let missing = match error {
        Error::Read { path, source } if source.kind() == io::ErrorKind::NotFound => Some(path),
        // Told by its extension not to be a scene before anyone has looked for it.
        Error::Parse { path, line: None, .. } if !path.exists() => Some(path),
        _ => None,
    };
    match missing.and_then(|path| meant(path)) {
        Some(meant) => format!("{error}; did you mean `{meant}`?"),
        None => error.to_string(),
    }
}

/// What `path`, which does not exist, may have been meant to be.
fn meant(path: &Path) -> Option<String> {
    let shown = |path: PathBuf| Some(path.display().to_string());
    let with_extension = |path: &Path| {
        let mut forms = SCENE_FILES.iter().map(|extension| path.with_extension(extension));
        forms.find(|form| path.extension().is_none() && form.is_file())
    };
    if let Some(found) = with_extension(path).or_else(|| near_file(path)) {
        return shown(found);
    }
    let name = path.to_str()?;
    if let Some(found) = near_builtin(name) {
        return Some(found);
    }
    let elsewhere = Path::new(SCENES).join(path.file_name()?);
    let found = if elsewhere.is_file() { Some(elsewhere) } else { with_extension(&elsewhere) };
    shown(found.or_else(|| near_file(&Path::new(SCENES).join(path.file_name()?)))?)
}

/// `heavy` for `builtin:heavy`, and slips in either word.
fn near_builtin(name: &str) -> Option<String> {
    let named = match name.split_once(':') {
        Some((prefix, named)) if close(prefix, [BUILTIN]).is_some() => named,
        _ => name,
    };
    // A number may follow the name.
    let (name, size) = named.split_at(named.find(':').unwrap_or(named.len()));
    close(name, builtin::NAMES.iter().copied()).map(|near| format!("{BUILTIN}:{near}{size}"))
}

/// The file whose path differs from `path` in the first name that does not exist: near to that, of the same extension.
fn near_file(path: &Path) -> Option<PathBuf> {
    let missing = path.ancestors().take_while(|part| !part.as_os_str().is_empty() && !part.exists()).last()?;
    let parent = missing.parent()?;
    let rest = path.strip_prefix(missing).ok()?;
    let directory = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    let entries = std::fs::read_dir(directory).ok()?.take(MOST_NAMES).flatten();
    let whole = |name: &str| {
        let found = parent.join(name);
        if rest.as_os_str().is_empty() { found } else { found.join(rest) }
    };
    let fits = |name: &String| {
        let found = whole(name);
        let extension = if path.extension().is_none() {
            has_extension(&found, &SCENE_FILES)
        } else {
            found.extension().map(|e| e.to_ascii_lowercase()) == path.extension().map(|e| e.to_ascii_lowercase())
        };
        extension && found.is_file()
    };
    let mut names: Vec<String> =
        entries.filter_map(|entry| entry.file_name().into_string().ok()).filter(fits).collect();
    names.sort_by_key(|name| (!has_extension(Path::new(name), &["toml"]), name.clone()));
    let wanted = missing.file_name()?.to_str()?;
    // By the stems: the extension is the same, and must not make short names look alike.
    let stem = |name: &str| Path::new(name).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default().to_owned();
    let stems: Vec<String> = names.iter().map(|name| stem(name)).collect();
    let near = close(&stem(wanted), stems.iter().map(String::as_str))?;
    names.iter().zip(&stems).find(|(_, stem)| *stem == near).map(|(name, _)| whole(name))
}

fn has_extension(path: &Path, known: &[&str]) -> bool {
    path.extension().is_some_and(|extension| known.iter().any(|known| extension.eq_ignore_ascii_case(known)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn files_near_by_are_found() {
        let place = tempfile::tempdir().unwrap();
        fs::create_dir(place.path().join("scenes")).unwrap();
        for name in
            ["scenes/cornell.toml", "scenes/cornell.obj", "scenes/sky.toml", "lamp.OBJ", "truck.glb", "image.exr"]
        {
            fs::write(place.path().join(name), "").unwrap();
        }
        let found = |name: &str| meant(&place.path().join(name));
        let path = |name: &str| Some(place.path().join(name).display().to_string());
        for (name, wanted) in [
            ("scenes/cornel.toml", "scenes/cornell.toml"),
            ("scenes/Cornell.obj", "scenes/cornell.obj"),
            ("scenes/cornell", "scenes/cornell.toml"),
            ("scenes/cornel", "scenes/cornell.toml"),
            ("scene/cornell.toml", "scenes/cornell.toml"),
            ("lamb.obj", "lamp.OBJ"),
            ("imag.exr", "image.exr"),
            ("truck", "truck.glb"),
            ("truc.glb", "truck.glb"),
        ] {
            assert_eq!(found(name), path(wanted), "{name}");
        }
        for name in ["scenes/nonsense.toml", "scenes/sk.exr", "none/none.toml", "z.toml", "scene/nonsense.toml"] {
            assert_eq!(found(name), None, "{name}");
        }
    }

    #[test]
    fn scenes_made_in_code_are_found() {
        for (name, wanted) in [
            ("heavy", Some("builtin:heavy")),
            ("hevy", Some("builtin:heavy")),
            ("builtn:heavy:20000", Some("builtin:heavy:20000")),
            ("buildin:lamphall", Some("builtin:lamp_hall")),
            ("lamp_hall:100", Some("builtin:lamp_hall:100")),
            ("builtin:room:3", Some("builtin:rooms:3")),
            ("nothing", None),
        ] {
            assert_eq!(near_builtin(name).as_deref(), wanted, "{name}");
        }
    }
}
