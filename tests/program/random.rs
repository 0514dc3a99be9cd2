//! Values that are drawn at random for each frame.

use std::{
    io::{BufRead, BufReader},
    process::Stdio,
};

use crate::{common::Folder, values::SCENE};

/// The scene of tables of values, whose ball has a plain name.
fn scene() -> String {
    SCENE.replace("ball.001", "ball")
}

const RANDOM: &str = r#"
seed = 7
"light.key.point.intensity" = { log = [20, 200] }
"light.key.point.position" = { sphere = [3, 5], center = [0, 1, 0], upper = true }
"object.ball.material" = ["red", "gray"]
"object.ball.transform.translate.x" = { normal = [0, 0.4], min = -1, max = 1 }
"object.ball.shape.sphere.radius" = [0.5, 1]
"background.color" = [[0, 0, 0], [0.2, 0.3, 0.5]]
"camera.perspective.fov" = { integer = [30, 60] }
"#;

const JOB: [&str; 10] = [
    "s.toml",
    "-o",
    "f.####.exr",
    "--exr-type",
    "float",
    "--random",
    "r.toml",
    "--metadata",
    "transforms",
    "--skip-existing",
];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", &scene());
    folder.write("r.toml", RANDOM);
    folder
}

fn run(folder: &Folder, args: &[&str]) -> String {
    folder.succeed(&[&JOB[..], args].concat())
}

/// The frames of `transforms.json`.
fn transforms(folder: &Folder, name: &str) -> Vec<serde_json::Value> {
    let json: serde_json::Value = serde_json::from_slice(&folder.read(name)).expect("JSON");
    json["frames"].as_array().expect("frames").clone()
}

/// The values of each frame.
fn drawn(folder: &Folder) -> Vec<serde_json::Value> {
    let frames = transforms(folder, "transforms.json");
    frames.iter().map(|frame| frame["values"].clone()).collect()
}

/// The numbers of the frames that a job would render.
fn stale(folder: &Folder, args: &[&str]) -> String {
    let said = folder.succeed(&[&JOB[..9], args, &["--list-stale"]].concat());
    let first = |line: &str| line.split('\t').next().unwrap_or_default().to_owned();
    said.lines().map(first).collect::<Vec<_>>().join(" ")
}

/// Compares all pictures of a folder, and what they draw, with those of another.
fn assert_same(part: &Folder, whole: &Folder, what: &str) {
    let names: Vec<String> = part.names().into_iter().filter(|name| name.ends_with(".exr")).collect();
    assert!(!names.is_empty());
    for name in &names {
        assert!(part.read(name) == whole.read(name), "{what}: {name}");
    }
    let all = transforms(whole, "transforms.json");
    for frame in transforms(part, "transforms.json") {
        assert!(all.contains(&frame), "{what}: {frame}");
    }
}

#[test]
fn a_frame_draws_the_same_alone_in_any_order_on_any_threads_and_after_a_kill() {
    let whole = folder();
    run(&whole, &["--range", "1-4", "--threads", "2"]);
    let alone = folder();
    run(&alone, &["--range", "3", "--threads", "1"]);
    assert_same(&alone, &whole, "alone");
    let chunks = folder();
    for chunk in ["3", "1", "2", "4"] {
        run(&chunks, &["--range", chunk, "--threads", "1"]);
    }
    assert_same(&chunks, &whole, "chunks");
    assert_eq!(chunks.read("transforms.json"), whole.read("transforms.json"));
    let parts = folder();
    for part in ["2/2", "1/2"] {
        run(&parts, &["--range", "1-4", "--part", part]);
    }
    assert_same(&parts, &whole, "parts");
    let killed = folder();
    let mut child = killed
        .program()
        .args(JOB)
        .args(["--range", "1-4", "--progress", "plain"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    assert!(lines.any(|line| line.expect("a line").starts_with("wrote ")));
    child.kill().expect("killed");
    child.wait().expect("it has ended");
    run(&killed, &["--range", "1-4"]);
    assert_same(&killed, &whole, "after a kill");
    assert_eq!(killed.read("transforms.json"), whole.read("transforms.json"));
    let values = drawn(&whole);
    assert!((1..4).all(|frame| values[frame] != values[0]));
}

#[test]
fn a_frame_is_that_of_a_scene_with_the_values_that_the_side_file_tells() {
    let random = folder();
    run(&random, &["--range", "1-3", "--seed-mode", "fixed"]);
    for (frame, values) in drawn(&random).iter().enumerate() {
        let values = values.as_object().expect("values");
        assert_eq!(values.len(), 7);
        let set = values.iter().map(|(name, value)| format!("{name}={value}"));
        let set: Vec<String> = set.flat_map(|set| ["--set".to_owned(), set]).collect();
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let still = folder();
        // The ball is one that moves, which differs from one that rests by rounding.
        still.write(
            "v.csv",
            "frame,object.ball.transform.translate.y,background.visible\n1,1,true\n",
        );
        let args = ["--seed-mode", "fixed", "--values", "v.csv"];
        still.succeed(&[&JOB[..5], &args, &set].concat());
        let pixels = |folder: &Folder, name: &str| crate::common::pixels(&folder.path(name)).1;
        let name = format!("f.{:04}.exr", frame + 1);
        assert!(
            pixels(&random, &name) == pixels(&still, "f.0001.exr"),
            "frame {}",
            frame + 1
        );
    }
}

#[test]
fn pictures_tell_what_was_drawn() {
    let folder = folder();
    folder.succeed(&[&JOB[..9], &["-o", "f.####.png"]].concat());
    let expected = drawn(&folder)[0].clone();
    let image = folder.open_exr("f.0001.exr");
    let attributes = image
        .attributes
        .other
        .iter()
        .chain(&image.layer_data[0].attributes.other);
    let own = attributes.into_iter().find(|(name, _)| *name == "batch-render/values");
    let exr::meta::attribute::AttributeValue::Text(text) = own.expect("an attribute").1 else {
        panic!("no text")
    };
    let found: serde_json::Value = serde_json::from_str(&text.to_string()).expect("JSON");
    assert_eq!(found, expected);
    let png = String::from_utf8_lossy(&folder.read("f.0001.png")).into_owned();
    assert!(png.contains("batch-render/values") && png.contains("light.key.point.intensity"));
}

#[test]
fn a_dry_run_lists_what_each_frame_is_going_to_draw() {
    let folder = folder();
    let listed = folder
        .program()
        .args(JOB)
        .args(["--range", "2-4", "--dry-run"])
        .output()
        .expect("it runs");
    run(&folder, &["--range", "2-4"]);
    let listed = String::from_utf8(listed.stdout).expect("UTF-8");
    let frames: Vec<Vec<&str>> = listed.lines().map(|line| line.split('\t').collect()).collect();
    for (i, values) in drawn(&folder).iter().enumerate() {
        let [number, file, draws] = frames[i][..] else {
            panic!("{listed}")
        };
        assert_eq!((number, file), (&*(i + 2).to_string(), &*format!("f.{:04}.exr", i + 2)));
        assert_eq!(serde_json::from_str::<serde_json::Value>(draws).expect("JSON"), *values);
    }
    assert_eq!(frames[3], ["-", "transforms.json"]);
}

#[test]
fn another_seed_and_a_scene_of_another_name_draw_other_values() {
    let folder = folder();
    let values = |args: &[&str]| {
        folder.succeed(&[args, &JOB[1..9], &["--resolution", "4x4"]].concat());
        drawn(&folder)[0].clone()
    };
    folder.write("other.toml", &scene());
    let own = values(&["s.toml"]);
    let all = [
        &own,
        &values(&["other.toml"]),
        &values(&["s.toml", "--set", "random.seed=8"]),
        &values(&["s.toml", "--set", "random.scene=x"]),
    ];
    for (i, a) in all.iter().enumerate() {
        for b in &all[..i] {
            assert_ne!(a["light.key.point.intensity"], b["light.key.point.intensity"]);
            assert_ne!(a["background.color"], b["background.color"]);
        }
    }
    assert_eq!(values(&["other.toml", "--set", "random.scene=s"]), own);
    // The table of the scene file draws what the file of its own does.
    folder.write("s.toml", &format!("{}[random]\n{RANDOM}", scene()));
    let job = ["s.toml", "-o", "f.####.exr", "--metadata", "transforms"];
    folder.succeed(&job);
    assert_eq!(drawn(&folder)[0], own);
    folder.succeed(&[&job[..], &["--set", "random.light.key.point.intensity=[1,2]"]].concat());
    let intensity = drawn(&folder)[0]["light.key.point.intensity"].as_f64();
    assert!(intensity.is_some_and(|intensity| (1.0..2.0).contains(&intensity)));
}

#[test]
fn frames_are_rendered_again_where_they_draw_other_values_and_only_then() {
    let folder = folder();
    let range = ["--range", "1-3"];
    run(&folder, &range);
    assert_eq!(stale(&folder, &range), "");
    folder.write("r.toml", &format!("# The same draws.\n{RANDOM}"));
    assert_eq!(stale(&folder, &range), "");
    folder.write("r.toml", &RANDOM.replace("[0.5, 1]", "[0.5, 1.1]"));
    assert_eq!(stale(&folder, &range), "1 2 3");
    folder.write("r.toml", &RANDOM.replace("seed = 7", "seed = 8"));
    assert_eq!(stale(&folder, &range), "1 2 3");
    folder.write("r.toml", RANDOM);
    assert_eq!(
        stale(&folder, &[&range[..], &["--set", "random.seed=8"]].concat()),
        "1 2 3"
    );
    assert_eq!(stale(&folder, &range), "");
}

#[test]
fn draws_hold_while_the_shutter_is_open() {
    let folder = folder();
    let open = |shutter: &str| scene().replace("[background]", &format!("shutter = {shutter}\n[background]"));
    let picture = |scene: &str| {
        folder.write("s.toml", scene);
        folder.succeed(&[&JOB[..9], &["--range", "2"]].concat());
        crate::common::pixels(&folder.path("f.0002.exr")).1
    };
    let sharp = picture(&scene());
    for shutter in ["[0, 1]", "[-0.5, 0.5]", "[-1, -0.5]", "[0, 2.5]"] {
        assert!(picture(&open(shutter)) == sharp, "{shutter}");
    }
}

#[test]
fn both_eyes_and_a_view_of_the_same_number_share_their_draws() {
    let folder = folder();
    let job = [&JOB[..1], &JOB[3..9], &["--resolution", "8x6"]].concat();
    let views = ["--views", "sphere:3", "-o", "views/####.exr"];
    folder.write("r.toml", &RANDOM.replace("perspective.fov\"", "perspective.eye.x\""));
    let message = folder.fail(65, &[&job[..], &views].concat());
    assert!(
        message.contains("r.toml: camera.perspective.eye.x is set by the views"),
        "{message}"
    );
    // The message says how to go on.
    let without = "random.camera.perspective.eye.x=none";
    assert!(message.contains(&format!("--set {without} takes it out")), "{message}");
    folder.succeed(&[&job[..], &views, &["--set", without]].concat());
    // Frames are there without any draw, too.
    folder.write("r.toml", "'light.key.point.intensity' = [1, 2]");
    let none = "random.light.key.point.intensity=none";
    folder.succeed(&[&job[..], &["--set", none, "--range", "2", "-o", "none/####.exr"]].concat());
    folder.write("r.toml", RANDOM);
    folder.succeed(&[&job[..], &views].concat());
    let pair = ["--stereo", "ipd=0.06", "--range", "1-3", "-o", "{eye}/####.exr"];
    folder.succeed(&[&job[..], &pair].concat());
    let values = |name: &str| -> Vec<serde_json::Value> {
        let frames = transforms(&folder, name);
        frames.iter().map(|frame| frame["values"].clone()).collect()
    };
    let of_left = values("left/transforms.json");
    assert_eq!(of_left.len(), 3);
    assert_eq!(of_left, values("right/transforms.json"));
    assert_eq!(of_left, values("views/transforms.json"));
    for frame in transforms(&folder, "views/transforms.json") {
        let fov = frame["values"]["camera.perspective.fov"].as_f64().expect("an angle");
        let focal = frame["fl_y"].as_f64().expect("a number");
        assert!(
            (focal - 3.0 / libm::tan(0.5 * fov.to_radians())).abs() < 1e-9,
            "{fov}: {focal}"
        );
    }
}

#[test]
fn a_value_has_one_source() {
    let folder = folder();
    folder.write("v.csv", "frame,light.key.point.intensity\n1,1\n");
    let message = folder.fail(65, &[&JOB[..7], &["--values", "v.csv"]].concat());
    assert!(
        message.contains("r.toml: light.key.point.intensity is set by v.csv, too"),
        "{message}"
    );
    folder.write("v.csv", "frame,light.key.point.position.x\n1,1\n");
    let message = folder.fail(65, &[&JOB[..7], &["--values", "v.csv"]].concat());
    assert!(message.contains("light.key.point.position"), "{message}");
    // Another value of a table moves beside those that are drawn.
    folder.write("v.csv", "frame,object.ball.transform.translate.y\n1,1\n4,2\n");
    let said = run(&folder, &["--values", "v.csv"]);
    assert!(said.contains("4 frames rendered"), "{said}");
    folder.succeed(&[&JOB[..9], &["--set", "light.key.point.intensity=5"]].concat());
    assert_eq!(drawn(&folder)[0].get("light.key.point.intensity"), None);
}

#[test]
fn distributions_that_are_wrong_are_refused_with_their_line() {
    let folder = folder();
    for (random, message) in [
        ("\"light.key.point.intensity\" = [10, 1]", "r.toml:1:31"),
        ("\n\"light.key.point.intensity\" = [nan, 1]", "r.toml:2:31"),
        (
            "\n\"light.kay.point.intensity\" = [1, 2]",
            "r.toml:2: light.kay.point.intensity: unknown light `kay`",
        ),
        (
            "\"object.ball.material\" = [\"red\", \"grey\"]",
            "r.toml:1: object.ball.material: ",
        ),
        (
            "\"object.ball.shape.sphere.radius\" = { normal = [0.1, 1] }",
            "r.toml:1: object.ball.shape.sphere.radius: expected",
        ),
        (
            "\"light.key.point.intensity\" = [-1, 1]",
            "r.toml:1: light.key.point.intensity: expected",
        ),
    ] {
        folder.write("r.toml", random);
        let found = folder.fail(65, &[&JOB[..7], &["--range", "1-50"]].concat());
        assert!(found.contains(message), "{random}: {found}");
        let found = folder.fail(65, &["check", "s.toml", "--random", "r.toml"]);
        assert!(found.contains(message), "{random}: {found}");
    }
    let found = folder.fail(66, &["s.toml", "-o", "f.png", "--random", "none.toml"]);
    assert!(
        found.contains("cannot read the distributions") && found.contains("none.toml"),
        "{found}"
    );
    let found = folder.fail(2, &["s.toml", "-o", "f.png", "--set", "random.seed=-1"]);
    assert!(
        found.contains("random.seed") && found.contains("a seed is a whole number from 0"),
        "{found}"
    );
}

#[test]
fn one_file_of_distributions_varies_what_models_have_whatever_they_call_it() {
    let folder = Folder::new();
    let triangles = "v -1 0 0\nv 1 0 0\nv 0 1 0\nv 0 2 0\n";
    folder.write("m.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
    folder.write(
        "a.obj",
        &format!("mtllib m.mtl\n{triangles}usemtl red\nf 1 2 3\nusemtl blue\nf 1 2 4\n"),
    );
    folder.write("b.obj", &format!("mtllib m.mtl\n{triangles}usemtl blue\nf 1 2 3\n"));
    for scene in ["a", "b"] {
        folder.write(
            &format!("{scene}.random.toml"),
            "\"material.*.base_color\" = [[0, 0, 0], [1, 1, 1]]\n\"object.*.transform.rotate.y\" = [0, 20]\n",
        );
    }
    let job = [
        "a.obj",
        "b.obj",
        "--range",
        "1-2",
        "--resolution",
        "16x12",
        "--samples",
        "1",
        "-q",
    ];
    let files = [
        "--random",
        "{scene}.random.toml",
        "--metadata",
        "transforms",
        "-o",
        "{scene}/####.png",
    ];
    folder.succeed(&[&job[..], &files].concat());
    let values = |scene: &str| {
        let frames = transforms(&folder, &format!("{scene}/transforms.json"));
        frames[0]["values"].as_object().expect("a table").clone()
    };
    let names = |scene: &str| values(scene).keys().cloned().collect::<Vec<_>>();
    assert_eq!(
        names("a"),
        [
            "material.blue.base_color",
            "material.red.base_color",
            "object.a.transform.rotate.y"
        ]
    );
    assert_eq!(names("b"), ["material.blue.base_color", "object.b.transform.rotate.y"]);
    let own = values("a");
    assert_ne!(own["material.blue.base_color"], own["material.red.base_color"]);
    let red = ["--set", "random.material.red.base_color=none"];
    folder.succeed(&[&job[..], &files, &red].concat());
    assert_eq!(names("a"), ["material.blue.base_color", "object.a.transform.rotate.y"]);
}

/// A model by itself, the table that it draws from, and a job of three frames.
const MODEL_JOB: [&str; 9] = [
    "m.obj",
    "--random=r.toml",
    "--range=1-3",
    "--resolution=16x12",
    "--samples=1",
    "-o",
    "f.####.exr",
    "--metadata",
    "transforms",
];

fn model_folder() -> Folder {
    let folder = folder();
    folder.write("m.obj", "v -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write(
        "r.toml",
        "transform.rotate.y = [0, 360]\n\"background.sky.elevation\" = [5, 80]\n",
    );
    folder
}

#[test]
fn a_model_by_itself_draws_values() {
    let folder = model_folder();
    folder.succeed(&MODEL_JOB);
    let values = drawn(&folder);
    assert!(values[0] != values[1] && values[0]["transform.rotate.y"].is_f64());
}

#[test]
#[cfg(unix)]
fn jobs_of_farms_draw_values() {
    let folder = model_folder();
    folder.succeed(&[&["submit", "--engine", "slurm", "--bundle", "b"], &MODEL_JOB[..]].concat());
    let script = String::from_utf8(folder.read("b/frames.sbatch")).expect("UTF-8");
    assert!(script.contains("--random=r.toml"), "{script}");
}

#[test]
fn all_objects_of_a_model_by_itself_are_the_model_and_not_its_ground() {
    let folder = Folder::new();
    folder.write("m.obj", "v -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("r.toml", "\"object.*.visible\" = [true, false]\n");
    let job = ["m.obj", "--random", "r.toml", "--ground", "--dry-run", "-o", "f.png"];
    let listed = folder.program().args(job).output().expect("it runs").stdout;
    let listed = String::from_utf8(listed).expect("UTF-8");
    assert!(
        listed.contains("object.m.visible") && !listed.contains("ground"),
        "{listed}"
    );
    folder.write("r.toml", "\"object.ground.visible\" = [true, false]\n");
    let listed = folder.program().args(job).output().expect("it runs").stdout;
    assert!(
        String::from_utf8(listed)
            .expect("UTF-8")
            .contains("object.ground.visible")
    );
}
