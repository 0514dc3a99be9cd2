//! A document that is checked, and the way through its JSON.

use ::gltf::json::Value;

use crate::assets::gltf::document::Document;
pub(super) use crate::assets::gltf::json::index;

/// A document that is checked.
pub(super) struct Lint<'a> {
    pub document: &'a Document<'a>,
    pub raw: &'a Value,
    pub faults: Vec<String>,
}

impl<'a> Lint<'a> {
    pub fn fault(&mut self, text: impl Into<String>) {
        self.faults.push(text.into());
    }

    /// The array of the document that is called `key`.
    pub fn array(&self, key: &str) -> &'a [Value] {
        array(self.raw, key)
    }

    /// The element of such an array that `value` names by `key`.
    pub fn named(&self, value: &Value, key: &str, array: &str) -> Option<&'a Value> {
        self.array(array).get(index(value, key)?)
    }
}

pub(super) fn array<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}
