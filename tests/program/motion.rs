//! Jobs whose objects move while the shutter is open.

use crate::common::Folder;

const SCENE: &str = r#"
values = "v.csv"
[render]
width = 48
height = 32
samples = 8
[camera]
orthographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }
shutter = [0, 0.5]
[material.lamp]
emitter = { radiance = 1 }
[[object]]
name = "ball"
material = "lamp"
shape.sphere = { radius = 0.5 }
transform = { translate = [0, 0, 0] }
"#;

const TABLE: &str =
    "frame,interp,object.ball.transform.translate.x\n1,linear,-2\n3,linear,2\n5,linear,2\n7,linear,-2\n";

const JOB: [&str; 8] = [
    "s.toml",
    "-o",
    "f.####.exr",
    "--skip-existing",
    "--exr-type",
    "float",
    "--aovs",
    "CryptoObject",
];

fn folder(scene: &str, table: &str) -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", scene);
    folder.write("v.csv", table);
    folder
}

/// The sum of the red light of a frame, and its mean column.
fn light(folder: &Folder, frame: u32) -> (f32, f32) {
    let (width, pixels) = crate::common::pixels(&folder.path(&format!("f.{frame:04}.exr")));
    let (mut sum, mut column) = (0.0, 0.0);
    for (i, [r, ..]) in pixels.into_iter().enumerate() {
        sum += r;
        column += r * ((i % width) as f32 + 0.5);
    }
    (sum, column / sum)
}

#[test]
fn a_table_blurs_an_object_over_the_shutter_of_the_scene() {
    let folder = folder(SCENE, TABLE);
    folder.succeed(&JOB);
    // A circle of four pixels' radius, in the middle of its way within the shutter: half a metre behind its place.
    let area = std::f32::consts::PI * 16.0;
    for (frame, column) in [(1, 12.0), (2, 28.0), (4, 40.0), (6, 20.0)] {
        let (sum, found) = light(&folder, frame);
        assert!((sum - area).abs() < 0.04 * area, "{frame}: {sum} is not {area}");
        assert!((found - column).abs() < 0.15, "{frame}: {found} is not {column}");
    }
}

#[test]
fn a_blurred_frame_has_the_same_bytes_alone_in_a_part_and_on_any_number_of_threads() {
    let whole = folder(SCENE, TABLE);
    whole.succeed(&JOB);
    let other = folder(SCENE, TABLE);
    other.succeed(&[&JOB[..], &["--range", "6", "--threads", "1"]].concat());
    other.succeed(&[&JOB[..], &["--part", "2/3", "--threads", "3"]].concat());
    for name in other.names().iter().filter(|name| name.ends_with(".exr")) {
        assert!(other.read(name) == whole.read(name), "{name}");
    }
    assert!(other.names().iter().filter(|name| name.ends_with(".exr")).count() >= 3);
}

#[test]
fn a_changed_row_concerns_the_frames_whose_shutters_see_it() {
    let folder = folder(SCENE, TABLE);
    folder.succeed(&JOB);
    let stale = |args: &[&str]| {
        let said = folder.succeed(&[&["s.toml", "--list-stale"], &JOB[1..3], &JOB[4..], args].concat());
        let first = |line: &str| line.split('\t').next().unwrap_or_default().to_owned();
        said.lines().map(first).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(stale(&[]), "");
    // The ball rests from 3 to 5; the last row moves it from 5 on, within the shutter of frame 5.
    folder.write("v.csv", &TABLE.replace("7,linear,-2", "7,linear,-1"));
    assert_eq!(stale(&[]), "5 6 7");
    assert_eq!(stale(&["--set", "camera.shutter=[-0.5, 0]"]), "1 2 3 4 5 6 7");
}
