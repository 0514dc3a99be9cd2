//! Animated pictures of whole sequences, `-o film.gif` and `-o film.apng`: they hold all frames or are not written.

use crate::{
    common::{SMALL_SCENE, stderr},
    streams::{FILM, SMALL, folder},
};

#[test]
fn films_of_gif_and_apng_hold_all_frames_at_full_size() {
    let folder = folder();
    folder.succeed(
        &[
            &SMALL[..],
            &FILM[..],
            &["-o", "film.gif", "-o", "film.apng", "--fps", "20"],
        ]
        .concat(),
    );
    assert_eq!(folder.names(), ["film.apng", "film.gif", "path.csv", "s.toml"]);
    let gif = folder.read("film.gif");
    assert_eq!(&gif[..10], b"GIF89a\x10\0\x0c\0");
    let controls = gif.windows(6).filter(|part| *part == [0x21, 0xf9, 4, 4, 5, 0]);
    assert_eq!(controls.count(), 3, "three frames of 5/100 s");
    let apng = png::Decoder::new(std::io::Cursor::new(folder.read("film.apng")))
        .read_info()
        .expect("a PNG");
    let info = apng.info();
    assert_eq!((info.width, info.height), (16, 12));
    assert_eq!(info.animation_control().expect("a film").num_frames, 3);
    // With files of the frames a film is made again without rendering.
    let both = ["-o", "f.#.png", "-o", "again.apng", "--fps", "20"];
    folder.succeed(&[&SMALL[..], &FILM[..], &both].concat());
    folder.succeed(&[&SMALL[..], &FILM[..], &both, &["-o", "later.gif", "--skip-existing"]].concat());
    assert!(folder.read("again.apng") == folder.read("film.apng"));
    assert!(folder.read("later.gif") == gif);
}

#[test]
fn a_film_is_refused_where_frames_on_disk_could_not_be_shown_in_it() {
    let folder = folder();
    for (files, is_right) in [
        (&[][..], false),
        (&["-o", "f.#.npz"], false),
        (&["--png-depth"], false),
        (&["-o", "f.#.exr", "--show", "depth"], false),
        (&["-o", "f.#.exr", "--exposure", "auto"], false),
        (&["-o", "f.#.exr", "--aovs", "depth"], true),
        (&["-o", "f.#.png", "--show", "depth"], true),
        (&["-o", "f.#.npz", "-o", "f.#.jpg"], true),
    ] {
        for partial in [&["--skip-existing"][..], &["--part", "1/2"]] {
            let job = [&SMALL[..], &FILM, files, &["-o", "film.gif", "--check"], partial].concat();
            match is_right {
                true => drop(folder.succeed(&job)),
                false => {
                    let said = folder.fail(2, &job);
                    assert!(
                        said.contains("-o film.gif: an animated picture is made of all frames"),
                        "{said}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_job_that_lacks_a_frame_keeps_the_film_that_is_there() {
    let folder = folder();
    let cuboid =
        "[[object]]\nname = \"box\"\nmaterial = \"red\"\nshape.cuboid = { min = [-2, 0, -2], max = [2, 1, -1] }\n";
    folder.write("s.toml", &format!("{SMALL_SCENE}{cuboid}"));
    let row = |max: &str| {
        folder.write(
            "v.csv",
            &format!("frame,object.box.shape.cuboid.max.x\n1,1\n2,{max}\n3,1\n"),
        )
    };
    row("1");
    let values = ["--values", "v.csv", "--progress", "none", "-o", "film.gif"];
    let job = [&SMALL[..], &FILM, &values].concat();
    folder.succeed(&job);
    let whole = folder.read("film.gif");
    // Below the least x, which is found when the frame renders.
    row("-5");
    let said = folder.fail(1, &job);
    let kept = "1 of its 3 frames are missing, and an older file stays as it is: film.gif";
    assert!(said.contains(kept) && said.contains("to repeat the job: "), "{said}");
    assert!(folder.read("film.gif") == whole);
    row("0.5");
    folder.succeed(&job);
    assert!(folder.read("film.gif") != whole);
}

#[test]
fn the_part_that_ends_last_writes_the_film() {
    let folder = folder();
    let job = [
        &SMALL[..],
        &FILM,
        &["-o", "f.#.exr", "-o", "film.apng", "--progress", "none"],
    ]
    .concat();
    let output = folder.run(&[&job[..], &["--part", "2/2"]].concat());
    assert!(output.status.success() && !folder.path("film.apng").exists());
    let said = stderr(&output);
    assert!(said.contains("the part that ends last writes it"), "{said}");
    folder.succeed(&[&job[..], &["--part", "1/2"]].concat());
    let apng = png::Decoder::new(std::io::Cursor::new(folder.read("film.apng")));
    let apng = apng.read_info().expect("a PNG");
    assert_eq!(apng.info().animation_control().expect("a film").num_frames, 3);
}

#[test]
fn a_film_of_parts_with_clear_pixels_is_that_of_the_whole_job() {
    let folder = folder();
    let clear = SMALL_SCENE.replace("color = [0.2, 0.4, 0.8]", "color = [0.2, 0.4, 0.8]\nvisible = false");
    let lamp = "[material.lamp]\nemitter = { radiance = 4 }\n[[object]]\nmaterial = \"lamp\"\n\
                shape.sphere = { center = [1, 2, 0], radius = 0.7 }\n";
    folder.write("s.toml", &format!("{clear}{lamp}"));
    // PNG files have lost the light of what covers a part of a pixel; EXR files of 32 bits have all of it.
    let files = [
        "-o",
        "f.#.png",
        "-o",
        "f.#.exr",
        "--exr-type",
        "float",
        "--progress",
        "none",
    ];
    let job = |film| [&SMALL[..], &FILM, &files, &["-o", film]].concat();
    folder.succeed(&job("whole.apng"));
    for part in ["1/2", "2/2"] {
        folder.succeed(&[&job("parts.apng")[..], &["--part", part]].concat());
    }
    assert!(folder.read("parts.apng") == folder.read("whole.apng"));
}

#[test]
fn what_makes_no_sense_with_a_film_is_refused_before_the_scene_is_loaded() {
    let folder = folder();
    let missing = SMALL_SCENE.replace(
        "sphere = { center = [-1, 1, 0], radius = 1 }",
        "mesh = { file = \"none.obj\" }",
    );
    folder.write("s.toml", &missing);
    for (more, message) in [
        (
            &["-o", "film.####.gif"][..],
            "whose name has no field for the frame's number: film.####.gif",
        ),
        (&["-o", "film.{frame}.apng"], "whose name has no field"),
        (
            &["-o", "film.gif", "--resolution", "65536x2"],
            "a GIF has at most 65535 columns and rows, not 65536x2: film.gif",
        ),
        (
            &["-o", "f.jpg", "--resolution", "2x65536"],
            "a jpg file has at most 65535 columns and rows, not 2x65536",
        ),
        (
            &["-o", "film.gif", "--metadata", "ids"],
            "--metadata writes files beside those of the frames",
        ),
        (
            &["-o", "film.gif", "--checkpoint", "1s"],
            "--checkpoint writes files beside those of the frames",
        ),
    ] {
        let said = folder.fail(2, &[&["s.toml"], more].concat());
        assert!(said.contains(message), "{more:?}: {said}");
    }
    for command in [
        &["submit", "s.toml", "--engine", "slurm", "--bundle", "b"][..],
        &["check", "s.toml"],
        &["bench", "s.toml"],
    ] {
        for more in [&["-o", "film.gif"][..], &["-o", "-"]] {
            let said = folder.fail(2, &[command, more].concat());
            assert!(said.contains("-o - and -o film.gif: only a job"), "{said}");
        }
    }
    assert_eq!(folder.names(), ["path.csv", "s.toml"]);
}

#[test]
fn a_list_of_stale_frames_needs_files_of_frames() {
    let folder = folder();
    let said = folder.fail(2, &[&SMALL[..], &["-o", "film.gif", "--list-stale"]].concat());
    assert!(said.contains("the frames have no files"), "{said}");
}

#[test]
fn a_film_may_have_the_signs_of_fields_in_its_name() {
    let folder = folder();
    folder.succeed(&[&SMALL[..], &["-o", "take %#2.gif"]].concat());
    assert_eq!(folder.names(), ["path.csv", "s.toml", "take #2.gif"]);
}
