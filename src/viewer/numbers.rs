//! The reading of messages, in which wrong numbers are told apart from malformed messages.
//!
//! A number that no field can hold is a slip of a user: it is refused, and the page goes on. Such a message is one that can be read
//! with 1 in the place of its numbers. Words where a number belongs count as wrong numbers, too.

use std::ops::Range;

use super::message::PageMessage;
use crate::value::one_line;

/// The keys whose values are words.
const WORDS: [&str; 4] = ["t", "integrator", "view", "pass"];

/// The length at which a wrong number is cut in the page.
const SHOWN: usize = 40;

/// Why a message was not read.
#[derive(Debug, PartialEq)]
pub enum Misread {
    /// A number is wrong, in the message `seq` if it has such a number.
    Number {
        seq: Option<u64>,
        text: String,
    },
    Malformed,
}

/// Reads a message.
pub fn read(text: &str) -> Result<PageMessage, Misread> {
    if let Ok(message) = serde_json::from_str(text) {
        return Ok(message);
    }
    let scalars = scalars(text);
    let read_with =
        |kept: &dyn Fn(usize) -> bool| serde_json::from_str::<PageMessage>(&with_ones(text, &scalars, kept));
    // Messages have few fields, so there are few scalars in one that can be read.
    read_with(&|_| false).map_err(|_| Misread::Malformed)?;
    let is_wrong = |i: &usize| read_with(&|kept| kept == *i).is_err();
    let wrong: Vec<usize> = (0..scalars.len()).filter(is_wrong).collect();
    let repaired = read_with(&|kept| !wrong.contains(&kept)).map_err(|_| Misread::Malformed)?;
    let first = wrong.first().ok_or(Misread::Malformed)?;
    let Scalar { key, place } = &scalars[*first];
    let word = &text[place.clone()];
    let flaw = match word.parse::<f64>() {
        Ok(v) if v.is_finite() && v.fract() != 0.0 => "is not a whole number",
        Ok(v) if !v.is_nan() => "is out of range",
        _ => "is not a number",
    };
    Err(Misread::Number {
        seq: repaired.seq().filter(|_| *key != "seq"),
        text: format!("{key}: {} {flaw}", one_line(word, SHOWN)),
    })
}

/// A value of a message that may be a number.
struct Scalar<'a> {
    /// The last key before it.
    key: &'a str,
    place: Range<usize>,
}

fn scalars(text: &str) -> Vec<Scalar<'_>> {
    let bytes = text.as_bytes();
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-.".contains(byte);
    let (mut found, mut key, mut at) = (Vec::new(), "", 0);
    while let Some(first) = bytes.get(at) {
        let mut end = at + 1;
        if *first == b'"' {
            end = end_of_string(bytes, at);
            if text[end..].trim_start().starts_with(':') {
                key = text[at..end].trim_matches('"');
            } else {
                found.push(Scalar { key, place: at..end });
            }
        } else if is_part(first) {
            end = bytes[at..]
                .iter()
                .position(|byte| !is_part(byte))
                .map_or(bytes.len(), |n| at + n);
            if !["true", "false"].contains(&&text[at..end]) {
                found.push(Scalar { key, place: at..end });
            }
        }
        at = end;
    }
    found.retain(|scalar| !WORDS.contains(&scalar.key));
    found
}

/// The end of the string that begins at `start`.
fn end_of_string(bytes: &[u8], start: usize) -> usize {
    let mut at = start + 1;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'"' => return at + 1,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    bytes.len()
}

/// The text with 1 in the place of all scalars that are not `kept`.
fn with_ones(text: &str, scalars: &[Scalar<'_>], kept: &dyn Fn(usize) -> bool) -> String {
    let (mut written, mut from) = (String::with_capacity(text.len()), 0);
    for (i, Scalar { place, .. }) in scalars.iter().enumerate() {
        if !kept(i) {
            written += &text[from..place.start];
            written.push('1');
            from = place.end;
        }
    }
    written + &text[from..]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn wrong_numbers_are_told_apart_from_malformed_messages() {
        let look = |samples: &str| {
            format!(
                "{{\"t\":\"look\",\"seq\":7,\"look\":{{\"integrator\":\"path\",\"view\":\"raw\",\"exposure\":0,\
                 \"pass\":\"beauty\",\"samples\":{samples},\"scale\":1}}}}"
            )
        };
        let eye = |x: &str| {
            format!(
                "{{\"t\":\"view\", \"seq\":7, \"camera\":{{\"eye\":[0, {x},0],\"target\":[1,2,3],\"up\":[0,1,0]}}}}"
            )
        };
        for (message, text) in [
            (look("-1"), "samples: -1 is out of range"),
            (look("5e9"), "samples: 5e9 is out of range"),
            (look("1.5"), "samples: 1.5 is not a whole number"),
            (look("null"), "samples: null is not a number"),
            (
                look("\"a lot, \\\"x\\\":1\""),
                "samples: \"a lot, \\\"x\\\":1\" is not a number",
            ),
            (eye("NaN"), "eye: NaN is not a number"),
            (eye("1e999"), "eye: 1e999 is out of range"),
            (eye("\"\u{e9}\""), "eye: \"\u{e9}\" is not a number"),
        ] {
            let text = text.to_owned();
            assert_eq!(
                read(&message).unwrap_err(),
                Misread::Number { seq: Some(7), text },
                "{message}"
            );
        }
        let of_seq = "{\"t\":\"home\",\"seq\":-2}";
        let text = "seq: -2 is out of range".to_owned();
        assert_eq!(read(of_seq).unwrap_err(), Misread::Number { seq: None, text });
        for malformed in [
            "",
            "{",
            "-1",
            "{\"t\":-1,\"seq\":1}",
            "{\"t\":\"home\",\"seq\":-2,\"more\":1}",
            "{\"t\":\"view\",\"seq\":-2}",
            "{\"t\":\"look\",\"seq\":1,\"look\":{\"samples\":-1}}",
            "{\"t\":\"delete\",\"frame\":{}}",
            "{\"t\":\"delete\",\"frame\":\"",
            "{\"t\":\"delete\",\"frame\":\"\\",
        ] {
            assert_eq!(read(malformed).unwrap_err(), Misread::Malformed, "{malformed}");
        }
    }

    proptest! {
        #[test]
        fn no_message_makes_it_panic(text in "([{}\\[\\]:,\"\\\\ \u{e9}]|\"t\":\"(view|frame|delete)\"|\"(seq|frame|eye)\"|-?[0-9.e]{1,9}|null|NaN){0,20}") {
            let _ = read(&text);
        }
    }
}
