//! Blocks of lines: numbers to bytes, bytes reordered and deflated.

use half::{f16, slice::HalfFloatSliceExt};
use libdeflater::{CompressionLvl, Compressor};
use rayon::prelude::*;

use super::{
    codec::Codec,
    compression::Compression,
    image::{Channel, ChannelData, Image, Samples},
};
use crate::output::EncodeError;

/// OpenEXR's own default.
const LEVEL: i32 = 4;
/// The largest half.
const MAX_HALF: f32 = 65504.0;

/// Some lines, as the file stores them.
pub(super) struct Block {
    /// The first line, in the frame's coordinates.
    pub y: i32,
    pub packed: Vec<u8>,
    pub clamped: u64,
    pub nans: u64,
}

/// All blocks of `image` from the top down, each packed by some thread; `channels` are its channels, sorted.
///
/// # Errors
/// A codec gives up.
pub(super) fn encode(image: &Image, channels: &[Channel]) -> Result<Vec<Block>, EncodeError> {
    let lines = image.compression.lines_per_block();
    let codec = Codec::new(image, channels);
    (0..image.data.height().div_ceil(lines))
        .into_par_iter()
        .map_init(BlockPacker::new, |packer, block| {
            let first = block * lines;
            let end = (first + lines).min(image.data.height());
            packer.pack(image, channels, codec.as_ref(), first as usize..end as usize)
        })
        .collect()
}

/// The buffers for packing a block, kept from one to the next.
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

    /// Packs `lines`, counted from the top of the data window.
    fn pack(
        &mut self,
        image: &Image,
        channels: &[Channel],
        codec: Option<&Codec>,
        lines: std::ops::Range<usize>,
    ) -> Result<Block, EncodeError> {
        let count = lines.len();
        let width = image.data.width() as usize;
        let y = image.data.y0 + lines.start as i32;
        let (mut clamped, mut nans) = (0, 0);
        self.bytes.clear();
        for line in lines {
            for channel in channels {
                match channel.samples {
                    Samples::Half(plane) => {
                        let counts = self.put_halves(plane, line, width);
                        clamped += counts.0;
                        nans += counts.1;
                    }
                    Samples::Float(plane) => {
                        gather(plane, line, width, &mut self.row);
                        put(&mut self.bytes, self.row.iter().map(|v| v.to_le_bytes()));
                    }
                    Samples::Uint(plane) => {
                        gather(plane, line, width, &mut self.uint_row);
                        put(&mut self.bytes, self.uint_row.iter().map(|v| v.to_le_bytes()));
                    }
                }
            }
        }
        let packed = match codec {
            Some(codec) => codec.pack(&self.bytes, count)?,
            None => self.deflate(image.compression).to_vec(),
        };
        Ok(Block {
            y,
            packed,
            clamped,
            nans,
        })
    }

    /// Appends a line of halves; how many numbers were clamped and how many were none.
    fn put_halves(&mut self, plane: ChannelData<f32>, line: usize, width: usize) -> (u64, u64) {
        let (mut clamped, mut nans) = (0, 0);
        gather(plane, line, width, &mut self.row);
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

    /// The bytes as they are stored: deflated, or as they are where that does not gain.
    fn deflate(&mut self, compression: Compression) -> &[u8] {
        if compression == Compression::None {
            return &self.bytes;
        }
        reorder(&self.bytes, &mut self.parted, &mut self.reordered);
        // With no room for a block that is not smaller, the compressor gives such a block up.
        self.packed.resize(self.bytes.len() - 1, 0);
        match self.compressor.zlib_compress(&self.reordered, &mut self.packed) {
            Ok(size) => &self.packed[..size],
            Err(_) => &self.bytes,
        }
    }
}

/// Replaces `out` with a line of a channel.
fn gather<T: Copy>(plane: ChannelData<T>, line: usize, width: usize, out: &mut Vec<T>) {
    let values = &plane.values[plane.first + line * width * plane.step..];
    out.clear();
    match plane.step {
        1 => out.extend_from_slice(&values[..width]),
        step => out.extend((0..width).map(|i| values[i * step])),
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

/// All even bytes, then all odd ones, each as its difference to the one before: what deflate is good at. `parted` is for the
/// bytes without differences.
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
