//! Models that play animations.

use super::*;
use crate::assets::gltf::samples::glb;

const TRIANGLE: [f32; 9] = [-0.5, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0, 0.2];
const NORMALS: [f32; 9] = [0.0, 0.0, 1.0, 0.2, 0.0, 1.0, 0.0, 0.1, 1.0];
const TANGENTS: [f32; 12] = [1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, -1.0];
const JOINTS: [f32; 12] = [0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
const WEIGHTS: [f32; 12] = [0.9, 0.1, 0.0, 0.0, 0.4, 0.6, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
const MOVES: [f32; 9] = [0.0, 0.0, 0.0, 0.6, 0.9, 0.0, -0.4, 0.3, 0.5];
const TURNS: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.6, 0.0, 0.8, 0.0, 0.0, 1.0, 0.2];

/// A model whose nodes are a lamp, a thing with a child of the same mesh, a skin with its bones, a morph, and a light.
pub(super) fn model(animation: &str) -> Vec<u8> {
    let scales = |middle: f32| [[1.0; 3], [middle; 3], [1.5, 1.0, 1.0]].concat();
    let (vanishing, mirrored) = (scales(0.0), [[1.0; 3], [-1.0, 1.0, 1.0], [1.0; 3]].concat());
    let arrays: [(usize, &[f32]); 15] = [
        (3, &TRIANGLE),
        (3, &NORMALS),
        (4, &TANGENTS),
        (4, &JOINTS),
        (4, &WEIGHTS),
        (1, &[0.0, 1.0, 3.0]),
        (3, &MOVES),
        (4, &TURNS),
        (1, &[0.0, 1.0, 0.3]),
        (3, &vanishing),
        (3, &mirrored),
        (3, &[0.1, 0.2, 0.9, 0.9, 0.3, 0.1, 0.0, 0.0, 0.0]),
        (2, &[0.0, 0.0, 1.0, 0.0, 0.5, 1.0]),
        (2, &[0.0, 0.0, 0.4, 0.7, 2.0, 3.0]),
        (1, &[0.0, 1.0, -2.0]),
    ];
    let rest = r#""extensionsUsed": ["KHR_lights_punctual", "KHR_animation_pointer"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 20}]}},
        "images": [{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAFklEQVR42mP4L8cg8kuDQc7mw68PIgAjvQWcELqerwAAAABJRU5ErkJggg=="}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1],
                "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 1]}}},
                "metallicRoughnessTexture": {"index": 0}}},
            {"emissiveFactor": [3, 3, 2], "emissiveTexture": {"index": 0}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 12}, "material": 0}]},
            {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 12}, "material": 1}]},
            {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2, "JOINTS_0": 3, "WEIGHTS_0": 4}, "material": 0}]},
            {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "targets": [{"POSITION": 1, "NORMAL": 0}], "material": 0}]}],
        "nodes": [{"name": "lamp", "mesh": 1, "translation": [1, 1.5, 0]},
            {"name": "thing", "mesh": 0, "children": [2]},
            {"name": "child", "mesh": 0, "translation": [0.8, 0.2, 0], "scale": [0.5, 0.5, 0.5]},
            {"name": "skin", "mesh": 2, "skin": 0}, {"name": "bone", "children": [5]}, {"name": "tip"},
            {"name": "morph", "mesh": 3, "translation": [-1.5, 0, 0]},
            {"name": "bulb", "translation": [0, 2, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"name": "still", "mesh": 0, "translation": [-1, 1, -1]}],
        "skins": [{"joints": [4, 5]}]"#;
    glb(&arrays, &format!(r#"{rest}, "animations": [{animation}]"#))
}

/// An animation of these targets by these accessors.
pub(super) fn animation(channels: &[(&str, usize)]) -> String {
    let channel = |(i, (pointer, _)): (usize, &(&str, usize))| {
        let parts: Vec<&str> = pointer.split('/').collect();
        match parts[..] {
            ["", "nodes", node, path] => {
                format!(r#"{{"sampler": {i}, "target": {{"node": {node}, "path": "{path}"}}}}"#)
            }
            _ => format!(
                r#"{{"sampler": {i}, "target": {{"path": "pointer", "extensions": {{"KHR_animation_pointer":
                {{"pointer": "{pointer}"}}}}}}}}"#
            ),
        }
    };
    let sampler = |(_, output): &(&str, usize)| format!(r#"{{"input": 5, "output": {output}}}"#);
    let channels_text: Vec<String> = channels.iter().enumerate().map(channel).collect();
    let samplers: Vec<String> = channels.iter().map(sampler).collect();
    format!(
        r#"{{"channels": [{}], "samplers": [{}]}}"#,
        channels_text.join(","),
        samplers.join(",")
    )
}

fn open(channels: &[(&str, usize)], table: Option<&str>) -> (tempfile::TempDir, Job) {
    let folder = folder(table.unwrap_or("frame\n1\n"));
    let scene = format!(
        "{SCENE}[[object]]\nname = \"figure\"\ntransform = {{ translate = [0, 0.3, 1], rotate = [0, 10, 0] }}\n\
        shape.mesh = {{ file = \"figure.glb\", animation = \"all\", lights = true }}\n\
        [[object]]\nname = \"late\"\n\
        shape.mesh = {{ file = \"figure.glb\", animation = \"all\", start = 0.25, speed = 2, repeat = true, lights = false }}\n"
    );
    fs::write(folder.path().join("s.toml"), scene).expect("written");
    fs::write(folder.path().join("figure.glb"), model(&animation(channels))).expect("written");
    let request = Request {
        values: table.map(|_| folder.path().join("v.csv")),
        fps: Some(10.0),
        ..Request::default()
    };
    let job = Job::open(&folder.path().join("s.toml"), &request).unwrap_or_else(|e| panic!("{e}"));
    (folder, job)
}

/// Renders frames by moving the scene of the frame before and by compiling each alone.
fn both_ways(channels: &[(&str, usize)], table: Option<&str>) {
    let (_folder, job) = open(channels, table);
    let compiled = || job.compile().expect("a scene");
    let (mut moved, mut anew) = (job.scenes(compiled()), job.scenes(compiled()));
    let mut pictures = Vec::new();
    for frame in [1.0, 10.0, 4.5, 0.0, 10.0, 22.0, 500.0] {
        let found = picture(&job, moved.seek(frame).expect("a scene"));
        anew.recover();
        let expected = picture(&job, anew.seek(frame).expect("a scene"));
        assert!(found == expected, "frame {frame} of {channels:?}");
        pictures.push(found);
    }
    assert!(
        pictures[0] != pictures[2] && pictures[2] != pictures[4],
        "nothing moves: {channels:?}"
    );
    assert!(
        pictures[1] == pictures[4],
        "a frame depends on those before it: {channels:?}"
    );
}

#[test]
fn a_model_that_is_moved_equals_one_that_is_compiled_for_its_time() {
    for (pointer, output) in [
        ("/nodes/1/translation", 6),
        ("/nodes/1/rotation", 7),
        ("/nodes/1/scale", 9),
        ("/nodes/2/scale", 10),
        ("/nodes/4/rotation", 7),
        ("/nodes/4/scale", 9),
        ("/nodes/6/weights", 8),
        ("/nodes/0/translation", 6),
        ("/nodes/0/scale", 10),
        ("/nodes/7/translation", 6),
        ("/materials/0/roughnessFactor", 8),
        ("/materials/1/emissiveFactor", 11),
        ("/materials/0/base/offset", 13),
        ("/materials/0/base/rotation", 14),
        ("/materials/0/base/scale", 13),
        (
            "/materials/1/emissiveTexture/extensions/KHR_texture_transform/offset",
            13,
        ),
        ("/extensions/KHR_lights_punctual/lights/0/color", 11),
    ] {
        let pointer = pointer.replace("/0/rough", "/0/pbrMetallicRoughness/rough");
        let base = "pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/";
        let pointer = pointer.replace("base/", base);
        both_ways(&[(&pointer, output)], None);
    }
}

#[test]
fn what_moves_is_updated_and_what_has_no_inverse_is_compiled() {
    for (pointer, output, expected) in [
        ("/nodes/0/translation", 6, true),
        ("/nodes/1/rotation", 7, true),
        ("/nodes/4/scale", 9, true),
        ("/nodes/6/weights", 8, true),
        ("/nodes/7/translation", 6, true),
        ("/extensions/KHR_lights_punctual/lights/0/intensity", 8, false),
        ("/nodes/1/scale", 9, false),
    ] {
        let (_folder, job) = open(&[(pointer, output)], None);
        let mut scenes = job.scenes(job.compile().expect("a scene"));
        let moving = scenes.moving.as_mut().expect("it moves");
        // At 1 s the scale is 0, at 0 s the intensity.
        moving.options.time = if pointer.ends_with("intensity") { 0.0 } else { 1.0 };
        assert_eq!(
            moving.play(Arc::get_mut(&mut scenes.scene).expect("nobody else has it")),
            expected,
            "{pointer}"
        );
    }
}

#[test]
fn all_at_once_with_a_table_of_values_equals_the_scene_of_the_time() {
    let channels = [
        ("/nodes/0/translation", 6),
        ("/nodes/1/rotation", 7),
        ("/nodes/2/translation", 6),
        ("/nodes/5/translation", 6),
        ("/nodes/6/weights", 8),
        ("/nodes/7/translation", 6),
    ];
    both_ways(&channels, Some("frame,object.figure.transform.rotate.y\n0,0\n20,90\n"));
    both_ways(
        &channels,
        Some("frame,material.red.matte.albedo.g,object.late.visible\n0,0,1\n9,1,0\n"),
    );
}

#[test]
fn the_time_of_a_frame_is_its_number_over_the_frame_rate() {
    let (_folder, job) = open(&[("/nodes/1/translation", 6)], None);
    let mut scenes = job.scenes(job.compile().expect("a scene"));
    let places = |scene: &Scene| {
        let geometry = scene.geometry.accel.geometry();
        geometry
            .instance_transforms()
            .map(|t| t.widened().translation)
            .collect::<Vec<_>>()
    };
    let (at_rest, at_key) = (
        places(scenes.seek(0.0).expect("a scene")),
        places(scenes.seek(10.0).expect("a scene")),
    );
    let held = places(scenes.seek(999.0).expect("a scene"));
    let moved: Vec<f64> = at_rest.iter().zip(&at_key).map(|(a, b)| a.distance(*b)).collect();
    let far = (0.6_f64 * 0.6 + 0.9 * 0.9).sqrt();
    assert!(moved.iter().any(|d| (d - far).abs() < 1e-6), "{moved:?}");
    assert!(held != at_key && job.plan.frames.len() == 1);
}
