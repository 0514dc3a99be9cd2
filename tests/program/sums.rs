//! Kept sums: samples that are added to finished frames.

use crate::common::{Folder, SMALL_SCENE, repo_str, stderr};

const PASSES: &str = "depth,N,albedo,variance,sampleCount,CryptoObject,diffuse_direct,lightgroup";

/// Renders a scene with sums, once for each number of samples, and returns what the last run says.
fn keep(folder: &Folder, scene: &str, samples: &[&str], more: &[&str]) -> String {
    let mut said = String::new();
    for (run, samples) in samples.iter().enumerate() {
        let threads = ["1", "2", "3"][run % 3];
        let own = "-o f.exr --progress none -v --keep-sums";
        let own: Vec<&str> = own
            .split(' ')
            .chain(["--threads", threads, "--samples", samples])
            .collect();
        let output = folder.run(&[&[scene], &own[..], more].concat());
        said = stderr(&output);
        assert!(output.status.success(), "{said}");
    }
    said
}

/// The file of one job with all samples, that of jobs with more and more of them, and what the last of these says.
fn both(scene: &str, samples: &[&str], more: &[&str]) -> (Vec<u8>, Vec<u8>, String) {
    let (whole, folder) = (Folder::new(), Folder::new());
    for folder in [&whole, &folder] {
        folder.write("s.toml", scene);
    }
    keep(&whole, "s.toml", &samples[samples.len() - 1..], more);
    let said = keep(&folder, "s.toml", samples, more);
    assert_eq!(folder.names(), ["f.exr", "f.exr.sums", "s.toml"]);
    (whole.read("f.exr"), folder.read("f.exr"), said)
}

fn assert_continues(scene: &str, samples: &[&str], more: &[&str]) {
    let (whole, several, said) = both(scene, samples, more);
    assert!(
        said.contains("goes on from f.exr.sums") && !said.contains("without"),
        "{said}"
    );
    assert!(whole == several, "{samples:?} {more:?}");
}

fn assert_starts_anew(scene: &str, samples: &[&str], more: &[&str]) {
    let (whole, several, said) = both(scene, samples, more);
    assert!(said.contains("frame 1 starts without its kept sums"), "{said}");
    assert!(whole == several, "{samples:?} {more:?}");
}

#[test]
fn samples_that_follow_make_the_file_of_one_job_with_all_of_them() {
    assert_continues(SMALL_SCENE, &["4", "16", "64"], &["--aovs", PASSES]);
    assert_continues(SMALL_SCENE, &["3", "7"], &["--aovs", "depth,CryptoObject"]);
    assert_continues(SMALL_SCENE, &["4", "16"], &["--aovs", "denoise", "--crop", "7,5,33,20"]);
    assert_continues(
        SMALL_SCENE,
        &["8", "8", "32"],
        &["--set", "render.sampler.independent={}"],
    );
    let catcher = SMALL_SCENE.replace(
        "material = \"floor\"\n",
        "material = \"floor\"\nshadow_catcher = true\n",
    );
    assert_ne!(catcher, SMALL_SCENE);
    assert_continues(&catcher, &["4", "16"], &["--aovs", "denoise"]);
}

#[test]
fn adaptive_frames_go_on_where_their_noise_is_high() {
    let adaptive = [
        "--noise-threshold",
        "0.01",
        "--min-samples",
        "8",
        "--aovs",
        "sampleCount,denoise",
    ];
    assert_continues(SMALL_SCENE, &["16", "48", "256"], &adaptive);
    assert_continues(SMALL_SCENE, &["32", "64"], &adaptive);
}

#[test]
fn a_frame_starts_anew_where_the_bits_would_be_others() {
    // Fewer samples, and more than there were but less than twice as many where passes compare halves.
    assert_starts_anew(SMALL_SCENE, &["16", "4"], &[]);
    assert_starts_anew(SMALL_SCENE, &["16", "24"], &["--aovs", "denoise"]);
    assert_continues(SMALL_SCENE, &["16", "24"], &[]);
}

#[test]
fn frames_that_move_start_anew_and_other_scenes_have_other_sums() {
    let (whole, folder) = (Folder::new(), Folder::new());
    let scene = repo_str("scenes/motion/scene.toml");
    let more = [
        "--range",
        "7",
        "--resolution",
        "40x30",
        "--set",
        "camera.shutter=[0, 0.5]",
    ];
    keep(&whole, &scene, &["16"], &more);
    let said = keep(&folder, &scene, &["4", "16"], &more);
    assert!(said.contains("frame 7 starts without its kept sums"), "{said}");
    assert!(folder.read("f.exr") == whole.read("f.exr"));
    let said = keep(&folder, &scene, &["64"], &["--range", "8", "--resolution", "40x30"]);
    assert!(
        said.contains("not used, for it is damaged or of other settings: f.exr.sums"),
        "{said}"
    );
}
