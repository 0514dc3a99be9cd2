//! An EXR file in memory: its parts, their attributes, and the numbers of their channels.

use std::{io::BufReader, path::Path};

use super::{
    compression::Compression,
    cryptomatte,
    headers::{Header, Headers},
    image::{Channel, ChannelData, Image, Samples},
    write::{write, write_parts},
};
use crate::{
    film::Window,
    math::parallel,
    output::{Attribute, BlockShape, EncodeError, Value, facts},
    scene::MatteTable,
};
use ::exr::{
    block::{self, UncompressedBlock, chunk::Chunk, lines::LineIndex, reader::ChunksReader as _},
    math::Vec2,
    meta::attribute::SampleType,
};

/// The attributes that the writer computes.
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

/// The attributes that the renderer adds to every file.
const RENDERERS_OWN: [&str; 13] = [
    "software",
    "batch-render/version",
    "batch-render/checksum",
    "batch-render/frame",
    "batch-render/samples",
    "batch-render/seed",
    "batch-render/sampler",
    "batch-render/conventions",
    "imageCounter",
    "framesPerSecond",
    "timeCode",
    "chromaticities",
    "colorInteropID",
];

/// An EXR file in memory.
#[derive(Clone, Debug)]
pub struct ExrFile {
    /// Whether the file is declared as multi-part.
    pub is_multi: bool,
    /// At least one.
    pub parts: Vec<Part>,
}

/// A part of a file.
#[derive(Clone, Debug)]
pub struct Part {
    pub name: String,
    /// The attributes, without those that the writer computes.
    pub attributes: Vec<Attribute>,
    pub compression: Compression,
    pub blocks: BlockShape,
    /// The full frame.
    pub display: Window,
    /// The stored pixels.
    pub data: Window,
    pub planes: Vec<Plane>,
}

/// A channel with its full name.
#[derive(Clone, Debug)]
pub struct Plane {
    pub name: String,
    pub numbers: Numbers,
}

/// The numbers of a channel, row by row from the top, by their stored type.
#[derive(Clone, Debug)]
pub enum Numbers {
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

    /// Replaces the numbers from index `at` on by those of a line of a file.
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

impl Part {
    fn new(header: Header) -> Result<Self, ReadError> {
        let known = Compression::ALL.into_iter().find(|c| c.code() == header.compression);
        let compression = known.ok_or(ReadError::Compression)?;
        let text = |name: &str| {
            header.attributes.iter().find_map(|a| match &a.value {
                Value::String(text) if a.name == name => Some(text.clone()),
                _ => None,
            })
        };
        Ok(Self {
            name: text("name").unwrap_or_default(),
            compression,
            blocks: header.block_shape(),
            display: header.display,
            data: header.data,
            planes: Vec::new(),
            attributes: header
                .attributes
                .into_iter()
                .filter(|a| !WRITERS_OWN.contains(&a.name.as_str()))
                .collect(),
        })
    }
}

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("cannot read the pixels: {0}")]
    Unreadable(String),
    #[error("its compression is none of this program")]
    Compression,
}

impl ReadError {
    fn new(reason: &impl ToString) -> Self {
        Self::Unreadable(reason.to_string())
    }
}

impl ExrFile {
    /// Reads the file at `path` without its numbers.
    ///
    /// # Errors
    /// The file cannot be read, or has neither scanlines nor tiles.
    pub fn without_numbers(path: &Path) -> Result<Self, ReadError> {
        let headers = facts::open(path).and_then(|file| Headers::read(&mut BufReader::new(file), usize::MAX));
        let headers = headers.map_err(|error| ReadError::new(&error))?;
        let headers = headers.ok_or_else(|| ReadError::new(&"it has neither lines nor tiles of pixels"))?;
        let parts = headers.parts.into_iter().map(Part::new);
        Ok(Self {
            is_multi: headers.is_multi,
            parts: parts.collect::<Result<_, _>>()?,
        })
    }

    /// Reads the file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or has neither scanlines nor tiles.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let mut file = Self::without_numbers(path)?;
        let window = file.parts[0].data;
        if file.parts.iter().any(|part| part.data != window) {
            return Err(ReadError::new(&"its parts have different sizes"));
        }
        file.put(path, window)?;
        Ok(file)
    }

    /// Copies the numbers of the file at `path`, which holds this window, into this one.
    ///
    /// # Errors
    /// The file cannot be read, or has other parts or channels than this one.
    pub fn put(&mut self, path: &Path, window: Window) -> Result<(), ReadError> {
        let unreadable = |error: ::exr::error::Error| ReadError::new(&error);
        let file = facts::open(path).map_err(|error| ReadError::new(&error))?;
        let reader = block::read(BufReader::new(file), true).map_err(unreadable)?;
        let mut chunks = reader.all_chunks(true).map_err(unreadable)?;
        let meta = chunks.meta_data().clone();
        let size = Vec2(window.width() as usize, window.height() as usize);
        if meta.headers.len() != self.parts.len() || meta.headers.iter().any(|header| header.layer_size != size) {
            return Err(ReadError::new(&"it has changed"));
        }
        for (part, header) in self.parts.iter_mut().zip(&meta.headers) {
            let channels = header.channels.list.iter();
            let found: Vec<(String, SampleType)> = channels.map(|c| (c.name.to_string(), c.sample_type)).collect();
            if part.planes.is_empty() {
                let plane = |(name, kind)| Plane {
                    name,
                    numbers: Numbers::new(kind, part.data.area()),
                };
                part.planes = found.into_iter().map(plane).collect();
            } else if !part.planes.iter().map(|p| (p.name.clone(), p.numbers.kind())).eq(found) {
                return Err(ReadError::new(&"it has other channels than the others"));
            }
        }
        // The number of blocks that are decoded in parallel.
        const TOGETHER: usize = 64;
        loop {
            let some: Result<Vec<Chunk>, _> = chunks.by_ref().take(TOGETHER).collect();
            let some = some.map_err(unreadable)?;
            if some.is_empty() {
                return Ok(());
            }
            let unpack = |chunk| UncompressedBlock::decompress_chunk(chunk, &meta, true);
            for block in parallel::map(some, unpack) {
                let block = block.map_err(unreadable)?;
                let part = &mut self.parts[block.index.layer];
                let channels = &meta.headers[block.index.layer].channels;
                for (bytes, line) in LineIndex::lines_in_block(block.index, channels) {
                    let column = window.x0.wrapping_add_unsigned(line.position.x() as u32);
                    let row = window.y0.wrapping_add_unsigned(line.position.y() as u32);
                    let at = part.data.index(column, row);
                    part.planes[line.channel].numbers.put(at, &block.data[bytes]);
                }
            }
        }
    }

    /// The planes of all parts.
    pub fn planes(&self) -> impl Iterator<Item = &Plane> {
        self.parts.iter().flat_map(|part| &part.planes)
    }

    /// The mattes of a pass, if it is one of mattes.
    pub fn mattes(&self, pass: &str) -> Option<MatteTable> {
        cryptomatte::table(self.parts.iter().flat_map(|part| &part.attributes), pass)
    }

    /// The attribute of this name in the first part.
    pub fn attribute(&self, name: &str) -> Option<&Value> {
        let mut attributes = self.parts[0].attributes.iter();
        attributes.find(|a| a.name == name).map(|a| &a.value)
    }

    /// The attributes that the renderer was given for the frame, without those that it adds to every file.
    pub fn given_attributes(&self) -> impl Iterator<Item = &Attribute> {
        let is_own = |name: &str| RENDERERS_OWN.contains(&name) || name.starts_with("cryptomatte/");
        self.parts[0].attributes.iter().filter(move |a| !is_own(&a.name))
    }

    /// Encodes the file, without a seal.
    ///
    /// # Errors
    /// The format cannot represent it.
    pub fn encode(&self) -> Result<Vec<u8>, EncodeError> {
        let channels: Vec<Vec<Channel>> = self.parts.iter().map(channels).collect();
        let images = self.parts.iter().zip(&channels).map(|(part, channels)| {
            let image = Image {
                display: part.display,
                data: part.data,
                channels,
                attributes: &part.attributes,
                compression: part.compression,
                blocks: part.blocks,
            };
            (part.name.as_str(), image)
        });
        let images: Vec<(&str, Image)> = images.collect();
        let mut bytes = Vec::new();
        match (self.is_multi, &images[..]) {
            (false, [(_, image), ..]) => write(image, &mut bytes)?,
            _ => write_parts(&images, &mut bytes)?,
        };
        Ok(bytes)
    }
}

fn channels(part: &Part) -> Vec<Channel<'_>> {
    let channels = part.planes.iter().map(|plane| Channel {
        name: &plane.name,
        samples: plane.numbers.samples(),
    });
    channels.collect()
}
