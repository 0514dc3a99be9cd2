//! The program as its users and their farms meet it: files, exit codes, signals, full disks.

use std::{
    fs,
    io::Read,
    process::{Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, stderr};

fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder
}

/// One sample of few pixels.
const QUICK: [&str; 4] = ["--resolution", "16x12", "--samples", "1"];

fn quick<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [args, &QUICK].concat()
}

#[test]
fn without_patterns_files_are_named_after_the_scene_in_the_current_folder() {
    let folder = prepared();
    folder.succeed(&quick(&["s.toml"]));
    assert_eq!(folder.names(), ["path.csv", "s.0001.exr", "s.0001.png", "s.toml"]);
}

#[test]
fn every_frame_of_the_path_is_written_and_folders_are_made() {
    let folder = prepared();
    folder.succeed(&quick(&["s.toml", "--frames", "path.csv", "-o", "a/b/f.####.exr"]));
    let expected: Vec<_> = (1..=5).map(|f| format!("f.{f:04}.exr")).collect();
    assert_eq!(crate::common::names(&folder.path("a/b")), expected);
}

#[test]
fn plain_lines_tell_each_frame_and_a_closing_summary() {
    let folder = prepared();
    let said = folder.succeed(&quick(&["s.toml", "--frames", "path.csv", "-o", "f.#.png"]));
    assert!(said.contains("frame 3 (3 of 5) rendered in "), "{said}");
    assert!(said.contains("wrote f.5.png\n"), "{said}");
    for word in [
        "5 frames rendered in ",
        "time per frame: median ",
        "rays: ",
        "scene: ",
        "tree built in ",
        "peak memory: ",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    assert!(
        !said.contains('\u{1b}') && !said.contains('\r'),
        "no control codes: {said:?}"
    );
}

#[test]
fn quiet_says_nothing() {
    let folder = prepared();
    assert_eq!(folder.succeed(&quick(&["s.toml", "-q", "-o", "f.png"])), "");
}

#[test]
fn check_and_dry_run_validate_without_rendering() {
    let folder = prepared();
    let said = folder.succeed(&["s.toml", "--frames", "path.csv", "--check"]);
    assert_eq!(said, "s.toml: 5 frames to render, nothing wrong\n");
    let said = folder.succeed(&[
        "s.toml",
        "--frames",
        "path.csv",
        "--range",
        "2-3",
        "--dry-run",
        "-o",
        "f.####.png",
    ]);
    assert_eq!(
        said,
        "2\tf.0002.png\n3\tf.0003.png\ns.toml: 2 frames to render, nothing wrong\n"
    );
    let said = folder.succeed(&["check", "s.toml"]);
    folder.succeed(&[
        "check",
        "s.toml",
        "--set",
        "render.samples=2",
        "--missing-assets",
        "placeholder",
    ]);
    let wrong = folder.fail(2, &["check", "s.toml", "--samples", "many"]);
    assert!(wrong.contains("--samples"), "{wrong}");
    assert_eq!(said.lines().next(), Some("s.toml: 1 frame to render, nothing wrong"));
    assert!(said.contains("4 objects: 0 triangles, 4 other shapes\n"), "{said}");
    assert!(said.contains("\nbounds: x "), "{said}");
    let json: serde_json::Value = serde_json::from_str(&folder.succeed(&["check", "s.toml", "--json"])).expect("JSON");
    assert!(json["bounds"]["min"][1].is_number());
    assert_eq!((&json["shapes"], &json["lights"]), (&4.into(), &3.into()));
    assert_eq!(folder.names(), ["path.csv", "s.toml"]);
}

#[test]
fn skip_existing_leaves_whole_files_and_renders_missing_and_broken_ones() {
    let folder = prepared();
    let args = quick(&[
        "s.toml",
        "--frames",
        "path.csv",
        "-o",
        "f.####.exr",
        "-o",
        "f.####.png",
        "--skip-existing",
    ]);
    folder.succeed(&args);
    let whole = folder.read("f.0002.exr");
    fs::remove_file(folder.path("f.0001.png")).unwrap();
    fs::write(folder.path("f.0002.exr"), &whole[..whole.len() - 10]).unwrap();
    let untouched = fs::metadata(folder.path("f.0003.exr")).unwrap().modified().unwrap();
    let said = folder.succeed(&args);
    assert!(said.contains("2 frames rendered, 3 skipped in "), "{said}");
    assert_eq!(folder.read("f.0002.exr"), whole);
    assert_eq!(
        fs::metadata(folder.path("f.0003.exr")).unwrap().modified().unwrap(),
        untouched
    );
}

#[test]
fn fail_existing_stops_before_the_first_frame() {
    let folder = prepared();
    folder.write("f.0003.png", "precious");
    let said = folder.fail(
        73,
        &quick(&["s.toml", "--frames", "path.csv", "-o", "f.####.png", "--fail-existing"]),
    );
    assert_eq!(said, "error: the file exists already: f.0003.png\n");
    assert_eq!(folder.read("f.0003.png"), b"precious");
    assert_eq!(folder.names(), ["f.0003.png", "path.csv", "s.toml"]);
}

#[test]
fn an_empty_scene_is_its_background() {
    let folder = Folder::new();
    folder.write(
        "e.toml",
        "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n[background]\ncolor = [1, 0.5, 0]\n\
         [output]\nview = \"raw\"\n",
    );
    for accel in ["linear", "bvh2", "wide"] {
        folder.succeed(&["e.toml", "--resolution", "8x8", "--accel", accel, "-o", "e.png"]);
        let image = image::load_from_memory(&folder.read("e.png")).unwrap().into_rgb8();
        assert!(image.pixels().all(|p| p.0 == [255, 128, 0]), "{accel}");
    }
}

#[test]
fn an_invisible_background_is_transparent() {
    let folder = Folder::new();
    let scene = SMALL_SCENE.replace("color = [0.2, 0.4, 0.8]", "color = [0.2, 0.4, 0.8]\nvisible = false");
    folder.write("s.toml", &scene);
    folder.succeed(&quick(&["s.toml", "-o", "f.png"]));
    let image = image::load_from_memory(&folder.read("f.png")).unwrap().into_rgba8();
    assert_eq!(image.get_pixel(0, 0).0, [0, 0, 0, 0]);
    assert!(image.pixels().any(|p| p.0[3] == 255));
}

#[test]
fn wrong_usage_ends_with_2_and_help_with_0() {
    let folder = prepared();
    let said = folder.fail(2, &["s.toml", "--resoluton", "4x4"]);
    assert!(
        said.contains("unexpected argument '--resoluton'") && said.contains("--resolution"),
        "{said}"
    );
    folder.fail(2, &[]);
    folder.fail(2, &["s.toml", "--threads", "0"]);
    folder.fail(2, &["s.toml", "--samples", "0"]);
    folder.fail(2, &["s.toml", "--resolution", "0x4"]);
    folder.fail(2, &["s.toml", "--skip-existing", "--overwrite"]);
    assert!(folder.succeed(&["--help"]).contains("--frames"));
}

#[test]
fn the_long_version_tells_features_and_vectors() {
    let folder = Folder::new();
    let short = folder.succeed(&["-V"]);
    assert_eq!(short, concat!("batch-render ", env!("CARGO_PKG_VERSION"), "\n"));
    let long = folder.succeed(&["--version"]);
    let lines: Vec<&str> = long.lines().collect();
    assert!(long.starts_with(short.trim_end()) && lines.len() == 4, "{long}");
    for (line, name) in lines[1..].iter().zip(["features: ", "system: ", "vectors: "]) {
        assert!(line.starts_with(name), "{long}");
    }
}

#[test]
fn the_schema_is_that_of_the_types() {
    // A trial compares the file with the types.
    let schema = include_str!("../../docs/schema/scene.json");
    assert!(Folder::new().succeed(&["schema"]) == schema);
}

#[cfg(unix)]
#[test]
fn shells_complete_commands_flags_and_values() {
    let folder = Folder::new();
    let script = folder.succeed(&["completions", "bash"]);
    folder.write("c.bash", &script);
    let complete = |words: &str| {
        let count = words.split(' ').count() - 1;
        let typed =
            format!("source ./c.bash; COMP_WORDS=({words}); COMP_CWORD={count}; _batch_render; echo ${{COMPREPLY[*]}}");
        let output = std::process::Command::new("bash")
            .args(["-c", &typed])
            .current_dir(folder.path("."))
            .output();
        String::from_utf8(output.expect("bash runs").stdout)
            .expect("UTF-8")
            .trim()
            .to_owned()
    };
    assert_eq!(complete("batch-render che"), "check");
    assert_eq!(complete("batch-render c.b"), "c.bash");
    assert_eq!(complete("batch-render s.toml --skip"), "--skip-existing");
    assert_eq!(complete("batch-render s.toml --progress pl"), "plain");
    assert_eq!(complete("batch-render check s.toml --str"), "--strict");
    assert_eq!(complete("batch-render check s.toml --missing-assets pl"), "placeholder");
    assert_eq!(complete("batch-render check s.toml --skip"), "");
    let flags = folder.succeed(&["completions", "fish"]);
    assert!(
        flags.contains("-l threads -s t -r -d 'Threads to render with"),
        "{flags}"
    );
    let flags = folder.succeed(&["completions", "zsh"]);
    assert!(
        flags.starts_with("#compdef batch-render\n") && flags.contains("'*--skip-existing["),
        "{flags}"
    );
    folder.fail(2, &["completions", "tcsh"]);
}

#[test]
fn the_manual_page_has_every_flag() {
    let folder = Folder::new();
    let page = folder.succeed(&["man"]);
    assert!(page.starts_with(".TH BATCH\\-RENDER 1 "), "{page}");
    let help = folder.succeed(&["--help"]);
    let flags = help.lines().filter_map(|line| line.trim_start().strip_prefix("--"));
    let flags = flags.filter_map(|line| line.split([' ', '=', '[']).next());
    for flag in flags {
        let marked = format!("\\fB\\-\\-{}\\fR", flag.replace('-', "\\-"));
        assert!(page.contains(&marked), "{marked}");
    }
    for heading in [".SS Frames", ".SH BATCH\\-RENDER CHECK", ".SH EXAMPLES"] {
        assert!(page.lines().any(|line| line == heading), "{heading}");
    }
}

#[test]
fn an_unwritable_folder_is_found_before_rendering() {
    let folder = prepared();
    folder.write("occupied", "a file where a folder should be");
    let said = folder.fail(73, &quick(&["s.toml", "-o", "occupied/f.png"]));
    assert!(
        said.starts_with("error: cannot create output: ") && said.ends_with(": occupied/f.png\n"),
        "{said}"
    );
    assert_eq!(folder.read("occupied"), b"a file where a folder should be");
}

/// Starts a job that takes long, and waits for its first file.
fn long_job(folder: &Folder) -> std::process::Child {
    let mut path = String::from("frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n");
    path += "1,0,2,6,0,0.8,0\n1000,2,2,5,0,0.8,0\n";
    folder.write("long.csv", &path);
    let child = folder
        .program_with_signals()
        .args([
            "s.toml",
            "--frames",
            "long.csv",
            "--resolution",
            "200x150",
            "-o",
            "f.####.exr",
            "--progress",
            "none",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !folder.path("f.0001.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no first file");
        sleep(Duration::from_millis(5));
    }
    child
}

/// Every file under its own name is complete.
fn assert_whole(folder: &Folder) {
    for name in folder.names().iter().filter(|n| n.starts_with("f.")) {
        let read = exr::prelude::read_first_rgba_layer_from_file(
            folder.path(name),
            |_, _| (),
            |_, _, _: (f32, f32, f32, f32)| (),
        );
        read.unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[cfg(unix)]
fn signalled(signal: &str) -> (Folder, std::process::ExitStatus) {
    let folder = prepared();
    let mut child = long_job(&folder);
    let killed = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(killed.success());
    (folder, child.wait().unwrap())
}

#[test]
#[cfg(unix)]
fn sigint_and_sigterm_leave_whole_frames_and_say_so() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let (folder, status) = signalled(signal);
        assert_eq!(status.code(), Some(code), "{signal}");
        assert_whole(&folder);
        let hidden: Vec<_> = folder.names().into_iter().filter(|n| n.starts_with('.')).collect();
        assert!(hidden.is_empty(), "{hidden:?}");
    }
}

#[test]
#[cfg(unix)]
fn sigkill_leaves_whole_files_under_their_own_names() {
    let (folder, status) = signalled("-KILL");
    assert_eq!(status.code(), None);
    assert_whole(&folder);
    // And the job goes on from there to the same bits.
    let args = [
        "s.toml",
        "--frames",
        "long.csv",
        "--resolution",
        "200x150",
        "--range",
        "1-3",
    ];
    folder.succeed(&[&args[..], &["-o", "f.####.exr", "--skip-existing"]].concat());
    folder.succeed(&[&args[..], &["-o", "g.####.exr"]].concat());
    for frame in 1..=3 {
        assert!(folder.read(&format!("f.{frame:04}.exr")) == folder.read(&format!("g.{frame:04}.exr")));
    }
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let folder = prepared();
    let mut child = folder
        .program()
        .args(quick(&["s.toml", "--frames", "path.csv", "-o", "f.####.png"]))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(child.wait().unwrap().success(), "{said}");
    assert_eq!(said, "");
    assert_eq!(folder.names().iter().filter(|n| n.ends_with(".png")).count(), 5);
}

#[test]
fn nobody_has_to_read_the_log() {
    let folder = prepared();
    let args = quick(&["s.toml", "--frames", "path.csv", "-vv", "-o", "f.####.png"]);
    let mut program = folder.program();
    program.args(args).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = program.spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(folder.names().iter().filter(|n| n.ends_with(".png")).count(), 5);
}

#[test]
fn the_scenes_own_files_are_relative_to_the_current_folder_and_inputs_to_the_scene() {
    let folder = Folder::new();
    fs::create_dir(folder.path("scene")).unwrap();
    fs::copy(
        crate::common::repo("scenes/assignment/stripes.bmp"),
        folder.path("scene/t.bmp"),
    )
    .unwrap();
    folder.write(
        "scene/s.toml",
        "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n[texture.t]\nimage = { file = \"t.bmp\" }\n\
         [output]\nfiles = \"pictures/f.####.png\"\n",
    );
    folder.succeed(&quick(&["scene/s.toml"]));
    assert_eq!(crate::common::names(&folder.path("pictures")), ["f.0001.png"]);
}

#[test]
fn missing_images_stop_the_job_unless_placeholders_are_wanted() {
    let folder = Folder::new();
    folder.write(
        "wall.mtl",
        "newmtl wall\nmap_Kd mortar.png\nnewmtl other\nmap_Kd broken.png\n",
    );
    folder.write("broken.png", "no picture");
    folder.write(
        "wall.obj",
        "mtllib wall.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
         usemtl wall\nf 1/1 2/2 3/3\nusemtl other\nf 1/1 3/3 4/4\n",
    );
    folder.write(
        "s.toml",
        "[camera]\nperspective = { eye = [0, 0, 2], target = [0, 0, 0] }\n\
         [texture.t]\nimage = { file = \"bricks.png\" }\n\
         [render]\nintegrator.whitted = { ambient = 1 }\n\
         [[object]]\nshape.mesh = { file = \"wall.obj\" }\n",
    );
    let said = folder.fail(66, &quick(&["s.toml", "-o", "f.png"]));
    assert!(said.contains("bricks.png") && said.contains("broken.png"), "{said}");
    assert!(said.contains("help: --missing-assets placeholder"), "{said}");
    let args = ["s.toml", "--missing-assets", "placeholder", "-o", "f.png"];
    let output = folder.run(&quick(&args));
    assert!(output.status.success(), "{}", stderr(&output));
    let warnings = stderr(&output);
    for file in ["bricks.png", "broken.png", "mortar.png"] {
        let lines = warnings.lines().filter(|l| l.contains(file)).count();
        assert_eq!(lines, 1, "{file}: {warnings}");
    }
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(said.contains("placeholders shown: 2 images"), "{said}");
    let picture = image::load_from_memory(&folder.read("f.png"))
        .expect("a PNG")
        .into_rgb8();
    let magenta = |p: &image::Rgb<u8>| p.0[0] > 60 && p.0[0] == p.0[2] && p.0[1] == 0;
    assert!(picture.pixels().filter(|p| magenta(p)).count() > 20);
}

#[test]
fn a_gltf_file_whose_image_is_missing_shows_a_placeholder_too() {
    let folder = Folder::new();
    folder.write(
        "t.gltf",
        r#"{
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
            "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
            "textures": [{ "source": 0 }], "images": [{ "uri": "gone.png" }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                            "min": [0, 0, 0], "max": [0, 0, 0] }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "buffers": [{ "byteLength": 36,
                "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
        }"#,
    );
    let said = folder.fail(66, &quick(&["t.gltf"]));
    assert!(said.contains("gone.png"), "{said}");
    let said = folder.succeed(&quick(&["t.gltf", "--missing-assets", "placeholder"]));
    assert!(said.contains("placeholders shown: 1 image\n"), "{said}");
}

#[test]
fn simd_levels_that_cannot_be_had_are_wrong_usage() {
    let folder = prepared();
    for (level, code) in [("avx99", 2), ("portable", 0), ("", 0)] {
        let run = folder
            .program()
            .args(quick(&["s.toml"]))
            .env("BATCH_RENDER_SIMD", level)
            .output()
            .expect("the program runs");
        assert_eq!(run.status.code(), Some(code), "{level}: {}", stderr(&run));
        if code != 0 {
            let said = stderr(&run);
            assert!(
                said.contains("BATCH_RENDER_SIMD") && said.contains("`avx99`") && said.contains("portable"),
                "{said}"
            );
        }
    }
}
