//! EXR files as pictures: the first layer's colour channels, over its data window.

use std::io::Cursor;

use ::exr::{
    image::{AnyChannels, FlatSamples, Layer},
    meta::MetaData,
    prelude::{ReadChannels as _, ReadLayers as _, read},
};

use super::{error::ImageProblem, limits::check_size};
use crate::texture::Bitmap;

pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// More than any of the format's codecs packs into a byte: deflate stops at 1,032.
const MOST_GAIN: u64 = 4096;

pub(super) fn decode(bytes: &[u8]) -> Result<Bitmap, ImageProblem> {
    check_header(bytes)?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))?;
    picture(image.layer_data)
}

/// Refuses what the decoder would believe: it allocates for the size that the header claims.
fn check_header(bytes: &[u8]) -> Result<(), ImageProblem> {
    let length = bytes.len() as u64;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
    for header in &meta.headers {
        if header.deep {
            return Err(ImageProblem::broken("deep data is not supported"));
        }
        let [width, height] = [header.layer_size.0 as u64, header.layer_size.1 as u64];
        let bytes_per_pixel = header.channels.bytes_per_pixel as u64;
        check_size([width, height], 0)?;
        // The sides are bounded now, the number of channels by the header's length: no product overflows.
        let size = width * height * bytes_per_pixel;
        check_size([width, height], size)?;
        // A place in the table of blocks, a position and a size.
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
    Ok(())
}

fn picture(layer: Layer<AnyChannels<FlatSamples>>) -> Result<Bitmap, ImageProblem> {
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
    let size = [layer.size.0 as u32, layer.size.1 as u32];
    let mut values = vec![0.0; layer.size.0 * layer.size.1 * channels];
    for (first, plane) in planes.into_iter().enumerate() {
        let slots = values.iter_mut().skip(first).step_by(channels);
        match &plane.sample_data {
            FlatSamples::F16(v) => slots.zip(v).for_each(|(slot, v)| *slot = v.to_f32()),
            FlatSamples::F32(v) => slots.zip(v).for_each(|(slot, v)| *slot = *v),
            FlatSamples::U32(v) => slots.zip(v).for_each(|(slot, v)| *slot = *v as f32),
        }
    }
    Ok(Bitmap::from_floats(size, channels, values))
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
