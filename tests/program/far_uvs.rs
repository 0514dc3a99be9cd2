//! Texture coordinates far from 0 show what those near 0 show, whole repetitions away.

use crate::common::Folder;

/// A place in whole repetitions, an odd number on each axis.
const FAR: [f64; 2] = [1_000_001.0, -5_649_831.0];

/// A square that fills the picture, with coordinates around `place` that end in fractions, as the model of a format.
fn model(folder: &Folder, format: &str, place: [f64; 2]) {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let uv = |[x, y]: [f64; 2]| [place[0] + 0.25 + 1.5 * x, place[1] + 0.125 + 1.25 * y];
    match format {
        "obj" => {
            let corner = |c: [f64; 2]| format!("v {} {} 0\nvt {:.3} {:.3}\n", c[0], c[1], uv(c)[0], uv(c)[1]);
            // Another part whose coordinates are near 0 has its own.
            let near = "v 5 5 0\nv 6 5 0\nv 5 6 0\nvt 0 0\no near\nf 5/5 6/5 7/5\n";
            let text = corners.map(corner).concat() + near + "o far\nf 1/1 2/2 3/3 4/4\n";
            folder.write("m.obj", &text);
        }
        "ply" | "corners.ply" => {
            let of_faces = format == "corners.ply";
            let numbers = |c: [f64; 2]| format!("{} {}", uv(c)[0], uv(c)[1]);
            let own = |c: [f64; 2]| if of_faces { String::new() } else { numbers(c) };
            let vertices = corners.map(|c| format!("{} {} 0 {}\n", c[0], c[1], own(c))).concat();
            let [of_vertex, of_face, list] = if of_faces {
                let list = format!("8 {}", corners.map(numbers).join(" "));
                ["", "property list uchar double texcoord\n", &list].map(str::to_owned)
            } else {
                ["property double s\nproperty double t\n", "", ""].map(str::to_owned)
            };
            folder.write(
                &format!("m.{format}"),
                &format!(
                    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                     {of_vertex}element face 1\nproperty list uchar int vertex_indices\n{of_face}end_header\n\
                     {vertices}4 0 1 2 3 {list}\n"
                ),
            );
        }
        "gltf" => {
            let positions = corners.map(|[x, y]| [x, y, 0.0]).concat();
            // The set of the picture is the second one; v points down.
            let uvs = corners.map(|c| [uv(c)[0], 1.0 - uv(c)[1]]).concat();
            let near = [0.5; 8];
            let numbers = positions.iter().chain(&near).chain(&uvs).map(|v| *v as f32);
            let indices = [0_u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes);
            let bytes: Vec<u8> = numbers.flat_map(f32::to_le_bytes).chain(indices.concat()).collect();
            std::fs::write(folder.path("m.bin"), &bytes).expect("written");
            folder.write(
                "m.gltf",
                r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2}, "indices": 3, "material": 0}]}],
                "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorTexture": {"index": 0, "texCoord": 1,
                "extensions": {"KHR_texture_transform": {"scale": [2, 1], "offset": [0.3, 0]}}}}, "emissiveTexture": {"index": 0}}],
                "textures": [{"source": 0}], "images": [{"uri": "ramp.tga"}], "extensionsUsed": ["KHR_texture_transform"],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
                {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"}],
                "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                {"buffer": 0, "byteOffset": 80, "byteLength": 32}, {"buffer": 0, "byteOffset": 112, "byteLength": 12}],
                "buffers": [{"byteLength": 124, "uri": "m.bin"}]}"#,
            );
        }
        _ => unreachable!("a format of this test"),
    }
}

/// Writes a picture of 8 x 8 texels, all different.
fn ramp(folder: &Folder) {
    let header = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 0, 8, 0, 24, 0];
    let texels = (0..64_u8).flat_map(|i| [4 * (i % 8) * 8, 4 * (i / 8) * 8, 255 - 3 * i]);
    let bytes: Vec<u8> = header.into_iter().chain(texels).collect();
    std::fs::write(folder.path("ramp.tga"), bytes).expect("written");
}

/// The picture of a square with coordinates around `place`; `texture` has the keys of its texture, `model` is its format.
fn picture(format: &str, place: [f64; 2], texture: &str, more: &str) -> Vec<[f32; 3]> {
    let folder = Folder::new();
    ramp(&folder);
    model(&folder, format, place);
    let (material, texture) = match texture {
        "" => ("", String::new()),
        keys => (
            "material = \"m\"\n",
            format!("[texture.t]\n{keys}\n[material.m]\nmatte = {{ albedo = \"texture.t\" }}\n"),
        ),
    };
    folder.render(&format!(
        "[render]\nwidth = 64\nheight = 64\nsamples = 1\nintegrator.whitted = {{ max_depth = 1, ambient = 1 }}\n\
         [camera]\northographic = {{ eye = [0.5, 0.5, 5], target = [0.5, 0.5, 0], height = 1 }}\n{texture}\
         [[object]]\n{material}shape.mesh = {{ file = \"m.{format}\" }}\n{more}"
    ))
}

/// The largest difference of a channel.
fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    let channels = a.iter().flatten().zip(b.iter().flatten());
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[track_caller]
fn assert_far_is_near(format: &str, texture: &str, near: [f64; 2], more: &str) {
    let home = picture(format, near, texture, more);
    assert!(difference(&home, &[home[0]; 64 * 64]) > 0.1, "{format} {texture}");
    let found = difference(&home, &picture(format, FAR, texture, more));
    assert!(found < 1e-3, "{format} {texture}: {found}");
}

const IMAGE: &str = "image = { file = \"ramp.tga\" }";

#[test]
fn texture_coordinates_of_any_model_far_from_0_equal_those_near_0() {
    for format in ["obj", "ply", "corners.ply"] {
        assert_far_is_near(format, IMAGE, [0.0; 2], "");
    }
}

#[test]
fn second_texture_coordinates_of_gltf_far_from_0_equal_those_near_0() {
    // Places in which single precision holds the fractions of the corners.
    let pictures = [[0.0; 2], [100_001.0, -50_001.0]].map(|place| picture("gltf", place, "", ""));
    assert!(difference(&pictures[0], &[pictures[0][0]; 64 * 64]) > 0.1);
    let found = difference(&pictures[0], &pictures[1]);
    assert!(found < 1e-3, "{found}");
}

#[test]
fn copies_with_far_texture_coordinates_equal_those_near_0() {
    let copy = "[[object]]\nmaterial = \"m\"\nshape.mesh = { file = \"m.obj\" }\ntransform = { translate = [0.5, 0, 1], \
                scale = 0.5 }\n";
    assert_far_is_near("obj", IMAGE, [0.0; 2], &copy.repeat(2));
}

#[test]
fn far_texture_coordinates_keep_the_side_of_a_mirrored_repetition() {
    let mirrored = "image = { file = \"ramp.tga\", wrap = \"mirror\" }";
    assert_far_is_near("obj", mirrored, [1.0, 1.0], "");
    let [home, other] = [[0.0; 2], [1.0; 2]].map(|place| picture("obj", place, mirrored, ""));
    assert!(difference(&home, &other) > 0.1);
}

#[test]
fn transforms_of_far_texture_coordinates_equal_transforms_of_near_ones() {
    for (transform, near) in [
        ("scale = 0.5", [1.0, 1.0]),
        // 1,000,001 tenths are one tenth more than whole repetitions.
        ("scale = 0.1", [1.0, -1.0]),
        ("rotate = 90, offset = [0.3, 0.7]", [0.0, 0.0]),
        // The numbers of the file, which are not those of single precision.
        ("scale = 0.3, offset = [1000000.5, 0]", [1.0, -1.0]),
    ] {
        assert_far_is_near("obj", &format!("{IMAGE}\ntransform = {{ {transform} }}"), near, "");
    }
}

#[test]
fn far_texture_coordinates_that_an_offset_brings_back_show_a_picture_that_does_not_repeat() {
    let clamped = "image = { file = \"ramp.tga\", wrap = \"clamp\" }";
    let home = picture("obj", [0.0; 2], clamped, "");
    let offset = format!("{clamped}\ntransform = {{ offset = [{}, {}] }}", -FAR[0], -FAR[1]);
    let found = difference(&home, &picture("obj", FAR, &offset, ""));
    assert!(found < 1e-3, "{found}");
    let edge = picture("obj", FAR, clamped, "");
    assert_eq!(difference(&edge, &[edge[0]; 64 * 64]), 0.0);
}

#[test]
fn far_texture_coordinates_of_patterns_equal_near_ones() {
    let checker = "checker = { a = [1, 1, 1], b = [0, 0, 0], scale = 3 }";
    let stripes = "stripes = { a = [1, 1, 1], b = [0, 0, 0], width = 0.1 }";
    for pattern in [checker, stripes] {
        // An odd number of squares is between the places, and another one in the other direction.
        assert_far_is_near("obj", pattern, [0.0, 0.0], "");
    }
}

#[test]
fn the_pass_of_texture_coordinates_far_from_0_has_the_true_ones() {
    /// The spacing of single precision at five millions.
    const ROUNDING: f64 = 0.25;
    let folder = Folder::new();
    model(&folder, "obj", FAR);
    folder.write(
        "s.toml",
        "[render]\nwidth = 8\nheight = 8\nsamples = 1\nintegrator.whitted = { max_depth = 1 }\n\
         [camera]\northographic = { eye = [0.5, 0.5, 5], target = [0.5, 0.5, 0], height = 1 }\n\
         [[object]]\nshape.mesh = { file = \"m.obj\" }\n[output]\nexr_type = \"float\"\n",
    );
    folder.succeed(&["s.toml", "--aovs", "UV", "-o", "f.exr", "--progress", "none"]);
    let picture = folder.open_exr("f.exr");
    let channels = &picture.layer_data[0].channel_data.list;
    for (channel, place, extent) in [("UV.U", FAR[0], 1.5), ("UV.V", FAR[1], 1.25)] {
        let named = |c: &&exr::image::AnyChannel<_>| c.name.to_string().ends_with(channel);
        let found = channels.iter().find(named).expect("a channel");
        for value in found.sample_data.values_as_f32() {
            assert!(
                (-ROUNDING..=extent + ROUNDING).contains(&(f64::from(value) - place - 0.125)),
                "{channel} {value}"
            );
        }
    }
}
