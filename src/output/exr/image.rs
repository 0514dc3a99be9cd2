//! The content of an EXR file: channels with their values, and attributes.

use super::compression::Compression;
use crate::{
    film::Window,
    output::{Attribute, BlockShape},
};

/// Columns and rows of a tile.
pub(super) const TILE_SIDE: u32 = 64;

/// The content of an EXR file.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    /// The full frame.
    pub display: Window,
    /// The stored pixels.
    pub data: Window,
    /// In any order, with distinct names.
    pub channels: &'a [Channel<'a>],
    /// In any order, with distinct names, without the attributes that the format requires.
    pub attributes: &'a [Attribute],
    pub compression: Compression,
    pub blocks: BlockShape,
}

/// A channel: one number for each pixel of the data window.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'a> {
    /// `layer.channel`; readers from before 2013 accept at most 31 bytes.
    pub name: &'a str,
    pub samples: Samples<'a>,
}

/// The numbers of a channel, by their stored type.
#[derive(Clone, Copy, Debug)]
pub enum Samples<'a> {
    Half(ChannelData<'a, f32>),
    Float(ChannelData<'a, f32>),
    Uint(ChannelData<'a, u32>),
}

/// The values of a channel: that of pixel `i`, counted by rows from the top left, is `values[first + i * step]`.
#[derive(Clone, Copy, Debug)]
pub struct ChannelData<'a, T> {
    pub values: &'a [T],
    pub first: usize,
    pub step: usize,
}

impl<'a, T> ChannelData<'a, T> {
    /// Contiguous values.
    pub fn dense(values: &'a [T]) -> Self {
        let (first, step) = (0, 1);
        Self { values, first, step }
    }

    pub(super) fn holds(&self, pixels: usize) -> bool {
        let last = (pixels - 1)
            .checked_mul(self.step)
            .and_then(|n| n.checked_add(self.first));
        self.step > 0 && last.is_some_and(|last| last < self.values.len())
    }
}

impl Samples<'_> {
    pub(super) fn holds(&self, pixels: usize) -> bool {
        match self {
            Self::Half(p) | Self::Float(p) => p.holds(pixels),
            Self::Uint(p) => p.holds(pixels),
        }
    }

    pub(super) fn bytes_per_sample(&self) -> usize {
        match self {
            Self::Half(_) => 2,
            Self::Float(_) | Self::Uint(_) => 4,
        }
    }
}
