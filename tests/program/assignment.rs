//! The assignment's scene against the pictures of the program that it comes from.

use crate::common::{Folder, repo, repo_str};

/// The part of the pixels that lie within 2/255 in every channel.
fn agreement(ours: &[u8], reference: &str) -> f64 {
    let ours = image::load_from_memory(ours).expect("our PNG").into_rgb8();
    let theirs = image::open(repo(reference)).expect("the reference").into_rgb8();
    assert_eq!(ours.dimensions(), theirs.dimensions());
    let close = ours
        .pixels()
        .zip(theirs.pixels())
        .filter(|(a, b)| a.0.iter().zip(b.0).all(|(a, b)| a.abs_diff(b) <= 2));
    close.count() as f64 / f64::from(ours.width() * ours.height())
}

#[test]
fn the_scene_from_its_own_camera_equals_the_reference() {
    let folder = Folder::new();
    folder.succeed(&[&repo_str("scenes/assignment/scene.toml"), "-o", "f.png"]);
    let same = agreement(&folder.read("f.png"), "scenes/assignment/reference/eye_0_0_15.png");
    assert!(same >= 0.999, "{same}");
}

#[test]
fn the_camera_path_passes_the_second_reference_twenty_forward() {
    let folder = Folder::new();
    let scene = repo_str("scenes/assignment/scene.toml");
    let path = repo_str("scenes/assignment/camera_path.csv");
    folder.succeed(&[&scene, "--frames", &path, "--range", "1,51,60", "-o", "f.####.png"]);
    let same = agreement(&folder.read("f.0051.png"), "scenes/assignment/reference/eye_0_0_-5.png");
    assert!(same >= 0.999, "{same}");
    let decoded = |name| {
        let image = image::load_from_memory(&folder.read(name));
        image.expect("our PNG").into_rgb8()
    };
    assert!(
        decoded("f.0060.png") == decoded("f.0001.png"),
        "the path ends where it began"
    );
    assert_eq!(folder.names(), ["f.0001.png", "f.0051.png", "f.0060.png"]);
}

#[test]
fn the_camera_path_makes_sixty_frames_in_both_formats() {
    let folder = Folder::new();
    let scene = repo_str("scenes/assignment/scene.toml");
    let path = repo_str("scenes/assignment/camera_path.csv");
    folder.succeed(&[&scene, "--frames", &path, "--resolution", "24x24"]);
    let names = crate::common::names(&folder.path("out/assignment"));
    assert_eq!(names.len(), 120);
    assert!(names.contains(&"frame.0001.exr".into()) && names.contains(&"frame.0060.png".into()));
}

#[test]
fn the_cone_and_the_spotlight_change_the_picture() {
    let folder = Folder::new();
    folder.succeed(&[&repo_str("scenes/assignment/extended.toml"), "-o", "f.png"]);
    let same = agreement(&folder.read("f.png"), "scenes/assignment/reference/eye_0_0_15.png");
    assert!(same < 0.95, "{same}");
}
