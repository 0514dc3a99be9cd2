//! Validation of a document beyond the needs of rendering, including its unused parts.
//!
//! Faults that prevent rendering are errors of the loader; all others are found here and become warnings. The rules are those of
//! the specification; names in messages are those of its JSON.

mod animations;
mod arrays;
mod checked;
mod extensions;
mod images;
mod meshes;

use ::gltf::json::Value;

use super::document::Document;
use crate::value::one_line;
use checked::{Lint, array, index};

/// The most faults of a file that are reported one by one.
const MAX_FAULTS: usize = 20;

/// The faults of a document whose images `used` are rendered.
pub(super) fn faults(document: &Document<'_>, used: &[usize]) -> Vec<String> {
    let mut lint = Lint {
        document,
        raw: &document.raw,
        faults: document.container_faults.iter().map(|f| (*f).to_owned()).collect(),
    };
    empty_arrays(&mut lint);
    extensions::check(&mut lint);
    arrays::check(&mut lint);
    images::check(&mut lint, used);
    meshes::check(&mut lint);
    animations::check(&mut lint);
    cameras(&mut lint);
    lights(&mut lint);
    nodes(&mut lint);
    skins(&mut lint);
    let mut faults = lint.faults;
    if let Some(more) = faults.len().checked_sub(MAX_FAULTS).filter(|n| *n > 0) {
        faults.truncate(MAX_FAULTS);
        faults.push(format!("and {more} more faults"));
    }
    faults
}

/// Reports empty arrays, which the format does not allow. Recursion ends: the JSON reader accepts at most 128 levels.
fn empty_arrays(lint: &mut Lint<'_>) {
    fn walk(value: &Value, place: &str, out: &mut Vec<String>) {
        match value {
            // Parsing adds `nodes` to scenes without nodes.
            Value::Array(values) if values.is_empty() && !place.ends_with(".nodes") => {
                out.push(format!("{place} is an empty array"));
            }
            Value::Array(values) => {
                let is_list = values.iter().any(|v| v.is_object() || v.is_array());
                for (i, value) in values.iter().enumerate().filter(|_| is_list) {
                    walk(value, &format!("{place}[{i}]"), out);
                }
            }
            Value::Object(map) => {
                for (key, value) in map.iter().filter(|(key, _)| *key != "extras") {
                    let dot = if place.is_empty() { "" } else { "." };
                    walk(value, &format!("{place}{dot}{key}"), out);
                }
            }
            _ => {}
        }
    }
    walk(lint.raw, "", &mut lint.faults);
    for place in &lint.document.empty_scenes {
        lint.faults.push(format!("scenes[{place}].nodes is an empty array"));
    }
}

fn cameras(lint: &mut Lint<'_>) {
    for (i, camera) in lint.array("cameras").iter().enumerate() {
        let kinds = ["perspective", "orthographic"];
        if kinds.iter().all(|kind| camera.get(kind).is_some()) {
            lint.fault(format!("camera {i} is both perspective and orthographic"));
        }
        for key in ["xmag", "ymag"] {
            let size = camera.pointer(&format!("/orthographic/{key}")).and_then(Value::as_f64);
            if size == Some(0.0) {
                lint.fault(format!("camera {i} has {key} = 0"));
            }
        }
    }
}

fn lights(lint: &mut Lint<'_>) {
    let lights = lint.raw.pointer("/extensions/KHR_lights_punctual/lights");
    for (i, light) in lights.and_then(Value::as_array).into_iter().flatten().enumerate() {
        let number = |path: &str| light.pointer(path).and_then(Value::as_f64);
        let colors = array(light, "color").iter().filter_map(Value::as_f64);
        if number("/intensity").into_iter().chain(colors).any(|v| v < 0.0) {
            lint.fault(format!("light {i} has an intensity or a colour below 0"));
        }
        let kind = light.get("type").and_then(Value::as_str).unwrap_or("none");
        if !["point", "directional", "spot"].contains(&kind) {
            let kind = one_line(kind, 40);
            lint.fault(format!("light {i} is of an unknown type, `{kind}`, and is left out"));
        }
        let inner = number("/spot/innerConeAngle").unwrap_or(0.0);
        let outer = number("/spot/outerConeAngle").unwrap_or(std::f64::consts::FRAC_PI_4);
        if light.get("spot").is_some() && !(0.0 <= inner && inner < outer && outer <= std::f64::consts::FRAC_PI_2) {
            lint.fault(format!(
                "light {i} has no cone from {inner} within {outer}: they are 0 <= inner < outer <= pi / 2"
            ));
        }
    }
}

fn nodes(lint: &mut Lint<'_>) {
    let nodes = lint.array("nodes");
    for (i, node) in nodes.iter().enumerate() {
        let has = |key: &str| node.get(key).is_some();
        if has("matrix") && ["translation", "rotation", "scale"].iter().any(|key| has(key)) {
            lint.fault(format!("node {i} has a matrix beside translation, rotation or scale"));
        }
        for key in ["skin", "weights"] {
            if has(key) && !has("mesh") {
                lint.fault(format!("node {i} has {key} but no mesh"));
            }
        }
    }
    let mut is_child = vec![false; nodes.len()];
    for child in nodes.iter().flat_map(|n| array(n, "children")) {
        let child = child.as_u64().and_then(|c| usize::try_from(c).ok());
        if let Some(known) = child.and_then(|c| is_child.get_mut(c)) {
            *known = true;
        }
    }
    for (i, scene) in lint.array("scenes").iter().enumerate() {
        for root in array(scene, "nodes").iter().filter_map(Value::as_u64) {
            if is_child.get(root as usize) == Some(&true) {
                lint.fault(format!("scene {i} names node {root}, which has a parent"));
            }
        }
    }
}

fn skins(lint: &mut Lint<'_>) {
    for (i, skin) in lint.array("skins").iter().enumerate() {
        let Some(accessor) = index(skin, "inverseBindMatrices") else {
            continue;
        };
        let joints = array(skin, "joints").len();
        let count = lint.array("accessors").get(accessor).and_then(|a| index(a, "count"));
        if count.is_some_and(|n| n < joints) {
            lint.fault(format!("skin {i} has fewer inverse bind matrices than joints"));
        }
        if let Ok(columns) = lint.document.matrix_bottoms(accessor)
            && columns.iter().any(|bottom| *bottom != [0.0, 0.0, 0.0, 1.0])
        {
            lint.fault(format!(
                "skin {i} has inverse bind matrices whose last row is not 0 0 0 1"
            ));
        }
    }
}
