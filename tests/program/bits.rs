//! The same bits: whatever the threads, the crop, the chunks and the accelerator.

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE};

fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder
}

#[test]
fn one_two_and_seven_threads_write_the_same_files() {
    let folder = prepared();
    for threads in ["1", "2", "7"] {
        let (exr, png) = (format!("t{threads}.####.exr"), format!("t{threads}.####.png"));
        folder.succeed(&["s.toml", "--threads", threads, "-o", &exr, "-o", &png]);
    }
    for threads in [2, 7] {
        for ending in ["exr", "png"] {
            let same = folder.read(&format!("t{threads}.0001.{ending}")) == folder.read(&format!("t1.0001.{ending}"));
            assert!(same, "{threads} threads, {ending}");
        }
    }
}

#[test]
fn frames_rendered_in_chunks_equal_the_whole_sequence() {
    let folder = prepared();
    folder.succeed(&["s.toml", "--frames", "path.csv", "-o", "whole.####.exr"]);
    for range in ["5", "1-2", "3-4"] {
        folder.succeed(&[
            "s.toml",
            "--frames",
            "path.csv",
            "--range",
            range,
            "-o",
            "part.####.exr",
        ]);
    }
    for frame in 1..=5 {
        let same = folder.read(&format!("part.{frame:04}.exr")) == folder.read(&format!("whole.{frame:04}.exr"));
        assert!(same, "frame {frame}");
    }
}

/// The content of an EXR: where its data window lies, and R, G, B, A of each pixel.
struct Pixels {
    corner: (i32, i32),
    size: (usize, usize),
    rgba: Vec<[f32; 4]>,
}

fn pixels(bytes: &[u8]) -> Pixels {
    use exr::prelude::*;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.width(), vec![[0.0_f32; 4]; size.area()]),
            |(width, pixels), at, (r, g, b, a): (f32, f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b, a],
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .expect("an EXR with R, G, B and A");
    let layer = &image.layer_data;
    let corner = layer.attributes.layer_position;
    Pixels {
        corner: (corner.x(), corner.y()),
        size: (layer.size.width(), layer.size.height()),
        rgba: layer.channel_data.pixels.1.clone(),
    }
}

/// Asserts that the scene file `s.toml` has the same pixels in a crop as in the full picture.
fn assert_a_crop_has_the_same_pixels(folder: &Folder) {
    folder.succeed(&["s.toml", "-o", "full.exr"]);
    folder.succeed(&["s.toml", "--crop", "13,7,46,31", "-o", "crop.exr"]);
    let full = pixels(&folder.read("full.exr"));
    let crop = pixels(&folder.read("crop.exr"));
    assert_eq!((crop.corner, crop.size), ((13, 7), (33, 24)));
    for y in 0..24 {
        for x in 0..33 {
            assert_eq!(
                crop.rgba[y * 33 + x],
                full.rgba[(y + 7) * full.size.0 + x + 13],
                "pixel {x} {y}"
            );
        }
    }
}

#[test]
fn a_crop_has_the_pixels_of_the_full_picture() {
    assert_a_crop_has_the_same_pixels(&prepared());
}

/// A smooth ball of metal without texture coordinates, among surfaces that have derivatives, tangents and curvature.
const SMOOTH_METAL: &str = r#"
[render]
width = 70
height = 50
samples = 8
[camera]
perspective = { eye = [0, 1, 6], target = [0, 0, 0], fov = 40 }
[background]
color = [0.3, 0.4, 0.5]
[texture.board]
checker = { a = [0.9, 0.1, 0.1], b = [0.1, 0.1, 0.9], scale = 4 }
[material.board]
matte = { albedo = "texture.board" }
[material.metal]
metal = { color = [0.9, 0.8, 0.4], roughness = 0.3 }
[[object]]
material = "metal"
shape.mesh = { file = "ball.obj" }
[[object]]
material = "board"
shape.mesh = { file = "floor.obj" }
[[object]]
material = "board"
shape.sphere = { center = [1.5, 0, 0.5], radius = 0.6 }
[[light]]
point = { position = [3, 4, 5], intensity = 60 }
"#;

/// An OBJ file of a unit ball with normals and without texture coordinates.
fn smooth_ball() -> String {
    use std::{f64::consts::PI, fmt::Write};
    let (rows, columns) = (12_usize, 24_usize);
    let mut obj = String::new();
    for (row, column) in (0..=rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let (theta, phi) = (PI * row as f64 / rows as f64, 2.0 * PI * column as f64 / columns as f64);
        let (radius, y) = (libm::sin(theta), libm::cos(theta));
        let (x, z) = (radius * libm::cos(phi), radius * libm::sin(phi));
        writeln!(obj, "v {x} {y} {z}\nvn {x} {y} {z}").expect("a string");
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let a = row * columns + column + 1;
        let b = row * columns + (column + 1) % columns + 1;
        let (c, d) = (a + columns, b + columns);
        writeln!(obj, "f {a}//{a} {b}//{b} {d}//{d} {c}//{c}").expect("a string");
    }
    obj
}

#[test]
fn a_surface_without_texture_coordinates_has_the_same_pixels_whatever_was_hit_before() {
    let folder = Folder::new();
    folder.write("s.toml", SMOOTH_METAL);
    folder.write("ball.obj", &smooth_ball());
    folder.write(
        "floor.obj",
        "v -5 -1 -5\nv 5 -1 -5\nv 5 -1 5\nv -5 -1 5\nvt 0 0\nvt 3 0\nvt 2 4\nvt 0 1\nf 1/1 4/4 3/3 2/2\n",
    );
    assert_a_crop_has_the_same_pixels(&folder);
}

#[test]
fn rays_that_passed_a_surface_leave_nothing_to_those_of_the_next_tile() {
    let folder = Folder::new();
    folder.write(
        "s.toml",
        r#"
[render]
width = 70
height = 50
samples = 8
[camera]
perspective = { eye = [0, 0, 5], target = [0, 0, 0], fov = 40 }
[background]
color = [0.5, 0.7, 1]
[material.veil]
principled = { base_color = 1, opacity = 0.5, transmission = 1, thickness = 1, attenuation_color = [0.3, 0.9, 0.4], attenuation_distance = 0.5 }
[[object]]
material = "veil"
shape.sphere = { center = [0, 0, 0], radius = 1 }
"#,
    );
    assert_a_crop_has_the_same_pixels(&folder);
}

#[test]
fn every_accelerator_writes_the_same_file() {
    let folder = prepared();
    for accel in ["linear", "bvh2", "wide"] {
        folder.succeed(&["s.toml", "--accel", accel, "-o", &format!("{accel}.exr")]);
    }
    for accel in ["bvh2", "wide"] {
        assert!(
            folder.read(&format!("{accel}.exr")) == folder.read("linear.exr"),
            "{accel}"
        );
    }
}

#[test]
fn another_seed_gives_other_noise() {
    let folder = prepared();
    folder.succeed(&["s.toml", "-o", "a.png"]);
    folder.succeed(&["s.toml", "--seed", "8", "-o", "b.png"]);
    assert!(folder.read("a.png") != folder.read("b.png"));
}

#[test]
fn the_noise_of_a_sequence_moves_unless_its_seed_is_fixed() {
    let folder = prepared();
    let still = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,2,6,0,0.8,0\n2,0,2,6,0,0.8,0\n";
    folder.write("still.csv", still);
    folder.write(
        "fixed.toml",
        &SMALL_SCENE.replace("seed = 7", "seed = 7\nseed_mode = \"fixed\""),
    );
    let same = |scene: &str, more: &[&str]| {
        let args = [&[scene, "--frames", "still.csv", "-o", "f.####.exr"], more].concat();
        folder.succeed(&args);
        pixels(&folder.read("f.0001.exr")).rgba == pixels(&folder.read("f.0002.exr")).rgba
    };
    assert!(!same("s.toml", &[]));
    assert!(same("s.toml", &["--seed-mode", "fixed"]));
    assert!(same("fixed.toml", &[]));
    assert!(!same("fixed.toml", &["--seed-mode", "frame"]));
}

#[test]
fn the_sampler_is_the_scenes_choice_and_sobol_the_default() {
    let folder = prepared();
    for name in ["sobol", "independent"] {
        let scene = SMALL_SCENE.replace("seed = 7", &format!("seed = 7\nsampler = \"{name}\""));
        folder.write("chosen.toml", &scene);
        folder.succeed(&["chosen.toml", "-o", &format!("{name}.exr")]);
    }
    folder.succeed(&["s.toml", "-o", "default.exr"]);
    let [default, a, b] = ["default.exr", "sobol.exr", "independent.exr"].map(|name| pixels(&folder.read(name)).rgba);
    assert!(default == a);
    assert!(a != b);
}

#[test]
fn an_open_shutter_blurs_what_moves_the_same_in_chunks_and_a_closed_one_nothing() {
    let folder = prepared();
    let rows = |shutter: &str| {
        let head = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,shutter_open,shutter_close\n";
        format!("{head}1,0,2,6,0,0.8,0,{shutter}\n5,2,2,5,0,0.8,0,{shutter}\n")
    };
    folder.write("open.csv", &rows("-0.25,0.25"));
    folder.write("closed.csv", &rows("0,0"));
    let render = |path: &str, range: &str, to: &str| {
        folder.succeed(&["s.toml", "--frames", path, "--range", range, "-o", to]);
    };
    render("open.csv", "1-5", "open.####.exr");
    render("open.csv", "3", "chunk.####.exr");
    render("closed.csv", "3", "closed.####.exr");
    render("path.csv", "3", "plain.####.exr");
    assert!(folder.read("chunk.0003.exr") == folder.read("open.0003.exr"));
    assert!(folder.read("closed.0003.exr") == folder.read("plain.0003.exr"));
    assert!(folder.read("open.0003.exr") != folder.read("plain.0003.exr"));
}

#[test]
fn outside_of_a_fisheyes_circle_the_picture_is_empty() {
    let folder = prepared();
    let camera = "\n[camera]\nfisheye = { eye = [0, 2, 6], target = [0, 0.8, 0] }\n";
    let lines: Vec<_> = SMALL_SCENE
        .lines()
        .filter(|l| !l.starts_with("[camera]") && !l.starts_with("perspective"))
        .collect();
    folder.write("fisheye.toml", &(lines.join("\n") + camera));
    folder.succeed(&["fisheye.toml", "-o", "f.exr", "-o", "f.png"]);
    let found = pixels(&folder.read("f.exr"));
    assert_eq!(found.rgba[0], [0.0; 4]);
    assert_eq!(found.rgba[25 * 70 + 35][3], 1.0);
    let png = image::load_from_memory(&folder.read("f.png")).expect("a PNG");
    assert_eq!(png.into_rgba8().get_pixel(0, 0).0, [0; 4]);
}
