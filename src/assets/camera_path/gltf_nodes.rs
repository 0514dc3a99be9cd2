//! Cameras of glTF files (`.gltf`, `.glb`).
//!
//! A camera looks along the -z of its node with +y up, in metres; `yfov` is the angle over the picture's height, in radians. Its
//! `aspectRatio` and its clipping planes are not read. If an animation moves a camera, the first of those that move is the
//! camera of the frames from 0 to the last key, at the frame rate. Otherwise each node with a camera is a frame: its
//! `extras.frame`, or as that of COLMAP's pictures from the names of nodes, in the order of the scene. The numbers of such a
//! file are read in double precision.
//!
//! Source: Khronos, "glTF 2.0 Specification", sections 3.5 and 3.10.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use serde_json::{Value, json};

use super::{
    CameraPathFormat, PathProblem, PathProblems,
    held::{Holds, POSES, Target, Written},
    keys::{self, Frames, Posed},
    source::{Source, text},
    still::Still,
};
use crate::{
    assets::{
        load_model::{ModelRequest, load_model},
        model::{ModelCamera, ModelView},
        motion::ModelEdits,
    },
    camera::{
        lens::FieldOfView,
        path::{CameraPath, MAX_FRAME},
    },
    shape::mesh::{AnimationChoice, Playback},
    value::one_line,
    warnings::WarningKind,
};

/// The frames of a second, if nothing says it: those of Blender.
const FPS: f64 = 24.0;

/// The most frames of an animation.
const MOST_FRAMES: f64 = 1e6;

pub(super) const FORMAT: CameraPathFormat = CameraPathFormat {
    name: "gltf",
    extensions: &["gltf", "glb"],
    names: &[],
    read,
    holds: Holds {
        names: true,
        view: true,
        ..POSES
    },
    write,
};

fn read(source: &Source<'_>) -> Result<CameraPath, PathProblems> {
    let json = text(json_of(source.bytes)?)?;
    let root: Value = serde_json::from_str(json).map_err(|error| {
        let message = error.to_string();
        PathProblem::of_line(error.line(), message.split(" at line ").next().unwrap_or_default())
    })?;
    if root
        .get("animations")
        .is_some_and(|animations| animations.as_array().is_some_and(|a| !a.is_empty()))
        && let Some(path) = animated(source)?
    {
        return Ok(path);
    }
    let found = Nodes { root: &root }.cameras().map_err(PathProblem::of_file)?;
    if found.is_empty() {
        return Err(PathProblem::of_file("the scene has no node with a camera").into());
    }
    let own: Option<Vec<i64>> = found.iter().map(|(frame, _)| *frame).collect();
    let names = found.iter().map(|(_, posed)| posed.name.as_deref());
    let frames = own.unwrap_or_else(|| keys::picture_frames(names));
    let posed = found.into_iter().map(|(_, posed)| posed);
    keys::path(
        frames.into_iter().map(|frame| frame as f64).zip(posed),
        Frames::Pictures,
    )
}

/// The JSON of a file: of a GLB, its first chunk.
fn json_of(bytes: &[u8]) -> Result<&[u8], PathProblem> {
    if !bytes.starts_with(b"glTF") {
        return Ok(bytes);
    }
    let word = |at: usize| bytes.get(at..at + 4).and_then(|word| <[u8; 4]>::try_from(word).ok());
    let length = word(12).map(u32::from_le_bytes);
    let chunk = length.and_then(|length| bytes.get(20..)?.get(..length as usize));
    let chunk = chunk.filter(|_| word(16) == Some(*b"JSON"));
    let chunk = chunk.ok_or_else(|| PathProblem::of_file("the GLB has no whole JSON chunk"))?;
    // Some exporters pad with zeros.
    let zeros = chunk.iter().rev().take_while(|byte| **byte == 0).count();
    Ok(&chunk[..chunk.len() - zeros])
}

/// The path of the first camera that an animation moves, if one does.
fn animated(source: &Source<'_>) -> Result<Option<CameraPath>, PathProblems> {
    let mut request = ModelRequest::from(source.path);
    request.choice.animation = Some(AnimationChoice::All);
    let model = load_model(&request, source.files).map_err(|error| PathProblem::of_file(error.to_string()))?;
    let Some(motion) = &model.motion else { return Ok(None) };
    let mut moving = (0..model.cameras.len()).filter(|camera| motion.moves_camera(*camera));
    let Some(camera) = moving.next() else { return Ok(None) };
    if moving.next().is_some() {
        let (name, path) = (one_line(&model.cameras[camera].name, 80), source.path.display());
        let text = format!("several cameras move, the path is that of the first, `{name}`: {path}");
        source.files.warnings().add(WarningKind::CHOICE, path, text);
    }
    let fps = source.options.fps.unwrap_or(FPS);
    let last = (f64::from(motion.end()) * fps).ceil();
    if last.is_nan() || last > MOST_FRAMES {
        return Err(PathProblem::of_file("the animation is too long").into());
    }
    let (playback, edits) = (Playback::default(), ModelEdits::default());
    let frames = (0..=last as u32).map(f64::from);
    let posed = frames.map(|frame| {
        let pose = motion.pose(&playback, &edits, frame / fps);
        let ModelCamera {
            model_from_camera,
            view,
            ..
        } = &pose.cameras[camera];
        let posed = posed(model_from_camera, *view)?;
        Ok((frame, posed))
    });
    let posed = posed
        .collect::<Result<Vec<_>, String>>()
        .map_err(PathProblem::of_file)?;
    keys::path(posed, Frames::Way).map(Some)
}

fn posed(place: &DAffine3, view: ModelView) -> Result<Posed, String> {
    let ModelView::Perspective { fov } = view else {
        return Err("an orthographic camera has no place in a camera path".to_owned());
    };
    let (back, up) = (place.matrix3.z_axis.normalize_or_zero(), place.matrix3.y_axis);
    let right = up.cross(back).normalize_or_zero();
    let axes = DMat3::from_cols(right, back.cross(right), back);
    if !keys::is_place(place.translation) {
        return Err("a number of its transform is not finite or too large".to_owned());
    }
    let mut posed = Posed::new(place.translation, keys::rotation(&axes)?);
    posed.lens.view = Some(FieldOfView::Vertical(fov.to_degrees()));
    Ok(posed)
}

/// The nodes of a document.
struct Nodes<'a> {
    root: &'a Value,
}

impl<'a> Nodes<'a> {
    fn item(&self, list: &str, index: &Value) -> Option<&'a Value> {
        self.root.get(list)?.get(usize::try_from(index.as_u64()?).ok()?)
    }

    /// The nodes of the scene that have a camera, each with its own number of a frame.
    fn cameras(&self) -> Result<Vec<(Option<i64>, Posed)>, String> {
        let nodes = self.root.get("nodes").and_then(Value::as_array).map_or(0, Vec::len);
        let scene = self.root.get("scene").cloned().unwrap_or(Value::from(0));
        let roots = match self.item("scenes", &scene) {
            Some(scene) => scene
                .get("nodes")
                .and_then(Value::as_array)
                .cloned()
                .unwrap_or_default(),
            None => (0..nodes).map(Value::from).collect(),
        };
        let mut open: Vec<(Value, DAffine3)> = roots.into_iter().rev().map(|node| (node, DAffine3::IDENTITY)).collect();
        let (mut found, mut visited) = (Vec::new(), 0);
        while let Some((index, parent)) = open.pop() {
            let node = self.item("nodes", &index);
            let node = node.ok_or_else(|| format!("there is no node {}", one_line(&index.to_string(), 80)))?;
            visited += 1;
            if visited > nodes {
                return Err("a node has two parents, or is its own ancestor".to_owned());
            }
            let of_node = |message: String| format!("node {index}: {message}");
            let place = parent * local(node).map_err(of_node)?;
            if let Some(camera) = node.get("camera") {
                let camera = self.item("cameras", camera);
                let camera = camera.ok_or_else(|| of_node("there is no such camera".to_owned()))?;
                found.push(self.camera(node, camera, &place).map_err(of_node)?);
            }
            let children = node.get("children").and_then(Value::as_array);
            open.extend(children.into_iter().flatten().rev().map(|child| (child.clone(), place)));
        }
        Ok(found)
    }

    fn camera(&self, node: &Value, camera: &Value, place: &DAffine3) -> Result<(Option<i64>, Posed), String> {
        let view = match camera.get("perspective").and_then(|view| view.get("yfov")) {
            Some(yfov) => match yfov.as_f64().filter(|fov| *fov > 0.0 && *fov < PI) {
                Some(fov) => ModelView::Perspective { fov },
                None => {
                    return Err(format!(
                        "`yfov` is {}, expected an angle above 0 and below pi",
                        one_line(&yfov.to_string(), 80)
                    ));
                }
            },
            None if camera.get("orthographic").is_some() => ModelView::Orthographic { height: 1.0 },
            None => return Err("the camera has no `perspective.yfov`".to_owned()),
        };
        let mut posed = posed(place, view)?;
        let name = node.get("name").or(camera.get("name")).and_then(Value::as_str);
        posed.name = name.map(str::to_owned);
        let frame = node.get("extras").and_then(|extras| extras.get("frame")?.as_i64());
        Ok((frame.filter(|frame| (-MAX_FRAME..=MAX_FRAME).contains(frame)), posed))
    }
}

/// The transform of a node.
fn local(node: &Value) -> Result<DAffine3, String> {
    if let Some(matrix) = numbers::<16>(node, "matrix")? {
        return Ok(DAffine3::from_mat4(DMat4::from_cols_array(&matrix)));
    }
    let translation = numbers(node, "translation")?.unwrap_or_default();
    let rotation = numbers(node, "rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = numbers(node, "scale")?.unwrap_or([1.0; 3]);
    Ok(DAffine3::from_scale_rotation_translation(
        DVec3::from_array(scale),
        keys::unit_quaternion(rotation).map(DQuat::normalize)?,
        DVec3::from_array(translation),
    ))
}

/// The list of `N` numbers under a key, if there is one.
fn numbers<const N: usize>(node: &Value, key: &str) -> Result<Option<[f64; N]>, String> {
    let Some(value) = node.get(key) else { return Ok(None) };
    let list: Option<Vec<f64>> = value
        .as_array()
        .and_then(|list| list.iter().map(Value::as_f64).collect());
    let list = list.and_then(|list| <[f64; N]>::try_from(list).ok());
    list.map(Some)
        .ok_or_else(|| format!("`{key}` is not a list of {N} numbers"))
}

/// A node with a camera for every frame, at rest, with its number in `extras`.
fn write(target: &Target<'_>, cameras: &[Still]) -> Written {
    let (mut views, mut nodes) = (Vec::<(f64, Option<f64>)>::new(), Vec::new());
    for camera in cameras {
        let size = camera.pixels.and_then(|lens| lens.size);
        let view = (
            camera.view("gltf")?.to_radians(),
            size.map(|[width, height]| width / height),
        );
        let index = views.iter().position(|other| *other == view).unwrap_or_else(|| {
            views.push(view);
            views.len() - 1
        });
        let name = camera
            .name
            .clone()
            .unwrap_or_else(|| format!("camera.{:04}", camera.frame));
        nodes.push(json!({
            "name": name,
            "camera": index,
            "translation": camera.eye.to_array(),
            "rotation": DQuat::from_mat3(&camera.axes).to_array(),
            "extras": { "frame": camera.frame },
        }));
    }
    let views = views.into_iter().map(|(fov, aspect)| {
        let mut perspective = json!({ "yfov": fov, "znear": 0.01 });
        if let Some(aspect) = aspect {
            perspective["aspectRatio"] = aspect.into();
        }
        json!({ "type": "perspective", "perspective": perspective })
    });
    let scene: Vec<usize> = (0..nodes.len()).collect();
    let root = json!({
        "asset": { "version": "2.0", "generator": "batch-render" },
        "scene": 0,
        "scenes": [{ "nodes": scene }],
        "cameras": views.collect::<Vec<_>>(),
        "nodes": nodes,
    });
    let text = serde_json::to_string_pretty(&root).expect("numbers and texts are JSON") + "\n";
    if target
        .path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("glb"))
    {
        return target.file(glb(text));
    }
    target.file(text)
}

/// A GLB of this JSON.
fn glb(mut json: String) -> Vec<u8> {
    let padding = json.len().next_multiple_of(4) - json.len();
    json.extend(std::iter::repeat_n(' ', padding));
    let length = json.len() as u32;
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((length + 20).to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.into_bytes());
    bytes
}
