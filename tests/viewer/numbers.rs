//! Wrong numbers in messages.

use serde_json::json;
use tungstenite::Message;

use crate::client::Fly;

#[test]
fn a_wrong_number_is_refused_with_its_name_and_ends_nothing() {
    let fly = Fly::start(None, &[]);
    let mut page = fly.page();
    let look = page.facts["look"].clone();
    let look = |key: &str, number: &str| {
        let mut changed = look.clone();
        changed[key] = json!("NUMBER");
        let message = json!({ "t": "look", "seq": 5, "look": changed }).to_string();
        message.replace("\"NUMBER\"", number)
    };
    let view = |x: &str| {
        format!("{{\"t\":\"view\",\"seq\":5,\"camera\":{{\"eye\":[0,{x},0],\"target\":[0,0,-1],\"up\":[0,1,0]}}}}")
    };
    for (message, reason) in [
        (look("samples", "-1"), "samples: -1 is out of range"),
        (look("samples", "1.5"), "samples: 1.5 is not a whole number"),
        (look("samples", "70000"), "out of range"),
        (look("exposure", "null"), "exposure: null is not a number"),
        (look("exposure", "-65"), "out of range"),
        (look("scale", "\"half\""), "scale: \"half\" is not a number"),
        (view("NaN"), "eye: NaN is not a number"),
        (view("1e999"), "eye: 1e999 is out of range"),
        (view("1e39"), "out of range"),
        (
            "{\"t\":\"frame\",\"seq\":5,\"frame\":1e99}".to_owned(),
            "is not a number between -1000000000 and 1000000000",
        ),
    ] {
        page.socket.send(Message::text(message.as_str())).expect("sent");
        let note = page.told("note");
        let text = note["text"].as_str().expect("a text");
        assert!(text.contains(reason), "{message}: {text}");
        // The page finds the field by the number of its message.
        assert_eq!(
            (&note["is_error"], &note["seq"]),
            (&json!(true), &json!(5)),
            "{message}"
        );
    }
    page.ask(json!({ "t": "home" }));
    page.picture(true);
}
