use std::path::Path;

use glam::{DAffine3, DVec3};

use crate::{
    assets::{
        Files,
        gltf::{parse, samples::glb},
        model::{AnimationChoice, Model, ModelChoice, ModelFeature, ModelLightKind, ModelView},
        motion::ModelEdits,
    },
    math::{Rgb, Vec2, Vec3},
    shape::mesh::Playback,
    texture::{Color, Scalar, StTransform},
};

fn load(bytes: &[u8], names: &[&str]) -> Result<Model, String> {
    let names = names.iter().map(|name| (*name).to_owned()).collect();
    let choice = ModelChoice {
        animation: Some(AnimationChoice::Named(names)),
        ..ModelChoice::default()
    };
    parse(bytes, Path::new("a.glb"), &choice, &Files::default()).map_err(|e| e.to_string())
}

fn at(model: &Model, time: f64) -> Model {
    model.posed(
        model
            .pose(&Playback::default(), &ModelEdits::default(), time)
            .expect("it is animated"),
    )
}

const TRIANGLE: (usize, &[f32]) = (3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
const TIMES: (usize, &[f32]) = (1, &[1.0, 3.0]);
const MOVES: (usize, &[f32]) = (3, &[0.0, 0.0, 0.0, 4.0, 0.0, -2.0]);
const MESH: &str = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]"#;

/// A parent with a turned child that carries a triangle, and a triangle that stands still.
const NODES: &str = r#""nodes": [{"name": "arm", "translation": [9, 9, 9], "children": [1]},
    {"name": "hand", "mesh": 0, "rotation": [0, 0, 1, 0], "translation": [0, 1, 0]}, {"mesh": 0}]"#;

/// An animation of a property of node 0 by accessors 1 and 2.
fn animation(name: &str, path: &str) -> String {
    format!(
        r#"{{{name} "channels": [{{"sampler": 0, "target": {{"node": 0, "path": "{path}"}}}}],
        "samplers": [{{"input": 1, "output": 2}}]}}"#
    )
}

#[test]
fn a_child_of_a_moving_node_moves_with_it_and_keeps_its_own_transform() {
    let rest = format!(
        r#"{MESH}, {NODES}, "animations": [{}]"#,
        animation(r#""name": "Go","#, "translation")
    );
    let model = load(&glb(&[TRIANGLE, TIMES, MOVES], &rest), &["Go"]).unwrap();
    assert_eq!(
        (model.clips[0].length, &model.clips[0].moves[..]),
        (3.0, &[("node", 1)][..])
    );
    for (time, x) in [(0.0, 0.0), (1.0, 0.0), (1.5, 1.0), (3.0, 4.0), (1e9, 4.0)] {
        let posed = at(&model, time);
        let corner = posed.instances[0].model_from_mesh.transform_point3(DVec3::X);
        assert!(
            (corner - DVec3::new(x - 1.0, 1.0, -0.5 * x)).length() < 1e-12,
            "{time}: {corner}"
        );
        assert_eq!(posed.instances[1].model_from_mesh, DAffine3::IDENTITY);
    }
    let movers: Vec<bool> = model.movers().iter().map(Option::is_some).collect();
    assert_eq!(movers, [true, false]);
}

#[test]
fn animations_have_their_names_else_their_numbers_and_the_second_of_a_name_has_a_number_more() {
    let of = |name: &str| animation(name, "translation");
    let all = [
        of(r#""name": "Go","#),
        of(""),
        of(r#""name": "Go","#),
        of(r#""name": "Go#2","#),
    ]
    .join(",");
    let bytes = glb(
        &[TRIANGLE, TIMES, MOVES],
        &format!(r#"{MESH}, {NODES}, "animations": [{all}]"#),
    );
    let model = load(&bytes, &["1"]).unwrap();
    let names: Vec<&str> = model.clips.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(names, ["Go", "1", "Go#2", "Go#2#2"]);
    assert_eq!(
        load(&bytes, &["go"]).unwrap_err(),
        "unknown animation `go` (did you mean `Go`?): a.glb"
    );
    let none = load(&bytes, &[]).unwrap();
    assert!(none.motion.is_none() && none.features.iter().all(|f| f.loss().is_none()));
}

#[test]
fn two_animations_that_move_the_same_are_refused_and_others_are_played_together() {
    let [a, b, c] = [("A", "translation"), ("B", "scale"), ("C", "scale")]
        .map(|(name, path)| animation(&format!(r#""name": "{name}","#), path));
    let bytes = glb(
        &[TRIANGLE, TIMES, MOVES],
        &format!(r#"{MESH}, {NODES}, "animations": [{a}, {b}, {c}]"#),
    );
    assert_eq!(
        load(&bytes, &["A", "B", "C"]).unwrap_err(),
        "the animations `B` and `C` both move the scale of node 0 `arm`: a.glb"
    );
    let hand = at(&load(&bytes, &["B", "A"]).unwrap(), 9.0).instances[0].model_from_mesh;
    assert_eq!(hand.transform_point3(DVec3::ZERO), DVec3::new(4.0, 0.0, -2.0));
    assert_eq!(hand.transform_vector3(DVec3::X), DVec3::X * -4.0);
}

#[test]
fn broken_keys_are_refused_with_their_place() {
    let fault = |times: &[f32], moves: &[f32]| {
        let rest = format!(r#"{MESH}, {NODES}, "animations": [{}]"#, animation("", "translation"));
        let all = load(&glb(&[TRIANGLE, (1, times), (3, moves)], &rest), &["0"]);
        all.err().unwrap_or_default()
    };
    let place = "the translation of node 0 `arm` in the animation `0`";
    let of = |cause: &str| format!("broken model: {place}: {cause}: a.glb");
    let flat = [0.0; 6];
    assert_eq!(
        fault(&[2.0, 1.0], &flat),
        of("the time of key 1 is before that of the key before it")
    );
    assert_eq!(fault(&[0.0, f32::NAN], &flat), of("the time of key 1 is not finite"));
    assert_eq!(fault(&[0.0], &flat), of("it has 6 numbers instead of 3"));
    assert_eq!(
        fault(&[0.0, 1.0], &[0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0]),
        of("key 1 has a number that is not finite")
    );
    assert_eq!(fault(&[0.0], &[0.0; 3]), "");
    let unknown = glb(
        &[TRIANGLE, TIMES, MOVES],
        &format!(r#"{MESH}, {NODES}, "animations": [{{"channels": [], "samplers": []}}]"#),
    );
    assert!(load(&unknown, &["0"]).is_ok(), "nothing moves");
}

#[test]
fn weights_of_a_node_and_of_its_mesh_morph_positions() {
    let target: (usize, &[f32]) = (3, &[0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0]);
    let weights: (usize, &[f32]) = (1, &[0.5, 1.0]);
    let arrays = [TRIANGLE, TIMES, weights, target];
    let meshes = |more: &str| {
        format!(
            r#""meshes": [{{"weights": [0.25], "primitives": [{{"attributes": {{"POSITION": 0}}, "targets": [{{"POSITION": 3}}]}}]}}],
            "nodes": [{{"mesh": 0}}, {{"mesh": 0, "weights": [0]}}], {more}"#
        )
    };
    let depth = |model: &Model, time: f64| {
        let posed = at(model, time);
        [0, 1].map(|i| posed.meshes[posed.instances[i].mesh].positions[0].z)
    };
    let of_node = meshes(&format!(r#""animations": [{}]"#, animation("", "weights")));
    let model = load(&glb(&arrays, &of_node), &["0"]).unwrap();
    assert_eq!(
        [0.0, 2.0, 9.0].map(|t| depth(&model, t)),
        [[1.0, 0.0], [1.5, 0.0], [2.0, 0.0]]
    );
    // Those of the mesh count where the node has none.
    let of_mesh = meshes(
        r#""animations": [{"channels": [{"sampler": 0, "target": {"path": "pointer", "extensions":
        {"KHR_animation_pointer": {"pointer": "/meshes/0/weights"}}}}], "samplers": [{"input": 1, "output": 2}]}]"#,
    );
    let model = load(&glb(&arrays, &of_mesh), &["0"]).unwrap();
    assert_eq!(depth(&model, 2.0), [1.5, 0.0]);
    assert_eq!(
        model.meshes[0].positions[0].z, 0.0,
        "what deforms is kept as it is before"
    );
}

#[test]
fn a_skin_follows_its_joints_and_not_its_own_node() {
    let weights: (usize, &[f32]) = (4, &[1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let joints: (usize, &[f32]) = (4, &[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let rest = format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "JOINTS_0": 4, "WEIGHTS_0": 3}}}}]}}],
        "nodes": [{{"name": "bone"}}, {{"name": "root"}}, {{"mesh": 0, "skin": 0, "translation": [7, 7, 7]}}],
        "skins": [{{"joints": [1, 0]}}], "animations": [{}]"#,
        animation("", "translation")
    );
    let model = load(&glb(&[TRIANGLE, TIMES, MOVES, weights, joints], &rest), &["0"]).unwrap();
    let posed = at(&model, 3.0);
    let expected = [Vec3::ZERO, Vec3::new(3.0, 0.0, -1.0), Vec3::new(4.0, 1.0, -2.0)];
    assert_eq!(
        (&posed.meshes[0].positions[..], posed.instances[0].model_from_mesh),
        (&expected[..], DAffine3::IDENTITY)
    );
}

#[test]
fn pointers_change_materials_lights_and_cameras_and_others_are_said() {
    let channels = [
        "/materials/0/pbrMetallicRoughness/baseColorFactor",
        "/extensions/KHR_lights_punctual/lights/0/color",
        "/extensions/KHR_lights_punctual/lights/0/intensity",
        "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle",
        "/cameras/0/perspective/yfov",
        "/materials/0/doubleSided",
    ];
    let outputs = [2, 3, 4, 4, 4, 4];
    let channel = |(i, pointer): (usize, &&str)| {
        format!(
            r#"{{"sampler": {i}, "target": {{"path": "pointer", "extensions": {{"KHR_animation_pointer": {{"pointer": "{pointer}"}}}}}}}}"#
        )
    };
    let channels: Vec<String> = channels.iter().enumerate().map(channel).collect();
    let samplers = outputs.map(|output| format!(r#"{{"input": 1, "output": {output}}}"#));
    let rest = format!(
        r#""extensionsUsed": ["KHR_animation_pointer", "KHR_lights_punctual"], "materials": [{{}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
        "cameras": [{{"type": "perspective", "perspective": {{"yfov": 0.7, "znear": 1}}}}],
        "extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "spot", "intensity": 5, "spot": {{}}}}]}}}},
        "nodes": [{{"mesh": 0, "camera": 0, "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}}],
        "animations": [{{"name": "Glow", "channels": [{}], "samplers": [{}]}}]"#,
        channels.join(","),
        samplers.join(",")
    );
    let arrays: [(usize, &[f32]); 5] = [
        TRIANGLE,
        TIMES,
        (4, &[1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 1.0]),
        (3, &[1.0, 1.0, 1.0, 0.0, 0.0, 1.0]),
        (1, &[0.5, 1.5]),
    ];
    let model = load(&glb(&arrays, &rest), &["Glow"]).unwrap();
    let choice_of_lights = |feature: &&ModelFeature| feature.name != "KHR_lights_punctual";
    let losses = model.features.iter().filter(choice_of_lights);
    let losses: Vec<String> = losses.filter_map(ModelFeature::loss).collect();
    let loss = "not rendered: /materials/0/doubleSided, used by 1 channel (it stays as it is at rest)";
    assert_eq!(losses, [loss]);
    let posed = at(&model, 2.0);
    let surface = &posed.materials[0].surface;
    assert!(matches!(surface.base_color, Color::Constant(c) if c == Rgb::new(0.5, 0.5, 0.0)));
    assert_eq!(surface.opacity, Scalar::Constant(0.75));
    assert_eq!(posed.lights[0].strength, Rgb::new(0.5, 0.5, 1.0));
    assert!(matches!(
        posed.lights[0].kind,
        ModelLightKind::Spot { inner: 0.0, outer: 1.0 }
    ));
    assert_eq!(posed.cameras[0].view, ModelView::Perspective { fov: 1.0 });
    assert_eq!(model.clips[0].moves, [("camera", 1), ("light", 1), ("material", 1)]);
}

#[test]
fn pointers_move_the_texture_of_one_reference_and_no_equal_one() {
    let image = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAFklEQVR42mP4L8cg8kuDQc7mw68PIgAjvQWcELqerwAAAABJRU5ErkJggg==";
    let base = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform";
    let channel = |(i, property): (usize, &str)| {
        format!(
            r#"{{"sampler": {i}, "target": {{"path": "pointer", "extensions": {{"KHR_animation_pointer": {{"pointer": "{base}/{property}"}}}}}}}}"#
        )
    };
    let channels: Vec<String> = ["offset", "rotation"].into_iter().enumerate().map(channel).collect();
    let material = r#"{"pbrMetallicRoughness": {"baseColorTexture":
        {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.1, 0], "scale": [2, 3]}}}}}"#;
    let primitive = |material: usize| format!(r#"{{"attributes": {{"POSITION": 0}}, "material": {material}}}"#);
    let rest = format!(
        r#""images": [{{"uri": "{image}"}}], "textures": [{{"source": 0}}], "materials": [{material}, {material}],
        "meshes": [{{"primitives": [{}, {}]}}], "nodes": [{{"mesh": 0}}],
        "animations": [{{"name": "Slide", "channels": [{}],
        "samplers": [{{"input": 1, "output": 2}}, {{"input": 1, "output": 3}}]}}]"#,
        primitive(0),
        primitive(1),
        channels.join(",")
    );
    let arrays: [(usize, &[f32]); 4] = [TRIANGLE, TIMES, (2, &[0.0, 0.0, 0.5, 1.0]), (1, &[0.0, 3.0])];
    let model = load(&glb(&arrays, &rest), &["Slide"]).unwrap();
    assert!(model.features.iter().all(|feature| feature.used_by != "channel"));
    let transforms = |model: &Model| -> Vec<StTransform> { model.textures.iter().map(|t| t.transform).collect() };
    let still = StTransform::of_uv(Vec2::new(0.1, 0.0), 0.0, Vec2::new(2.0, 3.0));
    assert_eq!(transforms(&model), [still, still]);
    // The middle of the two keys.
    let moved = StTransform::of_uv(Vec2::new(0.25, 0.5), 1.5, Vec2::new(2.0, 3.0));
    assert_eq!(transforms(&at(&model, 2.0)), [moved, still]);
    assert_eq!(model.clips[0].moves, [("material", 1)]);
}
