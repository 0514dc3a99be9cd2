//! The codecs of the `exr` crate, applied to blocks.

use ::exr::{
    compression::Compression as Method,
    math::{RoundingMode, Vec2},
    meta::{
        BlockDescription,
        attribute::{ChannelDescription, IntegerBounds, LevelMode, LineOrder, SampleType, Text, TileDescription},
        header::Header,
    },
};

use super::{
    compression::Compression,
    image::{Channel, Image, Samples, TILE_SIDE},
};
use crate::output::{BlockShape, EncodeError};

/// The loss of DWAA: OpenEXR's default.
pub(super) const DWA_LEVEL: f32 = 45.0;

/// A codec of the `exr` crate for the blocks of an image.
pub(super) struct Codec {
    method: Method,
    header: Header,
}

impl Codec {
    /// The codec for an image with these channels, sorted; `None` if `blocks` has the method itself.
    pub fn new(image: &Image, channels: &[Channel]) -> Option<Self> {
        let method = match image.compression {
            Compression::None | Compression::Zips | Compression::Zip => return None,
            Compression::Rle => Method::RLE,
            Compression::Piz => Method::PIZ,
            Compression::Dwaa => Method::DWAA(Some(DWA_LEVEL)),
        };
        let describe = |channel: &Channel| ChannelDescription {
            name: Text::from_slice_unchecked(channel.name.as_bytes()),
            sample_type: match channel.samples {
                Samples::Half(_) => SampleType::F16,
                Samples::Float(_) => SampleType::F32,
                Samples::Uint(_) => SampleType::U32,
            },
            quantize_linearly: false,
            sampling: Vec2(1, 1),
        };
        let size = Vec2(image.data.width() as usize, image.data.height() as usize);
        let channels = channels.iter().map(describe).collect();
        let header = Header::new(Text::from_slice_unchecked(b""), size, channels);
        let order = LineOrder::Increasing;
        let blocks = match image.blocks {
            BlockShape::Lines => BlockDescription::ScanLines,
            BlockShape::Tiles => BlockDescription::Tiles(TileDescription {
                tile_size: Vec2(TILE_SIDE as usize, TILE_SIDE as usize),
                level_mode: LevelMode::Singular,
                rounding_mode: RoundingMode::Down,
            }),
        };
        Some(Self {
            method,
            header: header.with_encoding(method, blocks, order),
        })
    }

    /// Compresses little-endian numbers of this many columns and lines.
    ///
    /// # Errors
    /// The codec fails.
    pub fn pack(&self, bytes: &[u8], [columns, lines]: [usize; 2]) -> Result<Vec<u8>, EncodeError> {
        let section = IntegerBounds::from_dimensions(Vec2(columns, lines));
        let bytes = self.in_native_order(bytes, columns);
        let packed = self.method.compress_image_section_to_le(&self.header, bytes, section);
        packed.map_err(|e| EncodeError::Unfit(e.to_string()))
    }

    /// Converts little-endian numbers to the byte order of this machine, which the codec expects.
    fn in_native_order(&self, bytes: &[u8], width: usize) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        if cfg!(target_endian = "big") {
            let mut rest = &mut bytes[..];
            for channel in self.header.channels.list.iter().cycle() {
                let size = channel.sample_type.bytes_per_sample();
                if rest.len() < size * width {
                    break;
                }
                let (line, after) = rest.split_at_mut(size * width);
                line.chunks_exact_mut(size).for_each(<[u8]>::reverse);
                rest = after;
            }
        }
        bytes
    }
}
