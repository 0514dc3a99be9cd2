//! The header of a PLY file.

/// The encoding of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl NumberType {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// The bytes of a binary number.
    pub const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The largest whole number of the type, which stands for 1 in a colour; 1 of a float.
    pub fn one(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// The kind of a property: a number or a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PropertyKind {
    Number(NumberType),
    List { count: NumberType, item: NumberType },
}

/// A property of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub name: String,
    pub kind: PropertyKind,
}

/// An element declaration, such as that of vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// The least bytes of one element.
    pub fn least_bytes(&self, encoding: Encoding) -> u64 {
        let of = |property: &Property| match (encoding, property.kind) {
            // A digit, and a space or line end.
            (Encoding::Text, _) => 2,
            (_, PropertyKind::Number(number)) => number.size(),
            (_, PropertyKind::List { count, .. }) => count.size(),
        };
        self.properties.iter().map(|p| of(p) as u64).sum()
    }
}

/// A header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The number of textures that comments name.
    pub textures: usize,
}

/// The fault of a file that does not begin as PLY files do.
const NO_HEADER: &str = "it has no header, the file does not begin with `ply`";

/// Reads the header; returns it with the data after it.
///
/// # Errors
/// The header is broken; the text says why.
pub(super) fn read(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
    let (first, mut rest) = line(bytes).ok_or(NO_HEADER)?;
    if first != b"ply" {
        return Err(NO_HEADER.into());
    }
    let mut encoding = None;
    let (mut elements, mut textures) = (Vec::<Element>::new(), 0);
    loop {
        let (text, after) = line(rest).ok_or("the header does not end")?;
        rest = after;
        let text = String::from_utf8_lossy(text);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        match words[..] {
            [] | ["obj_info", ..] => {}
            ["comment", ref comment @ ..] => textures += usize::from(comment.first() == Some(&"TextureFile")),
            ["format", name, _] => {
                encoding = Some(match name {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(format!("the format `{name}` is unknown")),
                });
            }
            ["element", name, count] => elements.push(Element {
                name: name.to_owned(),
                count: count
                    .parse()
                    .map_err(|_| format!("the number of elements `{name}` is `{count}`"))?,
                properties: Vec::new(),
            }),
            ["property", .., name] => {
                let kind = property(&words).ok_or_else(|| format!("the property is not understood: {text}"))?;
                let element = elements.last_mut().ok_or("a property without an element")?;
                let name = name.to_owned();
                element.properties.push(Property { name, kind });
            }
            ["end_header"] => break,
            _ => return Err(format!("the line of the header is not understood: {text}")),
        }
    }
    let encoding = encoding.ok_or("the header names no format")?;
    Ok((
        Header {
            encoding,
            elements,
            textures,
        },
        rest,
    ))
}

fn property(words: &[&str]) -> Option<PropertyKind> {
    match *words {
        [_, "list", count, item, _] => Some(PropertyKind::List {
            count: NumberType::of(count)?,
            item: NumberType::of(item)?,
        }),
        [_, number, _] => Some(PropertyKind::Number(NumberType::of(number)?)),
        _ => None,
    }
}

/// Splits off the next line, which ends in `\n`, `\r\n` or `\r`.
fn line(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'))?;
    let after = if bytes[end..].starts_with(b"\r\n") {
        end + 2
    } else {
        end + 1
    };
    Some((bytes[..end].trim_ascii(), &bytes[after..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_read_with_any_line_ends() {
        let text = "ply\nformat binary_big_endian 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty double x\nelement face 1\nproperty list uchar int vertex_index\nend_header\n\n1";
        for end in ["\n", "\r\n"] {
            let text = text.replace('\n', end);
            let (header, data) = read(text.as_bytes()).unwrap();
            assert_eq!((header.encoding, header.textures), (Encoding::BigEndian, 1));
            assert_eq!(header.elements[0].least_bytes(header.encoding), 8);
            assert_eq!(header.elements[1].properties[0].name, "vertex_index");
            // The data starts with the byte of a line end.
            assert_eq!(data, format!("{end}1").as_bytes());
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let flaw = |text: &str| read(text.as_bytes()).unwrap_err();
        assert_eq!(flaw("solid\n"), NO_HEADER);
        assert_eq!(flaw("ply\nformat ascii 1.0\n"), "the header does not end");
        assert_eq!(flaw("ply\nend_header\n"), "the header names no format");
        assert_eq!(flaw("ply\nformat middle 1.0\n"), "the format `middle` is unknown");
        assert_eq!(
            flaw("ply\nelement vertex -1\n"),
            "the number of elements `vertex` is `-1`"
        );
        assert_eq!(flaw("ply\nproperty float x\n"), "a property without an element");
        assert!(flaw("ply\nelement a 1\nproperty list float x\n").contains("not understood"));
    }
}
