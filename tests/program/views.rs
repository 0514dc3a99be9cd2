//! Views around a scene, for sets of training pictures.

use crate::common::{Folder, repo_str};
use glam::DVec3;

/// A box that is no cube and is not at the origin, and a ball that the camera does not see.
const SCENE: &str = "[render]\nwidth = 40\nheight = 30\nsamples = 1\n\
    [camera]\nperspective = { eye = [1, 3, 14], target = [1, 3, 5], fov = 40 }\n\
    [background]\ncolor = [0.2, 0.4, 0.6]\n[material.m]\nmatte = { albedo = 0.5 }\n\
    [[light]]\npoint = { position = [4, 9, 9], intensity = 50 }\n\
    [[object]]\nmaterial = \"m\"\nshape.cuboid = { min = [0, 2, 4.5], max = [2, 4, 5.5] }\n\
    [[object]]\nmaterial = \"m\"\nvisible = false\nshape.sphere = { center = [50, 0, 0], radius = 1 }\n";

/// The same without the ball.
fn alone() -> String {
    let end = SCENE.rfind("[[object]]").expect("two objects");
    SCENE[..end].to_owned()
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SCENE);
    folder.write("alone.toml", &alone());
    folder
}

fn frames(folder: &Folder, name: &str) -> Vec<serde_json::Value> {
    let text = String::from_utf8(folder.read(name)).expect("UTF-8");
    let whole: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    whole["frames"].as_array().expect("frames").clone()
}

/// A column of the matrix from the camera to the world: right, up, backwards and the eye.
fn column(frame: &serde_json::Value, c: usize) -> DVec3 {
    let at = |r: usize| frame["transform_matrix"][r][c].as_f64().expect("a number");
    DVec3::new(at(0), at(1), at(2))
}

#[test]
fn the_transforms_of_all_views_see_the_box_at_the_wanted_share_of_the_picture() {
    let folder = folder();
    folder.succeed(&[
        "s.toml",
        "--views",
        "orbit:3@30,hemisphere:4",
        "--views",
        "sphere:5,cube",
        "--fit",
        "0.8",
        "-o",
        "f.##.png",
        "--metadata",
        "transforms",
    ]);
    let frames = frames(&folder, "transforms.json");
    assert_eq!(frames.len(), 3 + 4 + 5 + 6);
    for (i, frame) in frames.iter().enumerate() {
        assert_eq!(frame["file_path"], format!("f.{:02}.png", i + 1));
        let number = |name: &str| frame[name].as_f64().expect("a number");
        let mut largest = 0.0_f64;
        for corner in 0..8 {
            let side = |axis: usize, ends: [f64; 2]| ends[corner >> axis & 1];
            let p = DVec3::new(side(0, [0.0, 2.0]), side(1, [2.0, 4.0]), side(2, [4.5, 5.5])) - column(frame, 3);
            let depth = -p.dot(column(frame, 2));
            assert!(depth > 0.0);
            let u = number("fl_x") * p.dot(column(frame, 0)) / depth / number("cx");
            let v = number("fl_y") * p.dot(column(frame, 1)) / depth / number("cy");
            largest = largest.max(u.abs()).max(v.abs());
        }
        assert!((largest - 0.8).abs() < 1e-9, "{i}: {largest}");
    }
}

/// A cube that fills the square pictures of a camera at 90 degrees whose eye is one edge from its middle.
#[test]
fn an_orbit_at_its_own_distance_is_a_turntable() {
    let folder = Folder::new();
    let cube = alone()
        .replace("height = 30", "height = 40")
        .replace("eye = [1, 3, 14]", "eye = [1, 3, 7]")
        .replace("fov = 40", "fov = 90")
        .replace(
            "min = [0, 2, 4.5], max = [2, 4, 5.5]",
            "min = [0, 2, 4], max = [2, 4, 6]",
        );
    folder.write("s.toml", &cube);
    let run = |flags: &[&str]| {
        folder.succeed(&[&["s.toml", "--metadata", "transforms"], flags].concat());
    };
    run(&["--views", "orbit:4", "--fit", "1", "-o", "v/f.#.exr"]);
    run(&["--turntable", "4", "-o", "t/f.#.exr"]);
    let [views, turns] = ["v", "t"].map(|of| frames(&folder, &format!("{of}/transforms.json")));
    let pixels = |name: &str| {
        let image = folder.open_exr(name);
        let channels = image.layer_data[0].channel_data.list.iter();
        channels
            .map(|channel| channel.sample_data.values_as_f32().map(f32::to_bits).collect())
            .collect::<Vec<Vec<u32>>>()
    };
    for i in 0..4 {
        for c in 0..4 {
            let (view, turn) = (column(&views[i], c), column(&turns[i], c));
            assert!(view.distance(turn) < 1e-14, "{i}: {view} and {turn}");
        }
        let name = format!("f.{}.exr", i + 1);
        assert_eq!(pixels(&format!("v/{name}")), pixels(&format!("t/{name}")), "{i}");
    }
}

#[test]
fn parts_and_a_continued_job_have_the_files_of_the_whole_one() {
    let folder = folder();
    let job = |views: &str, out: &str, more: &[&str]| {
        let args = ["s.toml", "--views", views, "-o", out, "--skip-existing"];
        folder.succeed(&[&args[..], more].concat())
    };
    job("sphere:6,cube", "whole/f.##.exr", &[]);
    job("sphere:6,cube", "f/f.##.exr", &["--part", "2/3"]);
    assert_eq!(crate::common::names(&folder.path("f")).len(), 4);
    job("sphere:6,cube", "f/f.##.exr", &["--range", "1-3"]);
    job("sphere:6,cube", "f/f.##.exr", &[]);
    for i in 1..=12 {
        let [a, b] = ["whole", "f"].map(|of| folder.read(&format!("{of}/f.{i:02}.exr")));
        assert_eq!(a, b, "{i}");
    }
    let stale = |views: &str, more: &[&str]| {
        let args = ["s.toml", "--views", views, "-o", "f/f.##.exr", "--list-stale"];
        folder.succeed(&[&args[..], more].concat()).lines().count()
    };
    assert_eq!(stale("sphere:6,cube", &[]), 0);
    assert_eq!(stale("sphere:6,cube", &["--fit", "0.5"]), 12);
    // The axes are where they were.
    assert_eq!(stale("hemisphere:6,cube", &[]), 6);
}

/// Slurm runs on Unix alone: a folder with backslashes is refused.
#[cfg(unix)]
#[test]
fn a_farm_renders_views_in_tasks() {
    let folder = folder();
    let submit = [
        "submit", "--engine", "slurm", "--bundle", "job", "--chunk", "2", "s.toml",
    ];
    folder.succeed(&[&submit[..], &["--views", "orbit:4@20,cube", "-o", "f.##.png"]].concat());
    let script = String::from_utf8(folder.read("job/frames.sbatch")).expect("UTF-8");
    assert!(
        script.contains("orbit:4@20,cube") && script.contains("--array=1-5"),
        "{script}"
    );
}

#[test]
fn views_of_a_model_see_it_from_all_sides_and_ignore_its_ground() {
    let folder = Folder::new();
    let cube = repo_str("scenes/cube/cube.obj");
    let flags = ["--views", "cube", "--resolution", "32x24", "--samples", "1", "-o"];
    folder.succeed(&[&[&*cube], &flags[..], &["plain/f.#.png", "--metadata", "transforms"]].concat());
    folder.succeed(
        &[
            &[&*cube],
            &flags[..],
            &["ground/f.#.png", "--metadata", "transforms", "--ground"],
        ]
        .concat(),
    );
    let [plain, ground] = ["plain", "ground"].map(|of| frames(&folder, &format!("{of}/transforms.json")));
    assert_eq!((plain.len(), &plain), (6, &ground));
}

#[test]
fn what_views_cannot_do_is_refused() {
    let folder = folder();
    let refused = |args: &[&str]| folder.fail(2, &[&["s.toml", "-o", "f.##.png"], args].concat());
    let message = refused(&["--views", "ring:4"]);
    assert!(
        message.contains("expected orbit:N, orbit:N@ELEVATION, hemisphere:N, sphere:N or cube"),
        "{message}"
    );
    let message = refused(&["--views", "cube", "--range", "7"]);
    assert!(
        message.contains("frame 7 is outside of the views, which are frames 1 to 6"),
        "{message}"
    );
    let message = refused(&["--views", "cube", "--fit", "1.5"]);
    assert!(
        message.contains("--fit: expected a number above 0 and at most 1, found 1.5"),
        "{message}"
    );
    let message = refused(&["--fit", "0.5"]);
    assert!(message.contains("--views"), "{message}");
    folder.write("s.toml", &SCENE.replace("fov = 40", "shift = [2, 0]"));
    let message = refused(&["--views", "cube"]);
    assert!(message.contains("--views: the lens is shifted so far"), "{message}");
    folder.write(
        "s.toml",
        &SCENE.replace("perspective", "fisheye").replace(", fov = 40", ""),
    );
    let message = refused(&["--views", "cube"]);
    assert!(
        message.contains("--views: only a perspective camera without distortion is moved"),
        "{message}"
    );
    folder.write("s.toml", SCENE);
    folder.write("c.csv", "frame,camera.perspective.eye.x\n1,1\n2,60\n");
    let message = folder.fail(
        65,
        &["s.toml", "-o", "f.##.png", "--views", "cube", "--values", "c.csv"],
    );
    assert!(
        message.contains("c.csv: camera.perspective.eye.x is set by the views"),
        "{message}"
    );
    let empty = SCENE.find("[[object]]").expect("an object");
    folder.write("s.toml", &SCENE[..empty]);
    let message = folder.fail(65, &["s.toml", "-o", "f.##.png", "--views", "cube"]);
    assert!(
        message.contains("--views: the scene has nothing with bounds: s.toml"),
        "{message}"
    );
}

#[test]
fn a_plan_by_itself_does_not_know_where_the_scene_of_views_is() {
    use batch_render::{
        assets::Files,
        batch::{Plan, Request, Views},
        describe::{Overrides, load},
    };
    let desc = load(std::path::Path::new("s.toml"), &Overrides::default(), |_| Ok(SCENE)).expect("a scene");
    let views = Views {
        sets: vec!["orbit:3".parse().expect("a set")],
        fit: 0.9,
    };
    let request = Request {
        views: Some(views),
        ..Request::default()
    };
    let error = Plan::new(&desc, &request, &Files::default()).expect_err("it is refused");
    assert!(
        error.to_string().contains("the bounds of the scene are not known"),
        "{error}"
    );
}
