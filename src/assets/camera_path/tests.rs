//! Camera paths of all formats.

use std::{collections::BTreeMap, fs};

use glam::DVec3;

use super::*;
use crate::camera::{
    Camera, Lens, RotationOrder,
    path::{CameraPath, CameraState},
};

#[test]
fn a_missing_file_is_told_from_one_that_cannot_be_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let missing = folder.path().join("path.csv");
    let error = load(&missing, None, &CameraPathOptions::default(), &Files::default()).unwrap_err();
    assert!(matches!(error, CameraPathError::NotFound { .. }));
    assert_eq!(
        error.to_string(),
        format!("there is no such camera path: {}", missing.display())
    );

    let csv = CameraPathFormat::by_name("CSV");
    let error = load(folder.path(), csv, &CameraPathOptions::default(), &Files::default()).unwrap_err();
    assert!(matches!(error, CameraPathError::Io { .. }));
}

#[test]
fn an_unknown_ending_names_the_known_ones() {
    let error = load(
        Path::new("shot.abc"),
        None,
        &CameraPathOptions::default(),
        &Files::default(),
    )
    .unwrap_err();
    assert_eq!(
        error.to_string(),
        "unknown camera path format (expected one of `csv`, `tsv`, `chan`, `bin`, `txt`, `tum`, `json`, `gltf`, `glb`, `yaml`, `yml`): shot.abc"
    );
}

#[test]
fn a_file_is_loaded_and_its_problems_bear_its_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("Shot.CSV");
    let header = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n";
    fs::write(&path, format!("{header}1,0,0,15,0,0,0\n")).expect("written");
    let loaded = load(&path, None, &CameraPathOptions::default(), &Files::default()).expect("a path");
    assert_eq!(loaded.frames(), 1..=1);

    fs::write(&path, format!("{header}1,abc,0,15,0,0,0\n")).expect("written");
    let error = load(&path, None, &CameraPathOptions::default(), &Files::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!("{}:2: eye_x: 'abc' is not a number", path.display())
    );
}

/// The sine of 45 degrees.
const S: &str = "0.70710678118654752";

/// A file by its name.
type Named = (&'static str, Vec<u8>);

/// The files of a camera at (1, 2, 3) that looks along -x with +y up, in every format but CSV; its picture has 8x6 pixels with
/// focal lengths of 10 and 11 and the centre at (4.5, 3.25) where the format says so. Several files of one format are alternatives.
fn files() -> Vec<(&'static str, Vec<u8>, Option<Named>)> {
    let text = |text: &str| text.replace("[S]", S).into_bytes();
    let image = b"# comment\n9 0 -[S] 0 [S] 3 2 1 4 a b 12.png\n\n";
    let mut images = 1_u64.to_le_bytes().to_vec();
    images.extend(9_u32.to_le_bytes());
    let s = std::f64::consts::FRAC_1_SQRT_2;
    images.extend(
        [0.0, -s, 0.0, s, 3.0, 2.0, 1.0]
            .iter()
            .flat_map(|v: &f64| v.to_le_bytes()),
    );
    images.extend(4_u32.to_le_bytes());
    images.extend(b"a b 12.png\0");
    images.extend(1_u64.to_le_bytes());
    images.extend([0; 24]);
    let mut cameras = 1_u64.to_le_bytes().to_vec();
    cameras.extend(4_u32.to_le_bytes());
    cameras.extend(1_u32.to_le_bytes());
    cameras.extend([8_u64, 6].iter().flat_map(|v| v.to_le_bytes()));
    cameras.extend([10.0, 11.0, 4.5, 3.25].iter().flat_map(|v: &f64| v.to_le_bytes()));
    let json = r#"{"w": 8, "h": 6, "fl_x": 10, "fl_y": 11, "cx": 4.5, "cy": 3.25, "k1": 0,
        "frames": [{"file_path": "images/12.png", "transform_matrix": [[0, 0, 1, 1], [0, 1, 0, 2], [-1, 0, 0, 3], [0, 0, 0, 1]]}]}"#;
    let path = r#"{"render_height": 6, "camera_path": [{"camera_to_world": [0, 0, 1, 1, 0, 1, 0, 2, -1, 0, 0, 3, 0, 0, 0, 1], "fov": 40}]}"#;
    let gltf = r#"{"scene": 0, "scenes": [{"nodes": [1]}], "cameras": [{"perspective": {"yfov": 0.69813170079773184}}],
        "nodes": [{"camera": 0, "name": "c.12", "rotation": [0, [S], 0, [S]]}, {"children": [0], "translation": [1, 2, 3], "scale": [2, 2, 2]}]}"#
        .replace("[S]", S);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((gltf.len() as u32 + 20).to_le_bytes());
    glb.extend((gltf.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(gltf.as_bytes());
    let yaml = "%YAML:1.0\n---\nimage_width: 8\nimage_height: 6\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
        data: [ 10., 0., 4., 0., 11., 2.75,\n       0., 0., 1. ]\nDistortion_Coefficients: [ 0., 0., 0., 0. ]\n\
        rvec: [ -2.2214414690791831, 0., 2.2214414690791831 ]\ntvec: !!opencv-nd-matrix\n   sizes: [ 3 ]\n   dt: d\n   data: [ 3., 2., 1. ]\n";
    vec![
        ("a.chan", text("# frame\n12 1 2 3 0 90 0 40\n"), None),
        ("a.tum", text("12 1 2 3 [S] 0 -[S] 0\n"), None),
        ("a.txt", text("12,1,2,3,[S],0,-[S],0\n"), None),
        (
            "images.txt",
            text(str::from_utf8(image).expect("a text")),
            Some(("cameras.txt", text("4 PINHOLE 8 6 10 11 4.5 3.25\n"))),
        ),
        ("images.bin", images, Some(("cameras.bin", cameras))),
        ("a.json", text(json), None),
        ("path.json", text(path), None),
        ("a.gltf", text(&gltf), None),
        ("a.glb", glb, None),
        ("a.yml", text(yaml), None),
    ]
}

/// Reads a file with another beside it.
fn read(name: &str, bytes: &[u8], beside: Option<&Named>) -> Result<CameraPath, CameraPathError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join(name), bytes).expect("written");
    if let Some((name, bytes)) = beside {
        fs::write(folder.path().join(name), bytes).expect("written");
    }
    load(
        &folder.path().join(name),
        None,
        &CameraPathOptions::default(),
        &Files::default(),
    )
}

#[test]
fn one_camera_is_the_same_in_every_format() {
    let mut seen = BTreeMap::new();
    for (name, bytes, beside) in files() {
        let path = read(name, &bytes, beside.as_ref()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let frame = if matches!(name, "path.json" | "a.yml") { 1 } else { 12 };
        assert_eq!(path.frames(), frame..=frame, "{name}");
        let CameraState {
            pose,
            pinhole,
            name: picture,
            lens,
            ..
        } = path.at(frame as f64).expect("a frame");
        assert!(
            (pose.eye() - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-14,
            "{name}: {pose:?}"
        );
        assert!((pose.forward() - DVec3::NEG_X).length() < 1e-14, "{name}: {pose:?}");
        assert!((pose.up() - DVec3::Y).length() < 1e-14, "{name}: {pose:?}");
        seen.insert(
            name,
            (picture.unwrap_or_default(), pinhole.is_some(), lens.view.is_some()),
        );
        let Some(lens) = pinhole.filter(|lens| lens.size == Some([8.0, 6.0])) else {
            continue;
        };
        let view = Camera::new(&pose, &Lens::Pinhole(lens), [8, 6])
            .pinhole()
            .expect("no distortion");
        assert_eq!((view.focal, view.center), ([10.0, 11.0], [4.5, 3.25]), "{name}");
    }
    let of = |name: &str, has_pixels, has_view| (name.to_owned(), has_pixels, has_view);
    assert_eq!(seen["a.chan"], of("", false, true));
    assert_eq!(
        (&seen["a.tum"], &seen["a.txt"]),
        (&of("", false, false), &of("", false, false))
    );
    assert_eq!(
        (&seen["images.txt"], &seen["images.bin"]),
        (&of("a b 12.png", true, false), &of("a b 12.png", true, false))
    );
    assert_eq!(
        (&seen["a.json"], &seen["path.json"]),
        (&of("images/12.png", true, false), &of("", false, true))
    );
    assert_eq!(
        (&seen["a.gltf"], &seen["a.glb"]),
        (&of("c.12", false, true), &of("c.12", false, true))
    );
    assert_eq!(seen["a.yml"], of("", true, false));
}

#[test]
fn the_angles_of_chan_files_are_in_the_order_of_nuke_or_of_the_option() {
    let (folder, text) = (
        tempfile::tempdir().expect("a temporary folder"),
        "1 0 0 0 10 20 30\n4 0 0 0 10 20 30\n",
    );
    let file = folder.path().join("a.chan");
    fs::write(&file, text).expect("written");
    let pose = |order| {
        let options = CameraPathOptions {
            rotation_order: order,
            ..CameraPathOptions::default()
        };
        let path = load(&file, None, &options, &Files::default()).expect("a path");
        assert_eq!((path.frames(), path.pictures()), (1..=4, None));
        path.at(1.0).expect("a frame").pose.world_from_camera().matrix3
    };
    let degrees = DVec3::new(10.0, 20.0, 30.0);
    assert_eq!(pose(None), RotationOrder::Zxy.rotation(degrees));
    assert_eq!(pose(Some(RotationOrder::Xyz)), RotationOrder::Xyz.rotation(degrees));
}

/// Every prefix of every file, and every file with a byte changed, is read or refused.
#[test]
fn damaged_files_are_refused_without_a_panic() {
    let (mut read, mut refused) = (0, 0);
    for (name, bytes, beside) in files() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        let all: Vec<_> = std::iter::once((name, bytes)).chain(beside).collect();
        for (name, bytes) in &all {
            fs::write(path(name), bytes).expect("written");
        }
        let mut check = |name: &str, bytes: &[u8]| {
            let files = Files::default().with_supplied(Some((path(name), bytes.into())));
            match load(&path(all[0].0), None, &CameraPathOptions::default(), &files) {
                Ok(_) => read += 1,
                Err(error) => {
                    refused += 1;
                    let folder = folder.path().display().to_string();
                    assert!(error.to_string().starts_with(&folder), "{error}");
                }
            }
        };
        for (name, bytes) in &all {
            for end in 0..bytes.len() {
                check(name, &bytes[..end]);
            }
            for i in 0..bytes.len() {
                for value in [0, b'-', b'9', b'e', b'[', b'"', 0xff] {
                    let mut changed = bytes.clone();
                    changed[i] = value;
                    check(name, &changed);
                }
            }
        }
    }
    assert!(read > 1000 && refused > 5000, "{read} and {refused}");
}

/// Converts a file in a folder to another name there.
fn converted(folder: &Path, from: &str, to: &str, settings: &Conversion) -> Converted {
    let (from, to) = (folder.join(from), folder.join(to));
    let converted = convert(&from, &to, settings, &Files::default()).unwrap_or_else(|error| panic!("{error}"));
    for (path, bytes) in &converted.files {
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, bytes).expect("written");
    }
    converted
}

/// Cameras around a point with lenses of their own, as `transforms.json`.
fn around(model: &str, coefficients: &str) -> String {
    let frame = |i: u32| {
        let (sin, cos) = libm::sincos(f64::from(i) * 0.9);
        format!(
            r#"{{"file_path": "f_{:03}.png", "fl_x": {}, "transform_matrix": [[{cos}, 0, {sin}, {}], [0, 1, 0, {}], [{}, 0, {cos}, 7.1]]}}"#,
            3 * i + 5,
            10 + i,
            0.1 + f64::from(i),
            1.0 / 3.0,
            -sin,
        )
    };
    let frames: Vec<String> = (0..5).map(frame).collect();
    format!(
        r#"{{"w": 8, "h": 6, "fl_y": 11, "cx": 4.4, "cy": 3.3, "camera_model": "{model}"{coefficients}, "frames": [{}]}}"#,
        frames.join(", ")
    )
}

fn cameras(path: &Path) -> Vec<still::Still> {
    let path = load(path, None, &CameraPathOptions::default(), &Files::default()).expect("a path");
    let frames: Vec<i64> = path.keys().map(|frame| frame as i64).collect();
    still::stills(&path, frames, None).expect("cameras")
}

#[test]
fn numbers_come_back_from_every_format_that_holds_them() {
    let models = [
        ("PINHOLE", ""),
        ("OPENCV", r#", "k1": -0.1, "k2": 0.02, "p1": 0.001, "p2": -0.002"#),
        ("OPENCV", r#", "k1": -0.1, "k3": 0.02"#),
        (
            "OPENCV_FISHEYE",
            r#", "k1": 0.1, "k2": 0.02, "k3": 0.001, "k4": -0.002"#,
        ),
    ];
    for (model, coefficients) in models {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a.json"), around(model, coefficients)).expect("written");
        let own = cameras(&path("a.json"));
        assert_eq!(
            own.iter().map(|camera| camera.frame).collect::<Vec<_>>(),
            [5, 8, 11, 14, 17]
        );
        for (name, keeps_lens) in [
            ("b.json", true),
            ("m/images.bin", true),
            ("n/images.txt", true),
            ("o", true),
            ("c.tum", false),
            ("c.chan", false),
            ("c.gltf", false),
            ("c.glb", false),
            ("c.csv", true),
        ] {
            if model == "OPENCV_FISHEYE" && !keeps_lens && name != "c.tum" {
                // A fisheye has no angle of view.
                let refused = convert(&path("a.json"), &path(name), &Conversion::default(), &Files::default());
                assert!(
                    refused.is_err_and(|error| error.to_string().contains("fisheye")),
                    "{name}"
                );
                continue;
            }
            let lost = converted(folder.path(), "a.json", name, &Conversion::default()).lost;
            assert_eq!(lost.is_none(), keeps_lens, "{name}: {lost:?}");
            let again = cameras(&path(name));
            assert_eq!(again.len(), own.len(), "{name}");
            for (a, b) in own.iter().zip(&again) {
                assert_eq!(a.frame, b.frame, "{name}");
                assert!(
                    (a.eye - b.eye).length() < 1e-12 && a.axes.abs_diff_eq(b.axes, 1e-12),
                    "{name}: {a:?} {b:?}"
                );
                if keeps_lens {
                    assert_eq!(a.name, b.name, "{name}");
                    assert!(
                        a.pixels.expect("a lens").is_near(&b.pixels.expect("a lens")),
                        "{name}: {a:?} {b:?}"
                    );
                } else if name != "c.tum" {
                    let [a, b] = [a, b].map(|camera| camera.fov.expect("an angle"));
                    assert!((a - b).abs() < 1e-9, "{name}: {a} and {b}");
                }
            }
        }
    }
}

#[test]
fn calibrations_hold_one_lens_and_all_of_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    for (count, coefficients) in [
        (5, "0.1, 0.2, 0.3, 0.4"),
        (8, "1, 2, 3, 4, 5, 6, 7, 8"),
        (12, "1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12"),
    ] {
        let head =
            "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   data: [ 10, 0.5, 4, 0, 11, 3, 0, 0, 1 ]\n";
        let poses = "extrinsic_parameters: !!opencv-matrix\n   rows: 2\n   cols: 6\n   data: [ 3, 0.1, 0.2, 1, 2, 3, 0, 0, 0, 0, 0, 0 ]\n";
        fs::write(
            path("a.yml"),
            format!("{head}distortion_coefficients: [ {coefficients} ]\n{poses}"),
        )
        .expect("written");
        assert_eq!(
            converted(folder.path(), "a.yml", "b.yaml", &Conversion::default()).lost,
            None
        );
        let text = fs::read_to_string(path("b.yaml")).expect("a text");
        assert!(text.contains(&format!("rows: {count}\n   cols: 1")), "{text}");
        for (a, b) in cameras(&path("a.yml")).iter().zip(&cameras(&path("b.yaml"))) {
            assert!(
                (a.eye - b.eye).length() < 1e-12 && a.axes.abs_diff_eq(b.axes, 1e-12),
                "{a:?} {b:?}"
            );
            assert!(a.pixels.expect("a lens").is_near(&b.pixels.expect("a lens")));
        }
    }
    fs::write(path("c.json"), around("PINHOLE", "")).expect("written");
    let refused = convert(
        &path("c.json"),
        &path("c.yml"),
        &Conversion::default(),
        &Files::default(),
    );
    let message = refused.map(|_| ()).unwrap_err().to_string();
    assert!(
        message.starts_with("opencv files have one lens, and that of frame 8 differs from that of frame 5"),
        "{message}"
    );
}

#[test]
fn keyframes_become_all_frames_with_lenses_in_pixels_of_the_size_that_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let header = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_x,shift_x,name\n";
    fs::write(
        folder.path().join("a.csv"),
        format!("{header}1,0,0,5,0,0,0,90,0.25,wide\n4,3,0,5,3,0,0,90,0.25,\n"),
    )
    .expect("written");
    let settings = Conversion {
        resolution: Some([8, 4]),
        ..Conversion::default()
    };
    assert_eq!(converted(folder.path(), "a.csv", "b.json", &settings).frames, 4);
    let all = cameras(&folder.path().join("b.json"));
    for (i, camera) in all.iter().enumerate() {
        assert!((camera.eye.x - i as f64).abs() < 1e-12, "{camera:?}");
    }
    let lens = all[0].pixels.expect("a lens");
    assert!((lens.focal[0] - 4.0).abs() < 1e-12 && (lens.focal[1] - 4.0).abs() < 1e-12);
    assert_eq!((lens.center, lens.size), ([Some(2.0), Some(2.0)], Some([8.0, 4.0])));
    // The name of a shot is none of a picture.
    assert_eq!(all[0].name.as_deref(), Some("0001.png"));
    assert_eq!(converted(folder.path(), "a.csv", "c.csv", &settings).lost, None);
    let text = fs::read_to_string(folder.path().join("c.csv")).expect("a text");
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(rows[0], "frame,eye_x,eye_y,eye_z,qx,qy,qz,qw,fov,shift_x,shift_y");
    // 90 degrees over a picture twice as wide as high.
    assert!(rows[1].starts_with("1,0,0,5,0,0,0,1,53.1301023541559"), "{text}");
    assert!(rows[1].ends_with(",0.25,0"), "{text}");
    // Lenses in pixels stay in pixels.
    assert_eq!(converted(folder.path(), "b.json", "d.csv", &settings).lost, None);
    let text = fs::read_to_string(folder.path().join("d.csv")).expect("a text");
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(
        rows[0],
        "frame,eye_x,eye_y,eye_z,qx,qy,qz,qw,fx,fy,cx,cy,skew,width,height,k1,k2,p1,p2,k3,k4,k5,k6,s1,s2,s3,s4,name"
    );
    assert!(
        rows[1].ends_with(",2,2,0,8,4,0,0,0,0,0,0,0,0,0,0,0,0,\"0001.png\""),
        "{text}"
    );
}
