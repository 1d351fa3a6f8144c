//! What a file's references point at: bytes, in the file itself, in text, or in files beside it.

use crate::error::{Error, Result};
use crate::files::read;
use crate::import::obj::names;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::json::{Index, Root, buffer};
use percent_encoding::percent_decode_str;
use std::path::Path;

/// The buffers of a file, in their order.
pub struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// Reads all buffers; `data` are those in the file itself.
    pub fn read(path: &Path, root: &Root, mut data: Option<Vec<u8>>) -> Result<Buffers> {
        let mut buffers = Vec::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            let fault = |why: String| Error::parse(path, None, format!("buffers[{i}]: {why}"));
            let bytes = match &buffer.uri {
                Some(uri) => bytes_at(path, uri).map_err(&fault)?,
                None => data.take().ok_or_else(|| fault("it names no file, and no data follow the JSON".into()))?,
            };
            let (has, wants) = (bytes.len() as u64, buffer.byte_length.0);
            if has < wants {
                return Err(fault(format!("it has {has} bytes where the JSON says {wants}: the file was cut off")));
            }
            buffers.push(bytes);
        }
        Ok(Buffers(buffers))
    }

    /// The bytes of a view, and how far its elements lie apart if it says so; the message says why there are none.
    pub fn view(&self, root: &Root, view: Index<buffer::View>) -> std::result::Result<(&[u8], Option<usize>), String> {
        let number = view.value();
        let Some(view) = root.buffer_views.get(number) else {
            return Err(format!("there is no bufferViews[{number}]"));
        };
        let bytes = self.0.get(view.buffer.value()).map_or(&[][..], |bytes| bytes);
        let first = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0)).ok();
        let count = usize::try_from(view.byte_length.0).ok();
        let bytes = first.and_then(|first| bytes.get(first..)?.get(..count?));
        let bytes = bytes.ok_or_else(|| format!("bufferViews[{number}] reaches beyond its buffer"))?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }
}

/// The bytes at `uri` of the file `path`, in the address itself or in a file; the message says why there are none.
pub fn bytes_at(path: &Path, uri: &str) -> std::result::Result<Vec<u8>, String> {
    if let Some((kind, text)) = uri.strip_prefix("data:").and_then(|rest| rest.split_once(',')) {
        return match kind.ends_with(";base64") {
            true => STANDARD.decode(text).map_err(|why| format!("its data are not base64: {why}")),
            false => Ok(percent_decode_str(text).collect()),
        };
    }
    let name = percent_decode_str(uri).decode_utf8_lossy();
    if names::has_control(&name) {
        return Err(format!("`{name}`: {}", names::CONTROL));
    }
    if name.contains("://") {
        return Err(format!("`{name}` is not a file beside the scene: octray reads nothing from the network"));
    }
    let folder = path.with_file_name("");
    // Writers that do not escape names may well have `%` in one.
    let file = [folder.join(&*name), folder.join(uri)].into_iter().find(|file| file.exists());
    read::bytes(&file.unwrap_or_else(|| folder.join(&*name))).map_err(|why| why.to_string())
}
