//! Reading the JSON of a document, with the place of a fault.
//!
//! The place is found after the fault. A reader stops at the first fault, so a document that ends after the faulty value has the
//! same one: at each level, the first child after which the document can end leads to the place. A deserializer that keeps the
//! path as it reads costs every type of glTF a second set of functions, 350 kB of the program.

use ::gltf::json::{Root, Value};
use serde::Deserialize;

/// The document, or its first fault with the place: `materials[1].pbrMetallicRoughness.baseColorFactor[2]: invalid type …`.
pub(super) fn read(document: &Value) -> Result<Root, String> {
    Root::deserialize(document).map_err(|fault| {
        let fault = Fault::new(fault.to_string());
        let place = fault.place(document);
        let Fault { message, .. } = fault;
        if place.is_empty() {
            message
        } else {
            format!("{place}: {message}")
        }
    })
}

/// The first fault of a document.
struct Fault {
    message: String,
    /// The field that an object lacks, if that is the fault.
    missing: Option<String>,
}

impl Fault {
    fn new(message: String) -> Self {
        let missing = message
            .strip_prefix("missing field `")
            .and_then(|m| m.split('`').next());
        Self {
            missing: missing.map(str::to_owned),
            message,
        }
    }

    /// The place in the document, as text; empty for the document itself.
    ///
    /// It takes time in proportion to the document's size, its depth and the logarithm of the number of children.
    fn place(&self, document: &Value) -> String {
        let mut place = String::new();
        // The values on the way to the place, each with the number of the child that leads on.
        let mut way: Vec<(&Value, usize)> = Vec::new();
        let mut node = document;
        while !self.is_of(node, &way) {
            let children: Vec<&Value> = children(node).collect();
            let numbers: Vec<usize> = (0..children.len()).collect();
            let found = numbers.partition_point(|&i| !self.is_in(&way, self.cut(node, i, children[i].clone())));
            let Some(child) = children.get(found) else { break };
            match node {
                Value::Object(fields) => {
                    let key = fields.keys().nth(found).expect("a key for each child");
                    place.extend([if place.is_empty() { "" } else { "." }, key]);
                }
                _ => place.push_str(&format!("[{found}]")),
            }
            way.push((node, found));
            node = child;
        }
        place
    }

    /// Whether the fault is of this value itself: its type, its length, or a field that it lacks.
    fn is_of(&self, node: &Value, way: &[(&Value, usize)]) -> bool {
        match (node, &self.missing) {
            (Value::Object(fields), Some(missing)) => {
                let mut filled = fields.clone();
                let is_absent = filled.insert(missing.clone(), Value::Null).is_none();
                is_absent && !self.is_in(way, Value::Object(filled))
            }
            (Value::Array(_), Some(_)) => false,
            (Value::Object(_), None) => self.is_in(way, Value::Object(Default::default())),
            // The elements of a longer or shorter array are no part of it.
            (Value::Array(elements), None) if self.message.starts_with("invalid length") => {
                let shallow = |element: &Value| match element {
                    Value::Object(_) => Value::Object(Default::default()),
                    Value::Array(_) => Value::Null,
                    other => other.clone(),
                };
                self.is_in(way, elements.iter().map(shallow).collect())
            }
            (Value::Array(_), None) => self.is_in(way, Value::Array(Vec::new())),
            _ => true,
        }
    }

    /// Whether the document has the fault when it ends after this value at the end of the way.
    fn is_in(&self, way: &[(&Value, usize)], value: Value) -> bool {
        let document = way
            .iter()
            .rev()
            .fold(value, |child, &(node, number)| self.cut(node, number, child));
        Root::deserialize(&document).is_err_and(|e| e.to_string() == self.message)
    }

    /// The value with this child in the place of its own, and without the children after it.
    ///
    /// Where a field is missing, later texts and numbers stay, or they would be missing too.
    fn cut(&self, node: &Value, number: usize, child: Value) -> Value {
        let stays = |value: &Value| self.missing.is_some() && !is_container(value);
        match node {
            Value::Object(fields) => {
                let mut cut = serde_json::Map::new();
                let mut child = Some(child);
                for (i, (key, value)) in fields.iter().enumerate() {
                    if i == number {
                        cut.extend(child.take().map(|child| (key.clone(), child)));
                    } else if i < number || stays(value) {
                        cut.insert(key.clone(), value.clone());
                    }
                }
                Value::Object(cut)
            }
            Value::Array(elements) => elements[..number].iter().cloned().chain([child]).collect(),
            _ => child,
        }
    }
}

fn is_container(value: &Value) -> bool {
    value.is_object() || value.is_array()
}

/// The children of a value, in the order of reading.
fn children(node: &Value) -> Box<dyn Iterator<Item = &Value> + '_> {
    match node {
        Value::Object(fields) => Box::new(fields.values()),
        Value::Array(elements) => Box::new(elements.iter()),
        _ => Box::new(std::iter::empty()),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// The JSON pointers of all values of a document.
    fn pointers(document: &Value) -> Vec<String> {
        let mut found = vec![String::new()];
        let mut open = vec![(String::new(), document)];
        while let Some((pointer, node)) = open.pop() {
            let keys: Vec<String> = match node {
                Value::Object(fields) => fields.keys().cloned().collect(),
                _ => (0..children(node).count()).map(|i| i.to_string()).collect(),
            };
            for (key, child) in keys.iter().zip(children(node)) {
                let pointer = format!("{pointer}/{key}");
                found.push(pointer.clone());
                open.push((pointer, child));
            }
        }
        found
    }

    #[test]
    fn places_are_those_of_a_reader_that_keeps_the_path() {
        let document = json!({
            "asset": { "version": "2.0", "extras": { "a": [1, { "b": 2 }] } },
            "accessors": [
                { "componentType": 5126, "count": 3, "type": "VEC3", "bufferView": 0, "min": [0, 0, 0], "max": [1, 1, 1] },
                {
                    "componentType": 5123, "count": 3, "type": "SCALAR",
                    "sparse": {
                        "count": 1,
                        "indices": { "bufferView": 0, "componentType": 5123 },
                        "values": { "bufferView": 0 },
                    },
                },
            ],
            "animations": [{
                "channels": [{ "sampler": 0, "target": { "node": 1, "path": "rotation" } }],
                "samplers": [{ "input": 0, "output": 1, "interpolation": "STEP" }],
            }],
            "buffers": [{ "byteLength": 36, "uri": "a.bin" }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36, "target": 34962 }],
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }],
            "images": [{ "uri": "a.png" }, { "bufferView": 0, "mimeType": "image/png" }],
            "materials": [
                { "name": "a", "alphaMode": "MASK", "alphaCutoff": 0.5 },
                {
                    "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 0.5, 1], "baseColorTexture": { "index": 0 } },
                    "emissiveFactor": [0, 0, 1],
                    "doubleSided": true,
                },
            ],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "mode": 4, "material": 1 }] }],
            "nodes": [
                { "mesh": 0, "translation": [0, 1, 2], "children": [1] },
                { "camera": 0, "rotation": [0, 0, 0, 1], "scale": [1, 2, 3] },
                { "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] },
            ],
            "samplers": [{ "magFilter": 9729, "wrapS": 33071 }],
            "scenes": [{ "nodes": [0, 2] }],
            "textures": [{ "source": 0, "sampler": 0 }],
        });
        assert!(read(&document).is_ok());
        let others = [
            json!(null),
            json!(true),
            json!(-1),
            json!(1.5),
            json!("x"),
            json!([]),
            json!([1]),
            json!(["x"]),
            json!([1, 2]),
            json!({}),
            json!({ "x": 1 }),
            json!([{ "x": 1 }]),
        ];
        let mut compared = 0;
        let mut compare = |wrong: Value| {
            let expected: Result<Root, _> = serde_path_to_error::deserialize(wrong.clone());
            if let Err(expected) = expected {
                assert_eq!(read(&wrong).map(drop), Err(expected.to_string()), "{wrong}");
                compared += 1;
            }
        };
        for pointer in pointers(&document) {
            for other in &others {
                let mut wrong = document.clone();
                *wrong.pointer_mut(&pointer).expect("a value") = other.clone();
                compare(wrong);
            }
            if let Some((parent, last)) = pointer.rsplit_once('/') {
                let mut wrong = document.clone();
                if let Some(fields) = wrong.pointer_mut(parent).and_then(Value::as_object_mut) {
                    fields.remove(last);
                }
                compare(wrong);
            }
        }
        assert!(compared > 500, "{compared}");
    }
}
