//! The lights of glTF files: their units, and what brings them into a scene.

use crate::common::{Folder, stderr};
use std::f32::consts::PI;

/// A triangle in the xy plane, white but for a fifth, under a light that shines along -z from 2 m above the origin.
pub fn model(generator: &str, light: &str) -> String {
    let triangle = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset": {{"version": "2.0", "generator": "{generator}"}},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_specular"],
        "extensions": {{"KHR_lights_punctual": {{"lights": [{light}]}}}},
        "materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0}},
            "extensions": {{"KHR_materials_specular": {{"specularFactor": 0}}}}}}],
        "buffers": [{{"byteLength": 36, "uri": "data:;base64,{triangle}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
        "nodes": [{{"mesh": 0, "translation": [-4, -4, 0], "scale": [16, 16, 1]}},
            {{"translation": [0, 0, 2], "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}}]}}"#
    )
}

const BLENDER: &str = "Khronos glTF Blender I/O v5.3.43";

// As Blender's exporter writes a sun of 2, a point of 100 W and a spot of 100 W, 45 degrees wide with a blend of 0.15.
const SUN: &str = r#"{"type": "directional", "intensity": 1366}"#;
const POINT: &str = r#"{"type": "point", "intensity": 5435.141306588225}"#;
const SPOT: &str = r#"{"type": "spot", "intensity": 5435.141306588225,
    "spot": {"innerConeAngle": 0.3337942263919169, "outerConeAngle": 0.39269909262657166}}"#;

/// The radiance of the triangle below the light, as an object with these keys of its mesh.
fn radiance(folder: &Folder, keys: &str) -> f32 {
    let scene = format!(
        "[render]\nwidth = 9\nheight = 9\nsamples = 1\n[camera]\n\
         orthographic = {{ eye = [5, 0, 9], target = [5, 0, 0], height = 0.01 }}\n\
         [[object]]\nshape.mesh = {{ file = 'a.gltf'{keys} }}\ntransform = {{ translate = [5, 0, 0] }}\n"
    );
    folder.render(&scene)[40][0]
}

#[test]
fn lights_of_blender_are_as_bright_as_in_cycles() {
    let folder = Folder::new();
    // A point of P watts has the intensity P / (4 pi), a spot as well.
    let by_point = 0.8 / PI * (100.0 / (4.0 * PI)) / 4.0;
    for (light, expected) in [(SUN, 0.8 / PI * 2.0), (POINT, by_point), (SPOT, by_point)] {
        folder.write("a.gltf", &model(BLENDER, light));
        let found = radiance(&folder, ", lights = true");
        assert!((found / expected - 1.0).abs() < 1e-3, "{light}: {found} and {expected}");
        let unitless = radiance(&folder, ", lights = true, light_units = 'unitless'");
        assert!((unitless / expected / 683.0 - 1.0).abs() < 1e-3, "{light}: {unitless}");
        // Others mean what they write.
        folder.write("a.gltf", &model("Khronos", light));
        assert_eq!(radiance(&folder, ", lights = true"), unitless);
        assert_eq!(radiance(&folder, ", lights = true, light_units = 'photometric'"), found);
    }
}

#[test]
fn a_model_that_is_the_scene_has_its_lights_in_the_unit_of_its_program() {
    let folder = Folder::new();
    folder.write("a.gltf", &model(BLENDER, SUN));
    let run = |args: &[&str]| {
        let small = [
            "a.gltf",
            "--resolution",
            "9x9",
            "--samples",
            "1",
            "--progress",
            "none",
            "-v",
        ];
        let output = folder.run(&[&small[..], &["-o", "a.exr"], args].concat());
        assert!(output.status.success());
        let [_, value] = [0, 1].map(|_| crate::common::pixels(&folder.path("a.exr")).1[40][0]);
        (value, stderr(&output))
    };
    let (auto, log) = run(&[]);
    assert!((auto - 0.8 / PI * 2.0).abs() < 1e-3, "{auto}");
    assert!(log.contains("its lights are divided by 683 lm/W"), "{log}");
    let (unitless, log) = run(&["--light-units", "unitless"]);
    assert!((unitless / auto / 683.0 - 1.0).abs() < 2e-3, "{unitless}");
    assert!(log.contains("its lights are taken as they are"), "{log}");
    folder.write("a.toml", "[[object]]\nshape.mesh = { file = 'a.gltf' }\n");
    let message = folder.fail(2, &["a.toml", "--light-units", "auto"]);
    assert!(message.contains("`light_units`"), "{message}");
}

#[test]
fn lights_that_an_object_leaves_out_are_not_called_rendered() {
    let folder = Folder::new();
    folder.write("a.gltf", &model(BLENDER, SUN));
    let check = |keys: &str| {
        let scene = format!(
            "[camera]\nperspective = {{ eye = [0, 0, 9], target = [0, 0, 0] }}\n\
             [[object]]\nshape.mesh = {{ file = 'a.gltf'{keys} }}\n"
        );
        folder.write("a.toml", &scene);
        let output = folder.run(&["check", "a.toml"]);
        (String::from_utf8_lossy(&output.stdout).into_owned(), stderr(&output))
    };
    let (list, log) = check("");
    assert!(
        list.contains("KHR_lights_punctual, 1 x node: not rendered") && list.contains("0 lights"),
        "{list}"
    );
    assert!(log.contains("`lights = true` of the mesh lets them shine"), "{log}");
    let (list, log) = check(", lights = true");
    assert!(
        list.contains("KHR_lights_punctual, 1 x node: rendered") && list.contains("1 light\n"),
        "{list}"
    );
    assert_eq!(log, "");
    let (list, log) = check(", lights = false");
    assert!(list.contains("KHR_lights_punctual, 1 x node: not needed"), "{list}");
    assert_eq!(log, "");
}
