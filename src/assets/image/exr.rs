//! EXR files as pictures: the first layer's colour channels, over the display window.
//!
//! Pixels of the display window that lie outside of the layer's data window are black, and transparent where the layer
//! has alpha. Source: "The OpenEXR File Layout", openexr.com, section "Display window and data window".

use std::{io::Cursor, ops::Range};

use ::exr::{
    image::{AnyChannels, FlatSamples, Layer},
    meta::{MetaData, attribute::IntegerBounds, header::Header},
    prelude::{ReadChannels as _, ReadLayers as _, read},
};

use super::{
    error::ImageProblem,
    limits::{check_size, shrunk, with_levels},
};
use crate::{
    assets::{MemoryBudget, MemoryKind},
    texture::Bitmap,
};

pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// An upper bound of the compression ratio of all codecs; that of deflate is 1,032.
const MOST_GAIN: u64 = 4096;

/// The bytes of memory for the picture, by the header: at most four channels of floats.
pub(super) fn memory(bytes: &[u8]) -> Result<u64, ImageProblem> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
    Ok(shown_bytes(&meta))
}

/// The same; 0 for a file without a layer.
fn shown_bytes(meta: &MetaData) -> u64 {
    let area = |h: &Header| h.shared_attributes.display_window.size.area() as u64;
    meta.headers.first().map_or(0, area).saturating_mul(16)
}

/// Decodes the bytes of a file. The memory is that of a picture whose size will be halved `halvings` times.
pub(super) fn decode(bytes: &[u8], halvings: u32, memory: &MemoryBudget) -> Result<Bitmap, ImageProblem> {
    let kept = check_header(bytes, memory)?;
    memory.take(MemoryKind::Images, with_levels(shrunk(kept, halvings)))?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))?;
    picture(image.layer_data, image.attributes.display_window)
}

/// Refuses absurd sizes, for which the decoder would allocate memory. Returns the bytes of the picture.
fn check_header(bytes: &[u8], memory: &MemoryBudget) -> Result<u64, ImageProblem> {
    let length = bytes.len() as u64;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
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
        memory.check(MemoryKind::Images, size.saturating_add(picture))?;
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

/// The part of `layer` inside of `window`.
fn picture(layer: Layer<AnyChannels<FlatSamples>>, window: IntegerBounds) -> Result<Bitmap, ImageProblem> {
    let list = &layer.channel_data.list;
    let find = |name: &str| {
        let exact = list.iter().find(|c| c.name.eq_case_insensitive(name));
        exact.or_else(|| {
            list.iter()
                .find(|c| last_part(&c.name.to_string()).eq_ignore_ascii_case(name))
        })
    };
    let mut planes = match (find("R"), find("G"), find("B"), find("Y")) {
        (Some(r), Some(g), Some(b), _) => vec![r, g, b],
        (_, _, _, Some(y)) => vec![y],
        _ if list.len() == 1 => vec![&list[0]],
        _ => return Err(ImageProblem::broken("no channels R, G, B or Y")),
    };
    if planes.len() == 3 {
        planes.extend(find("A"));
    }
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
    Ok(Bitmap::from_floats(
        [window.size.0 as u32, window.size.1 as u32],
        channels,
        values,
    ))
}

/// The intersection of `first..first + size` with `0..window`.
fn overlap(first: i64, size: usize, window: usize) -> Range<usize> {
    let clamp = |at: i64| at.clamp(0, window as i64) as usize;
    clamp(first)..clamp(first + size as i64)
}

/// `R` of `layer.R`.
fn last_part(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

impl From<::exr::error::Error> for ImageProblem {
    fn from(error: ::exr::error::Error) -> Self {
        Self::broken(error)
    }
}
