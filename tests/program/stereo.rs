//! Pictures of two eyes.

use crate::common::{Folder, SMALL_SCENE};

const SMALL: [&str; 4] = ["--resolution", "16x12", "--samples", "2"];

#[test]
fn both_eyes_have_the_files_that_each_has_by_itself() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let of = |stereo: &str, out: &str| {
        folder.succeed(
            &[
                &["a.toml", "--stereo", stereo, "--turntable", "2", "-o", out],
                &SMALL[..],
            ]
            .concat(),
        )
    };
    let said = of("ipd=0.2,convergence=3", "{eye}/####.exr");
    assert!(said.contains("scene 2 of 2: a.toml, right eye"), "{said}");
    for eye in ["left", "right"] {
        of(&format!("ipd=0.2,convergence=3,eye={eye}"), "alone.{eye}.####.exr");
        for frame in ["0001", "0002"] {
            let [own, alone] = [format!("{eye}/{frame}.exr"), format!("alone.{eye}.{frame}.exr")];
            assert!(folder.read(&own) == folder.read(&alone), "{own}");
        }
    }
    assert!(folder.read("left/0001.exr") != folder.read("right/0001.exr"));
}

#[test]
fn cameras_of_eyes_are_told_where_they_are() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let job = [
        "a.toml",
        "--stereo",
        "ipd=0.2",
        "--metadata",
        "transforms",
        "-o",
        "{eye}/####.exr",
    ];
    folder.succeed(&[&job[..], &SMALL[..]].concat());
    let eyes = ["left", "right"].map(|eye| {
        let text = folder.read(&format!("{eye}/transforms.json"));
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        let matrix = &json["frames"][0]["transform_matrix"];
        let column = |c: usize| [0, 1, 2].map(|r| matrix[r][c].as_f64().expect("a number"));
        (column(3), column(0))
    });
    let [(left, right_axis), (right, _)] = eyes;
    for i in 0..3 {
        assert!(
            (right[i] - left[i] - 0.2 * right_axis[i]).abs() < 1e-9,
            "{left:?} {right:?}"
        );
    }
}

#[test]
fn eyes_that_would_share_a_file_and_cameras_without_eyes_are_refused() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let said = folder.fail(2, &["a.toml", "--stereo", "ipd=0.06", "-o", "a.exr"]);
    assert!(
        said.contains("both eyes would write a.exr: tell their files apart by {eye} in the name"),
        "{said}"
    );
    folder.write(
        "flat.toml",
        "[camera]\northographic = { eye = [0, 0, 5], target = [0, 0, 0], height = 4 }\n",
    );
    let said = folder.fail(2, &["flat.toml", "--stereo", "ipd=0.06", "-o", "{eye}.exr"]);
    assert!(
        said.contains("--stereo: the two eyes of an orthographic camera see the same"),
        "{said}"
    );
}
