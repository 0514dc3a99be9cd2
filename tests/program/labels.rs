//! Labels of pictures, `coco.json` and `ids.json`: of models that change, of parts of a job, and their categories.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::common::{Folder, stderr};

/// A model of some triangles beside each other, each an object of this name.
fn model(names: &[&str]) -> String {
    let mut text = String::new();
    for (i, name) in names.iter().enumerate() {
        let x = i as f32;
        text += &format!("o {name}\nv {x} 0 0\nv {} 0 0\nv {x} 1 0\n", x + 0.9);
        text += &format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    text
}

const SCENE: &str = "[render]\nwidth = 32\nheight = 24\nsamples = 1\n\
    [camera]\nperspective = { eye = [0.5, 1, 6], target = [0.5, 1, 0], fov = 40 }\n[background]\ncolor = 0.5\n\
    [material.wood]\nmatte = { albedo = 0.5 }\n[material.rubber]\nmatte = { albedo = 0.2 }\n\
    [[object]]\nname = \"thing\"\nmaterial = \"wood\"\nshape.mesh = { file = \"things/chair_01.obj\" }\n\
    [[object]]\nname = \"ball\"\nmaterial = \"rubber\"\nshape.sphere = { center = [0.5, 2, 0], radius = 0.5 }\n";

/// Whether the thing is a chair in each frame.
const IS_CHAIR: [bool; 5] = [true, false, false, true, false];

/// A scene whose first object is a chair or a table.
fn folder() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("things")).expect("made");
    folder.write("things/chair_01.obj", &model(&["leg_1", "leg_2"]));
    folder.write("things/table_02.obj", &model(&["top"]));
    folder.write("s.toml", SCENE);
    let row = |(i, is_chair): (usize, bool)| {
        let name = if is_chair { "chair_01" } else { "table_02" };
        format!("{},things/{name}.obj\n", i + 1)
    };
    let rows: String = IS_CHAIR.into_iter().enumerate().map(row).collect();
    folder.write("v.csv", &format!("frame,object.thing.shape.mesh.file\n{rows}"));
    folder
}

const JOB: [&str; 6] = ["s.toml", "--values", "v.csv", "--metadata", "coco,ids", "--png-ids"];

fn job(folder: &Folder, output: &str, more: &[&str]) {
    folder.succeed(&[&JOB[..], &["-q", "-o", output], more].concat());
}

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&folder.read(name)).expect("JSON")
}

fn list<'v>(value: &'v Value, key: &str) -> &'v Vec<Value> {
    value[key].as_array().expect("a list")
}

/// The names of the categories, and of those above them.
fn categories(file: &Value) -> Vec<(&str, &str)> {
    let all = list(file, "categories").iter();
    all.map(|category| (text(category, "name"), text(category, "supercategory")))
        .collect()
}

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value[key].as_str().expect("a text")
}

#[test]
fn frames_that_show_other_models_have_the_labels_of_these() {
    let folder = folder();
    job(&folder, "out/f.####.png", &[]);
    let file = json(&folder, "out/coco.json");
    assert_eq!(
        categories(&file),
        [("ball", "ball"), ("thing/leg", "thing"), ("thing/top", "thing")]
    );
    let ids = json(&folder, "out/ids.json");
    let names_of = |frame: usize| {
        let has = |table: &&Value| list(table, "frames").contains(&json!(frame));
        let mut tables = list(&ids, "tables").iter().filter(has);
        let table = tables.next().expect("the frame has names");
        assert!(tables.next().is_none());
        list(table, "objectId").clone()
    };
    for (i, is_chair) in IS_CHAIR.into_iter().enumerate() {
        let frame = i + 1;
        let names: &[&str] = match is_chair {
            true => &["thing/leg_1", "thing/leg_2", "ball"],
            false => &["thing/top", "ball"],
        };
        assert_eq!(names_of(frame), names);
        let picture = image::open(folder.path(&format!("out/ids.{frame:04}.png"))).expect("a PNG");
        let numbers = picture.into_luma16().into_raw();
        let of_frame = list(&file, "annotations")
            .iter()
            .filter(|own| own["image_id"] == json!(frame));
        let of_frame: Vec<&Value> = of_frame.collect();
        assert_eq!(of_frame.len(), names.len(), "frame {frame}");
        for annotation in of_frame {
            let object = annotation["object_id"].as_u64().expect("a number") as usize;
            let area = numbers.iter().filter(|number| usize::from(**number) == object).count();
            assert_eq!(annotation["area"], json!(area), "frame {frame}, object {object}");
            assert_eq!(annotation["object_name"], names[object - 1]);
            let category = annotation["category_id"].as_u64().expect("a number") as usize;
            let expected = names[object - 1].trim_end_matches(['_', '1', '2']);
            assert_eq!(categories(&file)[category - 1].0, expected);
        }
    }
}

#[test]
fn labels_of_frames_with_other_models_are_the_same_from_parts_in_any_order() {
    let folder = folder();
    job(&folder, "whole/f.####.png", &[]);
    for (name, ranges) in [
        ("rising", &["1", "2-3", "4-5"][..]),
        ("falling", &["5", "3-4", "1", "2"]),
    ] {
        for range in ranges {
            job(&folder, &format!("{name}/f.####.png"), &["--range", range]);
        }
        for file in ["coco.json", "ids.json"] {
            assert!(
                folder.read(&format!("{name}/{file}")) == folder.read(&format!("whole/{file}")),
                "{name}/{file}"
            );
        }
    }
    // A picture without a number shows the last frame.
    for range in ["1", "2"] {
        job(&folder, "still/f.png", &["--range", range]);
    }
    let ids = json(&folder, "still/ids.json");
    assert_eq!(
        (list(&ids, "tables").len(), &ids["tables"][0]["frames"]),
        (1, &json!([2]))
    );
    // A frame that is there is labelled as one that is rendered.
    std::fs::remove_file(folder.path("rising/coco.json")).expect("removed");
    job(&folder, "rising/f.####.png", &["--skip-existing"]);
    assert!(folder.read("rising/coco.json") == folder.read("whole/coco.json"));
}

#[test]
fn crops_in_one_folder_keep_the_labels_of_each_other() {
    let folder = folder();
    let crop = |name: &str, crop: &str, range: &str| {
        job(
            &folder,
            &format!("out/{name}.####.png"),
            &["--crop", crop, "--range", range],
        );
    };
    for range in ["2-3", "1"] {
        crop("left", "0,0,16,24", range);
        crop("right", "16,0,32,24", range);
    }
    let file = json(&folder, "out/coco.json");
    let image = |image: &Value| (image["id"].as_i64(), image["file_name"].as_str().map(str::to_owned));
    let images: BTreeSet<_> = list(&file, "images").iter().map(image).collect();
    let named = |name: &str, first: i64| {
        let name = name.to_owned();
        (1..=3).map(move |frame| (Some(first + frame), Some(format!("{name}.{frame:04}.png"))))
    };
    let expected: BTreeSet<_> = named("left", 0).chain(named("right", 1_000_000)).collect();
    assert_eq!(images, expected);
    let annotations = list(&file, "annotations");
    let numbers: BTreeSet<_> = annotations.iter().map(|own| own["id"].as_i64()).collect();
    assert_eq!(numbers.len(), annotations.len());
    let area = |annotations: &[Value], image: i64| -> u64 {
        let own = annotations.iter().filter(|own| own["image_id"] == json!(image));
        own.map(|own| own["area"].as_u64().expect("a number")).sum()
    };
    job(&folder, "whole/f.####.png", &[]);
    let whole = json(&folder, "whole/coco.json");
    for frame in 1..=3 {
        let halves = area(annotations, frame) + area(annotations, 1_000_000 + frame);
        assert_eq!(halves, area(list(&whole, "annotations"), frame), "frame {frame}");
    }
    // Labels of pictures that are gone go with the next part.
    for frame in 1..=3 {
        std::fs::remove_file(folder.path(&format!("out/right.{frame:04}.png"))).expect("removed");
    }
    crop("left", "0,0,16,24", "1");
    let file = json(&folder, "out/coco.json");
    assert_eq!(list(&file, "images").len(), 3);
}

#[test]
fn damaged_labels_of_other_parts_stop_a_part_before_its_first_ray() {
    let folder = folder();
    job(&folder, "out/f.####.png", &["--range", "1"]);
    let whole = folder.read("out/coco.json");
    let half = &whole[..whole.len() / 2];
    std::fs::write(folder.path("out/coco.json"), half).expect("written");
    let job = [&JOB[..], &["-q", "-o", "out/f.####.png", "--range", "2"]].concat();
    let message = folder.fail(65, &job);
    assert!(
        message.starts_with("error: the labels of other pictures cannot be kept: ") && message.contains("coco.json"),
        "{message}"
    );
    assert!(folder.read("out/coco.json") == half && !folder.path("out/f.0002.png").exists());
    // A job of all frames needs none of them.
    folder.succeed(&job[..job.len() - 2]);
}

#[test]
fn categories_are_named_after_what_the_flag_says() {
    let folder = folder();
    let named = |scene: &str, kind: &str| {
        let output = format!("{kind}/f.####.png");
        let job = [
            scene,
            "--metadata",
            "coco",
            "--categories",
            kind,
            "--resolution",
            "32x24",
        ];
        folder.succeed(&[&job[..], &["--samples", "1", "-q", "-o", &output]].concat());
        json(&folder, &format!("{kind}/coco.json"))
    };
    for (kind, expected) in [
        ("object", &[("ball", "ball"), ("thing/leg", "thing")][..]),
        ("material", &[("rubber", "rubber"), ("wood", "wood")]),
        ("file", &[("ball", "ball"), ("chair", "things")]),
        ("scene", &[("s", "s")]),
    ] {
        let file = named("s.toml", kind);
        assert_eq!(categories(&file), expected, "{kind}");
        assert_eq!(list(&file, "annotations").len(), 3, "{kind}");
    }
    let whole = folder.path("things/chair_01.obj");
    let file = named(whole.to_str().expect("UTF-8"), "scene");
    assert_eq!(categories(&file), [("chair", "things")]);
    let message = folder.fail(2, &["s.toml", "--metadata", "coco", "--categories", "colour"]);
    assert!(
        message.contains("expected one of `object`, `material`, `file`, `scene`"),
        "{message}"
    );
}

#[test]
fn shadow_catchers_and_holdouts_are_no_categories() {
    let folder = Folder::new();
    let ball = |x: i32, more: &str| {
        format!(
            "[[object]]\nname = \"b{x}x\"\nmaterial = \"grey\"\nshape.sphere = {{ center = [{x}, 0, 0], radius = 1 }}\n{more}\n"
        )
    };
    let balls = [ball(0, ""), ball(3, "shadow_catcher = true"), ball(6, "holdout = true")].concat();
    let camera = "[camera]\nperspective = { eye = [3, 0, 12], target = [3, 0, 0] }\n";
    folder.write(
        "s.toml",
        &format!("{camera}[material.grey]\nmatte = {{ albedo = 0.5 }}\n{balls}"),
    );
    let job = [
        "s.toml",
        "--metadata",
        "coco",
        "--resolution",
        "32x24",
        "--samples",
        "1",
        "-q",
    ];
    for kind in ["object", "file"] {
        folder.succeed(&[&job[..], &["--categories", kind, "-o", &format!("{kind}/f.png")]].concat());
        let file = json(&folder, &format!("{kind}/coco.json"));
        assert_eq!(categories(&file), [("b0x", "b0x")], "{kind}");
        assert_eq!(list(&file, "annotations").len(), 1, "{kind}");
    }
}

#[test]
fn an_object_of_two_materials_is_an_instance_of_each() {
    let folder = Folder::new();
    folder.write("m.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue_2\nKd 0 0 1\n");
    folder.write(
        "m.obj",
        "mtllib m.mtl\no flag\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl red\nf 1 2 3\nusemtl blue_2\nf 2 4 3\n",
    );
    let job = [
        "m.obj",
        "--metadata",
        "coco",
        "--resolution",
        "32x24",
        "--samples",
        "1",
        "-q",
    ];
    for (kind, count) in [("object", 1), ("material", 2)] {
        folder.succeed(&[&job[..], &["--categories", kind, "-o", "f.png"]].concat());
        let file = json(&folder, "coco.json");
        let annotations = list(&file, "annotations");
        assert_eq!(annotations.len(), count, "{kind}");
        let numbers: BTreeSet<_> = annotations.iter().map(|own| own["id"].as_i64()).collect();
        assert_eq!(numbers.len(), count, "{kind}");
    }
    assert_eq!(
        categories(&json(&folder, "coco.json")),
        [("blue", "blue"), ("red", "red")]
    );
}

#[test]
fn ranges_of_samples_have_the_labels_of_all() {
    let folder = folder();
    let run = |output: &str, more: &[&str]| {
        let job = [
            "s.toml",
            "--samples",
            "4",
            "--metadata",
            "coco",
            "--progress",
            "none",
            "-o",
            output,
        ];
        let output = folder.run(&[&job[..], more].concat());
        assert!(
            output.status.success() && output.stderr.is_empty(),
            "{}",
            stderr(&output)
        );
    };
    run("whole/f.exr", &[]);
    let whole = json(&folder, "whole/coco.json");
    assert!(!list(&whole, "annotations").is_empty());
    for range in ["1/3", "2/3", "3/3"] {
        run("parts/f.exr", &["--sample-range", range]);
        let part = json(
            &folder,
            &format!("parts/samples-{}/coco.json", range.replace('/', "-of-")),
        );
        assert_eq!(part["annotations"], whole["annotations"], "{range}");
    }
}

#[test]
fn pictures_that_transforms_json_no_longer_lists_are_named() {
    let folder = folder();
    let said = |output: &str, crop: &str| {
        let job = [
            "s.toml",
            "--metadata",
            "transforms",
            "--progress",
            "none",
            "--range",
            "1",
        ];
        let output = folder.run(&[&job[..], &["-o", output, "--crop", crop]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    assert_eq!(said("left.png", "0,0,16,24"), "");
    assert_eq!(said("left.png", "0,0,16,24"), "");
    let warning = "warning: transforms.json no longer lists left.png, of another job";
    assert!(said("right.png", "16,0,32,24").starts_with(warning));
    std::fs::remove_file(folder.path("right.png")).expect("removed");
    assert_eq!(said("left.png", "0,0,16,24"), "");
}

#[test]
fn a_model_by_itself_is_below_its_folder_and_files_of_one_name_have_two() {
    let folder = Folder::new();
    let job = [
        "--metadata",
        "coco",
        "--categories",
        "file",
        "--resolution",
        "32x24",
        "--samples",
        "1",
        "-q",
    ];
    for name in ["oak", "elm"] {
        std::fs::create_dir(folder.path(name)).expect("made");
        folder.write(&format!("{name}/chair.obj"), &model(&["leg"]));
    }
    folder.succeed(&[&["oak/chair.obj", "-o", "one/f.png"], &job[..]].concat());
    assert_eq!(categories(&json(&folder, "one/coco.json")), [("chair", "oak")]);
    // The first part does not know of the other file.
    for (name, frame) in [("oak", "1"), ("elm", "2"), ("oak", "3")] {
        let scene = format!("{name}/chair.obj");
        let output = ["-o", "all/f.#.png", "--turntable", "36", "--range", frame];
        folder.succeed(&[&[&scene[..]], &output[..], &job[..]].concat());
    }
    let file = json(&folder, "all/coco.json");
    assert_eq!(categories(&file), [("elm/chair", "elm"), ("oak/chair", "oak")]);
    let of = |at: usize| list(&file, "annotations")[at]["category_id"].as_u64();
    assert_eq!([of(0), of(1), of(2)], [Some(2), Some(1), Some(2)]);
}

#[test]
fn parts_in_folders_of_their_own_number_files_alike_and_mixed_kinds_are_a_warning() {
    let folder = folder();
    let job = |output: &str, kind: &str, range: &str| {
        let args = [
            "--categories",
            kind,
            "--range",
            range,
            "-o",
            output,
            "--progress",
            "none",
        ];
        let output = folder.run(&[&JOB[..], &args].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    for range in ["1", "2"] {
        assert_eq!(job(&format!("{range}/f.#.png"), "file", range), "");
    }
    let [one, two] = ["1", "2"].map(|part| json(&folder, &format!("{part}/coco.json")));
    let expected = [("ball", "ball"), ("chair", "things"), ("table", "things")];
    assert_eq!(
        (&categories(&one)[..], &categories(&two)[..]),
        (&expected[..], &expected[..])
    );
    let said = job("1/f.#.png", "object", "2");
    assert!(
        said.contains("the categories of this job are named after `object`, those of other pictures after `file`"),
        "{said}"
    );
}
