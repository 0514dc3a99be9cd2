//! What the program says to those who type something else than it expects.

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
