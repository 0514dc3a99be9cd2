//! Keys of the camera path.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::client::{Fly, Page};

/// A path of times at 24 frames per second: the keys lie at 0, 10.08 and 19.92.
const TIMES: &str = "time,eye_x,eye_y,eye_z,target_x,target_y,target_z\n\
                     0,0,1,6,0,1,0\n0.42,1,1,6,0,1,0\n0.83,2,1,6,0,1,0\n";

fn frames(page: &Page) -> Vec<f64> {
    page.keys
        .iter()
        .map(|key| key["frame"].as_f64().expect("a number"))
        .collect()
}

/// The frames of the keys after the next edit.
fn edited(page: &mut Page, message: &Value) -> Vec<f64> {
    page.send(message);
    page.told("keys");
    frames(page)
}

#[test]
fn keys_between_frames_are_shown_replaced_moved_and_deleted() {
    let fly = Fly::start(Some(TIMES), &["--fps", "24"]);
    let mut page = fly.page();
    let between = 0.83 * 24.0;
    assert_eq!(frames(&page), [0.0, 0.42 * 24.0, between]);
    page.ask(json!({ "t": "frame", "frame": between }));
    let (header, _) = page.picture(true);
    assert_eq!(
        (&header["camera"]["eye"], &header["on_path"]),
        (&json!([2.0, 1.0, 6.0]), &json!(true))
    );
    assert_eq!(header["frame"].as_f64(), Some(between));
    let camera = json!({ "eye": [3, 1, 6], "target": [0, 1, 0], "up": [0, 1, 0] });
    page.ask(json!({ "t": "view", "camera": camera }));
    assert_eq!(edited(&mut page, &json!({ "t": "set" })), [0.0, 0.42 * 24.0, between]);
    let moved = edited(&mut page, &json!({ "t": "move", "from": 0.42 * 24.0, "to": 12 }));
    assert_eq!(moved, [0.0, 12.0, between]);
    assert_eq!(
        edited(&mut page, &json!({ "t": "delete", "frame": between })),
        [0.0, 12.0]
    );
    // The key is set where the view is.
    assert_eq!(edited(&mut page, &json!({ "t": "set" })), [0.0, 12.0, between]);
    page.send(&json!({ "t": "save" }));
    page.told("note");
    let saved = String::from_utf8(fly.folder.read("path.csv")).expect("text");
    assert!(saved.ends_with("\n0.5,1,1,6,0,1,0\n0.83,3,1,6,0,1,0\n"), "{saved}");
}

#[test]
fn a_key_set_between_frames_is_where_its_rounded_time_says() {
    let fly = Fly::start(Some(TIMES), &["--fps", "24"]);
    let mut page = fly.page();
    page.ask(json!({ "t": "frame", "frame": 5.123456 }));
    page.picture(false);
    let keys = edited(&mut page, &json!({ "t": "set" }));
    assert_eq!(keys[1], 0.213477 * 24.0);
    // The view is at its key, which is deleted by its frame.
    page.ask(json!({ "t": "home" }));
    assert_eq!(page.picture(false).0["frame"].as_f64(), Some(keys[1]));
    assert_eq!(edited(&mut page, &json!({ "t": "delete", "frame": keys[1] })).len(), 3);
}

#[test]
fn a_file_of_frames_takes_whole_frames_only() {
    let fly = Fly::start(None, &[]);
    let mut page = fly.page();
    page.ask(json!({ "t": "frame", "frame": 2.5 }));
    page.send(&json!({ "t": "set" }));
    let note = page.told("note");
    assert!(
        note["text"]
            .as_str()
            .is_some_and(|text| text.contains("2.5 is not a whole number")),
        "{note}"
    );
    page.ask(json!({ "t": "frame", "frame": 2 }));
    assert_eq!(edited(&mut page, &json!({ "t": "set" })), [2.0]);
}

/// The best time of an edit of a path with this many keys, and the bytes of all that edits and saving send.
fn cost_of_edits(keys: u32) -> (Duration, usize) {
    let row = |i: u32| format!("{},{i},1,6,0,1,0\n", 10 * i);
    let rows: String = (1..=keys).map(row).collect();
    let path = format!("frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n{rows}");
    let fly = Fly::start(Some(&path), &[]);
    let mut page = fly.page();
    let (mut best, mut bytes) = (Duration::MAX, 0);
    for (message, answers) in [
        (json!({ "t": "move", "from": 20, "to": 21 }), ["facts", "keys"]),
        (json!({ "t": "move", "from": 21, "to": 20 }), ["facts", "keys"]),
        (json!({ "t": "delete", "frame": 20 }), ["facts", "keys"]),
        (json!({ "t": "set" }), ["facts", "keys"]),
        (json!({ "t": "move", "from": 10, "to": 11 }), ["facts", "keys"]),
        (json!({ "t": "save" }), ["note", "facts"]),
    ] {
        let begun = Instant::now();
        page.send(&message);
        bytes += answers
            .map(|kind| page.told(kind).to_string().len())
            .iter()
            .sum::<usize>();
        if message["t"] != "save" {
            best = best.min(begun.elapsed());
        }
    }
    assert_eq!(page.keys.len(), keys as usize - 1);
    (best, bytes)
}

#[test]
fn edits_among_2000_keys_send_what_those_among_20_send_in_a_time_that_is_not_quadratic() {
    let [(few_time, few), (many_time, many)] = [20, 2000].map(cost_of_edits);
    // Indices have more digits.
    assert!(many <= few + 10, "{few} bytes, {many} bytes");
    assert!(many_time < 100 * few_time, "{few_time:?}, {many_time:?}");
    println!("an edit among 20 keys: {few_time:?}, among 2,000: {many_time:?}");
}
