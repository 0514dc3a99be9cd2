//! The values that are drawn at random for a frame, as files beside and with the pictures tell them.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::{describe::Values, math::sorting};

/// The attribute of the values that were drawn for a picture, as JSON.
pub const VALUES: &str = "batch-render/values";

/// The values that are drawn for a frame, by their names; `None` where none are.
pub(in crate::batch) fn draws(values: Option<&Values>, frame: i32) -> Option<BTreeMap<String, Value>> {
    let drawn = values?.drawn_at(frame.into());
    let drawn = drawn.map(|(name, text)| {
        let value: toml::Value = text.parse().expect("the TOML crate has written it");
        let value = serde_json::to_value(value).expect("values of scenes are JSON");
        (name.to_owned(), value)
    });
    let drawn: BTreeMap<String, Value> = sorting::ordered(drawn);
    (!drawn.is_empty()).then_some(drawn)
}

/// The same as a text.
pub(in crate::batch) fn text(values: Option<&Values>, frame: i32) -> Option<String> {
    let drawn = draws(values, frame)?;
    Some(serde_json::to_string(&drawn).expect("numbers and texts are JSON"))
}
