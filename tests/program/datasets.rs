//! Files for people who make data sets: depth in millimetres, pictures of 16 bits, cameras and names.

use crate::{
    common::{Folder, repo_str},
    lenses::pixel_of,
};
use serde_json::Value;

const SMALL: [&str; 6] = ["--resolution", "48x27", "--samples", "4", "--progress", "none"];

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&folder.read(name)).expect("JSON")
}

pub fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list").iter();
    list.map(|v| v.as_f64().expect("a number")).collect()
}

/// A column of the matrix of a frame of `transforms.json`, without its last number.
pub fn column(frame: &Value, column: usize) -> glam::DVec3 {
    let rows = frame["transform_matrix"].as_array().expect("rows");
    glam::DVec3::from_array([0, 1, 2].map(|row| numbers(&rows[row])[column]))
}

#[test]
fn depth_in_millimetres_is_the_pass_and_nothing_is_0() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    folder.succeed(
        &[
            &[&scene, "-o", "f.exr", "-o", "f.png", "--png-depth", "--aovs", "N"],
            &SMALL[..],
        ]
        .concat(),
    );
    assert_eq!(folder.names(), ["depth.0001.png", "f.exr", "f.png"]);
    let depth = image::load_from_memory(&folder.read("depth.0001.png"))
        .expect("a PNG")
        .into_luma16();
    let image = folder.open_exr("f.exr");
    let list = &image.layer_data[0].channel_data.list;
    let z = list
        .iter()
        .find(|c| c.name.to_string() == "depth.Z")
        .expect("the pass is in the film");
    for (pixel, z) in depth.pixels().zip(z.sample_data.values_as_f32()) {
        let expected = if z > 1e9 { 0.0 } else { (z * 1000.0).round() };
        assert_eq!(f32::from(pixel.0[0]), expected);
    }
    assert!(depth.pixels().any(|p| p.0[0] == 0) && depth.pixels().any(|p| p.0[0] > 3000));
    let files = [
        "-o",
        "f.exr",
        "-o",
        "f.png",
        "--png-depth",
        "--aovs",
        "N",
        "--skip-existing",
    ];
    let again = [&[&*scene], &files[..], &SMALL[..4]].concat();
    let again = folder.succeed(&again);
    assert!(again.contains("skipped"), "{again}");
    let error = folder.fail(2, &[&scene, "-o", "f.exr", "--png-depth=depth.exr"]);
    assert!(
        error.contains("--png-depth: expected a pattern that ends in .png, found `depth.exr`"),
        "{error}"
    );
}

#[test]
fn normals_and_numbers_of_objects_are_those_of_the_passes() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    let args = [
        &scene,
        "-o",
        "f.exr",
        "--png-normals",
        "--png-ids=out/number.####.png",
        "--exr-type",
        "float",
    ];
    folder.succeed(&[&args[..], &SMALL[..]].concat());
    let image = folder.open_exr("f.exr");
    let channel = |name: &str| -> Vec<f32> {
        let mut list = image.layer_data[0].channel_data.list.iter();
        let found = list.find(|c| c.name.to_string() == name);
        found
            .expect("the pass is in the film")
            .sample_data
            .values_as_f32()
            .collect()
    };
    let picture = |name: &str| image::load_from_memory(&folder.read(name)).expect("a PNG");
    let (normals, ids) = (picture("normals.0001.png"), picture("out/number.0001.png"));
    assert_eq!(
        (normals.color(), ids.color()),
        (image::ColorType::Rgb16, image::ColorType::L16)
    );
    let ids: Vec<f32> = ids.into_luma16().pixels().map(|p| f32::from(p.0[0])).collect();
    assert!(ids == channel("objectId.Y") && ids.contains(&0.0) && ids.contains(&3.0));
    let (x, y, z) = (channel("N.X"), channel("N.Y"), channel("N.Z"));
    for (i, pixel) in normals.into_rgb16().pixels().enumerate() {
        if ids[i] == 0.0 {
            assert_eq!(pixel.0, [0; 3]);
            continue;
        }
        for (code, expected) in pixel.0.into_iter().zip([x[i], y[i], z[i]]) {
            assert!(
                ((f32::from(code) - 32768.0) / 32767.0 - expected).abs() < 2e-5,
                "{i}: {code} and {expected}"
            );
        }
    }
    let error = folder.fail(2, &[&scene, "-o", "f.exr", "--png-ids=ids.exr"]);
    assert!(
        error.contains("--png-ids: expected a pattern that ends in .png"),
        "{error}"
    );
}

#[test]
fn pictures_of_16_bits_and_dithered_ones_are_the_same_picture() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    let picture = |name: &str, bits: &str| {
        folder.succeed(&[&[&scene, "-o", name, "--png-bits", bits], &SMALL[..]].concat());
        image::load_from_memory(&folder.read(name)).expect("a PNG")
    };
    let (eight, sixteen) = (picture("8.png", "8"), picture("16.png", "16"));
    assert_eq!(sixteen.color(), image::ColorType::Rgba16);
    let dithered = picture("d.png", "8-dithered").into_rgba8();
    assert_eq!(dithered, picture("again.png", "8-dithered").into_rgba8());
    let mut changed = 0;
    for ((a, b), c) in eight
        .into_rgba8()
        .iter()
        .zip(sixteen.into_rgba16().iter())
        .zip(dithered.iter())
    {
        let exact = f32::from(*b) / 257.0;
        assert!((f32::from(*a) - exact).abs() < 0.51 && (f32::from(*c) - exact).abs() < 1.0);
        changed += usize::from(a != c);
    }
    assert!(changed > 100);
    let error = folder.fail(2, &[&scene, "-o", "f.png", "--png-bits", "12"]);
    assert!(error.contains("--png-bits: unknown bits `12`"), "{error}");
}

#[test]
fn every_view_is_a_picture_of_its_own() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    let views = ["raw", "srgb", "reinhard", "aces", "agx", "neutral"];
    let pictures = views.map(|view| {
        folder.succeed(&[&[&scene, "-o", "f.png", "--view", view, "--exposure", "1"], &SMALL[..]].concat());
        image::load_from_memory(&folder.read("f.png"))
            .expect("a PNG")
            .into_rgba8()
    });
    for (i, picture) in pictures.iter().enumerate() {
        assert!(pictures[..i].iter().all(|other| other != picture), "{}", views[i]);
    }
}

/// Two balls, 5 m and 95 m away.
const FAR_SCENE: &str = "[render]\nwidth = 16\nheight = 8\nsamples = 1\n\
    [camera]\nperspective = { eye = [0, 0, 6], target = [0, 0, 0], fov = 40 }\n\
    [background]\ncolor = 0.5\n[material.m]\nmatte = { albedo = 0.5 }\n\
    [[object]]\nmaterial = \"m\"\nshape.sphere = { center = [-0.5, 0, 0], radius = 1 }\n\
    [[object]]\nmaterial = \"m\"\nshape.sphere = { center = [30, 0, -95], radius = 20 }\n";

#[test]
fn data_pictures_without_a_pattern_are_beside_the_first_pictures() {
    let folder = Folder::new();
    folder.write("s.toml", FAR_SCENE);
    let flags = ["--png-depth", "--png-normals", "--png-ids"];
    folder.succeed(&[&["s.toml", "-o", "out/f.exr", "-o", "small/f.png"], &flags[..]].concat());
    assert_eq!(
        crate::common::names(&folder.path("out")),
        ["depth.0001.png", "f.exr", "ids.0001.png", "normals.0001.png"]
    );
    assert_eq!(folder.names(), ["out", "s.toml", "small"]);
}

#[test]
fn depths_beyond_the_range_are_one_warning_and_another_unit_holds_them() {
    let folder = Folder::new();
    folder.write("s.toml", FAR_SCENE);
    let depth = |unit: &str| {
        let args = [
            "s.toml",
            "--turntable",
            "2",
            "-o",
            "f.#.exr",
            "--png-depth=d.#.png",
            "--png-depth-unit",
            unit,
        ];
        let said = crate::common::stderr(&folder.run(&args));
        let image = image::load_from_memory(&folder.read("d.1.png")).expect("a PNG");
        (said, image.into_luma16().into_raw())
    };
    let (said, millimetres) = depth("mm");
    let saturated = millimetres.iter().filter(|v| **v == 65535).count();
    assert!(saturated > 0);
    assert_eq!(said.matches("warning").count(), 1, "{said}");
    assert!(
        said.contains(
            "pixels of --png-depth are farther than 65.534 m and hold 65535; --png-depth-unit cm or m reaches farther"
        ),
        "{said}"
    );
    let (said, centimetres) = depth("cm");
    assert_eq!(said, "");
    for (mm, cm) in millimetres.iter().zip(&centimetres) {
        if *mm == 65535 {
            assert!(*cm > 6553);
        } else {
            assert!((f32::from(*cm) - f32::from(*mm) / 10.0).abs() <= 0.55);
        }
    }
    let unknown = folder.fail(2, &["s.toml", "--png-depth", "--png-depth-unit", "dm"]);
    assert!(unknown.contains("unknown unit `dm`"), "{unknown}");
    // The unit is part of what a file depends on.
    let again = [
        "s.toml",
        "--turntable",
        "2",
        "-o",
        "f.#.exr",
        "--png-depth=d.#.png",
        "--list-stale",
    ];
    assert_eq!(folder.succeed(&again).lines().count(), 2);
}

#[test]
fn the_frames_of_another_resolution_that_transforms_lose_are_a_warning() {
    let folder = Folder::new();
    folder.write("s.toml", FAR_SCENE);
    let job = [
        "s.toml",
        "--turntable",
        "2",
        "-o",
        "f.#.png",
        "--metadata",
        "transforms",
        "--range",
    ];
    folder.succeed(&[&job[..], &["1"]].concat());
    let other = crate::common::stderr(&folder.run(&[&job[..], &["2", "--resolution", "8x4"]].concat()));
    assert!(
        other.contains(
            "1 frame of other jobs is lost: their pictures have 16x8 pixels, those of this job 8x4: transforms.json"
        ),
        "{other}"
    );
}

const TRANSFORMS_SCENE: &str = "[render]\nwidth = 64\nheight = 48\nsamples = 1\n\
    [camera]\nperspective = { eye = [0, 1, 4], target = [0, 0, 0], fov = 40, shift = [0.1, 0] }\n\
    [material.m]\nmatte = { albedo = 0.5 }\n\
    [[object]]\nname = \"ball \\\"1\\\"\"\nmaterial = \"m\"\nshape.sphere = { center = [0.3, 0, 0], radius = 1 }\n";

#[test]
fn transforms_tell_where_every_point_of_a_picture_is_seen_also_of_crops_and_with_overscan() {
    let folder = Folder::new();
    folder.write("s.toml", TRANSFORMS_SCENE);
    folder.write(
        "path.csv",
        "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z\n3, 0, 1, 4, 0, 0, 0\n4, 3, 0, 2, 0, 0, 0\n",
    );
    let args = [
        "s.toml",
        "--frames",
        "path.csv",
        "--progress",
        "none",
        "--aovs",
        "P",
        "--metadata",
        "transforms,ids",
    ];
    let pictures = ["-o", "out/f.####.exr", "-o", "out/f.####.png"];
    for window in [&[][..], &["--crop", "14,9,50,44"], &["--overscan", "8"]] {
        folder.succeed(&[&args[..], &pictures, window].concat());
        check_transforms(&folder);
    }
    let ids = json(&folder, "out/ids.json");
    assert_eq!(ids["objectId"], serde_json::json!(["ball \"1\""]));
    assert_eq!(ids["materialId"], serde_json::json!(["m"]));
    assert_eq!(
        ids["tree"],
        serde_json::json!([{ "name": "ball \"1\"", "id": 1, "parent": null, "children": [] }])
    );
}

/// Compares `transforms.json` with the points that the EXR files hold.
pub fn check_transforms(folder: &Folder) {
    let transforms = json(folder, "out/transforms.json");
    for (i, frame) in transforms["frames"].as_array().expect("frames").iter().enumerate() {
        assert_eq!(frame["file_path"], format!("f.000{}.png", 3 + i));
        let (width, height) = image::image_dimensions(folder.path(&format!("out/f.000{}.png", 3 + i))).expect("a PNG");
        assert_eq!((&transforms["w"], &transforms["h"]), (&width.into(), &height.into()));
        let column = |c: usize| column(frame, c);
        let number = |name: &str| frame[name].as_f64().expect("a number");
        let half_angle = (f64::from(width) / 2.0 / number("fl_x")).atan();
        assert!((number("camera_angle_x") - 2.0 * half_angle).abs() < 1e-12);
        let image = exr::prelude::read_all_flat_layers_from_file(folder.path(&format!("out/f.000{}.exr", 3 + i)))
            .expect("an EXR");
        let list = &image.layer_data[0].channel_data.list;
        let channel = |name: &str| -> Vec<f32> {
            list.iter()
                .find(|c| c.name.to_string() == name)
                .expect("a channel")
                .sample_data
                .values_as_f32()
                .collect()
        };
        let (x, y, z) = (channel("P.X"), channel("P.Y"), channel("P.Z"));
        let mut seen = 0;
        for pixel in 0..width as usize * height as usize {
            let p = glam::DVec3::new(x[pixel].into(), y[pixel].into(), z[pixel].into());
            if p == glam::DVec3::ZERO {
                continue;
            }
            let from_eye = p - column(3);
            let local = glam::DVec3::new(
                from_eye.dot(column(0)),
                -from_eye.dot(column(1)),
                -from_eye.dot(column(2)),
            );
            let [u, v] = pixel_of(&transforms, frame, local).to_array();
            let center = (
                (pixel % width as usize) as f64 + 0.5,
                (pixel / width as usize) as f64 + 0.5,
            );
            assert!(
                (u - center.0).abs() < 1e-3 && (v - center.1).abs() < 1e-3,
                "{pixel}: {u}, {v}"
            );
            seen += 1;
        }
        assert!(seen > 100);
    }
}

#[test]
fn headers_of_exr_files_tell_where_every_point_is_seen_how_deep_it_is_and_what_the_lens_was() {
    let lenses = [
        (
            "perspective = { eye = [901, 1, 4], target = [900, 0, 0], focal_length = 50, fstop = 4, focus_distance = 3, shift = [0.1, 0.05] }",
            true,
        ),
        (
            "orthographic = { eye = [901, 1, 4], target = [900, 0, 0], height = 3, shift = [0, 0.2] }",
            true,
        ),
        ("panorama = { eye = [901, 1, 4], target = [900, 0, 0] }", false),
        ("fisheye = { eye = [901, 1, 4], target = [900, 0, 0] }", false),
    ];
    for (lens, has_ndc) in lenses {
        let folder = Folder::new();
        folder.write(
            "s.toml",
            &format!(
                "[render]\nwidth = 64\nheight = 48\nsamples = 1\n[camera]\n{lens}\n[material.m]\nmatte = {{ albedo = 0.5 }}\n\
                 [[object]]\nmaterial = \"m\"\nshape.sphere = {{ center = [900.3, 0, 0], radius = 1 }}\n"
            ),
        );
        let args = [
            "s.toml",
            "-o",
            "f.exr",
            "--aovs",
            "P,depth",
            "--crop",
            "8,6,60,48",
            "--fps",
            "24",
        ];
        folder.succeed(&[&args[..], &["--progress", "none"]].concat());
        let image = folder.open_exr("f.exr");
        let layer = &image.layer_data[0];
        let facts = &layer.attributes;
        assert_eq!((facts.near_clip_plane, facts.far_clip_plane), (Some(0.0), Some(1e10)));
        assert_eq!(facts.focus, has_lens(lens).then_some(3.0), "{lens}");
        assert_eq!(facts.aperture, has_lens(lens).then_some(4.0), "{lens}");
        let focal = facts.other.get(&exr::prelude::Text::from("pinholeFocalLength"));
        assert_eq!(focal.is_some(), has_lens(lens));
        let matrix = |m: [f32; 16]| glam::DMat4::from_cols_array(&m.map(f64::from));
        let to_camera = matrix(facts.world_to_camera.expect("a matrix"));
        let to_ndc = facts.world_to_normalized_device.map(matrix);
        assert_eq!(to_ndc.is_some(), has_ndc);
        let channel = |name: &str| -> Vec<f32> {
            let list = layer.channel_data.list.iter();
            let found = list.into_iter().find(|c| c.name.to_string() == name);
            found.expect("a channel").sample_data.values_as_f32().collect()
        };
        let (x, y, z, depth) = (channel("P.X"), channel("P.Y"), channel("P.Z"), channel("depth.Z"));
        let mut seen = 0;
        for pixel in (0..52 * 42).filter(|i| depth[*i] < 1e9) {
            let p = glam::DVec4::new(x[pixel].into(), y[pixel].into(), z[pixel].into(), 1.0);
            let camera = to_camera * p;
            let far = if lens.starts_with("panorama") || lens.starts_with("fisheye") {
                camera.truncate().length()
            } else {
                camera.z
            };
            assert!(
                (far - f64::from(depth[pixel])).abs() < 4e-3,
                "{lens}: {far} and {}",
                depth[pixel]
            );
            if let Some(to_ndc) = to_ndc {
                let ndc = to_ndc * p;
                let at = [ndc.x / ndc.w * 64.0, ndc.y / ndc.w * 48.0];
                let center = [(8 + pixel % 52) as f64 + 0.5, (6 + pixel / 52) as f64 + 0.5];
                assert!(
                    (0..2).all(|i| (at[i] - center[i]).abs() < 0.05),
                    "{lens}: {at:?} and {center:?}"
                );
            }
            seen += 1;
        }
        assert!(seen > 20, "{lens}: {seen}");
    }
}

fn has_lens(camera: &str) -> bool {
    camera.starts_with("perspective")
}

#[test]
fn headers_of_exr_files_tell_the_time_of_a_frame_and_of_its_shutter() {
    let folder = Folder::new();
    folder.write("s.toml", "[render]\nwidth = 8\nheight = 8\nsamples = 1\n[camera]\nperspective = { eye = [0, 1, 4], target = [0, 0, 0] }\n");
    folder.write(
        "path.csv",
        "frame, eye_x, eye_y, eye_z, target_x, target_y, target_z, shutter_open, shutter_close\n\
         90000, 0, 1, 4, 0, 0, 0, -0.25, 0.25\n90065, 3, 0, 2, 0, 0, 0, -0.25, 0.25\n",
    );
    let args = [
        "s.toml",
        "-o",
        "f.####.exr",
        "--frames",
        "path.csv",
        "--range",
        "90065",
        "--fps",
        "24",
    ];
    folder.succeed(&[&args[..], &["--progress", "none"]].concat());
    let image = folder.open_exr("f.90065.exr");
    let facts = &image.layer_data[0].attributes;
    // 90065 frames are 62 min, 32 s and 17 frames.
    let code = image.attributes.time_code.expect("a time code");
    assert_eq!((code.hours, code.minutes, code.seconds, code.frame), (1, 2, 32, 17));
    assert_eq!(facts.exposure, Some(0.5 / 24.0));
    let text = |name: &str| {
        let found = facts.other.get(&exr::prelude::Text::from(name));
        found.map(|value| format!("{value:?}")).unwrap_or_default()
    };
    assert!(text("shutterAngle").contains("180"), "{}", text("shutterAngle"));
    assert!(text("batch-render/scene").contains("s.toml"));
    assert!(text("batch-render/conventions").contains("pixel centres are at .5"));
}

#[test]
fn cameras_without_focal_lengths_and_unknown_files_are_refused() {
    let folder = Folder::new();
    folder.write(
        "s.toml",
        "[camera]\nfisheye = { eye = [0, 1, 4], target = [0, 0, 0] }\n",
    );
    let error = folder.fail(
        2,
        &[&["s.toml", "-o", "f.png", "--metadata", "transforms"], &SMALL[..]].concat(),
    );
    assert!(
        error.contains("--metadata transforms: only perspective cameras have focal lengths"),
        "{error}"
    );
    let error = folder.fail(2, &["s.toml", "--metadata", "transform"]);
    assert!(
        error.contains("--metadata: unknown metadata `transform`") && error.contains("transforms"),
        "{error}"
    );
}
