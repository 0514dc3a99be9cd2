//! The features that a document uses, and their treatment.

use ::gltf::json::Value;

use crate::assets::model::{ANIMATIONS, Model, ModelChoice, Treatment};

/// The extension with the lights of nodes.
pub(super) const LIGHTS: &str = "KHR_lights_punctual";

/// The known extensions, which files may require. Unknown ones that a file only uses are reported.
const EXTENSIONS: [(&str, Treatment); 25] = [
    ("EXT_mesh_gpu_instancing", Treatment::Rendered),
    ("EXT_texture_webp", Treatment::Rendered),
    (LIGHTS, Treatment::Rendered),
    ("KHR_animation_pointer", Treatment::Rendered),
    ("KHR_materials_anisotropy", Treatment::Rendered),
    ("KHR_materials_clearcoat", Treatment::Rendered),
    ("KHR_materials_diffuse_transmission", Treatment::Rendered),
    ("KHR_materials_dispersion", Treatment::Rendered),
    ("KHR_materials_emissive_strength", Treatment::Rendered),
    ("KHR_materials_ior", Treatment::Rendered),
    ("KHR_materials_iridescence", Treatment::Rendered),
    ("KHR_materials_pbrSpecularGlossiness", Treatment::Rendered),
    ("KHR_materials_sheen", Treatment::Rendered),
    ("KHR_materials_specular", Treatment::Rendered),
    ("KHR_materials_transmission", Treatment::Rendered),
    ("KHR_materials_unlit", Treatment::Rendered),
    ("KHR_materials_variants", Treatment::Rendered),
    ("KHR_materials_volume", Treatment::Rendered),
    ("KHR_mesh_quantization", Treatment::Rendered),
    ("KHR_node_visibility", Treatment::Rendered),
    ("KHR_texture_transform", Treatment::Rendered),
    ("KHR_xmp", Treatment::Unneeded("it holds no picture")),
    ("KHR_xmp_json_ld", Treatment::Unneeded("it holds no picture")),
    ("MSFT_lod", Treatment::Unneeded("the finest level is shown")),
    (
        "KHR_node_hoverability",
        Treatment::Unneeded("it is for pointers on a screen"),
    ),
];

/// The treatment of an extension; `None` of an unknown one.
pub(super) fn treatment(extension: &str) -> Option<Treatment> {
    let known = EXTENSIONS.iter().find(|(name, _)| *name == extension);
    known.map(|(_, treatment)| *treatment)
}

/// Adds the document's features to `model`.
pub(super) fn collect(document: &Value, choice: &ModelChoice, model: &mut Model) {
    let animations = match &choice.animation {
        None => Treatment::Without("the rest pose is shown"),
        Some(_) => Treatment::Rendered,
    };
    all(document, animations, model);
    let lights = match choice.lights {
        Some(true) => return,
        Some(false) => Treatment::Unneeded("`lights = false`"),
        None => Treatment::Without("`lights = true` of the mesh lets them shine"),
    };
    for feature in model.features.iter_mut().filter(|f| f.name == LIGHTS) {
        feature.treatment = lights;
    }
}

fn all(document: &Value, animations: Treatment, model: &mut Model) {
    extensions(document, "file", model);
    let count = |key: &str| document.get(key).and_then(Value::as_array).map_or(0, Vec::len);
    for _ in 0..count("animations") {
        model.add_feature(ANIMATIONS, "animation", animations);
    }
    for _ in 0..count("skins") {
        model.add_feature("skins", "skin", Treatment::Rendered);
    }
    // Extensions that the document declares but does not use.
    let used = document.get("extensionsUsed").and_then(Value::as_array);
    for name in used.into_iter().flatten().filter_map(Value::as_str) {
        if !model.features.iter().any(|f| f.name == name) {
            model.add_feature(name, "file", treatment(name).unwrap_or(Treatment::Without("")));
        }
    }
}

/// Counts the extensions of a value and of all values in it. Recursion ends: the JSON reader accepts 128 levels at the most.
fn extensions(value: &Value, what: &'static str, model: &mut Model) {
    match value {
        Value::Array(values) => values.iter().for_each(|v| extensions(v, what, model)),
        Value::Object(map) => {
            if let Some(Value::Object(used)) = map.get("extensions") {
                for name in used.keys() {
                    model.add_feature(name, what, treatment(name).unwrap_or(Treatment::Without("")));
                }
            }
            for (key, value) in map {
                let what = match key.as_str() {
                    "materials" => "material",
                    "meshes" => "mesh",
                    "nodes" => "node",
                    "textures" => "texture",
                    "images" => "image",
                    "cameras" => "camera",
                    "lights" => "light",
                    "bufferViews" => "buffer view",
                    "animations" => "animation",
                    "extras" => continue,
                    _ => what,
                };
                extensions(value, what, model);
            }
        }
        _ => {}
    }
}
