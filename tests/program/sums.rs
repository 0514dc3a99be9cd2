//! Kept sums: samples that are added to finished frames.

use crate::common::{Folder, SMALL_SCENE, pixels, repo_str, stderr};

const PASSES: &str = "depth,N,albedo,variance,sampleCount,CryptoObject,diffuse_direct,lightgroup";

/// A frame of the moving scene in which things move while the shutter is open.
const BLURRED: [&str; 6] = [
    "--range",
    "7",
    "--resolution",
    "40x30",
    "--set",
    "camera.shutter=[0, 0.5]",
];

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
        said.contains("has kept sums in f.exr.sums") && !said.contains("without"),
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
fn filtered_textures_are_those_of_one_job() {
    let (whole, folder) = (Folder::new(), Folder::new());
    let scene = repo_str("scenes/kinds/image.toml");
    let small = [
        "--resolution",
        "48x27",
        "--set",
        "texture.shown.image.filter='trilinear'",
    ];
    keep(&whole, &scene, &["16"], &small);
    keep(&folder, &scene, &["4", "16"], &small);
    assert!(whole.read("f.exr") == folder.read("f.exr"));
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
    keep(&whole, &scene, &["16"], &BLURRED);
    let said = keep(&folder, &scene, &["4", "16"], &BLURRED);
    assert!(said.contains("frame 7 starts without its kept sums"), "{said}");
    assert!(folder.read("f.exr") == whole.read("f.exr"));
    let said = keep(&folder, &scene, &["64"], &["--range", "8", "--resolution", "40x30"]);
    assert!(
        said.contains("not used, for it is damaged or of other settings: f.exr.sums"),
        "{said}"
    );
}

/// Renders these ranges of the samples of a scene in turn.
fn render_ranges(folder: &Folder, scene: &str, ranges: &[&str], more: &[&str]) {
    for (run, range) in ranges.iter().enumerate() {
        let threads = ["2", "1", "3"][run % 3];
        let own = [
            "-o",
            "f.exr",
            "--progress",
            "none",
            "--threads",
            threads,
            "--sample-range",
            range,
        ];
        folder.succeed(&[&[scene], &own[..], more].concat());
    }
}

fn assert_adds_up(scene: &str, more: &[&str]) {
    let (whole, folder) = (Folder::new(), Folder::new());
    render_ranges(&whole, scene, &["all/3"], more);
    render_ranges(&folder, scene, &["3/3", "1/3", "2/3", "all/3"], more);
    let folders = ["samples-1-of-3", "samples-2-of-3", "samples-3-of-3"];
    assert_eq!(folder.names()[1..], folders);
    assert!(folder.read("f.exr") == whole.read("f.exr"), "{more:?}");
    assert_eq!(whole.names(), ["f.exr"]);
}

#[test]
fn ranges_of_samples_add_up_to_the_bits_of_one_job_of_all_ranges() {
    let folder = Folder::new();
    let scene = folder.write("s.toml", SMALL_SCENE);
    let scene = scene.to_str().expect("a name");
    assert_adds_up(scene, &["--samples", "16", "--aovs", PASSES]);
    assert_adds_up(scene, &["--samples", "16", "--aovs", "denoise", "--crop", "7,5,33,20"]);
    let moving = repo_str("scenes/motion/scene.toml");
    assert_adds_up(&moving, &[&BLURRED[..], &["--samples", "7"]].concat());
}

#[test]
fn a_range_is_the_picture_of_its_own_samples_and_the_sum_that_of_all() {
    let folder = Folder::new();
    let scene = folder.write("s.toml", SMALL_SCENE);
    let scene = scene.to_str().expect("a name");
    let (one, ranges) = (Folder::new(), Folder::new());
    one.succeed(&[scene, "-o", "f.exr", "--samples", "12", "--progress", "none"]);
    render_ranges(&ranges, scene, &["1/2", "all/2"], &["--samples", "12"]);
    let (whole, sum) = (pixels(&one.path("f.exr")).1, pixels(&ranges.path("f.exr")).1);
    let far = whole
        .iter()
        .zip(&sum)
        .filter(|(a, b)| (0..3).any(|c| (a[c] - b[c]).abs() > 2e-3 * a[c].abs()));
    assert_eq!(far.count(), 0);
    let image = ranges.open_exr("samples-1-of-2/f.exr");
    let mut facts = image.layer_data[0].attributes.other.iter();
    let (_, samples) = facts
        .find(|(name, _)| **name == *"batch-render/samples")
        .expect("the number of samples");
    assert_eq!(*samples, exr::meta::attribute::AttributeValue::I32(6));
}

#[test]
fn ranges_beside_a_picture_are_no_pictures_of_its_folder_to_compare() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    let job = |out: &str, range: &str| {
        let job = [
            "--samples",
            "4",
            "--resolution",
            "16x9",
            "-q",
            "-o",
            out,
            "--sample-range",
            range,
        ];
        folder.succeed(&[&[&*scene], &job[..]].concat());
    };
    job("whole/f.exr", "all/2");
    for range in ["1/2", "2/2", "all/2"] {
        job("parts/f.exr", range);
    }
    for pair in [["whole", "parts"], ["parts", "whole"]] {
        let lines = folder.succeed(&[&["compare"], &pair[..]].concat());
        assert_eq!(lines.lines().count(), 1, "{lines}");
    }
    // Ranges that both have are compared.
    for range in ["1/2", "2/2"] {
        job("others/f.exr", range);
    }
    let lines = folder.succeed(&["compare", "others", "parts/../others"]);
    assert_eq!(lines.lines().count(), 2, "{lines}");
}

#[test]
fn ranges_are_refused_where_they_do_not_add_up() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let refused = |more: &[&str]| folder.fail(2, &[&["s.toml", "-o", "f.exr", "--samples", "8"], more].concat());
    for (range, more, message) in [
        (
            "2/4",
            "--noise-threshold=0.1",
            "does not go with adaptive sampling: give --noise-threshold 0",
        ),
        ("2/4", "--keep-sums", "does not go with --keep-sums"),
        (
            "2/4",
            "--denoise",
            "does not go with --denoise: give it to the job of all ranges",
        ),
        (
            "all/4",
            "--checkpoint=1s",
            "does not go with --checkpoint: give it to the jobs of single ranges",
        ),
        ("1/9", "--quiet", "8 samples cannot be divided into 9 ranges"),
        ("5/4", "--quiet", "expected I/N or all/N"),
    ] {
        let said = refused(&["--sample-range", range, more]);
        assert!(said.contains(message), "{said}");
    }
}
