//! `compare`: pictures beside their references, and the exit code.

use std::fs;

use crate::common::{Folder, SMALL_SCENE};

/// A folder with `a.exr` and `a.png` of few samples, and `b` of more.
fn rendered() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    for (name, samples) in [("a", "1"), ("b", "4")] {
        let [exr, png] = ["exr", "png"].map(|format| format!("{name}.{format}"));
        folder.succeed(&["s.toml", "-o", &exr, "-o", &png, "--samples", samples]);
    }
    folder
}

fn compared(folder: &Folder, args: &[&str]) -> (Option<i32>, String, String) {
    let output = folder.run(&[&["compare"], args].concat());
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn the_exit_code_says_whether_pictures_are_within_the_tolerance() {
    let folder = rendered();
    for format in ["exr", "png"] {
        let [a, b] = ["a", "b"].map(|name| format!("{name}.{format}"));
        assert_eq!(compared(&folder, &[&a, &a]).0, Some(0));
        let (code, line, error) = compared(&folder, &[&a, &b, "--json"]);
        assert_eq!(code, Some(1));
        assert_eq!(error, "error: 1 of 1 picture beyond the tolerance\n");
        let measures: serde_json::Value = serde_json::from_str(&line).expect("JSON");
        for metric in ["flip", "rmse", "relmse", "pixels", "largest"] {
            let value = measures[metric].as_f64().expect("a number");
            assert!(value > 0.0, "{metric}");
            let tolerance =
                |factor: f64| (factor * value.max(measures["alpha_rmse"].as_f64().expect("a number"))).to_string();
            let code = |tolerance: &str| compared(&folder, &[&a, &b, "--metric", metric, "--tolerance", tolerance]).0;
            assert_eq!(code(&tolerance(1.001)), Some(0), "{metric}");
            assert_eq!(code(&(0.999 * value).to_string()), Some(1), "{metric}");
        }
    }
}

#[test]
fn arrays_in_folders_are_said_to_be_left_out() {
    let folder = rendered();
    for name in ["x", "y"] {
        fs::create_dir(folder.path(name)).expect("made");
        fs::copy(folder.path("a.png"), folder.path(&format!("{name}/a.png"))).expect("copied");
        folder.write(&format!("{name}/a.npz"), name);
    }
    let (code, _, said) = compared(&folder, &["x", "y"]);
    assert_eq!(code, Some(0));
    assert!(said.starts_with("warning: 2 NPZ files left out"), "{said}");
}

#[test]
fn folders_are_compared_by_names_and_updated() {
    let folder = rendered();
    let put = |from: &str, to: &str| {
        let to = folder.path(to);
        fs::create_dir_all(to.parent().expect("a folder")).expect("created");
        fs::copy(folder.path(from), to).expect("copied");
    };
    for (from, to) in [
        ("a.png", "expected/same.png"),
        ("a.png", "expected/in/other.png"),
        ("a.png", "expected/lost.png"),
        ("a.png", "out/same.png"),
        ("b.png", "out/in/other.png"),
        ("b.exr", "out/new.exr"),
    ] {
        put(from, to);
    }
    folder.write("out/notes.txt", "no picture");
    let (code, lines, error) = compared(&folder, &["expected", "out", "-o", "maps"]);
    assert_eq!(
        (code, &error[..]),
        (Some(1), "error: 3 of 4 pictures beyond the tolerance\n")
    );
    let path = |name: &str| name.replace('/', std::path::MAIN_SEPARATOR_STR);
    for (name, end) in [
        ("out/in/other.png", "; beyond the tolerance"),
        ("out/lost.png", ": the picture is missing"),
        ("out/new.exr", ": there is no reference"),
    ] {
        let name = path(name);
        assert!(
            lines.lines().any(|line| line.starts_with(&name) && line.ends_with(end)),
            "{lines}"
        );
    }
    assert_eq!(
        crate::common::files(&folder.path("maps")),
        [folder.path("maps/in/other.png.png"), folder.path("maps/same.png.png")]
    );
    // Equal pictures have a black map.
    let black = image::open(folder.path("maps/same.png.png"))
        .expect("a picture")
        .to_rgb8();
    assert!(black.pixels().all(|pixel| pixel.0 == [0, 0, 4]));

    // What is missing stays missing; the others become references.
    let (code, lines, _) = compared(&folder, &["expected", "out", "--update"]);
    assert_eq!(code, Some(1));
    assert!(lines.ends_with("2 references updated\n"), "{lines}");
    fs::remove_file(folder.path("expected/lost.png")).expect("removed");
    assert_eq!(compared(&folder, &["expected", "out"]).0, Some(0));
    assert_eq!(folder.read("expected/in/other.png"), folder.read("b.png"));
}

#[test]
fn what_cannot_be_compared_says_why() {
    let folder = rendered();
    fs::create_dir(folder.path("empty")).expect("created");
    folder.write("broken.png", "no picture");
    folder.succeed(&["s.toml", "-o", "wide.exr", "--samples", "1", "--resolution", "40x8"]);
    for (code, args, expected) in [
        (66, ["a.exr", "none.exr"], "none.exr"),
        (65, ["a.png", "broken.png"], "broken.png"),
        (66, ["nowhere", "empty"], "nowhere"),
        (66, ["empty", "nowhere"], "nowhere"),
        (2, ["empty", "a.png"], "one path is a folder and the other is none"),
        (2, ["empty", "empty"], "there is no picture in the folders"),
        (1, ["a.exr", "a.png"], "1 of 1 picture beyond the tolerance"),
        (1, ["a.exr", "wide.exr"], "1 of 1 picture beyond the tolerance"),
    ] {
        let (found, lines, error) = compared(&folder, &args);
        assert_eq!(found, Some(code), "{args:?}: {lines}{error}");
        assert!(error.contains(expected), "{args:?}: {error}");
    }
}

#[test]
fn passes_are_compared_by_numbers_and_ids_by_pixels() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("moved.toml", &SMALL_SCENE.replace("target = [0, 0", "target = [0.4, 0"));
    let passes = "depth,N,objectId,CryptoObject";
    for (scene, name, aovs) in [
        ("s.toml", "a.exr", passes),
        ("moved.toml", "b.exr", passes),
        ("s.toml", "c.exr", "N"),
    ] {
        folder.succeed(&[scene, "-o", name, "--samples", "2", "--aovs", aovs]);
    }
    let lines = |args: &[&str]| -> Vec<serde_json::Value> {
        let (code, lines, error) = compared(&folder, &[args, &["--json"]].concat());
        assert_eq!(code, Some(i32::from(args[0] != args[1])), "{lines}{error}");
        lines
            .lines()
            .map(|line| serde_json::from_str(line).expect("JSON"))
            .collect()
    };
    let same = lines(&["a.exr", "a.exr", "--passes"]);
    assert_eq!(lines(&["a.exr", "a.exr", "--passes=all"]), same);
    let names: Vec<_> = same[1..]
        .iter()
        .map(|line| line["pass"].as_str().expect("a name"))
        .collect();
    for name in ["", "N", "depth", "objectId", "CryptoObject00"] {
        assert!(names.contains(&name), "{names:?}");
    }
    assert!(
        same.iter()
            .all(|line| line["within_tolerance"] == true && line["pixels"] == 0.0),
        "{same:?}"
    );

    let moved = lines(&["a.exr", "b.exr", "--passes=depth,objectId,CryptoObject00,none"]);
    for line in &moved[1..] {
        assert_eq!(line["within_tolerance"], false, "{line}");
        match line["pass"].as_str() {
            Some("none") => assert_eq!(line["error"], "neither file has such a pass"),
            Some("depth") => assert!(line["rmse"].as_f64().is_some_and(|rmse| rmse > 0.0), "{line}"),
            _ => assert!(
                line["pixels"].as_f64().is_some_and(|share| share > 0.0 && share < 1.0) && line["rmse"].is_null(),
                "{line}"
            ),
        }
    }
    let missing = lines(&["a.exr", "c.exr", "--passes=depth,N"]);
    assert_eq!(missing[1]["within_tolerance"], true, "{missing:?}");
    assert_eq!(missing[2]["error"], "the pass is missing");
    let (_, text, _) = compared(&folder, &["a.exr", "b.exr", "--passes"]);
    assert!(
        text.contains("b.exr: objectId: ") && text.contains(" % of pixels differ"),
        "{text}"
    );
}

#[test]
fn references_may_be_missing_at_first_and_any_difference_counts() {
    let folder = Folder::new();
    let write = |name: &str, [red, alpha]: [f32; 2]| {
        let path = folder.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("created");
        exr::prelude::write_rgba_file(path, 8, 8, |_, _| (red, 0.2_f32, 0.3_f32, alpha)).expect("written");
    };
    write("out/a.exr", [-1.0, 1.0]);
    assert_eq!(compared(&folder, &["expected", "out"]).0, Some(66));
    assert_eq!(compared(&folder, &["expected", "out", "--update"]).0, Some(0));
    assert_eq!(compared(&folder, &["expected", "out"]).0, Some(0));
    // No display shows light below 0, which is a difference all the same.
    write("out/a.exr", [-2.0, 1.0]);
    let (code, line, _) = compared(&folder, &["expected", "out"]);
    assert!(code == Some(1) && line.contains("FLIP 0.00000"), "{line}");
    assert_eq!(
        compared(&folder, &["expected", "out", "--tolerance", "0.001"]).0,
        Some(0)
    );
    // Alpha is among the numbers of `pixels` already, whose limit holds for it.
    write("out/a.exr", [-1.0, 0.99]);
    assert_eq!(
        compared(&folder, &["expected", "out", "--tolerance", "0.001"]).0,
        Some(1)
    );
    let pixels = ["expected", "out", "--metric", "pixels", "--limit", "0.02"];
    assert_eq!(compared(&folder, &pixels).0, Some(0));
}

#[test]
fn crops_are_compared_over_their_own_windows() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let render = |name: &str, more: &[&str]| {
        folder.succeed(&[&["s.toml", "--samples", "1", "-o", name], more].concat());
    };
    render("left.exr", &["--crop", "0,0,8,8"]);
    render("right.exr", &["--crop", "8,0,16,8"]);
    render("all.exr", &[]);
    assert_eq!(compared(&folder, &["right.exr", "right.exr"]).0, Some(0));
    for other in ["left.exr", "all.exr"] {
        let (code, line, _) = compared(&folder, &["right.exr", other, "--tolerance", "1000"]);
        assert_eq!(code, Some(1));
        assert!(
            line.contains("the data windows differ: 8x8 pixels at 8,0 and "),
            "{line}"
        );
    }
    // What is outside of the windows has no weight: the crop shows the background.
    let (_, line, _) = compared(&folder, &["right.exr", "right.exr", "--json"]);
    let line: serde_json::Value = serde_json::from_str(&line).expect("JSON");
    let blue = line["reference_mean"][2].as_f64().expect("a number");
    assert!((blue - 0.8).abs() < 1e-3, "{blue}");
}
