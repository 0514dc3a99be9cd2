//! Properties of elements, read one after another or skipped.

use super::{
    header::{Element, NumberType, Property, PropertyKind},
    source::{Source, Stop},
};
use crate::{assets::bare::BareMeshProblem, value::one_line};

pub(super) fn broken(cause: impl AsRef<str>) -> BareMeshProblem {
    BareMeshProblem::Broken(one_line(cause.as_ref(), 200).into_owned())
}

/// The error at element `at`.
pub(super) fn stopped(element: &Element, at: u64) -> impl Fn(Stop) -> BareMeshProblem {
    let place = format!("{} {at}", element.name);
    move |stop| match &stop {
        Stop::End => broken(format!("the file ends within {place}")),
        Stop::NoNumber(word) => broken(format!("{place}: expected a number, found '{}'", one_line(word, 40))),
    }
}

/// Reads the length of a list.
pub(super) fn list_length(source: &mut impl Source, count: NumberType) -> Result<usize, Stop> {
    let length = source.number(count)?;
    // No list is longer than the file.
    if length >= 0.0 && length.fract() == 0.0 && length <= source.bytes_left() as f64 {
        Ok(length as usize)
    } else {
        Err(Stop::NoNumber(format!("a list of {length} numbers")))
    }
}

pub(super) fn skip_property(source: &mut impl Source, property: &Property) -> Result<(), Stop> {
    match property.kind {
        PropertyKind::Number(number) => source.skip(number, 1),
        PropertyKind::List { count, item } => {
            let length = list_length(source, count)?;
            source.skip(item, length)
        }
    }
}

pub(super) fn skip(element: &Element, source: &mut impl Source) -> Result<(), BareMeshProblem> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for i in 0..element.count {
        for property in &element.properties {
            skip_property(source, property).map_err(|stop| stopped(element, i)(stop))?;
        }
    }
    Ok(())
}
