//! The file around a scene: JSON by itself, or the binary container with JSON and data in one.

use crate::error::{Error, Result};
use crate::files::read;
use gltf::binary::Glb;
use gltf::json::validation::{Error as Fault, Validate};
use gltf::json::{Path as Place, Root};
use std::path::Path;

/// The bytes that a binary file begins with.
const MAGIC: &[u8] = b"glTF";

/// The length of a binary file's header.
const HEADER: usize = 12;

/// Extensions that only widen which types of numbers an accessor may have: all are read anyway.
const WIDENING: [&str; 1] = ["KHR_mesh_quantization"];

/// The JSON of a file, its references checked, and the data that follow it in a binary one.
pub fn read(path: &Path) -> Result<(Root, Option<Vec<u8>>)> {
    let bytes = read::bytes(path)?;
    let fault = |why: String| Error::parse(path, None, why);
    let (json, data) = match bytes.starts_with(MAGIC) {
        true => {
            // The crate takes the length that the header says for one that holds the header.
            let length = bytes.get(8..HEADER).and_then(|length| length.try_into().ok()).map_or(0, u32::from_le_bytes);
            if (length as usize) < HEADER {
                return Err(fault("the binary glTF file ends within its header".into()));
            }
            let glb =
                Glb::from_slice(&bytes).map_err(|why| fault(format!("not a whole binary glTF 2.0 file: {why}")))?;
            (glb.json, glb.bin.map(|data| data.into_owned()))
        }
        false => (bytes.as_slice().into(), None),
    };
    // Some writers put a byte order mark in front.
    let text = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&json);
    let root: Root = serde_json::from_slice(text).map_err(|why| {
        let line = (why.line() > 0 && data.is_none()).then_some(why.line());
        Error::parse(path, line, format!("not a glTF 2.0 scene: {why}"))
    })?;
    if !root.asset.version.starts_with("2.") {
        return Err(fault(format!("glTF {}: octray reads glTF 2.0", root.asset.version)));
    }
    let mut faults = Vec::new();
    root.validate(&root, Place::new, &mut |place: &dyn Fn() -> Place, error: Fault| faults.push((place(), error)));
    for (place, error) in faults {
        let place = place.to_string();
        match error {
            Fault::Unsupported if WIDENING.iter().any(|name| place.contains(name)) => {}
            // Bounds of positions are of no use here.
            Fault::Missing | Fault::Invalid if place.ends_with(".min") || place.ends_with(".max") => {}
            Fault::Unsupported => {
                return Err(fault(format!("{place}: the file requires an extension that octray does not know")));
            }
            error => return Err(fault(format!("{place}: {}", error.to_string().to_lowercase()))),
        }
    }
    Ok((root, data))
}
