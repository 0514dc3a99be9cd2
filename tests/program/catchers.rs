//! Shadow catchers and linked lights: the same bits whatever the threads, the crop, a merge and a checkpoint.

use crate::{
    common::{Folder, SMALL_SCENE},
    denoise::channel,
};

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
    let checkpoint = || {
        std::fs::metadata(folder.path("f.exr.checkpoint"))
            .and_then(|file| file.modified())
            .ok()
    };
    for _ in 0..3 {
        let before = checkpoint();
        let mut program = folder.program_with_signals();
        let mut child = program
            .args(job("f", &more))
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        // Each run is killed once it has kept more than the one before, or ends.
        while checkpoint() == before && child.try_wait().expect("a status").is_none() {
            sleep(Duration::from_millis(2));
        }
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

/// A gray catcher below a ball under a gray sun, where reflections and noise leave light without alpha.
const SUNNY: &str = r#"
[render]
width = 80
height = 50
samples = 16
[camera]
perspective = { eye = [0, 2, 6], target = [0, 0.8, 0], fov = 40 }
[background]
color = 0.3
visible = false
[[light]]
sun = { direction = [0.35, -1, -0.75], irradiance = 1.9, angle = 2 }
[material.ground]
matte = { albedo = 0.4 }
[material.ball]
principled = { base_color = [0.7, 0.1, 0.1], roughness = 0.3 }
[material.glass]
glass = {}
[[object]]
material = "ground"
shape.plane = { point = [0, 0, 0], normal = [0, 1, 0] }
shadow_catcher = true
[[object]]
material = "ball"
shape.sphere = { center = [0.8, 1, 0], radius = 1 }
[[object]]
material = "glass"
shape.sphere = { center = [-1.2, 0.7, 0.5], radius = 0.7 }
"#;

#[test]
fn a_denoised_catcher_is_nearer_to_the_truth_in_its_alpha_and_over_a_plate() {
    let folder = Folder::new();
    folder.write("s.toml", SUNNY);
    folder.succeed(&["s.toml", "--denoise", "-o", "clean.exr"]);
    folder.succeed(&["s.toml", "-o", "noisy.exr"]);
    folder.succeed(&["s.toml", "--samples", "256", "--seed", "7", "-o", "truth.exr"]);
    let channels = |name: &str| {
        let image = folder.open_exr(name);
        ["R", "A"].map(|name| channel(&image, name))
    };
    let [clean, noisy, truth] = ["clean.exr", "noisy.exr", "truth.exr"].map(channels);
    // The pixels that show the catcher alone; caustics are rare there, and count as much as other errors.
    let bare: Vec<usize> = (0..truth[1].len()).filter(|i| truth[1][*i] < 0.5).collect();
    let error = |a: &[Vec<f32>; 2], shown: fn(f32, f32) -> f32| -> f64 {
        let apart = |i: &usize| f64::from(shown(a[0][*i], a[1][*i]) - shown(truth[0][*i], truth[1][*i]));
        bare.iter().map(|i| apart(i).powi(2).min(1e-3)).sum()
    };
    for shown in [|_, a| a, |r, a| r + (1.0 - a) * 0.3, |r, _| r] as [fn(f32, f32) -> f32; 3] {
        let (after, before) = (error(&clean, shown), error(&noisy, shown));
        assert!(after < 0.7 * before, "{after} {before}");
    }
}

#[test]
fn a_picture_of_the_albedo_shows_catchers_and_what_is_before_them_as_they_are() {
    let folder = Folder::new();
    folder.write("s.toml", SUNNY);
    for args in [["-o", "f.exr", "--aovs", "albedo"], ["-o", "f.png", "--show", "albedo"]] {
        folder.succeed(&[&["s.toml", "--set", "output.view=raw"], &args[..]].concat());
    }
    let shown = image::open(folder.path("f.png")).expect("a picture");
    assert!(!shown.color().has_alpha());
    let shown = shown.to_rgb8();
    let albedo = channel(&folder.open_exr("f.exr"), "albedo.R");
    for (pixel, albedo) in shown.pixels().zip(albedo) {
        assert!(
            (f32::from(pixel.0[0]) - 255.0 * albedo).abs() < 0.7,
            "{pixel:?}, {albedo}"
        );
    }
    // The catcher itself, of which the alpha is 0 or that of a shadow.
    assert!(shown.pixels().filter(|pixel| pixel.0[0] == 102).count() > 1000);
}
