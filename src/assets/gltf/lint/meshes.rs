//! Meshes: attributes, indices, morph targets, joints and texture coordinates.

use std::collections::{BTreeMap, HashMap, HashSet};

use ::gltf::json::Value;

use super::{
    arrays::{has_numbers, size_of_component},
    checked::{Lint, array, index},
};

/// The largest error of the length of a normal; more than that of numbers of 8 bits.
const UNIT_TOLERANCE: f32 = 0.02;

pub(super) fn check(lint: &mut Lint<'_>) {
    let mut views = BTreeMap::<usize, usize>::new();
    let (mut normals, mut colors) = (HashSet::new(), HashSet::new());
    for (m, mesh) in lint.array("meshes").iter().enumerate() {
        let mut targets = None;
        for (p, primitive) in array(mesh, "primitives").iter().enumerate() {
            let place = format!("primitive {p} of mesh {m}");
            attributes(lint, primitive, &place, (&mut views, &mut colors));
            unit_normals(lint, primitive, &place, &mut normals);
            indices(lint, primitive, &place);
            morphs(lint, primitive, &place);
            joints(lint, primitive, &place);
            coordinates(lint, primitive, &place);
            targets = targets.max(Some(array(primitive, "targets").len()));
        }
        let weights = mesh.get("weights").and_then(Value::as_array).map(Vec::len);
        if let (Some(weights), Some(targets)) = (weights, targets)
            && weights != targets
        {
            lint.fault(format!("mesh {m} has {weights} weights for {targets} morph targets"));
        }
    }
    for (view, users) in views {
        let stride = lint.array("bufferViews").get(view).and_then(|v| v.get("byteStride"));
        if users > 1 && stride.is_none() {
            lint.fault(format!(
                "buffer view {view} holds several attributes and has no byteStride"
            ));
        }
    }
}

fn is_known(semantic: &str) -> bool {
    let numbered = |name: &str| {
        let rest = semantic.strip_prefix(name);
        rest.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
    };
    matches!(semantic, "POSITION" | "NORMAL" | "TANGENT")
        || semantic.starts_with('_')
        || ["TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"].into_iter().any(numbered)
}

/// The attributes of a primitive, or of a morph target, with their accessors' numbers.
fn entries(value: &Value) -> impl Iterator<Item = (&str, usize)> {
    let map = value.as_object().into_iter().flatten();
    map.filter_map(|(name, accessor)| Some((name.as_str(), usize::try_from(accessor.as_u64()?).ok()?)))
}

/// Whether an attribute may have numbers of its accessor's type.
fn is_allowed(semantic: &str, accessor: &Value, is_quantized: bool) -> bool {
    // The numbers of the types: byte, unsigned byte, short, unsigned short, float.
    const BYTE: u64 = 5120;
    const UBYTE: u64 = 5121;
    const SHORT: u64 = 5122;
    const USHORT: u64 = 5123;
    const FLOAT: u64 = 5126;
    let is_normalized = accessor.get("normalized").and_then(Value::as_bool) == Some(true);
    let Some(component) = accessor.get("componentType").and_then(Value::as_u64) else {
        return true;
    };
    let unsigned = [UBYTE, USHORT].contains(&component);
    let whole = unsigned || [BYTE, SHORT].contains(&component);
    match semantic.split('_').next().unwrap_or_default() {
        "POSITION" => component == FLOAT || is_quantized && whole,
        "NORMAL" | "TANGENT" => component == FLOAT || is_quantized && whole && !unsigned && is_normalized,
        "TEXCOORD" => component == FLOAT || unsigned && is_normalized || is_quantized && whole,
        "COLOR" | "WEIGHTS" => component == FLOAT || unsigned && is_normalized,
        "JOINTS" => unsigned && !is_normalized,
        _ => true,
    }
}

/// Whether a colour is negative, above 1 or not finite.
fn is_out_of_range(lint: &Lint<'_>, accessor: usize) -> bool {
    let (Ok((least, most)), Ok(largest)) = (lint.document.range(accessor), lint.document.largest(accessor)) else {
        return false;
    };
    // Exporters round.
    !(least >= -0.001 && most / largest <= 1.001)
}

fn attributes(
    lint: &mut Lint<'_>,
    primitive: &Value,
    place: &str,
    (views, colors): (&mut BTreeMap<usize, usize>, &mut HashSet<usize>),
) {
    let used = array(lint.raw, "extensionsUsed").iter();
    let is_quantized = used
        .filter_map(Value::as_str)
        .any(|name| name == "KHR_mesh_quantization");
    let Some(given) = primitive.get("attributes") else {
        return lint.fault(format!("{place} has no attributes"));
    };
    let mut own = HashMap::<usize, Vec<usize>>::new();
    for (name, number) in entries(given) {
        if !is_known(name) {
            lint.fault(format!("{place} has an attribute of an unknown name"));
        }
        let Some(accessor) = lint.array("accessors").get(number) else {
            continue;
        };
        if !is_allowed(name, accessor, is_quantized) {
            lint.fault(format!(
                "the attribute {name} of {place} has numbers of a type that the format forbids"
            ));
        }
        if name.starts_with("COLOR_") && colors.insert(number) && has_numbers(accessor) && is_out_of_range(lint, number)
        {
            lint.fault(format!(
                "the attribute {name} of {place} has colours that are not between 0 and 1"
            ));
        }
        if name == "POSITION" && (accessor.get("min").is_none() || accessor.get("max").is_none()) {
            lint.fault(format!("the positions of {place} have no min and max"));
        }
        let Some(view) = index(accessor, "bufferView") else {
            continue;
        };
        let size = size_of_component(accessor).unwrap_or(4);
        let stride = lint.array("bufferViews").get(view).and_then(|v| index(v, "byteStride"));
        let offset = index(accessor, "byteOffset").unwrap_or(0);
        if !offset.is_multiple_of(4)
            || stride.is_some_and(|s| !s.is_multiple_of(4))
            || stride.is_none() && is_packed_oddly(accessor, size)
        {
            lint.fault(format!(
                "the attribute {name} of {place} is not at multiples of 4 bytes"
            ));
        }
        own.entry(view).or_default().push(number);
    }
    for (view, mut accessors) in own {
        accessors.sort_unstable();
        accessors.dedup();
        let users = views.entry(view).or_default();
        *users = (*users).max(accessors.len());
    }
}

/// Whether the elements of an accessor without a stride are no multiple of 4 bytes.
fn is_packed_oddly(accessor: &Value, size: usize) -> bool {
    let width = match accessor.get("type").and_then(Value::as_str) {
        Some("VEC2") => 2,
        Some("VEC3") => 3,
        Some("VEC4") => 4,
        _ => 1,
    };
    !(size * width).is_multiple_of(4) && index(accessor, "count").is_some_and(|n| n > 1)
}

/// Reports normals that are no unit vectors, once for each accessor in `known`.
fn unit_normals(lint: &mut Lint<'_>, primitive: &Value, place: &str, known: &mut HashSet<usize>) {
    let number = index(&primitive["attributes"], "NORMAL");
    let Some(number) = number.filter(|number| known.insert(*number)) else {
        return;
    };
    if !lint.array("accessors").get(number).is_some_and(has_numbers) {
        return;
    }
    let Ok(normals) = lint.document.floats::<3>(number) else {
        return;
    };
    let length2 = |n: &[f32; 3]| n.iter().map(|v| v * v).sum::<f32>();
    let is_unit = |n: &&[f32; 3]| (length2(n).sqrt() - 1.0).abs() < UNIT_TOLERANCE;
    let (odd, none) = (
        normals.iter().filter(|n| !is_unit(n)).count(),
        normals.iter().filter(|n| length2(n) == 0.0).count(),
    );
    if odd > 0 {
        let total = normals.len();
        lint.fault(format!(
            "{odd} of the {total} normals of {place} are no unit vectors, {none} of them are zero"
        ));
    }
}

fn indices(lint: &mut Lint<'_>, primitive: &Value, place: &str) {
    let Some(number) = index(primitive, "indices") else {
        return;
    };
    let Some(accessor) = lint.array("accessors").get(number) else {
        return;
    };
    let component = accessor.get("componentType").and_then(Value::as_u64);
    let is_scalar = accessor.get("type").and_then(Value::as_str) == Some("SCALAR");
    let is_normalized = accessor.get("normalized").and_then(Value::as_bool) == Some(true);
    if !is_scalar || is_normalized || !matches!(component, Some(5121 | 5123 | 5125)) {
        return lint.fault(format!("the indices of {place} are no whole numbers"));
    }
    let view = lint.named(accessor, "bufferView", "bufferViews");
    if view.is_some_and(|v| v.get("byteStride").is_some()) {
        lint.fault(format!("the indices of {place} have a byteStride"));
    }
    let restart = match component {
        Some(5121) => 0xff,
        Some(5123) => 0xffff,
        _ => u32::MAX,
    };
    if let Ok(indices) = lint.document.indices(number)
        && indices.contains(&restart)
    {
        lint.fault(format!(
            "the indices of {place} hold {restart}, which would begin a new strip"
        ));
    }
}

fn morphs(lint: &mut Lint<'_>, primitive: &Value, place: &str) {
    for target in array(primitive, "targets") {
        for (name, number) in entries(target) {
            if primitive.pointer(&format!("/attributes/{name}")).is_none() {
                lint.fault(format!(
                    "a morph target of {place} moves {name}, which the primitive does not have"
                ));
            }
            let accessor = lint.array("accessors").get(number);
            if name == "POSITION" && accessor.is_some_and(|a| a.get("min").is_none() || a.get("max").is_none()) {
                lint.fault(format!(
                    "the positions of a morph target of {place} have no min and max"
                ));
            }
        }
    }
}

fn joints(lint: &mut Lint<'_>, primitive: &Value, place: &str) {
    let attribute = |name: &str, set: u32| index(&primitive["attributes"], &format!("{name}_{set}"));
    let mut sums = Vec::new();
    for set in 0..4 {
        let (joints, weights) = (attribute("JOINTS", set), attribute("WEIGHTS", set));
        match (joints, weights) {
            (None, None) => break,
            (Some(joints), Some(weights)) => influences(lint, (joints, weights), &mut sums, place),
            _ => {
                return lint.fault(format!(
                    "{place} has different numbers of sets of joints and of weights"
                ));
            }
        }
    }
    if sums.iter().any(|sum: &f32| (sum - 1.0).abs() > 0.02) {
        lint.fault(format!("{place} has weights of joints whose sum is not 1"));
    }
}

/// Checks a set of influences, and adds its weights to the `sums` of the vertices.
fn influences(lint: &mut Lint<'_>, (joints, weights): (usize, usize), sums: &mut Vec<f32>, place: &str) {
    if !lint.array("accessors").get(weights).is_some_and(has_numbers) {
        return;
    }
    let (Ok(joints), Ok(weights)) = (lint.document.floats::<4>(joints), lint.document.floats::<4>(weights)) else {
        return;
    };
    if !weights.iter().flatten().all(|w| *w >= 0.0 && w.is_finite()) {
        lint.fault(format!("{place} has weights of joints below 0 or not finite"));
    }
    sums.resize(sums.len().max(weights.len()), 0.0);
    for (sum, weights) in sums.iter_mut().zip(&weights) {
        *sum += weights.iter().sum::<f32>();
    }
    let twice =
        |(j, w): (&[f32; 4], &[f32; 4])| (0..4).any(|a| (0..a).any(|b| j[a] == j[b] && w[a] != 0.0 && w[b] != 0.0));
    if joints.iter().zip(&weights).any(twice) {
        lint.fault(format!("{place} has vertices with one joint twice"));
    }
    let skins = lint.array("skins").iter().map(|s| array(s, "joints").len());
    if let Some(most) = skins.max()
        && joints.iter().flatten().any(|j| *j as usize >= most)
    {
        lint.fault(format!("{place} names joints that no skin has"));
    }
}

/// Reports textures whose coordinates a primitive does not have.
fn coordinates(lint: &mut Lint<'_>, primitive: &Value, place: &str) {
    let Some(material) = lint.named(primitive, "material", "materials") else {
        return;
    };
    let mut sets = Vec::new();
    crate::assets::gltf::materials::texture_infos(material, &mut sets);
    sets.sort_unstable();
    sets.dedup();
    for set in sets {
        if primitive.pointer(&format!("/attributes/TEXCOORD_{set}")).is_none() {
            lint.fault(format!(
                "a texture of {place} reads TEXCOORD_{set}, which the primitive does not have"
            ));
        }
    }
}
