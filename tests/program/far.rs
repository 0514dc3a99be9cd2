//! Scenes far from the world's origin look as they do at it.

use std::fmt::Write;

use crate::common::{Folder, pixels};
use batch_render::{
    accel::AccelKind,
    assets::Store,
    camera::{Camera, Lens, LookAt, Pose, perspective::PerspectiveLens},
    compile::{self, Instancing},
    describe,
    integrator::whitted::Whitted,
    math::{DVec3, Rgb},
    render::{self, Settings},
};

/// Places in whole metres: a hundred kilometres away, and in the coordinates of a map.
const FAR: [[i64; 3]; 2] = [[100_000, 0, -100_000], [431_250, 20, 5_649_830]];
const HOME: [i64; 3] = [0; 3];

/// Frames of a camera that moves by a millimetre.
const STEPS: usize = 10;

const HEAD: &str = "[render]\nwidth = 48\nheight = 36\nsamples = 8\nintegrator.path = { max_depth = 3 }\n\
                    [background]\ncolor = [0.2, 0.4, 0.8]\n[material.m]\nmatte = { albedo = 0.6 }\n";

/// A point that is `p` away from `place`, as scene files and tables write it: in decimal numbers that are exact.
fn point(place: [i64; 3], p: [f64; 3]) -> String {
    let decimals = |axis: usize| {
        let micrometres = place[axis] * 1_000_000 + (p[axis] * 1e6).round() as i64;
        let (sign, size) = (if micrometres < 0 { "-" } else { "" }, micrometres.unsigned_abs());
        format!("{sign}{}.{:06}", size / 1_000_000, size % 1_000_000)
    };
    format!("{}, {}, {}", decimals(0), decimals(1), decimals(2))
}

fn at(place: [i64; 3], p: [f64; 3]) -> String {
    format!("[{}]", point(place, p))
}

fn camera(place: [i64; 3], eye: [f64; 3], target: [f64; 3]) -> String {
    let (eye, target) = (at(place, eye), at(place, target));
    format!("[camera]\nperspective = {{ eye = {eye}, target = {target}, fov = 40 }}\n")
}

/// A small ball in front of the camera, lit by lamps.
fn ball(place: [i64; 3]) -> String {
    let [center, lamp, spot] = [[0.0, 0.0, 0.0], [0.3, 0.5, 0.4], [-0.4, 0.3, 0.4]].map(|p| at(place, p));
    format!(
        "[[object]]\nmaterial = \"m\"\nshape.sphere = {{ center = {center}, radius = 0.1 }}\n\
         [[light]]\npoint = {{ position = {lamp}, intensity = 0.5 }}\n\
         [[light]]\nspot = {{ position = {spot}, target = {center}, cone_angle = 10, intensity = 0.5 }}\n"
    )
}

/// A floor that reaches so far that the scene has no small box.
fn floor() -> &'static str {
    "[[object]]\nmaterial = \"m\"\n\
     shape.quad = { corners = [[-1e6, -0.125, 1e6], [1e6, -0.125, 1e6], [1e6, -0.125, -1e6], [-1e6, -0.125, -1e6]] }\n"
}

/// The largest difference of a channel.
fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    let channels = a.iter().flatten().zip(b.iter().flatten());
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// A sample on an edge may fall to either side: one pixel in 500 may differ.
#[track_caller]
fn assert_alike(a: &[[f32; 3]], b: &[[f32; 3]]) {
    let differ = |(a, b): &(&[f32; 3], &[f32; 3])| difference(&[**a], &[**b]) > 2e-3;
    let count = a.iter().zip(b).filter(differ).count();
    assert!(
        count * 500 <= a.len(),
        "{count} pixels differ, up to {}",
        difference(a, b)
    );
}

fn eye(step: usize) -> [f64; 3] {
    [step as f64 * 0.001, 0.05, 0.4]
}

/// The frames of a camera path past `scene`.
fn path_frames(place: [i64; 3], scene: &str) -> Vec<Vec<[f32; 3]>> {
    let mut table = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n".to_owned();
    for step in 0..STEPS {
        let [eye, target] = [eye(step), [eye(step)[0], 0.0, 0.0]].map(|p| point(place, p));
        writeln!(table, "{},{eye},{target}", step + 1).expect("memory takes all text");
    }
    let folder = Folder::new();
    folder.write("path.csv", &table);
    folder.write("s.toml", &format!("{HEAD}{scene}"));
    folder.succeed(&["s.toml", "--frames", "path.csv", "--progress", "none", "-o", "f.##.exr"]);
    let frame = |i: usize| pixels(&folder.path(&format!("f.{i:02}.exr"))).1;
    (1..=STEPS).map(frame).collect()
}

#[track_caller]
fn assert_moves(frames: &[Vec<[f32; 3]>]) {
    for (i, pair) in frames.windows(2).enumerate() {
        let found = difference(&pair[0], &pair[1]);
        assert!(found > 0.02, "frame {}: {found}", i + 2);
    }
}

#[test]
fn a_camera_that_moves_by_millimetres_at_a_hundred_kilometres_moves_in_every_frame() {
    let home = path_frames(HOME, &ball(HOME));
    assert_moves(&home);
    for place in FAR {
        let far = path_frames(place, &ball(place));
        assert_moves(&far);
        for (a, b) in home.iter().zip(&far) {
            assert_alike(a, b);
        }
    }
}

#[test]
fn over_ground_without_end_the_scene_is_precise_around_the_camera() {
    let place = FAR[0];
    let far = path_frames(place, &format!("{}{}", ball(place), floor()));
    assert_moves(&far);
    let home = path_frames(HOME, &format!("{}{}", ball(HOME), floor()));
    for (a, b) in home.iter().zip(&far) {
        assert_alike(a, b);
    }
    // Whichever frames are rendered, the scene is the same.
    let folder = Folder::new();
    let table = (0..STEPS).map(|i| format!("{},{},{}\n", i + 1, point(place, eye(i)), point(place, [0.0; 3])));
    let head = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n";
    folder.write("path.csv", &format!("{head}{}", table.collect::<String>()));
    folder.write("s.toml", &format!("{HEAD}{}{}", ball(place), floor()));
    for (range, name) in [("1-10", "a.##.exr"), ("7", "b.##.exr")] {
        folder.succeed(&[
            "s.toml",
            "--frames",
            "path.csv",
            "--range",
            range,
            "--progress",
            "none",
            "-o",
            name,
        ]);
    }
    assert_eq!(folder.read("a.07.exr"), folder.read("b.07.exr"));
}

#[test]
fn scene_files_place_cameras_and_objects_to_the_millimetre() {
    // Tiles of half a millimetre, a millimetre apart: as shapes, and moved there by a transform and by a matrix.
    let scene = |place: [i64; 3], step: usize| {
        let x = step as f64 * 0.001;
        let mut text = HEAD.to_owned() + &camera(place, [x, 0.0, 0.02], [x, 0.0, 0.0]);
        for i in -3..=3 {
            let x = f64::from(i) * 0.001;
            let [min, max, middle] =
                [[x, 0.0, 0.0], [x + 0.0005, 0.001, 0.001], [x, -0.001, 0.0]].map(|p| at(place, p));
            let rows: Vec<_> = point(place, [x, -0.003, 0.0]).split(", ").map(str::to_owned).collect();
            write!(
                text,
                "[[object]]\nmaterial = \"m\"\nshape.cuboid = {{ min = {min}, max = {max} }}\n\
                 [[object]]\nmaterial = \"m\"\nshape.sphere = {{ radius = 0.0004 }}\ntransform = {{ translate = {middle} }}\n\
                 [[object]]\nmaterial = \"m\"\nshape.cone = {{ radius = 1, height = 3 }}\ntransform = {{ matrix = \
                 [[0.0004, 0, 0, {}], [0, 0.0004, 0, {}], [0, 0, 0.0004, {}], [0, 0, 0, 1]] }}\n",
                rows[0], rows[1], rows[2]
            )
            .expect("memory takes all text");
        }
        text + "[[light]]\nsun = { direction = [1, -2, -2], irradiance = 2 }\n"
    };
    for step in [0, 1] {
        let home = Folder::new().render(&scene(HOME, step));
        assert!(difference(&home, &[home[0]; 48 * 36]) > 0.1);
        for place in [[1_000_000, 0, 1_000_000], FAR[1]] {
            assert_alike(&home, &Folder::new().render(&scene(place, step)));
        }
    }
}

#[test]
fn planar_textures_far_away_stay_where_they_were() {
    // Stripes of a centimetre on a shape and on a mesh.
    let picture = |place: [i64; 3]| {
        let folder = Folder::new();
        let vertex = |p: [f64; 3]| format!("v {}\n", point(place, p).replace(',', ""));
        let corners = [[-0.1, 0.1, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.0], [-0.1, 0.0, 0.0]];
        folder.write("m.obj", &(corners.map(vertex).concat() + "f 4 3 2 1\n"));
        let [from, to] =
            [[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]].map(|p| point(place, p).split(',').next().map(str::to_owned));
        let ramp = format!(
            "from = {}, to = {}",
            from.expect("three numbers"),
            to.expect("three numbers")
        );
        let [a, b, c, d] = [[0.0, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.0]].map(|p| at(place, p));
        let lamp = at(place, [0.0, 0.0, 0.5]);
        folder.render(&format!(
            "{HEAD}{}[texture.t]\nstripes = {{ a = [1, 0, 0], b = [0, 0, 1], width = 0.05 }}\n\
             mapping.planar = {{ s = {{ axis = \"x\", {ramp} }}, t = {{ axis = \"x\", {ramp} }} }}\n\
             [material.striped]\nmatte = {{ albedo = \"texture.t\" }}\n\
             [[object]]\nmaterial = \"striped\"\nshape.mesh = {{ file = \"m.obj\" }}\n\
             [[object]]\nmaterial = \"striped\"\nshape.quad = {{ corners = [{a}, {b}, {c}, {d}] }}\n\
             [[light]]\npoint = {{ position = {lamp}, intensity = 1 }}\n",
            camera(place, [0.0, 0.0, 0.4], [0.0; 3])
        ))
    };
    let home = picture(HOME);
    let reds = home.iter().filter(|p| p[0] > 2.0 * p[2]).count();
    assert!(reds > 50, "{reds}");
    for place in FAR {
        assert_alike(&home, &picture(place));
    }
}

/// Ten steps of 0.2 m, as an OBJ.
fn stairs(place: [i64; 3]) -> String {
    let mut text = String::new();
    for i in 0..=20_u32 {
        let (up, back) = (f64::from(i.div_ceil(2)) * 0.2, f64::from(i / 2) * -0.2);
        for x in [0.0, 1.0] {
            let p = point(place, [x, up, back]).replace(',', "");
            writeln!(text, "v {p}").expect("memory takes all text");
        }
        if i > 0 {
            writeln!(text, "f -4 -3 -1 -2").expect("memory takes all text");
        }
    }
    text
}

const STAIRS_VIEW: [[f64; 3]; 2] = [[2.5, 3.0, 3.0], [0.5, 1.0, -1.0]];

#[test]
fn an_obj_in_the_coordinates_of_a_map_looks_like_its_local_twin() {
    let picture = |model: [i64; 3], transform: &str, place: [i64; 3]| {
        let folder = Folder::new();
        folder.write("stairs.obj", &stairs(model));
        let [eye, target] = STAIRS_VIEW;
        let object = format!("[[object]]\nshape.mesh = {{ file = \"stairs.obj\" }}\n{transform}");
        let sun = "[[light]]\nsun = { direction = [0, -1, -0.4], irradiance = 3 }\n";
        folder.render(&format!("{HEAD}{}{object}{sun}", camera(place, eye, target)))
    };
    let home = picture(HOME, "", HOME);
    for place in FAR {
        assert_alike(&home, &picture(place, "", place));
        // The other way round, and there and back again.
        let forth = format!("transform = {{ translate = {} }}\n", at(place, [0.0; 3]));
        assert_alike(&home, &picture(HOME, &forth, place));
        let back = format!("transform = {{ translate = {} }}\n", at(place.map(|v| -v), [0.0; 3]));
        assert_alike(&home, &picture(place, &back, HOME));
    }
}

/// A square of a millimetre in the plane z = 0, in a format of text.
fn tile(format: &str, place: [i64; 3]) -> String {
    let corners = [[0.0, 0.0], [0.001, 0.0], [0.001, 0.001], [0.0, 0.001]];
    let corners = corners.map(|[x, y]| point(place, [x, y, 0.0]).replace(',', ""));
    let [a, b, c, d] = &corners;
    match format {
        "ply" => format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{a}\n{b}\n{c}\n{d}\n4 0 1 2 3\n"
        ),
        "stl" => {
            let facet = |corners: [&String; 3]| {
                let vertices = corners.map(|p| format!("vertex {p}\n")).concat();
                format!("facet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\n")
            };
            format!("solid tile\n{}{}endsolid tile\n", facet([a, b, c]), facet([a, c, d]))
        }
        "gltf" => {
            // The corners of a square of a metre as floats, two triangles, and the node that brings it to its place.
            let (corners, indices) = (
                "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAA",
                "AAABAAIAAAACAAMA",
            );
            let place = at(place, [0.0; 3]);
            format!(
                r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0, "translation": {place},
                "scale": [0.001, 0.001, 0.001]}}], "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
                "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}},
                {{"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}}],
                "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 1, "byteLength": 12}}],
                "buffers": [{{"byteLength": 48, "uri": "data:application/octet-stream;base64,{corners}"}},
                {{"byteLength": 12, "uri": "data:application/octet-stream;base64,{indices}"}}]}}"#
            )
        }
        _ => unreachable!("a format of this test"),
    }
}

#[test]
fn models_of_other_formats_keep_their_millimetres_in_the_coordinates_of_a_map() {
    for format in ["ply", "stl", "gltf"] {
        let picture = |place: [i64; 3]| {
            let folder = Folder::new();
            folder.write(&format!("tile.{format}"), &tile(format, place));
            let camera = camera(place, [0.0005, 0.0005, 0.002], [0.0005, 0.0005, 0.0]);
            folder.render(&format!(
                "{HEAD}{camera}[[object]]\nmaterial = \"m\"\nshape.mesh = {{ file = \"tile.{format}\" }}\n\
                 [[light]]\nsun = {{ direction = [0, 0, -1], irradiance = 3 }}\n"
            ))
        };
        let home = picture(HOME);
        assert!(difference(&home, &[home[0]; 48 * 36]) > 0.1, "{format}");
        for place in FAR {
            assert_alike(&home, &picture(place));
        }
    }
}

#[test]
fn a_model_in_the_coordinates_of_a_map_is_a_scene_as_its_local_twin_is() {
    let picture = |place: [i64; 3], more: &[&str]| {
        let folder = Folder::new();
        folder.write("stairs.obj", &stairs(place));
        let args = [
            "stairs.obj",
            "--resolution",
            "48x36",
            "--samples",
            "8",
            "--progress",
            "none",
        ];
        folder.succeed(&[&args[..], &["-o", "f.#.exr"], more].concat());
        pixels(&folder.path(&folder.names()[0])).1
    };
    assert_alike(&picture(HOME, &[]), &picture(FAR[1], &[]));
    let turn = ["--turntable", "8", "--range", "4"];
    assert_alike(&picture(HOME, &turn), &picture(FAR[1], &turn));
}

#[test]
fn instances_far_away_are_as_precise_as_copies() {
    let picture = |place: [i64; 3], instancing| {
        let folder = Folder::new();
        folder.write("stairs.obj", &stairs(place));
        let head = "[[object]]\nshape.mesh = { file = \"stairs.obj\" }\n";
        let moved = "transform = { translate = [0.3, 0.001, -0.5], scale = 1 }\n";
        let sun = "[[light]]\nsun = { direction = [0, -1, -0.4], irradiance = 3 }\n";
        let file = folder.write("s.toml", &format!("{head}{head}{moved}{sun}"));
        let desc = describe::load(&file, &batch_render::describe::Overrides::default(), std::fs::read).expect("sound");
        let store = Store::default();
        let scene = compile::scene_instancing(&desc, AccelKind::Wide, &store, instancing).expect("sound");
        let [eye, target] = STAIRS_VIEW.map(|p| DVec3::from(place.map(|v| v as f64)) + DVec3::from(p));
        let pose = Pose::look_at(eye, &LookAt::new(target)).expect("a pose");
        let camera = Camera::new(&pose, &Lens::Perspective(PerspectiveLens::vertical(40.0)), [48, 36]);
        let whitted = Whitted {
            max_depth: 1,
            ambient: Rgb::gray(0.1),
        };
        let film = render::render(&scene, &camera, &whitted, &Settings::new([48, 36], 8)).expect("a film");
        film.beauty()
            .iter()
            .map(|[r, g, b, _]| [*r, *g, *b])
            .collect::<Vec<_>>()
    };
    let home = picture(HOME, Instancing::Never);
    for place in FAR {
        for instancing in [Instancing::Never, Instancing::Always] {
            assert_alike(&home, &picture(place, instancing));
        }
    }
}
