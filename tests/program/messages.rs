//! Messages of the program to those who type something else than it expects.

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, stderr};

/// The scene and a path that gives the field of view, too.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let lines = SMALL_PATH.lines().zip(["fov", "30", "30"]);
    let path: String = lines.map(|(line, fov)| format!("{line},{fov}\n")).collect();
    folder.write("path.csv", &path);
    folder
}

#[test]
fn one_warning_says_which_settings_of_the_camera_the_path_replaces() {
    let folder = prepared();
    let said = stderr(&folder.run(&[
        "s.toml",
        "--frames",
        "path.csv",
        "--check",
        "--set",
        "camera.perspective.fov=20",
        "--set",
        "camera.perspective.eye=[1, 2, 3]",
        "--set",
        "camera.perspective.blades=5",
    ]));
    assert_eq!(
        said,
        "warning: --set camera.perspective.eye has no effect, the camera path replaces it: path.csv \
         (and 1 more like this: --set camera.perspective.fov)\n"
    );
}

#[test]
fn a_mistyped_command_is_suggested() {
    let folder = prepared();
    let first_line = |args: &[&str]| folder.fail(2, args).lines().next().map(str::to_owned);
    let of = |text: &str| Some(text.to_owned());
    assert_eq!(
        first_line(&["chekc", "s.toml"]),
        of("error: unknown command `chekc` (did you mean `check`?)")
    );
    assert_eq!(
        first_line(&["chekc"]),
        of("error: unknown command `chekc` (did you mean `check`?)")
    );
    assert_eq!(
        first_line(&["s.toml", "check"]),
        of("error: the command `check` stands before the scene, and not after `s.toml`")
    );
    // A file is a scene, whatever its name.
    folder.write("chekc", SMALL_SCENE);
    folder.succeed(&["chekc", "--check"]);
    assert!(
        folder
            .fail(66, &["scene-that-is-not-there"])
            .contains("cannot read scene")
    );
}

#[cfg(unix)]
#[test]
fn a_pattern_that_is_not_utf8_is_refused_by_name_and_a_path_is_not() {
    use std::{ffi::OsStr, os::unix::ffi::OsStrExt as _};
    let folder = prepared();
    let odd = |text: &'static [u8]| OsStr::from_bytes(text);
    let scene = odd(b"s\xff.toml");
    std::fs::write(folder.path("s.toml").with_file_name(scene), SMALL_SCENE).expect("written");
    for (words, named) in [
        (
            &[odd(b"-o"), odd(b"f\xff.####.png")][..],
            "-o: expected UTF-8 text, found `f\u{fffd}.####.png`",
        ),
        (
            &[odd(b"--output=\xff.png")],
            "--output: expected UTF-8 text, found `\u{fffd}.png`",
        ),
    ] {
        let output = folder.program().arg(scene).args(words).output().expect("it runs");
        assert_eq!(output.status.code(), Some(2));
        let message = stderr(&output);
        assert_eq!(message.lines().next(), Some(format!("error: {named}").as_str()));
    }
    let output = folder.program().arg(scene).arg("--check").output().expect("it runs");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn a_frame_field_of_another_program_is_refused() {
    let said = prepared().fail(2, &["s.toml", "-o", "f.{frame}.png"]);
    assert_eq!(
        said,
        "error: the frame's number is written as ####, not as {frame}, as in f.####.png: f.{frame}.png\n"
    );
}

#[test]
fn scenes_of_other_programs_come_with_advice() {
    let folder = Folder::new();
    for (name, advice) in [
        ("a.blend", "export glTF"),
        ("a.pov", "write its shapes in a scene file"),
        ("a.xml", "name their PLY and OBJ meshes in a scene file"),
        ("a.usdc", "USD is not read"),
        ("a.3ds", "export glTF"),
    ] {
        folder.write(name, "camera { location <0, 1, -5> }");
        let said = folder.fail(65, &[name]);
        assert!(said.contains(advice), "{said}");
    }
}

#[test]
fn messages_name_what_is_to_be_changed() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    for name in ["e.json", "e.glb", "e.chan"] {
        folder.write(name, "\n");
    }
    folder.write("list.json", "[]");
    folder.write("file", "");
    folder.write("dot.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n");
    folder.write("tiny.obj", "v 0 0 0\nv 1e-30 0 0\nv 0 1e-30 0\nf 1 2 3\n");
    for (code, args, expected) in [
        (65, &["--frames", "e.json"][..], "error: e.json: the file is empty\n"),
        (65, &["--frames", "e.glb"], "error: e.glb: the file is empty\n"),
        (
            65,
            &["--frames", "list.json"],
            "expected an object with a list `frames` or `camera_path`",
        ),
        (
            2,
            &["--stats", "-"],
            "--stats -: only frames go to standard output (-o -)",
        ),
        (2, &["--stereo", "ipd=0.06,ipd=0.07"], "`ipd` is given twice"),
        (65, &["--max-memory", "100K"], "and 100 KiB are allowed (--max-memory)"),
    ] {
        let said = folder.fail(code, &[&["s.toml", "-o", "f.png"], args].concat());
        assert!(said.contains(expected), "{said}");
    }
    for (job, folders) in [
        (&["-o", "file/f.png"][..], 1),
        (&["-o", "f.png", "--report", "file"], 1),
    ] {
        let said = folder.fail(73, &[&["s.toml", "--resolution", "8x8"], job].concat());
        let told = said.matches("file is a file, and a folder must be there").count();
        assert_eq!((told, said.matches("error:").count()), (folders, folders), "{said}");
    }
    let said = folder.fail(65, &["dot.obj", "--views", "cube", "-o", "f.#.png"]);
    assert!(
        said.contains("--views: the scene has nothing with bounds: dot.obj"),
        "{said}"
    );
    let said = folder.fail(65, &["tiny.obj", "--normalise", "unit-cube", "-o", "f.png"]);
    assert!(
        said.contains("--normalise: the model is 1.4") && said.contains("too small"),
        "{said}"
    );
}

#[test]
fn negative_values_are_joined_to_their_options() {
    let folder = Folder::new();
    for (args, joined) in [
        (&["s.toml", "--samples", "-1"][..], "--samples=-1"),
        (&["s.toml", "--seed", "-1.5"], "--seed=-1.5"),
        (&["compare", "a", "b", "--tolerance", "-1"], "--tolerance=-1"),
    ] {
        let said = folder.fail(2, args);
        assert!(
            said.contains(&format!("as {joined}\n")) && !said.contains("tip:"),
            "{said}"
        );
    }
    // A name of a file that begins so is one behind `--`, as others.
    assert!(folder.fail(2, &["-1"]).contains("use '-- -1'"));
}
