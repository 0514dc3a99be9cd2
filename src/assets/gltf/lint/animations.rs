//! Validation of animations, also of those that are not played.

use std::collections::HashSet;

use ::gltf::json::Value;

use super::checked::{Lint, array, index};

const POINTER: &str = "KHR_animation_pointer";

pub(super) fn check(lint: &mut Lint<'_>) {
    for (i, animation) in lint.array("animations").iter().enumerate() {
        let samplers = array(animation, "samplers");
        for (s, sampler) in samplers.iter().enumerate() {
            let place = format!("sampler {s} of animation {i}");
            let of = |key: &str| lint.named(sampler, key, "accessors");
            let (input, output) = (of("input"), of("output"));
            if input.is_some_and(|a| a.get("min").is_none() || a.get("max").is_none()) {
                lint.fault(format!("the input of {place} has no min and max"));
            }
            for accessor in [input, output].into_iter().flatten() {
                let view = lint.named(accessor, "bufferView", "bufferViews");
                if view.is_some_and(|v| v.get("byteStride").is_some()) {
                    lint.fault(format!("the numbers of {place} have a byteStride"));
                }
            }
        }
        let mut targets = HashSet::new();
        for (c, channel) in array(animation, "channels").iter().enumerate() {
            if !targets.insert(what_moves(&channel["target"])) {
                lint.fault(format!("channel {c} of animation {i} moves what another one moves"));
            }
            let place = format!("channel {c} of animation {i}");
            let sampler = index(channel, "sampler").and_then(|s| samplers.get(s));
            target(lint, channel, sampler, &place);
        }
    }
}

/// The node and the property that a channel moves, or the property that an extension names.
fn what_moves(target: &Value) -> (Option<usize>, Option<&str>, Option<&str>) {
    let pointer = target.pointer(&format!("/extensions/{POINTER}/pointer"));
    let path = target.get("path");
    (
        index(target, "node"),
        path.and_then(Value::as_str),
        pointer.and_then(Value::as_str),
    )
}

fn target(lint: &mut Lint<'_>, channel: &Value, sampler: Option<&Value>, place: &str) {
    let target = &channel["target"];
    let path = target.get("path").and_then(Value::as_str).unwrap_or_default();
    let node = lint.named(target, "node", "nodes");
    if target.get("extensions").is_some_and(|e| e.get(POINTER).is_some()) && path != "pointer" {
        lint.fault(format!("{place} has {POINTER}, but not the path `pointer`"));
    }
    if path == "weights" {
        let mesh = node.and_then(|n| lint.named(n, "mesh", "meshes"));
        let has_targets = |mesh: &Value| array(mesh, "primitives").iter().any(|p| p.get("targets").is_some());
        if node.is_some() && !mesh.is_some_and(has_targets) {
            lint.fault(format!("{place} moves the weights of a node without morph targets"));
        }
    }
    let Some(number) = sampler.and_then(|s| index(s, "output")) else {
        return;
    };
    let Some(output) = lint.array("accessors").get(number) else {
        return;
    };
    let kind = output.get("type").and_then(Value::as_str).unwrap_or_default();
    let expected = match path {
        "translation" | "scale" => "VEC3",
        "rotation" => "VEC4",
        "weights" => "SCALAR",
        _ => return,
    };
    if kind != expected {
        return lint.fault(format!("{place} has an output of {kind}, not of {expected}"));
    }
    if path != "rotation" {
        return;
    }
    let Ok(rotations) = lint.document.floats::<4>(number) else {
        return;
    };
    let is_cubic = sampler.and_then(|s| s.get("interpolation")).and_then(Value::as_str) == Some("CUBICSPLINE");
    // The middle one of three numbers of a spline is the value.
    let values = rotations.iter().enumerate().filter(|(i, _)| !is_cubic || i % 3 == 1);
    let is_unit = |q: &[f32; 4]| (q.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 0.01;
    if values.map(|(_, q)| q).any(|q| !is_unit(q)) {
        lint.fault(format!("{place} has rotations that are no unit quaternions"));
    }
}
