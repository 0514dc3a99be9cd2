//! Denoising as a user runs it: sequences of files become cleaner ones, whole or in chunks, or are refused by name.

use crate::common::{Folder, SMALL_SCENE, stderr};
use exr::prelude::{FlatImage, FlatSamples};

/// Five frames of a camera that moves, and then stands still.
const PATH: &str =
    "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,2,6,0,0.8,0\n3,0.2,2,6,0,0.8,0\n5,0.2,2,6,0,0.8,0\n";

const LIGHT: &str = "denoise,diffuse_direct,diffuse_indirect,specular_direct,specular_indirect,transmission,emission";

/// The frames of this camera, without a word.
const JOB: &str = "s.toml --frames p.csv --integrator path --progress none";

/// The arguments in these lines.
fn words<'a>(lines: &[&'a str]) -> Vec<&'a str> {
    lines.iter().flat_map(|line| line.split(' ')).collect()
}

/// A folder with the scene and the path.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("p.csv", PATH);
    folder
}

/// A sequence with the passes of the denoiser and the six components, `n.1.exr` to `n.5.exr`.
fn rendered(more: &[&str]) -> Folder {
    let folder = folder();
    let job = [JOB, "--samples 16 -o n.#.exr --aovs", LIGHT];
    folder.succeed(&[words(&job), more.to_vec()].concat());
    folder
}

/// The numbers of a channel.
pub fn channel(image: &FlatImage, name: &str) -> Vec<f32> {
    let mut channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    let found = channels
        .find(|channel| channel.name.eq(name))
        .unwrap_or_else(|| panic!("no channel {name}"));
    match &found.sample_data {
        FlatSamples::F16(values) => values.iter().map(|v| v.to_f32()).collect(),
        FlatSamples::F32(values) => values.clone(),
        FlatSamples::U32(_) => panic!("{name} holds whole numbers"),
    }
}

fn square_error(a: &[f32], b: &[f32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b) * f64::from(a - b));
    squares.sum::<f64>() / a.len() as f64
}

#[test]
fn denoised_frames_are_nearer_to_the_truth_and_keep_the_noisy_picture() {
    let folder = rendered(&["--exr-type", "float"]);
    let truth = "--samples 1024 --seed 99 -r 4 -o truth.exr --exr-type float";
    folder.succeed(&words(&[JOB, truth]));
    folder.succeed(&["denoise", "n.#.exr", "-o", "d.#.exr"]);
    let (noisy, denoised, truth) = (
        folder.open_exr("n.4.exr"),
        folder.open_exr("d.4.exr"),
        folder.open_exr("truth.exr"),
    );
    let (mut before, mut after) = (0.0, 0.0);
    for c in ["R", "G", "B"] {
        let of = |image| channel(image, c);
        assert_eq!(channel(&denoised, &format!("noisy.{c}")), of(&noisy));
        before += square_error(&of(&noisy), &of(&truth));
        after += square_error(&of(&denoised), &of(&truth));
        let layers = [
            "diffuse_direct",
            "diffuse_indirect",
            "specular_direct",
            "specular_indirect",
            "transmission",
            "emission",
        ];
        let layers = layers.map(|layer| channel(&denoised, &format!("{layer}.{c}")));
        for (i, beauty) in of(&denoised).into_iter().enumerate() {
            let sum: f32 = layers.iter().map(|layer| layer[i]).sum();
            assert!(
                (sum - beauty).abs() <= 1e-5 * beauty.max(1.0),
                "{c} {i}: {sum} {beauty}"
            );
        }
    }
    assert!(after < 0.5 * before, "{after} {before}");
    // Everything else stays.
    for name in ["A", "albedo.G", "N_mean.X", "depth_mean.Z", "beauty_a.R"] {
        assert_eq!(channel(&denoised, name), channel(&noisy, name), "{name}");
    }
}

/// A card out of focus that emits 0.8, 0.4 and 0.2, over nothing.
const CARD: &str = r#"
[render]
width = 48
height = 32
[camera]
perspective = { eye = [0, 0, 4], target = [-0.9, 0, 0], fov = 30, aperture_radius = 0.25, focus_distance = 8 }
[background]
color = [0.5, 0.7, 1.0]
visible = false
[material.card]
emitter = { radiance = [0.8, 0.4, 0.2] }
[[object]]
material = "card"
shape.quad = { corners = [[-1.6, -0.9, 0], [-0.3, -0.9, 0], [-0.3, 0.9, 0], [-1.6, 0.9, 0]] }
"#;

#[test]
fn red_over_alpha_of_a_card_equals_08_and_its_alpha_is_nearer_to_the_truth() {
    let folder = Folder::new();
    folder.write("s.toml", CARD);
    folder.succeed(&words(&[
        "s.toml -q --samples 16 --exr-type float --denoise -o f.exr --aovs emission",
    ]));
    folder.succeed(&words(&[
        "s.toml -q --samples 1024 --seed 9 --exr-type float -o truth.exr",
    ]));
    let [noisy, denoised, truth] = ["noisy/f.exr", "f.exr", "truth.exr"].map(|name| folder.open_exr(name));
    let alpha = [&noisy, &denoised, &truth].map(|image| channel(image, "A"));
    let (before, after) = (square_error(&alpha[0], &alpha[2]), square_error(&alpha[1], &alpha[2]));
    assert!(after < 0.7 * before, "{after} {before}");
    for (layer, light) in [("R", 0.8), ("G", 0.4), ("emission.B", 0.2)] {
        for (value, alpha) in channel(&denoised, layer).iter().zip(&alpha[1]) {
            assert!((value - light * alpha).abs() < 2e-5, "{layer}: {value} {alpha}");
        }
    }
}

#[test]
fn chunks_and_threads_give_the_bytes_of_the_whole() {
    for more in [&[][..], &["--multipart", "--compression", "zip"]] {
        let folder = rendered(more);
        folder.succeed(&["denoise", "n.#.exr", "-o", "whole.#.exr", "-t", "2"]);
        folder.succeed(&["denoise", "n.#.exr", "-o", "part.#.exr", "--range", "1-2", "-t", "1"]);
        folder.succeed(&["denoise", "n.#.exr", "-o", "part.#.exr", "--range", "3,5", "-t", "3"]);
        folder.succeed(&["denoise", "n.#.exr", "-o", "part.#.exr", "--range", "4"]);
        for i in 1..=5 {
            assert!(
                folder.read(&format!("whole.{i}.exr")) == folder.read(&format!("part.{i}.exr")),
                "{more:?} {i}"
            );
        }
    }
}

#[test]
fn a_job_denoises_its_frames_whole_or_in_two_steps() {
    let folder = folder();
    let denoise = "--samples 4 --denoise --temporal 1 -o";
    folder.succeed(&words(&[JOB, denoise, "whole/f.#.exr"]));
    let steps = |step: &str, parts: [&str; 2]| {
        for part in parts {
            folder.succeed(&words(&[
                JOB,
                denoise,
                "two/f.#.exr --part",
                part,
                "--denoise-step",
                step,
            ]));
        }
    };
    steps("render", ["1/2", "2/2"]);
    assert_eq!(crate::common::names(&folder.path("two")), ["noisy"]);
    steps("denoise", ["2/2", "1/2"]);
    for i in 1..=5 {
        assert!(
            folder.read(&format!("whole/f.{i}.exr")) == folder.read(&format!("two/f.{i}.exr")),
            "{i}"
        );
    }
    // One picture has a name without a number.
    folder.succeed(&words(&[
        "s.toml --integrator path --samples 4 --denoise -o still.exr -q",
    ]));
    folder.succeed(&["denoise", "noisy/still.exr", "-o", "again.exr"]);
    assert!(folder.read("still.exr") == folder.read("again.exr"));
    let error = folder.fail(2, &["denoise", "two/noisy/f.#.exr", "-o", "one.exr"]);
    assert!(error.contains("one.exr"), "{error}");
    // What is there and fits stays.
    let changed = || {
        std::fs::metadata(folder.path("two/f.3.exr"))
            .and_then(|m| m.modified())
            .expect("the file is there")
    };
    let before = changed();
    folder.succeed(&words(&[JOB, denoise, "two/f.#.exr --skip-existing"]));
    assert_eq!(changed(), before);
    let error = folder.fail(2, &words(&[JOB, denoise, "two/f.#.exr --part 1/2"]));
    assert!(error.contains("--denoise-step render"), "{error}");
    let error = folder.fail(2, &["s.toml", "--samples", "1", "--denoise", "-o", "f.exr"]);
    assert!(error.contains("2 or more"), "{error}");
    let error = folder.fail(2, &["denoise", "two/noisy/f.#.exr", "-o", "d.#.png"]);
    assert!(error.contains("denoised sequences are EXR files"), "{error}");
}

/// Runs a job, and returns its lines about frames that were denoised without others.
fn unfinished(folder: &Folder, job: &[&str]) -> Vec<String> {
    let output = folder.run(job);
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stderr(&output);
    let lines = said
        .lines()
        .filter(|line| line.contains(" Once all frames are rendered: "));
    lines.map(str::to_owned).collect()
}

#[test]
fn two_chunks_and_the_command_that_each_prints_equal_the_whole() {
    let folder = folder();
    let denoise = "--samples 4 --denoise --temporal 1 -o";
    folder.succeed(&words(&[JOB, denoise, "whole/f.#.exr"]));
    let equals_whole = |frame: i32| {
        let [whole, part] = ["whole", "part"].map(|name| folder.read(&format!("{name}/f.{frame}.exr")));
        whole == part
    };
    let chunk = |range: &str| unfinished(&folder, &words(&[JOB, denoise, "part/f.#.exr -r", range]));
    let first = chunk("1-3");
    assert!(equals_whole(1) && equals_whole(2) && !equals_whole(3));
    // The second chunk finds the frame beside it, and both are whole once the command has run.
    let second = chunk("4-5");
    assert!(equals_whole(4) && equals_whole(5) && !equals_whole(3));
    let parts = |lines: &[String]| {
        let [line] = lines else { panic!("{lines:?}") };
        let (facts, command) = line.split_once(" Once all frames are rendered: ").expect("a command");
        (facts.to_owned(), command.to_owned())
    };
    let ((facts, command), (others, same)) = (parts(&first), parts(&second));
    assert!(facts.ends_with("which are not there: 3 (without 4)."), "{facts}");
    let expected = "denoised by other jobs before the frames beside them were rendered: 3.";
    assert!(others.ends_with(expected) && same == command, "{others}");
    folder.run_printed(&command);
    assert!((1..=5).all(equals_whole));
    // Nothing is left to be done.
    assert_eq!(chunk("4-5 --skip-existing"), [""; 0]);
}

#[test]
fn a_frame_alone_names_the_frames_beside_it_that_are_missing_or_not_of_its_job() {
    let folder = folder();
    let job = |more| words(&[JOB, "--samples 4 --denoise -o f.#.exr -r", more]);
    let [line] = &unfinished(&folder, &job("2"))[..] else {
        panic!("no line")
    };
    assert!(line.contains(": 2 (without 1,3,4)"), "{line}");
    // Frame 1 of another seed does not help, and frame 3 does.
    folder.succeed(&job("1 --seed 9 --temporal 0"));
    folder.succeed(&job("3 --temporal 0"));
    let [line] = &unfinished(&folder, &job("2"))[..] else {
        panic!("no line")
    };
    assert!(line.contains(": 2 (without 1,4)"), "{line}");
    let file = batch_render::output::ExrFile::read(&folder.path("f.2.exr")).expect("an EXR file");
    let how = file
        .attribute("batch-render/denoised")
        .expect("it is there")
        .to_string();
    assert!(how.ends_with(", 1 other frames"), "{how}");
    assert_eq!(unfinished(&folder, &job("2 --temporal 0")), [""; 0]);
}

#[test]
fn what_cannot_be_denoised_is_refused_by_name() {
    let folder = rendered(&[]);
    let fail = |code: i32, args: &[&str]| folder.fail(code, &[&["denoise"], args].concat());
    assert!(fail(66, &["x.#.exr", "-o", "d.#.exr"]).contains("no file of the sequence"));
    assert!(fail(66, &["nowhere/x.#.exr", "-o", "d.#.exr"]).contains("no file of the sequence"));
    assert!(fail(66, &["n.#.exr", "-o", "d.#.exr", "--range", "7"]).contains("n.7.exr"));
    assert!(fail(2, &["n.#.exr", "-o", "n.#.exr"]).contains("a file that the job reads"));
    // A gap.
    let third = folder.read("n.3.exr");
    std::fs::remove_file(folder.path("n.3.exr")).unwrap();
    let error = fail(65, &["n.#.exr", "-o", "d.#.exr"]);
    assert!(error.contains("n.3.exr is missing between frames 2 and 4"), "{error}");
    folder.succeed(&["denoise", "n.#.exr", "-o", "alone.#.exr", "--temporal", "0"]);
    // A file that was cut short, and one of another size.
    std::fs::write(folder.path("n.3.exr"), &third[..third.len() - 9]).unwrap();
    assert!(fail(65, &["n.#.exr", "-o", "d.#.exr"]).contains("incomplete or altered"));
    let third = [JOB, "--samples 4 -r 3 -o n.#.exr"];
    folder.succeed(&words(&[third[0], third[1], "--resolution 35x25 --aovs", LIGHT]));
    assert!(fail(65, &["n.#.exr", "-o", "d.#.exr"]).contains("different sizes"));
    // No passes, one sample, denoised before.
    folder.succeed(&words(&third));
    let error = fail(65, &["n.#.exr", "-o", "d.#.exr"]);
    assert!(error.contains("--aovs denoise"), "{error}");
    folder.succeed(&words(&[JOB, "--samples 1 -r 3 -o one.#.exr --aovs", LIGHT]));
    assert!(fail(65, &["one.#.exr", "-o", "d.#.exr"]).contains("one sample"));
    assert!(fail(65, &["alone.#.exr", "-o", "d.#.exr", "--temporal", "0"]).contains("denoised already"));
}

#[test]
fn open_image_denoise_is_asked_for_by_name_where_it_is_missing() {
    let folder = rendered(&[]);
    let error = folder.fail(
        66,
        &words(&["denoise n.#.exr -o d.#.exr --filter oidn --oidn-lib nowhere.so"]),
    );
    assert!(error.contains("--oidn-lib") && error.contains("OIDN_DIR"), "{error}");
    assert!(!folder.path("d.1.exr").exists());
}

/// A bright card that moves to the right before a wall.
const MOVING: &str = r#"
values = "v.csv"
[render]
width = 48
height = 32
samples = 4
[camera]
perspective = { eye = [0, 0, 4], target = [0, 0, 0], fov = 40 }
[texture.boards]
checker = { a = 0.8, b = 0.3 }
transform = { scale = 4 }
[material.card]
matte = { albedo = "texture.boards" }
[material.wall]
matte = { albedo = 0.5 }
[[object]]
name = "card"
material = "card"
shape.quad = { corners = [[-0.5, -0.5, 0.5], [0.5, -0.5, 0.5], [0.5, 0.5, 0.5], [-0.5, 0.5, 0.5]] }
transform = { translate = [0, 0, 0] }
[[object]]
material = "wall"
shape.quad = { corners = [[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]] }
[[light]]
name = "key"
point = { position = [1, 2, 4], intensity = 20 }
"#;

#[test]
fn a_job_keeps_motion_vectors_for_its_denoiser_where_objects_move_and_parts_have_the_bytes_of_the_whole() {
    let folder = Folder::new();
    folder.write("s.toml", MOVING);
    let has_vectors = |name: &str| {
        let image = folder.open_exr(name);
        let mut channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
        channels.any(|channel| channel.name.eq("forward.u"))
    };
    let job = "s.toml -q --denoise --temporal 2 -r 1-4 -o";
    folder.write("v.csv", "frame,light.key.point.intensity\n1,20\n4,10\n");
    folder.succeed(&words(&[job, "light/f.#.exr"]));
    assert!(!has_vectors("light/noisy/f.2.exr"));
    folder.write("v.csv", "frame,object.card.transform.translate.x\n1,-0.6\n4,0.6\n");
    folder.succeed(&words(&[job, "whole/f.#.exr"]));
    assert!(has_vectors("whole/noisy/f.2.exr") && has_vectors("whole/f.2.exr"));
    for step in ["render", "denoise"] {
        for part in ["1/2", "2/2"] {
            folder.succeed(&words(&[job, "parts/f.#.exr --denoise-step", step, "--part", part]));
        }
    }
    folder.succeed(&words(&["s.toml -q -r 1-4 --aovs denoise -o apart/n.#.exr"]));
    folder.succeed(&words(&["denoise apart/n.#.exr -o apart/f.#.exr -t 1"]));
    for i in 1..=4 {
        let [whole, parts] = ["whole", "parts"].map(|home| folder.read(&format!("{home}/f.{i}.exr")));
        assert!(whole == parts, "{i}");
        let [whole, apart] =
            ["whole", "apart"].map(|home| channel(&folder.open_exr(&format!("{home}/f.{i}.exr")), "G"));
        assert!(whole == apart, "{i}");
    }
}

#[test]
fn frames_beyond_a_table_are_not_missed_and_its_own_are() {
    let folder = Folder::new();
    folder.write("s.toml", MOVING);
    folder.write("v.csv", "frame,object.card.transform.translate.x\n1,-0.6\n4,0.6\n");
    let job = |range| words(&["s.toml --progress none --samples 2 --denoise -o", range]);
    assert_eq!(unfinished(&folder, &job("a/f.#.exr -r 1-4")), [""; 0]);
    let [line] = &unfinished(&folder, &job("b/f.#.exr -r 3,4"))[..] else {
        panic!("no line")
    };
    assert!(
        line.contains(": 3,4 (without 1,2)") && !line.contains("--range"),
        "{line}"
    );
    // A command without the range would leave out frames 5 and 6.
    let [line] = &unfinished(&folder, &job("c/f.#.exr -r 3-6"))[..] else {
        panic!("no line")
    };
    assert!(
        line.contains(": 3,4 (without 1,2)") && line.contains("--range=3-6"),
        "{line}"
    );
}

#[test]
fn one_file_keeps_its_number_and_a_missing_frame_beside_is_named() {
    let folder = rendered(&["-r", "1-3,5"]);
    folder.succeed(&words(&["denoise n.3.exr -o q.##.exr -q"]));
    assert!(folder.path("q.03.exr").exists() && !folder.path("q.00.exr").exists());
    folder.succeed(&words(&["denoise n.3.exr -o q.##.exr --range 12"]));
    assert!(folder.read("q.12.exr") == folder.read("q.03.exr"));
    std::fs::copy(folder.path("n.3.exr"), folder.path("n.exr")).expect("it is there");
    let error = folder.fail(2, &words(&["denoise n.exr -o p.#.exr"]));
    assert!(
        error.contains("p.#.exr needs a number") && error.contains("--range"),
        "{error}"
    );
    let said = |range: &str| {
        let output = folder.run(&words(&["denoise n.#.exr -o d.#.exr --range", range]));
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    let line = said("1,2");
    assert!(line.contains("not there: 2 (without 4). Once"), "{line}");
    assert!(!said("1").contains("without"));
    assert!(!said("2 --temporal 1").contains("without"));
}
