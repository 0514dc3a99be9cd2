//! Jobs whose objects move while the shutter is open.

use crate::common::Folder;
use batch_render::{
    batch::{Job, Request},
    camera::Camera,
    describe::Overrides,
    film::Film,
    math::DVec3,
    render::Control,
};

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

/// A frame of the scene and the table in a folder, with a camera path, in a job that is not run.
fn film(folder: &Folder, path: Option<&str>, number: i32) -> Film {
    film_and_camera(folder, path, number).0
}

/// The same with the camera as the shutter opens.
fn film_and_camera(folder: &Folder, path: Option<&str>, number: i32) -> (Film, Camera) {
    let request = Request {
        overrides: Overrides::default().with("output.aovs", vec!["forward", "backward", "P"]),
        camera_path: path.map(|text| folder.write("path.csv", text)),
        ..Request::default()
    };
    let job = Job::open(&folder.path("s.toml"), &request).unwrap_or_else(|e| panic!("{e}"));
    let mut scenes = job.scenes(job.compile().unwrap_or_else(|e| panic!("{e}")));
    let index = job.plan.frames.iter().position(|frame| frame.number == number);
    let index = index.expect("a frame");
    let film = job.render_frame(&mut scenes, index, &Control::default());
    let camera = job.plan.frames[index].camera.camera(0.0);
    (film.unwrap_or_else(|e| panic!("{e}")), camera)
}

/// The motion vectors of the pixels that see something, with its place.
fn vectors<'a>(film: &'a Film, pass: &str) -> impl Iterator<Item = ([f32; 3], &'a [f32])> {
    let plane = |name: &str| film.plane(name).expect("a pass").values.chunks_exact(3);
    let pixels = film.beauty().iter().zip(plane(pass)).zip(plane("P"));
    let seen = pixels.filter(|((beauty, _), p)| beauty[3] > 0.9 && **p != [0.0; 3]);
    seen.map(|((_, vector), p)| ([vector[0], vector[1], vector[2]], p))
}

#[test]
fn motion_vectors_go_from_the_opening_of_a_shutter_to_the_next_ones_own_opening() {
    // Eight pixels a metre, and half a metre a frame.
    let folder = folder(
        &SCENE.replace("radius = 0.5", "radius = 1"),
        "frame,interp,object.ball.transform.translate.x\n0,linear,-1\n4,linear,1\n",
    );
    let openings = [0.0, -0.5, 0.4];
    let rows = (1..).zip(openings).map(|(frame, open)| {
        let close = open + 0.25;
        format!("{frame},0,0,5,0,0,0,{open},{close}\n")
    });
    let path = "frame,x,y,z,target_x,target_y,target_z,shutter_open,shutter_close\n".to_owned();
    let film = film(&folder, Some(&(path + &rows.collect::<String>())), 2);
    for (pass, frames) in [
        ("forward", 1.0 + openings[2] - openings[1]),
        ("backward", 1.0 + openings[1] - openings[0]),
    ] {
        assert!(vectors(&film, pass).count() > 50);
        for ([u, v, _], _) in vectors(&film, pass) {
            assert!((u - 4.0 * frames).abs() < 1e-3 && v.abs() < 1e-3, "{pass}: {u}, {v}");
        }
    }
}

#[test]
fn motion_vectors_follow_what_moves_while_other_objects_appear_and_vanish() {
    let other = "[[object]]\nname = \"other\"\nmaterial = \"lamp\"\nshape.sphere = { center = [0, 9, 0], radius = 0.5 }\n\
                 transform = { translate = [0, 0, 0] }\n[[object]]\nname = \"ball\"";
    let scene = SCENE
        .replace("shutter = [0, 0.5]", "")
        .replace("[[object]]\nname = \"ball\"", other);
    let folder = folder(
        &scene,
        "frame,interp,object.ball.transform.translate.x,object.other.visible,object.other.transform.translate.z\n\
         1,linear,-0.5,0,0\n2,linear,0,1,1\n3,linear,0.5,0,2\n",
    );
    let film = film(&folder, None, 2);
    for pass in ["forward", "backward"] {
        assert!(vectors(&film, pass).count() > 20);
        for ([u, v, _], _) in vectors(&film, pass) {
            assert!((u - 4.0).abs() < 1e-3 && v.abs() < 1e-3, "{pass}: {u}, {v}");
        }
    }
}

#[test]
fn motion_vectors_of_a_zoom_along_a_camera_path_have_the_lens_of_the_neighbours_own_time() {
    let scene = SCENE.replace(
        "orthographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }",
        "perspective = { eye = [0, 0, 5], target = [0, 0, 0], fov = 40 }",
    );
    let scene = scene.replace("radius = 0.5", "radius = 1.2");
    let folder = folder(
        &scene,
        "frame,interp,camera.perspective.fov\n1,linear,30\n3,linear,50\n5,linear,20\n",
    );
    let row = |frame| format!("{frame},0,0,5,0,0,0\n");
    let path = format!("frame,x,y,z,target_x,target_y,target_z\n{}{}", row(1), row(5));
    let fov = |frame: f64| {
        if frame < 3.0 {
            20.0 + 10.0 * frame
        } else {
            95.0 - 15.0 * frame
        }
    };
    // Pixels for a slope of one, at the time in frames.
    let scale = |frame: f64| 16.0 / libm::tan(fov(frame).to_radians() / 2.0);
    for (shutter, number) in [("[0, 0]", 2), ("[0.25, 0.25]", 2), ("[0, 0]", 3), ("[0, 0.5]", 4)] {
        let scene = scene.replace("shutter = [0, 0.5]", &format!("shutter = {shutter}"));
        folder.write("s.toml", &scene);
        let opens = f64::from(number) + if shutter.starts_with("[0.25") { 0.25 } else { 0.0 };
        let film = film(&folder, Some(&path), number);
        for (pass, from, to) in [("forward", opens, opens + 1.0), ("backward", opens - 1.0, opens)] {
            assert!(vectors(&film, pass).count() > 50);
            for ([u, v, _], p) in vectors(&film, pass) {
                let slope = |at: f32| f64::from(at) / (5.0 - f64::from(p[2]));
                let expected = [p[0], p[1]].map(|at| slope(at) * (scale(to) - scale(from)));
                let off = (f64::from(u) - expected[0]).hypot(f64::from(v) - expected[1]);
                assert!(off < 0.01, "{shutter} {number} {pass}: {u}, {v} is not {expected:?}");
            }
        }
    }
}

/// A triangle whose morph target has the whole weight after a second, and none at first.
const MORPH: &str = r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 88, "uri": "m.bin"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 36},
    {"buffer": 0, "byteOffset": 72, "byteLength": 8}, {"buffer": 0, "byteOffset": 80, "byteLength": 8}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1.5, 1, 0]},
    {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
    {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
    {"bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}]}], "weights": [0]}],
    "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0,
    "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
    "samplers": [{"input": 2, "output": 3}]}]}"#;
const CORNERS: [[f32; 3]; 3] = [[-1.0, -1.0, 0.0], [1.5, -0.8, 0.0], [0.0, 1.0, 0.0]];
const SHIFTS: [[f32; 3]; 3] = [[3.0, 0.5, 2.0], [-2.0, 1.0, -3.0], [0.5, -2.0, 1.0]];

/// The corners of the triangle at a time in frames, which turns by 10 degrees and grows by a tenth in each frame from the eighth on.
fn corners(frame: f64) -> [DVec3; 3] {
    let (sin, cos) = (
        libm::sin((10.0 * (frame - 8.0)).to_radians()),
        libm::cos((10.0 * (frame - 8.0)).to_radians()),
    );
    std::array::from_fn(|k| {
        let at = |c: usize| f64::from(CORNERS[k][c]) + frame / 24.0 * f64::from(SHIFTS[k][c]);
        let [x, y, z] = [0, 1, 2].map(|c| (1.0 + 0.1 * (frame - 8.0)) * at(c));
        DVec3::new(x * cos - y * sin, x * sin + y * cos, z)
    })
}

#[test]
fn motion_vectors_of_a_triangle_that_morphs_turns_and_grows_land_where_its_corners_say_with_every_camera() {
    let numbers = CORNERS.iter().chain(&SHIFTS).flatten().chain(&[0.0, 1.0, 0.0, 1.0]);
    let bytes: Vec<u8> = numbers.flat_map(|number| number.to_le_bytes()).collect();
    let table =
        "frame,interp,object.ball.transform.rotate.z,object.ball.transform.scale\n0,linear,-80,0.2\n16,linear,80,1.8\n";
    let own = "orthographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }";
    for camera in [
        own,
        "perspective = { eye = [0.3, 0.2, 4], target = [0, 0, 0], fov = 45 }",
        "panorama = { eye = [0.1, 0.2, 2], target = [0, 0, 0] }",
        "fisheye = { eye = [0.1, 0.2, 2], target = [0, 0, 0], fov = 200 }",
    ] {
        let scene = SCENE
            .replace(own, camera)
            .replace("[0, 0.5]", "[0, 0]")
            .replace(
                "shape.sphere = { radius = 0.5 }",
                "shape.mesh = { file = \"m.gltf\", animation = \"all\" }",
            )
            .replace("translate = [0, 0, 0]", "rotate = [0, 0, 0], scale = 1");
        let folder = folder(&scene, table);
        folder.write("m.gltf", MORPH);
        std::fs::write(folder.path("m.bin"), &bytes).expect("writable");
        let (film, eye) = film_and_camera(&folder, None, 8);
        let (posed, mut seen) = (corners(8.0), 0);
        let [side, other] = [posed[1] - posed[0], posed[2] - posed[0]];
        for (pass, from, to) in [("forward", 8.0, 9.0), ("backward", 7.0, 8.0)] {
            for ([u, v, z], p) in vectors(&film, pass) {
                // The barycentric coordinates of the point that the pixel sees.
                let p = DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2])) - posed[0];
                let normal = side.cross(other);
                let s = p.cross(other).dot(normal) / normal.length_squared();
                let t = side.cross(p).dot(normal) / normal.length_squared();
                let at = |frame: f64| {
                    let [a, b, c] = corners(frame);
                    eye.project(a * (1.0 - s - t) + b * s + c * t).expect("it is seen")
                };
                let expected = at(to) - at(from);
                let apart = (f64::from(u) - expected.x).hypot(f64::from(v) + expected.y);
                assert!(apart < 0.01, "{camera} {pass}: {u}, {v} is not {expected}");
                assert!(
                    (f64::from(z) - expected.z).abs() < 1e-3,
                    "{camera} {pass}: {z} is not {expected}"
                );
                seen += usize::from(expected.x.hypot(expected.y) > 0.3);
            }
        }
        assert!(seen > 8, "{camera}: {seen}");
    }
}

#[test]
fn a_zoom_along_a_camera_path_is_blurred_over_its_own_shutter() {
    let scene = SCENE.replace(
        "orthographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }",
        "perspective = { eye = [0, 0, 5], target = [0, 0, 0], fov = 40 }",
    );
    let table = "frame,interp,camera.perspective.fov\n1,linear,20\n3,linear,60\n";
    let path = "frame,x,y,z,target_x,target_y,target_z\n1,0,0,5,0,0,0\n3,0,0,5,0,0,0\n";
    let folder = folder(&scene, table);
    let [along, own] = [Some(path), None].map(|path| film(&folder, path, 2));
    assert!(along.beauty() == own.beauty());
}

#[test]
fn a_frame_of_a_job_that_is_not_run_equals_the_one_in_its_file() {
    let folder = folder(SCENE, TABLE);
    folder.succeed(&JOB);
    for number in [2, 4, 7] {
        let (_, written) = crate::common::pixels(&folder.path(&format!("f.{number:04}.exr")));
        let film = film(&folder, None, number);
        let rgb = film.beauty().iter().map(|&[r, g, b, _]| [r, g, b]);
        assert!(rgb.eq(written), "{number}");
    }
}

#[test]
fn frames_of_any_time_limit_have_the_same_bits_and_are_told_from_those_without_one() {
    let scene = SCENE.replace("emitter = { radiance = 1 }", "emitter = { radiance = [0.1, 0.7, 1.3] }");
    let job = [&JOB[..], &["--range", "1-2", "--samples", "50"]].concat();
    let [hour, day] = ["1h", "24h"].map(|limit| {
        let folder = folder(&scene, TABLE);
        folder.succeed(&[&job[..], &["--time-limit", limit]].concat());
        folder
    });
    for frame in ["f.0001.exr", "f.0002.exr"] {
        assert!(hour.read(frame) == day.read(frame), "{frame}");
    }
    let said = hour.succeed(&[&job[..], &["--time-limit", "2h"]].concat());
    assert!(said.contains("0 frames rendered, 2 skipped"), "{said}");
    let said = hour.succeed(&job);
    assert!(said.contains("2 frames rendered"), "{said}");
    // A frame that rests has all its samples in one order.
    let still = folder(&scene.replace("shutter = [0, 0.5]\n", ""), TABLE);
    still.succeed(&[&job[..], &["--time-limit", "1h"]].concat());
    let said = still.succeed(&job);
    assert!(said.contains("0 frames rendered, 2 skipped"), "{said}");
}
