//! The samples of a wave, and their order.

use super::{Settings, schedule::BlockSpec};
use crate::{
    accel::BatchLayout,
    film::Window,
    integrator::PathState,
    math::{Dispatch, Divisor, VectorLoop},
    sampler::{SampleKey, SampleKeys},
};

/// The samples of a wave: a range of samples of each pixel of a tile, where the samples of a pixel are adjacent, or those of a
/// list.
#[derive(Clone, Copy, Debug)]
pub(super) enum SampleBlock<'a> {
    Tile(TileBlock),
    Listed(&'a SampleKeys),
}

/// A range of samples of each pixel of a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileBlock {
    tile: Window,
    first_sample: u32,
    samples_per_pixel: Divisor,
    width: Divisor,
    layout: BatchLayout,
    /// The number of samples.
    count: u32,
}

impl SampleBlock<'_> {
    pub fn new(spec: &BlockSpec) -> Self {
        Self::Tile(TileBlock {
            tile: spec.tile,
            first_sample: spec.samples.start,
            samples_per_pixel: Divisor::new(spec.samples.len() as u32),
            width: Divisor::new(spec.tile.width()),
            layout: BatchLayout::Rows(spec.tile.width() * spec.samples.len() as u32),
            count: (spec.tile.area() * spec.samples.len()) as u32,
        })
    }

    /// The layout of the samples' rays; rays of ended paths are missing.
    pub fn layout(&self) -> BatchLayout {
        match self {
            Self::Tile(block) => block.layout,
            Self::Listed(_) => BatchLayout::Unordered,
        }
    }

    /// The key of the sample with this index in the wave. Those beyond the samples, of which shadow catchers have two radiances,
    /// have the keys of the first ones again.
    #[inline]
    pub fn key(&self, settings: &Settings, index: u32) -> SampleKey {
        let block = match self {
            Self::Tile(block) => block,
            Self::Listed(keys) => return keys.get(within(index, keys.len() as u32) as usize),
        };
        let (pixel, sample) = block.pixel_and_sample(within(index, block.count));
        SampleKey {
            seed: settings.seed,
            frame: settings.noise_frame,
            pixel,
            sample,
        }
    }

    /// Sets `keys` to those of the samples of the paths with these indices.
    pub fn keys(
        &self,
        on: impl Dispatch,
        settings: &Settings,
        indices: &[u32],
        paths: &[PathState],
        keys: &mut SampleKeys,
    ) {
        keys.start(settings.seed, settings.noise_frame);
        let block = match self {
            Self::Tile(block) => block,
            Self::Listed(all) => {
                let count = all.len() as u32;
                let listed = indices
                    .iter()
                    .map(|&i| within(paths[i as usize].sample, count) as usize);
                keys.columns.extend(listed.clone().map(|i| all.columns[i]));
                keys.rows.extend(listed.clone().map(|i| all.rows[i]));
                keys.samples.extend(listed.map(|i| all.samples[i]));
                return;
            }
        };
        let own = |&i: &u32| within(paths[i as usize].sample, block.count);
        keys.samples.extend(indices.iter().map(own));
        keys.columns.resize(indices.len(), 0);
        keys.rows.resize(indices.len(), 0);
        on.dispatch(FillKeys {
            block,
            columns: &mut keys.columns,
            rows: &mut keys.rows,
            samples: &mut keys.samples,
        });
    }
}

/// The index of a sample among `count`, which begin again after the last.
#[inline(always)]
fn within(index: u32, count: u32) -> u32 {
    index.min(index.wrapping_sub(count))
}

impl TileBlock {
    /// The pixel and the number of the sample with this index. Columns and rows of overscan are modulo 2^32.
    #[inline(always)]
    fn pixel_and_sample(&self, index: u32) -> ([u32; 2], u32) {
        let (pixel, sample) = self.samples_per_pixel.divide(index);
        let (row, column) = self.width.divide(pixel);
        let from = |start: i32, n: u32| (start as u32).wrapping_add(n);
        (
            [from(self.tile.x0, column), from(self.tile.y0, row)],
            self.first_sample + sample,
        )
    }
}

/// Computes keys from indices in the wave.
struct FillKeys<'a> {
    block: &'a TileBlock,
    columns: &'a mut [u32],
    rows: &'a mut [u32],
    /// In: indices in the wave; out: numbers of samples.
    samples: &'a mut [u32],
}

impl VectorLoop for FillKeys<'_> {
    #[inline(always)]
    fn run(self) {
        for ((column, row), sample) in self.columns.iter_mut().zip(self.rows).zip(self.samples) {
            ([*column, *row], *sample) = self.block.pixel_and_sample(*sample);
        }
    }
}
