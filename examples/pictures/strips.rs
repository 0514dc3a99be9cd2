//! The strips of pictures that vary one setting.

use batch_render::output::DisplayTransform;

const BALL: &str = include_str!("ball.toml");
const PASSES: &str = include_str!("../../scenes/passes/scene.toml");

/// Pictures of one scene, side by side.
pub struct Strip {
    /// Its file below the folder of pictures, without the ending.
    pub file: &'static str,
    /// The text of the scene.
    pub scene: &'static str,
    /// The text in the scene that each picture replaces.
    pub placeholder: &'static str,
    /// The text in its place, in which the value stands for `VALUE`.
    pub setting: &'static str,
    /// The word before the value in the line above each picture.
    pub label: &'static str,
    pub values: Vec<&'static str>,
    pub columns: u32,
    /// The size of each picture.
    pub size: [u32; 2],
}

/// All strips.
pub fn strips() -> Vec<Strip> {
    let amounts = vec!["0", "0.25", "0.5", "0.75", "1"];
    let ball = |file, label, setting, values: &[&'static str]| Strip {
        file,
        scene: BALL,
        placeholder: "SHOWN",
        setting,
        label,
        values: values.to_vec(),
        columns: values.len() as u32,
        size: [144, 144],
    };
    let pass = |file, values: &[&'static str]| Strip {
        file,
        scene: PASSES,
        placeholder: "aovs = \"all\"",
        setting: "show = \"VALUE\"",
        label: "",
        values: values.to_vec(),
        columns: 3,
        size: [240, 135],
    };
    let wall = |file, label, setting, values: &[&'static str], size| Strip {
        file,
        scene: include_str!("wall.toml"),
        placeholder: "SHOWN",
        setting,
        label,
        values: values.to_vec(),
        columns: values.len() as u32,
        size,
    };
    vec![
        wall(
            "light/rect-spread",
            "spread",
            "rect = { position = [0, 2.1, 0.1], direction = [0, -1, 0], size = [0.9, 0.9], power = 8, spread = VALUE }",
            &["1", "0.5", "0.2", "0.05", "0"],
            [144, 144],
        ),
        wall(
            "light/rect-texture",
            "texture",
            "rect = { position = [0, 1.2, -0.55], direction = [0, 0, 1], size = [1.6, 0.9], power = 6, texture = \"texture.VALUE\", camera = true }",
            &["stripes", "board", "cells"],
            [240, 160],
        ),
        wall(
            "light/point-ies",
            "direction",
            "point = { position = [0, 1.8, -0.1], ies = \"scenes/kinds/wall-washer.ies\", power = 30, direction = VALUE }",
            &["[0, -1, 0]", "[0.6, -1, 0]", "[0, 0, -1]"],
            [240, 160],
        ),
        ball(
            "material/metal-roughness",
            "roughness",
            "metal = { preset = \"copper\", roughness = VALUE }",
            &amounts,
        ),
        ball(
            "material/metal-distribution",
            "distribution",
            "metal = { preset = \"copper\", roughness = 0.45, distribution = \"VALUE\" }",
            &["ggx", "beckmann"],
        ),
        ball(
            "material/glass-roughness",
            "roughness",
            "glass = { roughness = VALUE }",
            &["0", "0.15", "0.3", "0.5", "0.8"],
        ),
        ball(
            "material/principled-roughness",
            "roughness",
            "principled = { base_color = [0.5, 0.05, 0.04], roughness = VALUE }",
            &amounts,
        ),
        ball(
            "material/principled-metallic",
            "metallic",
            "principled = { base_color = [0.9, 0.6, 0.25], roughness = 0.25, metallic = VALUE }",
            &amounts,
        ),
        ball(
            "material/principled-transmission",
            "transmission",
            "principled = { base_color = [0.5, 0.8, 0.9], roughness = 0.05, thickness = 1, transmission = VALUE }",
            &amounts,
        ),
        ball(
            "material/principled-coat",
            "clearcoat",
            "principled = { base_color = [0.05, 0.15, 0.5], roughness = 0.8, clearcoat = VALUE }",
            &amounts,
        ),
        ball(
            "material/principled-sheen",
            "sheen_color",
            "principled = { base_color = [0.12, 0.02, 0.06], roughness = 1, specular = 0, sheen_roughness = 0.4, sheen_color = VALUE }",
            &amounts,
        ),
        Strip {
            file: "shape/mesh-subdivide",
            scene: include_str!("cage.toml"),
            placeholder: "SHOWN",
            setting: "subdivide = VALUE",
            label: "subdivide",
            values: vec!["0", "1", "2", "3", "4"],
            columns: 5,
            size: [144, 144],
        },
        Strip {
            file: "shape/mesh-displacement",
            scene: include_str!("ground.toml"),
            placeholder: "SHOWN",
            setting: "scale = VALUE",
            label: "scale",
            values: vec!["0", "0.2", "0.5", "1"],
            columns: 4,
            size: [200, 134],
        },
        Strip {
            file: "camera/perspective-aperture",
            scene: include_str!("row.toml"),
            placeholder: "SHOWN",
            setting: "aperture_radius = VALUE",
            label: "aperture_radius",
            values: vec!["0", "0.03", "0.06", "0.12"],
            columns: 4,
            size: [200, 134],
        },
        Strip {
            file: "object-back-faces",
            scene: include_str!("shell.toml"),
            placeholder: "SHOWN",
            setting: "VALUE",
            label: "back_faces",
            values: vec!["shaded", "black", "culled"],
            columns: 3,
            size: [200, 160],
        },
        Strip {
            file: "output-views",
            scene: include_str!("lamps.toml"),
            placeholder: "SHOWN",
            setting: "VALUE",
            label: "",
            values: DisplayTransform::ALL.map(DisplayTransform::name).to_vec(),
            columns: 3,
            size: [240, 135],
        },
        pass(
            "passes-light",
            &[
                "beauty",
                "diffuse_direct",
                "diffuse_indirect",
                "specular_direct",
                "specular_indirect",
                "transmission",
                "emission",
                "albedo",
                "sampleCount",
            ],
        ),
        pass(
            "passes-data",
            &[
                "N",
                "P",
                "depth",
                "distance",
                "UV",
                "objectId",
                "materialId",
                "CryptoObject",
                "CryptoMaterial",
            ],
        ),
    ]
}
