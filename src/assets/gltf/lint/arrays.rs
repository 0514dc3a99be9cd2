//! Buffers, their views, and accessors: places, strides, alignments and bounds.

use ::gltf::json::Value;

use super::checked::{Lint, array, index};
use crate::assets::gltf::container::{Location, locate};

/// The most numbers whose bounds are compared with those that the file gives.
const MAX_COMPARED: usize = 1 << 20;

pub(super) fn check(lint: &mut Lint<'_>) {
    for (i, buffer) in lint.array("buffers").iter().enumerate() {
        let length = index(buffer, "byteLength");
        if length == Some(0) {
            lint.fault(format!("buffer {i} has no bytes"));
        }
        let Some(uri) = buffer.get("uri").and_then(Value::as_str) else {
            continue;
        };
        match locate(lint.document.folder, uri, lint.document.files) {
            Err(e) => lint.fault(format!("buffer {i}: {e}")),
            Ok(Location::File(path)) if !path.is_file() => {
                lint.fault(format!("buffer {i} names a file that is not there: {}", path.display()));
            }
            Ok(Location::Here(bytes)) if length.is_some_and(|n| n > bytes.len() || n + 3 < bytes.len()) => {
                let (said, found) = (length.unwrap_or(0), bytes.len());
                lint.fault(format!("buffer {i} should have {said} bytes, but has {found}"));
            }
            Ok(_) => {}
        }
    }
    views(lint);
    let mut compared = 0;
    for i in 0..lint.array("accessors").len() {
        accessor(lint, i, &mut compared);
    }
}

fn views(lint: &mut Lint<'_>) {
    for (i, view) in lint.array("bufferViews").iter().enumerate() {
        let number = |key: &str| index(view, key).unwrap_or(0);
        if number("byteLength") == 0 {
            lint.fault(format!("buffer view {i} has no bytes"));
        }
        let buffer = lint.named(view, "buffer", "buffers");
        let end = number("byteOffset").saturating_add(number("byteLength"));
        if buffer.and_then(|b| index(b, "byteLength")).is_some_and(|n| end > n) {
            lint.fault(format!("buffer view {i} reaches past the end of its buffer"));
        }
        let Some(stride) = index(view, "byteStride") else {
            continue;
        };
        if !(4..=252).contains(&stride) || stride % 4 != 0 {
            lint.fault(format!(
                "buffer view {i} has a byteStride of {stride}, not of 4 to 252 in steps of 4"
            ));
        } else if stride > number("byteLength") {
            lint.fault(format!("buffer view {i} has a byteStride larger than itself"));
        }
    }
}

/// The bytes of a number of this type.
pub(super) fn size_of_component(accessor: &Value) -> Option<usize> {
    Some(match accessor.get("componentType")?.as_u64()? {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        5125 | 5126 => 4,
        _ => return None,
    })
}

/// Whether an accessor has numbers in the file; those of others come from extensions.
pub(super) fn has_numbers(accessor: &Value) -> bool {
    accessor.get("bufferView").is_some() || accessor.get("sparse").is_some()
}

/// The numbers of an element.
fn width(accessor: &Value) -> Option<usize> {
    Some(match accessor.get("type")?.as_str()? {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        "MAT4" => 16,
        _ => return None,
    })
}

fn accessor(lint: &mut Lint<'_>, i: usize, compared: &mut usize) {
    let accessor = &lint.array("accessors")[i];
    let (Some(size), Some(width)) = (size_of_component(accessor), width(accessor)) else {
        return lint.fault(format!("accessor {i} is of an unknown type"));
    };
    let count = index(accessor, "count").unwrap_or(0);
    if count == 0 {
        lint.fault(format!("accessor {i} has no elements"));
    }
    let offset = index(accessor, "byteOffset").unwrap_or(0);
    if !offset.is_multiple_of(size) {
        lint.fault(format!(
            "accessor {i} has a byteOffset of {offset}, no multiple of {size}"
        ));
    }
    if let Some(view) = lint.named(accessor, "bufferView", "bufferViews") {
        let total = offset.saturating_add(index(view, "byteOffset").unwrap_or(0));
        if !total.is_multiple_of(size) {
            lint.fault(format!(
                "accessor {i} begins at byte {total} of its buffer, no multiple of {size}"
            ));
        }
        let element = size * width;
        let stride = index(view, "byteStride").unwrap_or(element);
        if stride < element {
            lint.fault(format!("accessor {i} has a stride of {stride} bytes for {element}"));
        }
        let length = count.saturating_sub(1).saturating_mul(stride).saturating_add(element);
        let end = offset.saturating_add(length);
        if count > 0 && index(view, "byteLength").is_some_and(|n| end > n) {
            lint.fault(format!("accessor {i} reaches past the end of its buffer view"));
        }
    }
    if let Some(sparse) = accessor.get("sparse")
        && index(sparse, "count").is_none_or(|n| n == 0 || n > count)
    {
        lint.fault(format!(
            "the sparse part of accessor {i} has more elements than it, or none"
        ));
    }
    bounds(lint, i, width, compared);
}

/// Compares the bounds that an accessor gives with its numbers.
fn bounds(lint: &mut Lint<'_>, i: usize, width: usize, compared: &mut usize) {
    let accessor = &lint.array("accessors")[i];
    let given = ["min", "max"].map(|key| array(accessor, key));
    if given.iter().all(|b| b.is_empty()) || !has_numbers(accessor) {
        return;
    }
    if given.iter().any(|b| !b.is_empty() && b.len() != width) {
        return lint.fault(format!("accessor {i} has bounds of another width than its elements"));
    }
    let count = index(accessor, "count").unwrap_or(0);
    *compared = compared.saturating_add(count.saturating_mul(width));
    if width > 4 || *compared > MAX_COMPARED {
        return;
    }
    let Ok(found) = lint.document.bounds(i) else { return };
    for (key, given, found) in [("min", given[0], found.0), ("max", given[1], found.1)] {
        let differs = |(given, found): (&Value, &f32)| {
            let given = given.as_f64().unwrap_or(f64::NAN) as f32;
            (given - found).abs() > 1e-6 * found.abs().max(1.0)
        };
        if given.iter().zip(&found).any(differs) {
            lint.fault(format!("the {key} of accessor {i} differs from its numbers"));
        }
    }
}
