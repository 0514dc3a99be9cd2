//! EXR files as pictures: the colour channels of the layer that is light, over the display window.
//!
//! Pixels of the display window that lie outside of the layer's data window are black, and transparent where the layer
//! has alpha. Source: "The OpenEXR File Layout", openexr.com, section "Display window and data window".

mod layers;
pub mod passes;
mod primaries;

use std::{io::Cursor, ops::Range};

use ::exr::{
    image::{AnyChannels, FlatSamples, Layer},
    meta::{
        MetaData,
        attribute::IntegerBounds,
        header::{Header, ImageAttributes},
    },
    prelude::{ReadChannels as _, ReadLayers as _, read},
};

use layers::ShownChannels;
use passes::ImagePass;

use super::{
    error::ImageProblem,
    limits::{check_size, shrunk, with_levels},
};
use crate::{
    assets::{MemoryBudget, MemoryKind},
    texture::Bitmap,
};

pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The place of the pixels of a file in its picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureWindow {
    /// The first column and the first row of the file, which may be outside of the picture.
    pub first: [i64; 2],
    /// The columns and rows of the picture.
    pub display: [u32; 2],
}

/// An upper bound of the compression ratio of all codecs; that of deflate is 1,032.
const MOST_GAIN: u64 = 4096;

/// The bytes of memory for all levels of the picture after some halvings, by the header: at most four channels of floats.
pub(super) fn memory(bytes: &[u8], halvings: u32) -> Result<u64, ImageProblem> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
    Ok(with_levels(shrunk(shown_bytes(&meta), halvings), 4))
}

/// The bytes of the picture alone; 0 for a file without a layer.
fn shown_bytes(meta: &MetaData) -> u64 {
    let area = |h: &Header| h.shared_attributes.display_window.size.area() as u64;
    meta.headers.first().map_or(0, area).saturating_mul(16)
}

/// Decodes the bytes of a file. The memory is that of a picture whose size will be halved `halvings` times.
pub(super) fn decode(bytes: &[u8], halvings: u32, memory: &MemoryBudget) -> Result<Bitmap, ImageProblem> {
    let kept = check_header(bytes, memory)?;
    memory.take(MemoryKind::Images, with_levels(shrunk(kept, halvings), 4))?;
    let (layer, shown, attributes) = chosen(bytes)?;
    Ok(Bitmap {
        primaries: primaries::named(&attributes, &layer.attributes),
        ..picture(layer, &shown.channels, attributes.display_window)
    })
}

/// Decodes the pixels of a file over the data window of its picture, and returns the place of that window.
pub(super) fn decode_data(bytes: &[u8], memory: &MemoryBudget) -> Result<(Bitmap, PictureWindow), ImageProblem> {
    check_header(bytes, memory)?;
    let (layer, shown, attributes) = chosen(bytes)?;
    let data = IntegerBounds {
        position: layer.attributes.layer_position,
        size: layer.size,
    };
    memory.take(MemoryKind::Images, data.size.area() as u64 * 16)?;
    let display = attributes.display_window;
    let first = |data: i32, display: i32| i64::from(data) - i64::from(display);
    let window = PictureWindow {
        first: [
            first(data.position.0, display.position.0),
            first(data.position.1, display.position.1),
        ],
        display: [display.size.0 as u32, display.size.1 as u32],
    };
    Ok((picture(layer, &shown.channels, data), window))
}

/// The layer with the picture of a file, the channels of that, and the attributes of the file.
fn chosen(bytes: &[u8]) -> Result<(Layer<AnyChannels<FlatSamples>>, ShownChannels, ImageAttributes), ImageProblem> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
    let shown = layers::choose(&meta.headers)?;
    let pictures = read().no_deep_data().largest_resolution_level().all_channels();
    let (layer, attributes) = if meta.headers.len() == 1 {
        let image = pictures
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))?;
        (image.layer_data, image.attributes)
    } else {
        let image = pictures
            .all_layers()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))?;
        let layer = image.layer_data.into_iter().nth(shown.part);
        (
            layer.ok_or_else(|| ImageProblem::broken("a part is missing"))?,
            image.attributes,
        )
    };
    Ok((layer, shown, attributes))
}

/// All passes of a file, by their names.
pub(super) fn passes(bytes: &[u8], memory: &MemoryBudget) -> Result<Vec<ImagePass>, ImageProblem> {
    check_header(bytes, memory)?;
    let parts = read().no_deep_data().largest_resolution_level().all_channels();
    let image = parts.all_layers().all_attributes().from_buffered(Cursor::new(bytes))?;
    Ok(passes::of_parts(image.layer_data))
}

/// Refuses absurd sizes, for which the decoder would allocate memory. Returns the bytes of the picture.
fn check_header(bytes: &[u8], memory: &MemoryBudget) -> Result<u64, ImageProblem> {
    let length = bytes.len() as u64;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
    let mut all: u64 = 0;
    for header in &meta.headers {
        if header.deep {
            return Err(ImageProblem::broken("deep data is not supported"));
        }
        let [width, height] = [header.layer_size.0 as u64, header.layer_size.1 as u64];
        let bytes_per_pixel = header.channels.bytes_per_pixel as u64;
        check_size([width, height], 0)?;
        let shown = header.shared_attributes.display_window.size;
        let [columns, rows] = [shown.0 as u64, shown.1 as u64];
        // The picture in memory: at most four channels of floats.
        let picture = columns.saturating_mul(rows).saturating_mul(16);
        check_size([columns, rows], picture)?;
        // No overflow: the sides are checked, and the header's length bounds the number of channels.
        let size = width * height * bytes_per_pixel;
        check_size([width, height], size)?;
        // All parts are read at once.
        all = all.saturating_add(size);
        memory.check(MemoryKind::Images, all.saturating_add(picture))?;
        // An entry in the table of blocks, a position and a size.
        let blocks = header.chunk_count as u64;
        if blocks.saturating_mul(16) > length || size / MOST_GAIN > length {
            return Err(ImageProblem::broken(format!(
                "{length} bytes cannot hold {width} x {height} pixels"
            )));
        }
        if header
            .channels
            .list
            .iter()
            .any(|c| c.sampling.0 != 1 || c.sampling.1 != 1)
        {
            return Err(ImageProblem::broken("subsampled channels are not supported"));
        }
    }
    Ok(shown_bytes(&meta))
}

/// The part of these channels of `layer` inside of `window`.
fn picture(layer: Layer<AnyChannels<FlatSamples>>, shown: &[usize], window: IntegerBounds) -> Bitmap {
    let planes: Vec<_> = shown.iter().map(|i| &layer.channel_data.list[*i]).collect();
    let channels = planes.len();
    let first = [
        i64::from(layer.attributes.layer_position.0) - i64::from(window.position.0),
        i64::from(layer.attributes.layer_position.1) - i64::from(window.position.1),
    ];
    let mut values = vec![0.0; window.size.area() * channels];
    for (channel, plane) in planes.into_iter().enumerate() {
        let at = |i: usize| match &plane.sample_data {
            FlatSamples::F16(v) => v[i].to_f32(),
            FlatSamples::F32(v) => v[i],
            FlatSamples::U32(v) => v[i] as f32,
        };
        let columns = overlap(first[0], layer.size.0, window.size.0);
        for row in overlap(first[1], layer.size.1, window.size.1) {
            let source = (row as i64 - first[1]) as usize * layer.size.0;
            for column in columns.clone() {
                let value = at(source + (column as i64 - first[0]) as usize);
                values[(row * window.size.0 + column) * channels + channel] = value;
            }
        }
    }
    Bitmap::from_floats([window.size.0 as u32, window.size.1 as u32], channels, values)
}

/// The intersection of `first..first + size` with `0..window`.
fn overlap(first: i64, size: usize, window: usize) -> Range<usize> {
    let clamp = |at: i64| at.clamp(0, window as i64) as usize;
    clamp(first)..clamp(first + size as i64)
}

impl From<::exr::error::Error> for ImageProblem {
    fn from(error: ::exr::error::Error) -> Self {
        Self::broken(error)
    }
}
