//! Which samples a wave takes, and where in it each lies.

use std::ops::Range;

use super::Settings;
use crate::{
    accel::BatchLayout,
    film::Window,
    integrator::Path,
    math::{Divisor, Loop, Runner},
    sampler::{SampleKey, SampleKeys},
};

/// The samples of a wave: `together` of each pixel of `tile` from `first` on, a pixel's beside each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    tile: Window,
    first: u32,
    together: Divisor,
    width: Divisor,
    layout: BatchLayout,
}

impl Part {
    pub fn new(tile: Window, samples: &Range<u32>) -> Self {
        Self {
            tile,
            first: samples.start,
            together: Divisor::new(samples.len() as u32),
            width: Divisor::new(tile.x1 - tile.x0),
            layout: BatchLayout::Rows((tile.x1 - tile.x0) * samples.len() as u32),
        }
    }

    /// How the rays of the samples lie, those of paths that have ended aside.
    pub fn layout(&self) -> BatchLayout {
        self.layout
    }

    /// The address of the sample in `slot`.
    #[inline]
    pub fn key(&self, settings: &Settings, slot: u32) -> SampleKey {
        let (pixel, sample) = self.place(slot);
        SampleKey {
            seed: settings.seed,
            frame: settings.frame,
            pixel,
            sample,
        }
    }

    /// The addresses of the samples of the `chosen` paths, in place of what `keys` held.
    pub fn keys(&self, on: impl Runner, settings: &Settings, chosen: &[u32], paths: &[Path], keys: &mut SampleKeys) {
        keys.start(settings.seed, settings.frame);
        keys.samples.extend(chosen.iter().map(|&i| paths[i as usize].slot));
        keys.columns.resize(chosen.len(), 0);
        keys.rows.resize(chosen.len(), 0);
        on.run(Addresses {
            part: self,
            columns: &mut keys.columns,
            rows: &mut keys.rows,
            samples: &mut keys.samples,
        });
    }

    /// The pixel of the sample in `slot`, and its number.
    #[inline(always)]
    fn place(&self, slot: u32) -> ([u32; 2], u32) {
        let (pixel, sample) = self.together.divide(slot);
        let (row, column) = self.width.divide(pixel);
        ([self.tile.x0 + column, self.tile.y0 + row], self.first + sample)
    }
}

/// Makes addresses of slots.
struct Addresses<'a> {
    part: &'a Part,
    columns: &'a mut [u32],
    rows: &'a mut [u32],
    /// The slots so far.
    samples: &'a mut [u32],
}

impl Loop for Addresses<'_> {
    #[inline(always)]
    fn run(self) {
        for ((column, row), sample) in self.columns.iter_mut().zip(self.rows).zip(self.samples) {
            ([*column, *row], *sample) = self.part.place(*sample);
        }
    }
}
