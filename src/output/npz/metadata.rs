//! The metadata of a file, as JSON.

use serde_json::{Map, Number, Value as Json};

use super::array::{Array, Element};
use crate::{
    film::Window,
    math::sorting,
    output::{
        Attribute, FileFacts, FrameImage, Value,
        frame_attributes::{Conventions, attributes},
        seal,
    },
};

/// The name of the array.
pub(super) const METADATA: &str = "metadata";
/// The limit of its size, in bytes.
pub(super) const LONGEST: usize = 1 << 26;

const RESOLUTION: &str = "resolution";
const WINDOW: &str = "window";
const CONVENTIONS: &str = "batch-render/conventions";

const OF_ARRAYS: Conventions = Conventions {
    pixels: "arrays are [row, column, channel] from the upper left pixel of the window, which is columns x0 to x1 and rows y0 to y1 \
             of a picture of this resolution; pixel centres are at .5",
    picture: "picture",
    depth: "rgba is premultiplied light; depth",
    distance: "distance that",
};

/// The metadata of a frame.
pub(super) fn text(frame: &FrameImage) -> String {
    let known = attributes(frame)
        .into_iter()
        .filter(|attribute| attribute.name != seal::NAME)
        .map(|attribute| (attribute.name, json(attribute.value)));
    let mut map: Map<String, Json> = sorting::ordered(known);
    map.insert(CONVENTIONS.to_owned(), OF_ARRAYS.text().into());
    map.insert(RESOLUTION.to_owned(), frame.film.resolution.to_vec().into());
    let mattes = frame.planes().iter().filter_map(|plane| {
        let names = plane.spec.mattes.as_ref()?.mattes.iter();
        let names: Map<String, Json> = sorting::ordered(names.map(|matte| (matte.name.clone(), matte.id.into())));
        Some((plane.spec.name.clone(), names.into()))
    });
    let mattes: Map<String, Json> = sorting::ordered(mattes);
    if !mattes.is_empty() {
        map.insert("mattes".to_owned(), mattes.into());
    }
    put_window(&mut map, frame.film.window);
    Json::from(map).to_string()
}

/// The metadata of a picture that is joined of crops with these metadata.
pub(super) fn joined(array: &Array, own: &[Attribute]) -> Option<String> {
    let mut map = parse(array)?;
    let [width, height] = sizes(&map)?.0;
    for attribute in own {
        if let Some(value) = map.get_mut(&attribute.name) {
            *value = json(attribute.value.clone());
        }
    }
    put_window(&mut map, Window::full([width, height]));
    Some(Json::from(map).to_string())
}

/// The facts of a file with these metadata.
pub(super) fn facts(array: &Array) -> Option<FileFacts> {
    let map = parse(array)?;
    let (resolution, window) = sizes(&map)?;
    let attribute = |(name, value): (String, Json)| {
        let value = match value {
            Json::String(text) if text.len() <= FileFacts::MAX_ATTRIBUTE => Value::String(text),
            Json::Number(number) => match number.as_i64().map(i32::try_from) {
                Some(Ok(whole)) => Value::Int(whole),
                _ => Value::Double(number.as_f64()?),
            },
            _ => return None,
        };
        Some(Attribute { name, value })
    };
    Some(FileFacts {
        resolution,
        window,
        attributes: map.into_iter().filter_map(attribute).collect(),
    })
}

/// The facts of a file of another program that holds an array of this shape, if that may be a picture.
pub(super) fn facts_of_shape(shape: &[usize]) -> Option<FileFacts> {
    let [height, width, ..] = *shape else { return None };
    let side = |n: usize| i32::try_from(n).ok().map(i32::unsigned_abs);
    let resolution = [side(width)?, side(height)?];
    Some(FileFacts {
        resolution,
        window: Window::full(resolution),
        attributes: Vec::new(),
    })
}

fn parse(array: &Array) -> Option<Map<String, Json>> {
    let is_text = array.name == METADATA && matches!(array.element, Element::Text(_)) && array.shape.is_empty();
    is_text.then(|| serde_json::from_slice(&array.bytes).ok()).flatten()
}

/// The resolution of the whole picture, and the window of the file.
fn sizes(map: &Map<String, Json>) -> Option<([u32; 2], Window)> {
    let resolution = serde_json::from_value(map.get(RESOLUTION)?.clone()).ok()?;
    let [x0, y0, x1, y1] = serde_json::from_value(map.get(WINDOW)?.clone()).ok()?;
    (x0 < x1 && y0 < y1).then_some((resolution, Window::new(x0, y0, x1, y1)))
}

fn put_window(map: &mut Map<String, Json>, Window { x0, y0, x1, y1 }: Window) {
    map.insert(WINDOW.to_owned(), vec![x0, y0, x1, y1].into());
}

/// A value as JSON. Numbers that are not finite become texts.
fn json(value: Value) -> Json {
    let number = |v: f32| match Number::from_f64(v.to_string().parse().unwrap_or(f64::NAN)) {
        Some(number) => Json::Number(number),
        None => v.to_string().into(),
    };
    let numbers = |v: &[f32]| Json::from(v.iter().map(|v| number(*v)).collect::<Vec<Json>>());
    match value {
        Value::String(text) => text.into(),
        Value::Int(v) => v.into(),
        Value::Float(v) => number(v),
        Value::Double(v) => Number::from_f64(v).map_or_else(|| v.to_string().into(), Json::Number),
        Value::V2f(v) => numbers(&v),
        Value::M44f(v) => v.as_chunks::<4>().0.iter().map(|row| numbers(row)).collect(),
        Value::Chromaticities(v) => numbers(&v),
        Value::Box2i(Window { x0, y0, x1, y1 }) => vec![x0, y0, x1, y1].into(),
        Value::Strings(v) => v.into(),
        other @ (Value::Rational { .. } | Value::TimeCode { .. }) => other.to_string().into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_32_bits_are_written_by_their_own_digits() {
        let written = [
            Value::Float(0.1),
            Value::Float(1e10),
            Value::Float(f32::INFINITY),
            Value::Int(-3),
        ];
        let written: Vec<String> = written.into_iter().map(|value| json(value).to_string()).collect();
        assert_eq!(written, ["0.1", "10000000000.0", "\"inf\"", "-3"]);
        let rows = json(Value::M44f(std::array::from_fn(|i| i as f32)));
        assert_eq!(rows[1][2], 6.0);
    }
}
