//! Pictures of two eyes.

use std::collections::BTreeMap;

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, repo_str};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};

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
    assert!(said.contains("eye 2 of 2: a.toml, right eye"), "{said}");
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
fn eyes_are_as_far_apart_as_their_row_of_the_camera_path_says() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let header = "frame,eye_x,eye_y,eye_z,qx,qy,qz,qw,interp,ipd";
    folder.write(
        "p.csv",
        &format!("{header}\n1,0,1,5,0,0,0,1,linear,0.1\n3,0,1,5,0,0,0,1,,0.3\n"),
    );
    let job = [
        "a.toml",
        "--frames",
        "p.csv",
        "--stereo",
        "ipd=7",
        "--metadata",
        "transforms",
        "-o",
        "{eye}/####.exr",
    ];
    folder.succeed(&[&job[..], &SMALL[..]].concat());
    for (eye, side) in [("left", -1.0), ("right", 1.0)] {
        let text = folder.read(&format!("{eye}/transforms.json"));
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        for (i, half) in [0.05, 0.1, 0.15].into_iter().enumerate() {
            let x = json["frames"][i]["transform_matrix"][0][3].as_f64().expect("a number");
            assert!((x - side * half).abs() < 1e-9, "{eye} {i}: {x}");
        }
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

/// The bits of the numbers of each channel of an EXR file, with their place: width and height.
fn channels(folder: &Folder, name: &str) -> ([usize; 2], BTreeMap<String, Vec<u32>>) {
    let reader = read().no_deep_data().largest_resolution_level().all_channels();
    let image = reader.all_layers().all_attributes().from_file(folder.path(name));
    let image = image.expect("an EXR");
    let bits = |samples: &FlatSamples| match samples {
        FlatSamples::F16(v) => v.iter().map(|v| u32::from(v.to_bits())).collect(),
        FlatSamples::F32(v) => v.iter().map(|v| v.to_bits()).collect(),
        FlatSamples::U32(v) => v.clone(),
    };
    let list = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    let size = image.layer_data[0].size;
    let display = image.attributes.display_window.size;
    assert_eq!(size, display, "{name}");
    let channels = list.map(|c| (c.name.to_string(), bits(&c.sample_data))).collect();
    ([size.0, size.1], channels)
}

/// The half of a picture of two eyes, whose layout is `layout`, that shows this one.
fn half<T: Copy>(whole: &[T], [width, height]: [usize; 2], layout: &str, eye: &str) -> Vec<T> {
    let is_second = usize::from(eye == "right");
    let pixel = |i: usize| match layout {
        "side-by-side" => i / width * 2 * width + is_second * width + i % width,
        _ => is_second * width * height + i,
    };
    (0..width * height).map(|i| whole[pixel(i)]).collect()
}

const PASSES: &str = "scenes/passes/scene.toml";

/// Jobs whose eyes see different things, with passes of all kinds, with other numbers of samples for each block, and with motion blur.
const PAIRS: [&[&str]; 4] = [
    &[PASSES, "--aovs", "all", "--samples", "3"],
    &[
        PASSES,
        "--turntable",
        "2",
        "--range",
        "2",
        "--noise-threshold",
        "0.05",
        "--samples",
        "64",
    ],
    &["s.toml", "--show", "objectId", "--multipart"],
    &[
        "s.toml",
        "--frames",
        "path.csv",
        "--range",
        "2",
        "--exposure",
        "auto",
        "--samples",
        "2",
        "--tiled",
    ],
];

#[test]
fn halves_of_a_picture_of_both_eyes_have_the_bits_of_each_eye_by_itself() {
    const SIZE: [usize; 2] = [48, 27];
    for job in PAIRS {
        let folder = Folder::new();
        let passes = repo_str(PASSES);
        let job: Vec<_> = job
            .iter()
            .map(|word| if *word == PASSES { &passes } else { *word })
            .collect();
        folder.write("s.toml", SMALL_SCENE);
        folder.write("path.csv", SMALL_PATH);
        let of = |stereo: &str, out: &str| {
            let files = ["exr", "png", "npz"].map(|ending| format!("{out}.{ending}"));
            let files = files.iter().flat_map(|file| ["-o", &file[..]]);
            let more = ["--resolution", "48x27", "--stereo", stereo];
            folder.succeed(&[&job[..], &more, &files.collect::<Vec<_>>()].concat());
        };
        for layout in ["side-by-side", "top-bottom"] {
            of(&format!("ipd=0.3,convergence=4,layout={layout}"), layout);
            let factors = if layout == "top-bottom" { [1, 2] } else { [2, 1] };
            let (size, whole) = channels(&folder, &format!("{layout}.exr"));
            assert_eq!(size, [SIZE[0] * factors[0], SIZE[1] * factors[1]]);
            let picture = image::open(folder.path(&format!("{layout}.png")))
                .expect("a PNG")
                .into_rgba8();
            let picture: Vec<_> = picture.pixels().copied().collect();
            for eye in ["left", "right"] {
                of(&format!("ipd=0.3,convergence=4,eye={eye}"), eye);
                let (size, own) = channels(&folder, &format!("{eye}.exr"));
                assert_eq!(size, SIZE);
                assert!(whole.keys().eq(own.keys()), "{job:?}");
                for (name, values) in &own {
                    assert!(
                        &half(&whole[name], SIZE, layout, eye) == values,
                        "{job:?} {layout} {eye}: {name}"
                    );
                }
                let own = image::open(folder.path(&format!("{eye}.png")))
                    .expect("a PNG")
                    .into_rgba8();
                let own: Vec<_> = own.pixels().copied().collect();
                assert!(half(&picture, SIZE, layout, eye) == own, "{job:?} {layout} {eye}");
            }
        }
        let [left, right] = ["left", "right"].map(|eye| channels(&folder, &format!("{eye}.exr")));
        assert!(left != right, "{job:?}");
    }
}

#[test]
fn a_picture_of_both_eyes_is_known_again_by_its_layout_and_its_eyes() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let job = |stereo: &str, more: &[&str]| {
        let job = ["a.toml", "--turntable", "2", "-o", "f.#.exr", "--stereo", stereo];
        folder.succeed(&[&job[..], more, &SMALL[..]].concat())
    };
    job("ipd=0.2,layout=side-by-side", &["--threads", "1"]);
    let whole = folder.read("f.2.exr");
    assert!(job("ipd=0.2,layout=side-by-side", &["--skip-existing"]).contains("0 frames rendered, 2 skipped"));
    for other in [
        "ipd=0.2,layout=top-bottom",
        "ipd=0.3,layout=side-by-side",
        "ipd=0.2,eye=left",
    ] {
        let stale = job(other, &["--list-stale"]);
        assert_eq!(stale.lines().count(), 2, "{other}: {stale}");
    }
    job("ipd=0.2,layout=side-by-side", &["--threads", "3"]);
    assert!(folder.read("f.2.exr") == whole);
    let said = job("ipd=0.2,layout=top-bottom", &["--stats", "s.json"]);
    assert!(!said.contains("scene 1 of"), "{said}");
    let figures: serde_json::Value = serde_json::from_slice(&folder.read("s.json")).expect("JSON");
    assert_eq!(figures["resolution"], serde_json::json!([16, 24]));
    let whole = 2 * 16 * 12 * 2;
    assert!(
        figures["frames"]
            .as_array()
            .expect("frames")
            .iter()
            .all(|frame| frame["samples"] == whole),
        "{figures}"
    );
}

#[test]
fn what_works_on_one_camera_is_refused_for_pictures_of_both_eyes() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    for (flags, named) in [
        (&["--crop", "0,0,8,8"][..], "--crop"),
        (&["--overscan", "2"], "--overscan"),
        (&["--denoise"], "--denoise"),
        (&["--time-limit", "1s"], "--time-limit"),
        (&["--checkpoint", "1s"], "--checkpoint"),
        (&["--keep-sums"], "--keep-sums"),
        (&["--metadata", "transforms"], "--metadata"),
        (&["--metadata", "ids,coco"], "--metadata"),
    ] {
        let job = ["a.toml", "--stereo", "ipd=0.06,layout=top-bottom", "-o", "f.exr"];
        let said = folder.fail(2, &[&job[..], flags, &SMALL[..]].concat());
        let expected = format!("--stereo with layout=top-bottom: {named}");
        assert!(said.contains(" can only work on the picture of one eye"), "{said}");
        assert!(said.contains(&expected) && said.contains("{eye}"), "{said}");
    }
    let job = [
        "a.toml",
        "--stereo",
        "ipd=0.06,layout=top-bottom",
        "--metadata",
        "ids",
        "-o",
        "f.exr",
    ];
    folder.succeed(&[&job[..], &SMALL[..]].concat());
    let said = folder.fail(
        2,
        &[
            "a.toml",
            "--stereo",
            "ipd=0.06,layout=top-bottom",
            "-o",
            "f.jpg",
            "--resolution",
            "2x40000",
        ],
    );
    assert!(
        said.contains("a jpg file has at most 65535 columns and rows, not 2x80000"),
        "{said}"
    );
}

#[test]
fn files_beside_the_pictures_of_one_eye_leave_those_of_the_other() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let sidecars = "transforms,colmap,coco,ids";
    let job = |stereo: &str, out: &str| {
        let job = [
            "a.toml",
            "--stereo",
            stereo,
            "--metadata",
            sidecars,
            "--png-depth",
            "-o",
            out,
        ];
        folder.succeed(&[&job[..], &SMALL[..]].concat())
    };
    for eye in ["left", "right"] {
        job(&format!("ipd=0.2,eye={eye}"), &format!("one/{eye}.png"));
    }
    job("ipd=0.2", "both/{eye}.png");
    job("ipd=0.2", "each/{eye}/f.png");
    for eye in ["left", "right"] {
        for name in ["transforms", "coco", "ids"] {
            let one = folder.read(&format!("one/{name}.{eye}.json"));
            assert!(folder.read(&format!("both/{name}.{eye}.json")) == one, "{name}");
            assert!(folder.path(&format!("each/{eye}/{name}.json")).exists(), "{name}");
        }
        let images = |path: String| String::from_utf8(folder.read(&path)).expect("UTF-8");
        assert!(images(format!("one/sparse/{eye}/images.txt")).contains(&format!("{eye}.png")));
        assert!(images(format!("each/{eye}/sparse/0/images.txt")).contains("f.png"));
        let depth = folder.read(&format!("one/depth.{eye}.0001.png"));
        assert!(folder.read(&format!("each/{eye}/depth.0001.png")) == depth);
    }
}

#[test]
fn figures_and_the_page_of_one_eye_name_it() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let figures = ["--report", "page", "--stats", "stats.json", "-o", "f.png"];
    let files = |stereo: &[&str]| {
        folder.succeed(&[&["a.toml"], stereo, &figures[..], &SMALL[..]].concat());
        let stats: serde_json::Value = serde_json::from_slice(&folder.read("stats.json")).expect("JSON");
        let page = String::from_utf8(folder.read("page/index.html")).expect("UTF-8");
        (stats["eye"].clone(), page)
    };
    let (eye, page) = files(&["--stereo", "ipd=0.06,eye=right"]);
    assert_eq!(eye, "right");
    assert!(page.contains("<h1>a.toml, right eye</h1>"), "{page}");
    let (eye, page) = files(&["--stereo", "ipd=0.06,layout=side-by-side"]);
    assert!(eye.is_null() && page.contains("<h1>a.toml</h1>"), "{page}");
}

#[test]
fn messages_about_eyes_name_them() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let job = ["a.toml", "--stereo", "ipd=0.06"];
    let said = folder.fail(2, &[&job[..], &["-o", "-", "--output-format", "png"]].concat());
    assert!(said.contains("standard output holds the frames of one eye"), "{said}");
    let said = folder.fail(
        2,
        &["-", "--input-format", "toml", "--stereo", "ipd=0.06", "-o", "{eye}.png"],
    );
    assert!(said.contains("standard input (-) is read once"), "{said}");
    folder.write(
        "broken.toml",
        &SMALL_SCENE.replace("\"texture.board\"", "\"texture.none\""),
    );
    let said = folder.fail(1, &["broken.toml", "--stereo", "ipd=0.06", "-o", "{eye}.png"]);
    assert!(
        said.ends_with("error: 2 of 2 eyes failed: broken.toml, left eye; broken.toml, right eye\n"),
        "{said}"
    );
    folder.succeed(&[&job[..], &["-o", "{eye}.png", "--report", "page"], &SMALL[..]].concat());
    let page = String::from_utf8(folder.read("page/index.html")).expect("UTF-8");
    assert!(page.contains("<title>2 eyes: finished</title>"), "{page}");
}

#[test]
fn progress_of_open_job_description_rises_over_both_eyes() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let job = [
        "a.toml",
        "--stereo",
        "ipd=0.06",
        "-o",
        "{eye}.#.png",
        "--turntable",
        "2",
    ];
    let said = folder.succeed(&[&job[..], &["--progress", "openjd"], &SMALL[..]].concat());
    let parts = said.lines().filter_map(|line| line.strip_prefix("openjd_progress: "));
    assert_eq!(parts.collect::<Vec<_>>(), ["25.0", "50.0", "75.0", "100.0"]);
}

#[test]
fn files_of_one_eye_that_another_job_writes_end_with_the_code_of_busy_files() {
    let folder = Folder::new();
    folder.write("a.toml", SMALL_SCENE);
    let mut other = folder.program_with_signals();
    let other = other.args([
        "a.toml",
        "--stereo",
        "ipd=0.06,eye=left",
        "-o",
        "left/f.exr",
        "--samples",
        "1000000",
    ]);
    let mut other = other
        .args(["--progress", "json"])
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(other.stdout.take().expect("piped")));
    assert!(lines.next().expect("a line").expect("UTF-8").contains("frame_started"));
    let job = [
        "a.toml",
        "--stereo",
        "ipd=0.06",
        "-o",
        "{eye}/f.exr",
        "--if-busy",
        "leave",
    ];
    let said = folder.fail(75, &[&job[..], &SMALL[..]].concat());
    assert!(said.contains("1 of 2 eyes failed: a.toml, left eye"), "{said}");
    assert!(folder.path("right/f.exr").exists());
    other.kill().expect("killed");
    other.wait().expect("it ends");
    folder.succeed(&[&job[..], &SMALL[..]].concat());
}
