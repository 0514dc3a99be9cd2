//! Images and textures, used or not.

use ::gltf::json::Value;

use super::checked::{Lint, index};
use crate::assets::gltf::container::{Location, locate, read};

/// Checks all images. Those that are `used` are decoded later, and their faults are errors.
pub(super) fn check(lint: &mut Lint<'_>, used: &[usize]) {
    for (i, image) in lint.array("images").iter().enumerate() {
        let uri = image.get("uri").and_then(Value::as_str);
        let view = index(image, "bufferView");
        if uri.is_some() && view.is_some() {
            lint.fault(format!("image {i} has a uri and a buffer view"));
        }
        if used.contains(&i) {
            continue;
        }
        match (uri, view) {
            (None, None) => lint.fault(format!("image {i} has neither a uri nor a buffer view")),
            (None, Some(view)) => {
                if let Ok((bytes, _)) = lint.document.view(view) {
                    data(lint, i, bytes);
                }
            }
            (Some(uri), _) => match locate(lint.document.folder, uri, lint.document.files) {
                Err(e) => lint.fault(format!("image {i}: {e}")),
                Ok(Location::File(path)) if !path.is_file() => {
                    lint.fault(format!("image {i} names a file that is not there: {}", path.display()));
                }
                Ok(Location::File(path)) => match read(&path, lint.document.files) {
                    Err(e) => lint.fault(format!("image {i}: {e}")),
                    Ok(bytes) => data(lint, i, &bytes),
                },
                Ok(Location::Here(bytes)) => data(lint, i, &bytes),
            },
        }
    }
    for (i, texture) in lint.array("textures").iter().enumerate() {
        let plain = lint.named(texture, "source", "images");
        if plain.and_then(|image| image.get("mimeType")).and_then(Value::as_str) == Some("image/webp") {
            lint.fault(format!("texture {i} shows a WebP image without EXT_texture_webp"));
        }
        let webp = texture.pointer("/extensions/EXT_texture_webp");
        for source in [Some(texture), webp]
            .into_iter()
            .flatten()
            .filter_map(|t| index(t, "source"))
        {
            if source >= lint.array("images").len() {
                lint.fault(format!("texture {i} names image {source}, which is not there"));
            }
        }
    }
}

/// Reports data that does not start like an image.
fn data(lint: &mut Lint<'_>, i: usize, bytes: &[u8]) {
    let is_png = bytes.starts_with(b"\x89PNG\r\n\x1a\n");
    let is_known = is_png
        || matches!(bytes, [0xff, 0xd8, 0xff, marker, ..] if *marker >= 0xc0)
        || bytes.starts_with(b"RIFF")
        || bytes.starts_with(b"\xabKTX 20\xbb");
    if !is_known {
        lint.fault(format!("image {i} has an unknown format"));
    } else if is_png && !bytes.windows(4).any(|w| w == b"IEND") || bytes.len() < 16 {
        lint.fault(format!("image {i} ends early"));
    }
}
