//! The header of a file: magic number, flags, attributes sorted by name.

use super::{
    codec::DWA_LEVEL,
    compression::Compression,
    image::{Channel, Image, Samples, TILE_SIDE},
};
use crate::{
    film::Window,
    math::sorting,
    output::{BlockShape, EncodeError, Value},
};

pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
pub(super) const VERSION: u32 = 2;
/// Names may have up to 255 bytes instead of 31.
pub(super) const LONG_NAMES: u32 = 0x400;
/// The single part has tiles.
pub(super) const TILED: u32 = 0x200;
/// The file may have several parts.
pub(super) const MULTI_PART: u32 = 0x1000;

const SHORT_NAME: usize = 31;
const LONG_NAME: usize = 255;

/// An encoded attribute.
struct Entry<'a> {
    name: &'a str,
    kind: &'static str,
    bytes: Vec<u8>,
}

/// The attributes that the parts of a multi-part file need.
#[derive(Clone, Copy)]
pub(super) struct PartFacts<'a> {
    pub name: &'a str,
    /// The number of its blocks.
    pub blocks: u32,
}

/// The bytes before the headers, in which these names occur; `flags` are those of the file without that for long names.
pub(super) fn begin<'a>(mut names: impl Iterator<Item = &'a str>, flags: u32) -> Vec<u8> {
    let long = names.any(|name| name.len() > SHORT_NAME);
    let version = VERSION | flags | if long { LONG_NAMES } else { 0 };
    [MAGIC, version.to_le_bytes()].concat()
}

/// The names of the attributes and channels of `image`.
pub(super) fn names<'a>(image: &Image<'a>) -> impl Iterator<Item = &'a str> {
    let attributes = image.attributes.iter().map(|a| a.name.as_str());
    attributes.chain(image.channels.iter().map(|c| c.name))
}

/// The header of `image`, whose channels are `channels`, sorted.
pub(super) fn encode(image: &Image, channels: &[Channel], part: Option<PartFacts>) -> Result<Vec<u8>, EncodeError> {
    let mut entries: Vec<Entry> = image.attributes.iter().map(|a| entry(&a.name, &a.value)).collect();
    entries.extend([
        entry("dataWindow", &Value::Box2i(image.data)),
        entry("displayWindow", &Value::Box2i(image.display)),
        entry("pixelAspectRatio", &Value::Float(1.0)),
        entry("screenWindowCenter", &Value::V2f([0.0, 0.0])),
        entry("screenWindowWidth", &Value::Float(1.0)),
        raw("channels", "chlist", channel_list(channels)),
        raw("compression", "compression", vec![image.compression.code()]),
        raw("lineOrder", "lineOrder", vec![0]),
    ]);
    if image.compression == Compression::Dwaa {
        entries.push(entry("dwaCompressionLevel", &Value::Float(DWA_LEVEL)));
    }
    if image.blocks == BlockShape::Tiles {
        // No mipmaps.
        let side = TILE_SIDE.to_le_bytes();
        entries.push(raw("tiles", "tiledesc", [&side[..], &side, &[0]].concat()));
    }
    if let Some(PartFacts { name, blocks }) = part {
        let kind = match image.blocks {
            BlockShape::Lines => "scanlineimage",
            BlockShape::Tiles => "tiledimage",
        };
        entries.extend([
            entry("name", &name.into()),
            entry("type", &kind.into()),
            entry("chunkCount", &Value::Int(blocks as i32)),
        ]);
    }
    sorting::sort_by_key(&mut entries, |e| e.name);
    check_names(&entries, channels)?;

    let mut bytes = Vec::new();
    for entry in &entries {
        let size = i32::try_from(entry.bytes.len())
            .map_err(|_| EncodeError::Unfit(format!("attribute '{}' is too long", entry.name)))?;
        put_name(&mut bytes, entry.name);
        put_name(&mut bytes, entry.kind);
        bytes.extend(size.to_le_bytes());
        bytes.extend(&entry.bytes);
    }
    bytes.push(0);
    Ok(bytes)
}

fn check_names(entries: &[Entry], channels: &[Channel]) -> Result<(), EncodeError> {
    let unfit = |reason: String| Err(EncodeError::Unfit(reason));
    if let Some(pair) = entries.windows(2).find(|pair| pair[0].name == pair[1].name) {
        return unfit(format!("two attributes '{}'", pair[0].name));
    }
    for name in entries.iter().map(|e| e.name).chain(channels.iter().map(|c| c.name)) {
        if name.is_empty() || name.len() > LONG_NAME || name.contains('\0') {
            return unfit(format!(
                "the name {name:?}: from 1 to {LONG_NAME} bytes fit, none of them 0"
            ));
        }
    }
    Ok(())
}

fn put_name(bytes: &mut Vec<u8>, name: &str) {
    bytes.extend(name.as_bytes());
    bytes.push(0);
}

fn channel_list(channels: &[Channel]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for channel in channels {
        let kind: i32 = match channel.samples {
            Samples::Uint(_) => 0,
            Samples::Half(_) => 1,
            Samples::Float(_) => 2,
        };
        put_name(&mut bytes, channel.name);
        bytes.extend(kind.to_le_bytes());
        // Not perceptually linear, and three reserved bytes.
        bytes.extend([0; 4]);
        let every_pixel = 1_i32.to_le_bytes();
        bytes.extend(every_pixel);
        bytes.extend(every_pixel);
    }
    bytes.push(0);
    bytes
}

fn raw<'a>(name: &'a str, kind: &'static str, bytes: Vec<u8>) -> Entry<'a> {
    Entry { name, kind, bytes }
}

fn entry<'a>(name: &'a str, value: &Value) -> Entry<'a> {
    let floats = |v: &[f32]| v.iter().flat_map(|v| v.to_le_bytes()).collect();
    let (kind, bytes) = match value {
        Value::String(v) => ("string", v.clone().into_bytes()),
        Value::Int(v) => ("int", v.to_le_bytes().to_vec()),
        Value::Float(v) => ("float", v.to_le_bytes().to_vec()),
        Value::Double(v) => ("double", v.to_le_bytes().to_vec()),
        Value::V2f(v) => ("v2f", floats(v)),
        Value::M44f(v) => ("m44f", floats(v)),
        Value::Chromaticities(v) => ("chromaticities", floats(v)),
        Value::Rational { numerator, denominator } => (
            "rational",
            [numerator.to_le_bytes(), denominator.to_le_bytes()].concat(),
        ),
        Value::TimeCode { time, user } => ("timecode", [time.to_le_bytes(), user.to_le_bytes()].concat()),
        Value::Box2i(window) => ("box2i", corners(*window).map(i32::to_le_bytes).concat()),
        Value::Strings(v) => ("stringvector", strings(v)),
    };
    raw(name, kind, bytes)
}

/// Decodes an attribute of type `kind`; `None` if no [`Value`] has this type or `bytes` are invalid.
pub(super) fn decode(kind: &[u8], bytes: &[u8]) -> Option<Value> {
    let word = |i: usize| -> Option<[u8; 4]> { bytes.get(4 * i..4 * i + 4)?.try_into().ok() };
    let int = |i: usize| word(i).map(i32::from_le_bytes);
    let float = |i: usize| word(i).map(f32::from_le_bytes);
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).ok();
    Some(match (kind, bytes.len()) {
        (b"string", _) => Value::String(text(bytes)?),
        (b"int", 4) => Value::Int(int(0)?),
        (b"float", 4) => Value::Float(float(0)?),
        (b"double", 8) => Value::Double(f64::from_le_bytes(bytes.try_into().ok()?)),
        (b"v2f", 8) => Value::V2f([float(0)?, float(1)?]),
        (b"m44f", 64) => Value::M44f(floats(bytes)?),
        (b"chromaticities", 32) => Value::Chromaticities(floats(bytes)?),
        (b"timecode", 8) => Value::TimeCode {
            time: word(0).map(u32::from_le_bytes)?,
            user: word(1).map(u32::from_le_bytes)?,
        },
        (b"rational", 8) => Value::Rational {
            numerator: int(0)?,
            denominator: word(1).map(u32::from_le_bytes)?,
        },
        (b"box2i", 16) => {
            let end = |min: i32, max: i32| max.checked_add(1).filter(|end| *end >= min);
            let (x0, y0) = (int(0)?, int(1)?);
            Value::Box2i(Window::new(x0, y0, end(x0, int(2)?)?, end(y0, int(3)?)?))
        }
        (b"stringvector", _) => {
            let (mut rest, mut list) = (bytes, Vec::new());
            while let Some((length, after)) = rest.split_first_chunk::<4>() {
                let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
                list.push(text(after.get(..length)?)?);
                rest = &after[length..];
            }
            Value::Strings(list)
        }
        _ => return None,
    })
}

/// Decodes exactly `N` little-endian numbers.
fn floats<const N: usize>(bytes: &[u8]) -> Option<[f32; N]> {
    let floats: Vec<f32> = bytes
        .as_chunks()
        .0
        .iter()
        .map(|word| f32::from_le_bytes(*word))
        .collect();
    floats.try_into().ok()
}

/// The first and the last pixel, both inclusive.
fn corners(Window { x0, y0, x1, y1 }: Window) -> [i32; 4] {
    [x0, y0, x1.wrapping_sub(1), y1.wrapping_sub(1)]
}

fn strings(list: &[String]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for s in list {
        bytes.extend((s.len() as u32).to_le_bytes());
        bytes.extend(s.as_bytes());
    }
    bytes
}
