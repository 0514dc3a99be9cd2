//! A scene that changes on disk.

use serde_json::{Value, json};

use crate::{
    client::{Fly, Page},
    common::{SMALL_PATH, SMALL_SCENE},
};

/// The facts of the scene, as soon as they say so.
fn scene(page: &mut Page, is_so: impl Fn(&Value) -> bool) -> Value {
    loop {
        let facts = page.told("scene");
        if is_so(&facts) {
            return facts;
        }
    }
}

#[test]
fn a_scene_that_changes_on_disk_is_said_and_loaded_by_one_message() {
    let fly = Fly::start(Some(SMALL_PATH), &[]);
    let mut page = fly.page();
    let mut look = page.facts["look"].clone();
    look["exposure"] = json!(0.5);
    page.ask(json!({ "t": "look", "look": look }));
    page.ask(json!({ "t": "home" }));
    let old = page.picture(true).1;

    let changed = SMALL_SCENE
        .replace("samples = 20", "samples = 3")
        .replace("width = 70", "width = 60");
    fly.folder.write("scene.toml", &changed);
    scene(&mut page, |facts| facts["has_changed"] == true);
    // A job renders what the page shows.
    page.send(&json!({ "t": "render" }));
    let note = page.told("note");
    assert!(
        note["text"].as_str().is_some_and(|text| text.contains("reload")),
        "{note}"
    );
    assert_eq!(fly.still(), old);

    page.send(&json!({ "t": "reload" }));
    assert_eq!(page.told("hello")["resolution"], json!([60, 50]));
    let look = page.told("facts")["look"].clone();
    assert_eq!((&look["samples"], &look["exposure"]), (&json!(3), &json!(0.5)));
    let flags = ["--exposure", "0.5", "--progress", "none", "-o", "new.####.png"];
    fly.folder.succeed(&[&["scene.toml"], &flags[..]].concat());
    let new = fly.folder.read("new.0001.png");
    assert_eq!(page.picture(true).1, new);
    assert_eq!(fly.still(), new);
    page.send(&json!({ "t": "frame", "seq": 100, "frame": 1 }));
    page.send(&json!({ "t": "render" }));
    while page.told("job")["state"] != "done" {}
}

#[test]
fn a_scene_that_is_wrong_on_disk_is_said_to_be_so_and_the_old_one_stays() {
    let fly = Fly::start(None, &[]);
    let mut page = fly.page();
    page.ask(json!({ "t": "home" }));
    let old = page.picture(true).1;
    fly.folder
        .write("scene.toml", &SMALL_SCENE.replace("samples = 20", "samples"));
    scene(&mut page, |facts| facts["has_changed"] == true);
    page.send(&json!({ "t": "reload" }));
    let facts = scene(&mut page, |facts| facts["error"] != "");
    let error = facts["error"].as_str().expect("a text");
    assert!(error.contains("scene.toml") && facts["is_loading"] == false, "{facts}");
    page.ask(json!({ "t": "home" }));
    assert_eq!(page.picture(true).1, old);
    // What was read is on disk again.
    fly.folder.write("scene.toml", SMALL_SCENE);
    let facts = scene(&mut page, |facts| facts["has_changed"] == false);
    assert_eq!(facts["error"], "");
}

#[test]
fn a_camera_path_that_is_wrong_on_disk_leaves_the_page_its_keys() {
    let (head, camera) = SMALL_SCENE.split_once("[camera]").expect("a table");
    let (_, tail) = camera.split_once("[background]").expect("a table");
    let fly = Fly::of(&format!("{head}[background]{tail}"), &[("path.csv", SMALL_PATH)], &[]);
    let mut page = fly.page();
    page.ask(json!({ "t": "frame", "frame": 3 }));
    let old = page.picture(true).1;
    fly.folder.write("path.csv", "frame\n");
    page.send(&json!({ "t": "render" }));
    let note = page.told("note");
    assert!(
        note["text"]
            .as_str()
            .is_some_and(|text| text.contains("another program")),
        "{note}"
    );
    // The look needs a camera, and so does the scene when it is loaded again.
    let mut look = page.facts["look"].clone();
    look["exposure"] = json!(1.0);
    page.ask(json!({ "t": "look", "look": look }));
    assert!(page.picture(true).1 != old);
    look["exposure"] = json!(0.0);
    page.ask(json!({ "t": "look", "look": look }));
    page.send(&json!({ "t": "reload" }));
    let facts = self::scene(&mut page, |facts| facts["loads"] == 1 || facts["error"] != "");
    assert_eq!(facts["error"], "", "{facts}");
    page.ask(json!({ "t": "frame", "frame": 3 }));
    assert_eq!(page.picture(true).1, old);
    page.send(&json!({ "t": "save", "force": true }));
    assert_eq!(page.told("note")["is_error"], false);
    assert_eq!(fly.folder.read("path.csv"), SMALL_PATH.as_bytes());
    page.send(&json!({ "t": "render" }));
    while page.told("job")["state"] != "done" {}
}
