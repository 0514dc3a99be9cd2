//! Shadow catchers and linked lights: the same bits whatever the threads, the crop, a merge and a checkpoint.

use crate::common::{Folder, SMALL_SCENE};

/// The small scene on a floor that is a catcher, with a light that does not light all.
fn folder(samples: u32) -> Folder {
    let folder = Folder::new();
    let scene = SMALL_SCENE
        .replace("samples = 20", &format!("samples = {samples}"))
        .replace(
            "material = \"floor\"\n",
            "material = \"floor\"\nshadow_catcher = true\n",
        )
        .replace(
            "material = \"mirror\"\n",
            "material = \"mirror\"\nexclude_lights = ['light 1']\n",
        )
        .replace("color = [0.2, 0.4, 0.8]", "color = [0.2, 0.4, 0.8]\nvisible = false");
    assert!(scene.matches("shadow_catcher").count() == 1 && scene.matches("exclude_lights").count() == 1);
    folder.write("s.toml", &scene);
    folder
}

/// The arguments of a job that writes `name.exr` and `name.png`.
fn job(name: &str, more: &[&str]) -> Vec<String> {
    let out = [format!("{name}.exr"), format!("{name}.png")];
    let mut args: Vec<String> = ["s.toml", "--integrator", "path", "--aovs", "denoise,variance"]
        .map(str::to_owned)
        .into();
    for file in out {
        args.extend(["-o".to_owned(), file]);
    }
    args.extend(more.iter().map(|arg| (*arg).to_owned()));
    args
}

fn render(folder: &Folder, name: &str, more: &[&str]) {
    let args = job(name, more);
    folder.succeed(&args.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn a_catcher_has_the_same_bits_on_all_threads_in_merged_crops_and_in_rounds() {
    let folder = folder(12);
    render(&folder, "whole", &["--threads", "1"]);
    render(&folder, "threads", &["--threads", "5"]);
    let crops = ["0,0,33,50", "33,0,70,17", "33,17,70,50"];
    for (i, crop) in crops.iter().enumerate() {
        render(&folder, &format!("crop{i}"), &["--crop", crop]);
    }
    folder.succeed(&["merge", "merged.exr", "crop0.exr", "crop1.exr", "crop2.exr"]);
    render(&folder, "rounds", &["--time-limit", "1h"]);
    for other in ["threads.exr", "merged.exr", "rounds.exr"] {
        assert!(folder.read(other) == folder.read("whole.exr"), "{other}");
    }
    assert!(folder.read("threads.png") == folder.read("whole.png"));
}

#[cfg(unix)]
#[test]
fn a_catcher_that_was_killed_goes_on_with_the_same_bits() {
    use std::{process::Stdio, thread::sleep, time::Duration};
    let folder = folder(40);
    let more = ["--checkpoint", "0.05s", "-v", "--progress", "none"];
    render(&folder, "whole", &[]);
    let mut has_gone_on = false;
    for kill in 1..12 {
        let mut program = folder.program_with_signals();
        let mut child = program
            .args(job("f", &more))
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        sleep(Duration::from_millis(300 * kill));
        let _ = child.kill();
        let output = child.wait_with_output().expect("it ends");
        has_gone_on |= crate::common::stderr(&output).contains("goes on from f.exr.checkpoint");
        if output.status.success() {
            break;
        }
    }
    render(&folder, "f", &more);
    assert!(has_gone_on && folder.read("f.exr") == folder.read("whole.exr"));
}
