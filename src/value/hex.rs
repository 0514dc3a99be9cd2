//! Colours in hexadecimal digits, which scene files do not have.

use serde::de;

use crate::math::srgb;

/// The error of a colour in hexadecimal digits, which says how it is written here.
pub(super) fn in_hex<E: de::Error>(text: &str) -> Option<E> {
    let digits = text.strip_prefix('#').or(text.strip_prefix("0x"))?;
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6)?;
    let [_, codes @ ..] = number.to_be_bytes();
    let [r, g, b] = codes.map(srgb::decode8);
    Some(E::custom(format_args!(
        "colours are numbers of linear light: `{text}` is [{r:.4}, {g:.4}, {b:.4}]"
    )))
}
