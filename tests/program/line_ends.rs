//! Files whose lines end in CR and LF, and begin with a byte order mark, as editors on Windows write them.

use crate::common::{Folder, SMALL_SCENE, pixels};

#[test]
fn texts_of_windows_editors_give_the_same_frames() {
    let path = "# Two keys.\nframe, eye_x, eye_y, eye_z, target_x, target_y, target_z\n1, 0, 2, 6, 0, 1, 0\n3, 1, 2, 6, 0, 1, 0\n";
    let values = "frame, camera.perspective.fov\n1, 40\n3, 50\n";
    let frames = |written: &dyn Fn(&str) -> String| {
        let folder = Folder::new();
        folder.write("s.toml", &written(SMALL_SCENE));
        folder.write("p.csv", &written(path));
        folder.write("v.csv", &written(values));
        folder.succeed(&[
            "s.toml",
            "--frames",
            "p.csv",
            "--values",
            "v.csv",
            "--progress",
            "none",
            "-o",
            "f.#.exr",
        ]);
        [1, 2, 3].map(|frame| pixels(&folder.path(&format!("f.{frame}.exr"))))
    };
    let plain = frames(&|text| text.to_owned());
    let windows = frames(&|text| format!("\u{feff}{}", text.replace('\n', "\r\n")));
    assert!(plain == windows && plain[0] != plain[2]);
}
