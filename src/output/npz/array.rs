//! Arrays of NumPy: the files `NAME.npy`, of which an NPZ file is made.
//!
//! Source: "numpy.lib.format", version 1.0 of the format.

use std::borrow::Cow;

use super::zip::{ALIGNMENT, Member};

const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
/// The ending of the names of arrays.
const ENDING: &str = ".npy";

/// The type of the elements of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    F32,
    U32,
    /// A text of this many bytes.
    Text(usize),
}

impl Element {
    fn code(self) -> String {
        match self {
            Self::F32 => "<f4".to_owned(),
            Self::U32 => "<u4".to_owned(),
            Self::Text(length) => format!("|S{length}"),
        }
    }

    fn parse(code: &str) -> Option<Self> {
        match code {
            "<f4" => Some(Self::F32),
            "<u4" => Some(Self::U32),
            _ => Some(Self::Text(code.strip_prefix("|S")?.parse().ok()?)),
        }
    }

    fn size(self) -> usize {
        match self {
            Self::F32 | Self::U32 => 4,
            Self::Text(length) => length,
        }
    }
}

/// A named array, with the last index running fastest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Array<'a> {
    pub name: String,
    pub element: Element,
    pub shape: Vec<usize>,
    /// Little-endian.
    pub bytes: Cow<'a, [u8]>,
}

impl<'a> Array<'a> {
    /// An array of numbers, or of the bits of whole ones.
    pub fn new(name: &str, element: Element, shape: Vec<usize>, values: &'a [f32]) -> Self {
        let bytes = match cfg!(target_endian = "big") {
            true => Cow::Owned(values.iter().flat_map(|v| v.to_le_bytes()).collect()),
            false => bytemuck::cast_slice(values).into(),
        };
        Self {
            name: name.to_owned(),
            element,
            shape,
            bytes,
        }
    }

    /// An array of little-endian numbers.
    pub fn owned(name: String, element: Element, shape: Vec<usize>, numbers: Vec<[u8; 4]>) -> Self {
        Self {
            name,
            element,
            shape,
            bytes: numbers.into_flattened().into(),
        }
    }

    /// An array of no dimensions with a text.
    pub fn text(name: &str, text: String) -> Self {
        Self {
            name: name.to_owned(),
            element: Element::Text(text.len()),
            shape: Vec::new(),
            bytes: text.into_bytes().into(),
        }
    }

    /// The member of an archive with the array.
    pub fn into_member(self) -> Member<'a> {
        let numbers: Vec<String> = self.shape.iter().map(|n| n.to_string()).collect();
        let comma = if numbers.len() == 1 { "," } else { "" };
        let (code, shape) = (self.element.code(), numbers.join(", "));
        let mut facts = format!("{{'descr': '{code}', 'fortran_order': False, 'shape': ({shape}{comma}), }}");
        let before = MAGIC.len() + 2;
        let length = (before + facts.len() + 1).next_multiple_of(ALIGNMENT) - before;
        facts += &" ".repeat(length - 1 - facts.len());
        facts.push('\n');
        Member {
            name: self.name + ENDING,
            head: [MAGIC, &(length as u16).to_le_bytes(), facts.as_bytes()].concat(),
            data: self.bytes,
        }
    }

    /// Reads a member of an archive with an array of this program, which has at least one byte; `None` for others.
    pub fn parse(name: &str, mut member: Vec<u8>) -> Option<Array<'static>> {
        let rest = member.strip_prefix(MAGIC)?;
        let (length, rest) = rest.split_first_chunk()?;
        let (facts, data) = rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))?;
        let facts = str::from_utf8(facts).ok()?.strip_prefix("{'descr': '")?;
        let (code, facts) = facts.split_once("', 'fortran_order': False, 'shape': (")?;
        let (shape, _) = facts.split_once(')')?;
        let numbers = shape.split(',').map(str::trim).filter(|n| !n.is_empty());
        let shape: Vec<usize> = numbers.map(|n| n.parse().ok()).collect::<Option<_>>()?;
        let element = Element::parse(code)?;
        let size = shape.iter().try_fold(element.size(), |size, n| size.checked_mul(*n))?;
        // Another dimension of an empty array may be of any size.
        if size == 0 || size != data.len() {
            return None;
        }
        member.drain(..member.len() - size);
        Some(Array {
            name: name.strip_suffix(ENDING).unwrap_or(name).to_owned(),
            element,
            shape,
            bytes: Cow::Owned(member),
        })
    }

    /// The bytes of an element of the first two dimensions, a pixel.
    pub fn pixel_size(&self) -> usize {
        self.shape.iter().skip(2).product::<usize>() * self.element.size()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_read_as_they_are_written_and_numbers_are_aligned() {
        let numbers: Vec<f32> = (0..6).map(|i| i as f32).collect();
        for shape in [vec![6], vec![2, 3], vec![1, 2, 3], vec![3, 2, 1, 1]] {
            let array = Array::new("depth", Element::F32, shape, numbers.as_slice());
            let Member { name, head, data } = array.clone().into_member();
            assert_eq!((name.as_str(), head.len() % ALIGNMENT), ("depth.npy", 0));
            assert_eq!(Array::parse(&name, [&head, &*data].concat()), Some(array));
        }
        let text = Array::text("metadata", "{\"a\": \"\u{fc}\"}".to_owned());
        let Member { name, head, data } = text.clone().into_member();
        assert!(head.windows(5).any(|part| part == b"'|S11"));
        assert_eq!(Array::parse(&name, [&head, &*data].concat()), Some(text));
    }

    #[test]
    fn an_array_that_is_cut_off_or_too_large_for_its_bytes_is_none() {
        let array = Array::new("a", Element::U32, vec![2, 2], &[0.0; 4][..]);
        let Member { head, data, .. } = array.into_member();
        let whole = [&head, &*data].concat();
        for length in 0..whole.len() {
            assert_eq!(Array::parse("a", whole[..length].to_vec()), None, "{length}");
        }
        let text = String::from_utf8_lossy(&head[10..]).replace("(2, 2)", "(9999999999999999999, 9)");
        let huge = [&head[..10], text.as_bytes()].concat();
        assert_eq!(Array::parse("a", huge), None);
    }

    #[test]
    fn an_array_without_elements_or_with_elements_of_no_size_is_none() {
        let array = Array::new("a", Element::F32, vec![2, 1], &[0.0; 2][..]);
        let Member { head, .. } = array.into_member();
        let shaped = |code: &str, shape: &str, bytes: &[u8]| {
            let text = String::from_utf8_lossy(&head[10..])
                .replace("<f4", code)
                .replace("2, 1", shape);
            let length = u16::try_from(text.len()).unwrap();
            [MAGIC, &length.to_le_bytes(), text.as_bytes(), bytes].concat()
        };
        assert!(Array::parse("a", shaped("<f4", "2, 1", &[0; 8])).is_some());
        for (code, shape) in [
            ("<f4", "0"),
            ("<f4", "2, 1, 0"),
            ("<f4", "0, 4294967296, 4294967296, 4294967296"),
            ("|S0", "2, 1"),
            ("|S0", ""),
        ] {
            assert_eq!(Array::parse("a", shaped(code, shape, &[])), None, "{code} ({shape})");
        }
    }
}
