//! The live viewer without a browser: who gets in, what a page may say, the camera path file, and that pictures are those of
//! the job. `tests/viewer` has the same with a browser.

#[path = "../common/mod.rs"]
mod common;

mod client;
mod keys;
mod motion;
mod numbers;
mod scene;

use std::{
    io::{ErrorKind, Read, Write},
    net::TcpStream,
    time::{Duration, Instant},
};

use client::{Fly, Told};
use common::{Folder, SMALL_PATH, SMALL_SCENE};
use serde_json::{Value, json};
use tungstenite::Message;

fn camera(eye: [f64; 3], target: [f64; 3]) -> Value {
    json!({ "eye": eye, "target": target, "up": [0, 1, 0], "roll": 0, "lens": {} })
}

#[test]
fn only_who_has_the_secret_and_names_this_machine_gets_in() {
    let fly = Fly::start(None, &[]);
    let (status, head, body) = fly.own("/");
    let body = String::from_utf8(body).expect("text");
    assert_eq!(status, 200);
    assert!(body.contains("<canvas") && !body.contains("{{"));
    assert!(head.contains("content-security-policy: default-src 'none'") && head.contains("cache-control: no-store"));
    // All that the page needs is in it.
    for elsewhere in ["src=\"http", "href=\"http", "//cdn", "@import"] {
        assert!(!body.contains(elsewhere), "{elsewhere}");
    }
    let key = format!("/?key={}", fly.key);
    let still = format!("/still.png?key={}0", fly.key);
    let host = fly.address.as_str();
    for (path, host, status) in [
        ("/", host, 403),
        ("/?key=", host, 403),
        ("/still.png", host, 403),
        (still.as_str(), host, 403),
        ("/live", host, 403),
        (key.as_str(), "evil.example", 421),
        (key.as_str(), "localhost:1", 200),
        ("/nothing", host, 403),
    ] {
        assert_eq!(fly.get(path, &[("Host", host)]).0, status, "{path} {host}");
    }
    assert_eq!(fly.get(&format!("/nothing?key={}", fly.key), &[("Host", host)]).0, 404);
    let twice = [("Host", host), ("Host", "evil.example")];
    assert_ne!(fly.get(&key, &twice).0, 200);
}

#[test]
fn a_socket_needs_the_secret_and_the_origin_of_the_page() {
    let fly = Fly::start(None, &[]);
    let host = fly.address.as_str();
    let own = format!("http://{host}");
    let refused = |host: &str, origin: Option<&str>, key: &str| fly.page_of(host, origin, key).err();
    assert_eq!(refused(host, Some(&own), &fly.key), None);
    assert_eq!(refused(host, Some(&own), "0123"), Some(403));
    assert_eq!(refused(host, Some("http://evil.example"), &fly.key), Some(403));
    assert_eq!(refused(host, Some("null"), &fly.key), Some(403));
    assert_eq!(refused(host, None, &fly.key), Some(403));
    // A name that another site has made point here.
    assert_eq!(
        refused("evil.example", Some("http://evil.example"), &fly.key),
        Some(421)
    );
}

#[test]
fn connections_without_the_secret_take_nothing_from_a_page_and_end() {
    let fly = Fly::start(None, &[]);
    let mut open = fly.page();
    let mut half: Vec<_> = (0..300).map(|_| fly.connect()).collect();
    for stream in &mut half {
        // The oldest may have lost their places already.
        let _ = stream.write_all(b"GET / HT");
    }
    let begun = Instant::now();
    let mut page = fly.page();
    for page in [&mut open, &mut page] {
        page.ask(json!({ "t": "view", "camera": camera([0.0, 1.0, 6.0], [0.0, 1.0, 0.0]) }));
        page.picture(false);
    }
    assert_eq!(fly.own("/").0, 200);
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
    // Of 300 at most 32 are left, and those for a short time, also where bytes arrive now and then.
    assert!(half[..260].iter_mut().all(has_ended));
    let slow = half.last_mut().expect("a connection");
    slow.set_read_timeout(Some(Duration::from_millis(100)))
        .expect("a timeout");
    while !has_ended(slow) {
        assert!(begun.elapsed() < Duration::from_secs(30));
        let _ = slow.write_all(b"T");
    }
    // Who has the secret stays.
    page.ask(json!({ "t": "frame", "frame": 2 }));
    page.picture(false);
}

/// Whether the other side has closed a connection; waits as long as its reading does.
fn has_ended(stream: &mut TcpStream) -> bool {
    match stream.read(&mut [0]) {
        Ok(read) => read == 0,
        Err(error) => !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
    }
}

#[test]
fn a_bad_message_ends_its_connection_and_nothing_else() {
    const POLICY: Option<u16> = Some(1008);
    let fly = Fly::start(None, &[]);
    let mut good = fly.page();
    for bad in [
        "",
        "{",
        "[]",
        "{\"t\":\"shutdown\"}",
        "{\"t\":\"view\",\"seq\":1}",
        "{\"t\":\"save\",\"file\":\"/etc/passwd\"}",
        "{\"t\":\"look\",\"seq\":1,\"look\":{\"samples\":-1}}",
    ] {
        let mut page = fly.page();
        page.socket.send(Message::text(bad)).expect("sent");
        assert_eq!(page.end(), POLICY, "{bad}");
    }
    let mut page = fly.page();
    page.socket.send(Message::binary(vec![0; 8])).expect("sent");
    assert_eq!(page.end(), POLICY);
    let mut page = fly.page();
    // It may be cut off before all of it is sent.
    let _ = page.socket.send(Message::text(" ".repeat(10 << 20)));
    page.end();
    let mut page = fly.page();
    for _ in 0..100_000 {
        if page.socket.send(Message::text("{\"t\":\"ack\"}")).is_err() {
            break;
        }
    }
    page.end();

    good.ask(json!({ "t": "view", "camera": camera([0.0, 1.0, 6.0], [0.0, 1.0, 0.0]) }));
    assert_eq!(good.picture(false).0["camera"]["eye"], json!([0.0, 1.0, 6.0]));
}

#[test]
fn what_cannot_be_is_refused_with_a_reason_and_the_view_stays() {
    let fly = Fly::start(Some(SMALL_PATH), &[]);
    let mut page = fly.page();
    let at_eye = camera([1.0; 3], [1.0; 3]);
    let mut wide = camera([0.0; 3], [1.0; 3]);
    wide["lens"]["fov"] = json!(180);
    let mut far = camera([0.0; 3], [1.0; 3]);
    far["eye"][1] = json!(1e39);
    let mut look = page.facts["look"].clone();
    look["integrator"] = json!("pth");
    for (message, reason) in [
        (
            json!({ "t": "view", "seq": 1, "camera": at_eye }),
            "the target is at the eye",
        ),
        (
            json!({ "t": "view", "seq": 2, "camera": wide }),
            "the view is not an angle",
        ),
        (json!({ "t": "view", "seq": 3, "camera": far }), "out of range"),
        (json!({ "t": "look", "seq": 3, "look": look }), "did you mean `path`"),
        (json!({ "t": "delete", "frame": 3 }), "frame 3 has no key"),
        (json!({ "t": "move", "from": 1, "to": 5 }), "frame 5 has a key already"),
        (
            json!({ "t": "frame", "seq": 4, "frame": i64::MAX }),
            "is not a number between",
        ),
    ] {
        page.send(&message);
        let note = page.told("note");
        let text = note["text"].as_str().expect("a text");
        assert!(note["is_error"] == true && text.contains(reason), "{message}: {text}");
    }
    page.ask(json!({ "t": "frame", "frame": 1 }));
    assert_eq!(page.picture(false).0["camera"]["eye"], json!([0.0, 2.0, 6.0]));
}

#[test]
fn the_newest_camera_counts_and_all_pages_see_it() {
    let fly = Fly::start(None, &[]);
    let (mut page, mut other) = (fly.page(), fly.page());
    for i in 0..200 {
        let x = f64::from(i) / 100.0;
        page.ask(json!({ "t": "view", "camera": camera([x, 2.0, 6.0], [x, 1.0, 0.0]) }));
    }
    let (header, file) = page.picture(true);
    assert_eq!(header["camera"]["eye"], json!([1.99, 2.0, 6.0]));
    assert_eq!((&header["samples"], &header["mime"]), (&json!(20), &json!("image/png")));
    assert_eq!(file, fly.still());
    loop {
        if let Told::Picture(seen, same) = other.next()
            && seen["stage"] == "final"
            && seen["version"] == header["version"]
        {
            assert_eq!(same, file);
            break;
        }
    }
}

#[test]
fn stills_are_the_files_of_the_job_wherever_the_camera_is() {
    let fly = Fly::start(Some(SMALL_PATH), &[]);
    fly.folder.succeed(&[
        "scene.toml",
        "--frames",
        "path.csv",
        "--progress",
        "none",
        "-o",
        "job.####.png",
    ]);
    let mut page = fly.page();
    for frame in [3, 1, 5] {
        page.ask(json!({ "t": "frame", "frame": frame }));
        assert_eq!(
            page.picture(true).1,
            fly.folder.read(&format!("job.000{frame}.png")),
            "frame {frame}"
        );
    }
    page.ask(json!({ "t": "home" }));
    page.picture(false);
    page.ask(json!({ "t": "frame", "frame": 1 }));
    page.picture(false);
    page.ask(json!({ "t": "home" }));
    fly.folder
        .succeed(&["scene.toml", "--progress", "none", "-o", "home.####.png"]);
    assert_eq!(page.picture(true).1, fly.folder.read("home.0001.png"));

    // And whatever the look is.
    for (key, value, flags) in [
        ("pass", json!("N"), ["--show", "N"]),
        ("integrator", json!("cost"), ["--integrator", "cost"]),
        ("view", json!("raw"), ["--view", "raw"]),
        ("exposure", json!(-1.5), ["--exposure", "-1.5"]),
        ("samples", json!(3), ["--samples", "3"]),
    ] {
        let mut look = page.facts["look"].clone();
        look[key] = value;
        page.ask(json!({ "t": "look", "look": look }));
        fly.folder
            .succeed(&[&["scene.toml", "--progress", "none", "-o", "look.####.png"], &flags[..]].concat());
        assert_eq!(page.picture(true).1, fly.folder.read("look.0001.png"), "{key}");
    }
}

#[test]
fn keys_are_saved_beside_what_was_written_and_rendered_as_shown() {
    let commented = format!("# mine\n{}", SMALL_PATH.replace("\n5,", "\n# then\n5,"));
    let fly = Fly::start(Some(&commented), &[]);
    let mut page = fly.page();
    page.ask(json!({ "t": "frame", "frame": 3 }));
    let mut aside = camera([1.5, 2.25, 5.0], [0.25, 0.5, 0.0]);
    aside["lens"] = json!({ "fov": 55, "focus_distance": 4 });
    page.ask(json!({ "t": "view", "camera": aside }));
    page.picture(false);
    page.send(&json!({ "t": "set" }));
    page.send(&json!({ "t": "move", "from": 5, "to": 6 }));
    // A job renders what is on disk.
    page.send(&json!({ "t": "render" }));
    assert!(page.told("note")["text"].as_str().is_some_and(|t| t.contains("save")));
    page.send(&json!({ "t": "save" }));
    assert_eq!(page.told("note")["is_error"], false);
    assert_eq!(fly.folder.read("path.csv.bak"), commented.as_bytes());
    let saved = String::from_utf8(fly.folder.read("path.csv")).expect("text");
    let expected = "# mine\nframe,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov,focus_distance\n\
                    1,0,2,6,0,0.8,0,40,6\n3,1.5,2.25,5,0.25,0.5,0,55,4\n# then\n6,2,2,5,0,0.8,0,40,6\n";
    assert_eq!(saved, expected);

    page.ask(json!({ "t": "frame", "frame": 3 }));
    let still = page.picture(true).1;
    page.send(&json!({ "t": "render" }));
    let mut shown = 0;
    let done = loop {
        match page.next() {
            Told::Facts(job) if job["t"] == "job" && job["text"] != "" && job["state"] != "running" => break job,
            Told::Picture(header, _) if header["kind"] == "job" => shown += 1,
            Told::End(code) => panic!("the connection has ended: {code:?}"),
            _ => {}
        }
    };
    assert_eq!((&done["state"], &done["done"]), (&json!("done"), &json!(6)), "{done}");
    assert!(shown > 0);
    assert_eq!(fly.folder.read("job.0003.png"), still);
    let files = fly.folder.names();
    assert!(files.iter().all(|name| !name.ends_with(".tmp")), "{files:?}");
}

#[test]
fn a_file_that_another_program_has_changed_is_not_replaced_unasked() {
    let fly = Fly::start(Some(SMALL_PATH), &[]);
    let mut page = fly.page();
    page.send(&json!({ "t": "move", "from": 5, "to": 7 }));
    let foreign = SMALL_PATH.replace("\n5,", "\n9,");
    fly.folder.write("path.csv", &foreign);
    page.send(&json!({ "t": "save" }));
    page.told("foreign");
    assert_eq!(fly.folder.read("path.csv"), foreign.as_bytes());
    page.send(&json!({ "t": "save", "force": true }));
    page.told("note");
    assert_eq!(
        fly.folder.read("path.csv"),
        SMALL_PATH.replace("\n5,", "\n7,").as_bytes()
    );
    assert_eq!(fly.folder.read("path.csv.bak"), foreign.as_bytes());
    // A file that is wrong is not loaded.
    fly.folder.write("path.csv", "frame\n");
    page.send(&json!({ "t": "load" }));
    assert_eq!(page.told("note")["is_error"], true);
    fly.folder.write("path.csv", &foreign);
    page.send(&json!({ "t": "load" }));
    assert_eq!(page.told("note")["is_error"], false);
}

#[test]
fn a_path_that_is_not_there_begins_with_the_first_key() {
    let fly = Fly::start(None, &[]);
    let mut page = fly.page();
    page.send(&json!({ "t": "save" }));
    assert_eq!(page.told("note")["text"], "there are no keys to save");
    page.ask(json!({ "t": "view", "camera": camera([0.0, 2.0, 6.0], [0.25, 0.1, 0.0]) }));
    page.send(&json!({ "t": "set" }));
    page.send(&json!({ "t": "save" }));
    assert_eq!(page.told("note")["is_error"], false);
    let text = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,2,6,0.25,0.1,0\n";
    assert_eq!(fly.folder.read("path.csv"), text.as_bytes());
    assert!(!fly.folder.path("path.csv.bak").exists());
}

#[test]
fn the_pointer_tells_the_object_its_material_and_its_distance() {
    let fly = Fly::start(None, &[]);
    let mut page = fly.page();
    page.ask(json!({ "t": "view", "camera": camera([-1.0, 1.0, 6.0], [-1.0, 1.0, 0.0]) }));
    page.send(&json!({ "t": "pick", "id": 4, "x": 0.5, "y": 0.5 }));
    let picked = page.told("picked");
    let found = &picked["found"];
    assert_eq!((&picked["id"], &found["material"]), (&json!(4), &json!("mirror")));
    assert!(
        (found["distance"].as_f64().expect("metres") - 5.0).abs() < 1e-3,
        "{found}"
    );
    page.send(&json!({ "t": "pick", "id": 5, "x": 0.5, "y": 0 }));
    assert_eq!(page.told("picked")["found"], Value::Null);
}

#[cfg(unix)]
#[test]
fn the_program_ends_cleanly_while_pages_are_connected_and_a_job_runs() {
    let mut fly = Fly::start(Some(SMALL_PATH), &["--samples", "60000"]);
    let mut page = fly.page();
    page.send(&json!({ "t": "render" }));
    loop {
        if page.told("job")["state"] == "running" {
            break;
        }
    }
    assert_eq!(fly.interrupt(), Some(0));
    assert_eq!(page.end(), Some(1001));
    let names = fly.folder.names();
    assert!(names.iter().all(|name| !name.starts_with("job.")), "{names:?}");
}

#[test]
fn wrong_use_is_said_before_anything_is_served() {
    let folder = Folder::new();
    folder.write("scene.toml", SMALL_SCENE);
    let error = folder.fail(65, &["fly", "scene.toml", "--frames", "path.abc"]);
    assert!(error.contains("unknown camera path format"), "{error}");
    let error = folder.fail(2, &["fly", "scene.toml", "--frames", "path.txt"]);
    assert!(
        error.contains("keys are kept in CSV files, not in those of tum"),
        "{error}"
    );
    folder.fail(66, &["fly", "nothing.toml"]);
    folder.write("bad.csv", "frame,eye_x\n1,2\n");
    folder.fail(65, &["fly", "scene.toml", "--frames", "bad.csv"]);
    let fly = Fly::start(None, &[]);
    let port = fly.address.rsplit_once(':').expect("a port").1;
    let error = folder.fail(71, &["fly", "scene.toml", "--port", port]);
    assert!(error.contains("cannot serve on"), "{error}");
    // A model is flown through as well, from a camera that frames it.
    let help = folder.succeed(&["fly", "--help"]);
    for key in ["F1, F2", "Ctrl+S", "Page Up"] {
        assert!(help.contains(key), "{key}");
    }
}
