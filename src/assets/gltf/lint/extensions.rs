//! Extensions in places where they mean nothing, undeclared ones, and numbers out of their range.

use ::gltf::json::Value;

use super::checked::{Lint, array, index};

/// The objects that may hold an extension; an unknown one may be anywhere.
fn places(extension: &str) -> Option<&'static [&'static str]> {
    Some(match extension {
        "KHR_texture_transform" => &["texture reference"],
        "KHR_lights_punctual" => &["document", "nodes"],
        "KHR_materials_variants" => &["document", "primitives"],
        "EXT_mesh_gpu_instancing" | "KHR_node_visibility" | "KHR_node_hoverability" => &["nodes"],
        "KHR_animation_pointer" => &["targets"],
        "EXT_texture_webp" | "KHR_texture_basisu" => &["textures"],
        name if name.starts_with("KHR_materials_") => &["materials"],
        "KHR_mesh_quantization" => &[],
        _ => return None,
    })
}

pub(super) fn check(lint: &mut Lint<'_>) {
    let declared: Vec<&str> = array(lint.raw, "extensionsUsed")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    let required: Vec<&str> = array(lint.raw, "extensionsRequired")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    let mut found = Vec::new();
    walk(lint.raw, "document", &mut found);
    let odd = found.iter().filter(|(.., value)| !value.is_object());
    let odd: Vec<String> = odd
        .map(|(name, ..)| format!("{name} is used, but is no object"))
        .collect();
    let mut found: Vec<_> = found.into_iter().map(|(name, place, _)| (name, place)).collect();
    lint.faults.extend(odd);
    found.sort_unstable();
    found.dedup();
    for (name, place) in &found {
        if places(name).is_some_and(|known| !known.contains(place)) {
            lint.fault(format!("{name} is in {place}, where it means nothing"));
        }
        if !declared.contains(name) {
            lint.fault(format!("{name} is used, but not in extensionsUsed"));
        }
    }
    for name in required.iter().filter(|name| !declared.contains(name)) {
        lint.fault(format!("{name} is required, but not in extensionsUsed"));
    }
    let quantized = "KHR_mesh_quantization";
    if declared.contains(&quantized) && !required.contains(&quantized) {
        lint.fault(format!("{quantized} is used, but not required"));
    }
    lights(lint);
    variants(lint);
    for (i, material) in lint.array("materials").iter().enumerate() {
        ranges(lint, material, &format!("material {i}"));
    }
}

/// Collects extensions with the arrays that hold the objects that they are in.
fn walk<'a>(value: &'a Value, place: &'static str, found: &mut Vec<(&'a str, &'static str, &'a Value)>) {
    match value {
        Value::Array(values) => values.iter().for_each(|v| walk(v, place, found)),
        Value::Object(map) => {
            let used = map.get("extensions").and_then(Value::as_object);
            found.extend(
                used.into_iter()
                    .flatten()
                    .map(|(name, value)| (name.as_str(), place, value)),
            );
            for (key, value) in map.iter().filter(|(key, _)| *key != "extras") {
                let place = match key.as_str() {
                    "nodes" => "nodes",
                    "materials" => "materials",
                    "primitives" => "primitives",
                    "meshes" => "meshes",
                    "textures" => "textures",
                    "target" => "targets",
                    "pbrMetallicRoughness" => "pbrMetallicRoughness",
                    "extensions" => place,
                    key if key.ends_with("Texture") => "texture reference",
                    _ => match value {
                        Value::Object(_) | Value::Array(_) if place == "document" => "another object",
                        _ => place,
                    },
                };
                walk(value, place, found);
            }
        }
        _ => {}
    }
}

fn lights(lint: &mut Lint<'_>) {
    const NAME: &str = "/extensions/KHR_lights_punctual";
    let lights = lint.raw.pointer(&format!("{NAME}/lights")).and_then(Value::as_array);
    if lint.raw.pointer(NAME).is_some() && lights.is_none() {
        lint.fault("KHR_lights_punctual has no lights");
    }
    for (i, light) in lights.into_iter().flatten().enumerate() {
        match light.get("type").and_then(Value::as_str) {
            None => lint.fault(format!("light {i} has no type")),
            Some("spot") if light.get("spot").is_none() => lint.fault(format!("spot light {i} has no spot")),
            Some(_) => {}
        }
    }
    for (i, node) in lint.array("nodes").iter().enumerate() {
        if let Some(held) = node.pointer(NAME)
            && index(held, "light").is_none()
        {
            lint.fault(format!("KHR_lights_punctual of node {i} names no light"));
        }
    }
}

fn variants(lint: &mut Lint<'_>) {
    let path = "/extensions/KHR_materials_variants/variants";
    let variants = lint.raw.pointer(path).and_then(Value::as_array);
    for (i, variant) in variants.into_iter().flatten().enumerate() {
        if variant.get("name").is_none_or(|name| !name.is_string()) {
            lint.fault(format!("variant {i} has no name"));
        }
    }
    for mesh in lint.array("meshes") {
        for primitive in array(mesh, "primitives") {
            let Some(held) = primitive.pointer("/extensions/KHR_materials_variants") else {
                continue;
            };
            let sound = |m: &Value| index(m, "material").is_some() && m.get("variants").is_some();
            if held.get("mappings").is_none() || !array(held, "mappings").iter().all(sound) {
                lint.fault("KHR_materials_variants of a primitive names no material or variant");
            }
        }
    }
}

/// The range of a number of a material by its name.
fn range(key: &str) -> Option<(f64, f64)> {
    Some(match key {
        "thicknessFactor"
        | "emissiveStrength"
        | "dispersion"
        | "iridescenceThicknessMinimum"
        | "iridescenceThicknessMaximum" => (0.0, f64::INFINITY),
        "attenuationDistance" => (f64::MIN_POSITIVE, f64::INFINITY),
        "iridescenceIor" => (1.0, f64::INFINITY),
        "specularColorFactor" => (0.0, f64::INFINITY),
        "anisotropyStrength" | "attenuationColor" | "strength" => (0.0, 1.0),
        key if key.ends_with("Factor") => (0.0, 1.0),
        _ => return None,
    })
}

fn ranges(lint: &mut Lint<'_>, value: &Value, place: &str) {
    let Value::Object(map) = value else { return };
    for (key, value) in map.iter().filter(|(key, _)| *key != "extras") {
        let numbers = match value {
            Value::Array(numbers) => numbers.as_slice(),
            Value::Object(_) => {
                ranges(lint, value, place);
                continue;
            }
            number => std::slice::from_ref(number),
        };
        for number in numbers.iter().filter_map(Value::as_f64) {
            let wrong = match range(key) {
                Some((least, most)) => !(least..=most).contains(&number),
                None => key == "ior" && number != 0.0 && number < 1.0,
            };
            if wrong {
                lint.fault(format!("{place} has {key} = {number}, which is out of its range"));
            }
        }
    }
}
