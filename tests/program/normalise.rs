//! Models by themselves that are moved and scaled to a common size.

use crate::common::{Folder, MOVING_MODEL};

/// A triangle from 3 to 7 m along x and 2 to 4 m along y at z = -1 m, a camera in front of it, and a lamp.
const MODEL: &str = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"], "buffers": [{"byteLength": 36, "uri":
    "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 60},
        {"type": "spot", "intensity": 90, "spot": {"outerConeAngle": 0.6}}]}},
    "nodes": [{"mesh": 0, "translation": [3, 2, -1], "scale": [4, 2, 1]}, {"camera": 0, "translation": [5, 3, 6]},
        {"translation": [6, 4, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"translation": [4, 3, 3], "extensions": {"KHR_lights_punctual": {"light": 1}}}]}"#;

const JOB: [&str; 11] = [
    "m.gltf",
    "--resolution",
    "32x24",
    "--samples",
    "4",
    "--aovs",
    "P",
    "--metadata",
    "transforms",
    "--progress",
    "none",
];

/// The values of the channels of these names, pixel by pixel.
fn channels<const N: usize>(folder: &Folder, file: &str, names: [&str; N]) -> Vec<[f32; N]> {
    let image = folder.open_exr(file);
    let all: Vec<_> = image
        .layer_data
        .iter()
        .flat_map(|layer| &layer.channel_data.list)
        .collect();
    let of = |name: &str| -> Vec<f32> {
        let channel = all.iter().find(|channel| channel.name.to_string() == name);
        channel
            .unwrap_or_else(|| panic!("no {name}"))
            .sample_data
            .values_as_f32()
            .collect()
    };
    let planes = names.map(of);
    (0..planes[0].len())
        .map(|at| std::array::from_fn(|i| planes[i][at]))
        .collect()
}

/// The scale and the translation in a file beside pictures, and the position of the first camera.
fn place(folder: &Folder, file: &str) -> (Option<(f64, [f64; 3])>, [f64; 3]) {
    let cameras: serde_json::Value = serde_json::from_slice(&folder.read(file)).expect("JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let place = cameras.get("model_place");
    let place = place.map(|place| {
        (
            number(&place["scale"]),
            [0, 1, 2].map(|i| number(&place["translate"][i])),
        )
    });
    (
        place,
        [0, 1, 2].map(|i| number(&cameras["frames"][0]["transform_matrix"][i][3])),
    )
}

#[test]
fn the_picture_of_a_normalised_model_is_the_same_and_its_points_lead_back() {
    let folder = Folder::new();
    folder.write("m.gltf", MODEL);
    folder.succeed(&[&JOB[..], &["-o", "plain/f.exr"]].concat());
    let (none, eye) = place(&folder, "plain/transforms.json");
    assert_eq!((none, eye), (None, [5.0, 3.0, 6.0]));
    let color = |file: &str| channels(&folder, file, ["R", "G", "B", "A"]);
    let points = |file: &str| channels(&folder, file, ["P.X", "P.Y", "P.Z"]);
    let (plain, at) = (color("plain/f.exr"), points("plain/f.exr"));
    assert!(plain.iter().any(|pixel| pixel[0] > 0.05));
    for (shape, scale) in [("unit-sphere", 1.0 / f64::sqrt(5.0)), ("unit-cube", 0.25)] {
        let file = format!("{shape}/f.exr");
        folder.succeed(&[&JOB[..], &["--normalise", shape, "-o", &file]].concat());
        let (place, own_eye) = place(&folder, &format!("{shape}/transforms.json"));
        let (own_scale, translate) = place.expect("the model was moved");
        assert!((own_scale - scale).abs() < 1e-12, "{own_scale}");
        for (axis, middle) in [5.0, 3.0, -1.0].into_iter().enumerate() {
            assert!((scale * middle + translate[axis]).abs() < 1e-6, "{translate:?}");
            assert!(
                (scale * eye[axis] + translate[axis] - own_eye[axis]).abs() < 1e-6,
                "{own_eye:?}"
            );
        }
        for (own, plain) in color(&file).iter().zip(&plain) {
            let same = own
                .iter()
                .zip(plain)
                .all(|(own, plain)| (own - plain).abs() <= 1e-3 * plain.abs() + 1e-4);
            assert!(same, "{own:?} {plain:?}");
        }
        let mut seen = 0;
        // Where nothing is seen P is 0.
        for (own, plain) in points(&file).iter().zip(&at).filter(|(_, plain)| **plain != [0.0; 3]) {
            let back = [0, 1, 2].map(|i| (f64::from(own[i]) - translate[i]) / own_scale);
            assert!(
                (0..3).all(|i| (back[i] - f64::from(plain[i])).abs() < 1e-4),
                "{back:?} {plain:?}"
            );
            seen += 1;
        }
        assert!(seen > 50, "{seen}");
    }
}

#[test]
fn all_poses_of_a_model_fill_the_shape() {
    let folder = Folder::new();
    folder.write("m.gltf", MOVING_MODEL);
    let job = [
        "--animation",
        "Walk",
        "--normalize",
        "unit-cube",
        "--range",
        "0",
        "-o",
        "f.exr",
    ];
    folder.succeed(&[&JOB[..], &job].concat());
    // It goes by 1 m along x, and is 1 m wide and high.
    let (place, _) = place(&folder, "transforms.json");
    assert_eq!(place, Some((0.5, [-0.5, -0.25, 0.0])));
}

#[test]
fn only_a_model_by_itself_is_normalised_and_nothing_else_moves_it() {
    let folder = Folder::new();
    folder.write("m.gltf", MODEL);
    folder.write("s.toml", crate::common::SMALL_SCENE);
    let said = folder.fail(2, &["s.toml", "--normalise", "unit-cube", "-o", "f.exr"]);
    assert!(said.contains("--normalise: only a model by itself is moved"), "{said}");
    let job = [&JOB[..], &["--normalise", "unit-cube", "-o", "f.exr", "--set"]].concat();
    for name in [
        "object.m.transform.scale",
        "transform.scale",
        "random.object.*.transform.scale",
    ] {
        let said = folder.fail(2, &[&job[..], &[&format!("{name}=[1,2]")]].concat());
        let name = name.trim_start_matches("random.");
        assert!(
            said.contains(&format!("--normalise: {name} moves the model"))
                && said.contains("move its nodes (node.NAME.transform)"),
            "{said}"
        );
    }
    // The bounds of all draws are known.
    let turned = [
        "--normalise",
        "unit-cube",
        "--set",
        "random.node.0.transform.rotate.z=[0,90]",
    ];
    folder.succeed(&[&JOB[..], &turned, &["--range", "1-2", "-o", "f.#.exr"]].concat());
    assert!(folder.fail(2, &["m.gltf", "--normalise", "cube"]).contains("unit-cube"));
}
