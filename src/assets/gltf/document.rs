//! A glTF document: its JSON, its buffers, and access by indices.

use std::{
    cell::{Cell, OnceCell},
    path::Path,
    sync::Arc,
};

use ::gltf::json::{
    self, Root, Value, deserialize,
    mesh::{Primitive, Semantic},
    validation::{Checked, Validate},
};

use super::{
    container::{self, Container, Location},
    error::GltfProblem,
    fault_place, features,
};
use crate::assets::Files;

/// The limit of all arrays together for each byte of the file, and the limit for any file: repeated accessors of a small
/// file must not fill the memory.
const BUDGET_PER_BYTE: u64 = 64;
const MIN_BUDGET: u64 = 256 << 20;

/// An open document.
pub(super) struct Document<'a> {
    pub root: Root,
    /// The whole JSON, with all extensions.
    pub raw: Value,
    /// The numbers of scenes whose nodes are an empty array.
    pub empty_scenes: Vec<usize>,
    /// Faults of the document's container.
    pub container_faults: Vec<&'static str>,
    pub folder: &'a Path,
    pub files: &'a Files,
    binary: Option<&'a [u8]>,
    buffers: Vec<OnceCell<Arc<[u8]>>>,
    budget: Cell<u64>,
}

impl<'a> Document<'a> {
    pub fn open(bytes: &'a [u8], folder: &'a Path, files: &'a Files) -> Result<Self, GltfProblem> {
        let Container { json, binary, faults } = Container::open(bytes)?;
        match json.trim_ascii().first() {
            Some(b'{') => {}
            None => return Err(GltfProblem::broken("the file is empty")),
            Some(_) => {
                return Err(GltfProblem::broken(
                    "it begins neither with the header of GLB nor with a JSON object",
                ));
            }
        }
        let syntax = |e: json::Error| GltfProblem::broken(format!("its JSON is not understood: {e}"));
        let mut raw: Value = deserialize::from_slice(json).map_err(syntax)?;
        check_version(&raw)?;
        check_extensions(&raw)?;
        let scenes = raw.get("scenes").and_then(Value::as_array);
        let has_empty_nodes = |scene: &Value| scene.get("nodes").and_then(Value::as_array).is_some_and(Vec::is_empty);
        let empty_scenes = scenes.into_iter().flatten().enumerate();
        let empty_scenes = empty_scenes
            .filter(|(_, s)| has_empty_nodes(s))
            .map(|(i, _)| i)
            .collect();
        normalize(&mut raw);
        let root = fault_place::read(&without_free_channels(raw.clone()));
        let root = root.map_err(|fault| GltfProblem::broken(format!("its JSON is not understood: {fault}")))?;
        check_indices(&root)?;
        let buffers = root.buffers.iter().map(|_| OnceCell::new()).collect();
        Ok(Self {
            root,
            raw,
            empty_scenes,
            container_faults: faults,
            folder,
            files,
            binary,
            buffers,
            budget: Cell::new(MIN_BUDGET + BUDGET_PER_BYTE * bytes.len() as u64),
        })
    }

    /// Reserves bytes for arrays.
    pub fn reserve(&self, bytes: u64) -> Result<(), GltfProblem> {
        let left = self.budget.get().checked_sub(bytes);
        self.budget
            .set(left.ok_or_else(|| GltfProblem::broken("its arrays are far larger than the file"))?);
        Ok(())
    }

    fn buffer(&self, index: usize) -> Result<&[u8], GltfProblem> {
        let buffer = get(&self.root.buffers, index, "buffer")?;
        let bytes = match &buffer.uri {
            None if index == 0 => self
                .binary
                .ok_or_else(|| GltfProblem::broken("buffer 0 has no uri, and there is no binary chunk"))?,
            None => return Err(GltfProblem::broken(format!("buffer {index} has no uri"))),
            Some(uri) => {
                let cell = &self.buffers[index];
                if cell.get().is_none() {
                    let bytes = match container::locate(self.folder, uri, self.files)? {
                        Location::Here(bytes) => bytes.into(),
                        Location::File(path) => container::read(&path, self.files)?,
                    };
                    self.budget
                        .set(self.budget.get().saturating_add(BUDGET_PER_BYTE * bytes.len() as u64));
                    let _ = cell.set(bytes);
                }
                cell.get().expect("it was just set")
            }
        };
        let length = usize::try_from(buffer.byte_length.0).unwrap_or(usize::MAX);
        bytes.get(..length).ok_or_else(|| {
            let found = bytes.len();
            GltfProblem::broken(format!("buffer {index} should have {length} bytes, but has {found}"))
        })
    }

    /// The bytes of a view, and its stride.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), GltfProblem> {
        let view = get(&self.root.buffer_views, index, "buffer view")?;
        let buffer = self.buffer(view.buffer.value())?;
        let start = view.byte_offset.map_or(0, |o| o.0);
        let end = start.checked_add(view.byte_length.0);
        let range = end.and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
        let bytes = range.and_then(|r| buffer.get(r)).ok_or_else(|| {
            GltfProblem::broken(format!(
                "buffer view {index} reaches past the end of buffer {}",
                view.buffer.value()
            ))
        })?;
        Ok((bytes, view.byte_stride.map(|s| s.0)))
    }
}

/// Element `index` of an array of the document.
pub(super) fn get<'a, T>(array: &'a [T], index: usize, what: &str) -> Result<&'a T, GltfProblem> {
    let count = array.len();
    array
        .get(index)
        .ok_or_else(|| GltfProblem::broken(format!("there is no {what} {index}, there are {count}")))
}

/// Refuses invalid indices anywhere in the document. Other findings of the crate's check are ignored: many are harmless, some
/// are valid.
fn check_indices(root: &Root) -> Result<(), GltfProblem> {
    let mut wrong = None;
    for (i, mesh) in root.meshes.iter().enumerate() {
        // The crate does not check this index.
        let positions = |p: &Primitive| p.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
        let is_wrong = |p: &Primitive| positions(p).is_some_and(|a| a.value() >= root.accessors.len());
        if let Some(k) = mesh.primitives.iter().position(is_wrong) {
            let path = format!("meshes[{i}].primitives[{k}].attributes[\"POSITION\"]");
            return Err(nothing(&path));
        }
    }
    root.validate(root, json::Path::new, &mut |path, error| {
        if error == json::validation::Error::IndexOutOfBounds {
            wrong.get_or_insert_with(|| path().to_string());
        }
    });
    wrong.map_or(Ok(()), |path| Err(nothing(&path)))
}

fn nothing(path: &str) -> GltfProblem {
    GltfProblem::broken(format!("{path} names something that is not there"))
}

fn check_version(raw: &Value) -> Result<(), GltfProblem> {
    let text = |key: &str| raw.get("asset").and_then(|a| a.get(key)).and_then(Value::as_str);
    let version = text("version").ok_or_else(|| GltfProblem::broken("it has no asset.version"))?;
    let major = version.split('.').next().unwrap_or_default();
    if major != "2" {
        return Err(GltfProblem::unsupported(format!("version {version} of glTF")));
    }
    match text("minVersion") {
        Some(least) if least != "2.0" => Err(GltfProblem::unsupported(format!("version {least} of glTF"))),
        _ => Ok(()),
    }
}

/// Extensions that compress meshes, which other programs decode.
const COMPRESSIONS: [&str; 3] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];

fn check_extensions(raw: &Value) -> Result<(), GltfProblem> {
    let required = raw.get("extensionsRequired").and_then(Value::as_array);
    let unknown: Vec<&str> = required
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .filter(|name| features::treatment(name).is_none())
        .collect();
    if unknown.is_empty() {
        return Ok(());
    }
    let plural = if unknown.len() == 1 { "extension" } else { "extensions" };
    let remedy = match unknown.iter().any(|name| COMPRESSIONS.contains(name)) {
        true => " (decode it: `gltf-transform copy in.glb out.glb`, or import and export it in Blender)",
        false => "",
    };
    Err(GltfProblem::unsupported(format!(
        "it requires the {plural} {}{remedy}",
        unknown.join(", ")
    )))
}

/// Removes animation channels without a node, whose target an extension names: the parser requires a node.
fn without_free_channels(mut raw: Value) -> Value {
    let animations = raw.get_mut("animations").and_then(Value::as_array_mut);
    for channels in animations.into_iter().flatten().filter_map(|a| a.get_mut("channels")) {
        if let Some(channels) = channels.as_array_mut() {
            channels.retain(|channel| channel.get("target").is_none_or(|t| t.get("node").is_some()));
        }
    }
    raw
}

/// Changes valid JSON that the parser does not accept: integers written as `1.0`, and scenes without nodes.
fn normalize(value: &mut Value) {
    if let Some(scenes) = value.get_mut("scenes").and_then(Value::as_array_mut) {
        for scene in scenes.iter_mut().filter_map(Value::as_object_mut) {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    whole_numbers(value);
}

/// Recursion ends: the JSON reader accepts 128 levels at the most.
fn whole_numbers(value: &mut Value) {
    match value {
        Value::Number(n) if n.is_f64() => {
            let whole = n.as_f64().filter(|v| v.fract() == 0.0 && v.abs() < 9e15);
            if let Some(v) = whole {
                *value = if v >= 0.0 { (v as u64).into() } else { (v as i64).into() };
            }
        }
        Value::Array(values) => values.iter_mut().for_each(whole_numbers),
        Value::Object(map) => map.values_mut().for_each(whole_numbers),
        _ => {}
    }
}
