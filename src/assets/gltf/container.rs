//! The bytes of a glTF asset: the GLB container, `data:` URIs, files beside the asset.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use super::error::GltfProblem;
use crate::{assets::Files, value::one_line, warnings::WarningKind};

/// A glTF file's JSON and the binary chunk of a GLB.
#[derive(Debug)]
pub(super) struct Container<'a> {
    pub json: &'a [u8],
    pub binary: Option<&'a [u8]>,
    /// Faults of a GLB that do not prevent reading.
    pub faults: Vec<&'static str>,
}

impl<'a> Container<'a> {
    pub fn open(bytes: &'a [u8]) -> Result<Self, GltfProblem> {
        if !bytes.starts_with(b"glTF") {
            let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            let faults = Vec::new();
            return Ok(Self {
                json,
                binary: None,
                faults,
            });
        }
        let word = |at: usize| -> Result<usize, GltfProblem> {
            let word = bytes
                .get(at..at + 4)
                .ok_or_else(|| GltfProblem::broken("the GLB header ends early"))?;
            let word = <[u8; 4]>::try_from(word).expect("the slice has four bytes");
            Ok(u32::from_le_bytes(word) as usize)
        };
        let (version, length) = (word(4)?, word(8)?);
        if version != 2 {
            return Err(GltfProblem::unsupported(format!(
                "version {version} of the GLB container"
            )));
        }
        if length < 12 || length > bytes.len() {
            let found = bytes.len();
            return Err(GltfProblem::broken(format!(
                "the GLB header says {length} bytes, the file has {found}"
            )));
        }
        let (mut json, mut binary, mut at) = (None, None, 12);
        let mut faults = Vec::new();
        let mut is_misplaced = false;
        while at + 8 <= length {
            let (size, kind) = (word(at)?, &bytes[at + 4..at + 8]);
            let chunk = (at + 8).checked_add(size).filter(|end| *end <= length);
            let chunk = chunk.map(|end| &bytes[at + 8..end]);
            let chunk = chunk
                .ok_or_else(|| GltfProblem::broken(format!("a GLB chunk of {size} bytes reaches past the end")))?;
            match kind {
                b"JSON" if json.is_none() => json = Some(chunk),
                b"BIN\0" if binary.is_none() => {
                    if json.is_none() || is_misplaced {
                        faults.push("the binary chunk of the GLB is not the second one");
                    }
                    binary = Some(chunk);
                }
                b"JSON" | b"BIN\0" => faults.push("the GLB has two chunks of one kind"),
                _ if json.is_some() && binary.is_none() => is_misplaced = true,
                _ => {}
            }
            // Chunks are padded to whole words; after an unpadded chunk the next follows immediately.
            at += 8 + size;
        }
        let json = json.ok_or_else(|| GltfProblem::broken("the GLB has no JSON chunk"))?;
        // The format requires spaces as padding, but some exporters write zeros.
        let json = json.trim_ascii_end();
        let zeros = json.iter().rev().take_while(|b| **b == 0).count();
        let json = &json[..json.len() - zeros];
        Ok(Self { json, binary, faults })
    }
}

/// The location of a URI's bytes.
#[derive(Debug, PartialEq)]
pub(super) enum Location {
    Here(Vec<u8>),
    File(PathBuf),
}

/// Locates a URI of an asset in `folder`. URIs are untrusted: only `data:` and files in the folder or below are allowed,
/// unless `files` allows others.
pub(super) fn locate(folder: &Path, uri: &str, files: &Files) -> Result<Location, GltfProblem> {
    if let Some(data) = uri.strip_prefix("data:") {
        return data_uri(data).map(Location::Here);
    }
    let scheme = uri.split(['/', '?', '#']).next().unwrap_or_default();
    if scheme.contains(':') {
        return Err(GltfProblem::refused(
            uri,
            "only files beside the asset and data: are read",
        ));
    }
    let decoded = String::from_utf8(percent_decoded(uri)).map_err(|_| GltfProblem::refused(uri, "it is not UTF-8"))?;
    if decoded.is_empty() || decoded.contains('\0') {
        return Err(GltfProblem::refused(uri, "it names no file"));
    }
    let has_drive = decoded.as_bytes().get(1) == Some(&b':');
    let separated = decoded.replace('\\', "/");
    if has_drive || !files.allows(Path::new(""), Path::new(&separated)) {
        let why = "it leaves the asset's folder (--allow-outside permits that)";
        return Err(GltfProblem::refused(uri, why));
    }
    let path = folder.join(&decoded);
    if separated != decoded && !path.exists() && folder.join(&separated).is_file() {
        let shown = one_line(uri, 200);
        let text = format!("the backslashes of a URI are read as slashes: {shown}");
        files.warnings().add(WarningKind::FAULT, shown, text);
        return Ok(Location::File(folder.join(&separated)));
    }
    // Some exporters do not escape a literal `%`.
    let literal = folder.join(uri);
    let is_literal = decoded != uri && !path.exists() && literal.is_file() && !uri.contains("..");
    Ok(Location::File(if is_literal { literal } else { path }))
}

/// The bytes of a file that a URI named.
pub(super) fn read(path: &Path, files: &Files) -> Result<Arc<[u8]>, GltfProblem> {
    let missing = |source| GltfProblem::Missing {
        source,
        file: path.to_owned(),
    };
    files.read(path).map_err(missing)
}

fn percent_decoded(uri: &str) -> Vec<u8> {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        let digits = after.get(..2).and_then(|d| str::from_utf8(d).ok());
        let escaped = digits.filter(|d| d.bytes().all(|b| b.is_ascii_hexdigit()));
        match escaped.and_then(|d| u8::from_str_radix(d, 16).ok()) {
            Some(decoded) if byte == b'%' => {
                out.push(decoded);
                rest = &after[2..];
            }
            _ => {
                out.push(byte);
                rest = after;
            }
        }
    }
    out
}

/// Decodes the part of a URI after `data:`.
fn data_uri(data: &str) -> Result<Vec<u8>, GltfProblem> {
    let (head, body) = data
        .split_once(',')
        .ok_or_else(|| GltfProblem::broken("a data: URI without a comma"))?;
    if head.ends_with(";base64") {
        base64(body.as_bytes()).ok_or_else(|| GltfProblem::broken("a data: URI is not base64"))
    } else {
        Ok(percent_decoded(body))
    }
}

/// Source: RFC 4648, section 4; the URL alphabet of section 5 is read as well, and padding may be missing.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let end = text.iter().rposition(|b| *b != b'=').map_or(0, |last| last + 1);
    let (mut bits, mut count) = (0u32, 0);
    for byte in &text[..end] {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b if b.is_ascii_whitespace() => continue,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    (count < 6).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(uri: &str) -> Result<PathBuf, String> {
        match locate(Path::new("models"), uri, &Files::default()) {
            Ok(Location::File(path)) => Ok(path),
            Ok(Location::Here(_)) => panic!("{uri}"),
            Err(e) => Err(e.to_string()),
        }
    }

    #[test]
    fn uris_stay_in_the_folder_of_the_asset() {
        assert_eq!(file("a%20b/./c.bin"), Ok("models/a b/./c.bin".into()));
        assert_eq!(file("a/../b.bin"), Ok("models/a/../b.bin".into()));
        assert_eq!(file("100%.png"), Ok("models/100%.png".into()));
        for bad in [
            "../b",
            "a/../../b",
            "%2e%2e/b",
            "/etc/passwd",
            "%2fetc",
            "c:/b",
            "http://x/y",
            "file:///b",
            "",
            r"..\b",
            "a%00",
        ] {
            assert!(file(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn data_uris_are_decoded() {
        let here = |uri| locate(Path::new(""), uri, &Files::default()).ok();
        let bytes = |text: &[u8]| Some(Location::Here(text.to_vec()));
        assert_eq!(here("data:application/octet-stream;base64,aGVsbG8="), bytes(b"hello"));
        assert_eq!(here("data:;base64,aGVsbG8"), bytes(b"hello"));
        assert_eq!(here("data:,a%20b"), bytes(b"a b"));
        assert_eq!(here("data:;base64,a*b"), None);
        assert_eq!(here("data:;base64,aGVsbA=x"), None);
        assert_eq!(here("data:nothing"), None);
    }

    #[test]
    fn broken_containers_are_refused() {
        let glb = |length: u32, rest: &[u8]| {
            let mut bytes = [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes()].concat();
            bytes.extend_from_slice(rest);
            Container::open(&bytes).map(|c| c.json.len()).map_err(|e| e.to_string())
        };
        assert!(Container::open(b"glTF\x02").is_err());
        assert!(glb(11, b"").is_err() && glb(400, b"").is_err() && glb(12, b"").is_err());
        assert!(glb(20, b"\xff\xff\xff\xffJSON").is_err());
        assert_eq!(glb(24, b"\x04\0\0\0JSON{}  "), Ok(2));
        assert_eq!(glb(24, b"\x04\0\0\0JSON{}\0\0"), Ok(2));
    }
}
