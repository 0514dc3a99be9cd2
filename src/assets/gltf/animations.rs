//! Animations: what each of them is called and moves, and the keys of those that are played.
//!
//! Sources: Khronos, "glTF 2.0 Specification", section 3.11, and "KHR_animation_pointer".

use std::{
    collections::{BTreeSet, HashMap, HashSet},
    sync::Arc,
};

use ::gltf::json::Value;

use super::{
    document::{Document, get},
    error::GltfProblem,
    json::index,
};
use crate::{
    assets::{
        model::{AnimationChoice, Model, Treatment},
        motion::{CameraProperty, Channel, Clip, LightProperty, MaterialProperty, ModelClip, Target, texture_property},
    },
    math::{
        keys::{KeyInterp, Keys},
        sorting,
    },
    value::{UnknownName, one_line, unique_names},
};

/// A channel of an animation that is played.
pub(super) struct PlayedChannel {
    pub moved: Target,
    pub keys: Keys,
}

/// An animation that is played.
pub(super) struct Played {
    pub channels: Vec<PlayedChannel>,
    pub end: f32,
}

impl Played {
    /// The animation as the model keeps it, without channels whose target is not shown.
    pub fn shown(self, target: impl Fn(&Target) -> Option<Target>) -> Clip {
        let channels = self.channels.into_iter();
        Clip {
            end: self.end,
            channels: channels
                .filter_map(|PlayedChannel { moved, keys }| target(&moved).map(|target| Channel { target, keys }))
                .collect(),
        }
    }
}

/// A channel in the JSON.
struct RawChannel<'a> {
    /// A JSON pointer to what it moves.
    pointer: String,
    sampler: Option<&'a Value>,
}

fn items<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn channels(animation: &Value) -> impl Iterator<Item = RawChannel<'_>> {
    let samplers = items(animation, "samplers");
    items(animation, "channels").iter().filter_map(|channel| {
        let target = channel.get("target")?;
        let pointer = target.pointer("/extensions/KHR_animation_pointer/pointer");
        let pointer = match pointer.and_then(Value::as_str) {
            Some(pointer) => pointer.to_owned(),
            None => format!("/nodes/{}/{}", index(target, "node")?, target.get("path")?.as_str()?),
        };
        let sampler = index(channel, "sampler").and_then(|sampler| samplers.get(sampler));
        Some(RawChannel { pointer, sampler })
    })
}

/// The names of all animations.
fn names(animations: &[Value]) -> Vec<String> {
    let own = |animation: &Value| animation.get("name").and_then(Value::as_str).map(str::to_owned);
    let own: Vec<String> = animations
        .iter()
        .map(|animation| own(animation).unwrap_or_default())
        .collect();
    unique_names(own.iter().map(String::as_str))
}

/// Adds all animations of a document to `model`; returns those that are played.
pub(super) fn read(
    document: &Document<'_>,
    choice: Option<&AnimationChoice>,
    light_divisor: u32,
    model: &mut Model,
) -> Result<Vec<Played>, GltfProblem> {
    let animations = items(&document.raw, "animations");
    let names = names(animations);
    let mut ends = HashMap::new();
    for (animation, name) in animations.iter().zip(&names) {
        model.clips.push(summary(document, animation, name.clone(), &mut ends));
    }
    let chosen: BTreeSet<usize> = match choice {
        None => return Ok(Vec::new()),
        Some(AnimationChoice::All) => sorting::ordered(0..animations.len()),
        Some(AnimationChoice::Named(chosen)) => {
            let chosen: Result<Vec<usize>, _> = chosen.iter().map(|name| find(name, &names)).collect();
            sorting::ordered(chosen?)
        }
    };
    let mut owners: HashMap<String, usize> = HashMap::new();
    let mut times = HashMap::new();
    let mut played = Vec::new();
    for number in chosen {
        let shown = one_line(&names[number], 80);
        let mut clip = Played {
            channels: Vec::new(),
            end: 0.0,
        };
        for RawChannel { pointer, sampler } in channels(&animations[number]) {
            let owner = *owners.entry(pointer.clone()).or_insert(number);
            if owner != number {
                let other = one_line(&names[owner], 80);
                let what = described(document, &pointer);
                return Err(GltfProblem::Conflict(format!(
                    "the animations `{other}` and `{shown}` both move {what}"
                )));
            }
            let Some((moved, width)) = moved(&pointer, light_divisor) else {
                let still = Treatment::Without("it stays as it is at rest");
                model.add_feature(&pointer, "channel", still);
                continue;
            };
            let place = || format!("{} in the animation `{shown}`", described(document, &pointer));
            let sampler = sampler.ok_or_else(|| GltfProblem::broken(format!("{} has no sampler", place())))?;
            let keys = keys(document, sampler, width, &mut times).map_err(|e| e.within(&place()))?;
            clip.end = clip.end.max(keys.end());
            clip.channels.push(PlayedChannel { moved, keys });
        }
        played.push(clip);
    }
    Ok(played)
}

fn find(name: &str, names: &[String]) -> Result<usize, GltfProblem> {
    let unknown = || {
        let unknown = UnknownName::new("animation", name, names.iter().map(String::as_str));
        GltfProblem::UnknownName(if names.is_empty() {
            unknown.with_fallback(Some("the model has none".to_owned()))
        } else {
            unknown
        })
    };
    names.iter().position(|known| known == name).ok_or_else(unknown)
}

/// The property that a pointer names, in words.
fn described(document: &Document<'_>, pointer: &str) -> String {
    let mut parts = pointer.trim_start_matches('/').splitn(3, '/');
    match (parts.next(), parts.next(), parts.next()) {
        (Some("nodes"), Some(number), Some(property)) => {
            let node = number.parse().ok().and_then(|n: usize| document.root.nodes.get(n));
            let name = node
                .and_then(|node| node.name.as_deref())
                .map_or_else(String::new, |name| format!(" `{}`", one_line(name, 80)));
            format!("the {} of node {number}{name}", one_line(property, 80))
        }
        _ => one_line(pointer, 160).into_owned(),
    }
}

/// The target of a pointer, and the number of components in a key; 0 stands for any.
fn moved(pointer: &str, light_divisor: u32) -> Option<(Target, usize)> {
    let mut parts = pointer.strip_prefix('/')?.splitn(3, '/');
    let (kind, number, property) = (parts.next()?, parts.next()?, parts.next()?);
    if let Some(light) = pointer.strip_prefix("/extensions/KHR_lights_punctual/lights/") {
        let (number, property) = light.split_once('/')?;
        let (property, width) = match property {
            "color" => (LightProperty::Color, 3),
            "intensity" => (LightProperty::Intensity { divisor: light_divisor }, 1),
            "spot/innerConeAngle" => (LightProperty::InnerCone, 1),
            "spot/outerConeAngle" => (LightProperty::OuterCone, 1),
            _ => return None,
        };
        return Some((Target::Light(number.parse().ok()?, property), width));
    }
    let number: usize = number.parse().ok()?;
    Some(match (kind, property) {
        ("nodes", "translation") => (Target::Translation(number), 3),
        ("nodes", "rotation") => (Target::Rotation(number), 4),
        ("nodes", "scale") => (Target::Scale(number), 3),
        ("nodes", "weights") => (Target::NodeWeights(number), 0),
        ("meshes", "weights") => (Target::MeshWeights(number), 0),
        ("cameras", "perspective/yfov") => (Target::Camera(number, CameraProperty::Fov), 1),
        ("cameras", "orthographic/ymag") => (Target::Camera(number, CameraProperty::HalfHeight), 1),
        ("materials", path) => match MaterialProperty::of_path(path) {
            Some(property) => (Target::Material(number, property), property.width),
            None => {
                let (key, property, width) = texture_property(path)?;
                (Target::Texture(number, key, property), width)
            }
        },
        _ => return None,
    })
}

/// Reads the keys of a sampler, of `width` numbers each; 0 stands for any.
fn keys(
    document: &Document<'_>,
    sampler: &Value,
    width: usize,
    times: &mut HashMap<usize, Arc<[f32]>>,
) -> Result<Keys, GltfProblem> {
    let accessor =
        |key: &str| index(sampler, key).ok_or_else(|| GltfProblem::broken(format!("its sampler has no {key}")));
    let (input, output) = (accessor("input")?, accessor("output")?);
    let interp = match sampler.get("interpolation").and_then(Value::as_str) {
        None | Some("LINEAR") => KeyInterp::Linear,
        Some("STEP") => KeyInterp::Step,
        Some("CUBICSPLINE") => KeyInterp::CubicSpline,
        Some(other) => {
            let other = one_line(other, 40);
            return Err(GltfProblem::broken(format!("the interpolation {other} is unknown")));
        }
    };
    let times = match times.get(&input) {
        Some(known) => Arc::clone(known),
        None => {
            let read: Arc<[f32]> = document.numbers(input, 1)?.into();
            times.insert(input, Arc::clone(&read));
            read
        }
    };
    let numbers = document.numbers(output, width.max(1))?;
    let width = match width {
        // A key holds one number for each weight.
        0 => {
            let parts = if interp == KeyInterp::CubicSpline { 3 } else { 1 };
            numbers.len() / (parts * times.len().max(1))
        }
        width => width,
    };
    if width == 0 {
        return Err(GltfProblem::broken("it has no numbers"));
    }
    Keys::new(times, numbers, width, interp).map_err(GltfProblem::broken)
}

/// The length of an animation and the number of things that it moves.
fn summary(document: &Document<'_>, animation: &Value, name: String, ends: &mut HashMap<usize, f32>) -> ModelClip {
    let (mut length, mut moved) = (0.0_f32, BTreeSet::new());
    for RawChannel { pointer, sampler } in channels(animation) {
        if let Some(input) = sampler.and_then(|sampler| index(sampler, "input")) {
            let read = || document.range(input).map_or(f32::NAN, |(_, end)| end);
            let end = *ends.entry(input).or_insert_with(read);
            length = if end.is_nan() || length.is_nan() {
                f32::NAN
            } else {
                length.max(end)
            };
        }
        let thing = match pointer.trim_start_matches('/').split('/').collect::<Vec<_>>()[..] {
            ["nodes", node, "translation" | "rotation" | "scale"] => ("node", node.to_owned()),
            ["nodes" | "meshes", number, "weights"] => ("morphing node", number.to_owned()),
            ["materials", number, ..] => ("material", number.to_owned()),
            ["cameras", number, ..] => ("camera", number.to_owned()),
            ["extensions", "KHR_lights_punctual", "lights", number, ..] => ("light", number.to_owned()),
            _ => ("other value", pointer.clone()),
        };
        moved.insert(thing);
    }
    let sorts: BTreeSet<&'static str> = sorting::ordered(moved.iter().map(|(sort, _)| *sort));
    let count = |sort: &'static str| (sort, moved.iter().filter(|(other, _)| *other == sort).count());
    ModelClip {
        name,
        length,
        moves: sorts.into_iter().map(count).collect(),
    }
}

/// The materials of the document that the played animations change.
pub(super) fn materials(played: &[Played]) -> BTreeSet<usize> {
    let channels = played.iter().flat_map(|clip| &clip.channels);
    let material = |channel: &PlayedChannel| match channel.moved {
        Target::Material(material, _) => Some(material),
        _ => None,
    };
    sorting::ordered(channels.filter_map(material))
}

/// The textures whose transforms the played animations change, by the material of the document and the key of its reference.
pub(super) fn textures(played: &[Played]) -> HashSet<(usize, &'static str)> {
    let channels = played.iter().flat_map(|clip| &clip.channels);
    let texture = |channel: &PlayedChannel| match channel.moved {
        Target::Texture(material, key, _) => Some((material, key)),
        _ => None,
    };
    channels.filter_map(texture).collect()
}

/// Checks that the numbers of nodes, meshes and materials in a played animation exist.
pub(super) fn check(document: &Document<'_>, played: &[Played]) -> Result<(), GltfProblem> {
    let root = &document.root;
    for channel in played.iter().flat_map(|clip| &clip.channels) {
        match channel.moved {
            Target::Translation(node) | Target::Rotation(node) | Target::Scale(node) | Target::NodeWeights(node) => {
                get(&root.nodes, node, "node").map(|_| ())
            }
            Target::MeshWeights(mesh) => get(&root.meshes, mesh, "mesh").map(|_| ()),
            Target::Material(material, _) | Target::Texture(material, ..) => {
                get(&root.materials, material, "material").map(|_| ())
            }
            Target::Camera(camera, _) => get(&root.cameras, camera, "camera").map(|_| ()),
            // Lights are in an extension; those that no node carries are not shown.
            Target::Light(..) => Ok(()),
        }?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
