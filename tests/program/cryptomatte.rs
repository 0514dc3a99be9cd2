//! Cryptomatte: what a compositor makes of a file is what the camera saw.

use std::collections::HashMap;

use crate::common::Folder;
use batch_render::math::hash;
use exr::prelude::{AttributeValue, FlatImage, FlatSamples, Text};

/// A red card before a gray wall, both wider than the picture but for the card's right edge, which is in the middle.
const CARD: &str = r#"
[render]
width = 32
height = 16
samples = 64

[camera]
CAMERA

[background]
color = [0.3, 0.3, 0.3]
visible = false

[material.card]
principled = { base_color = [0.8, 0.1, 0.1], opacity = OPACITY }

[material.wall]
matte = { albedo = 0.5 }

[[object]]
name = "card"
material = "card"
shape.quad = { corners = [[-9, -9, 1], [0, -9, 1], [0, 9, 1], [-9, 9, 1]] }

[[object]]
name = "wall"
material = "wall"
shape.quad = { corners = [[-9, 0, 0], [9, 0, 0], [9, 9, 0], [-9, 9, 0]] }
"#;

const STILL: &str = "perspective = { eye = [0, 0.01, 5], target = [0, 0.01, 0], fov = 40 }";

/// A text of a header, whose bytes are UTF-8.
fn utf8(text: &Text) -> String {
    String::from_utf8(text.bytes().to_vec()).expect("UTF-8")
}

/// A decoded file: the coverage of every name, the rest of each pixel, and alpha.
struct Decoded {
    coverage: HashMap<String, Vec<f32>>,
    alpha: Vec<f32>,
}

/// Decodes the layers of `pass` by the file's own attributes.
fn decode(image: &FlatImage, pass: &str) -> Decoded {
    let layer = &image.layer_data[0];
    let others = image.attributes.other.iter().chain(&layer.attributes.other);
    let texts: HashMap<String, String> = others
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((name.to_string(), utf8(text))),
            _ => None,
        })
        .collect();
    let (name, _) = texts
        .iter()
        .find(|(name, value)| name.ends_with("/name") && value.as_str() == pass)
        .expect("the pass is in the header");
    let key = name.strip_suffix("name").expect("it ends so");
    assert_eq!(texts[&format!("{key}hash")], "MurmurHash3_32");
    assert_eq!(texts[&format!("{key}conversion")], "uint32_to_float32");
    let manifest: HashMap<String, String> =
        serde_json::from_str(&texts[&format!("{key}manifest")]).expect("the manifest is JSON");
    let values = |channel: &str| -> Vec<f32> {
        let name = Text::from(channel);
        let found = layer.channel_data.list.iter().find(|c| c.name == name);
        match &found.unwrap_or_else(|| panic!("no channel {channel}")).sample_data {
            FlatSamples::F16(v) => v.iter().map(|v| v.to_f32()).collect(),
            FlatSamples::F32(v) => v.clone(),
            FlatSamples::U32(_) => panic!("{channel} is a float"),
        }
    };
    let alpha = values("A");
    let mut coverage: HashMap<String, Vec<f32>> = HashMap::new();
    for (name, id) in &manifest {
        let bits = u32::from_str_radix(id, 16).expect("eight hex digits");
        assert_eq!(bits, hash::name_as_float(name).to_bits(), "{name}");
        let mut sum = vec![0.0; alpha.len()];
        for layer in 0..3 {
            for [id, part] in [["R", "G"], ["B", "A"]] {
                let ids = values(&format!("{pass}{layer:02}.{id}"));
                let parts = values(&format!("{pass}{layer:02}.{part}"));
                for ((sum, id), part) in sum.iter_mut().zip(ids).zip(parts) {
                    *sum += if id.to_bits() == bits { part } else { 0.0 };
                }
            }
        }
        coverage.insert(name.clone(), sum);
    }
    Decoded { coverage, alpha }
}

/// Renders the card and decodes its objects; each row of a matte is `&matte[32 * y..][..32]`.
fn card(camera: &str, opacity: &str, args: &[&str]) -> Decoded {
    let folder = Folder::new();
    folder.write("s.toml", &CARD.replace("CAMERA", camera).replace("OPACITY", opacity));
    let common = ["s.toml", "--progress", "none", "-o", "f.exr", "--aovs", "CryptoObject"];
    folder.succeed(&[&common, args].concat());
    decode(&folder.open_exr("f.exr"), "CryptoObject")
}

#[test]
fn the_mattes_of_a_pixel_sum_to_its_alpha() {
    let decoded = card(STILL, "0.5", &[]);
    for (i, alpha) in decoded.alpha.iter().enumerate() {
        let sum: f32 = decoded.coverage.values().map(|matte| matte[i]).sum();
        assert!((sum - alpha).abs() < 6e-4, "pixel {i}: {sum} and {alpha}");
    }
    assert!(decoded.alpha.contains(&0.0) && decoded.alpha.contains(&1.0));
}

#[test]
fn a_matte_of_a_surface_is_its_opacity() {
    // Away from the edges: the card covers a quarter of each pixel, the wall behind it the rest.
    let decoded = card(STILL, "0.25", &["--samples", "4096", "--crop", "4,2,6,3"]);
    for i in 0..2 {
        let (card, wall) = (decoded.coverage["card"][i], decoded.coverage["wall"][i]);
        assert!((card - 0.25).abs() < 0.03, "{card}");
        assert!((card + wall - 1.0).abs() < 1e-6, "{wall}");
    }
}

#[test]
fn an_edge_out_of_focus_is_as_wide_as_its_circle_of_confusion() {
    let focused = "perspective = { eye = [0, 0.01, 5], target = [0, 0.01, 0], fov = 40, aperture_radius = 0.4, focus_distance = 4 }";
    let blurred = focused.replace("focus_distance = 4", "focus_distance = 100");
    let width = |camera: &str| {
        let decoded = card(camera, "1", &["--samples", "256"]);
        let row = &decoded.coverage["card"][32 * 12..][..32];
        assert!(row[0] > 0.99 && row[31] < 0.01);
        row.iter().filter(|c| (0.02..0.98).contains(*c)).count()
    };
    let (sharp, soft) = (width(focused), width(&blurred));
    assert!(sharp <= 3 && soft >= 4, "{sharp} and {soft} pixels");
}

#[test]
fn a_pan_while_the_shutter_is_open_smears_the_matte() {
    let folder = Folder::new();
    folder.write("s.toml", &CARD.replace("CAMERA", STILL).replace("OPACITY", "1"));
    folder.write(
        "path.csv",
        "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z, shutter_open, shutter_close\n\
         1, 0, 0.01, 5, 0, 0.01, 0, 0, 1\n2, 1, 0.01, 5, 1, 0.01, 0, 0, 1\n",
    );
    let args = [
        "s.toml",
        "--frames",
        "path.csv",
        "--range",
        "1",
        "--progress",
        "none",
        "-o",
        "f.exr",
    ];
    folder.succeed(&[&args[..], &["--aovs", "CryptoObject", "--samples", "256"]].concat());
    let decoded = decode(&folder.open_exr("f.exr"), "CryptoObject");
    let row = &decoded.coverage["card"][32 * 12..][..32];
    // 1 m at a distance of 4 m is 5.5 of 16 rows' pixels; linear from one end to the other.
    let partly = row.iter().filter(|c| (0.02..0.98).contains(*c)).count();
    assert!((4..=8).contains(&partly), "{row:?}");
    assert!(row.windows(2).all(|pair| pair[0] >= pair[1] - 0.05), "{row:?}");
}

#[test]
fn names_of_any_script_are_in_the_manifest() {
    let folder = Folder::new();
    let names = ["равнина", "草原 \\\"1\\\" \\\\ back", "emoji 🐇"];
    let objects: String = names
        .iter()
        .enumerate()
        .map(|(i, name)| {
            format!("[[object]]\nname = \"{name}\"\nmaterial = \"card\"\nshape.sphere = {{ center = [{i}, 1, 1], radius = 0.5 }}\n")
        })
        .collect();
    let scene = CARD.replace("CAMERA", STILL).replace("OPACITY", "1") + &objects;
    folder.write("s.toml", &scene);
    folder.succeed(&[
        "s.toml",
        "--progress",
        "none",
        "-o",
        "f.exr",
        "--aovs",
        "CryptoObject,CryptoAsset",
    ]);
    let image = folder.open_exr("f.exr");
    for pass in ["CryptoObject", "CryptoAsset"] {
        let decoded = decode(&image, pass);
        assert_eq!(decoded.coverage.len(), 5);
        for name in ["равнина", "草原 \"1\" \\ back", "emoji 🐇"] {
            assert!(decoded.coverage[name].iter().any(|c| *c > 0.5), "{name}");
        }
    }
}

#[test]
fn fewer_levels_are_fewer_layers() {
    let folder = Folder::new();
    folder.write("s.toml", &CARD.replace("CAMERA", STILL).replace("OPACITY", "1"));
    let args = [
        "s.toml",
        "--progress",
        "none",
        "-o",
        "f.exr",
        "--aovs",
        "CryptoMaterial",
    ];
    folder.succeed(&[&args[..], &["--cryptomatte-levels", "2"]].concat());
    let image = folder.open_exr("f.exr");
    let names: Vec<String> = image.layer_data[0]
        .channel_data
        .list
        .iter()
        .map(|c| c.name.to_string())
        .collect();
    let crypto = ["A", "B", "G", "R"].map(|c| format!("CryptoMaterial00.{c}"));
    assert_eq!(
        names,
        [
            ["A", "B"].map(str::to_owned).to_vec(),
            crypto.to_vec(),
            ["G", "R"].map(str::to_owned).to_vec()
        ]
        .concat()
    );
    let error = folder.fail(2, &[&args[..], &["--cryptomatte-levels", "3"]].concat());
    assert!(error.contains("expected an even number from 2 to 16"), "{error}");
    folder.write("bad.toml", "[output]\ncryptomatte_levels = 17\n");
    let error = folder.fail(65, &["bad.toml"]);
    assert!(
        error.contains("`cryptomatte_levels`: expected an even number"),
        "{error}"
    );
}
