//! Input that is hostile or odd: refused with its name, soon, and without taking the machine's memory.

use std::{
    process::Command,
    time::{Duration, Instant},
};

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, stderr};

const QUICK: [&str; 6] = ["--resolution", "16x12", "--samples", "1", "--progress", "none"];

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";

fn quick<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [args, &QUICK].concat()
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_wherever_a_file_is_read() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    for pipe in ["pipe.toml", "pipe.obj", "pipe.csv", "pipe.mtl", "pipe.png", "pipe.bin"] {
        let made = Command::new("mkfifo").arg(folder.path(pipe)).status();
        assert!(made.expect("mkfifo").success());
    }
    std::os::unix::fs::symlink("/dev/zero", folder.path("zero.png")).expect("a link");
    let textured = |file: &str| {
        let checker = "checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 6 }";
        SMALL_SCENE.replace(checker, &format!("image = {{ file = \"{file}\" }}"))
    };
    folder.write("texture.toml", &textured("pipe.png"));
    folder.write("device.toml", &textured("zero.png"));
    folder.write("a.obj", &format!("mtllib pipe.mtl\n{TRIANGLE}f 1 2 3\n"));
    let gltf = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }], "buffers": [{ "uri": "pipe.bin", "byteLength": 36 }] }"#;
    folder.write("a.gltf", gltf);
    let start = Instant::now();
    for (args, name) in [
        (&["pipe.toml"][..], "pipe.toml"),
        (&["pipe.obj"], "pipe.obj"),
        (&["s.toml", "--frames", "pipe.csv"], "pipe.csv"),
        (&["texture.toml"], "pipe.png"),
        (&["device.toml"], "zero.png"),
        (&["a.obj"], "pipe.mtl"),
        (&["a.gltf"], "pipe.bin"),
    ] {
        let message = folder.fail(65, &quick(args));
        assert!(
            message.contains("it is not a regular file") && message.contains(name),
            "{message}"
        );
    }
    assert!(start.elapsed() < Duration::from_secs(20));
}

#[test]
fn nothing_out_of_a_file_reaches_the_terminal_as_a_control_code() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write(
        "bad.toml",
        "[render]\nsampler = \"a\\u001b[31m\\u202e\\nwrote x.exr\"\n",
    );
    folder.write("key.toml", "\"a\\u001b[31m\" = 1\n");
    folder.write(
        "usemtl.obj",
        &format!("mtllib a.mtl\n{TRIANGLE}usemtl \u{1b}[31m\u{7}\nf 1 2 3\n"),
    );
    folder.write("a.mtl", "newmtl b\n");
    folder.write("token.obj", &format!("{TRIANGLE}f 1 2 \u{1b}[2J\n"));
    folder.write("path.csv", &SMALL_PATH.replace("eye_x", "eye\u{1b}[31m_q"));
    for args in [
        &["bad.toml"][..],
        &["key.toml"],
        &["usemtl.obj"],
        &["token.obj"],
        &["s.toml", "--frames", "path.csv"],
    ] {
        let output = folder.run(&quick(args));
        let said = [stderr(&output), String::from_utf8(output.stdout).expect("UTF-8")].concat();
        assert!(
            !said.contains(|c: char| (c.is_control() && c != '\n') || c == '\u{202e}'),
            "{args:?}: {said:?}"
        );
        assert!(!said.lines().any(|l| l.starts_with("wrote x")), "{said}");
    }
}

#[test]
fn megabytes_of_one_word_are_refused_soon_and_not_repeated() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let long = "9".repeat(2_000_000);
    folder.write(
        "header.csv",
        &format!("frame,eye_x,eye_y,eye_z,{}\n", "a".repeat(2_000_000)),
    );
    folder.write("cell.csv", &SMALL_PATH.replace("1,0,2", &format!("1,{long}x,2")));
    folder.write("a.obj", &format!("v 0 0 0\nf {long}\n"));
    folder.write("a.toml", &format!("[render]\nsampler = \"{long}\"\n"));
    for args in [
        &["s.toml", "--frames", "header.csv"][..],
        &["s.toml", "--frames", "cell.csv"],
        &["a.obj"],
        &["a.toml"],
    ] {
        let start = Instant::now();
        let message = folder.fail(65, &quick(args));
        assert!(message.len() < 5000, "{args:?}: {} bytes", message.len());
        assert!(message.contains(args[args.len() - 1]), "{message}");
        assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    }
}

#[test]
fn errors_of_geometry_name_the_object_and_the_file() {
    let folder = Folder::new();
    folder.write("far.obj", "v 0 0 0\nv 1e13 0 0\nv 0 1 0\nf 1 2 3\n");
    let message = folder.fail(65, &quick(&["far.obj"]));
    assert!(message.contains("far.obj") && message.contains("1e12 m"), "{message}");

    folder.write(
        "s.toml",
        &SMALL_SCENE.replace("center = [-1, 1, 0], radius = 1 }", "radius = 1e13 }\nname = \"giant\""),
    );
    let message = folder.fail(65, &quick(&["s.toml"]));
    assert!(
        message.contains("object `giant`: primitive") && message.contains("s.toml"),
        "{message}"
    );
}

#[test]
fn models_name_files_in_their_own_folder_only() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("models")).expect("a folder");
    folder.write("secret.mtl", "newmtl a\nKd 1 0 0\n");
    folder.write("models/in.mtl", "newmtl a\nmap_Kd ../secret.png\n");
    folder.write(
        "models/out.obj",
        &format!("mtllib ../secret.mtl\n{TRIANGLE}usemtl a\nf 1/1 2/1 3/1\n"),
    );
    folder.write(
        "models/map.obj",
        &format!("mtllib in.mtl\n{TRIANGLE}usemtl a\nf 1/1 2/1 3/1\n"),
    );
    for (model, file) in [("models/out.obj", "secret.mtl"), ("models/map.obj", "secret.png")] {
        let message = folder.fail(65, &quick(&[model]));
        assert!(
            message.contains("--allow-outside") && message.contains(model) && message.contains(file),
            "{message}"
        );
    }
    folder.succeed(&quick(&["models/out.obj", "--allow-outside"]));
    // It is looked for now, and is not there.
    let output = folder.run(&quick(&["models/map.obj", "--allow-outside"]));
    let message = stderr(&output);
    assert!(output.status.success() && message.contains("secret.png"), "{message}");
}

#[test]
fn the_memory_of_a_job_covers_its_images() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.succeed(&["s.toml", "-o", "big.png", "--resolution", "700x700", "--samples", "1"]);
    let checker = "checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 6 }";
    folder.write(
        "t.toml",
        &SMALL_SCENE.replace(checker, "image = { file = \"big.png\" }"),
    );
    let message = folder.fail(65, &quick(&["t.toml", "--max-memory", "1M"]));
    assert!(
        message.contains(
            "images need 3 MiB of memory, frames have taken 1 MiB, shapes have taken 1 MiB, and 1 MiB are allowed (--max-memory)"
        ) && message.contains("big.png"),
        "{message}"
    );
    folder.succeed(&quick(&["t.toml", "--max-memory", "16M"]));
}

#[test]
fn max_memory_counts_the_shapes_of_points_and_their_tree() {
    let folder = Folder::new();
    let points: String = (0..20_000).map(|i| format!("{} {} 0\n", i % 200, i / 200)).collect();
    let header = "ply\nformat ascii 1.0\nelement vertex 20000\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    folder.write("points.ply", &format!("{header}{points}"));
    let arguments = |limit| quick(&["points.ply", "--max-memory", limit]);
    // 484 bytes for each sphere, and 210 for the construction of the tree.
    let message = folder.fail(65, &arguments("8M"));
    assert!(message.contains("shapes need 10 MiB of memory"), "{message}");
    let message = folder.fail(65, &arguments("12M"));
    assert!(message.contains("trees need 5 MiB of memory"), "{message}");
    folder.succeed(&arguments("17M"));
}

/// Another user may start the program only where root runs the tests and the folders above it are open.
#[cfg(target_os = "linux")]
#[test]
fn a_job_ends_in_a_clear_error_however_few_threads_a_user_may_have() {
    const PROGRAM: &str = env!("CARGO_BIN_EXE_batch-render");
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let open = std::os::unix::fs::PermissionsExt::from_mode(0o777);
    std::fs::set_permissions(folder.path(""), open).expect("our own folder");
    let run = |threads: u32, args: &[&str]| {
        let script = format!("ulimit -u {threads}; exec \"$0\" \"$@\"");
        let output = Command::new("setpriv")
            .args(["--reuid", "64321", "--regid", "64321", "--clear-groups"])
            .args(["sh", "-c", &script, PROGRAM])
            .args(args)
            .current_dir(folder.path(""))
            .output();
        output.ok().map(|o| (o.status.code(), stderr(&o)))
    };
    if !matches!(run(20, &["--version"]), Some((Some(0), _))) {
        return;
    }
    for threads in 1..=8 {
        let (code, said) = run(threads, &quick(&["s.toml", "--threads", "2", "--overwrite"])).expect("setpriv");
        match code {
            Some(0) => {}
            Some(71) => assert!(said.contains("cannot start"), "{said}"),
            _ => panic!("{threads} threads: {code:?}: {said}"),
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_be_had_are_a_clear_error() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    // More threads than the address space has stacks for.
    let output = Command::new("sh")
        .args([
            "-c",
            "ulimit -v 400000; exec \"$0\" \"$@\"",
            env!("CARGO_BIN_EXE_batch-render"),
        ])
        .args(quick(&["s.toml", "--threads", "1000"]))
        .current_dir(folder.path(""))
        .output()
        .expect("sh");
    assert_eq!(output.status.code(), Some(71), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("cannot start 1000 threads to render on"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn numbers_of_a_texture_that_are_not_finite_are_warned_of() {
    let folder = Folder::new();
    let pixel = |_| (f32::NAN, 0.5_f32, 0.5_f32);
    exr::prelude::write_rgb_file(folder.path("nan.exr"), 4, 4, |x, y| pixel((x, y))).expect("written");
    let checker = "checker = { a = [0.9, 0.9, 0.9], b = [0.1, 0.1, 0.1], scale = 6 }";
    folder.write(
        "t.toml",
        &SMALL_SCENE.replace(checker, "image = { file = \"nan.exr\" }"),
    );
    let output = folder.run(&quick(&["t.toml"]));
    assert!(output.status.success());
    assert!(
        stderr(&output).contains("16 numbers that are not finite became 0 or 65504: "),
        "{}",
        stderr(&output)
    );
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_samples_of_occlusion() {
    let folder = Folder::new();
    let scene = |samples: u32| {
        SMALL_SCENE.replace("samples = 20", "samples = 1").replace(
            "integrator.whitted = { max_depth = 4, ambient = 0.1 }",
            &format!("integrator.occlusion = {{ samples = {samples} }}"),
        )
    };
    let peak = |samples: u32| {
        folder.write("s.toml", &scene(samples));
        let said = folder.succeed(&["s.toml", "-o", "f.png", "--resolution", "64x48", "--threads", "1"]);
        let line = said.lines().find_map(|l| l.strip_prefix("peak memory: "));
        let mebibytes = line.and_then(|l| l.strip_suffix(" MiB")).expect("a peak");
        mebibytes.parse::<u32>().expect("a number")
    };
    let (few, many) = (peak(64), peak(4096));
    assert!(many < few + 20, "{few} MiB and {many} MiB");
}

#[test]
fn images_beyond_their_memory_are_shown_smaller_and_it_is_said() {
    let folder = Folder::new();
    // Left and right halves of two colours: smaller copies look alike from afar.
    for (name, blue) in [("a.png", 0), ("b.png", 255)] {
        let picture = image::RgbImage::from_fn(256, 256, |x, _| image::Rgb([if x < 128 { 255 } else { 0 }, 60, blue]));
        picture.save(folder.path(name)).expect("writable");
    }
    let quad = |x: i32, name: &str| {
        format!(
            "[texture.{name}]\nimage = {{ file = \"{name}.png\" }}\n[material.{name}]\nmatte = {{ albedo = \"texture.{name}\" }}\n\
             [[object]]\nmaterial = \"{name}\"\nshape.quad = {{ corners = [[{x}, 0, 0], [{0}, 0, 0], [{0}, 1, 0], [{x}, 1, 0]] }}\n",
            x + 1
        )
    };
    let scene = format!(
        "[render]\nwidth = 32\nheight = 16\nsamples = 16\n[background]\ncolor = 1\n\
         [camera]\northographic = {{ eye = [0, 0.5, 1], target = [0, 0.5, 0], height = 1 }}\n{}{}",
        quad(-1, "a"),
        quad(0, "b")
    );
    folder.write("s.toml", &scene);
    let picture = |limit: &str| {
        let args = ["s.toml", "--progress", "none", "--texture-memory", limit, "-o", "f.exr"];
        let output = folder.run(&args);
        assert!(output.status.success(), "{}", crate::common::stderr(&output));
        (
            crate::common::stderr(&output),
            crate::common::pixels(&folder.path("f.exr")).1,
        )
    };
    let (quiet, whole) = picture("1M");
    assert!(!quiet.contains("warning"), "{quiet}");
    let (warning, smaller) = picture("100K");
    let expected = "the images need 1 MiB of memory and 1 MiB are allowed (--texture-memory): 2 images are shown at half of \
                    their resolution or less";
    assert!(warning.contains(expected), "{warning}");
    let differ = whole.iter().zip(&smaller).filter(|(a, b)| (a[0] - b[0]).abs() > 0.05);
    assert!(differ.count() <= 16, "all but the seams look alike");
}
