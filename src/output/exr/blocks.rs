//! Encoding of blocks (lines or tiles): numbers become bytes, which are reordered and deflated.

use std::ops::Range;

use half::{f16, slice::HalfFloatSliceExt};
use libdeflater::{CompressionLvl, Compressor};
use rayon::prelude::*;

use super::{
    codec::Codec,
    compression::Compression,
    image::{Channel, ChannelData, Image, Samples, TILE_SIDE},
};
use crate::output::{BlockShape, EncodeError};

/// OpenEXR's own default.
const LEVEL: i32 = 4;
/// The largest half.
const MAX_HALF: f32 = 65504.0;

/// An encoded block.
pub(super) struct Block {
    pub place: BlockPlace,
    pub packed: Vec<u8>,
    pub clamped: u64,
    pub nans: u64,
}

/// The position of a block, as stored in the file.
#[derive(Clone, Copy, Debug)]
pub(super) enum BlockPlace {
    /// The first line, in the frame's coordinates.
    Line(i32),
    /// The column and the row of a tile, counted in tiles.
    Tile([i32; 2]),
}

impl BlockPlace {
    /// The bytes before the size of the block.
    pub fn bytes(self) -> Vec<u8> {
        match self {
            Self::Line(y) => y.to_le_bytes().to_vec(),
            // The last two are its level.
            Self::Tile([x, y]) => [x, y, 0, 0].map(i32::to_le_bytes).concat(),
        }
    }
}

/// The pixels of a block, counted from the top left of the data window.
struct Region {
    place: BlockPlace,
    columns: Range<usize>,
    lines: Range<usize>,
}

/// Encodes all blocks of `image` on all threads, in the order of rows; `channels` are its channels, sorted.
///
/// # Errors
/// A codec fails.
pub(super) fn encode(image: &Image, channels: &[Channel]) -> Result<Vec<Block>, EncodeError> {
    let codec = Codec::new(image, channels);
    regions(image)
        .into_par_iter()
        .map_init(BlockPacker::new, |packer, region| {
            packer.pack(image, channels, codec.as_ref(), region)
        })
        .collect()
}

fn regions(image: &Image) -> Vec<Region> {
    let (width, height) = (image.data.width(), image.data.height());
    let range = |index: u32, side: u32, end: u32| {
        let first = index * side;
        first as usize..first.saturating_add(side).min(end) as usize
    };
    match image.blocks {
        BlockShape::Lines => {
            let side = image.compression.lines_per_block();
            let region = |block: u32| Region {
                place: BlockPlace::Line(image.data.y0 + (block * side) as i32),
                columns: 0..width as usize,
                lines: range(block, side, height),
            };
            (0..height.div_ceil(side)).map(region).collect()
        }
        BlockShape::Tiles => {
            let columns = width.div_ceil(TILE_SIDE);
            let region = |block: u32| {
                let (x, y) = (block % columns, block / columns);
                Region {
                    place: BlockPlace::Tile([x as i32, y as i32]),
                    columns: range(x, TILE_SIDE, width),
                    lines: range(y, TILE_SIDE, height),
                }
            };
            (0..columns * height.div_ceil(TILE_SIDE)).map(region).collect()
        }
    }
}

/// The buffers for encoding a block, reused for the next.
struct BlockPacker {
    row: Vec<f32>,
    uint_row: Vec<u32>,
    halves: Vec<f16>,
    bytes: Vec<u8>,
    parted: Vec<u8>,
    reordered: Vec<u8>,
    packed: Vec<u8>,
    compressor: Compressor,
}

impl BlockPacker {
    fn new() -> Self {
        Self {
            row: Vec::new(),
            uint_row: Vec::new(),
            halves: Vec::new(),
            bytes: Vec::new(),
            parted: Vec::new(),
            reordered: Vec::new(),
            packed: Vec::new(),
            compressor: Compressor::new(CompressionLvl::new(LEVEL).unwrap_or_default()),
        }
    }

    /// Encodes the pixels of `region`.
    fn pack(
        &mut self,
        image: &Image,
        channels: &[Channel],
        codec: Option<&Codec>,
        region: Region,
    ) -> Result<Block, EncodeError> {
        let size = [region.columns.len(), region.lines.len()];
        let width = image.data.width() as usize;
        let (mut clamped, mut nans) = (0, 0);
        self.bytes.clear();
        for line in region.lines {
            let first = line * width + region.columns.start;
            let pixels = first..first + region.columns.len();
            for channel in channels {
                match channel.samples {
                    Samples::Half(plane) => {
                        let counts = self.put_halves(plane, pixels.clone());
                        clamped += counts.0;
                        nans += counts.1;
                    }
                    Samples::Float(plane) => {
                        gather(plane, pixels.clone(), &mut self.row);
                        put(&mut self.bytes, self.row.iter().map(|v| v.to_le_bytes()));
                    }
                    Samples::Uint(plane) => {
                        gather(plane, pixels.clone(), &mut self.uint_row);
                        put(&mut self.bytes, self.uint_row.iter().map(|v| v.to_le_bytes()));
                    }
                }
            }
        }
        let packed = match codec {
            Some(codec) => codec.pack(&self.bytes, size)?,
            None => self.deflate(image.compression).to_vec(),
        };
        Ok(Block {
            place: region.place,
            packed,
            clamped,
            nans,
        })
    }

    /// Appends a line of halves; returns the numbers of clamped values and of NaNs.
    fn put_halves(&mut self, plane: ChannelData<f32>, pixels: Range<usize>) -> (u64, u64) {
        let (mut clamped, mut nans) = (0, 0);
        let width = pixels.len();
        gather(plane, pixels, &mut self.row);
        for v in &mut self.row {
            clamped += u64::from(v.abs() > MAX_HALF);
            nans += u64::from(v.is_nan());
            *v = if v.is_nan() { 0.0 } else { v.clamp(-MAX_HALF, MAX_HALF) };
        }
        self.halves.resize(width, f16::ZERO);
        self.halves.convert_from_f32_slice(&self.row);
        put(&mut self.bytes, self.halves.iter().map(|v| v.to_le_bytes()));
        (clamped, nans)
    }

    /// The bytes to store: deflated, or unchanged if that is not smaller.
    fn deflate(&mut self, compression: Compression) -> &[u8] {
        if compression == Compression::None {
            return &self.bytes;
        }
        reorder(&self.bytes, &mut self.parted, &mut self.reordered);
        // The compressor fails if the result is not smaller than the input, because the buffer is one byte too short.
        self.packed.resize(self.bytes.len() - 1, 0);
        match self.compressor.zlib_compress(&self.reordered, &mut self.packed) {
            Ok(size) => &self.packed[..size],
            Err(_) => &self.bytes,
        }
    }
}

/// Copies some pixels of a channel to `out`, in place of its contents.
fn gather<T: Copy>(plane: ChannelData<T>, pixels: Range<usize>, out: &mut Vec<T>) {
    let values = &plane.values[plane.first + pixels.start * plane.step..];
    let count = pixels.len();
    out.clear();
    match plane.step {
        1 => out.extend_from_slice(&values[..count]),
        step => out.extend((0..count).map(|i| values[i * step])),
    }
}

/// Appends the bytes of numbers.
fn put<const N: usize>(bytes: &mut Vec<u8>, numbers: impl ExactSizeIterator<Item = [u8; N]>) {
    let start = bytes.len();
    bytes.resize(start + N * numbers.len(), 0);
    for (place, number) in bytes[start..].as_chunks_mut().0.iter_mut().zip(numbers) {
        *place = number;
    }
}

/// Reorders bytes for deflate: all even bytes, then all odd ones, each as the difference to the one before. `parted` is a buffer.
fn reorder(bytes: &[u8], parted: &mut Vec<u8>, out: &mut Vec<u8>) {
    parted.clear();
    parted.resize(bytes.len(), 0);
    let (even, odd) = parted.split_at_mut(bytes.len().div_ceil(2));
    let (pairs, last) = bytes.as_chunks::<2>();
    for ((pair, even), odd) in pairs.iter().zip(&mut *even).zip(odd) {
        [*even, *odd] = *pair;
    }
    if let [last] = last {
        even[pairs.len()] = *last;
    }
    out.clear();
    out.extend_from_slice(&parted[..1]);
    let pairs = parted[1..].iter().zip(&parted[..parted.len() - 1]);
    out.extend(pairs.map(|(byte, before)| byte.wrapping_sub(*before).wrapping_add(128)));
}
