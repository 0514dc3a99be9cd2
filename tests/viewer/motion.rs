//! A scene that moves: the view is that of the frame of the timeline.

use serde_json::{Value, json};

use crate::{
    client::{Fly, Page},
    common::{MOVING_MODEL, SMALL_SCENE},
};

/// A table that moves, dims and removes things.
const TABLE: &str = "frame, object.red.transform.translate.x, light.key.point.intensity, object.blue.visible\n\
                     1, 0, 60, true\n5, -2, 10, true\n6, -2, 10, false\n";

/// The small scene with parts for the table, with these lines before its first table and of its camera.
fn scene(head: &str, camera: &str) -> String {
    let own = SMALL_SCENE.replace("[background]", &format!("{camera}\n[background]"));
    format!(
        "{head}\n{own}\n[[object]]\nname = \"red\"\nmaterial = \"red\"\nshape.sphere = {{ center = [1, 1, 2], radius = 0.4 }}\n\
         transform = {{ translate = [0, 0, 0] }}\n[[object]]\nname = \"blue\"\nmaterial = \"floor\"\n\
         shape.sphere = {{ center = [0, 2, 0], radius = 0.3 }}\n\
         [[light]]\nname = \"key\"\npoint = {{ position = [3, 4, 5], intensity = 60 }}\n"
    )
}

/// The last picture of each of these frames, and that of the job.
fn stills_and_files(fly: &Fly, page: &mut Page, frames: &[i32], args: &[&str]) -> Vec<[Vec<u8>; 2]> {
    let of_frame = |frame: &i32| {
        let range = frame.to_string();
        let job = ["--range", &range, "--progress", "none", "-o", "own.####.png"];
        fly.folder.succeed(&[args, &job[..]].concat());
        page.ask(json!({ "t": "frame", "frame": frame }));
        [page.picture(true).1, fly.folder.read(&format!("own.{frame:04}.png"))]
    };
    frames.iter().map(of_frame).collect()
}

#[test]
fn a_still_of_frame_n_of_a_table_is_the_file_of_the_job() {
    let fly = Fly::of(&scene("values = \"table.csv\"", ""), &[("table.csv", TABLE)], &[]);
    let mut page = fly.page();
    let found = stills_and_files(&fly, &mut page, &[3, 6, 1, 5], &["scene.toml"]);
    for [still, file] in &found {
        assert_eq!(still, file);
    }
    assert!(found[0][0] != found[1][0] && found[1][0] != found[2][0] && found[1][0] != found[3][0]);
    // Looks are of the scene of the frame as well.
    let mut look = page.facts["look"].clone();
    look["exposure"] = json!(0.5);
    page.ask(json!({ "t": "look", "look": look }));
    let still = page.picture(true).1;
    fly.folder.succeed(&[
        "scene.toml",
        "--range",
        "5",
        "--exposure",
        "0.5",
        "--progress",
        "none",
        "-o",
        "look.####.png",
    ]);
    assert_eq!(still, fly.folder.read("look.0005.png"));
    assert_eq!(fly.folder.read("table.csv"), TABLE.as_bytes());
}

#[test]
fn a_table_of_a_flag_is_that_of_the_view_and_of_the_command() {
    let args = ["--values", "table.csv"];
    let fly = Fly::of(&scene("", ""), &[("table.csv", TABLE)], &args);
    let mut page = fly.page();
    assert_eq!(page.hello["frames"], json!([1, 6]));
    let command = page.facts["command"].as_str().expect("a command");
    assert!(command.contains("--values=table.csv"), "{command}");
    for [still, file] in stills_and_files(&fly, &mut page, &[4], &["scene.toml", "--values", "table.csv"]) {
        assert_eq!(still, file);
    }
}

#[test]
fn a_blurred_still_is_the_file_of_the_job() {
    let scene = scene("values = \"table.csv\"", "shutter = [-0.25, 0.5]");
    let fly = Fly::of(&scene, &[("table.csv", TABLE)], &[]);
    let mut page = fly.page();
    for [still, file] in stills_and_files(&fly, &mut page, &[3, 9], &["scene.toml"]) {
        assert_eq!(still, file);
    }
}

#[test]
fn the_pointer_finds_what_is_there_at_the_frame() {
    let fly = Fly::of(&scene("values = \"table.csv\"", ""), &[("table.csv", TABLE)], &[]);
    let mut page = fly.page();
    let object_at = |page: &mut Page, frame: i32| -> Value {
        page.ask(json!({ "t": "frame", "frame": frame }));
        let camera = json!({ "eye": [1, 1, 6], "target": [1, 1, 2], "up": [0, 1, 0] });
        page.ask(json!({ "t": "view", "camera": camera }));
        page.picture(true);
        page.send(&json!({ "t": "pick", "id": 1, "x": 0.5, "y": 0.5 }));
        page.told("picked")["found"]["object"].clone()
    };
    assert_eq!(object_at(&mut page, 1), "red");
    assert_ne!(object_at(&mut page, 5), "red");
    assert_eq!(object_at(&mut page, 1), "red");
}

#[test]
fn a_frame_that_cannot_be_made_is_said_and_the_next_one_is_shown() {
    let table = "frame, object.box.shape.cuboid.min.x, object.box.shape.cuboid.max.x\n1, 0, 3\n5, 2, 3\n9, 2, 1\n";
    let scene = scene("values = \"table.csv\"", "")
        + "[[object]]\nname = \"box\"\nmaterial = \"red\"\nshape.cuboid = { min = [0, 0, -3], max = [3, 1, -2] }\n";
    let fly = Fly::of(&scene, &[("table.csv", table)], &[]);
    let mut page = fly.page();
    page.ask(json!({ "t": "frame", "frame": 9 }));
    let error = loop {
        let facts = page.told("scene");
        if facts["frame_error"] != "" {
            break facts["frame_error"].as_str().expect("a text").to_owned();
        }
    };
    assert!(error.contains("object.box.shape.cuboid"), "{error}");
    for [still, file] in stills_and_files(&fly, &mut page, &[5], &["scene.toml"]) {
        assert_eq!(still, file);
    }
}

#[test]
fn a_still_of_frame_n_of_an_animation_is_the_file_of_the_job() {
    let args = ["--animation", "Walk", "--resolution", "40x30", "--samples", "4"];
    let fly = Fly::of_files(&[("a.gltf", MOVING_MODEL)], &args);
    let mut page = fly.page();
    let job = [&["a.gltf"], &args[..]].concat();
    let found = stills_and_files(&fly, &mut page, &[0, 6, 12, 3], &job);
    for [still, file] in &found {
        assert_eq!(still, file);
    }
    assert_ne!(found[0][0], found[1][0]);
}

#[test]
fn values_in_columns_of_the_camera_path_are_shown_and_stay_in_the_file() {
    let path = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,object.blue.visible\n\
                1,0,2,6,0,0.8,0,true\n5,2,2,5,0,0.8,0,false\n";
    let fly = Fly::of(&scene("", "shutter = [0, 0.5]"), &[("path.csv", path)], &[]);
    let mut page = fly.page();
    for [still, file] in stills_and_files(&fly, &mut page, &[3, 5], &["scene.toml", "--frames", "path.csv"]) {
        assert_eq!(still, file);
    }
    page.send(&json!({ "t": "move", "from": 5, "to": 7 }));
    page.send(&json!({ "t": "save" }));
    assert_eq!(page.told("note")["is_error"], false);
    assert_eq!(fly.folder.read("path.csv"), path.replace("\n5,", "\n7,").as_bytes());
}

#[test]
fn a_still_of_a_model_by_itself_with_a_table_is_the_file_of_the_job() {
    let table =
        "frame,interp,node.0.transform.translate.x,light.light 1.sun.irradiance\n1,linear,0,2\n5,linear,-1,0.5\n";
    let size = ["--resolution", "24x16", "--samples", "2", "--values", "v.csv"];
    let fly = Fly::of_files(&[("a.gltf", MOVING_MODEL), ("v.csv", table)], &size);
    let mut page = fly.page();
    assert_eq!(page.hello["frames"], json!([1, 5]));
    let found = stills_and_files(&fly, &mut page, &[4, 1], &[&["a.gltf"], &size[..]].concat());
    for [still, file] in &found {
        assert_eq!(still, file);
    }
    assert!(found[0][0] != found[1][0]);
}

#[test]
fn the_scenes_own_camera_moves_with_its_table_until_the_user_moves_it() {
    let table = "frame, camera.perspective.eye.x, camera.perspective.fov, object.blue.visible\n1, 0, 40, true\n5, 3, 60, false\n";
    let scene = scene("values = \"table.csv\"", "shutter = [0, 0.5]");
    let fly = Fly::of(&scene, &[("table.csv", table)], &[]);
    let mut page = fly.page();
    let follows = |page: &mut Page| {
        for [still, file] in stills_and_files(&fly, page, &[3, 9], &["scene.toml"]) {
            assert_eq!(still, file);
        }
    };
    follows(&mut page);
    let at = |page: &mut Page, frame: i32| {
        page.ask(json!({ "t": "frame", "frame": frame }));
        page.picture(true).0["camera"].clone()
    };
    let camera = at(&mut page, 5);
    assert_eq!(
        (&camera["eye"], &camera["lens"]["fov"]),
        (&json!([3.0, 2.0, 6.0]), &json!(60.0))
    );
    let own = json!({ "eye": [1.0, 1.0, 6.0], "target": [1.0, 1.0, 2.0], "up": [0.0, 1.0, 0.0] });
    page.ask(json!({ "t": "view", "camera": own }));
    for frame in [1, 4] {
        assert_eq!(at(&mut page, frame)["eye"], own["eye"]);
    }
    page.ask(json!({ "t": "home" }));
    follows(&mut page);
}

/// Asserts that less than a fiftieth of the numbers of two pictures differs.
fn assert_similar(pictures: [Vec<u8>; 2]) {
    let [a, b] = pictures.map(|png| image::load_from_memory(&png).expect("a PNG").into_rgb8());
    let far = a.iter().zip(b.iter()).filter(|(a, b)| a.abs_diff(**b) > 8).count();
    assert!(far * 50 < a.len(), "{far} of {}", a.len());
}

#[test]
fn the_camera_keeps_the_intrinsics_of_the_path_that_it_leaves() {
    let head = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,fx,width,height\n";
    let path = format!("{head}1,0,2,6,0,0.8,0,150,70,50\n5,2,2,5,0,0.8,0,150,70,50\n");
    let fly = Fly::start(Some(&path), &[]);
    let mut page = fly.page();
    page.ask(json!({ "t": "frame", "frame": 1 }));
    let (on, with_path) = page.picture(true);
    page.ask(json!({ "t": "view", "camera": on["camera"] }));
    let (off, without) = page.picture(true);
    assert_eq!((&on["on_path"], &off["on_path"]), (&json!(true), &json!(false)));
    assert_eq!(on["lens"], off["lens"]);
    assert_similar([with_path, without]);
    // And has the lens of the scene at home.
    page.ask(json!({ "t": "home" }));
    assert!(page.picture(false).0["lens"] != on["lens"]);
}

#[test]
fn a_camera_wider_than_half_of_all_directions_is_flown_from_where_its_table_has_moved_it() {
    let table = "frame, camera.fisheye.fov\n1, 200\n5, 300\n";
    let scene = scene("values = \"table.csv\"", "shutter = [0, 0]");
    let lens =
        "perspective = { eye = [0, 2, 6], target = [0, 0.8, 0], fov = 40, aperture_radius = 0.05, focus_distance = 6 }";
    let scene = scene.replace(lens, "fisheye = { eye = [0, 2, 6], target = [0, 0.8, 0] }");
    let fly = Fly::of(&scene, &[("table.csv", table)], &[]);
    let mut page = fly.page();
    page.ask(json!({ "t": "frame", "frame": 5 }));
    let (home, at_home) = page.picture(true);
    page.ask(json!({ "t": "view", "camera": home["camera"] }));
    let (away, flown) = page.picture(true);
    assert_eq!(
        (home["lens"]["fov"].as_f64(), &home["lens"]),
        (Some(300.0), &away["lens"])
    );
    assert_similar([at_home, flown]);
    let mut camera = home["camera"].clone();
    camera["eye"][1] = json!(5);
    page.ask(json!({ "t": "view", "camera": camera }));
    assert_eq!(page.picture(true).0["camera"]["eye"][1], 5.0);
}
