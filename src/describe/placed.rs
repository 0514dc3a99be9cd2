//! Values of TOML at the place of the override that gives them.

use std::borrow::Cow;

use toml::de::DeValue;

use crate::value::{Span, Spanned};

/// The value with all of it at `span`.
pub(super) fn placed<'i>(value: DeValue<'i>, span: &Span) -> Spanned<DeValue<'i>> {
    let inside = |value: Spanned<DeValue<'i>>| placed(value.into_inner(), span);
    let value = match value {
        DeValue::Array(array) => DeValue::Array(array.into_iter().map(inside).collect()),
        DeValue::Table(table) => {
            let entry = |(key, value): (Spanned<Cow<'i, str>>, _)| {
                (Spanned::new(span.clone(), key.into_inner()), inside(value))
            };
            DeValue::Table(table.into_iter().map(entry).collect())
        }
        other => other,
    };
    Spanned::new(span.clone(), value)
}
