//! Small assets for tests.

/// A GLB of arrays of floats, each an accessor with its number of numbers an element, and the rest of its JSON.
pub fn glb(arrays: &[(usize, &[f32])], rest: &str) -> Vec<u8> {
    let (mut binary, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    for (view, (width, numbers)) in arrays.iter().enumerate() {
        let (start, length) = (binary.len(), 4 * numbers.len());
        binary.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
        views.push(format!(
            r#"{{"buffer": 0, "byteOffset": {start}, "byteLength": {length}}}"#
        ));
        let (count, kind) = (numbers.len() / width, ["", "SCALAR", "VEC2", "VEC3", "VEC4"][*width]);
        accessors.push(format!(
            r#"{{"bufferView": {view}, "componentType": 5126, "count": {count}, "type": "{kind}"}}"#
        ));
    }
    let (length, views, accessors) = (binary.len(), views.join(","), accessors.join(","));
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {length}}}], "bufferViews": [{views}],
        "accessors": [{accessors}], {rest}}}"#
    );
    of_chunks(&json, &binary)
}

/// A GLB of its JSON and its binary chunk.
pub fn of_chunks(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((12 + 8 + json.len() + 8 + binary.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_bytes()), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}
