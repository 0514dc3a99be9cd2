//! Values of a scene file by their names: set for a job, and over frames by a table.

use crate::common::Folder;

pub const SCENE: &str = r#"
[render]
width = 24
height = 16
samples = 4
[camera]
perspective = { eye = [0, 1, 6], target = [0, 1, 0], fov = 40 }
[background]
color = 0.1
[material.red]
matte = { albedo = [0.8, 0.1, 0.1] }
[material.gray]
matte = { albedo = 0.5 }
[[object]]
name = "ball.001"
material = "red"
shape.sphere = { radius = 1 }
transform = { translate = [0, 1, 0] }
[[object]]
material = "gray"
shape.sphere = { center = [2, 1, 0], radius = 0.5 }
[[light]]
name = "key"
point = { position = [3, 4, 5], intensity = 40 }
[[light]]
sun = { direction = [-1, -2, -1], irradiance = 1 }
"#;

const JOB: [&str; 8] = [
    "s.toml",
    "-o",
    "f.####.exr",
    "--skip-existing",
    "--threads",
    "2",
    "--exr-type",
    "float",
];

fn folder(scene: &str) -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", scene);
    folder
}

fn run(folder: &Folder, args: &[&str]) -> String {
    folder.succeed(&[&JOB[..], args].concat())
}

/// The pixels of a frame.
fn pixels(folder: &Folder, frame: u32) -> Vec<[f32; 3]> {
    crate::common::pixels(&folder.path(&format!("f.{frame:04}.exr"))).1
}

/// The pixels of frame 1 of a scene, with these arguments.
fn picture(scene: &str, args: &[&str]) -> Vec<[f32; 3]> {
    let folder = folder(scene);
    run(&folder, args);
    pixels(&folder, 1)
}

/// The numbers of the frames that a job would render.
fn stale(folder: &Folder, args: &[&str]) -> String {
    let said = folder.succeed(&[&JOB[..3], args, &["--exr-type", "float", "--list-stale"]].concat());
    let first = |line: &str| line.split('\t').next().unwrap_or_default().to_owned();
    said.lines().map(first).collect::<Vec<_>>().join(" ")
}

#[test]
fn a_value_that_is_set_by_its_name_equals_the_one_in_the_file() {
    let cases = [
        (
            "object.ball.001.transform.translate.x=0.5",
            "translate = [0, 1, 0]",
            "translate = [0.5, 1, 0]",
        ),
        (
            "object.ball.001.shape.sphere.radius=0.5",
            "radius = 1 }",
            "radius = 0.5 }",
        ),
        (
            "object.object 2.shape.sphere.center.z=-1",
            "center = [2, 1, 0]",
            "center = [2, 1, -1]",
        ),
        (
            "object.1.shape.sphere.center.z=-1",
            "center = [2, 1, 0]",
            "center = [2, 1, -1]",
        ),
        ("light.key.point.intensity=90", "intensity = 40", "intensity = 90"),
        (
            "light.key.point.intensity.g=90",
            "intensity = 40",
            "intensity = [40, 90, 40]",
        ),
        ("light.light 2.sun.irradiance=3", "irradiance = 1", "irradiance = 3"),
        (
            "material.red.matte.albedo.b=0.7",
            "albedo = [0.8, 0.1, 0.1]",
            "albedo = [0.8, 0.1, 0.7]",
        ),
        ("background.color.r=0.6", "color = 0.1", "color = [0.6, 0.1, 0.1]"),
        ("camera.perspective.eye.y=2", "eye = [0, 1, 6]", "eye = [0, 2, 6]"),
        (
            "object.ball.001.material=gray",
            "material = \"red\"",
            "material = \"gray\"",
        ),
        (
            "object.ball.001.transform.scale.y=2",
            "translate = [0, 1, 0]",
            "translate = [0, 1, 0], scale = [1, 2, 1]",
        ),
    ];
    let plain = picture(SCENE, &[]);
    for (set, old, new) in cases {
        let found = picture(SCENE, &["--set", set]);
        assert!(found == picture(&SCENE.replacen(old, new, 1), &[]), "{set}");
        assert!(found != plain, "{set}");
    }
}

#[test]
fn an_object_that_is_not_visible_leaves_the_picture_of_a_scene_without_it() {
    let without = SCENE.replace(
        "radius = 1 }\ntransform = { translate = [0, 1, 0] }",
        "radius = 1e-9 }\ntransform = { translate = [0, -99, 0] }",
    );
    let found = picture(SCENE, &["--set", "object.ball.001.visible=false"]);
    assert_eq!(found, picture(&without, &[]));
    assert!(found != picture(SCENE, &[]));
}

#[test]
fn a_wrong_name_or_value_of_a_flag_is_wrong_usage_and_suggests_a_name() {
    let cases = [
        (
            "object.bal.001.visible=false",
            "unknown object `bal.001` (did you mean `ball.001`?)",
        ),
        (
            "light.kay.point.intensity=1",
            "unknown light `kay` (did you mean `key`?)",
        ),
        (
            "light.key.point.intensty=1",
            "unknown key `intensty` (did you mean `intensity`?)",
        ),
        (
            "light.key.point.intensity=much",
            "expected a number or [r, g, b], found the text \"much\"",
        ),
        ("light.key.point.intensity=-1", "light.key.point.intensity: "),
        ("object.ball.001.visible=3", "expected a boolean"),
        (
            "object.ball.001.transform.rotat.x=3",
            "unknown key `rotat` (did you mean `rotate`?)",
        ),
        ("material.gray.matte.albedo.x.y=3", "material.gray.matte.albedo.x.y: "),
        (
            "object.ball.001.shape.sphere.center.x=3",
            "the file has no `center`, and only some of its components are set",
        ),
    ];
    for (set, expected) in cases {
        let message = folder(SCENE).fail(2, &[&JOB[..], &["--set", set]].concat());
        let name = set.split('=').next().expect("a name");
        assert!(
            message.contains(expected) && message.contains(&format!("--set {name}")),
            "{set}: {message}"
        );
    }
}

const TABLE: &str = "frame,light.key.point.intensity,object.ball.001.transform.translate.x,material.red.matte.albedo.r,interp\n\
                     1,40,0,0.8,linear\n3,80,1,0.2,\n4,80,1,0.2,\n";

#[test]
fn a_frame_of_a_table_equals_the_picture_of_its_values() {
    let folder = folder(&format!("values = \"v.csv\"\n{SCENE}"));
    folder.write("v.csv", TABLE);
    let said = run(&folder, &[]);
    assert!(said.contains("4 frames rendered"), "{said}");
    for (frame, intensity, x, red) in [(1, "40", "0", "0.8"), (2, "60", "0.5", "0.5"), (3, "80", "1", "0.2")] {
        let still = SCENE
            .replace("intensity = 40", &format!("intensity = {intensity}"))
            .replace("translate = [0, 1, 0]", &format!("translate = [{x}, 1, 0]"))
            .replace("[0.8, 0.1, 0.1]", &format!("[{red}, 0.1, 0.1]"));
        let alone = picture(&still, &["--seed-mode", "fixed"]);
        let moving = self::folder(SCENE);
        moving.write("v.csv", TABLE);
        run(
            &moving,
            &[
                "--values",
                "v.csv",
                "--range",
                &frame.to_string(),
                "--seed-mode",
                "fixed",
            ],
        );
        assert!(pixels(&moving, frame) == alone, "frame {frame}");
    }
}

#[test]
fn frames_of_a_table_have_the_same_bytes_alone_in_chunks_and_in_a_sequence() {
    let table = "frame,object.ball.001.transform.translate.x,object.ball.001.visible,object.object 2.shape.sphere.radius,background.color\n\
                 1,0,true,0.5,0.1\n3,1,false,,\n5,,true,0.9,0.7\n";
    let whole = folder(SCENE);
    whole.write("v.csv", table);
    run(&whole, &["--values", "v.csv"]);
    for args in [
        &["--range", "4"][..],
        &["--part", "2/3"],
        &["--range", "1,5", "--threads", "1"],
    ] {
        let part = folder(SCENE);
        part.write("v.csv", table);
        part.succeed(&[&JOB[..4], &["--exr-type", "float", "--values", "v.csv"], args].concat());
        for name in part.names().iter().filter(|name| name.ends_with(".exr")) {
            assert!(part.read(name) == whole.read(name), "{args:?} {name}");
        }
    }
}

#[test]
fn a_changed_row_renders_again_the_frames_that_it_changes() {
    let folder = folder(SCENE);
    folder.write(
        "v.csv",
        "frame,light.key.point.intensity,interp\n1,40,hold\n3,40,hold\n5,40,hold\n",
    );
    let table = ["--values", "v.csv"];
    run(&folder, &table);
    assert_eq!(stale(&folder, &table), "");
    folder.write(
        "v.csv",
        "# a comment\nframe,light.key.point.intensity,interp\n1,40,hold\n3,81,hold\n5,40,hold\n",
    );
    assert_eq!(stale(&folder, &table), "3 4");
    let said = run(&folder, &table);
    assert!(said.contains("2 frames rendered, 3 skipped"), "{said}");
    folder.write("s.toml", &SCENE.replace("albedo = 0.5", "albedo = 0.4"));
    assert_eq!(stale(&folder, &table), "1 2 3 4 5");
}

#[test]
fn columns_of_a_camera_path_set_values_and_the_camera_has_one_source() {
    let path = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,light.key.point.intensity\n\
                1,0,1,6,0,1,0,40\n2,0,1,6,0,1,0,90\n";
    let folder = folder(SCENE);
    folder.write("p.csv", path);
    run(&folder, &["--frames", "p.csv", "--seed-mode", "fixed"]);
    let bright = SCENE.replace("intensity = 40", "intensity = 90");
    assert_eq!(pixels(&folder, 2), picture(&bright, &["--seed-mode", "fixed"]));
    for (column, by) in [
        ("camera.perspective.eye.x", "the camera path"),
        ("camera.perspective.fov", "the column `fov`"),
    ] {
        folder.write(
            "q.csv",
            &path
                .replace("light.key.point.intensity", column)
                .replace("frame,", "fov,frame,")
                .replace("\n1,", "\n40,1,")
                .replace("\n2,", "\n40,2,"),
        );
        let message = folder.fail(65, &["s.toml", "-o", "g.####.exr", "--frames", "q.csv"]);
        assert!(
            message.contains(&format!("q.csv: {column} is set by {by}")),
            "{message}"
        );
    }
}

#[test]
fn a_turntable_moves_the_camera_alone() {
    let folder = folder(SCENE);
    for column in ["camera.perspective.eye.x", "camera.perspective.fov"] {
        folder.write("c.csv", &format!("frame,{column}\n1,1\n2,60\n"));
        let message = folder.fail(
            65,
            &["s.toml", "-o", "g.####.exr", "--turntable", "2", "--values", "c.csv"],
        );
        assert!(
            message.contains(&format!("c.csv: {column} is set by the turntable")),
            "{message}"
        );
    }
}

#[test]
fn a_wrong_cell_is_refused_with_its_row_and_column() {
    let cases = [
        (
            "frame,light.kay.point.intensity\n1,2\n",
            "v.csv:1: light.kay.point.intensity: unknown light `kay` (did you mean `key`?)",
        ),
        (
            "frame,light.key.point.intensty\n1,2\n",
            "v.csv:2: light.key.point.intensty: unknown key `intensty` (did you mean `intensity`?)",
        ),
        (
            "frame,light.key.point.intensity\n1,2\n\n2,-3\n",
            "v.csv:4: light.key.point.intensity: ",
        ),
        (
            "frame,light.key.point.intensity\n1,2\n2,nan\n",
            "v.csv:3: light.key.point.intensity: 'nan' is not finite",
        ),
        (
            "frame,light.key.point.intensity\n1,2\n2,much\n",
            "v.csv:3: light.key.point.intensity: ",
        ),
        (
            "frame,object.ball.001.visible\n1,2\n",
            "v.csv:2: object.ball.001.visible: ",
        ),
        (
            "frame,background.color,background.color\n1,2,3\n",
            "v.csv:1: background.color is given twice: in columns 2 and 3",
        ),
        (
            "frame,background.color\n2,1\n1,1\n",
            "v.csv:3: frame: frame 1 comes after frame 2 of line 2",
        ),
        (
            "frame,render.samples\n1,2\n",
            "v.csv:1: render.samples: `render` holds for the whole job: use --set",
        ),
        (
            "frame,object.ball.001.name\n1,b\n",
            "v.csv:1: object.ball.001.name: `name` holds for the whole job",
        ),
        (
            "frame,background.color,interp\n1,2,smoth\n",
            "v.csv:2: interp: unknown interpolation `smoth` (did you mean `smooth`?)",
        ),
        (
            "# interp: background.colr = linear\nframe,background.color\n1,2\n",
            "v.csv:1: unknown column `background.colr` (did you mean `background.color`?)",
        ),
        // A name that is wrong in every row is told once.
        (
            "frame,object.ball.001.transfrm.scale\n1,2\n2,3.5\n3,1\n4,9\n",
            "error: v.csv:3: object.ball.001.transfrm.scale: unknown key `transfrm` (did you mean `transform`?)\n",
        ),
        ("frame\n1\n", "v.csv:1: there is no column of a value"),
        ("frame,background.color\n", "there are no rows below the header"),
    ];
    for (table, expected) in cases {
        let folder = folder(SCENE);
        folder.write("v.csv", table);
        let message = folder.fail(65, &[&JOB[..], &["--values", "v.csv"]].concat());
        assert!(message.contains(expected), "{table}: {message}");
        assert_eq!(
            message.matches("unknown key").count(),
            expected.matches("unknown key").count()
        );
    }
    let message = folder(SCENE).fail(66, &[&JOB[..], &["--values", "none.csv"]].concat());
    assert!(
        message.contains("there is no such table of values: none.csv"),
        "{message}"
    );
}

#[test]
fn empty_cells_and_frames_beyond_the_rows_keep_the_values_around_them() {
    let folder = folder(SCENE);
    folder.write(
        "v.csv",
        "frame,background.color,light.key.point.intensity\n1,0.1,\n2,,40\n3,0.3,\n",
    );
    run(
        &folder,
        &["--values", "v.csv", "--range", "2,9", "--seed-mode", "fixed"],
    );
    for (frame, color) in [(2, "0.2"), (9, "0.3")] {
        let still = SCENE.replace("color = 0.1", &format!("color = {color}"));
        assert_eq!(
            pixels(&folder, frame),
            picture(&still, &["--seed-mode", "fixed"]),
            "{frame}"
        );
    }
}

#[test]
fn the_example_of_the_manual_renders() {
    let manual = std::fs::read_to_string(crate::common::repo("docs/animation.md")).expect("the manual");
    let block = |language: &str| {
        let rest = manual.split_once(&format!("```{language}\n")).expect("a block").1;
        rest.split_once("```").expect("an end").0.to_owned()
    };
    let folder = Folder::new();
    folder.write("ball.toml", &block("toml"));
    folder.write("ball.csv", &block("csv"));
    let command = block("sh");
    let args: Vec<&str> = command.split_whitespace().skip(1).collect();
    let said = folder.succeed(&args);
    assert!(said.contains("3 frames rendered"), "{said}");
    assert!(folder.read("ball.0001.png") != folder.read("ball.0013.png"));
}
