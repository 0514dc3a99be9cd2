//! Crops to the whole picture: pixels are decoded, put into their places, and encoded again as they were.

use std::io::BufReader;

use ::exr::{
    block::{self, UncompressedBlock, lines::LineIndex, reader::ChunksReader as _},
    math::Vec2,
    meta::attribute::SampleType,
};

use super::{
    compression::Compression,
    headers::{Header, Headers},
    image::{Channel, ChannelData, Image, Samples},
    write::{write, write_parts},
};
use crate::{
    film::Window,
    output::{
        Attribute, BlockShape, Value, facts,
        join::{CropFile, JoinError, replace},
    },
};

/// The attributes that the writer makes itself.
const WRITERS_OWN: [&str; 12] = [
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "dwaCompressionLevel",
    "lineOrder",
    "name",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "type",
];

/// A part of the file of the whole picture.
struct Part {
    name: String,
    attributes: Vec<Attribute>,
    compression: Compression,
    blocks: BlockShape,
    display: Window,
    planes: Vec<Plane>,
}

/// A channel of the whole picture.
struct Plane {
    name: String,
    numbers: Numbers,
}

/// The numbers of a channel, row by row from the top.
enum Numbers {
    Half(Vec<f32>),
    Float(Vec<f32>),
    Uint(Vec<u32>),
}

impl Numbers {
    fn new(kind: SampleType, count: usize) -> Self {
        match kind {
            SampleType::F16 => Self::Half(vec![0.0; count]),
            SampleType::F32 => Self::Float(vec![0.0; count]),
            SampleType::U32 => Self::Uint(vec![0; count]),
        }
    }

    fn kind(&self) -> SampleType {
        match self {
            Self::Half(_) => SampleType::F16,
            Self::Float(_) => SampleType::F32,
            Self::Uint(_) => SampleType::U32,
        }
    }

    /// Replaces the numbers from the `at`th on by those of a line of a file.
    fn put(&mut self, at: usize, line: &[u8]) {
        match self {
            Self::Half(out) => put(&mut out[at..], line, |bytes| half::f16::from_ne_bytes(bytes).to_f32()),
            Self::Float(out) => put(&mut out[at..], line, f32::from_ne_bytes),
            Self::Uint(out) => put(&mut out[at..], line, u32::from_ne_bytes),
        }
    }

    fn samples(&self) -> Samples<'_> {
        match self {
            Self::Half(values) => Samples::Half(ChannelData::dense(values)),
            Self::Float(values) => Samples::Float(ChannelData::dense(values)),
            Self::Uint(values) => Samples::Uint(ChannelData::dense(values)),
        }
    }
}

fn put<T, const N: usize>(out: &mut [T], line: &[u8], number: impl Fn([u8; N]) -> T) {
    for (out, bytes) in out.iter_mut().zip(line.as_chunks().0) {
        *out = number(*bytes);
    }
}

/// The bytes of the file of the whole picture.
pub(super) fn join(crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
    let first = &crops[0];
    let (is_multi, mut parts) = parts(first)?;
    for crop in crops {
        let (_, others) = self::parts(crop)?;
        let is_same = |(a, b): (&Part, &Part)| {
            let common = |part: &Part| {
                let mut list = part.attributes.clone();
                replace(&mut list, own);
                list
            };
            a.name == b.name && (a.compression, a.blocks) == (b.compression, b.blocks) && common(a) == common(b)
        };
        if parts.len() != others.len() || !parts.iter().zip(&others).all(is_same) {
            return Err(JoinError::different(first, crop));
        }
    }
    for crop in crops {
        read(crop, &mut parts)?;
    }
    for part in &mut parts {
        replace(&mut part.attributes, own);
    }
    let channels: Vec<Vec<Channel>> = parts.iter().map(channels).collect();
    let images = parts.iter().zip(&channels).map(|(part, channels)| {
        let image = Image {
            display: part.display,
            data: part.display,
            channels,
            attributes: &part.attributes,
            compression: part.compression,
            blocks: part.blocks,
        };
        (part.name.as_str(), image)
    });
    let images: Vec<(&str, Image)> = images.collect();
    let mut bytes = Vec::new();
    let written = match (is_multi, &images[..]) {
        (false, [(_, image), ..]) => write(image, &mut bytes),
        _ => write_parts(&images, &mut bytes),
    };
    written.map_err(|error| JoinError::unfit(first, &error))?;
    Ok(bytes)
}

fn channels(part: &Part) -> Vec<Channel<'_>> {
    let channels = part.planes.iter().map(|plane| Channel {
        name: &plane.name,
        samples: plane.numbers.samples(),
    });
    channels.collect()
}

/// The parts of a file, without their numbers; whether it may have several.
fn parts(crop: &CropFile) -> Result<(bool, Vec<Part>), JoinError> {
    let headers = facts::open(&crop.path).and_then(|file| Headers::read(&mut BufReader::new(file), usize::MAX));
    let headers = headers.map_err(|error| JoinError::unreadable(&crop.path, &error))?;
    let headers =
        headers.ok_or_else(|| JoinError::unreadable(&crop.path, &"it has neither lines nor tiles of pixels"))?;
    let parts = headers.parts.into_iter().map(|header| part(crop, header));
    Ok((headers.is_multi, parts.collect::<Result<_, _>>()?))
}

fn part(crop: &CropFile, header: Header) -> Result<Part, JoinError> {
    let unfit = |reason: &str| JoinError::Unfit {
        reason: reason.to_owned(),
        path: crop.path.clone(),
    };
    let known = Compression::ALL.into_iter().find(|c| c.code() == header.compression);
    let compression = known.ok_or_else(|| unfit("its compression is none of this program"))?;
    if compression.is_lossy() {
        return Err(unfit(
            "its compression is lossy: its pixels, packed again, are not those of the whole picture",
        ));
    }
    let text = |name: &str| {
        header.attributes.iter().find_map(|a| match &a.value {
            Value::String(text) if a.name == name => Some(text.clone()),
            _ => None,
        })
    };
    Ok(Part {
        name: text("name").unwrap_or_default(),
        compression,
        blocks: header.block_shape(),
        display: header.display,
        planes: Vec::new(),
        attributes: header
            .attributes
            .into_iter()
            .filter(|a| !WRITERS_OWN.contains(&a.name.as_str()))
            .collect(),
    })
}

/// Puts the numbers of a file into their places.
fn read(crop: &CropFile, parts: &mut [Part]) -> Result<(), JoinError> {
    let unreadable = |error: ::exr::error::Error| JoinError::unreadable(&crop.path, &error);
    let file = facts::open(&crop.path).map_err(|error| JoinError::unreadable(&crop.path, &error))?;
    let reader = block::read(BufReader::new(file), true).map_err(unreadable)?;
    let mut chunks = reader.all_chunks(true).map_err(unreadable)?;
    let meta = chunks.meta_data().clone();
    let size = Vec2(crop.window.width() as usize, crop.window.height() as usize);
    if meta.headers.len() != parts.len() || meta.headers.iter().any(|header| header.layer_size != size) {
        return Err(JoinError::unreadable(&crop.path, &"it has changed"));
    }
    for (part, header) in parts.iter_mut().zip(&meta.headers) {
        let channels = header.channels.list.iter();
        let found: Vec<(String, SampleType)> = channels.map(|c| (c.name.to_string(), c.sample_type)).collect();
        if part.planes.is_empty() {
            let plane = |(name, kind)| Plane {
                name,
                numbers: Numbers::new(kind, part.display.area()),
            };
            part.planes = found.into_iter().map(plane).collect();
        } else if !part.planes.iter().map(|p| (p.name.clone(), p.numbers.kind())).eq(found) {
            return Err(JoinError::unreadable(
                &crop.path,
                &"it has other channels than the others",
            ));
        }
    }
    chunks
        .try_for_each(|chunk| {
            let block = UncompressedBlock::decompress_chunk(chunk?, &meta, true)?;
            let part = &mut parts[block.index.layer];
            let channels = &meta.headers[block.index.layer].channels;
            for (bytes, line) in LineIndex::lines_in_block(block.index, channels) {
                let column = crop.window.x0.wrapping_add_unsigned(line.position.x() as u32);
                let row = crop.window.y0.wrapping_add_unsigned(line.position.y() as u32);
                let at = part.display.index(column, row);
                part.planes[line.channel].numbers.put(at, &block.data[bytes]);
            }
            Ok(())
        })
        .map_err(unreadable)
}
